//! A world over real MAVLink in simulated time.
//!
//! A vehicle at time t moves on to t + T only when it has the setpoint stamped t. Until then it repeats where it is,
//! and the controller answers each repetition with the setpoint again. So nothing that the network does, and no load of
//! the machine, can change a flight: it can only take longer.

use super::vehicles::LOCKSTEP_EPOCH_US;
use super::{Closed, FlightError, GroundStation, GroundTruth, Interval, Watch, World};
use crate::config::Scenario;
use controller::Decision;
use flight_model::State;
use mavlink_bridge::{FleetEvent, boot_ms, local_ned_setpoint};
use std::time::Duration;
use tokio::time::Instant;

/// A vehicle that is silent for this long is given up.
const PATIENCE: Duration = Duration::from_secs(20);

/// Vehicles that keep simulated time, behind a link.
pub struct Lockstep {
    ground: GroundStation,
    ground_truth: GroundTruth,
    /// Simulated time that all vehicles have reached.
    now: Duration,
    states: Vec<State>,
    watch: Option<Watch>,
    /// The setpoint that each vehicle was sent last, to be sent again.
    datagrams: Vec<Vec<u8>>,
}

impl Lockstep {
    /// The vehicles of a scenario as `ground` hears them.
    pub fn new(scenario: &Scenario, ground: GroundStation, ground_truth: GroundTruth) -> Self {
        let states = scenario.starts.clone();
        let (watch, datagrams) = (Watch::without_a_link(scenario), vec![Vec::new(); states.len()]);
        Self { ground, ground_truth, now: Duration::ZERO, states, watch, datagrams }
    }

    /// Waits until every vehicle has reached `time`; answers those that ask again meanwhile.
    async fn gather(&mut self, time: Duration) -> Result<(), FlightError> {
        let time_ms = boot_ms(time);
        let mut news = Vec::new();
        let vehicles = self.ground.fleet().vehicles().iter();
        let mut behind: Vec<bool> =
            vehicles.map(|vehicle| vehicle.position.map(|at| at.time_boot_ms) != Some(time_ms)).collect();
        let mut missing = behind.iter().filter(|behind| **behind).count();
        let mut deadline = Instant::now() + PATIENCE;
        while missing > 0 {
            tokio::select! {
                received = self.ground.recv(at_us(time), &mut news) => received?,
                () = tokio::time::sleep_until(deadline) => {
                    let missing = (0..behind.len()).filter(|&vehicle| behind[vehicle]).collect();
                    return Err(FlightError::Silent { address: self.ground.address()?, missing, waited: PATIENCE });
                }
            }
            // A datagram brings the positions of the way too: only its last one tells where the vehicle waits.
            let last = news.iter().rev().find_map(|news| match news {
                FleetEvent::Position(vehicle) => Some(*vehicle),
                _ => None,
            });
            let Some(vehicle) = last.filter(|&vehicle| behind[vehicle]) else { continue };
            let Some(position) = self.ground.fleet().vehicles()[vehicle].position else { continue };
            if position.time_boot_ms == time_ms {
                behind[vehicle] = false;
                missing -= 1;
                deadline = Instant::now() + PATIENCE;
            } else if !self.datagrams[vehicle].is_empty() {
                tracing::trace!(vehicle = vehicle + 1, waits_at_ms = position.time_boot_ms, "setpoint sent again");
                self.ground.send_again(vehicle, &self.datagrams[vehicle]).await;
            }
        }
        self.now = time;
        self.states.clear();
        self.states
            .extend(self.ground.fleet().vehicles().iter().filter_map(|vehicle| vehicle.position.map(|at| at.state)));
        if let Some(watch) = &mut self.watch {
            watch.hear_states(&self.states, time);
            watch.look(time);
        }
        Ok(())
    }
}

impl World for Lockstep {
    fn transport(&self) -> &'static str {
        "lockstep"
    }

    async fn prepare(&mut self) -> Result<(), FlightError> {
        self.ground.make_ready(PATIENCE, LOCKSTEP_EPOCH_US).await?;
        self.gather(Duration::ZERO).await
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn states(&self) -> &[State] {
        &self.states
    }

    fn tells_ground_speeds(&self) -> bool {
        true
    }

    fn watch(&self) -> Option<&Watch> {
        self.watch.as_ref()
    }

    async fn send(&mut self, decisions: &[Decision]) -> Result<(), FlightError> {
        if let Some(watch) = &mut self.watch {
            watch.decided(self.now, self.now);
        }
        for (vehicle, (decision, kept)) in decisions.iter().zip(&mut self.datagrams).enumerate() {
            let setpoint = match &mut self.watch {
                Some(watch) => watch.command(vehicle, decision, self.now),
                None => decision.setpoint,
            };
            let setpoint = local_ned_setpoint(self.now, self.ground.target(vehicle), &setpoint);
            let datagram = self.ground.send(vehicle, &[setpoint], at_us(self.now)).await;
            kept.clear();
            kept.extend_from_slice(datagram);
        }
        Ok(())
    }

    async fn advance(&mut self, until: Duration) -> Result<(), FlightError> {
        let from = self.now;
        self.gather(until).await?;
        self.ground_truth.advance(from, until, &self.states);
        let Interval { start, step, tracks } = self.ground_truth.interval();
        if let Some(watch) = self.watch.as_mut().filter(|_| self.ground_truth.is_observed()) {
            watch.compare(start, step, tracks);
        }
        Ok(())
    }

    fn ground_truth(&mut self) -> Interval<'_> {
        self.ground_truth.interval()
    }

    fn close(self) -> Closed {
        Closed { present: self.watch.as_ref().map(Watch::figures).unwrap_or_default(), ..self.ground.close() }
    }
}

/// What the log shows at a simulated time.
fn at_us(time: Duration) -> u64 {
    LOCKSTEP_EPOCH_US + time.as_micros() as u64
}
