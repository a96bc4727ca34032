//! PX4's offboard control: a stream of setpoints, without which Offboard is not entered in the air and is left when it
//! stops (`mavlink_receiver.cpp`, `offboardCheck.cpp`).
//!
//! A real fixed wing accepts velocities in Offboard and does not follow them; this one does.

// PX4 looks for the older numbers of the frames.
#![allow(deprecated)]

use crate::autopilot::Autopilot;
use crate::error::Severity;
use crate::firmware::targets::{PositionTarget, TargetError, fly_target};
use crate::mode::Mode;
use mavlink_bridge::AltitudeDatum;
use mavlink_bridge::dialect::{MavFrame, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA};

/// The numbers of the global frames that PX4 looks for.
const INT_FRAMES: [u8; 3] = [
    MavFrame::MAV_FRAME_GLOBAL_INT as u8,
    MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT as u8,
    MavFrame::MAV_FRAME_GLOBAL_TERRAIN_ALT_INT as u8,
];

pub(in crate::firmware) fn take_local(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
    let target = PositionTarget::from_local(data, autopilot.flight.state().course_rad);
    take_target(autopilot, target);
}

/// Altitudes above the sea, above home or above the terrain, in the numbers of INT messages alone.
pub(in crate::firmware) fn take_global(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
    let target = PositionTarget::from_global(
        data,
        |position| autopilot.reference().locate(position),
        |altitude_m, frame| {
            let datum = AltitudeDatum::of_frame(frame).filter(|_| INT_FRAMES.contains(&frame));
            datum.map(|datum| autopilot.reference().above_origin_m(datum, f64::from(altitude_m)))
        },
    );
    take_target(autopilot, target);
}

/// SET_ATTITUDE_TARGET keeps the stream alive, and is not followed.
pub(crate) fn take_attitude(autopilot: &mut Autopilot) {
    autopilot.hear_offboard_setpoint();
    if autopilot.mode() == Mode::Offboard {
        refuse_target(autopilot, "Offboard: attitudes are not followed");
    }
}

/// Any target keeps the stream alive; one that says where to and how high is flown, in Offboard.
fn take_target(autopilot: &mut Autopilot, target: Result<PositionTarget, TargetError>) {
    let target = match target {
        Ok(target) if target.asks_for_anything => target,
        Ok(_) => return refuse_target(autopilot, "SET_POSITION_TARGET invalid"),
        Err(reason) => return refuse_target(autopilot, &format!("Offboard: {reason}")),
    };
    autopilot.hear_offboard_setpoint();
    if autopilot.session.failsafes.streams.ends_with_setpoints() {
        autopilot.set_mode(Mode::Offboard);
        autopilot.say(Severity::Info, "Offboard signal regained");
    }
    if autopilot.mode() != Mode::Offboard {
        return;
    }
    if !target.is_complete() {
        return refuse_target(autopilot, &format!("Offboard: mask {:#05x} is not followed", target.mask));
    }
    autopilot.count_setpoint();
    fly_target(autopilot, &target);
}

fn refuse_target(autopilot: &mut Autopilot, reason: &str) {
    autopilot.refuse_setpoint(Severity::Critical, reason);
}
