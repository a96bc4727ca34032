//! A bad link: loss, duplication, delay, jitter and reordering of datagrams. Sans-I/O and repeatable.

use crate::Counters;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::net::SocketAddr;
use std::time::Duration;

/// How bad a link is, in one direction. The default is a perfect one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImpairmentSettings {
    /// Probability that a datagram is lost, 0 to 1.
    pub loss: f64,
    /// Probability that a datagram comes twice, 0 to 1.
    pub duplication: f64,
    /// Probability that a datagram is held back until its successor has passed, 0 to 1.
    pub reordering: f64,
    /// Delay of every datagram, ms, 0 to 60 000.
    pub delay_ms: f64,
    /// Further delay, ms, uniform between 0 and this for each datagram, 0 to 60 000. Datagrams may overtake each other.
    pub jitter_ms: f64,
}

/// A setting that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}, but must be from 0 to {max}")]
pub struct ImpairmentError {
    /// Name of the setting.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// The greatest value it may have.
    pub max: f64,
}

/// How long a datagram that is held back waits for a successor before it goes without.
pub const HOLD_MAX: Duration = Duration::from_millis(100);

/// Most datagrams under way at once; further ones are lost, as in a full queue.
pub const UNDER_WAY_MAX: usize = 65_536;

impl ImpairmentSettings {
    /// Checks every setting against its range.
    pub fn validate(&self) -> Result<(), ImpairmentError> {
        let ranges = [
            ("loss", self.loss, 1.0),
            ("duplication", self.duplication, 1.0),
            ("reordering", self.reordering, 1.0),
            ("delay_ms", self.delay_ms, 60_000.0),
            ("jitter_ms", self.jitter_ms, 60_000.0),
        ];
        for (name, value, max) in ranges {
            if !(0.0..=max).contains(&value) {
                return Err(ImpairmentError { name, value, max });
            }
        }
        Ok(())
    }

    /// Whether datagrams pass as they come.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// One direction of a bad link. Datagrams go in by [`offer`](Self::offer) and come out by [`poll`](Self::poll).
///
/// `A` is what a datagram is addressed with: a socket's address, or an index for links in memory. What happens to the
/// n-th datagram depends on the seed, the stream and n alone.
#[derive(Debug)]
pub struct Impairment<A = SocketAddr> {
    settings: ImpairmentSettings,
    random: ChaCha8Rng,
    /// Due datagrams first, those due at once in the order in which they came.
    under_way: BinaryHeap<Reverse<UnderWay<A>>>,
    held: Option<(Duration, Vec<u8>, A)>,
    order: u64,
    lost: u64,
    duplicated: u64,
    reordered: u64,
}

impl<A: Clone> Impairment<A> {
    /// A link with `settings`, of the random stream `stream` of `seed`. Settings out of range are errors.
    pub fn new(settings: ImpairmentSettings, seed: u64, stream: u64) -> Result<Self, ImpairmentError> {
        settings.validate()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Ok(Self {
            settings,
            random,
            under_way: BinaryHeap::new(),
            held: None,
            order: 0,
            lost: 0,
            duplicated: 0,
            reordered: 0,
        })
    }

    /// Whether datagrams pass as they come: then nobody need go through `offer` and `poll`.
    pub fn is_none(&self) -> bool {
        self.settings.is_none()
    }

    /// A datagram enters the link at `now`.
    pub fn offer(&mut self, now: Duration, datagram: &[u8], address: A) {
        // Always as many draws, so that one datagram's fate does not change the next one's.
        let [loss, duplication, reordering, first_jitter, second_jitter] =
            std::array::from_fn(|_| self.random.random::<f64>());
        if loss < self.settings.loss || self.under_way.len() >= UNDER_WAY_MAX {
            self.lost += 1;
            return;
        }
        let due = self.due(now, first_jitter);
        if reordering < self.settings.reordering && self.held.is_none() {
            self.reordered += 1;
            self.held = Some((due, datagram.to_vec(), address.clone()));
        } else {
            self.send(due, datagram.to_vec(), address.clone());
            if let Some((held_due, held, held_address)) = self.held.take() {
                self.send(held_due.max(due), held, held_address);
            }
        }
        if duplication < self.settings.duplication {
            self.duplicated += 1;
            let due = self.due(now, second_jitter);
            self.send(due, datagram.to_vec(), address);
        }
    }

    /// The next datagram that has arrived by `now`.
    pub fn poll(&mut self, now: Duration) -> Option<(Vec<u8>, A)> {
        if let Some((due, held, address)) = self.held.take_if(|(due, ..)| *due + HOLD_MAX <= now) {
            self.send(due + HOLD_MAX, held, address);
        }
        if self.under_way.peek()?.0.due > now {
            return None;
        }
        self.under_way.pop().map(|Reverse(arrived)| (arrived.datagram, arrived.address))
    }

    /// When the next datagram arrives, if nothing else enters the link.
    pub fn next_due(&self) -> Option<Duration> {
        let held = self.held.as_ref().map(|(due, ..)| *due + HOLD_MAX);
        let under_way = self.under_way.peek().map(|Reverse(next)| next.due);
        [held, under_way].into_iter().flatten().min()
    }

    /// Adds what the link has lost, duplicated and reordered so far.
    pub fn count(&self, counters: &mut Counters) {
        counters.impairment_lost += self.lost;
        counters.impairment_duplicated += self.duplicated;
        counters.impairment_reordered += self.reordered;
    }

    fn due(&self, now: Duration, jitter: f64) -> Duration {
        let delay_ms = self.settings.delay_ms + jitter * self.settings.jitter_ms;
        now.saturating_add(Duration::from_secs_f64(delay_ms / 1e3))
    }

    fn send(&mut self, due: Duration, datagram: Vec<u8>, address: A) {
        self.under_way.push(Reverse(UnderWay { due, order: self.order, datagram, address }));
        self.order += 1;
    }
}

#[derive(Clone, Debug)]
struct UnderWay<A> {
    due: Duration,
    order: u64,
    datagram: Vec<u8>,
    address: A,
}

impl<A> Ord for UnderWay<A> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.due, self.order).cmp(&(other.due, other.order))
    }
}

impl<A> PartialOrd for UnderWay<A> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<A> PartialEq for UnderWay<A> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<A> Eq for UnderWay<A> {}
