//! PX4's offboard control: a stream of setpoints, without which Offboard is not entered in the air and is left when it
//! stops (`mavlink_receiver.cpp`, `offboardCheck.cpp`).
//!
//! A real fixed wing accepts velocities in Offboard and does not follow them; this one does.

// PX4 looks for the older numbers of the frames.
#![allow(deprecated)]

use crate::autopilot::Autopilot;
use crate::autopilot::flight::attitude::{Angle, AttitudeTarget};
use crate::error::Severity;
use crate::firmware::attitude::Euler;
use crate::firmware::targets::{PositionTarget, TargetError, fly_target};
use crate::mode::Mode;
use mavlink_bridge::AltitudeDatum;
use mavlink_bridge::dialect::{
    AttitudeTargetTypemask as AttitudeMask, MavFrame, SET_ATTITUDE_TARGET_DATA, SET_POSITION_TARGET_GLOBAL_INT_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};

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

/// An attitude or rates of roll and pitch, with a thrust: other masks are passed over, and do not keep the stream alive
/// (`handle_message_set_attitude_target`). Where there are both the attitude counts.
pub(in crate::firmware) fn take_attitude(autopilot: &mut Autopilot, data: &SET_ATTITUDE_TARGET_DATA) {
    let leaves_out = |part: AttitudeMask| data.type_mask.contains(part);
    let has_attitude = !leaves_out(AttitudeMask::ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE);
    let has_rates = !leaves_out(AttitudeMask::ATTITUDE_TARGET_TYPEMASK_BODY_ROLL_RATE_IGNORE)
        && !leaves_out(AttitudeMask::ATTITUDE_TARGET_TYPEMASK_BODY_PITCH_RATE_IGNORE);
    let thrust = if leaves_out(AttitudeMask::ATTITUDE_TARGET_TYPEMASK_THRUST_BODY_SET) {
        data.thrust_body[0]
    } else if !leaves_out(AttitudeMask::ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE) {
        data.thrust
    } else {
        return;
    };
    if !has_attitude && !has_rates || !hear_target(autopilot) {
        return;
    }
    let now_rad = autopilot.flight.roll_and_pitch_rad();
    let rates_radps = [data.body_roll_rate, data.body_pitch_rate].map(f64::from);
    let angles = if has_attitude {
        Euler::of(data.q).map(|euler| [euler.roll_rad, euler.pitch_rad].map(Angle::held))
    } else {
        let moving = |axis: usize| Angle { rad: now_rad[axis], rate_radps: rates_radps[axis] };
        rates_radps.iter().all(|rate| rate.is_finite()).then(|| [0, 1].map(moving))
    };
    match angles.filter(|_| thrust.is_finite()) {
        Some([roll, pitch]) => autopilot.follow_attitude(&AttitudeTarget {
            roll: Some(roll),
            pitch: Some(pitch),
            throttle: Some(f64::from(thrust.clamp(0.0, 1.0))),
            takes_off: true,
        }),
        None => refuse_target(autopilot, "Offboard: no such attitude"),
    }
}

/// A target keeps the stream alive, and brings Offboard back that was left for want of one. Whether it is Offboard that
/// is flown.
fn hear_target(autopilot: &mut Autopilot) -> bool {
    autopilot.hear_offboard_setpoint();
    if autopilot.session.failsafes.streams.ends_with_setpoints() {
        autopilot.set_mode(Mode::Offboard);
        autopilot.say(Severity::Info, "Offboard signal regained");
    }
    autopilot.mode() == Mode::Offboard
}

/// Any target keeps the stream alive; one that says where to and how high is flown, in Offboard.
fn take_target(autopilot: &mut Autopilot, target: Result<PositionTarget, TargetError>) {
    let target = match target {
        Ok(target) if target.asks_for_anything => target,
        Ok(_) => return refuse_target(autopilot, "SET_POSITION_TARGET invalid"),
        Err(reason) => return refuse_target(autopilot, &format!("Offboard: {reason}")),
    };
    if !hear_target(autopilot) {
        return;
    }
    autopilot.flight.set_attitude(None);
    if !target.is_complete() {
        return refuse_target(autopilot, &format!("Offboard: mask {:#05x} is not followed", target.mask));
    }
    autopilot.count_setpoint();
    fly_target(autopilot, &target);
}

fn refuse_target(autopilot: &mut Autopilot, reason: &str) {
    autopilot.refuse_setpoint(Severity::Critical, reason);
}
