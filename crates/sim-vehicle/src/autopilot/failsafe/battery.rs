//! A battery that runs down, watched as ArduPilot's monitor does.

use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::MavSeverity;
use std::time::Duration;

/// How the battery is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum BatteryLevel {
    #[default]
    Ok,
    Low,
    Critical,
}

/// What was found, and since when the voltage is too low (vehicle times).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BatteryWatch {
    level: BatteryLevel,
    low_since: Option<Duration>,
    critical_since: Option<Duration>,
}

/// The parameters of a level.
struct Threshold {
    voltage: Parameter,
    charge: Parameter,
    action: Parameter,
}

const LOW: Threshold = Threshold {
    voltage: Parameter::BatteryLowVoltage,
    charge: Parameter::BatteryLowCharge,
    action: Parameter::BatteryLowAction,
};
const CRITICAL: Threshold = Threshold {
    voltage: Parameter::BatteryCriticalVoltage,
    charge: Parameter::BatteryCriticalCharge,
    action: Parameter::BatteryCriticalAction,
};

/// What BATT_FS_LOW_ACT and BATT_FS_CRT_ACT ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Action {
    Nothing,
    Return,
    Land,
    /// Something that a plane without this device does not do.
    Missing(&'static str),
}

impl Action {
    /// A plane that is no quadplane lands for 4 and 6, and without AUTOLAND it returns for 7.
    fn of(value: f32) -> Self {
        match value as u8 {
            0 => Self::Nothing,
            2 | 4 | 6 => Self::Land,
            3 => Self::Missing("termination"),
            5 => Self::Missing("parachute"),
            _ => Self::Return,
        }
    }
}

impl BatteryWatch {
    pub fn level(&self) -> BatteryLevel {
        self.level
    }
}

impl Vehicle {
    /// A level is reached when the charge is too low, or the voltage for longer than BATT_LOW_TIMER. When all is well again
    /// the level is left; the mode stays.
    pub(super) fn check_battery(&mut self) {
        if !self.flight.is_armed() || self.parameters.get(Parameter::BatteryMonitor) == 0.0 {
            self.failsafes.battery = BatteryWatch::default();
            return;
        }
        let mut watch = self.failsafes.battery;
        let is_critical = self.is_reached(&CRITICAL, &mut watch.critical_since);
        let is_low = self.is_reached(&LOW, &mut watch.low_since);
        let (found, words, action) = match (is_critical, is_low) {
            (true, _) => (BatteryLevel::Critical, "critical", CRITICAL.action),
            (false, true) => (BatteryLevel::Low, "low", LOW.action),
            (false, false) => (BatteryLevel::Ok, "ok", LOW.action),
        };
        let before = std::mem::replace(&mut watch.level, found);
        self.failsafes.battery = watch;
        if found == before {
            return;
        }
        let battery = &self.world.battery;
        let text = format!("Battery 1 is {words} {:.2}V used {:.0} mAh", battery.voltage_v(), battery.consumed_mah());
        if found < before {
            self.say(MavSeverity::MAV_SEVERITY_INFO, &text);
            return;
        }
        self.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
        self.counters.failsafes += 1;
        // ArduPlane lands by the mission's landing sequence, and without one it returns.
        match Action::of(self.parameters.get(action)) {
            Action::Nothing => {}
            Action::Missing(what) => {
                self.say(MavSeverity::MAV_SEVERITY_WARNING, &format!("Battery failsafe: there is no {what}"));
            }
            Action::Return => self.set_mode(Mode::Rtl),
            Action::Land if self.flight.is_landing() => {}
            Action::Land => {
                if let Err(refusal) = self.start_landing() {
                    self.say(MavSeverity::MAV_SEVERITY_WARNING, &refusal.reason.unwrap_or_default());
                    self.set_mode(Mode::Rtl);
                }
            }
        }
    }

    /// Why the battery does not let it arm, if it does not.
    pub(crate) fn battery_forbids_arming(&self) -> Option<String> {
        if self.parameters.get(Parameter::BatteryMonitor) == 0.0 {
            return None;
        }
        [("critical", &CRITICAL), ("low", &LOW)].into_iter().find_map(|(words, threshold)| {
            let reason = match (self.is_voltage_below(threshold), self.is_charge_below(threshold)) {
                (true, _) => "voltage",
                (_, true) => "capacity",
                (false, false) => return None,
            };
            Some(format!("Battery 1 {words} {reason} failsafe"))
        })
    }

    fn is_reached(&self, threshold: &Threshold, since: &mut Option<Duration>) -> bool {
        if self.is_voltage_below(threshold) {
            since.get_or_insert(self.time);
        } else {
            *since = None;
        }
        let timer_s = f64::from(self.parameters.get(Parameter::BatteryLowTimer));
        let is_voltage_low =
            since.is_some_and(|since| timer_s > 0.0 && self.time.saturating_sub(since).as_secs_f64() > timer_s);
        is_voltage_low || self.is_charge_below(threshold)
    }

    fn is_voltage_below(&self, threshold: &Threshold) -> bool {
        let least_v = f64::from(self.parameters.get(threshold.voltage));
        least_v > 0.0 && self.world.battery.voltage_v() < least_v
    }

    fn is_charge_below(&self, threshold: &Threshold) -> bool {
        let least_mah = f64::from(self.parameters.get(threshold.charge));
        let left_mah = f64::from(self.parameters.get(Parameter::BatteryCapacity)) - self.world.battery.consumed_mah();
        least_mah > 0.0 && left_mah < least_mah
    }
}
