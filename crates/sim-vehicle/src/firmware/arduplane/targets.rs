//! What an ArduPlane makes of position targets in GUIDED: their altitude alone
//! (`handle_set_position_target_local_ned` and `..._global_int` of GCS_MAVLink_Plane.cpp).

// Clients still send the older numbers of the frames.
#![allow(deprecated)]

use crate::mode::Mode;
use crate::protocol::command::ALTITUDE_MAX_M;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{
    MavFrame, MavSeverity, PositionTargetTypemask as Mask, SET_POSITION_TARGET_GLOBAL_INT_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};

impl Vehicle {
    /// In LOCAL_OFFSET_NED: so much above the altitude that it has been told, whatever the mask says. `false` for any other
    /// frame, which an ArduPlane passes over.
    pub(in crate::firmware) fn arduplane_take_local_target(
        &mut self,
        data: &SET_POSITION_TARGET_LOCAL_NED_DATA,
    ) -> bool {
        if data.coordinate_frame != MavFrame::MAV_FRAME_LOCAL_OFFSET_NED {
            return false;
        }
        if self.mode() != Mode::Guided {
            return true;
        }
        let altitude_m = self.flight.aim().altitude_m - f64::from(data.z);
        if !data.z.is_finite() || altitude_m.abs() >= f64::from(ALTITUDE_MAX_M) {
            self.refuse_setpoint(MavSeverity::MAV_SEVERITY_WARNING, "Setpoint refused: no such altitude");
        } else if self.change_guided_altitude(altitude_m) {
            let above_home_m = altitude_m - self.flight.home().altitude_m;
            self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("Change alt to {above_home_m:.1}"));
        }
        true
    }

    /// In a global frame, unless the mask leaves the altitude out.
    pub(in crate::firmware) fn arduplane_take_global_target(&mut self, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
        if self.mode() != Mode::Guided || data.type_mask.contains(Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE) {
            return;
        }
        match self.guided_altitude_m("Setpoint", data.alt, data.coordinate_frame as u8) {
            // They come in streams: no word of each.
            Ok(altitude_m) => {
                self.change_guided_altitude(altitude_m);
            }
            Err(refusal) => self.refuse_setpoint(refusal.severity, &refusal.reason.unwrap_or_default()),
        }
    }

    /// Without effect, and then `false`, while a GUIDED_CHANGE_ALTITUDE is flown.
    fn change_guided_altitude(&mut self, altitude_m: f64) -> bool {
        if self.flight.is_altitude_slewed() {
            return false;
        }
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        self.restart_setpoint_timeout();
        true
    }
}
