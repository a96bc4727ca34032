//! ArduPlane. Its modes are those of [`Mode`](crate::Mode), and its answers those of `protocol/command/`.

mod commands;
pub(super) mod devices;
pub(super) mod messages;
#[cfg(test)]
mod page;
mod targets;

use crate::mode::Mode;
use mavlink_bridge::dialect::MavModeFlag;

/// The version whose names and answers the vehicle has.
pub(super) const VERSION: [u8; 3] = [4, 7, 0];

/// The flags that ArduPlane sets: 217 in GUIDED when armed, 209 in CRUISE and MANUAL, 81 in MANUAL when not.
pub(super) fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED;
    if !matches!(mode, Mode::Manual | Mode::Stabilize | Mode::Fbwa | Mode::Fbwb | Mode::Cruise) {
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
