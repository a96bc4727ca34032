//! PX4 on a fixed wing. From 1.18 on it has Guided Course, which takes speed, course and altitude by commands and keeps
//! the last of each. Before, the way that every version follows is Hold with a place far ahead, told again and again.
//! Its Offboard takes velocities and does not follow them.

use super::commands::{command_int, command_long, set_px4_mode};
use super::px4_multicopter::{HOLD, TAKEOFF, take_off};
use super::{Launch, Parameters, Seen, Situation, SoftwareVersion, VehicleLimits, ahead, airspeed_mps, amsl_m};
use crate::dialect::{MavCmd, MavFrame, Message};
use crate::setpoint::{course_deg, finite_f32};
use crate::{SetpointError, Target};
use flight_model::Setpoint;
use std::time::Duration;

/// Guided Course (`px4_custom_mode.h`).
const GUIDED_COURSE: u32 = 4 << 16 | 19 << 24;
/// The first version that has it.
const GUIDED_COURSE_SINCE: SoftwareVersion = SoftwareVersion { major: 1, minor: 18, patch: 0 };

pub(super) const LIMIT_PARAMETERS: [&str; 6] =
    ["FW_AIRSPD_MIN", "FW_AIRSPD_MAX", "FW_R_LIM", "FW_T_CLMB_R_SP", "FW_T_SINK_R_SP", "MIS_TAKEOFF_ALT"];

/// How far ahead the place is that it flies to in Hold, m.
const CARROT_M: f64 = 3_000.0;
/// A take-off is over at this share of its height.
const TAKEN_OFF_SHARE: f64 = 0.8;

/// A version that is not known is taken for an old one: every version follows the old way.
fn has_guided_course(version: Option<SoftwareVersion>) -> bool {
    version.is_some_and(|version| version >= GUIDED_COURSE_SINCE)
}

pub(super) fn flying_mode(version: Option<SoftwareVersion>) -> u32 {
    if has_guided_course(version) { GUIDED_COURSE } else { HOLD }
}

pub(super) fn repeat_every(version: Option<SoftwareVersion>) -> Option<Duration> {
    (!has_guided_course(version)).then_some(Duration::from_millis(500))
}

pub(super) fn launch(target: Target, seen: &Seen, height_m: f64, version: Option<SoftwareVersion>) -> Launch {
    let flying_mode = flying_mode(version);
    if !seen.armed || seen.on_ground {
        return take_off(target, seen);
    }
    if seen.custom_mode == flying_mode {
        return Launch::Flying;
    }
    if seen.custom_mode == TAKEOFF && seen.height_m < TAKEN_OFF_SHARE * height_m {
        return Launch::Wait;
    }
    Launch::Send(set_px4_mode(target, flying_mode))
}

pub(super) fn setpoint(
    target: Target,
    setpoint: &Setpoint,
    situation: &Situation<'_>,
    version: Option<SoftwareVersion>,
) -> Result<Vec<Message>, SetpointError> {
    let speed_mps = finite_f32(airspeed_mps(setpoint, situation))?;
    let altitude_m = finite_f32(amsl_m(setpoint.altitude_m, situation))?;
    let course_deg = course_deg(setpoint.course_rad)?;
    if !has_guided_course(version) {
        let place = ahead(situation, setpoint.course_rad, CARROT_M);
        let (x, y) = ((place.latitude_deg * 1e7).round() as i32, (place.longitude_deg * 1e7).round() as i32);
        // p2: it goes into Hold by itself. p4, the yaw, is left to the autopilot. z is above mean sea level whatever
        // the frame.
        let params = [speed_mps, 1.0, 0.0, f32::NAN];
        let frame = MavFrame::MAV_FRAME_GLOBAL;
        return Ok(vec![command_int(target, MavCmd::MAV_CMD_DO_REPOSITION, frame, params, (x, y, altitude_m))]);
    }
    let command = |command, [p1, p2, p3]: [f32; 3]| command_long(target, command, [p1, p2, p3, 0.0, 0.0, 0.0, 0.0]);
    Ok(vec![
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, [0.0, course_deg, 0.0]),
        command(MavCmd::MAV_CMD_DO_CHANGE_SPEED, [0.0, speed_mps, -1.0]),
        command(MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE, [altitude_m, 0.0, 0.0]),
    ])
}

pub(super) fn limits(parameters: Parameters<'_>) -> VehicleLimits {
    VehicleLimits {
        speed_min_mps: parameters("FW_AIRSPD_MIN"),
        speed_max_mps: parameters("FW_AIRSPD_MAX"),
        speeds_are_air: true,
        bank_max_rad: parameters("FW_R_LIM").map(f64::to_radians),
        climb_max_mps: parameters("FW_T_CLMB_R_SP"),
        sink_max_mps: parameters("FW_T_SINK_R_SP"),
        takeoff_height_m: parameters("MIS_TAKEOFF_ALT"),
    }
}
