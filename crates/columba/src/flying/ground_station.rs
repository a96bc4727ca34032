//! The ground station: one socket, the fleet it hears, and the log of both.

use super::vehicles::{reachable, system_id};
use super::{Closed, Log};
use crate::config::Scenario;
use flight_model::{RangeError, Ranges};
use mavlink_bridge::dialect::{COMMAND_LONG_DATA, MavCmd, MavResult, Message};
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{
    Counters, Encoder, Fleet, FleetEvent, Identity, LinkError, LinkSettings, Order, SequenceTracker, Target, UdpLink,
    messages,
};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::time::{Instant, timeout};

/// MAVLink ids of a ground station (MAV_COMP_ID_MISSIONPLANNER), as autopilots expect them.
const GROUND: (u8, u8) = (255, 190);
/// ArduPlane's GUIDED.
const GUIDED: u32 = 15;
/// A command that is not answered, or not accepted, is sent again after this.
const RETRY: Duration = Duration::from_millis(250);

/// Why a flight cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum FlightError {
    /// The socket.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Vehicles without telemetry.
    #[error("no telemetry on {address} for {} s from {}", .waited.as_secs_f64(), name(.missing))]
    Silent {
        /// Where it should have come.
        address: SocketAddr,
        /// Their indices.
        missing: Vec<usize>,
        /// For how long.
        waited: Duration,
    },
    /// A vehicle that refuses to be flown.
    #[error("vehicle {} does not accept {command}: {result}", .vehicle + 1)]
    Refused {
        /// Its index.
        vehicle: usize,
        /// What it does not accept.
        command: &'static str,
        /// Its answer.
        result: String,
    },
    /// A vehicle that refuses a setpoint.
    #[error("vehicle {} refuses its setpoint: {reason}", .vehicle + 1)]
    Setpoint {
        /// Its index.
        vehicle: usize,
        /// Its answer.
        reason: String,
    },
    /// Someone asked for the end.
    #[error("interrupted")]
    Interrupted,
}

/// `[ground]`: how the ground station waits for vehicles.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GroundSettings {
    /// In real time, a vehicle in flight that is silent for this long is warned of, and carried forward no further, s.
    pub silence_s: f64,
    /// Vehicles without a position, or that refuse a command, are given up after this before the flight, s; none: 15 in
    /// real time, 20 in lockstep.
    pub patience_s: Option<f64>,
}

impl Default for GroundSettings {
    fn default() -> Self {
        Self { silence_s: 3.0, patience_s: None }
    }
}

impl GroundSettings {
    /// Every setting that is out of its range.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        ranges.within("silence_s", self.silence_s, 0.1, 3600.0);
        if let Some(patience_s) = self.patience_s {
            ranges.within("patience_s", patience_s, 0.1, 86_400.0);
        }
        ranges.errors()
    }

    /// Silence that is worth a warning.
    pub fn silence(&self) -> Duration {
        Duration::from_secs_f64(self.silence_s)
    }
}

/// The ground's end of the link.
pub struct GroundStation {
    settings: GroundSettings,
    link: UdpLink,
    encoder: Encoder,
    fleet: Fleet,
    log: Log,
    counters: Counters,
    /// By peer: each network has its own system ids.
    sequences: HashMap<SocketAddr, SequenceTracker>,
    started: Instant,
    received: Vec<u8>,
    written: Vec<u8>,
    /// What the last datagram said, by vehicle.
    heard: Vec<(usize, Message)>,
}

impl GroundStation {
    /// Binds `address`; vehicles are recognised by the addresses given, or else by system id alone.
    pub fn bind(scenario: &Scenario, address: SocketAddr) -> Result<Self, LinkError> {
        let impairment = scenario.link.impairment;
        let settings =
            LinkSettings { inbound: impairment, outbound: impairment, seed: scenario.seed, ..LinkSettings::default() };
        let link = UdpLink::bind(address, settings)?;
        if let Ok(address) = link.local_addr() {
            tracing::debug!(%address, ?impairment, "ground station bound");
        }
        Ok(Self {
            settings: scenario.ground,
            link,
            encoder: Encoder::new(GROUND.0, GROUND.1),
            fleet: Fleet::new([]),
            log: Log::default(),
            counters: Counters::default(),
            sequences: HashMap::new(),
            started: Instant::now(),
            received: Vec::new(),
            written: Vec::new(),
            heard: Vec::new(),
        })
    }

