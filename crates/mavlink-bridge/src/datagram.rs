//! From a datagram to frames and messages.

use crate::frame::{CHECKSUM, Candidate, is_start_byte};
use crate::{Counters, Frame, FrameError, Message};

/// The frames of a datagram whose message ids we know and whose checksums are right; everything else is counted.
///
/// The datagram is searched from one start byte to the next. A whole frame with the right checksum is yielded, and the
/// search continues behind it. Signatures are accepted and not verified.
///
/// A frame with a wrong checksum may be two pieces of others: it is counted once, and what it covers is searched. The
/// length of a frame with an unknown id, or with flags that we do not understand, cannot be verified: such a frame is
/// counted and skipped as a whole if it ends at the end of the datagram or before another start byte, and does not
/// overlap a valid frame. Otherwise its start byte was garbage.
pub fn frames<'a, 'c>(datagram: &'a [u8], counters: &'c mut Counters) -> Frames<'a, 'c> {
    counters.datagrams = counters.datagrams.saturating_add(1);
    counters.bytes = counters.bytes.saturating_add(datagram.len() as u64);
    Frames { rest: datagram, suspect: 0, counters }
}

/// The frames of a datagram with their messages. Frames whose message cannot be read are yielded with the reason, and
/// counted as `invalid_value`, except those of other dialects, which are valid and not for us.
pub fn messages<'a>(
    datagram: &'a [u8],
    counters: &mut Counters,
) -> impl Iterator<Item = (Frame<'a>, Result<Message, FrameError>)> {
    let mut frames = frames(datagram, counters);
    std::iter::from_fn(move || {
        let frame = frames.next()?;
        let message = frame.message();
        if message.as_ref().is_err_and(|error| !matches!(error, FrameError::UnknownMessage(_))) {
            frames.counters.invalid_value = frames.counters.invalid_value.saturating_add(1);
        }
        Some((frame, message))
    })
}

/// See [`frames`].
#[derive(Debug)]
pub struct Frames<'a, 'c> {
    rest: &'a [u8],
    /// How many bytes of `rest` belong to a frame that has been counted as wrong.
    suspect: usize,
    counters: &'c mut Counters,
}

impl<'a> Iterator for Frames<'a, '_> {
    type Item = Frame<'a>;

    fn next(&mut self) -> Option<Frame<'a>> {
        loop {
            let garbage = self.rest.iter().position(|&byte| is_start_byte(byte)).unwrap_or(self.rest.len());
            self.skip_malformed(garbage);
            if self.rest.is_empty() {
                return None;
            }
            let Some(candidate) = Candidate::at_start_of(self.rest) else {
                self.skip_malformed(1);
                continue;
            };
            let length = candidate.frame.bytes.len();
            match candidate.verify() {
                Ok(()) => {
                    self.skip(length);
                    self.counters.frames = self.counters.frames.saturating_add(1);
                    return Some(candidate.frame);
                }
                Err(_) if self.suspect > 0 => self.skip_malformed(1),
                Err(FrameError::BadChecksum) => {
                    self.counters.bad_checksum = self.counters.bad_checksum.saturating_add(1);
                    self.suspect = length;
                    self.skip(1);
                }
                Err(_) if !stands_alone(self.rest, length) => self.skip_malformed(1),
                Err(reason) => {
                    let counter = match reason {
                        FrameError::IncompatibleFlags(_) => &mut self.counters.incompatible_flags,
                        _ => &mut self.counters.unknown_message,
                    };
                    *counter = counter.saturating_add(1);
                    self.skip(length);
                }
            }
        }
    }
}

impl Frames<'_, '_> {
    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest.get(bytes..).unwrap_or(&[]);
        self.suspect = self.suspect.saturating_sub(bytes);
    }

    fn skip_malformed(&mut self, bytes: usize) {
        let malformed = bytes.saturating_sub(self.suspect);
        self.counters.malformed_bytes = self.counters.malformed_bytes.saturating_add(malformed as u64);
        self.skip(bytes);
    }
}

