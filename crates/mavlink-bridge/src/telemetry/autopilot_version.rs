//! AUTOPILOT_VERSION, PROTOCOL_VERSION and EXTENDED_SYS_STATE.

// Clients still request messages that the dialect marks as superseded.
#![allow(deprecated)]

use crate::dialect::{
    AUTOPILOT_VERSION_DATA, EXTENDED_SYS_STATE_DATA, MavLandedState, MavProtocolCapability, MavVtolState, Message,
    PROTOCOL_VERSION_DATA,
};

/// AUTOPILOT_VERSION: a released version of the flight software, what it can do, and a number that tells one vehicle
/// from another (<https://mavlink.io/en/messages/common.html#AUTOPILOT_VERSION>).
pub fn autopilot_version([major, minor, patch]: [u8; 3], capabilities: MavProtocolCapability, uid: u64) -> Message {
    const RELEASED: u8 = 255;
    Message::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
        capabilities,
        uid,
        flight_sw_version: u32::from_be_bytes([major, minor, patch, RELEASED]),
        ..AUTOPILOT_VERSION_DATA::DEFAULT
    })
}

/// PROTOCOL_VERSION: MAVLink 2, and MAVLink 1 for peers that speak it
/// (<https://mavlink.io/en/messages/common.html#PROTOCOL_VERSION>).
pub fn protocol_version() -> Message {
    Message::PROTOCOL_VERSION(PROTOCOL_VERSION_DATA {
        version: 200,
        min_version: 100,
        max_version: 200,
        ..PROTOCOL_VERSION_DATA::DEFAULT
    })
}

/// EXTENDED_SYS_STATE of an aeroplane (<https://mavlink.io/en/messages/common.html#EXTENDED_SYS_STATE>).
pub fn extended_sys_state(landed_state: MavLandedState) -> Message {
    Message::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
        vtol_state: MavVtolState::MAV_VTOL_STATE_UNDEFINED,
        landed_state,
    })
}
