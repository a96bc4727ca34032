//! What a PX4 answers to commands that prepare a flight or are for devices: calibration, storage, failures on purpose,
//! regions of interest, a safety switch (`Commander::handle_command`, `calibration_messages.h`, `FailureTable.cpp`).

// Clients still speak what the dialect calls superseded, and autopilots answer.
#![allow(deprecated)]

use crate::autopilot::Autopilot;
use crate::autopilot::calibration::Begun;
use crate::autopilot::input::integer;
use crate::error::{CommandError, CommandResult, Severity};
use crate::parameters::table::Parameter;
use crate::protocol::command::request::Command;
use mavlink_bridge::CommandPosition;
use mavlink_bridge::dialect::MavCmd;

fn rejected(reason: &str) -> CommandError {
    CommandError::new(CommandResult::TemporarilyRejected, reason)
}

fn unsupported(reason: &str) -> CommandError {
    CommandError::new(CommandResult::Unsupported, reason)
}

/// The answer to a command that the dialect does not know: EXTERNAL_WIND_ESTIMATE is accepted, and the wind is known
/// better; those for others are not answered.
pub(in crate::firmware) fn answer_by_number(command: u16) -> Option<Result<(), CommandError>> {
    const EXTERNAL_WIND_ESTIMATE: u16 = 43_004;
    match command {
        EXTERNAL_WIND_ESTIMATE => Some(Ok(())),
        other => OF_OTHERS.contains(&other).then(|| Err(of_others())),
    }
}

pub(super) fn execute(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let [p1, p2, ..] = command.params;
    match command.command {
        MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION => calibrate(autopilot, command),
        MavCmd::MAV_CMD_FIXED_MAG_CAL_YAW => begin_calibration(autopilot, "mag"),
        MavCmd::MAV_CMD_INJECT_FAILURE => inject_failure(autopilot, [p1, p2, command.params[2]]),
        MavCmd::MAV_CMD_DO_SET_SAFETY_SWITCH_STATE => match integer(p1) {
            _ if autopilot.flight.is_armed() => Err(rejected("Safety switch: it is armed")),
            0 | 1 => Ok(()),
            _ => Err(CommandError::failed("Safety switch: param 1 must be 0 or 1")),
        },
        MavCmd::MAV_CMD_ACTUATOR_TEST => test_actuator(autopilot, command),
        // There are no logs: they cannot be sent now, or are not sent any more.
        MavCmd::MAV_CMD_LOGGING_START if p1.round() == 0.0 => Err(rejected("There are no logs")),
        MavCmd::MAV_CMD_LOGGING_START => Err(CommandError::unanswered("Logging: param 1 must be 0")),
        MavCmd::MAV_CMD_LOGGING_STOP => Ok(()),
        MavCmd::MAV_CMD_DO_FLIGHTTERMINATION => Err(CommandError::denied("There is no flight termination")),
        MavCmd::MAV_CMD_DO_AUTOTUNE_ENABLE => Err(CommandError::denied("There is no autotune")),
        MavCmd::MAV_CMD_CONTROL_HIGH_LATENCY => {
            Err(CommandError::failed("Control high latency failed! Telemetry unavailable"))
        }
        // There is nobody whom they would concern: a gimbal, a camera, an actuator, an estimator without a GPS.
        MavCmd::MAV_CMD_RUN_PREARM_CHECKS
        | MavCmd::MAV_CMD_NAV_ROI
        | MavCmd::MAV_CMD_DO_SET_ROI
        | MavCmd::MAV_CMD_DO_SET_ROI_LOCATION
        | MavCmd::MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET
        | MavCmd::MAV_CMD_DO_SET_ROI_NONE
        | MavCmd::MAV_CMD_DO_SET_ACTUATOR => Ok(()),
        MavCmd::MAV_CMD_DO_SET_GLOBAL_ORIGIN => Err(CommandError::denied("Origin: it is the scenario's")),
        MavCmd::MAV_CMD_NAV_VTOL_TAKEOFF => Err(unsupported("This is no VTOL")),
        MavCmd::MAV_CMD_DO_FIGURE_EIGHT => Err(unsupported("Figures of eight are not flown")),
        other if OF_OTHERS.contains(&(other as u32 as u16)) => Err(of_others()),
        _ => Err(CommandError::unsupported()),
    }
}

/// Commands that its commander leaves to others: gimbals, cameras, actuators, winches. Where they are not there, nobody
/// answers ("ignore commands that are handled by other parts of the system", `Commander.cpp`).
const OF_OTHERS: [u16; 27] = [
    93, 203, 204, 205, 206, 214, 220, 242, 243, 260, 309, 311, 312, 500, 521, 530, 531, 532, 620, 1000, 1001, 2003,
    3000, 30_001, 30_002, 42_600, 43_006,
];

fn of_others() -> CommandError {
    CommandError::unanswered("There is no device for this command")
}

