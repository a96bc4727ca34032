//! PX4 1.18 of a fixed wing, as <https://github.com/PX4/PX4-Autopilot> has it in `src/modules/commander` and
//! `src/modules/mavlink`: its modes here, its commands, its offboard control, its failsafes and its parameters beside.

mod commands;
mod failsafe;
mod feasibility;
mod geofence;
pub(super) mod messages;
mod mission_items;
mod offboard;
mod parameters;
mod params;
mod preflight;

pub(super) use commands::commanded_mode;
pub(crate) use failsafe::Failsafe;
pub(in crate::firmware) use feasibility::check as check_mission;
pub(crate) use geofence::area as fence_area;
pub(in crate::firmware) use mission_items::check as check_item;
pub(super) use parameters::{ABSENT_PARAMETERS, OWN_PARAMETERS, parameter};
pub(super) use preflight::answer_by_number;

use crate::mode::Mode;
use mavlink_bridge::dialect::MavModeFlag;
use std::time::Duration;

/// The version whose names and answers the vehicle has.
pub(super) const VERSION: [u8; 3] = [1, 18, 0];

/// What a PX4 has to remember beside what every vehicle does; vehicle times.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct State {
    /// When the last setpoint came that counts for the offboard stream.
    pub setpoint_heard: Option<Duration>,
    /// When the last heartbeat of a ground station came.
    pub ground_heard: Option<Duration>,
    /// What the vehicle does by itself for want of somebody.
    pub failsafe: Option<Failsafe>,
    pub was_armed: bool,
    /// The altitude of a take-off that it was told of before it was armed, m above the origin.
    pub takeoff_altitude_m: Option<f64>,
    /// The mode that it is in again when a landing has disarmed it: the last one that can be armed in.
    pub mode_to_restore: Option<Mode>,
    /// When it was armed on the ground and has not yet flown.
    pub armed_at: Option<Duration>,
    /// What is being calibrated.
    pub calibration: Option<preflight::Calibration>,
}

/// A mode's main and sub number, and PX4's name of it (`px4_custom_mode.h`, `lib/modes/ui.hpp`).
const MODES: [(Mode, u8, u8, &str); 12] = [
    (Mode::Manual, 1, 0, "Manual"),
    (Mode::Fbwb, 2, 0, "Altitude"),
    (Mode::Cruise, 3, 0, "Position"),
    (Mode::Takeoff, 4, 2, "Takeoff"),
    (Mode::Loiter, 4, 3, "Hold"),
    (Mode::Auto, 4, 4, "Mission"),
    (Mode::Rtl, 4, 5, "Return"),
    (Mode::Land, 4, 6, "Land"),
    (Mode::Course, 4, 19, "Guided Course"),
    (Mode::Offboard, 6, 0, "Offboard"),
    (Mode::Stabilize, 7, 0, "Stabilized"),
    (Mode::Circle, 3, 1, "Orbit"),
];

/// The modes that a client can set.
pub(super) const SELECTABLE: [Mode; 11] = [
    Mode::Manual,
    Mode::Fbwb,
    Mode::Cruise,
    Mode::Takeoff,
    Mode::Loiter,
    Mode::Auto,
    Mode::Rtl,
    Mode::Land,
    Mode::Course,
    Mode::Offboard,
    Mode::Stabilize,
];

/// The number in HEARTBEAT.custom_mode: main mode in bits 16 to 23, sub mode above.
pub(super) fn custom_mode(mode: Mode) -> u32 {
    let (_, main, sub, _) = row(mode);
    u32::from(main) << 16 | u32::from(sub) << 24
}

pub(super) fn mode_name(mode: Mode) -> &'static str {
    row(mode).3
}

/// The flags of HEARTBEAT. An autonomous mode is not guided by hand, and Offboard is none of PX4's own.
pub(super) fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    if mode.is_manual() {
        flags |= MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED;
    } else if mode != Mode::Offboard {
        flags |= MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED | MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED;
    }
    flags.set(MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED, mode != Mode::Manual);
    flags.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, armed);
    flags
}

/// A mode that PX4 does not have is its nearest.
fn row(mode: Mode) -> (Mode, u8, u8, &'static str) {
    let nearest = match mode {
        Mode::Fbwa => Mode::Stabilize,
        Mode::Guided => Mode::Loiter,
        other => other,
    };
    MODES.into_iter().find(|(known, ..)| *known == nearest).unwrap_or(MODES[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_flags_are_px4s() {
        assert_eq!(custom_mode(Mode::Course), 0x1304_0000);
        assert_eq!(custom_mode(Mode::Offboard), 6 << 16);
        assert_eq!((custom_mode(Mode::Guided), mode_name(Mode::Guided)), (0x0304_0000, "Hold"));
        // 157: custom, guided, auto, stabilised, armed; 209: manual with attitude control.
        assert_eq!(base_mode(Mode::Loiter, true).bits(), 157);
        assert_eq!(base_mode(Mode::Cruise, true).bits(), 209);
        assert_eq!(base_mode(Mode::Manual, false).bits(), 65);
    }
}
