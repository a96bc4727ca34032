//! A pilot's sticks, as RC_CHANNELS_OVERRIDE and MANUAL_CONTROL move them.

use super::Autopilot;
use super::manual_control::CHANNELS;
use crate::parameters::table::Parameter;

/// Where MANUAL_CONTROL holds the sticks. x is forward, which is nose down, y right, r yaw, each -1000 to 1000; z
/// throttle, 0 to 1000; 32767: not held.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ManualControl {
    pub x: i16,
    pub y: i16,
    pub z: i16,
    pub r: i16,
}

impl Autopilot {
    /// RC_CHANNELS_OVERRIDE: microseconds for each channel; 0 gives it back, 65535 leaves it. From the ninth on 0
    /// leaves it, and 65534 gives it back.
    pub(crate) fn override_channels(&mut self, system_id: u8, channels: [u16; CHANNELS]) {
        const FIRST_OF_EXTENSION: usize = 8;
        const GIVE_BACK: u16 = u16::MAX - 1;
        if !self.is_from_pilot(system_id) {
            return;
        }
        for (channel, microseconds) in channels.into_iter().enumerate() {
            match microseconds {
                u16::MAX => {}
                0 if channel >= FIRST_OF_EXTENSION => {}
                GIVE_BACK if channel >= FIRST_OF_EXTENSION => self.session.channels.put(channel, 0, self.time),
                held => self.session.channels.put(channel, held, self.time),
            }
        }
    }

    /// MANUAL_CONTROL. It counts as a heartbeat of the pilot's ground station.
    pub(crate) fn control_manually(&mut self, system_id: u8, sticks: ManualControl) {
        if !self.is_from_pilot(system_id) {
            return;
        }
        let centred = |value: i16, sign: i32| {
            if value == i16::MAX { 0 } else { (1500 + sign * i32::from(value) / 2).clamp(1000, 2000) as u16 }
        };
        let throttle = if sticks.z == i16::MAX { 0 } else { (1000 + i32::from(sticks.z)).clamp(1000, 2000) as u16 };
        let channels = [centred(sticks.y, 1), centred(sticks.x, -1), throttle, centred(sticks.r, 1)];
        for (channel, microseconds) in channels.into_iter().enumerate() {
            self.session.channels.put(channel, microseconds, self.time);
        }
        if !self.rules.any_ground_station {
            self.hear_heartbeat(system_id, true);
        }
    }

    /// Lets the flight have what the sticks say now.
    pub(super) fn move_sticks(&mut self) {
        const REVERSED: [Parameter; 3] =
            [Parameter::RollReversed, Parameter::PitchReversed, Parameter::ThrottleReversed];
        let reversed = REVERSED.map(|parameter| self.parameters.get(parameter) != 0.0);
        self.flight.set_sticks(self.session.channels.sticks(self.time, reversed));
    }

    /// Only the ground station of MAV_GCS_SYSID may move the sticks; to a PX4 all are the same.
    fn is_from_pilot(&self, system_id: u8) -> bool {
        self.rules.any_ground_station || f32::from(system_id) == self.parameters.get(Parameter::GroundSystemId)
    }
}
