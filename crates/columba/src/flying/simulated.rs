//! A world in which vehicles keep their own time, as in real time, but the clock and the link are simulated: real
//! MAVLink bytes through a link in memory that loses and delays them as `[link]` says. Repeatable, and as fast as it
//! goes.

use super::memory::at_once;
use super::setpoints::setpoint_messages;
use super::{
    Closed, FlightError, Interval, LOCKSTEP_EPOCH_US, Log, Progress, Stop, Watch, World, fly, led_vehicle_settings,
};
use crate::config::{Scenario, SetpointDialect};
use crate::flight::Flight;
use controller::Decision;
use flight_model::State;
use mavlink_bridge::dialect::{COMMAND_LONG_DATA, MavCmd, Message, Target};
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Counters, Encoder, Impairment, SequenceTracker, messages};
use sim_vehicle::{PeerId, Vehicle, VehicleSettings};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::time::Duration;

/// Vehicles fly in strides of this, as those of a host do.
const STRIDE: Duration = Duration::from_millis(5);
/// Where the vehicles believe the ground to be.
const GROUND: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 14550);
/// ArduPlane's GUIDED.
const GUIDED: f32 = 15.0;

/// Flies a scenario over a simulated link from beginning to end, or until `stop`.
///
/// # Errors
/// The optimiser, a vehicle or the link refuses its settings.
pub fn fly_simulated(scenario: &Scenario, progress: &Progress, stop: &Stop) -> anyhow::Result<(Flight, Option<Log>)> {
    at_once(fly(scenario, Simulated::new(scenario)?, progress, stop.clone()))
}

/// The simulated vehicles of a scenario, behind a simulated link.
pub struct Simulated {
    vehicles: Vec<Vehicle>,
    down: Impairment<usize>,
    up: Impairment<usize>,
    encoder: Encoder,
    sequences: Vec<SequenceTracker>,
    counters: Counters,
    log: Log,
    watch: Watch,
    setpoints: SetpointDialect,
    decisions: Vec<Decision>,
    /// The simulated clock, and flight time of the last tick.
    clock: Duration,
    now: Duration,
    interval_start: Duration,
    step: Duration,
    tracks: Vec<Vec<State>>,
}

impl Simulated {
    /// The vehicles at their starts.
    ///
    /// # Errors
    /// A vehicle or the link refuses its settings.
    pub fn new(scenario: &Scenario) -> anyhow::Result<Self> {
        let vehicles = led_vehicle_settings(scenario, Some(GROUND), LOCKSTEP_EPOCH_US)
            .into_iter()
            .map(Vehicle::new)
            .collect::<Result<Vec<_>, _>>()?;
        let link = |stream| Impairment::new(scenario.link.impairment, scenario.seed, stream);
        Ok(Self {
            down: link(0)?,
            up: link(1)?,
            encoder: Encoder::new(255, 190),
            sequences: vehicles.iter().map(|_| SequenceTracker::default()).collect(),
            counters: Counters::default(),
            log: Log::default(),
            watch: Watch::new(scenario),
            setpoints: scenario.link.setpoints,
            decisions: Vec::new(),
            clock: Duration::ZERO,
            now: Duration::ZERO,
            interval_start: Duration::ZERO,
            step: scenario.integration_step,
            tracks: vec![Vec::new(); vehicles.len()],
            vehicles,
        })
    }

    /// Lets vehicles and link run until a time of the simulated clock.
    fn run_until(&mut self, until: Duration) {
        while self.clock < until {
            let stride_ends = STRIDE * u32::try_from(self.clock.as_nanos() / STRIDE.as_nanos() + 1).unwrap_or(u32::MAX);
            let due = [self.up.next_due(), self.down.next_due()].into_iter().flatten().min();
            self.clock = stride_ends.min(due.unwrap_or(stride_ends)).max(self.clock).min(until);
            self.exchange();
        }
    }

    /// What goes to and fro at the present moment.
    fn exchange(&mut self) {
        let now = self.clock;
        while let Some((datagram, vehicle)) = self.up.poll(now) {
            self.fly(vehicle);
            self.vehicles[vehicle].handle(now, &datagram, PeerId::from(GROUND));
        }
        for vehicle in 0..self.vehicles.len() {
            self.fly(vehicle);
            while let Some(transmit) = self.vehicles[vehicle].poll_transmit() {
                self.down.offer(now, &transmit.datagram, vehicle);
            }
        }
        while let Some((datagram, vehicle)) = self.down.poll(now) {
            let at_us = LOCKSTEP_EPOCH_US + now.as_micros() as u64;
            let mut lost = Counters::default();
            for (frame, message) in messages(&datagram, &mut self.counters) {
                self.sequences[vehicle].observe(&frame, &mut lost);
                self.log.frame(at_us, frame.bytes);
                if let Ok(message) = message {
                    self.watch.hear(vehicle, &message, now);
                }
            }
            self.counters += lost;
        }
    }

