//! A vehicle's clock as the ground sees it: when a stamped message was really flown, not when it was heard.

use std::collections::VecDeque;
use std::time::Duration;

/// How far back stamped messages are looked at.
const WINDOW: Duration = Duration::from_secs(6);
/// At most so many are kept.
const SAMPLES_MAX: usize = 256;
/// Of the messages that arrive within so long the quickest counts.
const BIN_S: f64 = 0.5;
/// So many of the quickest are kept, however long ago: a ground station that was stalled finds seconds of late messages
/// at once, and must not take these for the link as it is.
const BINS_MAX: usize = 12;
/// What is older than this says nothing of the link any more, s.
const BIN_AGE_MAX_S: f64 = 60.0;
/// Round trips are looked at for this long: the shortest of them tells the delay of the link.
const ROUND_TRIPS: Duration = Duration::from_secs(20);
/// Of the messages of so long the quickest tells how exactly the clock is known, s. A drift that is taken from a step
/// spoils no more than its product with this.
const RECENT_S: f64 = 0.3;
/// A drift is believed from messages that span this.
const SPAN_MIN_S: f64 = 2.0;
/// Clocks differ by at most this: a simulator that cannot keep up is the worst.
const DRIFT_MAX: f64 = 0.5;
/// A jump of the vehicle's clock backwards by more than this is a reboot.
const REBOOT_MS: u32 = 2_000;

/// Estimates, from the time stamps of telemetry and from TIMESYNC round trips, which ground time a vehicle's time is.
///
/// A message is heard some delay after it was stamped. The least delays of each half second, with the drift between
/// the two clocks taken out, give the vehicle's time plus the least delay of the link; half of the shortest round trip
/// gives that delay. The drift is the median of the slopes between them: a burst of late messages does not move it.
#[derive(Clone, Debug, Default)]
pub struct VehicleClock {
    /// Ground time of arrival, and by how much it is ahead of the stamp, s.
    samples: VecDeque<(f64, f64)>,
    /// The quickest messages: the same two numbers.
    quickest: VecDeque<(f64, f64)>,
    round_trips: VecDeque<(Duration, f64)>,
    last_boot_ms: Option<u32>,
    /// Offset at `fitted_at` and its change per second.
    fit: Option<Fit>,
    reboots: u32,
}

#[derive(Clone, Copy, Debug)]
struct Fit {
    at_s: f64,
    offset_s: f64,
    drift: f64,
    jitter_s: f64,
    lateness_s: f64,
}

impl VehicleClock {
    /// Takes a stamp (`time_boot_ms`) that was heard at ground time `heard`.
    pub fn hear(&mut self, boot_ms: u32, heard: Duration) {
        if let Some(last) = self.last_boot_ms {
            let back = last.wrapping_sub(boot_ms);
            if back > REBOOT_MS && back < u32::MAX / 2 {
                self.samples.clear();
                self.quickest.clear();
                self.fit = None;
                self.reboots += 1;
            } else if back < u32::MAX / 2 && back > 0 {
                // Late, by another way: it tells nothing new.
                return;
            }
        }
        self.last_boot_ms = Some(boot_ms);
        let now_s = heard.as_secs_f64();
        let boot_s = f64::from(boot_ms) / 1e3;
        self.samples.push_back((now_s, now_s - boot_s));
        while self.samples.len() > SAMPLES_MAX
            || self.samples.front().is_some_and(|&(at_s, _)| now_s - at_s > WINDOW.as_secs_f64())
        {
            self.samples.pop_front();
        }
        self.note_quickest(now_s, now_s - boot_s);
        self.fit = self.fitted(now_s);
    }

    fn note_quickest(&mut self, now_s: f64, offset_s: f64) {
        let is_same_bin = |at_s: f64| libm::floor(at_s / BIN_S) == libm::floor(now_s / BIN_S);
        match self.quickest.back_mut().filter(|(at_s, _)| is_same_bin(*at_s)) {
            Some(last) if offset_s < last.1 => *last = (now_s, offset_s),
            Some(_) => {}
            None => self.quickest.push_back((now_s, offset_s)),
        }
        while self.quickest.len() > BINS_MAX
            || self.quickest.front().is_some_and(|&(at_s, _)| now_s - at_s > BIN_AGE_MAX_S)
        {
            self.quickest.pop_front();
        }
    }

