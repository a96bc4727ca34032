//! What COMMAND_LONG and COMMAND_INT make the vehicle do, accepted and refused as ArduPlane does.
//!
//! Where it differs: param 3 of GUIDED_CHANGE_ALTITUDE is the rate of climb that it is documented to be (broken in
//! ArduPlane since 4.6); terrain is as high as home; DO_CHANGE_SPEED counts after GUIDED_CHANGE_SPEED too; and of the
//! params that a command reads, one that is not a finite number is DENIED.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

mod message_requests;
#[cfg(test)]
mod page;
pub(crate) mod preflight;
mod reposition;
pub(crate) mod request;
pub(crate) mod reset;
mod set_home;
mod standard_modes;

use crate::autopilot::Autopilot;
use crate::autopilot::input::{check_finite, integer};
use crate::error::CommandError;
use crate::firmware::answers;
use crate::firmware::rules::CommandSet;
use crate::mode::Mode;
use crate::telemetry::announce::Component;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MavCmd, MavModeFlag};
use request::Command;

/// Obeys a command that came over a link, or says why not; nothing is changed then.
pub(crate) fn execute(component: &mut Component, command: &Command, link: usize) -> Result<(), CommandError> {
    let own = answers::execute(&mut component.autopilot, command);
    if let Some(outcome) = own.or_else(|| standard_modes::execute(component, command, link)) {
        return outcome;
    }
    let autopilot = &mut component.autopilot;
    let is_arduplane = autopilot.rules().commands == CommandSet::ArduPlane;
    let [p1, p2, p3, _] = command.params;
    match command.command {
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => autopilot.arm_or_disarm([p1, p2]),
        MavCmd::MAV_CMD_RUN_PREARM_CHECKS => autopilot.run_prearm_checks(),
        MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION => preflight::calibrate(component, command),
        MavCmd::MAV_CMD_DO_SET_HOME => set_home::set_home(autopilot, command),
        MavCmd::MAV_CMD_DO_SET_MODE => change_mode(autopilot, p1, p2),
        MavCmd::MAV_CMD_NAV_LOITER_UNLIM => autopilot.try_to_enter(Mode::Loiter),
        MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => autopilot.try_to_enter(Mode::Rtl),
        MavCmd::MAV_CMD_MISSION_START => autopilot.start_mission([p1, p2]),
        MavCmd::MAV_CMD_DO_LAND_START => autopilot.start_landing(),
        MavCmd::MAV_CMD_DO_RETURN_PATH_START => autopilot.start_return_path(),
        MavCmd::MAV_CMD_DO_GO_AROUND => autopilot.go_around(p1),
        MavCmd::MAV_CMD_DO_SET_MISSION_CURRENT => {
            autopilot.set_current_mission_item([p1, p2])?;
            // Who asks is told the current item at once.
            component.send_stream(link, Stream::MissionCurrent);
            Ok(())
        }
        MavCmd::MAV_CMD_DO_JUMP_TAG => {
            autopilot.jump_to_tag(p1)?;
            component.send_stream(link, Stream::MissionCurrent);
            Ok(())
        }
        MavCmd::MAV_CMD_DO_FENCE_ENABLE => autopilot.enable_fence([p1, p2]),
        MavCmd::MAV_CMD_DO_SET_SERVO | MavCmd::MAV_CMD_DO_REPEAT_SERVO if is_arduplane => autopilot.set_servo([p1, p2]),
        MavCmd::MAV_CMD_DO_SET_RELAY if is_arduplane => autopilot.set_relay([p1, p2]),
        MavCmd::MAV_CMD_DO_REPEAT_RELAY if is_arduplane => autopilot.check_relay(p1),
        // ArduPlane takes it for quadplanes alone.
        MavCmd::MAV_CMD_NAV_TAKEOFF => Err(CommandError::failed("Takeoff: set mode TAKEOFF, or AUTO with NAV_TAKEOFF")),
        MavCmd::MAV_CMD_DO_REPOSITION => reposition::reposition(autopilot, command),
        MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED => autopilot.guided_speed([p1, p2, p3]),
        MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE => autopilot.guided_altitude(p3, command.z, command.frame),
        MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => autopilot.guided_heading([p1, p2, p3]),
        MavCmd::MAV_CMD_DO_CHANGE_SPEED => autopilot.change_speed([p1, p2, p3]),
        MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => autopilot.change_altitude([p1, p2]),
        MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => message_requests::tell_message_interval(component, p1, link),
        MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => {
            message_requests::set_message_interval(component, command.params, command.z, link)
        }
        MavCmd::MAV_CMD_REQUEST_MESSAGE => message_requests::request_message(component, [p1, p2], link),
        MavCmd::MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES => {
            message_requests::answer_old_request(component, p1, Stream::AutopilotVersion, link)
        }
        MavCmd::MAV_CMD_REQUEST_PROTOCOL_VERSION => {
            message_requests::answer_old_request(component, p1, Stream::ProtocolVersion, link)
        }
        MavCmd::MAV_CMD_GET_HOME_POSITION => {
            component.asked_for.extend([(link, Stream::HomePosition), (link, Stream::GpsGlobalOrigin)]);
            Ok(())
        }
        _ => Err(CommandError::unsupported()),
    }
}

