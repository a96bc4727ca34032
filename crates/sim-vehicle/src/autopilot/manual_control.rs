//! The channels that a pilot's sticks move.

use crate::autopilot::flight::manual::Sticks;
use std::time::Duration;

/// ArduPilot's default of RC_OVERRIDE_TIME: how long a channel stays where it was put.
const OVERRIDE_TIME: Duration = Duration::from_secs(3);
/// How many channels there are.
pub(crate) const CHANNELS: usize = 16;
/// Where the channels are without anybody's hand on them, microseconds: roll, pitch, throttle, rudder, four switches,
/// and eight that the receiver has not.
const AT_REST_US: [u16; CHANNELS] = [1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800, 0, 0, 0, 0, 0, 0, 0, 0];
/// What a pulse and its mirror image make together, microseconds.
const MIRROR_US: u16 = 3000;
/// Half of the middle of a stick that counts as centred, as a share: ArduPilot's 30 microseconds.
const DEAD_ZONE: f64 = 0.06;

/// The channels that are overridden: where they are, microseconds, and until when, vehicle time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Channels {
    held: [Option<(u16, Duration)>; CHANNELS],
    /// When one was last put anywhere.
    moved: Option<Duration>,
}

impl Channels {
    /// 0 gives a channel back.
    pub fn put(&mut self, channel: usize, microseconds: u16, time: Duration) {
        self.held[channel] = (microseconds != 0).then_some((microseconds, time + OVERRIDE_TIME));
        self.moved = Some(time);
    }

    fn overridden(&self, channel: usize, time: Duration) -> Option<u16> {
        self.held[channel].filter(|(_, until)| time < *until).map(|(microseconds, _)| microseconds)
    }

    /// What the sticks say; none while nobody holds any. `reversed` tells of roll, pitch and throttle whether more
    /// microseconds mean less.
    pub fn sticks(&self, time: Duration, reversed: [bool; 3]) -> Option<Sticks> {
        let held = [0, 1, 2].map(|channel| {
            let pulse_us = self.overridden(channel, time);
            pulse_us.map(|pulse_us| if reversed[channel] { MIRROR_US.saturating_sub(pulse_us) } else { pulse_us })
        });
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

    /// Whether somebody holds a channel, or has let go of it within the last second.
    pub fn have_moved(&self, time: Duration) -> bool {
        self.moved.is_some_and(|moved| time < moved + OVERRIDE_TIME + Duration::from_secs(1))
    }

    /// Whether somebody holds the sticks.
    pub fn are_held(&self, time: Duration) -> bool {
        (0..3).any(|channel| self.overridden(channel, time).is_some())
    }

    /// Where all channels are, microseconds.
    pub fn positions_us(&self, time: Duration) -> [u16; CHANNELS] {
        std::array::from_fn(|channel| self.position_us(channel, time))
    }

    /// Where a channel is, microseconds.
    pub fn position_us(&self, channel: usize, time: Duration) -> u16 {
        self.overridden(channel, time).unwrap_or(AT_REST_US[channel])
    }
}
