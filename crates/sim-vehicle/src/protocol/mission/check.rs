//! Plans by their numbers on the wire, and what is checked of one before it is taken.

use crate::autopilot::plan::PlanKind;
use crate::autopilot::{fence, mission, rally};
use crate::error::PlanError;
use crate::firmware::answers;
use crate::firmware::rules::{CommandSet, Rules};
use crate::parameters::table::Parameter;
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::{MavMissionResult, MavMissionType};

/// The plan of a MAV_MISSION_TYPE.
pub(super) fn kind_of(mission_type: u8) -> Option<PlanKind> {
    PlanKind::ALL.into_iter().find(|kind| self::mission_type(*kind) as u8 == mission_type)
}

/// The number of a plan.
pub(super) fn mission_type(kind: PlanKind) -> MavMissionType {
    match kind {
        PlanKind::Mission => MavMissionType::MAV_MISSION_TYPE_MISSION,
        PlanKind::Fence => MavMissionType::MAV_MISSION_TYPE_FENCE,
        PlanKind::Rally => MavMissionType::MAV_MISSION_TYPE_RALLY,
    }
}

/// Most items.
pub(super) fn items_max(rules: &Rules, kind: PlanKind) -> u16 {
    rules.plan_items_max[kind as usize]
}

/// The parameter that counts its items.
pub(super) fn total(kind: PlanKind) -> Parameter {
    match kind {
        PlanKind::Mission => Parameter::MissionTotal,
        PlanKind::Fence => Parameter::FenceTotal,
        PlanKind::Rally => Parameter::RallyTotal,
    }
}

/// Whether an item can be one of `count` in this plan; the result code that says why not.
/// `first` is that of the items of a mission that are flown.
/// `by_integers`: it came as MISSION_ITEM_INT.
pub(super) fn check(
    rules: &Rules,
    kind: PlanKind,
    (seq, item): (u16, &PlanItem),
    count: u16,
    by_integers: bool,
) -> Result<(), PlanError> {
    if let Some(verdict) = answers::check_plan_item(rules, kind, item, by_integers) {
        return verdict;
    }
    let first = rules.first_mission_item;
    match kind {
        // Home is what it is.
        PlanKind::Mission if seq < first => Ok(()),
        PlanKind::Mission => mission::items::check(item, first..count),
        PlanKind::Fence => fence::items::check(item),
        PlanKind::Rally => rally::check(item),
    }
}

/// Whether items can be a plan; the index of the one that cannot, of the first too many or of their end, and why.
pub(super) fn check_items(rules: &Rules, kind: PlanKind, items: &[PlanItem]) -> Result<(), (usize, String)> {
    let count = u16::try_from(items.len()).unwrap_or(u16::MAX);
    if count > items_max(rules, kind) {
        let most = items_max(rules, kind);
        return Err((usize::from(most), format!("{} refused: more than {most} items", kind.name())));
    }
    for (seq, item) in (0..count).zip(items) {
        // By which message it came is not known any more.
        check(rules, kind, (seq, item), count, true)
            .or_else(|error| check(rules, kind, (seq, item), count, false).map_err(|_| error))
            .map_err(|error| (usize::from(seq), format!("{}: item {seq}", refusal(kind.name(), result_of(error)))))?;
    }
    if kind == PlanKind::Fence && rules.commands != CommandSet::Px4 {
        fence::items::check_whole(items).map_err(|reason| (items.len(), format!("Fence refused: {reason}")))?;
    }
    Ok(())
}

/// A result code in words.
pub(super) fn refusal(name: &str, result: MavMissionResult) -> String {
    let words = format!("{result:?}").to_lowercase().replace("mav_mission_", "").replace('_', " ");
    format!("{name} refused: {words}")
}

/// The result code of what is wrong with an item; of a whole plan there is none in particular.
pub(super) fn result_of(error: PlanError) -> MavMissionResult {
    match error {
        PlanError::Unsupported => MavMissionResult::MAV_MISSION_UNSUPPORTED,
        PlanError::UnsupportedFrame => MavMissionResult::MAV_MISSION_UNSUPPORTED_FRAME,
        PlanError::InvalidParam(1) => MavMissionResult::MAV_MISSION_INVALID_PARAM1,
        PlanError::InvalidParam(2) => MavMissionResult::MAV_MISSION_INVALID_PARAM2,
        PlanError::InvalidParam(3) => MavMissionResult::MAV_MISSION_INVALID_PARAM3,
        PlanError::InvalidParam(4) => MavMissionResult::MAV_MISSION_INVALID_PARAM4,
        PlanError::InvalidParam(5) => MavMissionResult::MAV_MISSION_INVALID_PARAM5_X,
        PlanError::InvalidParam(6) => MavMissionResult::MAV_MISSION_INVALID_PARAM6_Y,
        PlanError::InvalidParam(_) => MavMissionResult::MAV_MISSION_INVALID_PARAM7,
        _ => MavMissionResult::MAV_MISSION_ERROR,
    }
}
