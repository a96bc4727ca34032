//! Commands by their number.
//!
//! A COMMAND_INT or COMMAND_LONG whose command is not in the dialect gives no message, yet its sender waits for an
//! answer: what the answer needs is read from the frame here.

use crate::dialect::{COMMAND_INT_DATA, COMMAND_LONG_DATA};
use crate::{Frame, Target};
use mavlink::MessageData;

/// Which message carried a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandKind {
    /// COMMAND_INT.
    Int,
    /// COMMAND_LONG.
    Long,
}

/// A command whose number may not be in the dialect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawCommand {
    /// System that it is for, 0 for all.
    pub target_system: u8,
    /// Component that it is for, 0 for all.
    pub target_component: u8,
    /// Its number (MAV_CMD).
    pub command: u16,
    /// The message that carried it.
    pub kind: CommandKind,
}

/// The command in a frame; none if the frame is no command.
pub fn raw_command(frame: &Frame<'_>) -> Option<RawCommand> {
    let kind = match frame.header.message_id {
        COMMAND_INT_DATA::ID => CommandKind::Int,
        COMMAND_LONG_DATA::ID => CommandKind::Long,
        _ => return None,
    };
    // Both messages have seven four-byte fields first, then the command and its target.
    let command = u16::from_le_bytes([frame.payload_byte(28), frame.payload_byte(29)]);
    let Target { system_id, component_id } = frame.target_at(30);
    Some(RawCommand { target_system: system_id, target_component: component_id, command, kind })
}