    /// Says which vehicles to expect: at the addresses given, or else anywhere, by system id alone.
    pub fn expect(&mut self, vehicles: usize, addresses: Option<&[SocketAddr]>) {
        self.fleet = Fleet::new((0..vehicles).map(|index| Identity {
            system_id: system_id(index),
            address: addresses.and_then(|addresses| addresses.get(index).copied()).map(reachable),
        }));
    }

    /// Where vehicles on this machine find the ground, with the port that was really bound.
    pub fn address(&self) -> Result<SocketAddr, LinkError> {
        self.link.local_addr().map(reachable)
    }

    /// How it waits for vehicles.
    pub fn settings(&self) -> &GroundSettings {
        &self.settings
    }

    /// What was heard of every vehicle.
    pub fn fleet(&self) -> &Fleet {
        &self.fleet
    }

    /// Host time since the ground was bound.
    pub fn now(&self) -> Duration {
        self.started.elapsed()
    }

    /// Waits for a datagram, logs its frames at `at_us`, and tells what each brought. A frame that comes again, byte
    /// for byte, is logged once. Cancel safe.
    pub async fn recv(&mut self, at_us: u64, news: &mut Vec<FleetEvent>) -> Result<(), LinkError> {
        let from = self.link.recv(&mut self.received).await?;
        let now = self.started.elapsed();
        news.clear();
        self.heard.clear();
        let mut lost = Counters::default();
        let sequence = self.sequences.entry(from).or_default();
        for (frame, message) in messages(&self.received, &mut self.counters) {
            if sequence.observe(&frame, &mut lost) != Order::Repeated {
                self.log.frame(at_us, frame.bytes);
            }
            if let Ok(message) = message {
                let event = self.fleet.hear(&frame.header, &message, from, now);
                if let FleetEvent::Position(vehicle) | FleetEvent::Other(vehicle) = event {
                    self.heard.push((vehicle, message));
                }
                news.push(event);
            }
        }
        self.counters += lost;
        Ok(())
    }

    /// The messages of the fleet's vehicles in the last datagram, each with the vehicle's index.
    pub fn heard(&self) -> &[(usize, Message)] {
        &self.heard
    }

    /// Frames that came and that were lost on the way, so far.
    pub fn frames(&self) -> [u64; 2] {
        [self.counters.frames, self.counters.lost]
    }

    /// Sends messages to a vehicle in one datagram, which is returned to be sent again; logs them at `at_us`. A vehicle
    /// whose address is not known yet gets nothing.
    pub async fn send(&mut self, vehicle: usize, messages: &[Message], at_us: u64) -> &[u8] {
        self.written.clear();
        for message in messages {
            self.encoder.encode(message, &mut self.written);
        }
        if let Some(address) = self.fleet.vehicles().get(vehicle).and_then(|vehicle| vehicle.address) {
            self.link.send_to(&self.written, address).await;
            self.log.datagram(at_us, &self.written);
        }
        &self.written
    }

    /// Sends a datagram again, which is in the log already.
    pub async fn send_again(&mut self, vehicle: usize, datagram: &[u8]) {
        if let Some(address) = self.fleet.vehicles().get(vehicle).and_then(|vehicle| vehicle.address) {
            self.link.send_to(datagram, address).await;
        }
    }

    /// Whom a message to this vehicle names; everybody where it is not known.
    pub fn target(&self, vehicle: usize) -> Target {
        self.fleet.vehicles().get(vehicle).map_or_else(Target::default, |vehicle| vehicle.target)
    }

    /// Waits until every vehicle has said where it is, then sees to it that all are armed and in GUIDED.
    ///
    /// # Errors
    /// A vehicle is silent or refuses a command for longer than `patience`, or what the settings say instead.
    pub async fn make_ready(&mut self, patience: Duration, at_us: u64) -> Result<(), FlightError> {
        let patience = self.settings.patience_s.map_or(patience, Duration::from_secs_f64);
        self.muster(patience, at_us).await?;
        self.engage(patience, at_us).await
    }

