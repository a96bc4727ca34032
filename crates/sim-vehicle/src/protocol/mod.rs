//! The MAVLink services that the vehicle offers, message by message.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

pub(crate) mod command;
mod data_streams;
mod ftp;
pub(crate) mod mission;
pub(crate) mod parameter;

use crate::autopilot::manual_control::CHANNELS;
use crate::autopilot::pilot::ManualControl;
use crate::error::{CommandError, CommandResult, Severity};
use crate::firmware::answers::{self, Storage};
use crate::firmware::rules::CommandSet;
use crate::lockstep::Lockstep;
use crate::telemetry::announce::Component;
use crate::telemetry::streams::Stream;
use command::preflight;
use command::request::Command;
use command::reset;
use mavlink_bridge::dialect::{
    MavCmd, MavModeFlag, MavResult, MavType, Message, PING_DATA, RC_CHANNELS_OVERRIDE_DATA, SET_MODE_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA, TIMESYNC_DATA,
};
use mavlink_bridge::{Incoming, ItemKind, Request, Target, setpoint_from_local_ned};
use mission::MissionService;
use parameter::ParameterService;

/// The services of one vehicle, with what each of them remembers.
#[derive(Debug, Default)]
pub(crate) struct Services {
    pub parameters: ParameterService,
    pub missions: MissionService,
}

impl Services {
    /// Does what is asked over a link, of this vehicle.
    pub fn serve(
        &mut self,
        component: &mut Component,
        lockstep: Option<&mut Lockstep>,
        link: usize,
        incoming: &Incoming,
    ) {
        let sender = Target { system_id: incoming.header.system_id, component_id: incoming.header.component_id };
        match &incoming.request {
            Request::Parameter(request) => {
                self.parameters.serve(component, link, sender, request);
                self.missions.note_totals(component);
            }
            Request::Point(request) => self.missions.serve_point(component, link, sender, request),
            Request::Plan { mission_type, message } => {
                if let Some(kind) = message.item_kind() {
                    component.links().note_old_items(link, kind == ItemKind::Float);
                }
                self.missions.serve(component, link, sender, *mission_type, *message);
            }
            Request::Command(command) => {
                let outcome = match Command::read(command) {
                    Some(known) => self.execute(component, &known, link),
                    None => command::execute_by_number(&mut component.autopilot, command),
                };
                acknowledge(component, link, command.number, sender, outcome);
                component.send_asked_for();
            }
            Request::Message(Message::SET_MODE(data)) => self.set_mode(component, link, sender, data),
            Request::Message(Message::SET_POSITION_TARGET_LOCAL_NED(data)) => take_setpoint(component, lockstep, data),
            Request::Message(message) => serve_message(component, link, sender, message),
        }
    }

    /// Obeys a command. What the services remember a reboot forgets, too.
    pub(in crate::protocol) fn execute(
        &mut self,
        component: &mut Component,
        command: &Command,
        link: usize,
    ) -> Result<(), CommandError> {
        if command.command == MavCmd::MAV_CMD_USER_1 {
            return reset::ask(component, command.params);
        }
        if command.command == MavCmd::MAV_CMD_PREFLIGHT_STORAGE {
            return self.store(component, command);
        }
        if command.command != MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN {
            return command::execute(component, command, link);
        }
        let autopilot = &component.autopilot;
        if answers::check_reboot(autopilot.rules(), autopilot.flight.is_armed(), command)? {
            self.parameters.start_anew(component);
            self.missions.forget_uploads();
            component.autopilot.reboot();
            let time = component.autopilot.time();
            component.links().restart(time);
            (0..component.peers().len()).for_each(|link| component.announce(link));
            preflight::send_banner(&mut component.autopilot);
        }
        Ok(())
    }

    /// PREFLIGHT_STORAGE.
    fn store(&mut self, component: &mut Component, command: &Command) -> Result<(), CommandError> {
        let autopilot = &mut component.autopilot;
        match answers::storage(autopilot.rules(), autopilot.flight.is_armed(), command)? {
            Storage::Kept => {}
            Storage::Reset => self.parameters.reset(component),
            Storage::ResetByReboot => {
                autopilot.say(Severity::Warning, "All parameters reset, reboot board");
                self.parameters.reset_by_reboot();
            }
        }
        Ok(())
    }

    /// SET_MODE, DO_SET_MODE's forerunner. ArduPlane does not acknowledge it; the others do as if it were that command.
    fn set_mode(&mut self, component: &mut Component, link: usize, sender: Target, data: &SET_MODE_DATA) {
        let rules = component.autopilot.rules();
        let custom = data.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED);
        let command = Command::set_mode(rules.custom_mode_has_sub_mode, custom, data.custom_mode);
        let outcome = self.execute(component, &command, link);
        if rules.acknowledges_set_mode {
            acknowledge(component, link, command.command as u32 as u16, sender, outcome);
        } else {
            conclude(component, outcome);
        }
    }
}

