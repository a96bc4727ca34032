//! The command protocol on the wire (<https://mavlink.io/en/services/command.html>): COMMAND_INT, COMMAND_LONG and
//! COMMAND_ACK.
//!
//! A command is read from the frame itself: a number that is not in the dialect gives no message, yet its sender waits
//! for an acknowledgement.

use crate::coordinates::{LatLonE7, mav_frame};
use crate::dialect::{COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, MavFrame, MavResult};
use crate::{Encoder, Frame, Target};
use mavlink::MessageData;

/// A command, numbers as on the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Its number (MAV_CMD), in the dialect or not.
    pub number: u16,
    /// Params 1 to 4.
    pub params: [f32; 4],
    /// Params 5 and 6: for most commands latitude and longitude.
    pub position: CommandPosition,
    /// Param 7: for most commands an altitude, m, from the datum of the frame.
    pub z: f32,
    /// MAV_FRAME of a COMMAND_INT, in the dialect or not. A COMMAND_LONG has none.
    pub frame: Option<u8>,
}

/// Params 5 and 6 of a command, by the message that carried it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommandPosition {
    /// x and y of a COMMAND_INT: latitude and longitude in 1e-7 degrees, where the command has a position.
    Int(LatLonE7),
    /// Params 5 and 6 of a COMMAND_LONG: latitude and longitude in degrees, where the command has a position.
    Long([f32; 2]),
}

/// The name of a result as people say it: ACCEPTED, TEMPORARILY_REJECTED.
pub fn result_name(result: MavResult) -> String {
    format!("{result:?}").replace("MAV_RESULT_", "")
}

impl Command {
    /// The command; none if it is not in the dialect.
    pub fn mav_cmd(&self) -> Option<MavCmd> {
        num_traits::FromPrimitive::from_u16(self.number)
    }

    /// The coordinate frame of a COMMAND_INT; none if it is not in the dialect, and for a COMMAND_LONG.
    pub fn mav_frame(&self) -> Option<MavFrame> {
        self.frame.and_then(mav_frame)
    }
}

/// The command in a frame and its target; none if the frame is no command.
pub(crate) fn command(frame: &Frame<'_>) -> Option<(Target, Command)> {
    // Both messages have seven four-byte fields first, then the command and its target.
    let four = |field: usize| -> [u8; 4] { std::array::from_fn(|byte| frame.payload_byte(4 * field + byte)) };
    let float = |field: usize| f32::from_le_bytes(four(field));
    let int = |field: usize| i32::from_le_bytes(four(field));
    let (position, coordinate_frame) = match frame.header.message_id {
        COMMAND_INT_DATA::ID => (CommandPosition::Int(LatLonE7::new(int(4), int(5))), Some(frame.payload_byte(32))),
        COMMAND_LONG_DATA::ID => (CommandPosition::Long([float(4), float(5)]), None),
        _ => return None,
    };
    let command = Command {
        number: u16::from_le_bytes([frame.payload_byte(28), frame.payload_byte(29)]),
        params: std::array::from_fn(float),
        position,
        z: float(6),
        frame: coordinate_frame,
    };
    Some((frame.target_at(30), command))
}

impl Encoder {
    /// Appends a COMMAND_ACK for a command by its number, which the dialect need not know
    /// (<https://mavlink.io/en/messages/common.html#COMMAND_ACK>).
    pub fn encode_command_ack(&mut self, command: u16, result: MavResult, target: Target, out: &mut Vec<u8>) {
        let [low, high] = command.to_le_bytes();
        let fields = [low, high, result as u8, 0, 0, 0, 0, 0, target.system_id, target.component_id];
        self.write_fields(COMMAND_ACK_DATA::ID, &fields, 3, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::Message;
    use crate::telemetry::ground_heartbeat;
    use crate::{Counters, FrameError, Version, frames};
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
                param5: 0.5,
                param7: 100.0,
                ..COMMAND_LONG_DATA::DEFAULT
            });
            let mut bytes = Vec::new();
            Encoder::new(255, 190).with_version(version).encode(&long, &mut bytes);
            let bytes = with_command(&bytes, 60_000, COMMAND_LONG_DATA::EXTRA_CRC);
            let frame = only_frame(&bytes);
            assert_eq!(frame.message(), Err(FrameError::InvalidValue { enum_type: "MavCmd", value: 60_000 }));
            let expected = Command {
                number: 60_000,
                params: [0.0, -2.5, 0.0, 0.0],
                position: CommandPosition::Long([0.5, 0.0]),
                z: 100.0,
                frame: None,
            };
            let (target, read) = command(&frame).unwrap();
            assert_eq!((target, read), (Target { system_id: 7, component_id: 1 }, expected));
            assert_eq!((read.mav_cmd(), read.mav_frame()), (None, None));
        }
    }

    #[test]
    fn what_is_no_command_gives_none() {
        let mut bytes = Vec::new();
        Encoder::new(1, 1).encode(&ground_heartbeat(), &mut bytes);
        assert_eq!(command(&only_frame(&bytes)), None);
    }

    proptest! {
        #[test]
        fn a_command_survives_the_wire(
            system in any::<u8>(), component in any::<u8>(), v1 in any::<bool>(),
            p1 in any::<f32>(), x in any::<i32>(), z in any::<f32>(),
        ) {
            // All zeros behind the command: MAVLink 2 leaves them out.
            let int = Message::COMMAND_INT(COMMAND_INT_DATA {
                param1: p1,
                x,
                z,
                command: MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING,
                target_system: system,
                target_component: component,
                frame: MavFrame::MAV_FRAME_GLOBAL,
                ..COMMAND_INT_DATA::DEFAULT
            });
            let mut bytes = Vec::new();
            Encoder::new(1, 1).with_version(if v1 { Version::V1 } else { Version::V2 }).encode(&int, &mut bytes);
            let (target, read) = command(&only_frame(&bytes)).unwrap();
            prop_assert_eq!(target, Target { system_id: system, component_id: component });
            // By their bits: a param may be no number.
            prop_assert_eq!(read.params.map(f32::to_bits), [p1, 0.0, 0.0, 0.0].map(f32::to_bits));
            prop_assert_eq!(read.z.to_bits(), z.to_bits());
            prop_assert_eq!((read.number, read.frame), (43002, Some(0)));
            prop_assert_eq!(read.position, CommandPosition::Int(LatLonE7::new(x, 0)));
            prop_assert_eq!(read.mav_cmd(), Some(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING));
            prop_assert_eq!(read.mav_frame(), Some(MavFrame::MAV_FRAME_GLOBAL));
        }

        #[test]
        fn an_answer_by_number_is_what_the_dialect_would_write(
            system in any::<u8>(), component in any::<u8>(), v1 in any::<bool>(),
        ) {
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
            Encoder::new(9, 1).with_version(version).encode_command_ack(
                43000, MavResult::MAV_RESULT_UNSUPPORTED, target, &mut by_hand,
            );
            prop_assert_eq!(by_hand, by_dialect);
        }
    }
}
