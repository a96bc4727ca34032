//! The MAVLink services that the vehicle offers, message by message.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

pub(crate) mod command;
mod data_streams;
pub(crate) mod mission;
pub(crate) mod parameter;

use crate::error::Severity;
use crate::firmware::Personality;
use crate::protocol::command::{Command, Refusal};
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{
    DialectMessage, MavModeFlag, MavResult, Message, PING_DATA, SET_MODE_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
    TIMESYNC_DATA,
};
use mavlink_bridge::{
    Frame, FrameError, Target, parameter_request, plan_message, raw_command, setpoint_from_local_ned,
};

/// The system that a frame is for, 0 for all; none if the frame tells nothing to anyone.
pub(crate) fn target_system(frame: &Frame<'_>, message: &Result<Message, FrameError>) -> Option<u8> {
    match message {
        Ok(message) => Some(message.target_system_id().unwrap_or(0)),
        Err(_) => {
            let command = raw_command(frame).map(|command| command.target_system);
            let parameter = || parameter_request(frame).map(|(target, _)| target.system_id);
            let plan = || plan_message(frame).map(|(target, ..)| target.system_id);
            command.or_else(parameter).or_else(plan)
        }
    }
}

impl Vehicle {
    /// Does what a message asks that came over a link and is for this vehicle.
    pub(crate) fn serve(&mut self, link: usize, frame: &Frame<'_>, message: &Result<Message, FrameError>) {
        let sender = Target { system_id: frame.header.system_id, component_id: frame.header.component_id };
        if let Some((_, request)) = parameter_request(frame) {
            self.serve_parameter(link, sender, &request);
            return;
        }
        if let Some((_, mission_type, message)) = plan_message(frame) {
            const MISSION_ITEM: u32 = 39;
            const MISSION_REQUEST: u32 = 40;
            const MISSION_REQUEST_INT: u32 = 51;
            const MISSION_ITEM_INT: u32 = 73;
            match frame.header.message_id {
                MISSION_ITEM | MISSION_REQUEST => self.links().note_old_items(link, true),
                MISSION_ITEM_INT | MISSION_REQUEST_INT => self.links().note_old_items(link, false),
                _ => {}
            }
            self.serve_plan(link, sender, mission_type, message);
            return;
        }
        match message {
            Ok(Message::HEARTBEAT(data)) => {
                self.autopilot.hear_heartbeat(sender.system_id);
                self.autopilot.px4_hear_heartbeat(data.mavtype);
            }
            Ok(Message::COMMAND_LONG(data)) => self.obey(link, data.command as u32 as u16, sender, &data.into()),
            Ok(Message::COMMAND_INT(data)) => self.obey(link, data.command as u32 as u16, sender, &data.into()),
            Ok(Message::SET_MODE(data)) => self.legacy_set_mode(link, sender, data),
            Ok(Message::SET_POSITION_TARGET_LOCAL_NED(data)) => self.take_setpoint(data),
            Ok(Message::SET_POSITION_TARGET_GLOBAL_INT(data)) => self.autopilot.take_global_target(data),
            Ok(Message::SET_ATTITUDE_TARGET(_)) if self.autopilot.settings.personality == Personality::Px4 => {
                self.autopilot.px4_take_attitude();
            }
            Ok(Message::RC_CHANNELS_OVERRIDE(data)) => self.autopilot.override_channels(sender.system_id, data),
            Ok(Message::MANUAL_CONTROL(data)) => self.autopilot.control_manually(sender.system_id, data),
            Ok(Message::TIMESYNC(data)) => self.answer_timesync(link, sender, data),
            Ok(Message::PING(data)) => self.answer_ping(link, sender, data),
            Ok(Message::REQUEST_DATA_STREAM(data)) => self.set_data_stream(link, data),
            Ok(Message::FILE_TRANSFER_PROTOCOL(data)) => self.refuse_file_transfer(link, sender, data),
            Ok(Message::LOG_REQUEST_LIST(_)) => self.answer_log_request(link),
            // All vehicles share the scenario's origin: who would set another is told that. An ArduPlane passes it over.
            Ok(Message::SET_GPS_GLOBAL_ORIGIN(_)) if self.autopilot.settings.personality != Personality::ArduPlane => {
                self.send_stream(link, Stream::GpsGlobalOrigin);
            }
            Ok(_) => {}
            Err(_) => {
                if let Some(raw) = raw_command(frame) {
                    let outcome = self.autopilot.execute_by_number(&raw);
                    self.acknowledge(link, raw.command, sender, outcome);
                }
            }
        }
    }