    /// Waits until every vehicle has said where it is. Those that are silent and whose address is known are spoken to:
    /// a vehicle answers who speaks to it, though it may have been told of no ground station.
    async fn muster(&mut self, patience: Duration, at_us: u64) -> Result<(), FlightError> {
        let deadline = Instant::now() + patience;
        let mut news = Vec::new();
        let mut call = tokio::time::interval_at(Instant::now() + RETRY, RETRY);
        let mut known = usize::MAX;
        loop {
            let silent = |ground: &Self| -> Vec<usize> {
                let vehicles = ground.fleet.vehicles().iter().enumerate();
                vehicles.filter(|(_, vehicle)| vehicle.position.is_none()).map(|(index, _)| index).collect()
            };
            let missing = silent(self);
            if missing.len() != known {
                known = missing.len();
                let vehicles = self.fleet.vehicles().len();
                tracing::debug!(heard = vehicles - known, vehicles, "waiting for every vehicle's position");
            }
            if missing.is_empty() {
                return Ok(());
            }
            tokio::select! {
                received = self.recv(at_us, &mut news) => received?,
                _ = call.tick() => for vehicle in silent(self) {
                    self.send(vehicle, &[ground_heartbeat()], at_us).await;
                },
                () = tokio::time::sleep_until(deadline) => {
                    let (address, missing) = (self.address()?, silent(self));
                    return Err(FlightError::Silent { address, missing, waited: patience });
                }
            }
        }
    }

    /// Brings every vehicle into GUIDED and arms it, unless its heartbeat says that it is so already.
    async fn engage(&mut self, patience: Duration, at_us: u64) -> Result<(), FlightError> {
        let guided = command(MavCmd::MAV_CMD_DO_SET_MODE, 1.0, GUIDED as f32);
        let arm = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0, 0.0);
        for vehicle in 0..self.fleet.vehicles().len() {
            let craft = &self.fleet.vehicles()[vehicle];
            if craft.custom_mode != Some(GUIDED) {
                self.insist(vehicle, "GUIDED", guided.clone(), patience, at_us).await?;
            }
            if !self.fleet.vehicles()[vehicle].armed {
                self.insist(vehicle, "arming", arm.clone(), patience, at_us).await?;
            }
        }
        Ok(())
    }

    /// Sends a command until it is accepted.
    async fn insist(
        &mut self,
        vehicle: usize,
        name: &'static str,
        mut command: COMMAND_LONG_DATA,
        patience: Duration,
        at_us: u64,
    ) -> Result<(), FlightError> {
        let Target { system_id, component_id } = self.target(vehicle);
        (command.target_system, command.target_component) = (system_id, component_id);
        let wanted = command.command;
        let deadline = Instant::now() + patience;
        let mut news = Vec::new();
        let mut answer = "no answer".to_owned();
        while Instant::now() < deadline {
            tracing::debug!(vehicle = vehicle + 1, command = name, attempt = command.confirmation + 1, "command sent");
            self.send(vehicle, &[Message::COMMAND_LONG(command.clone())], at_us).await;
            command.confirmation = command.confirmation.saturating_add(1);
            let retry = Instant::now() + RETRY;
            while Instant::now() < retry {
                if let Ok(received) = timeout(RETRY, self.recv(at_us, &mut news)).await {
                    received?;
                }
                match &self.fleet.vehicles()[vehicle].last_ack {
                    Some(ack) if ack.command == wanted && ack.result == MavResult::MAV_RESULT_ACCEPTED => {
                        tracing::debug!(vehicle = vehicle + 1, command = name, "accepted");
                        return Ok(());
                    }
                    Some(ack) if ack.command == wanted => answer = format!("{:?}", ack.result),
                    _ => {}
                }
            }
        }
        Err(FlightError::Refused { vehicle, command: name, result: answer })
    }

    /// The counters of the link as JSON, and the log.
    pub fn close(self) -> Closed {
        let counters = serde_json::to_value(self.link.counters() + self.counters);
        // Numbers by name cannot fail to be written.
        Closed { counters: counters.unwrap_or_default(), log: Some(self.log), ..Closed::default() }
    }
}

fn command(command: MavCmd, param1: f32, param2: f32) -> COMMAND_LONG_DATA {
    COMMAND_LONG_DATA { command, param1, param2, ..COMMAND_LONG_DATA::DEFAULT }
}

fn name(vehicles: &[usize]) -> String {
    let shown: Vec<String> = vehicles.iter().take(8).map(|vehicle| (vehicle + 1).to_string()).collect();
    let more = if vehicles.len() > shown.len() {
        format!(" and {} more", vehicles.len() - shown.len())
    } else {
        String::new()
    };
    let plural = if vehicles.len() == 1 { "vehicle" } else { "vehicles" };
    format!("{plural} {}{more}", shown.join(", "))
}
