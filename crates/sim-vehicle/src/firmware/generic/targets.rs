//! Position targets: in GUIDED all that can be flown is.

use crate::autopilot::Autopilot;
use crate::error::Severity;
use crate::firmware::targets::{PositionTarget, TargetError, fly_target};
use crate::mode::Mode;
use mavlink_bridge::dialect::{SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA};

pub(in crate::firmware) fn take_local(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
    let target = PositionTarget::from_local(data, autopilot.flight.state().course_rad);
    take_target(autopilot, target);
}

pub(in crate::firmware) fn take_global(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
    let target = PositionTarget::from_global(
        data,
        |position| autopilot.reference().locate(position),
        |altitude_m, frame| autopilot.altitude_m("Setpoint", altitude_m, frame).ok(),
    );
    take_target(autopilot, target);
}

/// In GUIDED all is flown that asks for a place, a velocity, an altitude or a rate of climb.
fn take_target(autopilot: &mut Autopilot, target: Result<PositionTarget, TargetError>) {
    let reason = match target {
        Ok(_) if autopilot.mode() != Mode::Guided => format!("mode is {}", autopilot.mode()),
        Ok(target) if target.is_flyable() => {
            autopilot.count_setpoint();
            fly_target(autopilot, &target);
            autopilot.restart_setpoint_timeout();
            return;
        }
        Ok(target) => format!("mask {:#05x} is not followed", target.mask),
        Err(error) => error.to_string(),
    };
    autopilot.refuse_setpoint(Severity::Warning, &format!("Setpoint refused: {reason}"));
}
