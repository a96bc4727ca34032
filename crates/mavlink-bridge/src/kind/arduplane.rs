//! ArduPlane in GUIDED (<https://ardupilot.org/plane/docs/guided-mode.html>): three commands for speed, altitude and
//! course.
//!
//! It keeps the last of each for ever, and answers each. Course is over ground, speed is equivalent airspeed, altitude
//! is sent above mean sea level. Param 3 of the course is the greatest lateral acceleration: from the model's own
//! limit, so that the plane turns as the look-ahead thinks it does. Param 3 of the altitude is not used: ArduPlane 4.6
//! and later climb at a thirtieth of it.

use super::commands::{arm, command_int, set_mode};
use super::speed_demand::{gentle_rate_mps2, told_rate_mps2};
use super::{Launch, Parameters, Seen, Situation, VehicleLimits, airspeed_mps, amsl_m};
use crate::dialect::{MavCmd, MavFrame, Message};
use crate::setpoint::{course_deg, finite_f32, flyable_altitude_m};
use crate::{SetpointError, Target};
use flight_model::{Dynamics, Setpoint};

/// Numbers of modes (`ArduPlane/mode.h`).
pub(super) const GUIDED: u32 = 15;
const RTL: u32 = 11;
const LOITER: u32 = 12;
const TAKEOFF: u32 = 13;

/// Loiter, return, land. To land, RTL needs a landing sequence on board, or RTL_AUTOLAND; without, it circles above
/// home.
pub(super) const END_MODES: [u32; 3] = [LOITER, RTL, RTL];

/// What is told of a plane that was to land.
pub(super) const LAND_NOTE: &str =
    "it lands only if RTL_AUTOLAND is set and a landing sequence is on board; else it circles above its home";

/// Names before 4.5 stand behind the present ones.
pub(super) const LIMIT_PARAMETERS: [&str; 9] = [
    "AIRSPEED_MIN",
    "AIRSPEED_MAX",
    "ROLL_LIMIT_DEG",
    "TECS_CLMB_MAX",
    "TECS_SINK_MAX",
    "TKOFF_ALT",
    "ARSPD_FBW_MIN",
    "ARSPD_FBW_MAX",
    "LIM_ROLL_CD",
];

/// A take-off is over at this share of its height.
const TAKEN_OFF_SHARE: f64 = 0.8;
/// p3 of a course below this makes hardly any turn, m/s2.
const LATERAL_ACCELERATION_MIN_MPS2: f32 = 0.05;

/// A plane that is further than this from a wanted speed may have another demand than it was told, m/s.
const DEMAND_KNOWN_WITHIN_MPS: f64 = 0.5;

const MODES: [&str; 27] = [
    "MANUAL",
    "CIRCLE",
    "STABILIZE",
    "TRAINING",
    "ACRO",
    "FBWA",
    "FBWB",
    "CRUISE",
    "AUTOTUNE",
    "LAND",
    "AUTO",
    "RTL",
    "LOITER",
    "TAKEOFF",
    "AVOID_ADSB",
    "GUIDED",
    "INITIALISING",
    "QSTABILIZE",
    "QHOVER",
    "QLOITER",
    "QLAND",
    "QRTL",
    "QAUTOTUNE",
    "QACRO",
    "THERMAL",
    "LOITER_TO_QLAND",
    "AUTOLAND",
];

pub(super) fn mode_name(custom_mode: u32) -> Option<&'static str> {
    MODES.get(usize::try_from(custom_mode).ok()?).copied()
}

/// TAKEOFF mode climbs by itself once it is armed; GUIDED takes over in the air.
pub(super) fn launch(target: Target, seen: &Seen, height_m: f64) -> Launch {
    if !seen.armed {
        return match (seen.on_ground, seen.custom_mode) {
            (true, TAKEOFF) | (false, _) => Launch::Send(arm(target)),
            (true, _) => Launch::Send(set_mode(target, TAKEOFF)),
        };
    }
    if seen.custom_mode == GUIDED && !seen.on_ground {
        return Launch::Flying;
    }
    if seen.on_ground {
        return if seen.custom_mode == TAKEOFF { Launch::Wait } else { Launch::Send(set_mode(target, TAKEOFF)) };
    }
    if seen.custom_mode == TAKEOFF && seen.height_m < TAKEN_OFF_SHARE * height_m {
        return Launch::Wait;
    }
    Launch::Send(set_mode(target, GUIDED))
}

pub(super) fn setpoint(
    target: Target,
    setpoint: &Setpoint,
    situation: &Situation<'_>,
) -> Result<Vec<Message>, SetpointError> {
    let Dynamics { limits, response, .. } = situation.dynamics;
    let speed_mps = finite_f32(airspeed_mps(setpoint, situation))?;
    let acceleration_mps2 = finite_f32(demand_acceleration_mps2(setpoint, situation, response.acceleration_max_mps2))?;
    let altitude_m = flyable_altitude_m(finite_f32(amsl_m(setpoint.altitude_m, situation))?);
    let course_deg = course_deg(setpoint.course_rad)?;
    let lateral_mps2 = finite_f32(limits.lateral_acceleration_max_mps2())?.max(LATERAL_ACCELERATION_MIN_MPS2);
    let command = |command, params, z| command_int(target, command, MavFrame::MAV_FRAME_GLOBAL, params, (0, 0, z));
    Ok(vec![
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, [0.0, course_deg, lateral_mps2, 0.0], 0.0),
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED, [0.0, speed_mps, acceleration_mps2, 0.0], 0.0),
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE, [0.0; 4], altitude_m),
    ])
}

/// How fast the autopilot is told to change its demand of speed, m/s2; zero: at once, where the model has no limit.
fn demand_acceleration_mps2(setpoint: &Setpoint, situation: &Situation<'_>, acceleration_max_mps2: f64) -> f64 {
    let Some(demand_mps) = situation.speed_demand_mps.filter(|_| acceleration_max_mps2.is_finite()) else {
        return if acceleration_max_mps2.is_finite() { acceleration_max_mps2 } else { 0.0 };
    };
    // In another mode it may have had another demand than it was told.
    let missing_mps = (setpoint.speed_mps - situation.state.speed_mps).abs() - DEMAND_KNOWN_WITHIN_MPS;
    let change_mps = airspeed_mps(setpoint, situation) - demand_mps;
    let rate_mps2 = gentle_rate_mps2(change_mps.abs().max(missing_mps), acceleration_max_mps2);
    told_rate_mps2(rate_mps2, change_mps > 0.0)
}

pub(super) fn limits(parameters: Parameters<'_>) -> VehicleLimits {
    let either = |name: &str, older: &str| parameters(name).or_else(|| parameters(older));
    VehicleLimits {
        speed_min_mps: either("AIRSPEED_MIN", "ARSPD_FBW_MIN"),
        speed_max_mps: either("AIRSPEED_MAX", "ARSPD_FBW_MAX"),
        speeds_are_air: true,
        bank_max_rad: parameters("ROLL_LIMIT_DEG")
            .or_else(|| parameters("LIM_ROLL_CD").map(|cdeg| 0.01 * cdeg))
            .map(f64::to_radians),
        climb_max_mps: parameters("TECS_CLMB_MAX"),
        sink_max_mps: parameters("TECS_SINK_MAX"),
        takeoff_height_m: parameters("TKOFF_ALT").filter(|height_m| *height_m > 0.0),
    }
}
