//! A battery that runs down, watched as ArduPilot's monitor does.

use super::proposal::{Action, Cause, Proposal};
use crate::autopilot::event::Events;
use crate::autopilot::situation::Situation;
use crate::autopilot::timer::{Timer, Timers};
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;

/// How the battery is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum BatteryLevel {
    #[default]
    Ok,
    Low,
    Critical,
}

/// What was found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BatteryWatch {
    level: BatteryLevel,
}

/// The parameters of a level, and since when its voltage is reached.
struct Threshold {
    voltage: Parameter,
    charge: Parameter,
    action: Parameter,
    timer: Timer,
}

const LOW: Threshold = Threshold {
    voltage: Parameter::BatteryLowVoltage,
    charge: Parameter::BatteryLowCharge,
    action: Parameter::BatteryLowAction,
    timer: Timer::BatteryLow,
};
const CRITICAL: Threshold = Threshold {
    voltage: Parameter::BatteryCriticalVoltage,
    charge: Parameter::BatteryCriticalCharge,
    action: Parameter::BatteryCriticalAction,
    timer: Timer::BatteryCritical,
};

/// What a value of BATT_FS_LOW_ACT or BATT_FS_CRT_ACT brings about, or what it needs that is not there. A plane that is
/// no quadplane lands for 4 and 6, and without AUTOLAND it returns for 7.
fn action_of(value: f32) -> Result<Action, &'static str> {
    match value as u8 {
        0 => Ok(Action::Warn),
        2 | 4 | 6 => Ok(Action::Land),
        3 => Err("termination"),
        5 => Ok(Action::Parachute),
        _ => Ok(Action::Mode(Mode::Rtl)),
    }
}

impl BatteryWatch {
    pub fn level(&self) -> BatteryLevel {
        self.level
    }

    /// A level is reached when the charge is too low, or the voltage for longer than BATT_LOW_TIMER. When all is well
    /// again the level is left; the mode stays.
    pub fn check(&mut self, now: &Situation<'_>, timers: &mut Timers, events: &mut Events) -> Option<Proposal> {
        if !now.is_armed() || now.get(Parameter::BatteryMonitor) == 0.0 {
            self.level = BatteryLevel::Ok;
            timers.clear(LOW.timer);
            timers.clear(CRITICAL.timer);
            return None;
        }
        let is_critical = CRITICAL.is_reached(now, timers);
        let is_low = LOW.is_reached(now, timers);
        let (found, words, action) = match (is_critical, is_low) {
            (true, _) => (BatteryLevel::Critical, "critical", CRITICAL.action),
            (false, true) => (BatteryLevel::Low, "low", LOW.action),
            (false, false) => (BatteryLevel::Ok, "ok", LOW.action),
        };
        let before = std::mem::replace(&mut self.level, found);
        if found == before {
            return None;
        }
        let battery = now.world.battery();
        let text = format!("Battery 1 is {words} {:.2}V used {:.0} mAh", battery.voltage_v(), battery.consumed_mah());
        if found < before {
            events.say(Severity::Info, text);
            return None;
        }
        events.say(Severity::Warning, text);
        // ArduPlane lands by the mission's landing sequence, and without one it returns.
        let action = match action_of(now.get(action)) {
            Ok(Action::Land) if now.flight.is_landing() => Action::Warn,
            Ok(action) => action,
            Err(missing) => {
                events.say(Severity::Warning, format!("Battery failsafe: there is no {missing}"));
                Action::Warn
            }
        };
        Some(Proposal::new(Cause::Battery, action))
    }
}

/// Why the battery does not let it arm, if it does not.
pub(crate) fn forbids_arming(now: &Situation<'_>) -> Option<String> {
    if now.get(Parameter::BatteryMonitor) == 0.0 {
        return None;
    }
    [("critical", &CRITICAL), ("low", &LOW)].into_iter().find_map(|(words, threshold)| {
        let reason = match (threshold.is_voltage_below(now), threshold.is_charge_below(now)) {
            (true, _) => "voltage",
            (_, true) => "capacity",
            (false, false) => return None,
        };
        Some(format!("Battery 1 {words} {reason} failsafe"))
    })
}

impl Threshold {
    fn is_reached(&self, now: &Situation<'_>, timers: &mut Timers) -> bool {
        if self.is_voltage_below(now) {
            timers.begin(self.timer, now.time);
        } else {
            timers.clear(self.timer);
        }
        let timer_s = f64::from(now.get(Parameter::BatteryLowTimer));
        let is_long = |since: std::time::Duration| timer_s > 0.0 && since.as_secs_f64() > timer_s;
        timers.since(self.timer, now.time).is_some_and(is_long) || self.is_charge_below(now)
    }

    fn is_voltage_below(&self, now: &Situation<'_>) -> bool {
        let least_v = f64::from(now.get(self.voltage));
        least_v > 0.0 && now.world.battery().voltage_v() < least_v
    }

    fn is_charge_below(&self, now: &Situation<'_>) -> bool {
        let least_mah = f64::from(now.get(self.charge));
        let left_mah = f64::from(now.get(Parameter::BatteryCapacity)) - now.world.battery().consumed_mah();
        least_mah > 0.0 && left_mah < least_mah
    }
}
