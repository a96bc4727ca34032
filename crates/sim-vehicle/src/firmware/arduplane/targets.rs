//! What an ArduPlane makes of targets in GUIDED: of positions their altitude alone, of attitudes each axis by itself
//! (`handle_set_position_target_local_ned`, `..._global_int` and `handle_set_attitude_target` of
//! GCS_MAVLink_Plane.cpp).

// Clients still send the older numbers of the frames.
#![allow(deprecated)]

use crate::autopilot::Autopilot;
use crate::autopilot::flight::attitude::{Angle, AttitudeTarget};
use crate::autopilot::input::ALTITUDE_MAX_M;
use crate::error::Severity;
use crate::firmware::attitude::Euler;
use crate::mode::Mode;
use mavlink_bridge::dialect::{
    AttitudeTargetTypemask, MavFrame, PositionTargetTypemask as Mask, SET_ATTITUDE_TARGET_DATA,
    SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};

/// In LOCAL_OFFSET_NED: so much above the altitude that it has been told, whatever the mask says. `false` for any other
/// frame, which an ArduPlane passes over.
pub(in crate::firmware) fn take_local(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> bool {
    if data.coordinate_frame != MavFrame::MAV_FRAME_LOCAL_OFFSET_NED {
        return false;
    }
    if autopilot.mode() != Mode::Guided {
        return true;
    }
    let altitude_m = autopilot.flight.aim().altitude_m - f64::from(data.z);
    if !data.z.is_finite() || altitude_m.abs() >= f64::from(ALTITUDE_MAX_M) {
        autopilot.refuse_setpoint(Severity::Warning, "Setpoint refused: no such altitude");
    } else if change_guided_altitude(autopilot, altitude_m) {
        let above_home_m = altitude_m - autopilot.flight.home().altitude_m;
        autopilot.say(Severity::Info, &format!("Change alt to {above_home_m:.1}"));
    }
    true
}

/// In a global frame, unless the mask leaves the altitude out.
pub(in crate::firmware) fn take_global(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
    if autopilot.mode() != Mode::Guided || data.type_mask.contains(Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE) {
        return;
    }
    match autopilot.guided_altitude_m("Setpoint", data.alt, data.coordinate_frame as u8) {
        // They come in streams: no word of each.
        Ok(altitude_m) => {
            change_guided_altitude(autopilot, altitude_m);
        }
        Err(error) => autopilot.refuse_setpoint(error.severity, &error.reason.unwrap_or_default()),
    }
}

/// PTCH_LIM_MAX_DEG and PTCH_LIM_MIN_DEG as they are at first, degrees.
const PITCH_LIMITS_DEG: [f64; 2] = [-25.0, 20.0];

/// In GUIDED. The attitude sets bank and pitch; where the mask leaves it out, an axis whose rate is not left out is set
/// by it all the same. The throttle is set by itself. There is no rudder, which the yaw would move.
pub(in crate::firmware) fn take_attitude(autopilot: &mut Autopilot, data: &SET_ATTITUDE_TARGET_DATA, takes_off: bool) {
    if autopilot.mode() != Mode::Guided {
        return;
    }
    let is_whole = !data.type_mask.contains(AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE);
    let is_set = |rate: AttitudeTargetTypemask| is_whole || !data.type_mask.contains(rate);
    let is_rolled = is_set(AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_BODY_ROLL_RATE_IGNORE);
    let is_pitched = is_set(AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_BODY_PITCH_RATE_IGNORE);
    let is_throttled = !data.type_mask.contains(AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE);
    let euler = Euler::of(data.q);
    if is_throttled && !data.thrust.is_finite() || (is_rolled || is_pitched) && euler.is_none() {
        return autopilot.refuse_setpoint(Severity::Warning, "Setpoint refused: no such attitude");
    }
    let [least_rad, most_rad] = PITCH_LIMITS_DEG.map(f64::to_radians);
    let target = AttitudeTarget {
        roll: euler.filter(|_| is_rolled).map(|euler| Angle::held(euler.roll_rad)),
        pitch: euler.filter(|_| is_pitched).map(|euler| Angle::held(euler.pitch_rad.clamp(least_rad, most_rad))),
        throttle: is_throttled.then(|| f64::from(data.thrust.clamp(0.0, 1.0))),
        takes_off,
    };
    // A yaw alone.
    if !target.is_empty() {
        autopilot.force_attitude(&target);
    }
}

/// Without effect, and then `false`, while a GUIDED_CHANGE_ALTITUDE is flown.
fn change_guided_altitude(autopilot: &mut Autopilot, altitude_m: f64) -> bool {
    if autopilot.flight.is_altitude_slewed() {
        return false;
    }
    autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
    autopilot.restart_setpoint_timeout();
    true
}
