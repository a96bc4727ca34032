//! The MAVLink services that the vehicle offers, message by message.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

pub(crate) mod command;
mod data_streams;
pub(crate) mod mission;
pub(crate) mod parameter;

use crate::firmware::Personality;
use crate::protocol::command::{Command, Refusal};
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{
    MavModeFlag, MavResult, MavSeverity, Message, PING_DATA, SET_MODE_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
    TIMESYNC_DATA,
};
use mavlink_bridge::{Incoming, ItemKind, Request, Target, setpoint_from_local_ned};
use std::time::Duration;

impl Vehicle {
    /// Does what is asked over a link, of this vehicle.
    pub(crate) fn serve(&mut self, link: usize, incoming: &Incoming) {
        let sender = Target { system_id: incoming.header.system_id, component_id: incoming.header.component_id };
        match &incoming.request {
            Request::Parameter(request) => self.serve_parameter(link, sender, request),
            Request::Plan { mission_type, message } => {
                if let Some(kind) = message.item_kind() {
                    self.links.note_old_items(link, kind == ItemKind::Float);
                }
                self.serve_plan(link, sender, *mission_type, *message);
            }
            Request::Command(command) => {
                let outcome = match Command::read(command) {
                    Some(known) => self.execute(&known, link),
                    None => self.execute_by_number(command),
                };
                self.acknowledge(link, command.number, sender, outcome);
            }
            Request::Message(message) => self.serve_message(link, sender, message),
        }
    }

    fn serve_message(&mut self, link: usize, sender: Target, message: &Message) {
        match message {
            Message::HEARTBEAT(data) => {
                self.hear_heartbeat(sender.system_id);
                self.px4_hear_heartbeat(data.mavtype);
            }
            Message::SET_MODE(data) => self.legacy_set_mode(link, sender, data),
            Message::SET_POSITION_TARGET_LOCAL_NED(data) => self.take_setpoint(data),
            Message::SET_POSITION_TARGET_GLOBAL_INT(data) => self.take_global_target(data),
            Message::SET_ATTITUDE_TARGET(_) if self.settings.personality == Personality::Px4 => {
                self.px4_take_attitude();
            }
            Message::RC_CHANNELS_OVERRIDE(data) => self.override_channels(sender.system_id, data),
            Message::MANUAL_CONTROL(data) => self.control_manually(sender.system_id, data),
            Message::TIMESYNC(data) => self.answer_timesync(link, sender, data),
            Message::PING(data) => self.answer_ping(link, sender, data),
            // A PX4 passes it over.
            Message::REQUEST_DATA_STREAM(data) if self.settings.personality != Personality::Px4 => {
                self.set_data_stream(link, data);
            }
            Message::FILE_TRANSFER_PROTOCOL(data) => self.refuse_file_transfer(link, sender, data),
            Message::LOG_REQUEST_LIST(_) => self.answer_log_request(link),
            // All vehicles share the scenario's origin: who would set another is told that. An ArduPlane passes it over.
            Message::SET_GPS_GLOBAL_ORIGIN(_) if self.settings.personality != Personality::ArduPlane => {
                self.send_stream(link, Stream::GpsGlobalOrigin);
            }
            _ => {}
        }
    }

    fn take_setpoint(&mut self, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
        if self.lockstep.as_mut().is_some_and(|lockstep| !lockstep.accept(data.time_boot_ms, self.time)) {
            self.counters.setpoints_out_of_step += 1;
            return;
        }
        if self.take_local_target(data) {
            return;
        }
        let result = self.check_guided().and_then(|()| Ok(setpoint_from_local_ned(data)?));
        match result {
            Ok(setpoint) => {
                self.counters.setpoints_accepted += 1;
                let full = setpoint.over(&self.flight.state().hold());
                if let Some(velocity) = setpoint.velocity {
                    self.flight.set_ground_speed(full.speed_mps);
                    // A velocity of zero has no direction: the course stays.
                    if velocity.norm_squared() > 0.0 {
                        self.flight.set_course(full.course_rad, f64::INFINITY);
                    }
                }
                if setpoint.altitude.is_some() {
                    self.flight.set_altitude(full.altitude_m, f64::INFINITY);
                }
                self.restart_setpoint_timeout();
            }
            Err(refused) => {
                self.refuse_setpoint(MavSeverity::MAV_SEVERITY_WARNING, &format!("Setpoint refused: {refused}"));
            }
        }
    }

    /// Counts a setpoint that is not followed, and says why: setpoints come in streams, one word in five seconds is enough.
    pub(crate) fn refuse_setpoint(&mut self, severity: MavSeverity, text: &str) {
        self.counters.setpoints_refused += 1;
        if self.time >= self.quiet_until {
            self.quiet_until = self.time + Duration::from_secs(5);
            self.say(severity, text);
        }
    }

    fn acknowledge(&mut self, link: usize, number: u16, sender: Target, outcome: Result<(), Refusal>) {
        let result = self.conclude(outcome);
        self.links.acknowledge(link, number, result, sender);
    }

    /// Counts a command, says aloud why it is refused, and gives its result.
    fn conclude(&mut self, outcome: Result<(), Refusal>) -> MavResult {
        match outcome {
            Ok(()) => {
                self.counters.commands_accepted += 1;
                MavResult::MAV_RESULT_ACCEPTED
            }
            Err(refusal) => {
                self.counters.commands_refused += 1;
                if let Some(reason) = &refusal.reason {
                    self.say(refusal.severity, reason);
                }
                refusal.result
            }
        }
    }

    /// SET_MODE, DO_SET_MODE's forerunner. ArduPlane does not acknowledge it; the others do as if it were that command.
    fn legacy_set_mode(&mut self, link: usize, sender: Target, data: &SET_MODE_DATA) {
        let custom = data.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED);
        let command = Command::set_mode(self.settings.personality, custom, data.custom_mode);
        let outcome = self.execute(&command, link);
        if self.settings.personality == Personality::ArduPlane {
            self.conclude(outcome);
        } else {
            self.acknowledge(link, command.command as u32 as u16, sender, outcome);
        }
    }

    fn answer_timesync(&mut self, link: usize, sender: Target, data: &TIMESYNC_DATA) {
        // A set tc1 is itself an answer.
        if data.tc1 == 0 {
            let tc1 = i64::try_from(self.time.as_nanos()).unwrap_or(i64::MAX);
            let Target { system_id: target_system, component_id: target_component } = sender;
            self.links
                .send(link, &Message::TIMESYNC(TIMESYNC_DATA { tc1, ts1: data.ts1, target_system, target_component }));
        }
    }

    fn answer_ping(&mut self, link: usize, sender: Target, data: &PING_DATA) {
        // A ping with a target is itself an answer.
        if data.target_system == 0 && data.target_component == 0 {
            let Target { system_id: target_system, component_id: target_component } = sender;
            self.links.send(link, &Message::PING(PING_DATA { target_system, target_component, ..data.clone() }));
        }
    }
}
