//! What the vehicle does by itself when something is missing: setpoints, its ground station, charge, a GPS, an engine. Each is said
//! aloud when it begins and when it ends.

mod battery;
mod engine;
mod gps;
mod weather;

pub(crate) use battery::{BatteryLevel, BatteryWatch};

use crate::autopilot::Autopilot;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::Parameter;
use std::time::Duration;

/// Who is missing, and since when; vehicle times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failsafes {
    /// When the lack of setpoints becomes a failsafe.
    setpoints_until: Duration,
    pub setpoints_lost: bool,
    /// The ground station's last heartbeat; none before the first, which nobody waits for.
    ground_heard: Option<Duration>,
    pub ground_lost: bool,
    pub battery: BatteryWatch,
    pub gps_lost: bool,
    pub engine_failed: bool,
    /// Whether the wind is stronger than the airspeed: said, but no failsafe.
    pub is_blown_away: bool,
}

impl Failsafes {
    pub fn new() -> Self {
        Self {
            setpoints_until: Duration::MAX,
            setpoints_lost: false,
            ground_heard: None,
            ground_lost: false,
            battery: BatteryWatch::default(),
            gps_lost: false,
            engine_failed: false,
            is_blown_away: false,
        }
    }

    /// Whether any of them acts.
    pub fn is_any(&self) -> bool {
        self.setpoints_lost
            || self.ground_lost
            || self.gps_lost
            || self.engine_failed
            || self.battery.level() != BatteryLevel::Ok
    }
}

impl Autopilot {
    pub(crate) fn check_failsafes(&mut self) {
        let is_awaited = self.failsafes.setpoints_until != Duration::MAX;
        if is_awaited && !self.flight.is_flying() {
            self.restart_setpoint_timeout();
        }
        if self.time >= self.failsafes.setpoints_until {
            self.failsafes.setpoints_until = Duration::MAX;
            self.failsafes.setpoints_lost = true;
            self.flight.set_mode(Mode::Loiter);
            self.counters.failsafes += 1;
            let text = format!("Failsafe: no setpoint for {} s, LOITER", self.parameters.get(Parameter::GuidedTimeout));
            self.say(Severity::Critical, &text);
        }
        if self.parameters.get(Parameter::GroundFailsafe) != 0.0 {
            self.check_ground();
        }
        self.check_battery();
        self.check_gps();
        self.check_engine();
        self.check_wind();
    }

    /// The time-out runs while the vehicle flies in GUIDED; on the ground nothing is lost yet.
    pub(crate) fn restart_setpoint_timeout(&mut self) {
        let timeout_s = f64::from(self.parameters.get(Parameter::GuidedTimeout));
        let runs = timeout_s > 0.0 && self.flight.is_armed() && self.flight.mode() == Mode::Guided;
        let timeout = if runs { Duration::try_from_secs_f64(timeout_s).ok() } else { None };
        self.failsafes.setpoints_until = timeout.map_or(Duration::MAX, |timeout| self.time.saturating_add(timeout));
    }

    /// Nothing is waited for until the next guided command.
    pub(crate) fn stop_setpoint_timeout(&mut self) {
        self.failsafes.setpoints_until = Duration::MAX;
    }

    /// A heartbeat: the one of the ground station whose loss counts ends that failsafe, and the mode stays.
    pub(crate) fn hear_heartbeat(&mut self, system_id: u8) {
        if f32::from(system_id) != self.parameters.get(Parameter::GroundSystemId) {
            return;
        }
        self.failsafes.ground_heard = Some(self.time);
        if std::mem::take(&mut self.failsafes.ground_lost) {
            self.say(Severity::Warning, "GCS Failsafe Cleared");
        }
    }

    fn check_ground(&mut self) {
        const ONLY_IN_AUTO: f32 = 3.0;
        let timeout_s = self.parameters.get(Parameter::LongFailsafeTimeout);
        if self.parameters.get(Parameter::GroundFailsafe) == ONLY_IN_AUTO
            && self.mode() != Mode::Auto
            && !self.failsafes.ground_lost
        {
            return;
        }
        let silent = |heard: Duration| self.time.saturating_sub(heard).as_secs_f32() > timeout_s;
        let is_lost = self.failsafes.ground_heard.is_some_and(silent);
        if !is_lost || self.failsafes.ground_lost {
            return;
        }
        self.failsafes.ground_lost = true;
        self.counters.failsafes += 1;
        // By default ArduPlane goes on in GUIDED and AUTO, with what it was told last, and in no other mode.
        let goes_on = matches!(self.mode(), Mode::Guided | Mode::Auto | Mode::Rtl);
        if self.parameters.get(Parameter::LongFailsafeAction) != 0.0 || !goes_on {
            self.set_mode(Mode::Rtl);
        }
        let text = format!("GCS Failsafe On: switched to {}", self.mode());
        self.say(Severity::Warning, &text);
    }
}
