//! One frame, MAVLink 1 or 2 (<https://mavlink.io/en/guide/serialization.html>).

use crate::dialect::{DialectMessage, Message};
use crate::{Target, dialects};
use mavlink::MavlinkVersion;
use mavlink::error::ParserError;

/// Protocol version of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Version {
    /// MAVLink 1: message ids to 255, no truncation, no signature.
    V1,
    /// MAVLink 2.
    #[default]
    V2,
}

/// The header of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// System id of the sender.
    pub system_id: u8,
    /// Component id of the sender.
    pub component_id: u8,
    /// Sequence number, one more for each frame of this sender.
    pub sequence: u8,
    /// Message id.
    pub message_id: u32,
    /// Protocol version.
    pub version: Version,
}

/// One frame, where it lies in its datagram.
///
/// ```
/// use mavlink_bridge::telemetry::ground_heartbeat;
/// use mavlink_bridge::{Encoder, Frame, FrameError};
///
/// let mut bytes = Vec::new();
/// Encoder::new(255, 190).encode(&ground_heartbeat(), &mut bytes);
/// let frame = Frame::parse(&bytes)?;
/// assert_eq!((frame.header.system_id, frame.header.component_id), (255, 190));
/// assert_eq!(frame.message()?, ground_heartbeat());
///
/// bytes[12] ^= 1;
/// assert_eq!(Frame::parse(&bytes), Err(FrameError::BadChecksum));
/// # Ok::<(), FrameError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Its header.
    pub header: Header,
    /// The whole frame as on the wire, from the start byte to the checksum or signature.
    pub bytes: &'a [u8],
}

/// Why a frame gives no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// The message id is not in the dialect.
    #[error("message id {0} is not in the dialect")]
    UnknownMessage(u32),
    /// A field holds a value that its enum does not have.
    #[error("{enum_type} has no value {value}")]
    InvalidValue {
        /// The name of the enum.
        enum_type: &'static str,
        /// The value in the field.
        value: u64,
    },
    /// The bytes are no whole frame.
    #[error("the bytes are no whole frame")]
    Malformed,
    /// The checksum is wrong.
    #[error("the checksum is wrong")]
    BadChecksum,
    /// The frame has incompatibility flags that we do not understand.
    #[error("incompatibility flags {0:#04x} are not understood")]
    IncompatibleFlags(u8),
}

impl<'a> Frame<'a> {
    /// The frame at the start of `bytes`; bytes behind it are ignored.
    ///
    /// # Errors
    /// The bytes are not a whole frame, its message id is unknown, its checksum is wrong, or it has incompatibility
    /// flags that are not understood.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let candidate = Candidate::at_start_of(bytes).ok_or(FrameError::Malformed)?;
        candidate.verify()?;
        Ok(candidate.frame)
    }

    /// The payload, without the zeros that MAVLink 2 leaves out at its end.
    pub fn payload(&self) -> &'a [u8] {
        let (header_length, trailer_length) = match self.header.version {
            Version::V1 => (V1_HEADER, CHECKSUM),
            Version::V2 => (V2_HEADER, CHECKSUM + signature_length(self.bytes.get(2).copied().unwrap_or(0))),
        };
        let end = self.bytes.len().saturating_sub(trailer_length);
        self.bytes.get(header_length..end).unwrap_or(&[])
    }

    /// The message in the frame.
    ///
    /// # Errors
    /// The message id is not in the dialect, or a field holds a value that its enum does not have.
    pub fn message(&self) -> Result<Message, FrameError> {
        let version = match self.header.version {
            Version::V1 => MavlinkVersion::V1,
            Version::V2 => MavlinkVersion::V2,
        };
        Message::parse(version, self.header.message_id, self.payload()).map_err(|error| match error {
            ParserError::InvalidEnum { enum_type, value } => FrameError::InvalidValue { enum_type, value },
            ParserError::UnknownMessage { id } => FrameError::UnknownMessage(id),
            ParserError::InvalidPayloadSize { .. } | ParserError::BytesError(_) => FrameError::Malformed,
        })
    }
}

