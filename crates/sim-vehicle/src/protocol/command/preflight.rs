//! Commands about the autopilot itself: its calibration, a battery that was changed, and who it is.

use crate::autopilot::Autopilot;
use crate::autopilot::input::{check_finite, integer};
use crate::error::{CommandError, Severity};
use crate::parameters::table::Parameter;
use crate::protocol::command::request::Command;
use crate::telemetry::announce::Component;

/// How the accelerometer is held while it is calibrated, one after the other, in ArduPilot's words.
const POSES: [&str; 6] = ["level", "on its LEFT side", "on its RIGHT side", "nose DOWN", "nose UP", "on its BACK"];

/// The number by which an ArduPilot takes a calibration that it has for valid.
const BY_FORCE: i64 = 76;

/// PREFLIGHT_CALIBRATION. Param 1: 1 for the gyroscopes; param 2: 76 for the compasses as they are; param 3: 1 for the
/// barometer, whose drift starts anew; param 5: 1 for the accelerometer in six poses, 2 for the trim, 4 for the
/// accelerometer as it stands, 76 as it is.
pub(crate) fn calibrate(component: &mut Component, command: &Command) -> Result<(), CommandError> {
    let is_busy = component.is_busy();
    let autopilot = &mut component.autopilot;
    if autopilot.flight.is_armed() {
        return Err(CommandError::failed("Disarm to allow calibration"));
    }
    let [gyroscopes, compasses, barometer, _] = command.params;
    let [accelerometer, _] = command.whole_p5_p6();
    if gyroscopes == 1.0 {
        return Ok(());
    }
    if barometer == 1.0 {
        autopilot.say(Severity::Info, "Updating barometer calibration");
        autopilot.world.calibrate_barometer();
        autopilot.say(Severity::Info, "Barometer calibration complete");
        // The airspeed follows, and has one place to remember who has asked.
        if is_busy {
            return Err(CommandError::rejected("Calibration: one goes on"));
        }
        autopilot.say(Severity::Info, "Airspeed calibration started");
        return Err(CommandError::in_progress());
    }
    match accelerometer {
        1 => ask_for_pose(autopilot, 0),
        2 | 4 if autopilot.session.accelerometer_pose.is_some() => {
            return Err(CommandError::rejected("Poses of the accelerometer are waited for"));
        }
        2 => autopilot.say(Severity::Info, "Trim OK: roll=0.00 pitch=0.00 yaw=0.00"),
        4 | BY_FORCE => {}
        _ if compasses == BY_FORCE as f32 => {}
        _ => return Err(CommandError::unsupported()),
    }
    Ok(())
}

fn ask_for_pose(autopilot: &mut Autopilot, pose: usize) {
    autopilot.session.accelerometer_pose = Some(pose);
    autopilot.say(Severity::Critical, &format!("Place vehicle {} and press any key.", POSES[pose]));
}

/// ACCELCAL_VEHICLE_POS. Param 1: the pose, from 1, that it was asked for and that it has now. Nobody turns this
/// vehicle: all that is measured is that it stands level, and in the end the calibration fails.
pub(crate) fn take_pose(autopilot: &mut Autopilot, pose: f32) -> Result<(), CommandError> {
    let asked = autopilot.session.accelerometer_pose.filter(|asked| pose == (*asked + 1) as f32);
    let Some(asked) = asked else {
        return Err(CommandError::failed("No such pose of the accelerometer is waited for"));
    };
    if asked + 1 < POSES.len() {
        ask_for_pose(autopilot, asked + 1);
    } else {
        autopilot.session.accelerometer_pose = None;
        autopilot.say(Severity::Critical, "Calibration FAILED");
    }
    Ok(())
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
