//! Commands about the autopilot itself: its calibration, a battery that was changed, and who it is.

use crate::autopilot::Autopilot;
use crate::autopilot::input::{check_finite, integer};
use crate::error::{CommandError, Severity};
use crate::parameters::table::Parameter;

/// PREFLIGHT_CALIBRATION. Param 1: 1 for the gyroscopes; param 3: 1 for the barometer, whose drift starts anew.
pub(crate) fn calibrate(autopilot: &mut Autopilot, [gyroscopes, barometer]: [f32; 2]) -> Result<(), CommandError> {
    if autopilot.flight.is_armed() {
        return Err(CommandError::failed("Disarm to allow calibration"));
    }
    if gyroscopes == 1.0 {
        return Ok(());
    }
    if barometer == 1.0 {
        autopilot.world.calibrate_barometer();
        autopilot.say(Severity::Info, "Barometer calibration complete");
        return Ok(());
    }
    Err(CommandError::unsupported())
}

/// BATTERY_RESET. Param 1: bits of the batteries, of which there is one. Param 2: how full it is now, percent.
pub(crate) fn reset_battery(autopilot: &mut Autopilot, [batteries, percent]: [f32; 2]) -> Result<(), CommandError> {
    check_finite("Battery", &[batteries, percent])?;
    if integer(batteries) & 1 != 0 {
        let left = f64::from(percent.clamp(0.0, 100.0)) / 100.0;
        let capacity_mah = f64::from(autopilot.parameters.get(Parameter::BatteryCapacity));
        autopilot.world.reset_battery(&autopilot.parameters, capacity_mah, left);
    }
    Ok(())
}

/// DO_SEND_BANNER: who it is, in words.
pub(crate) fn send_banner(autopilot: &mut Autopilot) {
    let rules = autopilot.rules();
    let [major, minor, patch] = rules.version;
    autopilot.say(Severity::Info, &format!("{} V{major}.{minor}.{patch}", rules.product));
}