pub(crate) const V1_START: u8 = 0xFE;
pub(crate) const V2_START: u8 = 0xFD;
pub(crate) const V1_HEADER: usize = 6;
pub(crate) const V2_HEADER: usize = 10;
pub(crate) const CHECKSUM: usize = 2;
pub(crate) const SIGNATURE: usize = 13;
/// The incompatibility flag of a signed frame, MAVLINK_IFLAG_SIGNED.
pub(crate) const SIGNED: u8 = 0x01;

/// Checksum of a frame's bytes between its start byte and its checksum (CRC-16/MCRF4XX, with CRC_EXTRA).
pub(crate) fn checksum(covered: &[u8], extra: u8) -> u16 {
    mavlink::calculate_crc(covered, extra)
}

/// CRC_EXTRA of a message id, none if no dialect has it.
pub(crate) fn checksum_extra(message_id: u32) -> Option<u8> {
    match Message::extra_crc(message_id) {
        // The crate says 0 for ids that it does not know, and one message has 0 by chance.
        0 => Message::default_message_from_id(message_id).map(|_| 0).or_else(|| dialects::checksum_extra(message_id)),
        extra => Some(extra),
    }
}

/// Whether a frame may start with `byte`.
pub(crate) fn is_start_byte(byte: u8) -> bool {
    byte == V1_START || byte == V2_START
}

fn signature_length(incompatibility_flags: u8) -> usize {
    if incompatibility_flags & SIGNED == 0 { 0 } else { SIGNATURE }
}

/// Bytes that have the shape of a frame: a start byte, a header, and the length that the header says.
pub(crate) struct Candidate<'a> {
    pub(crate) frame: Frame<'a>,
    incompatibility_flags: u8,
}

impl<'a> Candidate<'a> {
    pub(crate) fn at_start_of(bytes: &'a [u8]) -> Option<Self> {
        let (header, incompatibility_flags) = match *bytes {
            [V1_START, _, sequence, system_id, component_id, message_id, ..] => {
                let message_id = u32::from(message_id);
                let header = Header { system_id, component_id, sequence, message_id, version: Version::V1 };
                (header, 0)
            }
            [V2_START, _, flags, _, sequence, system_id, component_id, id_0, id_1, id_2, ..] => {
                let message_id = u32::from_le_bytes([id_0, id_1, id_2, 0]);
                let header = Header { system_id, component_id, sequence, message_id, version: Version::V2 };
                (header, flags)
            }
            _ => return None,
        };
        let length = Frame::length(*bytes.first()?, *bytes.get(1)?, incompatibility_flags)?;
        let frame = Frame { header, bytes: bytes.get(..length)? };
        Some(Self { frame, incompatibility_flags })
    }

    pub(crate) fn verify(&self) -> Result<(), FrameError> {
        let unknown_flags = self.incompatibility_flags & !SIGNED;
        if unknown_flags != 0 {
            return Err(FrameError::IncompatibleFlags(unknown_flags));
        }
        let id = self.frame.header.message_id;
        let extra = checksum_extra(id).ok_or(FrameError::UnknownMessage(id))?;
        let end = self.frame.bytes.len() - CHECKSUM - signature_length(self.incompatibility_flags);
        let (covered, trailer) = self.frame.bytes.split_at(end);
        let expected = checksum(&covered[1..], extra).to_le_bytes();
        if trailer.starts_with(&expected) { Ok(()) } else { Err(FrameError::BadChecksum) }
    }
}

impl Frame<'_> {
    /// Length of a frame in bytes by its first three; none if the first is no start byte.
    pub fn length(start: u8, payload_length: u8, incompatibility_flags: u8) -> Option<usize> {
        let payload_length = usize::from(payload_length);
        match start {
            V1_START => Some(V1_HEADER + payload_length + CHECKSUM),
            V2_START => Some(V2_HEADER + payload_length + CHECKSUM + signature_length(incompatibility_flags)),
            _ => None,
        }
    }

    /// The target in two bytes of the payload.
    pub(crate) fn target_at(&self, offset: usize) -> Target {
        Target { system_id: self.payload_byte(offset), component_id: self.payload_byte(offset + 1) }
    }

    /// A byte of the payload; zeros at its end are not sent.
    pub(crate) fn payload_byte(&self, offset: usize) -> u8 {
        self.payload().get(offset).copied().unwrap_or(0)
    }
}
