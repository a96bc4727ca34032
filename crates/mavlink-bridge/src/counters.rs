//! Counters of a link.

use crate::Frame;
use serde::Serialize;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::{Add, AddAssign};

macro_rules! counters {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Totals of a link since its start. They add up: the counters of many links are their sum.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
        pub struct Counters {
            $($(#[$doc])* pub $name: u64,)*
        }

        impl AddAssign for Counters {
            fn add_assign(&mut self, other: Self) {
                $(self.$name = self.$name.saturating_add(other.$name);)*
            }
        }
    };
}

counters! {
    /// Datagrams received.
    datagrams,
    /// Bytes received.
    bytes,
    /// Frames received whole, with a message id that we know and the right checksum.
    frames,
    /// Frames with a message id that we know and a wrong checksum.
    bad_checksum,
    /// Frames with a message id that is not in the dialect: their checksum cannot be verified.
    unknown_message,
    /// MAVLink 2 frames with incompatibility flags that we do not understand.
    incompatible_flags,
    /// Frames whose payload holds a value that the dialect does not know.
    invalid_value,
    /// Bytes that belong to no frame, right or wrong: garbage, or the pieces of truncated frames.
    malformed_bytes,
    /// Frames that were lost, by the gaps in the sequence numbers of each sender.
    lost,
    /// Frames that came again, byte for byte: a vehicle in lockstep sends its last telemetry until it is answered, and
    /// a network may deliver a datagram twice.
    repeated,
    /// Frames that came late, by their sequence numbers.
    out_of_order,
    /// Datagrams sent.
    datagrams_sent,
    /// Bytes sent.
    bytes_sent,
    /// Datagrams that the socket refused to send.
    send_errors,
    /// Errors of the socket while receiving, such as the notice that a peer's port is closed.
    receive_errors,
    /// Datagrams that the link impairment lost, in either direction.
    impairment_lost,
    /// Datagrams that the link impairment sent twice.
    impairment_duplicated,
    /// Datagrams that the link impairment held back past their successor.
    impairment_reordered,
}

impl Add for Counters {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl std::iter::Sum for Counters {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), Add::add)
    }
}

/// What a frame's sequence number and bytes say of its place among the frames of its sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Newer than every frame before it.
    Newer,
    /// Older than the newest, and not heard before.
    Late,
    /// Heard before, byte for byte.
    Repeated,
}

/// Counts lost, late and repeated frames by each sender's sequence numbers.
///
/// A sender is a (system, component) on one network: keep one tracker for each peer whose system ids are its own.
#[derive(Clone, Debug, Default)]
pub struct SequenceTracker {
    senders: HashMap<(u8, u8), Sender>,
}

impl SequenceTracker {
    /// Notes a frame: adds the number of frames missing before it to `counters.lost`, or the frame itself to
    /// `counters.repeated` or `counters.out_of_order`.
    ///
    /// A sequence number in the half circle behind the newest one is that of an older frame, and moves nothing. Gaps of
    /// 128 frames and more cannot be told from that.
    pub fn observe(&mut self, frame: &Frame<'_>, counters: &mut Counters) -> Order {
        let digest = digest(frame.bytes);
        let sequence = frame.header.sequence;
        let id = (frame.header.system_id, frame.header.component_id);
        let Some(sender) = self.senders.get_mut(&id) else {
            self.senders.insert(id, Sender::new(sequence, digest));
            return Order::Newer;
        };
        let (order, missing) = sender.observe(sequence, digest);
        match order {
            Order::Newer => counters.lost = counters.lost.saturating_add(u64::from(missing)),
            Order::Late => counters.out_of_order = counters.out_of_order.saturating_add(1),
            Order::Repeated => counters.repeated = counters.repeated.saturating_add(1),
        }
        order
    }
}

/// The frames of one sender.
#[derive(Clone, Debug)]
struct Sender {
    newest: u8,
    /// By sequence number, the digest of the frame that was heard last with it.
    heard: Box<[Option<u64>; 256]>,
}

impl Sender {
    fn new(sequence: u8, digest: u64) -> Self {
        let mut heard = Box::new([None; 256]);
        heard[usize::from(sequence)] = Some(digest);
        Self { newest: sequence, heard }
    }

    /// The order of a frame, and how many are missing before it.
    fn observe(&mut self, sequence: u8, digest: u64) -> (Order, u8) {
        let missing = sequence.wrapping_sub(self.newest.wrapping_add(1));
        let slot = usize::from(sequence);
        if missing < 128 {
            for gap in 1..=missing {
                // What stands there is of the round before, and no frame of the gap was heard.
                self.heard[usize::from(sequence.wrapping_sub(gap))] = None;
            }
            self.newest = sequence;
            self.heard[slot] = Some(digest);
            return (Order::Newer, missing);
        }
        let known = self.heard[slot].replace(digest);
        (if known == Some(digest) { Order::Repeated } else { Order::Late }, 0)
    }
}

