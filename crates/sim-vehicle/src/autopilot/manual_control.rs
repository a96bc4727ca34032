//! The pilot's sticks, as RC_CHANNELS_OVERRIDE and MANUAL_CONTROL move them.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

use crate::autopilot::flight::Sticks;
use crate::firmware::Personality;
use crate::parameters::Parameter;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MANUAL_CONTROL_DATA, Message, RC_CHANNELS_DATA, RC_CHANNELS_OVERRIDE_DATA};
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
    fn put(&mut self, channel: usize, microseconds: u16, time: Duration) {
        self.0[channel] = (microseconds != 0).then_some((microseconds, time + OVERRIDE_TIME));
    }

    fn overridden(&self, channel: usize, time: Duration) -> Option<u16> {
        self.0[channel].filter(|(_, until)| time < *until).map(|(microseconds, _)| microseconds)
    }

    /// What the sticks say; none while nobody holds any.
    fn sticks(&self, time: Duration) -> Option<Sticks> {
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

    /// Where the channels are, microseconds.
    pub fn pulses_us(&self, time: Duration) -> [u16; 8] {
        std::array::from_fn(|channel| self.overridden(channel, time).unwrap_or(AT_REST_US[channel]))
    }

    /// RC_CHANNELS (<https://mavlink.io/en/messages/common.html#RC_CHANNELS>).
    pub fn message(&self, time: Duration) -> Message {
        let pulses_us = self.pulses_us(time);
        let at = |channel: usize| pulses_us[channel];
        Message::RC_CHANNELS(RC_CHANNELS_DATA {
            time_boot_ms: time.as_millis() as u32,
            chan1_raw: at(0),
            chan2_raw: at(1),
            chan3_raw: at(2),
            chan4_raw: at(3),
            chan5_raw: at(4),
            chan6_raw: at(5),
            chan7_raw: at(6),
            chan8_raw: at(7),
            chancount: 8,
            rssi: u8::MAX,
            ..RC_CHANNELS_DATA::DEFAULT
        })
    }
}

impl Vehicle {
    /// Microseconds for each channel; 0 gives it back, 65535 leaves it.
    pub(crate) fn override_channels(&mut self, system_id: u8, data: &RC_CHANNELS_OVERRIDE_DATA) {
        let channels = [
            data.chan1_raw,
            data.chan2_raw,
            data.chan3_raw,
            data.chan4_raw,
            data.chan5_raw,
            data.chan6_raw,
            data.chan7_raw,
            data.chan8_raw,
        ];
        if self.is_from_pilot(system_id) {
            for (channel, microseconds) in channels.into_iter().enumerate().filter(|(_, value)| *value != u16::MAX) {
                self.channels.put(channel, microseconds, self.time);
            }
        }
    }

    /// x is forward, which is nose down, y right, r yaw, each -1000 to 1000; z throttle, 0 to 1000; 32767: not held.
    pub(crate) fn control_manually(&mut self, system_id: u8, data: &MANUAL_CONTROL_DATA) {
        if !self.is_from_pilot(system_id) {
            return;
        }
        let centred = |value: i16, sign: i32| {
            if value == i16::MAX { 0 } else { (1500 + sign * i32::from(value) / 2).clamp(1000, 2000) as u16 }
        };
        let throttle = if data.z == i16::MAX { 0 } else { (1000 + i32::from(data.z)).clamp(1000, 2000) as u16 };
        let channels = [centred(data.y, 1), centred(data.x, -1), throttle, centred(data.r, 1)];
        for (channel, microseconds) in channels.into_iter().enumerate() {
            self.channels.put(channel, microseconds, self.time);
        }
        self.hear_heartbeat(system_id);
    }

    /// Lets the flight have what the sticks say now.
    pub(crate) fn move_sticks(&mut self) {
        self.flight.set_sticks(self.channels.sticks(self.time));
    }

    /// Whether somebody holds the sticks.
    pub(crate) fn are_sticks_held(&self) -> bool {
        self.channels.sticks(self.time).is_some()
    }

    /// Only the ground station of MAV_GCS_SYSID may move the sticks; to a PX4 all are the same.
    fn is_from_pilot(&self, system_id: u8) -> bool {
        self.settings.personality == Personality::Px4
            || f32::from(system_id) == self.parameters.get(Parameter::GroundSystemId)
    }
}
