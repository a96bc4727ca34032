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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawCommand {
    /// System that it is for, 0 for all.
    pub target_system: u8,
    /// Component that it is for, 0 for all.
    pub target_component: u8,
    /// Its number (MAV_CMD).
    pub command: u16,
    /// Params 1 to 4.
    pub params: [f32; 4],
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
    let params = std::array::from_fn(|param| {
        f32::from_le_bytes(std::array::from_fn(|byte| frame.payload_byte(4 * param + byte)))
    });
    Some(RawCommand { target_system: system_id, target_component: component_id, command, params, kind })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::{MavCmd, MavFrame, MavResult, Message};
    use crate::telemetry::ground_heartbeat;
    use crate::{Counters, Encoder, FrameError, Version, frames};
    use proptest::prelude::*;

    fn only_frame(bytes: &[u8]) -> Frame<'_> {
        let frames: Vec<_> = frames(bytes, &mut Counters::default()).collect();
        assert_eq!(frames.len(), 1);
        frames[0]
    }

    /// The same frame with another command in it, as a sender with a newer dialect would write it.
    fn with_command(bytes: &[u8], command: u16, extra: u8) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        let payload_start = if bytes[0] == 0xFD { 10 } else { 6 };
        bytes[payload_start + 28..payload_start + 30].copy_from_slice(&command.to_le_bytes());
        let end = bytes.len() - 2;
        let crc = crate::frame::checksum(&bytes[1..end], extra).to_le_bytes();
        bytes[end..].copy_from_slice(&crc);
        bytes
    }

    #[test]
    fn a_command_that_is_not_in_the_dialect_is_still_read() {
        for version in [Version::V1, Version::V2] {
            let long = Message::COMMAND_LONG(COMMAND_LONG_DATA {
                command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
                target_system: 7,
                target_component: 1,
                confirmation: 1,
                param2: -2.5,
                ..COMMAND_LONG_DATA::DEFAULT
            });
            let mut bytes = Vec::new();
            Encoder::new(255, 190).with_version(version).encode(&long, &mut bytes);
            let bytes = with_command(&bytes, 60_000, COMMAND_LONG_DATA::EXTRA_CRC);
            let frame = only_frame(&bytes);
            assert_eq!(frame.message(), Err(FrameError::InvalidValue { enum_type: "MavCmd", value: 60_000 }));
            let expected = RawCommand {
                target_system: 7,
                target_component: 1,
                command: 60_000,
                params: [0.0, -2.5, 0.0, 0.0],
                kind: CommandKind::Long,
            };
            assert_eq!(raw_command(&frame), Some(expected));
        }
    }

    #[test]
    fn what_is_no_command_gives_none() {
        let mut bytes = Vec::new();
        Encoder::new(1, 1).encode(&ground_heartbeat(), &mut bytes);
        assert_eq!(raw_command(&only_frame(&bytes)), None);
    }

    proptest! {
        #[test]
        fn the_raw_command_is_the_command(system in any::<u8>(), component in any::<u8>(), v1 in any::<bool>(), x in any::<f32>()) {
            // All zeros behind the command: MAVLink 2 leaves them out.
            let int = Message::COMMAND_INT(COMMAND_INT_DATA {
                param1: x,
                command: MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING,
                target_system: system,
                target_component: component,
                frame: MavFrame::MAV_FRAME_GLOBAL,
                ..COMMAND_INT_DATA::DEFAULT
            });
            let mut bytes = Vec::new();
            Encoder::new(1, 1).with_version(if v1 { Version::V1 } else { Version::V2 }).encode(&int, &mut bytes);
            let expected = RawCommand {
                target_system: system,
                target_component: component,
                command: 43002,
                params: [0.0; 4],
                kind: CommandKind::Int,
            };
            let raw = raw_command(&only_frame(&bytes)).unwrap();
            // By their bits: a param may be no number.
            prop_assert_eq!(raw.params.map(f32::to_bits), [x, 0.0, 0.0, 0.0].map(f32::to_bits));
            prop_assert_eq!(RawCommand { params: [0.0; 4], ..raw }, expected);
        }

        #[test]
        fn a_raw_answer_is_what_the_dialect_would_write(system in any::<u8>(), component in any::<u8>(), v1 in any::<bool>()) {
            use crate::dialect::COMMAND_ACK_DATA;
            let version = if v1 { Version::V1 } else { Version::V2 };
            let target = Target { system_id: system, component_id: component };
            let ack = Message::COMMAND_ACK(COMMAND_ACK_DATA {
                command: MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED,
                result: MavResult::MAV_RESULT_UNSUPPORTED,
                target_system: system,
                target_component: component,
                ..COMMAND_ACK_DATA::DEFAULT
            });
            let (mut by_hand, mut by_dialect) = (Vec::new(), Vec::new());
            Encoder::new(9, 1).with_version(version).encode(&ack, &mut by_dialect);
            Encoder::new(9, 1).with_version(version).encode_command_ack_raw(
                43000, MavResult::MAV_RESULT_UNSUPPORTED, target, &mut by_hand,
            );
            prop_assert_eq!(by_hand, by_dialect);
        }
    }
}
