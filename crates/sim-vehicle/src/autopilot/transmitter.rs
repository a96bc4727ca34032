//! A pilot's transmitter and its receiver: what the receiver says, its failsafes, and arming by the rudder stick.

use super::Autopilot;
use super::arming::Cause;
use super::manual_control::{OverrideTime, Receiver};
use crate::parameters::table::Parameter;
use std::time::Duration;

/// ARMING_RUDDER.
const RUDDER_ARMS: f32 = 1.0;
const RUDDER_DISARMS_TOO: f32 = 2.0;
/// How long the rudder stick must be held.
const RUDDER_HELD: Duration = Duration::from_secs(3);
/// From there on it counts, in microseconds from the middle: 40 of its 45 degrees, behind the dead zone.
const RUDDER_US: i32 = 448;
const DEAD_ZONE_US: u16 = 30;
const RUDDER: usize = 3;
const THROTTLE: usize = 2;

/// Since when the rudder stick is held to one side.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RudderStick {
    since: Option<Duration>,
}

impl Autopilot {
    /// What a receiver hears of its transmitter, microseconds for each channel; 0 leaves it.
    pub(crate) fn receive_channels(&mut self, pulses_us: &[u16]) {
        self.session.channels.receive(pulses_us);
    }

    /// Looks at what the receiver says, and does what follows.
    pub(super) fn watch_receiver(&mut self) {
        if !self.rules.has_switches {
            return;
        }
        let get = |parameter: Parameter| self.parameters.get(parameter);
        let receiver = match get(Parameter::ReceiverFail) as u8 {
            0 => Receiver::Works,
            1 => Receiver::Silent,
            _ => Receiver::ThrottleLost,
        };
        let override_time = OverrideTime::of_s(get(Parameter::OverrideTime));
        self.session.channels.set_receiver(receiver);
        self.session.channels.set_override_time(override_time);
        let step = self.step;
        let (now, session, events) = self.split();
        let pulses = session.channels.pulses(now.time, step);
        session.failsafes.receiver.read(&now, pulses, events);
        session.channels.set_neutral(!session.failsafes.receiver.is_well());
        let ground_is_lost = session.failsafes.ground_station.is_lost();
        if let Some(proposal) = session.failsafes.receiver.check(&now, ground_is_lost, events) {
            self.act(proposal);
        }
        self.watch_rudder();
    }

    /// Whether what the transmitter says counts.
    pub(crate) fn hears_transmitter(&self) -> bool {
        self.session.failsafes.receiver.is_well()
    }

    /// Whether the throttle failsafe is on.
    pub(super) fn has_failed_receiver(&self) -> bool {
        self.session.failsafes.receiver.has_failed()
    }

    /// Why the sticks do not let it arm, if so (`AP_Arming::rc_arm_checks`).
    pub(super) fn against_sticks(&self, by_rudder: bool) -> Option<String> {
        if !self.rules.has_switches || !self.hears_transmitter() {
            return None;
        }
        let pulse_us = |channel: usize| self.session.channels.position_us(channel, self.time);
        let is_off = |channel: usize| pulse_us(channel).abs_diff(1500) > DEAD_ZONE_US;
        let named = [("Roll", 0), ("Pitch", 1), ("Yaw", RUDDER)];
        let stick = named.into_iter().find(|(_, channel)| is_off(*channel) && !(by_rudder && *channel == RUDDER));
        let throttle = (!self.is_throttle_closed()).then_some(("Throttle", THROTTLE));
        stick.or(throttle).map(|(name, channel)| format!("{name} (RC{}) is not neutral", channel + 1))
    }

    fn is_throttle_closed(&self) -> bool {
        let pulse_us = self.session.channels.position_us(THROTTLE, self.time);
        let is_reversed = self.parameters.get(Parameter::ThrottleReversed) != 0.0;
        if is_reversed { pulse_us >= 2000 - DEAD_ZONE_US } else { pulse_us <= 1000 + DEAD_ZONE_US }
    }

    /// The rudder stick that is held to the right for 3 s arms, with the throttle closed, and to the left disarms.
    fn watch_rudder(&mut self) {
        let wanted = self.parameters.get(Parameter::RudderArming);
        let pulse_us = i32::from(self.session.channels.position_us(RUDDER, self.time)) - 1500;
        let arms = pulse_us > RUDDER_US;
        let is_held = arms && self.is_throttle_closed() || pulse_us < -RUDDER_US;
        if wanted < RUDDER_ARMS || !is_held || !self.hears_transmitter() {
            self.session.rudder = RudderStick::default();
            return;
        }
        let since = *self.session.rudder.since.get_or_insert(self.time);
        if self.time.saturating_sub(since) < RUDDER_HELD {
            return;
        }
        self.session.rudder = RudderStick::default();
        if arms && !self.flight.is_armed() {
            self.arm_by_rudder();
        } else if !arms && wanted == RUDDER_DISARMS_TOO && self.flight.is_armed() && !self.flight.is_flying() {
            self.disarm(Cause::Command);
        }
    }
}