fn digest(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Header, Version};
    use proptest::prelude::*;

    fn frame(system_id: u8, sequence: u8, bytes: &[u8]) -> Frame<'_> {
        let header = Header { system_id, component_id: 1, sequence, message_id: 0, version: Version::V2 };
        Frame { header, bytes }
    }

    /// Frames of one sender, each unlike the others.
    fn observed(sequences: impl IntoIterator<Item = u8>) -> Counters {
        let mut counters = Counters::default();
        let mut tracker = SequenceTracker::default();
        for (index, sequence) in sequences.into_iter().enumerate() {
            tracker.observe(&frame(1, sequence, &index.to_be_bytes()), &mut counters);
        }
        counters
    }

    /// The order of frames that have a sequence number and a content each.
    fn orders(frames: impl IntoIterator<Item = (u8, u8)>) -> (Vec<Order>, Counters) {
        let mut counters = Counters::default();
        let mut tracker = SequenceTracker::default();
        let orders = frames
            .into_iter()
            .map(|(sequence, content)| tracker.observe(&frame(1, sequence, &[content]), &mut counters))
            .collect();
        (orders, counters)
    }

    #[test]
    fn a_gap_is_lost_frames_also_across_the_wrap() {
        assert_eq!(observed([10, 11, 14]).lost, 2);
        assert_eq!(observed([254, 255, 1]).lost, 1);
        assert_eq!(observed([7]).lost, 0);
    }

    #[test]
    fn late_frames_are_no_gap() {
        let counters = observed([10, 12, 11, 12, 13]);
        assert_eq!((counters.lost, counters.out_of_order, counters.repeated), (1, 2, 0));
    }

    #[test]
    fn a_frame_that_comes_again_byte_for_byte_is_repeated_and_not_late() {
        use Order::{Late, Newer, Repeated};
        // The whole exchange again, as a vehicle in lockstep sends it; then the next frames.
        let (found, counters) = orders([(10, 0), (11, 1), (10, 0), (11, 1), (11, 1), (12, 2)]);
        assert_eq!(found, [Newer, Newer, Repeated, Repeated, Repeated, Newer]);
        assert_eq!((counters.lost, counters.out_of_order, counters.repeated), (0, 0, 3));
        // A late frame is late the first time it comes, and repeated the second time.
        let (found, counters) = orders([(10, 0), (12, 2), (11, 1), (11, 1)]);
        assert_eq!(found, [Newer, Newer, Late, Repeated]);
        assert_eq!((counters.lost, counters.out_of_order, counters.repeated), (1, 1, 1));
    }

    #[test]
    fn the_same_bytes_a_whole_round_later_are_another_frame() {
        // A sender of nothing but heartbeats has the same frame again every 256 frames.
        let (found, counters) = orders((0..=255).chain(0..=255).map(|sequence| (sequence, 0)));
        assert!(found.iter().all(|order| *order == Order::Newer));
        assert_eq!(counters, Counters::default());
        // A frame of a gap that comes late was not heard before, whatever had its number in the round before.
        let rest = [(0, 0), (5, 0), (3, 0)];
        let (found, counters) = orders((0..=255).map(|sequence| (sequence, 0)).chain(rest));
        assert_eq!(found.last(), Some(&Order::Late));
        assert_eq!((counters.lost, counters.out_of_order, counters.repeated), (4, 1, 0));
    }

    #[test]
    fn senders_are_told_apart() {
        let mut counters = Counters::default();
        let mut tracker = SequenceTracker::default();
        for (system_id, sequence) in [(1, 0), (2, 100), (1, 1), (2, 101)] {
            tracker.observe(&frame(system_id, sequence, &[sequence]), &mut counters);
        }
        assert_eq!(counters, Counters::default());
    }

    #[test]
    fn counters_add_field_by_field_and_do_not_overflow() {
        let one = Counters { frames: 3, lost: u64::MAX, ..Counters::default() };
        let other = Counters { frames: 4, lost: 1, bytes: 9, ..Counters::default() };
        let sum = Counters { frames: 7, lost: u64::MAX, bytes: 9, ..Counters::default() };
        assert_eq!(one + other, sum);
        assert_eq!([one, other].into_iter().sum::<Counters>(), sum);
    }

    proptest! {
        #[test]
        fn what_is_dropped_is_what_is_lost(kept in proptest::collection::vec(any::<bool>(), 1..600)) {
            // The last frame always comes, and no gap is longer than can be told.
            prop_assume!(!kept.windows(127).any(|window| window.iter().all(|kept| !kept)));
            let mut kept = kept;
            kept[0] = true;
            let last = kept.len() - 1;
            kept[last] = true;
            let dropped = kept.iter().filter(|kept| !**kept).count() as u64;
            let counters = observed((0..=last).filter(|&index| kept[index]).map(|index| index as u8));
            prop_assert_eq!((counters.lost, counters.out_of_order), (dropped, 0));
        }
    }
}
