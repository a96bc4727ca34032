//! What a PX4 answers to commands that prepare a flight or are for devices: calibration, storage, failures on purpose,
//! regions of interest, a safety switch (`Commander::handle_command`, `calibration_messages.h`, `FailureTable.cpp`).

use crate::parameters::Parameter;
use crate::protocol::command::{Command, Refusal, integer};
use crate::vehicle::Vehicle;
use mavlink_bridge::CommandPosition;
use mavlink_bridge::dialect::{MavCmd, MavResult, MavSeverity};
use std::time::Duration;

/// A calibration that is under way: it tells its progress, and takes vehicle time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Calibration {
    name: &'static str,
    began: Duration,
    /// Percent that have been told.
    told: u32,
}

/// How long a calibration takes.
const CALIBRATION: Duration = Duration::from_secs(2);
/// How often its progress is told, percent.
const PROGRESS_STEP: u32 = 20;

fn rejected(reason: &str) -> Refusal {
    Refusal::new(MavResult::MAV_RESULT_TEMPORARILY_REJECTED, reason)
}

fn unsupported(reason: &str) -> Refusal {
    Refusal::new(MavResult::MAV_RESULT_UNSUPPORTED, reason)
}

/// The answer to a command that the dialect does not know: EXTERNAL_WIND_ESTIMATE is accepted, and the wind is known better.
pub(in crate::firmware) fn answer_by_number(command: u16) -> Option<Result<(), Refusal>> {
    const EXTERNAL_WIND_ESTIMATE: u16 = 43_004;
    (command == EXTERNAL_WIND_ESTIMATE).then_some(Ok(()))
}

impl Vehicle {
    pub(super) fn px4_prepare(&mut self, command: &Command) -> Result<(), Refusal> {
        let [p1, p2, ..] = command.params;
        match command.command {
            MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION => self.px4_calibrate(command),
            MavCmd::MAV_CMD_FIXED_MAG_CAL_YAW => self.px4_begin_calibration("mag"),
            MavCmd::MAV_CMD_PREFLIGHT_STORAGE => self.px4_store(p1),
            MavCmd::MAV_CMD_INJECT_FAILURE => self.px4_inject_failure([p1, p2, command.params[2]]),
            MavCmd::MAV_CMD_DO_SET_SAFETY_SWITCH_STATE => match integer(p1) {
                _ if self.flight.is_armed() => Err(rejected("Safety switch: it is armed")),
                0 | 1 => Ok(()),
                _ => Err(Refusal::failed("Safety switch: param 1 must be 0 or 1")),
            },
            MavCmd::MAV_CMD_DO_FLIGHTTERMINATION => Err(Refusal::denied("There is no flight termination")),
            MavCmd::MAV_CMD_DO_AUTOTUNE_ENABLE => Err(Refusal::denied("There is no autotune")),
            MavCmd::MAV_CMD_CONTROL_HIGH_LATENCY => {
                Err(Refusal::failed("Control high latency failed! Telemetry unavailable"))
            }
            // There is nobody whom they would concern: a gimbal, a camera, an actuator, an estimator without a GPS.
            MavCmd::MAV_CMD_RUN_PREARM_CHECKS
            | MavCmd::MAV_CMD_NAV_ROI
            | MavCmd::MAV_CMD_DO_SET_ROI
            | MavCmd::MAV_CMD_DO_SET_ROI_LOCATION
            | MavCmd::MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET
            | MavCmd::MAV_CMD_DO_SET_ROI_NONE
            | MavCmd::MAV_CMD_DO_SET_ACTUATOR
            | MavCmd::MAV_CMD_EXTERNAL_POSITION_ESTIMATE => Ok(()),
            MavCmd::MAV_CMD_DO_SET_GLOBAL_ORIGIN => Err(Refusal::denied("Origin: it is the scenario's")),
            MavCmd::MAV_CMD_NAV_VTOL_TAKEOFF => Err(unsupported("This is no VTOL")),
            MavCmd::MAV_CMD_DO_FIGURE_EIGHT => Err(unsupported("Figures of eight are not flown")),
            _ => Err(Refusal::unsupported()),
        }
    }

