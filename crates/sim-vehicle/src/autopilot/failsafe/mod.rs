//! What the vehicle does by itself when something is missing: setpoints, its ground station, charge, a GPS, an engine. Each is said
//! aloud when it begins and when it ends.

mod battery;
mod engine;
mod gps;
mod weather;

pub(crate) use battery::{BatteryLevel, BatteryWatch};

use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::MavSeverity;
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

impl Vehicle {
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
            self.say(MavSeverity::MAV_SEVERITY_CRITICAL, &text);
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
            self.say(MavSeverity::MAV_SEVERITY_WARNING, "GCS Failsafe Cleared");
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
        match long_action(self.parameters.get(Parameter::LongFailsafeAction), self.mode()) {
            LongAction::GoOn => {}
            LongAction::NoParachute => {
                self.say(MavSeverity::MAV_SEVERITY_WARNING, "GCS Failsafe: there is no parachute");
            }
            LongAction::Glide => {
                self.set_mode(Mode::Fbwa);
                self.flight.glide();
            }
            // Without a mission AUTO returns.
            LongAction::Auto => {
                let _ = self.enter(Mode::Auto);
            }
            LongAction::Return => self.set_mode(Mode::Rtl),
        }
        let text = format!("GCS Failsafe On: switched to {}", self.mode());
        self.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
    }
}

/// What FS_LONG_ACTN brings about in a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LongAction {
    GoOn,
    Return,
    Glide,
    NoParachute,
    Auto,
}

/// `Plane::failsafe_long_on_event`: GUIDED and AUTO go on by default, and other modes return. AUTOLAND (5) is not simulated:
/// RTL, as where it is not possible.
fn long_action(value: f32, mode: Mode) -> LongAction {
    let returns = mode == Mode::Rtl;
    match value as u8 {
        4 => LongAction::Auto,
        _ if returns => LongAction::GoOn,
        2 => LongAction::Glide,
        3 => LongAction::NoParachute,
        1 | 5 => LongAction::Return,
        _ if matches!(mode, Mode::Guided | Mode::Auto) => LongAction::GoOn,
        _ => LongAction::Return,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_of_the_long_failsafe_does_what_arduplane_does() {
        for (value, guided, loiter, rtl) in [
            (0.0, LongAction::GoOn, LongAction::Return, LongAction::GoOn),
            (1.0, LongAction::Return, LongAction::Return, LongAction::GoOn),
            (2.0, LongAction::Glide, LongAction::Glide, LongAction::GoOn),
            (3.0, LongAction::NoParachute, LongAction::NoParachute, LongAction::GoOn),
            (4.0, LongAction::Auto, LongAction::Auto, LongAction::Auto),
            (5.0, LongAction::Return, LongAction::Return, LongAction::GoOn),
        ] {
            let found = [Mode::Guided, Mode::Loiter, Mode::Rtl].map(|mode| long_action(value, mode));
            assert_eq!(found, [guided, loiter, rtl], "{value}");
        }
    }
}