/// Obeys a command that the common dialect does not know.
pub(crate) fn execute_by_number(autopilot: &mut Autopilot, raw: &mavlink_bridge::Command) -> Result<(), CommandError> {
    const DO_SEND_BANNER: u16 = 42_428;
    const BATTERY_RESET: u16 = 42_651;
    const DO_AUX_FUNCTION: u16 = 218;
    const ACCELCAL_VEHICLE_POS: u16 = 42_429;
    let [p1, p2, ..] = raw.params;
    match raw.number {
        DO_SEND_BANNER if autopilot.rules().has_ardupilot_commands => {
            preflight::send_banner(autopilot);
            Ok(())
        }
        BATTERY_RESET if autopilot.rules().has_ardupilot_commands => preflight::reset_battery(autopilot, [p1, p2]),
        ACCELCAL_VEHICLE_POS if autopilot.rules().has_ardupilot_commands => preflight::take_pose(autopilot, p1),
        DO_AUX_FUNCTION if is_done_by_switch(autopilot, [p1, p2]) => Ok(()),
        number => answers::for_device(autopilot, number, raw.params).unwrap_or(Err(CommandError::unsupported())),
    }
}

/// DO_AUX_FUNCTION. Param 1: the function of a switch. Param 2: its position, 0 to 2.
fn is_done_by_switch(autopilot: &mut Autopilot, params: [f32; 2]) -> bool {
    let [function, position] = params.map(integer);
    match (u16::try_from(function), usize::try_from(position)) {
        (Ok(function), Ok(position @ 0..=2)) if autopilot.rules().has_switches => {
            autopilot.run_function(function, position)
        }
        _ => false,
    }
}

fn change_mode(autopilot: &mut Autopilot, base_mode: f32, custom_mode: f32) -> Result<(), CommandError> {
    check_finite("Mode", &[base_mode, custom_mode])?;
    let custom_flag = i64::from(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.bits());
    // MAV_MODE_FLAG_DECODE_POSITION_SAFETY by itself is a safety switch's, 0 off and 1 on, of which there is none.
    const SAFETY: i64 = 128;
    if integer(base_mode) & 0xFF == SAFETY && matches!(integer(custom_mode), 0 | 1) {
        return Ok(());
    }
    if integer(base_mode) & custom_flag == 0 {
        return Err(CommandError::denied("Mode: only custom modes are known"));
    }
    // A cast of what is negative or too large takes the bound, which is no mode.
    let number = u32::try_from(integer(custom_mode)).unwrap_or(u32::MAX);
    let mode = Mode::from_number(number).map_err(|error| CommandError::failed(error.to_string()))?;
    autopilot.enter(mode)
}
