//! HEARTBEAT.

// Clients still request messages that the dialect marks as superseded.
#![allow(deprecated)]

use crate::dialect::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType, Message};

/// HEARTBEAT (<https://mavlink.io/en/messages/common.html#HEARTBEAT>).
pub fn heartbeat(
    kind: MavType,
    autopilot: MavAutopilot,
    base_mode: MavModeFlag,
    custom_mode: u32,
    status: MavState,
) -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode,
        mavtype: kind,
        autopilot,
        base_mode,
        system_status: status,
        mavlink_version: 3,
    })
}

/// Whether a heartbeat is that of an autopilot, not of a ground station or of a part of a vehicle.
pub fn is_autopilot(heartbeat: &HEARTBEAT_DATA) -> bool {
    heartbeat.autopilot != MavAutopilot::MAV_AUTOPILOT_INVALID
        && !matches!(
            heartbeat.mavtype,
            MavType::MAV_TYPE_GCS
                | MavType::MAV_TYPE_ONBOARD_CONTROLLER
                | MavType::MAV_TYPE_GIMBAL
                | MavType::MAV_TYPE_ADSB
        )
}

/// HEARTBEAT of a ground station.
pub fn ground_heartbeat() -> Message {
    heartbeat(
        MavType::MAV_TYPE_GCS,
        MavAutopilot::MAV_AUTOPILOT_INVALID,
        MavModeFlag::empty(),
        0,
        MavState::MAV_STATE_ACTIVE,
    )
}
