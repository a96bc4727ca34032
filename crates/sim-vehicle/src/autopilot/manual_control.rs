//! The channels that a pilot's sticks move.

use crate::autopilot::flight::manual::Sticks;
use std::time::Duration;

/// ArduPilot's default of RC_OVERRIDE_TIME: how long a channel stays where it was put.
const OVERRIDE_TIME: Duration = Duration::from_secs(3);
/// Where the channels are without anybody's hand on them, microseconds: roll, pitch, throttle, rudder, four switches.
const AT_REST_US: [u16; 8] = [1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800];
/// Half of the middle of a stick that counts as centred, as a share: ArduPilot's 30 microseconds.
const DEAD_ZONE: f64 = 0.06;

/// The channels that are overridden: where they are, microseconds, and until when, vehicle time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Channels([Option<(u16, Duration)>; 8]);

impl Channels {
    /// 0 gives a channel back.
    pub fn put(&mut self, channel: usize, microseconds: u16, time: Duration) {
        self.0[channel] = (microseconds != 0).then_some((microseconds, time + OVERRIDE_TIME));
    }

    fn overridden(&self, channel: usize, time: Duration) -> Option<u16> {
        self.0[channel].filter(|(_, until)| time < *until).map(|(microseconds, _)| microseconds)
    }

    /// What the sticks say; none while nobody holds any.
    pub fn sticks(&self, time: Duration) -> Option<Sticks> {
        let held = [0, 1, 2].map(|channel| self.overridden(channel, time));
        held.iter().any(Option::is_some).then(|| {
            let [roll, pitch, throttle] = held;
            let deflection = |microseconds: Option<u16>| {
                let share = (f64::from(microseconds.unwrap_or(1500)) - 1500.0) / 500.0;
                if share.abs() <= DEAD_ZONE { 0.0 } else { share.clamp(-1.0, 1.0) }
            };
            let share = |microseconds: u16| ((f64::from(microseconds) - 1000.0) / 1000.0).clamp(0.0, 1.0);
            Sticks { roll: deflection(roll), pitch: deflection(pitch), throttle: throttle.map(share) }
        })
    }

    /// Whether somebody holds the sticks.
    pub fn are_held(&self, time: Duration) -> bool {
        self.sticks(time).is_some()
    }

    /// Where all channels are, microseconds.
    pub fn positions_us(&self, time: Duration) -> [u16; 8] {
        std::array::from_fn(|channel| self.overridden(channel, time).unwrap_or(AT_REST_US[channel]))
    }
}