fn serve_message(component: &mut Component, link: usize, sender: Target, message: &Message) {
    let autopilot = &mut component.autopilot;
    match message {
        Message::HEARTBEAT(data) => {
            autopilot.hear_heartbeat(sender.system_id, data.mavtype == MavType::MAV_TYPE_GCS);
        }
        Message::SET_POSITION_TARGET_GLOBAL_INT(data) => answers::take_global_target(autopilot, data),
        Message::SET_ATTITUDE_TARGET(data) => answers::take_attitude(autopilot, data),
        Message::RC_CHANNELS_OVERRIDE(data) => autopilot.override_channels(sender.system_id, channels_of(data)),
        Message::MANUAL_CONTROL(data) => {
            let sticks = ManualControl { x: data.x, y: data.y, z: data.z, r: data.r };
            autopilot.control_manually(sender.system_id, sticks);
        }
        Message::TIMESYNC(data) => answer_timesync(component, link, sender, data),
        Message::PING(data) => answer_ping(component, link, sender, data),
        // A PX4 passes it over.
        Message::REQUEST_DATA_STREAM(data) if autopilot.rules().commands != CommandSet::Px4 => {
            data_streams::set_data_stream(component, link, data)
        }
        Message::FILE_TRANSFER_PROTOCOL(data) => ftp::refuse(component, link, sender, data),
        Message::LOG_REQUEST_LIST(_) => data_streams::answer_log_request(component, link),
        // The real one that it is compared with, without terrain, gives a height of 0.
        Message::TERRAIN_CHECK(data) if autopilot.rules().commands == CommandSet::ArduPlane => {
            component.with_instruments(|links, instruments| {
                links.send(link, &instruments.terrain_report_at(data.lat, data.lon));
            });
        }
        // All vehicles share the scenario's origin: who would set another is told that. An ArduPlane passes it over.
        Message::SET_GPS_GLOBAL_ORIGIN(_) if autopilot.rules().tells_origin => {
            component.send_stream(link, Stream::GpsGlobalOrigin);
        }
        _ => {}
    }
}

fn take_setpoint(
    component: &mut Component,
    lockstep: Option<&mut Lockstep>,
    data: &SET_POSITION_TARGET_LOCAL_NED_DATA,
) {
    let autopilot = &mut component.autopilot;
    if lockstep.is_some_and(|lockstep| !lockstep.accept(data.time_boot_ms, autopilot.time())) {
        component.counters.setpoints_out_of_step += 1;
        return;
    }
    if answers::take_local_target(autopilot, data) {
        return;
    }
    match autopilot.check_guided().and_then(|()| Ok(setpoint_from_local_ned(data)?)) {
        Ok(setpoint) => autopilot.follow(&setpoint),
        Err(refused) => autopilot.refuse_setpoint(Severity::Warning, &format!("Setpoint refused: {refused}")),
    }
}

fn acknowledge(component: &mut Component, link: usize, number: u16, sender: Target, outcome: Result<(), CommandError>) {
    let Some(result) = conclude(component, outcome) else { return };
    component.links().acknowledge(link, number, result, sender);
    if result == MavResult::MAV_RESULT_IN_PROGRESS {
        component.conclude_later(link, number, sender);
    }
}

/// Counts a command, says aloud why it is refused, and gives its result; none if it is not answered.
fn conclude(component: &mut Component, outcome: Result<(), CommandError>) -> Option<MavResult> {
    let accepted = outcome.as_ref().map_or_else(|error| error.result == CommandResult::InProgress, |()| true);
    let counters = &mut component.counters;
    *(if accepted { &mut counters.commands_accepted } else { &mut counters.commands_refused }) += 1;
    match outcome {
        Ok(()) => Some(MavResult::MAV_RESULT_ACCEPTED),
        Err(error) => {
            if let Some(reason) = &error.reason {
                component.say(error.severity, reason);
            }
            Some(match error.result {
                CommandResult::Denied => MavResult::MAV_RESULT_DENIED,
                CommandResult::Failed => MavResult::MAV_RESULT_FAILED,
                CommandResult::Unsupported => MavResult::MAV_RESULT_UNSUPPORTED,
                CommandResult::TemporarilyRejected => MavResult::MAV_RESULT_TEMPORARILY_REJECTED,
                CommandResult::Cancelled => MavResult::MAV_RESULT_CANCELLED,
                CommandResult::InProgress => MavResult::MAV_RESULT_IN_PROGRESS,
                CommandResult::Unanswered => return None,
            })
        }
    }
}

fn channels_of(data: &RC_CHANNELS_OVERRIDE_DATA) -> [u16; CHANNELS] {
    [
        data.chan1_raw,
        data.chan2_raw,
        data.chan3_raw,
        data.chan4_raw,
        data.chan5_raw,
        data.chan6_raw,
        data.chan7_raw,
        data.chan8_raw,
        data.chan9_raw,
        data.chan10_raw,
        data.chan11_raw,
        data.chan12_raw,
        data.chan13_raw,
        data.chan14_raw,
        data.chan15_raw,
        data.chan16_raw,
    ]
}

fn answer_timesync(component: &mut Component, link: usize, sender: Target, data: &TIMESYNC_DATA) {
    // A set tc1 is itself an answer.
    if data.tc1 == 0 {
        let tc1 = i64::try_from(component.autopilot.time().as_nanos()).unwrap_or(i64::MAX);
        let Target { system_id: target_system, component_id: target_component } = sender;
        let answer = TIMESYNC_DATA { tc1, ts1: data.ts1, target_system, target_component };
        component.links().send(link, &Message::TIMESYNC(answer));
    }
}

fn answer_ping(component: &mut Component, link: usize, sender: Target, data: &PING_DATA) {
    // A ping with a target is itself an answer.
    if data.target_system == 0 && data.target_component == 0 {
        let Target { system_id: target_system, component_id: target_component } = sender;
        let answer = PING_DATA { target_system, target_component, ..data.clone() };
        component.links().send(link, &Message::PING(answer));
    }
}
