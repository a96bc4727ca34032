//! A bad link: loss, duplication, delay, jitter and reordering of datagrams. Sans-I/O and repeatable.

use crate::Counters;
use flight_model::{RangeError, Ranges};
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
    /// Probability that a datagram is lost, 0 to 1; see [`SHARE_MAX`](Self::SHARE_MAX).
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
    /// Greatest share of datagrams lost, duplicated or reordered in a flight: over a link that loses everything, a
    /// flight would wait for ever.
    pub const SHARE_MAX: f64 = 0.95;
    /// Greatest delay and jitter, ms.
    const DELAY_MAX_MS: f64 = 60_000.0;

    /// Every setting that is out of the range of a flight.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        for (name, share) in [("loss", self.loss), ("duplication", self.duplication), ("reordering", self.reordering)] {
            ranges.within(name, share, 0.0, Self::SHARE_MAX);
        }
        ranges.within("delay_ms", self.delay_ms, 0.0, Self::DELAY_MAX_MS);
        ranges.within("jitter_ms", self.jitter_ms, 0.0, Self::DELAY_MAX_MS);
        ranges.errors()
    }

    /// Checks every setting against its range as a link takes it; a link may lose everything.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn validate(&self) -> Result<(), ImpairmentError> {
        let ranges = [
            ("loss", self.loss, 1.0),
            ("duplication", self.duplication, 1.0),
            ("reordering", self.reordering, 1.0),
            ("delay_ms", self.delay_ms, Self::DELAY_MAX_MS),
            ("jitter_ms", self.jitter_ms, Self::DELAY_MAX_MS),
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
/// `A` is what a datagram is addressed with: a socket's address, or an index for links in memory. Everything random
/// about the n-th datagram depends on the seed, the stream and n alone.
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
    /// A link with `settings`, of the random stream `stream` of `seed`.
    ///
    /// # Errors
    /// A setting is out of its range.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: Duration = Duration::from_millis(1);

    /// Sends numbered datagrams a millisecond apart, and gives (time of arrival, number).
    fn arrivals(settings: ImpairmentSettings, seed: u64, stream: u64, count: u32) -> Vec<(Duration, u32)> {
        let mut link = Impairment::new(settings, seed, stream).unwrap();
        let mut arrivals = Vec::new();
        for number in 0..count {
            let now = number * MS;
            link.offer(now, &number.to_le_bytes(), ());
            while let Some((datagram, ())) = link.poll(now) {
                arrivals.push((now, u32::from_le_bytes(datagram.try_into().unwrap())));
            }
        }
        // Then as a shell does: wake when something is due.
        while let Some(due) = link.next_due() {
            while let Some((datagram, ())) = link.poll(due) {
                arrivals.push((due, u32::from_le_bytes(datagram.try_into().unwrap())));
            }
        }
        arrivals
    }

    fn numbers(arrivals: &[(Duration, u32)]) -> Vec<u32> {
        arrivals.iter().map(|&(_, number)| number).collect()
    }

    #[test]
    fn a_perfect_link_passes_everything_at_once() {
        let arrivals = arrivals(ImpairmentSettings::default(), 1, 0, 500);
        assert!(ImpairmentSettings::default().is_none());
        assert_eq!(arrivals, (0..500).map(|number| (number * MS, number)).collect::<Vec<_>>());
    }

    #[test]
    fn the_loss_is_the_loss_asked_for() {
        let settings = ImpairmentSettings { loss: 0.2, ..Default::default() };
        let received = numbers(&arrivals(settings, 7, 0, 20_000));
        // Four standard deviations of a binomial count.
        assert!(
            (received.len() as f64 - 16_000.0).abs() < 4.0 * (20_000.0 * 0.2 * 0.8_f64).sqrt(),
            "{}",
            received.len()
        );
        assert!(received.is_sorted());
        assert_eq!(arrivals(ImpairmentSettings { loss: 1.0, ..Default::default() }, 7, 0, 100), []);
    }

    #[test]
    fn duplicates_come_twice_and_are_counted() {
        let settings = ImpairmentSettings { duplication: 0.1, ..Default::default() };
        let received = numbers(&arrivals(settings, 7, 0, 10_000));
        let twice = received.windows(2).filter(|pair| pair[0] == pair[1]).count();
        assert_eq!(received.len(), 10_000 + twice);
        assert!((twice as f64 - 1000.0).abs() < 4.0 * 30.0, "{twice}");
    }

    #[test]
    fn delay_and_jitter_keep_their_bounds() {
        let settings = ImpairmentSettings { delay_ms: 30.0, jitter_ms: 5.0, ..Default::default() };
        let arrivals = arrivals(settings, 7, 0, 2_000);
        assert_eq!(arrivals.len(), 2_000);
        let delays_ms: Vec<f64> = arrivals.iter().map(|&(at, number)| (at - number * MS).as_secs_f64() * 1e3).collect();
        // Arrivals are seen at most a millisecond after they are due.
        assert!(delays_ms.iter().all(|delay| (30.0..36.0).contains(delay)));
        let mean_ms = delays_ms.iter().sum::<f64>() / delays_ms.len() as f64;
        assert!((32.5..33.5).contains(&mean_ms), "{mean_ms}");
    }

    #[test]
    fn what_is_held_back_comes_right_behind_its_successor() {
        let settings = ImpairmentSettings { reordering: 1.0, ..Default::default() };
        let arrivals = arrivals(settings, 7, 0, 6);
        assert_eq!(numbers(&arrivals), [1, 0, 3, 2, 5, 4]);
        assert_eq!(arrivals[1].0, MS);
    }

    #[test]
    fn what_is_held_back_comes_alone_when_nothing_follows() {
        let settings = ImpairmentSettings { reordering: 1.0, delay_ms: 2.0, ..Default::default() };
        assert_eq!(arrivals(settings, 7, 0, 1), [(2 * MS + HOLD_MAX, 0)]);
    }

    #[test]
    fn what_happened_is_counted() {
        let settings = ImpairmentSettings { loss: 0.5, duplication: 0.5, reordering: 0.5, ..Default::default() };
        let mut link = Impairment::new(settings, 3, 0).unwrap();
        let mut arrived = 0;
        for number in 0..1000 {
            link.offer(number * MS, &[1], ());
            arrived += std::iter::from_fn(|| link.poll(number * MS)).count() as u64;
        }
        arrived += std::iter::from_fn(|| link.poll(Duration::from_secs(10))).count() as u64;
        let mut counters = Counters::default();
        link.count(&mut counters);
        assert_eq!(arrived, 1000 - counters.impairment_lost + counters.impairment_duplicated);
        assert!(counters.impairment_reordered > 100);
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let refused = |settings: ImpairmentSettings| Impairment::<()>::new(settings, 0, 0).unwrap_err();
        let error = refused(ImpairmentSettings { loss: 1.5, ..Default::default() });
        assert_eq!(error.to_string(), "loss is 1.5, but must be from 0 to 1");
        assert_eq!(refused(ImpairmentSettings { jitter_ms: -1.0, ..Default::default() }).name, "jitter_ms");
        assert_eq!(refused(ImpairmentSettings { delay_ms: f64::NAN, ..Default::default() }).name, "delay_ms");
    }

    #[test]
    fn a_full_link_loses_what_comes_further() {
        let settings = ImpairmentSettings { delay_ms: 60_000.0, ..Default::default() };
        let mut link = Impairment::new(settings, 0, 0).unwrap();
        for _ in 0..UNDER_WAY_MAX + 10 {
            link.offer(Duration::ZERO, &[], ());
        }
        let mut counters = Counters::default();
        link.count(&mut counters);
        assert_eq!(counters.impairment_lost, 10);
    }

    fn settings() -> impl Strategy<Value = ImpairmentSettings> {
        (0.0..=1.0f64, 0.0..=1.0f64, 0.0..=1.0f64, 0.0..50.0f64, 0.0..50.0f64).prop_map(
            |(loss, duplication, reordering, delay_ms, jitter_ms)| ImpairmentSettings {
                loss,
                duplication,
                reordering,
                delay_ms,
                jitter_ms,
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_same_seed_gives_the_same_outcome(settings in settings(), seed in any::<u64>(), stream in any::<u64>()) {
            prop_assert_eq!(arrivals(settings, seed, stream, 100), arrivals(settings, seed, stream, 100));
        }

        #[test]
        fn streams_of_a_seed_are_independent(seed in any::<u64>(), stream in 0..1000u64) {
            let settings = ImpairmentSettings { loss: 0.5, ..Default::default() };
            prop_assert_ne!(arrivals(settings, seed, stream, 200), arrivals(settings, seed, stream + 1, 200));
        }

        #[test]
        fn what_arrives_was_sent_and_at_most_twice(settings in settings(), seed in any::<u64>()) {
            let arrivals = arrivals(settings, seed, 0, 100);
            let mut times = [0; 100];
            for &(at, number) in &arrivals {
                times[number as usize] += 1;
                prop_assert!(at >= number * MS);
            }
            prop_assert!(times.iter().all(|&times| times <= 2));
            prop_assert!(arrivals.is_sorted_by_key(|&(at, _)| at));
        }

        // Were the number of draws to depend on a datagram's fate, a change of one setting would change all the
        // others'.
        #[test]
        fn the_datagrams_lost_depend_on_the_loss_alone(settings in settings(), seed in any::<u64>()) {
            let survivors = |settings| {
                let mut numbers = numbers(&arrivals(settings, seed, 0, 100));
                numbers.sort_unstable();
                numbers.dedup();
                numbers
            };
            let loss_alone = ImpairmentSettings { loss: settings.loss, ..Default::default() };
            prop_assert_eq!(survivors(settings), survivors(loss_alone));
        }
    }
}
