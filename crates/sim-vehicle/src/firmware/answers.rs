//! What an autopilot answers where an ArduPlane answers otherwise: which module is asked.

use super::rules::{CommandSet, Rules, TargetSet};
use super::{arduplane, generic, px4};
use crate::autopilot::Autopilot;
use crate::autopilot::input::integer;
use crate::autopilot::plan::PlanKind;
use crate::error::{CommandError, CommandResult, PlanError};
use crate::mode::Mode;
use crate::protocol::command::request::Command;
use mavlink_bridge::dialect::{
    SET_ATTITUDE_TARGET_DATA, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use mavlink_bridge::{CommandPosition, PlanItem};

/// What the autopilot makes of a command, if it is not ArduPlane's answer.
pub(crate) fn execute(autopilot: &mut Autopilot, command: &Command) -> Option<Result<(), CommandError>> {
    match autopilot.rules().commands {
        CommandSet::ArduPlane => arduplane::commands::execute(autopilot, command),
        CommandSet::Px4 => px4::commands::execute(autopilot, command),
        CommandSet::Generic => generic::commands::execute(autopilot, command),
    }
}

/// The answer to a command for a device that is not there; none if it is not for one, or the autopilot knows no such
/// command.
pub(crate) fn for_device(
    autopilot: &mut Autopilot,
    command: u16,
    params: [f32; 4],
) -> Option<Result<(), CommandError>> {
    match autopilot.rules().commands {
        CommandSet::ArduPlane => arduplane::devices::execute(autopilot, command, params),
        CommandSet::Px4 => px4::preflight::answer_by_number(command),
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
/// there is none of. An armed ArduPlane does so by force alone: param 6 is 20190226. To a PX4 param 1 = 0 asks for
/// nothing.
pub(crate) fn check_reboot(rules: &Rules, is_armed: bool, command: &Command) -> Result<bool, CommandError> {
    let p1 = command.params[0];
    if rules.commands == CommandSet::Px4 {
        return match integer(p1) {
            0 => Ok(false),
            1 | 3 if !is_armed => Ok(true),
            _ => Err(CommandError::denied("Reboot: it is armed, or param 1 is neither 0, 1 nor 3")),
        };
    }
    if is_armed && !is_reboot_forced(command) {
        return Err(CommandError::failed("Reboot: it is armed"));
    }
    if p1 != 1.0 && p1 != 3.0 {
        return Err(CommandError::new(CommandResult::Unsupported, "Reboot: param 1 must be 1 or 3"));
    }
    Ok(true)
}

/// What becomes of the values of all parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    /// They are kept, as always.
    Kept,
    /// They are the first ones again.
    Reset,
    /// They are the first ones again when the vehicle starts anew.
    ResetByReboot,
}

/// PREFLIGHT_STORAGE. Param 1 of an ArduPlane: 2 for the first values, after a reboot. Of a PX4, disarmed: 0 load, 1
/// save, 2 and 4 for the first values, 3 for those of sensors' calibrations, of which there are none.
pub(crate) fn storage(rules: &Rules, is_armed: bool, command: &Command) -> Result<Storage, CommandError> {
    let p1 = command.params[0];
    if rules.commands != CommandSet::Px4 {
        let refused = CommandError::denied("Storage: param 1 must be 2");
        return if p1 == 2.0 { Ok(Storage::ResetByReboot) } else { Err(refused) };
    }
    match integer(p1) {
        _ if is_armed => Err(CommandError::rejected("Storage: it is armed")),
        0 | 1 | 3 => Ok(Storage::Kept),
        2 | 4 => Ok(Storage::Reset),
        // A PX4 says nothing to what it does not know.
        _ => Err(CommandError::unanswered("Storage: param 1 must be 0 to 4")),
    }
}

/// The number that reboots an armed ArduPlane, in param 6 or y.
const REBOOT_BY_FORCE: i32 = 20_190_226;

fn is_reboot_forced(command: &Command) -> bool {
    match command.position {
        CommandPosition::Int(position) => position.longitude_e7 == REBOOT_BY_FORCE,
        CommandPosition::Long([_, p6]) => p6 == REBOOT_BY_FORCE as f32,
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

/// Takes a SET_ATTITUDE_TARGET.
pub(crate) fn take_attitude(autopilot: &mut Autopilot, data: &SET_ATTITUDE_TARGET_DATA) {
    match autopilot.rules().targets {
        TargetSet::ArduPlane => arduplane::targets::take_attitude(autopilot, data, false),
        TargetSet::Px4 => px4::offboard::take_attitude(autopilot, data),
        TargetSet::Generic => arduplane::targets::take_attitude(autopilot, data, true),
    }
}

/// A checked item of a plan as it is flown and told.
pub(crate) fn kept_plan_item(rules: &Rules, kind: PlanKind, item: &PlanItem) -> PlanItem {
    if rules.keeps_items_in_bytes && kind == PlanKind::Mission {
        arduplane::mission_items::as_kept(item)
    } else {
        *item
    }
}

/// An item of a plan as it is told again.
pub(crate) fn told_plan_item(rules: &Rules, kind: PlanKind, item: &PlanItem, by_integers: bool) -> PlanItem {
    match rules.commands {
        CommandSet::Px4 => px4::mission_items::as_kept(kind, item, by_integers),
        CommandSet::ArduPlane | CommandSet::Generic => *item,
    }
}

/// Whether an item can be one of a plan, and why not; none if that is every vehicle's check.
pub(crate) fn check_plan_item(
    rules: &Rules,
    kind: PlanKind,
    item: &PlanItem,
    by_integers: bool,
) -> Option<Result<(), PlanError>> {
    match rules.commands {
        CommandSet::Px4 => Some(px4::mission_items::check(kind, item, by_integers)),
        CommandSet::ArduPlane | CommandSet::Generic => None,
    }
}
