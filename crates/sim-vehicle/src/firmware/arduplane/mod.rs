//! ArduPlane. Its modes are those of [`Mode`](crate::Mode), and its answers those of `protocol/command/`.

pub(super) mod commands;
pub(super) mod devices;
mod link_rates;
pub(super) mod messages;
pub(super) mod mission_items;
mod renamed;
pub(super) mod targets;

use super::rules::{CommandSet, Rules, TargetSet};
use super::stock;
use super::words;
use crate::mode::Mode;
use crate::parameters::table::{OF_PX4_ALONE, Parameter};
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MavAutopilot, MavModeFlag};

/// ArduPlane 4.7.
pub(super) const RULES: Rules = Rules {
    name: "arduplane",
    product: "ArduPlane",
    autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
    version: [4, 7, 0],

    custom_mode: Mode::number,
    custom_mode_has_sub_mode: false,
    mode_name: Mode::name,
    base_mode,
    modes: Mode::ARDUPLANE,
    has_standard_modes: false,
    first_mode: |mode, _| mode,
    mode_after_mission: Mode::Rtl,
    is_active_once_armed: false,
    tells_mode_at_once: true,
    returns_without_mission: true,

    commands: CommandSet::ArduPlane,
    targets: TargetSet::ArduPlane,
    acknowledges_set_mode: false,
    tells_origin: false,
    unknown_interval_fails: false,
    home_is_above_sea: false,
    has_ardupilot_commands: true,

    words: words::ARDUPLANE,
    fence_forbids_arming: true,
    fence_of_no_distance_is_none: false,
    climbs_to_return: false,
    fence_action,
    tells_arming_reason: true,
    has_switches: true,
    any_ground_station: false,
    watches_streams: false,

    judges_plans_as_px4: false,
    transfers_plans_as_px4: false,
    // What its simulator has room for.
    plan_items_max: [1312, 84, 50],
    first_mission_item: 1,
    resumes_after_upload: true,
    takes_off_before_mission: false,
    return_item_stays_current: true,
    nan_params_are_left_out: false,
    keeps_items_in_bytes: true,
    passes_waypoints: true,
    upload_can_be_broken_off: false,
    asks_by_old_message: true,
    tells_next_flown_item: true,
    tells_mission_as_px4: false,
    mission_mode_suspended: 0,
    repeats_reached: false,

    has_parameter: |parameter: Parameter| !OF_PX4_ALONE.contains(&parameter),
    parameter: |parameter| (parameter.name(), parameter.kind()),
    stock: || Some(&stock::ARDUPLANE),
    renamed_parameters: renamed::RENAMED,
    initial_parameters: &[],
    bytewise_parameters: false,
    tells_whole_numbers_as_floats: false,
    parameter_names_have_case: false,
    has_parameter_hash: false,
    // Of the sticks it tells unasked.
    more_streams: &[(Stream::RcChannels, |rates| &mut rates.sys_status_hz)],
    answers_in_mavlink_1: true,
    link_rates: link_rates::of,
};

/// FENCE_ACTION.
pub(super) fn fence_action(value: u8) -> Option<Mode> {
    match value {
        1 | 8 => Some(Mode::Rtl),
        6 | 7 => Some(Mode::Guided),
        // Only told: 0, and what has no meaning for a plane.
        _ => None,
    }
}

/// The flags that ArduPlane sets: 217 in GUIDED when armed, 209 in CRUISE and MANUAL, 81 in MANUAL when not.
pub(super) fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED;
    if !mode.is_manual() {
        flags |= MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED;
    }
    flags.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, armed);
    flags
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heartbeat_is_arduplanes() {
        assert_eq!(base_mode(Mode::Guided, true).bits(), 217);
        assert_eq!(base_mode(Mode::Cruise, true).bits(), 209);
        assert_eq!(base_mode(Mode::Guided, false).bits(), 89);
        assert_eq!(base_mode(Mode::Manual, false).bits(), 81);
    }
}
