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
    /// Bytes that belong to no frame: garbage, or the pieces of truncated frames.
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