/// PREFLIGHT_CALIBRATION. Params 1 to 7: the gyroscope; the compass; the barometer; 1 a radio, 2 its trim; 1 the
/// accelerometer, 2 level, 4 the accelerometer in one position; the airspeed; ESCs. None of them: what goes on is
/// ended.
fn calibrate(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let [p1, p2, p3, p4] = command.params.map(integer);
    let [p5, p6] = command.whole_p5_p6();
    let p7 = integer(command.z);
    if autopilot.flight.is_armed() {
        return Err(rejected("Calibration: it is armed"));
    }
    if [p1, p2, p3, p4, p5, p6, p7] == [0; 7] && autopilot.session.calibration.take().is_some() {
        autopilot.say(Severity::Info, "[cal] calibration cancelled");
        return Ok(());
    }
    match (p1, p2, p3, p4, p5, p6, p7) {
        (1, ..) => begin_calibration(autopilot, "gyro"),
        (_, 1, ..) => fail_calibration(autopilot, "mag", "the vehicle cannot be turned by hand"),
        (_, _, 1, ..) => begin_calibration(autopilot, "baro"),
        (_, _, _, 1, ..) => {
            autopilot.say(Severity::Info, "Calibration: Disabling RC input");
            Ok(())
        }
        (_, _, _, 2, ..) => fail_calibration(autopilot, "trim", "no inputs, aborting"),
        (_, _, _, _, 1, ..) => fail_calibration(autopilot, "accel", "the vehicle cannot be turned by hand"),
        (_, _, _, _, 2, ..) => begin_calibration(autopilot, "level"),
        (_, _, _, _, 4, ..) => begin_calibration(autopilot, "accel"),
        (_, _, _, _, _, 1 | 2, _) => fail_calibration(autopilot, "airspeed", "nobody blows into the pitot tube"),
        (.., 1) => Err(CommandError::denied("There are no ESCs to calibrate")),
        (_, _, _, 0, ..) => Ok(()),
        _ => Err(CommandError::unsupported()),
    }
}

fn begin_calibration(autopilot: &mut Autopilot, name: &'static str) -> Result<(), CommandError> {
    match autopilot.begin_calibration(name) {
        Begun::Yes => Ok(()),
        Begun::No => Err(rejected("Calibration: it is armed, or one goes on")),
    }
}

/// One that needs hands: it begins, and fails at once.
fn fail_calibration(autopilot: &mut Autopilot, name: &str, why: &str) -> Result<(), CommandError> {
    if autopilot.session.calibration.is_some() {
        return Err(rejected("Calibration: one goes on"));
    }
    autopilot.say(Severity::Info, &format!("[cal] calibration started: 2 {name}"));
    autopilot.say(Severity::Critical, &format!("[cal] calibration failed: {why}"));
    Ok(())
}

/// ACTUATOR_TEST. Param 5: the motor, 1 to 12, or servo, 33 to 40, or a function of PX4's own from 1000 on. Nothing
/// turns.
fn test_actuator(autopilot: &Autopilot, command: &Command) -> Result<(), CommandError> {
    if autopilot.flight.is_armed() {
        return Err(CommandError::denied("Actuator test: it is armed"));
    }
    let [function, _] = match command.position {
        CommandPosition::Long(params) => params.map(|param| param.round() as i64),
        CommandPosition::Int(_) => command.whole_p5_p6(),
    };
    match function {
        1..=12 | 33..=40 | 1000.. => Ok(()),
        _ => Err(CommandError::unanswered("Actuator test: param 5 is no motor and no servo")),
    }
}

/// INJECT_FAILURE. Param 1: what fails. Param 2: how, 0 for well again. Param 3: which one of them, 0 for all.
fn inject_failure(autopilot: &mut Autopilot, params: [f32; 3]) -> Result<(), CommandError> {
    if autopilot.parameters.get(Parameter::FailureInjection) == 0.0 {
        return Err(CommandError::denied("Failures: SYS_FAILURE_EN is 0"));
    }
    let [unit, kind, instance] = params.map(|param| param.round() as u8);
    if !knows_failure(unit, kind) {
        return Err(CommandError::unsupported());
    }
    // There is one of each.
    if instance > 1 {
        return Ok(());
    }
    let airspeed_mps = autopilot.flight.airspeed_mps().max(0.1) as f32;
    let set: &[(Parameter, f32)] = match (unit, kind) {
        (GPS, OK | OFF) => &[(Parameter::GpsFail, f32::from(kind))],
        (AIRSPEED, OK) => &[(Parameter::PitotFail, 0.0)],
        (AIRSPEED, STUCK) => &[(Parameter::PitotFail, airspeed_mps)],
        (MOTOR, OK | OFF) => &[(Parameter::EngineFail, f32::from(kind)), (Parameter::EngineShare, 0.0)],
        (_, OK) => &[],
        _ => return Err(unsupported("Failures: this one is not simulated")),
    };
    for (parameter, value) in set {
        // A value within its range.
        let _ = autopilot.set_parameter(*parameter, *value);
    }
    Ok(())
}

const BAROMETER: u8 = 3;
const GPS: u8 = 4;
const VIO: u8 = 6;
const AIRSPEED: u8 = 8;
const BATTERY: u8 = 100;
const MOTOR: u8 = 101;
const OK: u8 = 0;
const OFF: u8 = 1;
const STUCK: u8 = 2;
const WRONG: u8 = 4;

/// The failures that a PX4 knows.
fn knows_failure(unit: u8, kind: u8) -> bool {
    match unit {
        0..=BAROMETER => matches!(kind, OK | OFF | STUCK),
        GPS | AIRSPEED | MOTOR => matches!(kind, OK | OFF | STUCK | WRONG),
        VIO | BATTERY => matches!(kind, OK | OFF),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_failures_are_px4s() {
        for (unit, kinds) in
            [(0, &[OK, OFF, STUCK][..]), (GPS, &[OK, OFF, STUCK, WRONG]), (BATTERY, &[OK, OFF]), (5, &[])]
        {
            let known: Vec<u8> = (0..8).filter(|kind| knows_failure(unit, *kind)).collect();
            assert_eq!(known, kinds, "{unit}");
        }
    }
}