    fn take_setpoint(&mut self, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
        if self.lockstep.as_mut().is_some_and(|lockstep| !lockstep.accept(data.time_boot_ms, self.autopilot.time)) {
            self.autopilot.counters.setpoints_out_of_step += 1;
            return;
        }
        if self.autopilot.take_local_target(data) {
            return;
        }
        let result = self.autopilot.check_guided().and_then(|()| Ok(setpoint_from_local_ned(data)?));
        match result {
            Ok(setpoint) => {
                self.autopilot.counters.setpoints_accepted += 1;
                let full = setpoint.over(&self.autopilot.flight.state().hold());
                if let Some(velocity) = setpoint.velocity {
                    self.autopilot.flight.set_ground_speed(full.speed_mps);
                    // A velocity of zero has no direction: the course stays.
                    if velocity != (0.0, 0.0) {
                        self.autopilot.flight.set_course(full.course_rad, f64::INFINITY);
                    }
                }
                if setpoint.altitude.is_some() {
                    self.autopilot.flight.set_altitude(full.altitude_m, f64::INFINITY);
                }
                self.autopilot.restart_setpoint_timeout();
            }
            Err(refused) => {
                self.autopilot.refuse_setpoint(Severity::Warning, &format!("Setpoint refused: {refused}"));
            }
        }
    }

    fn obey(&mut self, link: usize, number: u16, sender: Target, command: &Command) {
        let outcome = self.execute(command, link);
        self.acknowledge(link, number, sender, outcome);
    }

    fn acknowledge(&mut self, link: usize, number: u16, sender: Target, outcome: Result<(), Refusal>) {
        let result = self.conclude(outcome);
        self.links().acknowledge(link, number, result, sender);
    }

    /// Counts a command, says aloud why it is refused, and gives its result.
    fn conclude(&mut self, outcome: Result<(), Refusal>) -> MavResult {
        match outcome {
            Ok(()) => {
                self.autopilot.counters.commands_accepted += 1;
                MavResult::MAV_RESULT_ACCEPTED
            }
            Err(refusal) => {
                self.autopilot.counters.commands_refused += 1;
                if let Some(reason) = &refusal.reason {
                    self.autopilot.say(refusal.severity, reason);
                }
                refusal.result
            }
        }
    }

    /// SET_MODE, DO_SET_MODE's forerunner. ArduPlane does not acknowledge it; the others do as if it were that command.
    fn legacy_set_mode(&mut self, link: usize, sender: Target, data: &SET_MODE_DATA) {
        let custom = data.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED);
        let command = Command::set_mode(self.autopilot.settings.personality, custom, data.custom_mode);
        if self.autopilot.settings.personality == Personality::ArduPlane {
            let outcome = self.execute(&command, link);
            self.conclude(outcome);
        } else {
            self.obey(link, command.command as u32 as u16, sender, &command);
        }
    }

    fn answer_timesync(&mut self, link: usize, sender: Target, data: &TIMESYNC_DATA) {
        // A set tc1 is itself an answer.
        if data.tc1 == 0 {
            let tc1 = i64::try_from(self.autopilot.time.as_nanos()).unwrap_or(i64::MAX);
            let Target { system_id: target_system, component_id: target_component } = sender;
            self.links()
                .send(link, &Message::TIMESYNC(TIMESYNC_DATA { tc1, ts1: data.ts1, target_system, target_component }));
        }
    }

    fn answer_ping(&mut self, link: usize, sender: Target, data: &PING_DATA) {
        // A ping with a target is itself an answer.
        if data.target_system == 0 && data.target_component == 0 {
            let Target { system_id: target_system, component_id: target_component } = sender;
            self.links().send(link, &Message::PING(PING_DATA { target_system, target_component, ..data.clone() }));
        }
    }
}
