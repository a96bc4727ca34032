//! Attitudes that somebody else sets. An ArduPlane forgets each axis by itself when no message has set it for some
//! time; a PX4 follows the last one until its stream ends.

use super::Autopilot;
use super::flight::attitude::AttitudeTarget;
use super::timer::Timer;
use std::time::Duration;

/// How long an ArduPlane flies by what a message has set (`ModeGuided::update`).
const FORCED: Duration = Duration::from_secs(3);

impl Autopilot {
    /// Flies by what a target sets for three seconds, each axis by itself; what it does not set stays as it is.
    pub(crate) fn force_attitude(&mut self, target: &AttitudeTarget) {
        let mut flown = self.flight.attitude().copied().unwrap_or_default();
        let timers = &mut self.session.timers;
        let end = self.time.saturating_add(FORCED);
        for (is_set, timer) in [
            (target.roll.is_some(), Timer::ForcedRoll),
            (target.pitch.is_some(), Timer::ForcedPitch),
            (target.throttle.is_some(), Timer::ForcedThrottle),
        ] {
            if is_set {
                timers.set(timer, end);
            }
        }
        flown.roll = target.roll.or(flown.roll);
        flown.pitch = target.pitch.or(flown.pitch);
        flown.throttle = target.throttle.or(flown.throttle);
        flown.takes_off = target.takes_off;
        self.flight.set_attitude(Some(flown));
        self.count_setpoint();
        self.restart_setpoint_timeout();
    }

    /// Flies by a target until another one comes.
    pub(crate) fn follow_attitude(&mut self, target: &AttitudeTarget) {
        self.flight.set_attitude(Some(*target));
        self.count_setpoint();
    }

    /// What has been set for three seconds and not again is forgotten.
    #[inline]
    pub(super) fn forget_attitude(&mut self) {
        let Some(flown) = self.flight.attitude().copied() else { return };
        let is_over = |timer| self.session.timers.is_over(timer, self.time);
        let left = AttitudeTarget {
            roll: flown.roll.filter(|_| !is_over(Timer::ForcedRoll)),
            pitch: flown.pitch.filter(|_| !is_over(Timer::ForcedPitch)),
            throttle: flown.throttle.filter(|_| !is_over(Timer::ForcedThrottle)),
            ..flown
        };
        if left != flown {
            self.flight.set_attitude(Some(left));
        }
    }
}
