//! Commands about the autopilot itself: its calibration, a battery that was changed, and starting it anew.

use crate::autopilot::Autopilot;
use crate::error::Severity;
use crate::firmware::Personality;
use crate::parameters::Parameter;
use crate::protocol::command::{Refusal, check_finite, integer};
use crate::protocol::mission::Uploads;
use crate::protocol::parameter::Listings;
use crate::vehicle::Vehicle;
use crate::world::BatterySettings;

impl Autopilot {
    /// PREFLIGHT_CALIBRATION. Param 1: 1 for the gyroscopes; param 3: 1 for the barometer, whose drift starts anew.
    pub(crate) fn calibrate(&mut self, [gyroscopes, barometer]: [f32; 2]) -> Result<(), Refusal> {
        if self.flight.is_armed() {
            return Err(Refusal::failed("Disarm to allow calibration"));
        }
        if gyroscopes == 1.0 {
            return Ok(());
        }
        if barometer == 1.0 {
            self.world.barometer_drift_m = 0.0;
            self.say(Severity::Info, "Barometer calibration complete");
            return Ok(());
        }
        Err(Refusal::unsupported())
    }

    /// BATTERY_RESET. Param 1: bits of the batteries, of which there is one. Param 2: how full it is now, percent.
    pub(crate) fn reset_battery(&mut self, [batteries, percent]: [f32; 2]) -> Result<(), Refusal> {
        check_finite("Battery", &[batteries, percent])?;
        if integer(batteries) & 1 != 0 {
            let left = f64::from(percent.clamp(0.0, 100.0)) / 100.0;
            let capacity_mah = f64::from(self.parameters.get(Parameter::BatteryCapacity));
            self.world.battery.reset(&BatterySettings::of(&self.parameters), capacity_mah, left);
        }
        Ok(())
    }

    /// DO_SEND_BANNER: who it is, in words.
    pub(crate) fn send_banner(&mut self) {
        let [major, minor, patch] = self.settings.personality.version();
        let name = self.settings.personality.product();
        self.say(Severity::Info, &format!("{name} V{major}.{minor}.{patch}"));
    }
}

impl Vehicle {
    /// PREFLIGHT_REBOOT_SHUTDOWN. Param 1: 1 to start anew, or 3, for a boot loader that there is none of.
    pub(crate) fn reboot(&mut self, p1: f32) -> Result<(), Refusal> {
        let is_px4 = self.autopilot.settings.personality == Personality::Px4;
        if self.autopilot.flight.is_armed() {
            let reason = "Reboot: it is armed";
            return Err(if is_px4 { Refusal::denied(reason) } else { Refusal::failed(reason) });
        }
        match p1 {
            1.0 | 3.0 => self.start_anew(),
            // PX4: nothing for the autopilot.
            0.0 if is_px4 => {}
            _ if is_px4 => return Err(Refusal::denied("Reboot: param 1 must be 1")),
            _ => return Err(Refusal::unsupported()),
        }
        Ok(())
    }

    /// As it was switched on, where it stands: parameters and plans are kept, and all that has been told it since is gone.
    /// Its time goes on, for the clock does.
    fn start_anew(&mut self) {
        self.listings = Listings::default();
        self.uploads = Uploads::default();
        self.autopilot.reboot();
        let time = self.autopilot.time;
        self.links().restart(time);
        (0..self.peers().len()).for_each(|link| self.announce(link));
        self.autopilot.send_banner();
    }
}
