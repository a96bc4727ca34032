//! How fast lists of parameters go to one peer, whichever vehicles send them.
//!
//! A peer has one receive buffer. Two hundred vehicles that each send a list at once would overrun it, and one vehicle
//! that always sent as slowly as if there were two hundred would keep its peer waiting.

use crate::links::PeerId;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Parameters in one go.
pub(super) const PARAMETERS_AT_ONCE: usize = 5;
/// Host time from one go to the next: 4000 parameters a second, about what a Python client can read.
const INTERVAL: Duration = Duration::from_micros(1250);

/// The time at which each peer is free again; shared by all vehicles of a host.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    free_at: Mutex<HashMap<PeerId, Duration>>,
}

impl Pace {
    /// Takes the peer's next free place, and gives its host time.
    pub fn reserve(&self, peer: PeerId, now: Duration) -> Duration {
        // A vehicle that panicked while it held the lock leaves whole times behind.
        let mut free_at = self.free_at.lock().unwrap_or_else(PoisonError::into_inner);
        if !free_at.contains_key(&peer) {
            free_at.retain(|_, time| *time > now);
        }
        let free = free_at.entry(peer).or_insert(now);
        let place = (*free).max(now);
        *free = place.saturating_add(INTERVAL);
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_a_pace_apart_for_each_peer() {
        let pace = Pace::default();
        let [one, other] = [1, 2].map(|port| PeerId::from(([127, 0, 0, 1], port)));
        let now = Duration::from_secs(3);
        assert_eq!(pace.reserve(one, now), now);
        assert_eq!(pace.reserve(one, now), now + INTERVAL);
        assert_eq!(pace.reserve(other, now), now);
        assert_eq!(pace.reserve(one, now), now + 2 * INTERVAL);
        let later = now + Duration::from_secs(1);
        assert_eq!(pace.reserve(one, later), later);
        assert_eq!(pace.free_at.lock().unwrap().len(), 2);
        pace.reserve(PeerId::from(([127, 0, 0, 1], 3)), later + Duration::from_secs(1));
        assert_eq!(pace.free_at.lock().unwrap().len(), 1, "who is long free is forgotten");
    }
}
