//! A battery that runs down, watched as ArduPilot's monitor does.

use crate::parameters::Parameter;
use crate::{Mode, Vehicle};
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
        let battery = &self.life.battery;
        let text = format!("Battery 1 is {words} {:.2}V used {:.0} mAh", battery.voltage_v(), battery.consumed_mah());
        if found < before {
            self.say(MavSeverity::MAV_SEVERITY_INFO, &text);
            return;
        }
        self.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
        self.counters.failsafes += 1;
        // Without a place to land, ArduPlane's action to land (2) is to return (1).
        if self.parameters.get(action) != 0.0 {
            self.set_mode(Mode::Rtl);
        }
    }

    fn is_reached(&self, threshold: &Threshold, since: &mut Option<Duration>) -> bool {
        let get = |parameter| f64::from(self.parameters.get(parameter));
        let battery = &self.life.battery;
        let (least_v, least_mah) = (get(threshold.voltage), get(threshold.charge));
        if least_v > 0.0 && battery.voltage_v() < least_v {
            since.get_or_insert(self.time);
        } else {
            *since = None;
        }
        let timer_s = get(Parameter::BatteryLowTimer);
        let is_voltage_low =
            since.is_some_and(|since| timer_s > 0.0 && self.time.saturating_sub(since).as_secs_f64() > timer_s);
        let left_mah = get(Parameter::BatteryCapacity) - battery.consumed_mah();
        is_voltage_low || (least_mah > 0.0 && left_mah < least_mah)
    }
}
