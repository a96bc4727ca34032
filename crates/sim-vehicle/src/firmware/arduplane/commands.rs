//! What an ArduPlane answers where it asks more of a command than `protocol/command` does (`handle_command_int_packet` of
//! GCS_Common.cpp and GCS_MAVLink_Plane.cpp).

// Clients still speak what the dialect calls superseded, and autopilots answer.
#![allow(deprecated)]

use super::devices;
use crate::error::CommandError;
use crate::protocol::command::request::Command;
use mavlink_bridge::CommandPosition;
use mavlink_bridge::dialect::{MavCmd, MavFrame};

/// The answer; none if it is that of every vehicle.
pub(in crate::firmware) fn execute(command: &Command) -> Option<Result<(), CommandError>> {
    let is_int = matches!(command.position, CommandPosition::Int(_));
    match command.command {
        // A COMMAND_LONG becomes one in the frame that is asked for. Only a quadplane takes off.
        MavCmd::MAV_CMD_NAV_TAKEOFF if is_int && command.frame != MavFrame::MAV_FRAME_LOCAL_OFFSET_NED as u8 => {
            Some(Err(CommandError::denied("Takeoff: the frame must be LOCAL_OFFSET_NED")))
        }
        MavCmd::MAV_CMD_EXTERNAL_POSITION_ESTIMATE if is_int => Some(external_position(command)),
        MavCmd::MAV_CMD_DO_SET_GLOBAL_ORIGIN if is_int && command.z.is_nan() => {
            Some(Err(CommandError::denied("Origin: no such place")))
        }
        // It has one already, the scenario's.
        MavCmd::MAV_CMD_DO_SET_GLOBAL_ORIGIN if is_int => Some(Err(CommandError::failed("Origin: it is set"))),
        // The answer of one that the dialect does not know any more.
        MavCmd::MAV_CMD_REQUEST_PROTOCOL_VERSION if command.params[0] != 1.0 => Some(Err(CommandError::unsupported())),
        _ => devices::answer(command.command as u32 as u16, command.params),
    }
}

/// A place above sea level without an altitude. With a GPS it is not needed.
fn external_position(command: &Command) -> Result<(), CommandError> {
    // GLOBAL and GLOBAL_INT.
    if !matches!(command.frame, 0 | 5) || !command.z.is_nan() {
        return Err(CommandError::denied("Position: frame GLOBAL, and no altitude"));
    }
    Err(CommandError::failed("Position: the GPS knows it better"))
}