    /// PREFLIGHT_CALIBRATION. Params 1 to 7: the gyroscope; the compass; the barometer; 1 a radio, 2 its trim; 1 the
    /// accelerometer, 2 level, 4 the accelerometer in one position; the airspeed; ESCs. None of them: what goes on is ended.
    fn px4_calibrate(&mut self, command: &Command) -> Result<(), Refusal> {
        let [p1, p2, p3, p4] = command.params.map(integer);
        let [p5, p6] = match command.position {
            CommandPosition::Long(params) => params.map(integer),
            CommandPosition::Int(at) => [i64::from(at.latitude_e7), i64::from(at.longitude_e7)],
        };
        let p7 = integer(command.z);
        if self.flight.is_armed() {
            return Err(rejected("Calibration: it is armed"));
        }
        if [p1, p2, p3, p4, p5, p6, p7] == [0; 7] && self.px4.calibration.take().is_some() {
            self.say(MavSeverity::MAV_SEVERITY_INFO, "[cal] calibration cancelled");
            return Ok(());
        }
        match (p1, p2, p3, p4, p5, p6, p7) {
            (1, ..) => self.px4_begin_calibration("gyro"),
            (_, 1, ..) => self.px4_fail_calibration("mag", "the vehicle cannot be turned by hand"),
            (_, _, 1, ..) => self.px4_begin_calibration("baro"),
            (_, _, _, 1 | 2, ..) => Err(unsupported("There is no radio to calibrate")),
            (_, _, _, _, 1, ..) => self.px4_fail_calibration("accel", "the vehicle cannot be turned by hand"),
            (_, _, _, _, 2, ..) => self.px4_begin_calibration("level"),
            (_, _, _, _, 4, ..) => self.px4_begin_calibration("accel"),
            (_, _, _, _, _, 1 | 2, _) => self.px4_fail_calibration("airspeed", "nobody blows into the pitot tube"),
            (.., 1) => Err(Refusal::denied("There are no ESCs to calibrate")),
            (_, _, _, 0, ..) => Ok(()),
            _ => Err(Refusal::unsupported()),
        }
    }

    fn px4_begin_calibration(&mut self, name: &'static str) -> Result<(), Refusal> {
        if self.flight.is_armed() || self.px4.calibration.is_some() {
            return Err(rejected("Calibration: it is armed, or one goes on"));
        }
        self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("[cal] calibration started: 2 {name}"));
        self.px4.calibration = Some(Calibration { name, began: self.time, told: 0 });
        Ok(())
    }

    /// One that needs hands: it begins, and fails at once.
    fn px4_fail_calibration(&mut self, name: &str, why: &str) -> Result<(), Refusal> {
        if self.px4.calibration.is_some() {
            return Err(rejected("Calibration: one goes on"));
        }
        self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("[cal] calibration started: 2 {name}"));
        self.say(MavSeverity::MAV_SEVERITY_CRITICAL, &format!("[cal] calibration failed: {why}"));
        Ok(())
    }

    /// Tells how far a calibration has come, and ends it.
    pub(super) fn px4_follow_calibration(&mut self) {
        let Some(mut calibration) = self.px4.calibration else { return };
        let share = self.time.saturating_sub(calibration.began).as_secs_f64() / CALIBRATION.as_secs_f64();
        let percent = (100.0 * share.min(1.0)) as u32;
        while calibration.told + PROGRESS_STEP <= percent {
            calibration.told += PROGRESS_STEP;
            self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("[cal] progress <{}>", calibration.told));
        }
        self.px4.calibration = Some(calibration);
        if percent >= 100 {
            self.px4.calibration = None;
            if calibration.name == "baro" {
                self.world.barometer_drift_m = 0.0;
            }
            self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("[cal] calibration done: {}", calibration.name));
        }
    }

    /// PREFLIGHT_STORAGE. Param 1: 0 load, 1 save: parameters are always kept. 2 to 4: they have their first values again.
    fn px4_store(&mut self, p1: f32) -> Result<(), Refusal> {
        if self.flight.is_armed() {
            return Err(rejected("Storage: it is armed"));
        }
        match integer(p1) {
            0 | 1 => Ok(()),
            2..=4 => Err(unsupported("Storage: start anew for the first values")),
            _ => Err(unsupported("Storage: param 1 must be 0 to 4")),
        }
    }

    /// INJECT_FAILURE. Param 1: what fails. Param 2: how, 0 for well again. Param 3: which one of them, 0 for all.
    fn px4_inject_failure(&mut self, params: [f32; 3]) -> Result<(), Refusal> {
        if self.parameters.get(Parameter::FailureInjection) == 0.0 {
            return Err(Refusal::denied("Failures: SYS_FAILURE_EN is 0"));
        }
        let [unit, kind, instance] = params.map(|param| param.round() as u8);
        if !knows_failure(unit, kind) {
            return Err(Refusal::unsupported());
        }
        // There is one of each.
        if instance > 1 {
            return Ok(());
        }
        let airspeed_mps = self.flight.airspeed_mps().max(0.1) as f32;
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
            let _ = self.set_parameter(*parameter, *value);
        }
        Ok(())
    }
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
