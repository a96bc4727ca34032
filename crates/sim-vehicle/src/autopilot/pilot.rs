//! A pilot's sticks, as RC_CHANNELS_OVERRIDE and MANUAL_CONTROL move them.

use super::Autopilot;
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
    /// RC_CHANNELS_OVERRIDE: microseconds for each channel; 0 gives it back, 65535 leaves it.
    pub(crate) fn override_channels(&mut self, system_id: u8, channels: [u16; 8]) {
        if !self.is_from_pilot(system_id) {
            return;
        }
        for (channel, microseconds) in channels.into_iter().enumerate().filter(|(_, value)| *value != u16::MAX) {
            self.session.channels.put(channel, microseconds, self.time);
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
        self.flight.set_sticks(self.session.channels.sticks(self.time));
    }

    /// Only the ground station of MAV_GCS_SYSID may move the sticks; to a PX4 all are the same.
    fn is_from_pilot(&self, system_id: u8) -> bool {
        self.rules.any_ground_station || f32::from(system_id) == self.parameters.get(Parameter::GroundSystemId)
    }
}
