//! The shared simulated clock: who moves it, and what is done while it stands.
//!
//! A vehicle at time t moves on to t + T only with the setpoint stamped t. So no loss, delay, repetition or reordering
//! of datagrams changes a flight: an old stamp, or one that is not t, moves nothing. While the vehicle waits it sends
//! its last telemetry again, for that or the answer to it may be lost.

use crate::settings::LockstepSettings;
use mavlink_bridge::boot_ms;
use std::time::Duration;

#[derive(Debug)]
pub(crate) struct Lockstep {
    settings: LockstepSettings,
    released: bool,
    wait: Duration,
    resend_at: Duration,
}

impl Lockstep {
    pub fn new(settings: LockstepSettings) -> Self {
        Self { settings, released: false, wait: settings.resend_after, resend_at: settings.resend_after }
    }

    /// Takes a setpoint's stamp at vehicle time `time`: whether it is the one that is waited for.
    pub fn accept(&mut self, stamp_ms: u32, time: Duration) -> bool {
        let awaited = !self.released && stamp_ms == boot_ms(time);
        self.released |= awaited;
        awaited
    }

    /// How far the vehicle may move on from `time`; none while it waits.
    pub fn released_until(&self, time: Duration) -> Option<Duration> {
        self.released.then(|| time.saturating_add(self.settings.period))
    }

    /// The vehicle has moved on, at host time `now`, and waits for the next setpoint.
    pub fn wait_from(&mut self, now: Duration) {
        self.released = false;
        self.wait = self.settings.resend_after;
        self.resend_at = now.saturating_add(self.wait);
    }

    /// Host time at which to ask again; none if nothing is waited for.
    pub fn resend_at(&self) -> Option<Duration> {
        (!self.released).then_some(self.resend_at)
    }

    /// Whether it is time to ask again at host time `now`. The next time is put off, twice as far.
    pub fn take_resend(&mut self, now: Duration) -> bool {
        let due = !self.released && now >= self.resend_at;
        if due {
            self.wait = self.wait.saturating_mul(2).min(self.settings.resend_at_most);
            self.resend_at = now.saturating_add(self.wait);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn only_the_stamp_of_now_releases_and_only_once() {
        let mut lockstep = Lockstep::new(LockstepSettings::default());
        for stamp in [0, 500, 999, 1_001, 1_500, u32::MAX] {
            assert!(!lockstep.accept(stamp, ms(1_000)));
        }
        assert_eq!(lockstep.released_until(ms(1_000)), None);
        assert!(lockstep.accept(1_000, ms(1_000)));
        assert!(!lockstep.accept(1_000, ms(1_000)));
        assert_eq!(lockstep.released_until(ms(1_000)), Some(ms(1_500)));
    }

    #[test]
    fn the_wait_doubles_to_its_bound() {
        let mut lockstep = Lockstep::new(LockstepSettings::default());
        lockstep.wait_from(ms(1_000));
        let mut times = Vec::new();
        for now in 1_000..1_500 {
            if lockstep.take_resend(ms(now)) {
                times.push(now);
            }
        }
        assert_eq!(times, [1_005, 1_015, 1_035, 1_075, 1_155, 1_255, 1_355, 1_455]);
        lockstep.accept(0, ms(0));
        assert_eq!(lockstep.resend_at(), None);
        assert!(!lockstep.take_resend(ms(9_000)));
    }
}
