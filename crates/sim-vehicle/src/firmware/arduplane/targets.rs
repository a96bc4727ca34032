//! What an ArduPlane makes of position targets in GUIDED: their altitude alone
//! (`handle_set_position_target_local_ned` and `..._global_int` of GCS_MAVLink_Plane.cpp).

// Clients still send the older numbers of the frames.
#![allow(deprecated)]

use crate::autopilot::Autopilot;
use crate::autopilot::input::ALTITUDE_MAX_M;
use crate::error::Severity;
use crate::mode::Mode;
use mavlink_bridge::dialect::{
    MavFrame, PositionTargetTypemask as Mask, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
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

/// Without effect, and then `false`, while a GUIDED_CHANGE_ALTITUDE is flown.
fn change_guided_altitude(autopilot: &mut Autopilot, altitude_m: f64) -> bool {
    if autopilot.flight.is_altitude_slewed() {
        return false;
    }
    autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
    autopilot.restart_setpoint_timeout();
    true
}
