//! What an autopilot answers where an ArduPlane answers otherwise: which module is asked.

use super::rules::{CommandSet, Rules, TargetSet};
use super::{arduplane, generic, px4};
use crate::autopilot::Autopilot;
use crate::error::CommandError;
use crate::mode::Mode;
use crate::protocol::command::request::Command;
use mavlink_bridge::dialect::{SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA};

/// What the autopilot makes of a command, if it is not ArduPlane's answer.
pub(crate) fn execute(autopilot: &mut Autopilot, command: &Command) -> Option<Result<(), CommandError>> {
    let rules = autopilot.rules();
    let for_device = || for_device(rules, command.command as u32 as u16, command.params[0]);
    match rules.commands {
        CommandSet::ArduPlane => for_device(),
        CommandSet::Px4 => px4::commands::execute(autopilot, command).or_else(for_device),
        CommandSet::Generic => generic::commands::execute(autopilot, command),
    }
}

/// The answer to a command for a device that is not there; none if it is not for one, or the autopilot knows no such
/// command.
pub(crate) fn for_device(rules: &Rules, command: u16, param_1: f32) -> Option<Result<(), CommandError>> {
    match rules.commands {
        CommandSet::ArduPlane => arduplane::devices::answer(command, param_1),
        CommandSet::Px4 => px4::commands::accepts_without_device(command).then_some(Ok(())),
        CommandSet::Generic => None,
    }
}

/// Sets one of the autopilot's modes.
pub(crate) fn change_mode(autopilot: &mut Autopilot, mode: Mode) -> Result<(), CommandError> {
    match autopilot.rules().commands {
        CommandSet::Px4 => px4::commands::change_mode(autopilot, mode),
        CommandSet::ArduPlane | CommandSet::Generic => autopilot.enter(mode),
    }
}

/// Whether PREFLIGHT_REBOOT_SHUTDOWN starts the vehicle anew. Param 1: 1 to start anew, or 3, for a boot loader that
/// there is none of.
pub(crate) fn check_reboot(rules: &Rules, is_armed: bool, p1: f32) -> Result<bool, CommandError> {
    let is_px4 = rules.commands == CommandSet::Px4;
    if is_armed {
        let reason = "Reboot: it is armed";
        return Err(if is_px4 { CommandError::denied(reason) } else { CommandError::failed(reason) });
    }
    match p1 {
        1.0 | 3.0 => Ok(true),
        // PX4: nothing for the autopilot.
        0.0 if is_px4 => Ok(false),
        _ if is_px4 => Err(CommandError::denied("Reboot: param 1 must be 1")),
        _ => Err(CommandError::unsupported()),
    }
}

/// Takes a SET_POSITION_TARGET_LOCAL_NED as the autopilot does; `false` if that is ArduPlane's way.
pub(crate) fn take_local_target(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> bool {
    match autopilot.rules().targets {
        TargetSet::ArduPlane => return arduplane::targets::take_local(autopilot, data),
        TargetSet::Px4 => px4::offboard::take_local(autopilot, data),
        TargetSet::Generic => generic::targets::take_local(autopilot, data),
    }
    true
}

/// Takes a SET_POSITION_TARGET_GLOBAL_INT.
pub(crate) fn take_global_target(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
    match autopilot.rules().targets {
        TargetSet::ArduPlane => arduplane::targets::take_global(autopilot, data),
        TargetSet::Px4 => px4::offboard::take_global(autopilot, data),
        TargetSet::Generic => generic::targets::take_global(autopilot, data),
    }
}

/// Takes a SET_ATTITUDE_TARGET, which keeps the offboard stream of a PX4 alive and is not followed.
pub(crate) fn take_attitude(autopilot: &mut Autopilot) {
    if autopilot.rules().hears_attitude_targets {
        px4::offboard::take_attitude(autopilot);
    }
}
