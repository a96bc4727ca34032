//! A client for tests: one vehicle in memory, driven by messages, without sockets and clocks. Behind the feature
//! `testing`.
//!
//! ```
//! use mavlink_bridge::dialect::{MavCmd, MavResult};
//! use sim_vehicle::testing::Client;
//! use sim_vehicle::{Mode, VehicleSettings};
//!
//! let mut client = Client::new(VehicleSettings { armed: false, ..VehicleSettings::default() })?;
//! assert_eq!(client.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0]), Some(MavResult::MAV_RESULT_ACCEPTED));
//! assert_eq!(client.command(MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, []), Some(MavResult::MAV_RESULT_ACCEPTED));
//! assert_eq!(client.vehicle().mode(), Mode::Rtl);
//!
//! client.fly(60.0);
//! assert!(client.texts().iter().any(|text| text == "Throttle armed"));
//! # Ok::<(), sim_vehicle::SettingsError>(())
//! ```

use crate::links::PeerId;
use crate::settings::{SettingsError, VehicleSettings};
use crate::vehicle::Vehicle;
use flight_model::State;
use mavlink_bridge::dialect::{
    COMMAND_LONG_DATA, MavCmd, MavParamType, MavResult, Message, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA,
};
use mavlink_bridge::{Counters, Encoder, messages};
use std::time::Duration;

/// A ground station and its vehicle. What the vehicle sends is kept until it is asked for.
#[derive(Debug)]
pub struct Client {
    vehicle: Vehicle,
    encoder: Encoder,
    address: PeerId,
    received: Vec<Message>,
}

impl Client {
    /// A client of a vehicle that sends telemetry to nobody else. It is system 255, component 190: a ground station.
    ///
    /// # Errors
    /// The vehicle's settings are not valid.
    pub fn new(settings: VehicleSettings) -> Result<Self, SettingsError> {
        let vehicle = Vehicle::new(VehicleSettings { ground: None, ..settings })?;
        let address = PeerId::from(([127, 0, 0, 1], 40_000));
        Ok(Self { vehicle, encoder: Encoder::new(255, 190), address, received: Vec::new() })
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// Sends a message, and gives what comes back at once.
    pub fn ask(&mut self, message: &Message) -> &[Message] {
        let mut datagram = Vec::new();
        self.encoder.encode(message, &mut datagram);
        self.vehicle.handle(self.vehicle.time(), &datagram, self.address);
        self.receive()
    }

    /// Sends a COMMAND_LONG with its first params, the others 0, and gives the result of its acknowledgement; none if
    /// there is none.
    pub fn command<const N: usize>(&mut self, command: MavCmd, params: [f32; N]) -> Option<MavResult> {
        let param = |index: usize| params.get(index).copied().unwrap_or_default();
        let message = Message::COMMAND_LONG(COMMAND_LONG_DATA {
            param1: param(0),
            param2: param(1),
            param3: param(2),
            param4: param(3),
            param5: param(4),
            param6: param(5),
            param7: param(6),
            command,
            target_system: self.vehicle.settings().system_id,
            target_component: self.vehicle.settings().component_id,
            confirmation: 0,
        });
        self.ask(&message).iter().find_map(|message| match message {
            Message::COMMAND_ACK(ack) if ack.command == command => Some(ack.result),
            _ => None,
        })
    }

    /// Sets a parameter, and gives its value as the vehicle tells it then; none if it does not have it.
    ///
    /// ```
    /// use sim_vehicle::testing::Client;
    /// use sim_vehicle::VehicleSettings;
    ///
    /// let mut client = Client::new(VehicleSettings::default())?;
    /// assert_eq!(client.set_parameter("WP_LOITER_RAD", 80.0), Some(80.0));
    /// assert_eq!(client.parameter("WP_LOITER_RAD"), Some(80.0));
    /// assert_eq!(client.parameter("NO_SUCH"), None);
    /// # Ok::<(), sim_vehicle::SettingsError>(())
    /// ```
    pub fn set_parameter(&mut self, name: &str, value: f32) -> Option<f32> {
        let message = Message::PARAM_SET(PARAM_SET_DATA {
            param_value: value,
            target_system: self.vehicle.settings().system_id,
            target_component: self.vehicle.settings().component_id,
            param_id: name.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        });
        told_value(self.ask(&message), name)
    }

    /// Asks for the value of a parameter; none if the vehicle does not have it.
    pub fn parameter(&mut self, name: &str) -> Option<f32> {
        let message = Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            param_index: -1,
            target_system: self.vehicle.settings().system_id,
            target_component: self.vehicle.settings().component_id,
            param_id: name.into(),
        });
        told_value(self.ask(&message), name)
    }

    /// Flies for a time, s, and gives the state after each integration step.
    pub fn fly(&mut self, seconds: f64) -> Vec<State> {
        let mut track = Vec::new();
        let until = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        self.vehicle.advance(self.vehicle.time() + until, &mut track);
        self.vehicle.handle_timeout(self.vehicle.time());
        self.receive();
        track
    }

    /// All messages that have come so far.
    pub fn received(&self) -> &[Message] {
        &self.received
    }

    /// Forgets what has come so far.
    pub fn forget(&mut self) {
        self.received.clear();
    }

    /// What has been said in STATUSTEXT so far, each text whole.
    pub fn texts(&self) -> Vec<String> {
        let mut texts: Vec<String> = Vec::new();
        for message in &self.received {
            let Message::STATUSTEXT(text) = message else { continue };
            let words = text.text.to_str().unwrap_or_default();
            match texts.last_mut().filter(|_| text.chunk_seq > 0) {
                Some(begun) => begun.push_str(words),
                None => texts.push(words.to_owned()),
            }
        }
        texts
    }

    /// Takes what the vehicle has sent, and gives what is new.
    fn receive(&mut self) -> &[Message] {
        let before = self.received.len();
        while let Some(transmit) = self.vehicle.poll_transmit() {
            if transmit.to == self.address {
                let mut counters = Counters::default();
                self.received
                    .extend(messages(&transmit.datagram, &mut counters).filter_map(|(_, message)| message.ok()));
            }
        }
        &self.received[before..]
    }
}

fn told_value(answer: &[Message], name: &str) -> Option<f32> {
    answer.iter().find_map(|message| match message {
        Message::PARAM_VALUE(value) if value.param_id.to_str() == Ok(name) => Some(value.param_value),
        _ => None,
    })
}
