//! Everything that an autopilot times, in one table. All times are vehicle times.

use std::time::Duration;

/// What is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Timer {
    /// Until when a setpoint must come.
    SetpointTimeout,
    /// Until when no further refused setpoint is put into words.
    QuietSetpoints,
    /// Until when what stands against arming is not said again.
    ArmingReason,
    /// Until when a pilot outside the fence may come back by himself.
    ManualRecovery,
    /// Until when the vehicle holds for want of a ground station, before it does more.
    GroundHold,
    /// Since when it has not flown.
    Flown,
    /// Since when the ground station has been silent.
    GroundStation,
    /// Since when the voltage is low.
    BatteryLow,
    /// Since when it is critical.
    BatteryCritical,
    /// Since when no setpoint has come for the offboard stream.
    OffboardStream,
    /// Since when it is armed on the ground and has not flown.
    ArmedIdle,
    /// Until when it flies by the bank that somebody has set.
    ForcedRoll,
    /// The same of the pitch.
    ForcedPitch,
    /// The same of the throttle.
    ForcedThrottle,
}

/// The times that are set.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Timers([Option<Duration>; Timer::ForcedThrottle as usize + 1]);

impl Timers {
    /// A timer ends at a time, or has begun at it.
    pub fn set(&mut self, timer: Timer, at: Duration) {
        self.0[timer as usize] = Some(at);
    }

    pub fn clear(&mut self, timer: Timer) {
        self.0[timer as usize] = None;
    }

    pub fn is_set(&self, timer: Timer) -> bool {
        self.0[timer as usize].is_some()
    }

    /// Whether a timer is set and its end has not come.
    pub fn is_running(&self, timer: Timer, now: Duration) -> bool {
        self.0[timer as usize].is_some_and(|end| now < end)
    }

    /// Whether a timer is set and its end has come.
    pub fn is_over(&self, timer: Timer, now: Duration) -> bool {
        self.0[timer as usize].is_some_and(|end| now >= end)
    }

    /// Begins to measure, unless that has begun.
    pub fn begin(&mut self, timer: Timer, now: Duration) {
        self.0[timer as usize].get_or_insert(now);
    }

    /// How long ago a timer has begun; none if it has not.
    pub fn since(&self, timer: Timer, now: Duration) -> Option<Duration> {
        self.0[timer as usize].map(|begun| now.saturating_sub(begun))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timer_runs_until_its_end_and_measures_from_its_beginning() {
        let [zero, one, two] = [0, 1, 2].map(Duration::from_secs);
        let mut timers = Timers::default();
        assert!(!timers.is_running(Timer::QuietSetpoints, zero) && !timers.is_over(Timer::QuietSetpoints, two));
        timers.set(Timer::QuietSetpoints, one);
        assert!(timers.is_running(Timer::QuietSetpoints, zero) && timers.is_over(Timer::QuietSetpoints, one));
        timers.begin(Timer::Flown, one);
        timers.begin(Timer::Flown, two);
        assert_eq!(timers.since(Timer::Flown, two), Some(one));
        timers.clear(Timer::Flown);
        assert_eq!((timers.since(Timer::Flown, two), timers.is_set(Timer::Flown)), (None, false));
    }
}
