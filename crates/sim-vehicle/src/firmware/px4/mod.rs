//! PX4 1.18 of a fixed wing, as <https://github.com/PX4/PX4-Autopilot> has it in `src/modules/commander` and
//! `src/modules/mavlink`: what differs here, its modes, its commands, its offboard control and its parameters beside.
//! What it watches over is in `autopilot/failsafe/streams.rs`, what it does by itself in `autopilot/habits.rs`.

pub(super) mod commands;
mod link_rates;
pub(super) mod messages;
pub(super) mod mission_items;
pub(super) mod modes;
pub(super) mod offboard;
pub(super) mod parameters;
mod params;
pub(super) mod preflight;

use super::arduplane;
use super::rules::{CommandSet, Rules, TargetSet};
use super::stock;
use super::words;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::MavAutopilot;

/// PX4 1.18 of a fixed wing.
pub(super) const RULES: Rules = Rules {
    name: "px4",
    product: "PX4",
    autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
    version: [1, 18, 0],

    custom_mode: modes::custom_mode,
    custom_mode_has_sub_mode: true,
    mode_name: modes::mode_name,
    base_mode: modes::base_mode,
    modes: &modes::SELECTABLE,
    has_standard_modes: true,
    first_mode,
    mode_after_mission: Mode::Loiter,
    is_active_once_armed: true,
    // It does not tell before its next heartbeat.
    tells_mode_at_once: false,
    returns_without_mission: false,

    commands: CommandSet::Px4,
    targets: TargetSet::Px4,
    acknowledges_set_mode: true,
    tells_origin: true,
    unknown_interval_fails: true,
    home_is_above_sea: true,
    has_ardupilot_commands: false,

    words: words::PX4,
    fence_forbids_arming: false,
    fence_of_no_distance_is_none: true,
    climbs_to_return: true,
    fence_action,
    tells_arming_reason: false,
    has_switches: false,
    any_ground_station: true,
    watches_streams: true,

    judges_plans_as_px4: true,
    transfers_plans_as_px4: true,
    // CONFIG_NUM_MISSION_ITMES_SUPPORTED of its simulator, DM_KEY_FENCE_POINTS_MAX and DM_KEY_SAFE_POINTS_MAX.
    plan_items_max: [10_000, 64, 32],
    first_mission_item: 0,
    resumes_after_upload: false,
    takes_off_before_mission: true,
    return_item_stays_current: false,
    nan_params_are_left_out: true,
    keeps_items_in_bytes: false,
    asks_by_old_message: false,
    tells_next_flown_item: false,
    tells_mission_as_px4: true,
    mission_mode_suspended: 2,
    repeats_reached: true,

    renamed_parameters: &[],
    has_parameter: |parameter| !parameters::ABSENT_PARAMETERS.contains(&parameter),
    parameter: parameters::parameter,
    stock: || Some(&stock::PX4),
    initial_parameters: &[
        (Parameter::DisarmDelay, 2.0),
        // Its fence counts as soon as it is uploaded.
        (Parameter::FenceEnable, 1.0),
        (Parameter::FenceAction, 2.0),
        // All kinds, of which those count that have a distance.
        (Parameter::FenceType, 7.0),
        (Parameter::FenceRadius, 0.0),
        (Parameter::FenceAltitudeMax, 0.0),
        // What airframes of fixed wings set (`rc.fw_defaults`).
        (Parameter::WaypointRadius, 10.0),
        (Parameter::TakeoffAltitude, 25.0),
        (Parameter::RtlAltitude, 100.0),
        (Parameter::PreflightDisarmDelay, -1.0),
    ],
    bytewise_parameters: true,
    parameter_names_have_case: true,
    has_parameter_hash: true,
    more_streams: &[
        (Stream::AttitudeQuaternion, |rates| &mut rates.attitude_hz),
        (Stream::Altitude, |rates| &mut rates.system_time_hz),
        (Stream::WindCov, |rates| &mut rates.system_time_hz),
        (Stream::GpsGlobalOrigin, |rates| &mut rates.system_time_hz),
        (Stream::Odometry, |rates| &mut rates.raw_sensors_hz),
        (Stream::HighresImu, |rates| &mut rates.raw_sensors_hz),
        (Stream::AttitudeTarget, |rates| &mut rates.vfr_hud_hz),
        (Stream::PositionTargetLocalNed, |rates| &mut rates.sys_status_hz),
        (Stream::ServoOutputRaw, |rates| &mut rates.sys_status_hz),
        (Stream::EstimatorStatus, |rates| &mut rates.home_position_hz),
        (Stream::Vibration, |rates| &mut rates.home_position_hz),
    ],
    // MAV_PROTO_VER is 2 at first.
    answers_in_mavlink_1: false,
    link_rates: link_rates::of,
    ..arduplane::RULES
};

/// In lockstep it follows setpoints from the beginning.
fn first_mode(mode: Mode, in_lockstep: bool) -> Mode {
    match mode {
        Mode::Guided if in_lockstep => Mode::Offboard,
        Mode::Guided | Mode::Manual => Mode::Loiter,
        other => other,
    }
}

/// GF_ACTION; a warning, and what has no meaning here, is words alone.
fn fence_action(value: u8) -> Option<Mode> {
    match value {
        2 => Some(Mode::Loiter),
        3 => Some(Mode::Rtl),
        5 => Some(Mode::Land),
        _ => None,
    }
}
