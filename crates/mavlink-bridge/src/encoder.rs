//! From messages to frames.

use crate::Version;
use crate::dialect::{DialectMessage, Message};
use crate::frame::{CHECKSUM, V1_HEADER, V1_START, V2_HEADER, V2_START, checksum, checksum_extra};
use mavlink::MavlinkVersion;

/// Writes the frames of one sender, and counts their sequence number.
///
/// ```
/// use mavlink_bridge::telemetry::ground_heartbeat;
/// use mavlink_bridge::{Counters, Encoder, Version, frames};
///
/// // A ground station that speaks MAVLink 1. Several frames fit into one datagram.
/// let mut encoder = Encoder::new(255, 190).with_version(Version::V1);
/// let mut datagram = Vec::new();
/// encoder.encode(&ground_heartbeat(), &mut datagram);
/// encoder.encode(&ground_heartbeat(), &mut datagram);
///
/// let sequence: Vec<u8> = frames(&datagram, &mut Counters::default()).map(|frame| frame.header.sequence).collect();
/// assert_eq!(sequence, [0, 1]);
/// ```
#[derive(Clone, Debug)]
pub struct Encoder {
    /// System id of the sender.
    pub system_id: u8,
    /// Component id of the sender.
    pub component_id: u8,
    /// Version to write. A message with an id above 255, which MAVLink 1 cannot carry, is written as MAVLink 2 in any
    /// case: a peer that knows only MAVLink 1 skips it.
    pub version: Version,
    sequence: u8,
}

/// The longest payload.
const PAYLOAD_MAX: usize = 255;

impl Encoder {
    /// An encoder that writes MAVLink 2.
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self { system_id, component_id, version: Version::V2, sequence: 0 }
    }

    /// The same encoder, writing `version`.
    pub fn with_version(mut self, version: Version) -> Self {
        self.version = version;
        self
    }

    /// Appends `message` to `out` as one frame.
    pub fn encode(&mut self, message: &Message, out: &mut Vec<u8>) {
        self.write_frame(message.message_id(), out, |version, payload| message.ser(version, payload));
    }

    /// Appends a frame from the bytes of its fields, of which MAVLink 1 has the first `v1_length`.
    pub(crate) fn write_fields(&mut self, id: u32, fields: &[u8], v1_length: usize, out: &mut Vec<u8>) {
        self.write_frame(id, out, |version, payload| {
            payload[..fields.len()].copy_from_slice(fields);
            match version {
                MavlinkVersion::V1 => v1_length,
                MavlinkVersion::V2 => mavlink::utils::remove_trailing_zeroes(fields),
            }
        });
    }

    fn write_frame(&mut self, id: u32, out: &mut Vec<u8>, write: impl FnOnce(MavlinkVersion, &mut [u8]) -> usize) {
        let start = out.len();
        let [id_0, id_1, id_2, _] = id.to_le_bytes();
        let sender = [self.sequence, self.system_id, self.component_id];
        let version = match self.version {
            Version::V1 if id <= 255 => MavlinkVersion::V1,
            _ => MavlinkVersion::V2,
        };
        let header_length = match version {
            MavlinkVersion::V1 => {
                out.extend_from_slice(&[V1_START, 0, sender[0], sender[1], sender[2], id_0]);
                V1_HEADER
            }
            MavlinkVersion::V2 => {
                out.extend_from_slice(&[V2_START, 0, 0, 0, sender[0], sender[1], sender[2], id_0, id_1, id_2]);
                V2_HEADER
            }
        };
        let payload_start = start + header_length;
        out.resize(payload_start + PAYLOAD_MAX, 0);
        let length = write(version, &mut out[payload_start..]).min(PAYLOAD_MAX);
        out.truncate(payload_start + length);
        out[start + 1] = length as u8;
        let crc = checksum(&out[start + 1..], checksum_extra(id).unwrap_or(0));
        out.reserve(CHECKSUM);
        out.extend_from_slice(&crc.to_le_bytes());
        self.sequence = self.sequence.wrapping_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Frame;
    use crate::telemetry::ground_heartbeat;

    #[test]
    fn sequence_numbers_run_on_and_wrap() {
        let mut encoder = Encoder::new(1, 1);
        for expected in (0..=255).chain(0..3) {
            let mut bytes = Vec::new();
            encoder.encode(&ground_heartbeat(), &mut bytes);
            assert_eq!(Frame::parse(&bytes).unwrap().header.sequence, expected);
        }
    }

    #[test]
    fn what_mavlink_1_cannot_carry_goes_as_mavlink_2() {
        let message = Message::default_message_from_id(395).unwrap();
        let mut bytes = Vec::new();
        Encoder::new(1, 1).with_version(Version::V1).encode(&message, &mut bytes);
        let frame = Frame::parse(&bytes).unwrap();
        assert_eq!((frame.header.version, frame.header.message_id), (Version::V2, 395));
        assert_eq!(frame.message(), Ok(message));
    }

    #[test]
    fn frames_are_appended() {
        let mut out = b"before".to_vec();
        Encoder::new(1, 1).encode(&ground_heartbeat(), &mut out);
        assert!(out.starts_with(b"before"));
        assert!(Frame::parse(&out[6..]).is_ok_and(|frame| frame.bytes.len() == out.len() - 6));
    }
}