/// Whether the first `length` of `bytes` may be a frame. A valid frame inside its payload does not matter; a valid
/// frame that reaches past its end shows that the length is wrong.
fn stands_alone(bytes: &[u8], length: usize) -> bool {
    let ends_well = bytes.get(length).is_none_or(|&byte| is_start_byte(byte));
    let runs_into_a_frame = |start: usize| {
        let behind = bytes.get(start..).unwrap_or(&[]);
        Frame::parse(behind).is_ok_and(|frame| start + frame.bytes.len() + CHECKSUM > length)
    };
    ends_well && !(1..length).any(runs_into_a_frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::DialectMessage;
    use crate::frame::{SIGNATURE, SIGNED, V2_START, checksum, checksum_extra};
    use crate::telemetry::ground_heartbeat;
    use crate::{Encoder, Header, Version};

    fn heartbeat(version: Version) -> Vec<u8> {
        let mut bytes = Vec::new();
        Encoder::new(7, 1).with_version(version).encode(&ground_heartbeat(), &mut bytes);
        bytes
    }

    fn count(datagram: &[u8]) -> (usize, Counters) {
        let mut counters = Counters::default();
        let yielded = frames(datagram, &mut counters).count();
        assert_eq!((counters.datagrams, counters.bytes), (1, datagram.len() as u64));
        assert_eq!(counters.frames, yielded as u64);
        (yielded, counters)
    }

    /// The checksum anew after a change, with a CRC_EXTRA.
    fn seal(mut bytes: Vec<u8>, extra: u8) -> Vec<u8> {
        let end = bytes.len() - CHECKSUM;
        let crc = checksum(&bytes[1..end], extra).to_le_bytes();
        bytes[end..].copy_from_slice(&crc);
        bytes
    }

    /// A MAVLink 2 frame with a message id that no dialect has.
    fn unknown() -> Vec<u8> {
        let mut bytes = heartbeat(Version::V2);
        bytes[7..10].copy_from_slice(&[0xFF, 0xFF, 0xFF]);
        seal(bytes, 50)
    }

    #[test]
    fn headers_are_read_as_written() {
        for version in [Version::V1, Version::V2] {
            let bytes = heartbeat(version);
            let frame = Frame::parse(&bytes).unwrap();
            let expected = Header { system_id: 7, component_id: 1, sequence: 0, message_id: 0, version };
            assert_eq!(frame.header, expected);
            assert_eq!(frame.message(), Ok(ground_heartbeat()));
        }
    }

    #[test]
    fn a_wrong_checksum_is_counted_once_and_hides_nothing_behind_it() {
        for version in [Version::V1, Version::V2] {
            let good = heartbeat(version);
            for index in [2, good.len() - 3, good.len() - 1] {
                // A flags byte set in MAVLink 2 is another matter.
                if version == Version::V2 && index == 2 {
                    continue;
                }
                let mut bad = good.clone();
                bad[index] ^= 0x40;
                let (yielded, counters) = count(&[&bad[..], &good].concat());
                assert_eq!((yielded, counters.bad_checksum, counters.malformed_bytes), (1, 1, 0));
            }
        }
    }

    #[test]
    fn a_sequence_number_that_is_a_start_byte_does_not_count_twice() {
        let mut bad = heartbeat(Version::V2);
        bad[4] = 0xFE;
        let last = bad.len() - 1;
        bad[last] ^= 1;
        let (yielded, counters) = count(&bad);
        assert_eq!((yielded, counters.bad_checksum, counters.malformed_bytes), (0, 1, 0));
    }

    #[test]
    fn unknown_ids_are_counted_and_passed_over() {
        let good = heartbeat(Version::V1);
        let (yielded, counters) = count(&[&unknown()[..], &good, &unknown()].concat());
        assert_eq!((yielded, counters.unknown_message, counters.malformed_bytes), (1, 2, 0));
    }

    #[test]
    fn a_frame_within_an_unknown_message_is_not_taken_out() {
        let inner = heartbeat(Version::V1);
        let mut outer = vec![V2_START, inner.len() as u8, 0, 0, 0, 1, 1, 0xFF, 0xFF, 0xFF];
        outer.extend_from_slice(&inner);
        outer.extend_from_slice(&[0, 0]);
        let (yielded, counters) = count(&outer);
        assert_eq!((yielded, counters.unknown_message), (0, 1));
    }

    #[test]
    fn signed_frames_are_accepted_with_their_signature() {
        let mut bytes = heartbeat(Version::V2);
        bytes[2] = SIGNED;
        let mut bytes = seal(bytes, 50);
        bytes.extend_from_slice(&[0xAB; SIGNATURE]);
        let both = [&bytes[..], &heartbeat(Version::V2)].concat();
        let mut counters = Counters::default();
        let read: Vec<_> = frames(&both, &mut counters).collect();
        assert_eq!(read.len(), 2);
        assert_eq!(read[0].bytes, bytes);
        assert_eq!(read[0].message(), Ok(ground_heartbeat()));
    }

    #[test]
    fn flags_that_are_not_understood_are_counted() {
        let mut bytes = heartbeat(Version::V2);
        bytes[2] = 0x02; // MAVLINK_IFLAG_SYSID32, proposed
        let (yielded, counters) = count(&seal(bytes, 50));
        assert_eq!((yielded, counters.incompatible_flags), (0, 1));
    }

    #[test]
    fn values_that_the_dialect_does_not_know_are_counted() {
        let mut bytes = heartbeat(Version::V1);
        bytes[6 + 4] = 250; // the type of vehicle
        let bytes = seal(bytes, 50);
        let mut counters = Counters::default();
        let read: Vec<_> = messages(&bytes, &mut counters).map(|(_, message)| message).collect();
        assert_eq!(read, [Err(FrameError::InvalidValue { enum_type: "MavType", value: 250 })]);
        assert_eq!((counters.frames, counters.invalid_value), (1, 1));
    }

    #[test]
    fn a_truncated_frame_is_malformed_bytes() {
        for version in [Version::V1, Version::V2] {
            let bytes = heartbeat(version);
            for length in 0..bytes.len() {
                let (yielded, counters) = count(&bytes[..length]);
                assert_eq!((yielded, counters.malformed_bytes), (0, length as u64));
                assert_eq!(Frame::parse(&bytes[..length]), Err(FrameError::Malformed));
            }
        }
    }

    #[test]
    fn a_checksum_extra_of_zero_is_no_unknown_id() {
        assert_eq!(Message::extra_crc(395), 0); // COMPONENT_INFORMATION
        assert_eq!(checksum_extra(395), Some(0));
        assert_eq!(checksum_extra(0xFF_FFFF), None);
    }

    #[test]
    fn an_unknown_length_that_runs_into_a_right_frame_is_not_believed() {
        // A piece of a header, which takes its message id out of the frame behind it, and ends with the datagram.
        let good = heartbeat(Version::V2);
        for piece in 1..10 {
            let mut datagram = vec![V2_START, (good.len() + piece - 12) as u8, 0, 0, 9, 9, 9, 0xFF, 0xFF, 0xFF];
            datagram.truncate(piece);
            datagram.extend_from_slice(&good);
            let (yielded, counters) = count(&datagram);
            assert_eq!(yielded, 1, "{piece}");
            assert_eq!(counters.bad_checksum + counters.unknown_message, u64::from(counters.malformed_bytes == 0));
        }
    }
}
