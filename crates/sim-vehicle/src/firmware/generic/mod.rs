//! No autopilot in particular, for authors of their own controllers: ArduPlane's numbers, commands and parameters, and
//! beside them take-off and landing as commands, MAVLink's standard modes, and position targets of every kind.

pub(super) mod commands;
pub(super) mod targets;

use super::arduplane;
use super::rules::{CommandSet, Rules, TargetSet};
use crate::mode::Mode;
use mavlink_bridge::dialect::{MavAutopilot, MavModeFlag, MavParamType};

/// ArduCopter's number of LAND, which ArduPlane leaves free.
pub(super) const LAND: u32 = 9;

/// No autopilot in particular.
pub(super) const RULES: Rules = Rules {
    name: "generic",
    product: "Columba",
    autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
    version: [0, 0, 0],

    custom_mode,
    base_mode,
    modes: &MODES,
    has_standard_modes: true,
    returns_without_mission: false,

    commands: CommandSet::Generic,
    targets: TargetSet::Generic,
    acknowledges_set_mode: true,
    tells_origin: true,

    tells_arming_reason: false,

    first_mission_item: 0,
    resumes_after_upload: false,
    takes_off_before_mission: true,
    return_item_stays_current: false,
    nan_params_are_left_out: true,
    keeps_items_in_bytes: false,
    passes_waypoints: false,
    upload_can_be_broken_off: true,
    asks_by_old_message: false,
    mission_mode_suspended: 2,

    // Clients do not agree on how an unknown autopilot encodes whole numbers: it has none.
    parameter: |parameter| (parameter.name(), MavParamType::MAV_PARAM_TYPE_REAL32),
    tells_whole_numbers_as_floats: true,
    stock: || None,
    more_streams: &[],
    ..arduplane::RULES
};

/// The modes that a client can set.
pub(super) const MODES: [Mode; 11] = [
    Mode::Manual,
    Mode::Circle,
    Mode::Stabilize,
    Mode::Fbwa,
    Mode::Cruise,
    Mode::Land,
    Mode::Auto,
    Mode::Rtl,
    Mode::Loiter,
    Mode::Takeoff,
    Mode::Guided,
];

/// ArduPlane's numbers, and one of LAND.
pub(super) fn custom_mode(mode: Mode) -> u32 {
    if mode == Mode::Land { LAND } else { mode.number() }
}

/// The flags of HEARTBEAT as MAVLink describes them: nobody looks up the custom modes of an unknown autopilot.
pub(super) fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED;
    flags.set(MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED, mode.is_manual());
    flags.set(MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED, !mode.is_manual());
    flags.set(MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED, !mode.is_manual() && mode != Mode::Guided);
    flags.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, armed);
    flags
}
