//! Commands about the autopilot itself: its calibration, a battery that was changed, and starting it anew.

use crate::autopilot::failsafe::Failsafes;
use crate::autopilot::manual_control::Channels;
use crate::firmware::Personality;
use crate::firmware::px4;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::protocol::command::{Command, Refusal, check_finite, integer};
use crate::protocol::mission::Uploads;
use crate::protocol::parameter::Listings;
use crate::vehicle::Vehicle;
use crate::world::BatterySettings;
use mavlink_bridge::CommandPosition;
use mavlink_bridge::dialect::{MavResult, MavSeverity};
use std::time::Duration;

impl Vehicle {
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
            self.say(MavSeverity::MAV_SEVERITY_INFO, "Barometer calibration complete");
            return Ok(());
        }
        Err(Refusal::unsupported())
    }

    /// BATTERY_RESET. Param 1: bits of the batteries, of which there is one. Param 2: how full it is now, percent.
    pub(crate) fn reset_battery(&mut self, [batteries, percent]: [f32; 2]) -> Result<(), Refusal> {
        check_finite("Battery", &[batteries, percent])?;
        if integer(batteries) & 1 != 0 {
            self.reset_battery_to(f64::from(percent.clamp(0.0, 100.0)) / 100.0);
        }
        Ok(())
    }

    /// How full the battery is from now on, 0 to 1.
    fn reset_battery_to(&mut self, left: f64) {
        let capacity_mah = f64::from(self.parameters.get(Parameter::BatteryCapacity));
        self.world.battery.reset(&BatterySettings::of(&self.parameters), capacity_mah, left);
    }

    /// DO_SEND_BANNER: who it is, in words.
    pub(crate) fn send_banner(&mut self) {
        let [major, minor, patch] = self.settings.personality.version();
        let name = self.settings.personality.product();
        self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("{name} V{major}.{minor}.{patch}"));
    }

    /// PREFLIGHT_REBOOT_SHUTDOWN. Param 1: 1 to start anew, or 3, for a boot loader that there is none of. An armed ArduPlane
    /// does so by force alone: param 6 is 20190226. To a PX4 param 1 = 0 asks for nothing.
    pub(crate) fn reboot(&mut self, command: &Command) -> Result<(), Refusal> {
        let p1 = command.params[0];
        if self.settings.personality == Personality::Px4 {
            return match integer(p1) {
                0 => Ok(()),
                1 | 3 if !self.flight.is_armed() => {
                    self.start_anew();
                    Ok(())
                }
                _ => Err(Refusal::denied("Reboot: it is armed, or param 1 is neither 0, 1 nor 3")),
            };
        }
        if self.flight.is_armed() && !is_reboot_forced(command) {
            return Err(Refusal::failed("Reboot: it is armed"));
        }
        if p1 != 1.0 && p1 != 3.0 {
            return Err(Refusal::new(MavResult::MAV_RESULT_UNSUPPORTED, "Reboot: param 1 must be 1 or 3"));
        }
        self.start_anew();
        Ok(())
    }

    /// As it was switched on, where it stands: parameters and plans are kept, and all that has been told it since is gone, its
    /// home too. Its time goes on, for the clock does.
    fn start_anew(&mut self) {
        if self.flight.is_armed() {
            self.disarm();
        }
        let first = if self.settings.on_ground { Mode::Manual } else { self.settings.mode };
        let mode = self.settings.personality.first_mode(first, self.lockstep.is_some());
        self.failsafes = Failsafes::new();
        self.channels = Channels::default();
        self.listings = Listings::default();
        self.uploads = Uploads::default();
        self.px4 = px4::State::default();
        self.quiet_until = Duration::ZERO;
        self.home_is_set = false;
        self.arming_reason = None;
        self.arming_reason_due = Duration::ZERO;
        self.set_mode(mode);
        if self.flight.is_on_ground() {
            self.set_home_here();
        } else {
            self.set_home_at((0.0, 0.0), 0.0);
        }
        let usual_mps = f64::from(self.parameters.get(Parameter::AirspeedCruise));
        self.flight.set_speed(usual_mps, f64::INFINITY);
        self.flight.set_least_ground_speed(0.0);
        self.reset_battery_to(1.0);
        self.reset_mission();
        self.fence.forget_breaches();
        self.reconfigure_fence(Parameter::FenceEnable);
        self.links.restart(self.time);
        (0..self.links.len()).for_each(|link| self.announce(link));
        self.send_banner();
    }
}

/// The number that reboots an armed ArduPlane, in param 6 or y.
const REBOOT_BY_FORCE: i32 = 20_190_226;

fn is_reboot_forced(command: &Command) -> bool {
    match command.position {
        CommandPosition::Int(position) => position.longitude_e7 == REBOOT_BY_FORCE,
        CommandPosition::Long([_, p6]) => p6 == REBOOT_BY_FORCE as f32,
    }
}
