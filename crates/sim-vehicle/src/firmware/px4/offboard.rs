//! PX4's offboard control: a stream of setpoints, without which Offboard is not entered in the air and is left when it
//! stops (`mavlink_receiver.cpp`, `offboardCheck.cpp`).
//!
//! A real fixed wing accepts velocities in Offboard and does not follow them; this one does.

// PX4 looks for the older numbers of the frames.
#![allow(deprecated)]

use super::Failsafe;
use crate::firmware::targets::{PositionTarget, TargetRefused};
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::vehicle::Vehicle;
use mavlink_bridge::AltitudeDatum;
use mavlink_bridge::dialect::{
    MavFrame, MavSeverity, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use std::time::Duration;

/// The numbers of the global frames that PX4 looks for.
const INT_FRAMES: [u8; 3] = [
    MavFrame::MAV_FRAME_GLOBAL_INT as u8,
    MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT as u8,
    MavFrame::MAV_FRAME_GLOBAL_TERRAIN_ALT_INT as u8,
];

impl Vehicle {
    pub(in crate::firmware) fn px4_take_local_target(&mut self, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
        let target = PositionTarget::from_local(data, self.flight.state().course_rad);
        self.take_target(target);
    }

    /// Altitudes above the sea, above home or above the terrain, in the numbers of INT messages alone.
    pub(in crate::firmware) fn px4_take_global_target(&mut self, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
        let target = PositionTarget::from_global(
            data,
            |position| self.to_local(position),
            |altitude_m, frame| {
                let datum = AltitudeDatum::of_frame(frame).filter(|_| INT_FRAMES.contains(&frame));
                datum.map(|datum| self.above_origin_m(datum, f64::from(altitude_m)))
            },
        );
        self.take_target(target);
    }

    /// SET_ATTITUDE_TARGET keeps the stream alive, and is not followed.
    pub(crate) fn px4_take_attitude(&mut self) {
        self.px4.setpoint_heard = Some(self.time);
        if self.mode() == Mode::Offboard {
            self.refuse_target("Offboard: attitudes are not followed");
        }
    }

    /// Whether setpoints have come of late.
    pub(super) fn has_offboard_stream(&self) -> bool {
        let timeout_s = self.parameters.get(Parameter::OffboardTimeout);
        let is_recent = |heard: Duration| self.time.saturating_sub(heard).as_secs_f32() <= timeout_s;
        // In lockstep time stands still between setpoints.
        self.lockstep.is_some() || self.px4.setpoint_heard.is_some_and(is_recent)
    }

    /// Any target keeps the stream alive; one that says where to and how high is flown, in Offboard.
    fn take_target(&mut self, target: Result<PositionTarget, TargetRefused>) {
        let target = match target {
            Ok(target) if target.asks_for_anything => target,
            Ok(_) => return self.refuse_target("SET_POSITION_TARGET invalid"),
            Err(reason) => return self.refuse_target(&format!("Offboard: {reason}")),
        };
        self.px4.setpoint_heard = Some(self.time);
        if self.px4.failsafe.is_some_and(Failsafe::ends_with_setpoints) {
            self.set_mode(Mode::Offboard);
            self.say(MavSeverity::MAV_SEVERITY_INFO, "Offboard signal regained");
        }
        if self.mode() != Mode::Offboard {
            return;
        }
        if !target.is_complete() {
            return self.refuse_target(&format!("Offboard: mask {:#05x} is not followed", target.mask));
        }
        self.counters.setpoints_accepted += 1;
        self.fly_target(&target);
    }

    fn refuse_target(&mut self, reason: &str) {
        self.refuse_setpoint(MavSeverity::MAV_SEVERITY_CRITICAL, reason);
    }
}
