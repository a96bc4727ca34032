//! From a stream of bytes to frames: a serial line and TCP cut frames anywhere.

use crate::frame::{Candidate, is_start_byte};
use crate::{Counters, Frame, FrameError};

/// Finds frames in bytes that come in pieces, and keeps what belongs to a frame that is not whole yet. One for each
/// peer.
///
/// Frames with a message id that no dialect knows are handed out too: nothing verifies them, but a log must hold them
/// and a sequence number is theirs.
#[derive(Clone, Debug, Default)]
pub struct Framer {
    kept: Vec<u8>,
    /// How many bytes at the front of `kept` belong to a frame that has been counted as wrong.
    suspect: usize,
}

/// A frame as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found<'a> {
    /// Its checksum is right.
    Verified(Frame<'a>),
    /// Its message id is in no dialect that we know: its length is plausible, and no more is known.
    Unknown(Frame<'a>),
}

impl<'a> Found<'a> {
    /// The frame.
    pub fn frame(&self) -> Frame<'a> {
        match *self {
            Self::Verified(frame) | Self::Unknown(frame) => frame,
        }
    }
}

impl Framer {
    /// Takes the next bytes of a stream, and hands every frame that is whole to `take`.
    pub fn push(&mut self, bytes: &[u8], counters: &mut Counters, take: impl FnMut(Found<'_>)) {
        counters.datagrams = counters.datagrams.saturating_add(1);
        counters.bytes = counters.bytes.saturating_add(bytes.len() as u64);
        self.kept.extend_from_slice(bytes);
        self.search(false, counters, take);
    }

    /// Takes a datagram: no frame reaches from one into the next.
    pub fn push_datagram(&mut self, bytes: &[u8], counters: &mut Counters, take: impl FnMut(Found<'_>)) {
        counters.datagrams = counters.datagrams.saturating_add(1);
        counters.bytes = counters.bytes.saturating_add(bytes.len() as u64);
        self.kept.clear();
        self.suspect = 0;
        self.kept.extend_from_slice(bytes);
        self.search(true, counters, take);
    }

    fn search(&mut self, ends_here: bool, counters: &mut Counters, mut take: impl FnMut(Found<'_>)) {
        let mut at = 0;
        let mut suspect = self.suspect;
        let kept = std::mem::take(&mut self.kept);
        while let Some(rest) = kept.get(at..).filter(|rest| !rest.is_empty()) {
            let garbage = rest.iter().position(|&byte| is_start_byte(byte)).unwrap_or(rest.len());
            if garbage > 0 {
                skip(garbage, &mut at, &mut suspect, counters);
                continue;
            }
            let Some(candidate) = Candidate::at_start_of(rest) else {
                if ends_here {
                    skip(1, &mut at, &mut suspect, counters);
                    continue;
                }
                break;
            };
            let length = candidate.frame.bytes.len();
            match candidate.verify() {
                Ok(()) => {
                    counters.frames = counters.frames.saturating_add(1);
                    take(Found::Verified(candidate.frame));
                    at += length;
                    suspect = suspect.saturating_sub(length);
                }
                Err(_) if suspect > 0 => skip(1, &mut at, &mut suspect, counters),
                Err(FrameError::BadChecksum) => {
                    counters.bad_checksum = counters.bad_checksum.saturating_add(1);
                    suspect = length.saturating_sub(1);
                    at += 1;
                }
                // What follows a frame is another one, or nothing yet.
                Err(_) if rest.get(length).is_some_and(|&byte| !is_start_byte(byte)) => {
                    skip(1, &mut at, &mut suspect, counters);
                }
                Err(FrameError::IncompatibleFlags(_)) => {
                    counters.incompatible_flags = counters.incompatible_flags.saturating_add(1);
                    at += length;
                }
                Err(_) => {
                    counters.unknown_message = counters.unknown_message.saturating_add(1);
                    take(Found::Unknown(candidate.frame));
                    at += length;
                }
            }
        }
        self.kept = kept;
        self.kept.drain(..at.min(self.kept.len()));
        self.suspect = suspect;
    }
}

fn skip(bytes: usize, at: &mut usize, suspect: &mut usize, counters: &mut Counters) {
    let malformed = bytes.saturating_sub(*suspect);
    counters.malformed_bytes = counters.malformed_bytes.saturating_add(malformed as u64);
    *suspect = suspect.saturating_sub(bytes);
    *at += bytes;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::ground_heartbeat;
    use crate::{Encoder, Version};
    use proptest::prelude::*;

    fn frames_of(count: usize) -> Vec<Vec<u8>> {
        let mut encoders = [Encoder::new(3, 1), Encoder::new(4, 1).with_version(Version::V1)];
        (0..count)
            .map(|index| {
                let mut bytes = Vec::new();
                encoders[index % 2].encode(&ground_heartbeat(), &mut bytes);
                bytes
            })
            .collect()
    }

    fn found(framer: &mut Framer, bytes: &[u8], counters: &mut Counters) -> Vec<Vec<u8>> {
        let mut all = Vec::new();
        framer.push(bytes, counters, |found| all.push(found.frame().bytes.to_vec()));
        all
    }

    proptest! {
        #[test]
        fn a_stream_cut_anywhere_gives_its_frames(cuts in prop::collection::vec(1..40usize, 1..60)) {
            let frames = frames_of(20);
            let stream = frames.concat();
            let (mut framer, mut counters, mut all, mut at) = (Framer::default(), Counters::default(), Vec::new(), 0);
            for cut in cuts.into_iter().cycle() {
                if at >= stream.len() {
                    break;
                }
                let end = (at + cut).min(stream.len());
                all.extend(found(&mut framer, &stream[at..end], &mut counters));
                at = end;
            }
            prop_assert_eq!(all, frames);
            prop_assert_eq!((counters.bad_checksum, counters.malformed_bytes, counters.unknown_message), (0, 0, 0));
        }

        #[test]
        fn noise_never_panics_and_never_hides_a_frame_for_long(noise in prop::collection::vec(any::<u8>(), 0..600)) {
            let (mut framer, mut counters) = (Framer::default(), Counters::default());
            found(&mut framer, &noise, &mut counters);
            // A start byte in the noise may claim up to one frame's length behind it.
            let good = frames_of(40).concat();
            prop_assert!(!found(&mut framer, &good, &mut counters).is_empty());
        }
    }

    #[test]
    fn a_frame_of_an_unknown_dialect_is_handed_out() {
        let mut unknown = frames_of(1).remove(0);
        unknown[7..10].copy_from_slice(&[0xF0, 0xFF, 0xFF]);
        let good = frames_of(1).remove(0);
        let (mut framer, mut counters, mut all) = (Framer::default(), Counters::default(), Vec::new());
        let stream = [unknown.as_slice(), &good].concat();
        framer.push_datagram(&stream, &mut counters, |found| {
            all.push((matches!(found, Found::Unknown(_)), found.frame().bytes.to_vec()));
        });
        assert_eq!(all, [(true, unknown), (false, good)]);
        assert_eq!(counters.unknown_message, 1);
    }

    #[test]
    fn a_cut_datagram_is_forgotten() {
        let good = frames_of(1).remove(0);
        let (mut framer, mut counters, mut count) = (Framer::default(), Counters::default(), 0);
        framer.push_datagram(&good[..10], &mut counters, |_| count += 1);
        framer.push_datagram(&good, &mut counters, |_| count += 1);
        assert_eq!((count, counters.malformed_bytes), (1, 10));
    }
}
