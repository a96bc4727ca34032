//! PX4's modes: their numbers, names and flags (`px4_custom_mode.h`, `lib/modes/ui.hpp`).

use crate::mode::Mode;
use mavlink_bridge::dialect::MavModeFlag;

/// A mode's main and sub number, and PX4's name of it (`px4_custom_mode.h`, `lib/modes/ui.hpp`).
pub(super) const MODES: [(Mode, u8, u8, &str); 13] = [
    (Mode::Manual, 1, 0, "Manual"),
    (Mode::Fbwb, 2, 0, "Altitude"),
    (Mode::Cruise, 3, 0, "Position"),
    (Mode::Takeoff, 4, 2, "Takeoff"),
    (Mode::Loiter, 4, 3, "Hold"),
    (Mode::Auto, 4, 4, "Mission"),
    (Mode::Rtl, 4, 5, "Return"),
    (Mode::Land, 4, 6, "Land"),
    (Mode::Course, 4, 19, "Guided Course"),
    // The sticks' rates, which these vehicles fly as a bank.
    (Mode::Acro, 5, 0, "Acro"),
    (Mode::Offboard, 6, 0, "Offboard"),
    (Mode::Stabilize, 7, 0, "Stabilized"),
    (Mode::Circle, 3, 1, "Orbit"),
];

/// The modes that a client can set.
pub(super) const SELECTABLE: [Mode; 12] = [
    Mode::Manual,
    Mode::Fbwb,
    Mode::Cruise,
    Mode::Takeoff,
    Mode::Loiter,
    Mode::Auto,
    Mode::Rtl,
    Mode::Land,
    Mode::Course,
    Mode::Acro,
    Mode::Offboard,
    Mode::Stabilize,
];

/// The number in HEARTBEAT.custom_mode: main mode in bits 16 to 23, sub mode above.
pub(in crate::firmware) fn custom_mode(mode: Mode) -> u32 {
    let (_, main, sub, _) = row(mode);
    u32::from(main) << 16 | u32::from(sub) << 24
}

pub(in crate::firmware) fn mode_name(mode: Mode) -> &'static str {
    row(mode).3
}

/// The flags of HEARTBEAT. An autonomous mode is not guided by hand, and Offboard is none of PX4's own.
pub(in crate::firmware) fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
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
