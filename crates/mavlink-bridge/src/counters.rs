//! What a link has seen, counted.

use crate::Header;
use serde::Serialize;
use std::collections::HashMap;
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
    /// Frames that never came, by the gaps in the sequence numbers of each sender.
    lost,
    /// Frames that came late or twice, by their sequence numbers.
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

/// Counts lost frames by the gaps in each sender's sequence numbers.
///
/// A sender is a (system, component) on one network: keep one tracker for each peer whose system ids are its own.
#[derive(Clone, Debug, Default)]
pub struct SequenceTracker {
    last: HashMap<(u8, u8), u8>,
}

impl SequenceTracker {
    /// Notes a frame, and adds to `counters.lost` the number of frames missing before it.
    ///
    /// A sequence number in the half circle behind the newest one is a late or repeated frame: it adds to
    /// `counters.out_of_order` and moves nothing. Gaps of 128 frames and more cannot be told from that.
    pub fn observe(&mut self, header: &Header, counters: &mut Counters) {
        let sender = (header.system_id, header.component_id);
        let Some(last) = self.last.get_mut(&sender) else {
            self.last.insert(sender, header.sequence);
            return;
        };
        let missing = header.sequence.wrapping_sub(last.wrapping_add(1));
        if missing < 128 {
            counters.lost = counters.lost.saturating_add(u64::from(missing));
            *last = header.sequence;
        } else {
            counters.out_of_order = counters.out_of_order.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Version;
    use proptest::prelude::*;

    fn header(system_id: u8, sequence: u8) -> Header {
        Header { system_id, component_id: 1, sequence, message_id: 0, version: Version::V2 }
    }

    fn observed(sequences: impl IntoIterator<Item = u8>) -> Counters {
        let mut counters = Counters::default();
        let mut tracker = SequenceTracker::default();
        for sequence in sequences {
            tracker.observe(&header(1, sequence), &mut counters);
        }
        counters
    }

    #[test]
    fn a_gap_is_lost_frames_also_across_the_wrap() {
        assert_eq!(observed([10, 11, 14]).lost, 2);
        assert_eq!(observed([254, 255, 1]).lost, 1);
        assert_eq!(observed([7]).lost, 0);
    }

    #[test]
    fn late_and_repeated_frames_are_no_gap() {
        let counters = observed([10, 12, 11, 12, 13]);
        assert_eq!((counters.lost, counters.out_of_order), (1, 2));
    }

    #[test]
    fn senders_are_told_apart() {
        let mut counters = Counters::default();
        let mut tracker = SequenceTracker::default();
        for (system_id, sequence) in [(1, 0), (2, 100), (1, 1), (2, 101)] {
            tracker.observe(&header(system_id, sequence), &mut counters);
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