    /// Takes a TIMESYNC round trip that ended at ground time `heard`.
    pub fn round_trip(&mut self, round_trip: Duration, heard: Duration) {
        self.round_trips.push_back((heard, round_trip.as_secs_f64()));
        while self.round_trips.front().is_some_and(|&(at, _)| heard.saturating_sub(at) > ROUND_TRIPS) {
            self.round_trips.pop_front();
        }
    }

    /// Delay of the link one way, s: half of the shortest round trip; none before there was one.
    pub fn delay_s(&self) -> Option<f64> {
        self.round_trips.iter().map(|&(_, trip_s)| 0.5 * trip_s).min_by(f64::total_cmp)
    }

    /// Time that a command takes to the vehicle, s, as far as round trips tell: their mean without what telemetry
    /// takes of it on the way back; none before there was one.
    pub fn command_delay_s(&self) -> Option<f64> {
        let back_s = self.delay_s()? + self.jitter_s().unwrap_or(0.0);
        Some((self.round_trip_mean_s()? - back_s).max(0.0))
    }

    /// Spread of a delay one way, s: the standard deviation of round trips over the root of two.
    pub fn delay_spread_s(&self) -> Option<f64> {
        let (mean_s, count) = (self.round_trip_mean_s()?, self.round_trips.len() as f64);
        let variance = self.round_trips.iter().map(|&(_, trip_s)| (trip_s - mean_s) * (trip_s - mean_s)).sum::<f64>();
        Some((0.5 * variance / count).sqrt())
    }

    fn round_trip_mean_s(&self) -> Option<f64> {
        let count = self.round_trips.len() as f64;
        (count > 0.0).then(|| self.round_trips.iter().map(|&(_, trip_s)| trip_s).sum::<f64>() / count)
    }

    /// How much later than the quickest messages come, s: the mean over the window.
    pub fn jitter_s(&self) -> Option<f64> {
        self.fit.map(|fit| fit.jitter_s)
    }

    /// How late even the quickest message of the last moment came, s. Whether the link was slow or the vehicle's clock
    /// has stood still nobody can tell: by so much its time may be wrong.
    pub fn lateness_s(&self) -> Option<f64> {
        self.fit.map(|fit| fit.lateness_s)
    }

    /// Seconds by which the vehicle's clock falls behind in a second; positive for a simulator that cannot keep up.
    pub fn drift(&self) -> Option<f64> {
        self.fit.map(|fit| fit.drift)
    }

    /// How often the clock began anew: reboots in flight, or another vehicle with the same system id.
    pub fn reboots(&self) -> u32 {
        self.reboots
    }

    /// The ground time at which the vehicle's clock showed `boot_ms`, s; none before anything was heard.
    pub fn ground_time_s(&self, boot_ms: u32) -> Option<f64> {
        let fit = self.fit?;
        let boot_s = f64::from(boot_ms) / 1e3;
        let delay_s = self.delay_s().unwrap_or(0.0);
        // offset(t) = offset + drift (t - at), and t = boot + offset(t).
        let at_s = (boot_s + fit.offset_s - fit.drift * fit.at_s) / (1.0 - fit.drift);
        Some(at_s - delay_s)
    }

    /// A line along the lower edge of the samples.
    fn fitted(&self, now_s: f64) -> Option<Fit> {
        let drift = self.drift_of_quickest();
        let residual = |&(t, o): &(f64, f64)| o - drift * (t - now_s);
        let offset_s = self.quickest.iter().map(residual).min_by(f64::total_cmp)?;
        let late_s: f64 = self.samples.iter().map(|sample| residual(sample) - offset_s).sum();
        let jitter_s = (late_s / self.samples.len().max(1) as f64).max(0.0);
        let recent = self.samples.iter().rev().take_while(|(at_s, _)| now_s - at_s <= RECENT_S);
        let least_s = recent.map(residual).min_by(f64::total_cmp).unwrap_or(offset_s);
        // As in `ground_time_s`: a second of the ground is less than one of a clock that falls behind.
        let lateness_s = ((least_s - offset_s) / (1.0 - drift)).max(0.0);
        Some(Fit { at_s: now_s, offset_s, drift, jitter_s, lateness_s })
    }