    fn fly(&mut self, vehicle: usize) {
        self.vehicles[vehicle].handle_timeout(self.clock);
        self.vehicles[vehicle].advance(self.clock, &mut self.tracks[vehicle]);
    }

    fn command(&mut self) {
        let now = self.clock;
        let decisions = std::mem::take(&mut self.decisions);
        for (vehicle, decision) in decisions.iter().enumerate() {
            let setpoint = self.watch.command(vehicle, decision, now);
            let target = self.target(vehicle);
            let mut messages = vec![ground_heartbeat(), Watch::time_request(now)];
            messages.extend(setpoint_messages(self.setpoints, vehicle, target, &setpoint, self.now));
            self.offer(vehicle, &messages);
        }
        self.decisions = decisions;
    }

    fn target(&self, vehicle: usize) -> Target {
        let VehicleSettings { system_id, component_id, .. } = *self.vehicles[vehicle].settings();
        Target { system_id, component_id }
    }

    fn offer(&mut self, vehicle: usize, messages: &[Message]) {
        let mut datagram = Vec::new();
        for message in messages {
            self.encoder.encode(message, &mut datagram);
        }
        self.log.datagram(LOCKSTEP_EPOCH_US + self.clock.as_micros() as u64, &datagram);
        self.up.offer(self.clock, &datagram, vehicle);
    }

    fn look(&mut self) {
        self.watch.note_frames(self.counters.frames, self.counters.lost);
        self.watch.look(self.clock);
    }
}

impl World for Simulated {
    fn transport(&self) -> &'static str {
        "simulated"
    }

    async fn prepare(&mut self) -> Result<(), FlightError> {
        // Who is not armed, or not in GUIDED, is brought there past the link: no flight hangs on it.
        let order = |command, param1, param2| {
            Message::COMMAND_LONG(COMMAND_LONG_DATA { command, param1, param2, ..COMMAND_LONG_DATA::DEFAULT })
        };
        let mut datagram = Vec::new();
        self.encoder.encode(&order(MavCmd::MAV_CMD_DO_SET_MODE, 1.0, GUIDED), &mut datagram);
        self.encoder.encode(&order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0, 0.0), &mut datagram);
        for vehicle in self.vehicles.iter_mut().filter(|vehicle| !vehicle.is_armed()) {
            vehicle.handle(Duration::ZERO, &datagram, PeerId::from(GROUND));
        }
        self.exchange();
        self.look();
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn states(&self) -> &[State] {
        self.watch.states()
    }

    fn tells_ground_speeds(&self) -> bool {
        self.setpoints == SetpointDialect::LocalNed
    }

    fn watch(&self) -> Option<&Watch> {
        Some(&self.watch)
    }

    fn starts(&self) -> Vec<State> {
        self.vehicles.iter().map(|vehicle| *vehicle.state()).collect()
    }

    async fn send(&mut self, decisions: &[Decision]) -> Result<(), FlightError> {
        self.decisions.clear();
        self.decisions.extend_from_slice(decisions);
        self.watch.decided(self.now, self.clock);
        self.command();
        Ok(())
    }

    async fn advance(&mut self, until: Duration) -> Result<(), FlightError> {
        self.tracks.iter_mut().for_each(Vec::clear);
        self.interval_start = self.now;
        for again in self.watch.sends_again(until.saturating_sub(self.now)) {
            self.run_until(self.now + again);
            self.command();
        }
        self.run_until(until);
        self.now = until;
        self.look();
        self.watch.compare(self.interval_start, self.step, &self.tracks);
        Ok(())
    }

    fn ground_truth(&mut self) -> Interval<'_> {
        Interval { start: self.interval_start, step: self.step, tracks: &self.tracks }
    }

    fn close(self) -> Closed {
        let mut counters = self.counters;
        self.down.count(&mut counters);
        self.up.count(&mut counters);
        Closed {
            counters: serde_json::to_value(counters).unwrap_or_default(),
            present: self.watch.figures(),
            log: Some(self.log),
        }
    }
}
