//! The channels that a pilot's sticks move.

use crate::autopilot::flight::manual::Sticks;
use std::time::Duration;

/// How many channels there are.
pub(crate) const CHANNELS: usize = 16;
/// Where the channels are without anybody's hand on them, microseconds: roll, pitch, throttle, rudder, four switches,
/// and eight that the receiver has not.
const AT_REST_US: [u16; CHANNELS] = [1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800, 0, 0, 0, 0, 0, 0, 0, 0];
/// What a pulse and its mirror image make together, microseconds.
const MIRROR_US: u16 = 3000;
/// Half of the middle of a stick that counts as centred, as a share: ArduPilot's 30 microseconds.
const DEAD_ZONE: f64 = 0.06;

/// The throttle that a receiver sends which has lost its transmitter (SIM_RC_FAIL 2), microseconds.
const THROTTLE_LOST_US: u16 = 950;
const THROTTLE: usize = 2;

/// The channels: those that are overridden, and the receiver's.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Channels {
    /// Where they were put by messages, microseconds, and when, vehicle time.
    overrides: [Option<(u16, Duration)>; CHANNELS],
    override_time: OverrideTime,
    /// When one was last put anywhere.
    moved: Option<Duration>,
    /// Where the receiver has them, if somebody moves its sticks.
    received: [Option<u16>; CHANNELS],
    receiver: Receiver,
    /// Whether the sticks are taken for centred, and the throttle for closed, wherever they are.
    is_neutral: bool,
}

/// RC_OVERRIDE_TIME: how long a channel stays where a message has put it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OverrideTime {
    /// Messages do not move it.
    Never,
    For(Duration),
    /// Until it is given back.
    Forever,
}

impl Default for OverrideTime {
    fn default() -> Self {
        Self::of_s(3.0)
    }
}

impl OverrideTime {
    /// 0 is never, below 0 for ever.
    pub fn of_s(value_s: f32) -> Self {
        match value_s {
            value_s if value_s > 0.0 => Self::For(Duration::from_secs_f32(value_s)),
            value_s if value_s < 0.0 => Self::Forever,
            _ => Self::Never,
        }
    }
}

/// SIM_RC_FAIL: how a receiver fails.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Receiver {
    #[default]
    Works,
    /// Nothing comes.
    Silent,
    /// The sticks are centred, and the throttle is below its range.
    ThrottleLost,
}

/// What the receiver says in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pulses {
    /// Whether anything has come: from the receiver, or by messages.
    pub have_come: bool,
    pub throttle_us: u16,
}

impl Channels {
    /// 0 gives a channel back.
    pub fn put(&mut self, channel: usize, microseconds: u16, time: Duration) {
        self.overrides[channel] = (microseconds != 0).then_some((microseconds, time));
        self.moved = Some(time);
    }

    /// All channels are the receiver's again.
    pub fn give_back_all(&mut self) {
        self.overrides = [None; CHANNELS];
    }

    pub fn set_override_time(&mut self, override_time: OverrideTime) {
        self.override_time = override_time;
    }

    /// What the receiver hears of its transmitter, microseconds; 0 leaves a channel. One that has failed hears nothing.
    pub fn receive(&mut self, pulses_us: &[u16]) {
        if self.receiver != Receiver::Works {
            return;
        }
        for (received, &pulse_us) in self.received.iter_mut().zip(pulses_us).filter(|(_, pulse_us)| **pulse_us != 0) {
            *received = Some(pulse_us);
        }
    }

    /// The receiver works, or fails. What it has said last it says on.
    pub fn set_receiver(&mut self, receiver: Receiver) {
        self.receiver = receiver;
        if receiver == Receiver::ThrottleLost {
            self.received = [Some(1500); CHANNELS];
            self.received[THROTTLE] = Some(THROTTLE_LOST_US);
        }
    }

    pub fn set_neutral(&mut self, is_neutral: bool) {
        self.is_neutral = is_neutral;
    }

    /// What has come in a step that ends at a time and began a step before.
    pub fn pulses(&self, time: Duration, step: Duration) -> Pulses {
        let by_message = self.moved.is_some_and(|moved| time.saturating_sub(moved) <= step);
        let throttle_us = self.placed(THROTTLE, time).unwrap_or(AT_REST_US[THROTTLE]);
        Pulses { have_come: self.receiver != Receiver::Silent || by_message, throttle_us }
    }

    fn overridden(&self, channel: usize, time: Duration) -> Option<u16> {
        let is_held = |since: Duration| match self.override_time {
            OverrideTime::Never => false,
            OverrideTime::For(long) => time.saturating_sub(since) < long,
            OverrideTime::Forever => true,
        };
        self.overrides[channel].filter(|(_, since)| is_held(*since)).map(|(microseconds, _)| microseconds)
    }

    /// Where somebody has put a channel.
    fn placed(&self, channel: usize, time: Duration) -> Option<u16> {
        self.overridden(channel, time).or(self.received[channel])
    }

    /// What the sticks say; none while nobody holds any. `reversed` tells of roll, pitch and throttle whether more
    /// microseconds mean less.
    pub fn sticks(&self, time: Duration, reversed: [bool; 3]) -> Option<Sticks> {
        if self.is_neutral {
            return Some(Sticks { roll: 0.0, pitch: 0.0, throttle: Some(0.0) });
        }
        let held = [0, 1, THROTTLE].map(|channel| {
            let pulse_us = self.placed(channel, time);
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
        let long_enough = match self.override_time {
            OverrideTime::Never => Duration::ZERO,
            OverrideTime::For(long) => long,
            OverrideTime::Forever => Duration::MAX,
        };
        let by_message = self
            .moved
            .is_some_and(|moved| time.saturating_sub(moved) < long_enough.saturating_add(Duration::from_secs(1)));
        by_message || self.received.iter().any(Option::is_some)
    }

    /// Whether somebody holds the sticks.
    pub fn are_held(&self, time: Duration) -> bool {
        (0..3).any(|channel| self.placed(channel, time).is_some())
    }

    /// Where all channels are, microseconds.
    pub fn positions_us(&self, time: Duration) -> [u16; CHANNELS] {
        std::array::from_fn(|channel| self.position_us(channel, time))
    }

    /// Where a channel is, microseconds.
    pub fn position_us(&self, channel: usize, time: Duration) -> u16 {
        // Roll, pitch and rudder.
        if self.is_neutral && matches!(channel, 0 | 1 | 3) {
            return AT_REST_US[channel];
        }
        self.placed(channel, time).unwrap_or(AT_REST_US[channel])
    }
}