    /// The median slope between the quickest messages.
    fn drift_of_quickest(&self) -> f64 {
        let points: Vec<(f64, f64)> = self.quickest.iter().copied().collect();
        let mut slopes = Vec::new();
        for (index, &(t, o)) in points.iter().enumerate() {
            let before = points[..index].iter().filter(|(earlier, _)| t - earlier >= 0.5 * SPAN_MIN_S);
            slopes.extend(before.map(|&(earlier, offset)| (o - offset) / (t - earlier)));
        }
        let spans = points.first().zip(points.last()).is_some_and(|(first, last)| last.0 - first.0 >= SPAN_MIN_S);
        if !spans || slopes.is_empty() {
            return 0.0;
        }
        slopes.sort_by(f64::total_cmp);
        slopes[slopes.len() / 2].clamp(-DRIFT_MAX, DRIFT_MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn clock(drift: f64, delay_s: f64, jitter_s: impl Fn(usize) -> f64, count: usize) -> (VehicleClock, f64) {
        let mut clock = VehicleClock::default();
        let mut last_s = 0.0;
        for index in 0..count {
            let flown_s = 100.0 + 0.1 * index as f64;
            let boot_ms = ((flown_s - 90.0) * (1.0 - drift) * 1e3).round() as u32;
            let heard_s = flown_s + delay_s + jitter_s(index);
            clock.hear(boot_ms, Duration::from_secs_f64(heard_s));
            clock.round_trip(Duration::from_secs_f64(2.0 * delay_s), Duration::from_secs_f64(heard_s));
            last_s = clock.ground_time_s(boot_ms).unwrap() - flown_s;
        }
        (clock, last_s)
    }

    #[test]
    fn a_steady_link_gives_the_time_at_which_it_was_flown() {
        let (clock, error_s) = clock(0.0, 0.2, |_| 0.0, 50);
        assert!(error_s.abs() < 2e-3, "{error_s}");
        assert!((clock.delay_s().unwrap() - 0.2).abs() < 1e-9);
    }

    #[test]
    fn a_stalled_ground_station_takes_late_messages_for_late() {
        let (mut clock, _) = clock(0.0, 0.0, |_| 0.0, 100);
        // Eight seconds of messages, of which the last was flown at 118 s, all read at that time; then as before.
        for index in 100..260 {
            let flown_s = 100.0 + 0.1 * index as f64;
            let boot_ms = ((flown_s - 90.0) * 1e3).round() as u32;
            clock.hear(boot_ms, Duration::from_secs_f64(f64::max(flown_s, 118.0)));
            let error_s = clock.ground_time_s(boot_ms).unwrap() - flown_s;
            assert!(error_s.abs() < 2e-3, "{flown_s}: {error_s}");
        }
    }

    #[test]
    fn a_clock_that_stood_still_may_be_wrong_by_as_much() {
        let (mut clock, _) = clock(0.0, 0.01, |index| 0.002 * (index % 4) as f64, 100);
        assert!(clock.lateness_s().unwrap() < 3e-3, "{:?}", clock.lateness_s());
        // The simulator stands for two seconds, then it goes on.
        for index in 120..132 {
            let flown_s = 100.0 + 0.1 * index as f64;
            let boot_ms = ((flown_s - 2.0 - 90.0) * 1e3).round() as u32;
            clock.hear(boot_ms, Duration::from_secs_f64(flown_s + 0.01));
            let error_s = (clock.ground_time_s(boot_ms).unwrap() - flown_s).abs();
            let lateness_s = clock.lateness_s().unwrap();
            assert!(error_s < lateness_s + DRIFT_MAX * RECENT_S + 0.01, "{index}: {error_s} {lateness_s}");
        }
    }

    #[test]
    fn a_reboot_begins_anew() {
        let (mut clock, _) = clock(0.0, 0.0, |_| 0.0, 50);
        clock.hear(100, Duration::from_secs(200));
        assert_eq!(clock.reboots(), 1);
        assert!((clock.ground_time_s(100).unwrap() - 200.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn jitter_and_drift_are_taken_out(drift in -0.05..0.05f64, seed in 0..1000usize) {
            // Half of the messages come up to 20 ms late.
            let late = |index: usize| match (index * 7919 + seed).is_multiple_of(2) {
                true => 0.0,
                false => ((index * 104_729 + seed) % 20) as f64 * 1e-3,
            };
            let (_, error_s) = clock(drift, 0.0, late, 120);
            prop_assert!(error_s.abs() < 0.015, "{error_s}");
        }
    }
}
