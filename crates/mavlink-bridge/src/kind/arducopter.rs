//! ArduCopter in GUIDED (<https://ardupilot.org/dev/docs/copter-commands-in-guided-mode.html>): a stream of velocities.
//!
//! Any of x, y, z ignored makes it ignore the whole position, so altitude is held by the vertical velocity. It stops 3
//! s after the last velocity. Other frames than LOCAL_NED and other masks stop it.

use super::commands::{arm, command_long, set_mode};
use super::{Launch, Parameters, Seen, Situation, VehicleLimits};
use crate::dialect::{MavCmd, MavFrame, Message, PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA};
use crate::setpoint::finite_f32;
use crate::telemetry::boot_ms;
use crate::{SetpointError, Target};
use flight_model::Setpoint;

/// Numbers of modes (`ArduCopter/mode.h`).
pub(super) const GUIDED: u32 = 4;
const RTL: u32 = 6;
const LAND: u32 = 9;
/// Holds the place without a pilot. LOITER would take its climb from a throttle stick that may not be there.
const BRAKE: u32 = 17;

/// Loiter, return, land.
pub(super) const END_MODES: [u32; 3] = [BRAKE, RTL, LAND];

pub(super) const LIMIT_PARAMETERS: [&str; 8] = [
    "WPNAV_SPEED",
    "WPNAV_SPEED_UP",
    "WPNAV_SPEED_DN",
    "ANGLE_MAX",
    // From 4.7 on, in m/s and degrees.
    "WP_SPD",
    "WP_SPD_UP",
    "WP_SPD_DN",
    "ATC_ANGLE_MAX",
];

/// vx, vy and vz count.
const VELOCITY_MASK: u16 = 0x0DC7;
/// Vertical velocity for each metre of altitude that is missing, 1/s.
const ALTITUDE_GAIN_PER_S: f64 = 1.0;
/// A take-off is over at this share of its height.
const TAKEN_OFF_SHARE: f64 = 0.9;

const MODES: [(u32, &str); 26] = [
    (0, "STABILIZE"),
    (1, "ACRO"),
    (2, "ALT_HOLD"),
    (3, "AUTO"),
    (4, "GUIDED"),
    (5, "LOITER"),
    (6, "RTL"),
    (7, "CIRCLE"),
    (9, "LAND"),
    (11, "DRIFT"),
    (13, "SPORT"),
    (14, "FLIP"),
    (15, "AUTOTUNE"),
    (16, "POSHOLD"),
    (17, "BRAKE"),
    (18, "THROW"),
    (19, "AVOID_ADSB"),
    (20, "GUIDED_NOGPS"),
    (21, "SMART_RTL"),
    (22, "FLOWHOLD"),
    (23, "FOLLOW"),
    (24, "ZIGZAG"),
    (25, "SYSTEMID"),
    (26, "AUTOROTATE"),
    (27, "AUTO_RTL"),
    (28, "TURTLE"),
];

pub(super) fn mode_name(custom_mode: u32) -> Option<&'static str> {
    MODES.iter().find(|(number, _)| *number == custom_mode).map(|(_, name)| *name)
}

/// GUIDED on the ground, armed, then NAV_TAKEOFF; a second one on the way up is refused, and not sent.
pub(super) fn launch(target: Target, seen: &Seen, height_m: f64) -> Launch {
    if seen.custom_mode != GUIDED {
        return Launch::Send(set_mode(target, GUIDED));
    }
    if !seen.armed {
        return Launch::Send(arm(target));
    }
    if seen.height_m >= TAKEN_OFF_SHARE * height_m {
        return Launch::Flying;
    }
    let climbs = seen.climb_mps > 0.3 || !seen.on_ground && seen.height_m > 1.0;
    if climbs {
        return Launch::Wait;
    }
    let params = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, height_m as f32];
    Launch::Send(command_long(target, MavCmd::MAV_CMD_NAV_TAKEOFF, params))
}

pub(super) fn setpoint(
    target: Target,
    setpoint: &Setpoint,
    situation: &Situation<'_>,
) -> Result<Vec<Message>, SetpointError> {
    let (sin, cos) = libm::sincos(setpoint.course_rad);
    let limits = situation.dynamics.limits;
    let climb_mps = (ALTITUDE_GAIN_PER_S * (setpoint.altitude_m - situation.state.altitude_m))
        .clamp(limits.climb_min_mps.min(0.0), limits.climb_max_mps.max(0.0));
    Ok(vec![Message::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms: boot_ms(situation.now),
        vx: finite_f32(setpoint.speed_mps * cos)?,
        vy: finite_f32(setpoint.speed_mps * sin)?,
        vz: finite_f32(-climb_mps)?,
        type_mask: PositionTargetTypemask::from_bits_retain(VELOCITY_MASK),
        target_system: target.system_id,
        target_component: target.component_id,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
    })])
}

pub(super) fn limits(parameters: Parameters<'_>) -> VehicleLimits {
    let metres = |newer: &str, older_cm: &str| parameters(newer).or_else(|| parameters(older_cm).map(|cm| 0.01 * cm));
    VehicleLimits {
        speed_min_mps: None,
        speed_max_mps: metres("WP_SPD", "WPNAV_SPEED"),
        speeds_are_air: false,
        bank_max_rad: metres("ATC_ANGLE_MAX", "ANGLE_MAX").map(f64::to_radians),
        climb_max_mps: metres("WP_SPD_UP", "WPNAV_SPEED_UP"),
        sink_max_mps: metres("WP_SPD_DN", "WPNAV_SPEED_DN"),
        takeoff_height_m: None,
    }
}
