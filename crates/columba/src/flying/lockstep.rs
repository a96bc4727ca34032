//! The controller's side of a lockstep flight: real MAVLink over UDP, simulated time.
//!
//! A vehicle at time t moves on to t + T only when it has the setpoint stamped t. Until then it repeats where it is, and
//! the controller answers each repetition with the setpoint again. So nothing that the network does, and no load of the
//! machine, can change a flight: it can only take longer.

use super::ground::{Ground, GroundError, stopped};
use super::vehicles::LOCKSTEP_EPOCH_US;
use super::{Ended, Log, Progress, Recorder, Stop, Truth};
use crate::config::Scenario;
use crate::flight::Flight;
use controller::Flock;
use flight_model::State;
use mavlink_bridge::{News, boot_ms, local_ned_setpoint};
use std::time::{Duration, Instant};

/// A vehicle that says nothing for this long is given up.
const PATIENCE: Duration = Duration::from_secs(20);

/// Flies a scenario with vehicles that keep simulated time. `truth` is how they really fly, where that is known.
pub async fn fly(
    scenario: &Scenario,
    mut ground: Ground,
    mut truth: Option<Truth>,
    progress: &Progress,
    mut stop: Stop,
) -> anyhow::Result<(Flight, Log)> {
    let mut flock = Flock::new(scenario.flock_settings(), scenario.starts.len())?;
    let vehicles = scenario.starts.len();
    let mut flight = Lockstep { now: Duration::ZERO, datagrams: vec![Vec::new(); vehicles], states: Vec::new() };
    let mustered = ground.make_ready(PATIENCE, LOCKSTEP_EPOCH_US, &mut stop).await;
    let starts = match mustered {
        Ok(()) => ground.fleet().crafts().iter().filter_map(|craft| craft.position.map(|at| at.state)).collect(),
        Err(_) => scenario.starts.clone(),
    };
    let mut recorder = Recorder::new(scenario, &starts);
    flight.states = starts;
    let ended = match mustered {
        Ok(()) => flight.fly(scenario, &mut ground, &mut truth, &mut flock, &mut recorder, progress, &mut stop).await,
        Err(error) => Err(error),
    };
    let ended = Ended::from(ended);
    recorder.last(flight.now.as_secs_f64(), &flight.states);
    let (counters, log) = ground.close();
    Ok((recorder.finish(scenario, "lockstep", ended, serde_json::to_value(counters)?), log))
}

struct Lockstep {
    /// Simulated time that all vehicles have reached.
    now: Duration,
    /// The setpoint that each vehicle was sent last, to be sent again.
    datagrams: Vec<Vec<u8>>,
    states: Vec<State>,
}

impl Lockstep {
    #[allow(clippy::too_many_arguments)] // the parts of one flight, each with its own owner
    async fn fly(
        &mut self,
        scenario: &Scenario,
        ground: &mut Ground,
        truth: &mut Option<Truth>,
        flock: &mut Flock,
        recorder: &mut Recorder,
        progress: &Progress,
        stop: &mut Stop,
    ) -> Result<(), GroundError> {
        let started = Instant::now();
        let clock = move || started.elapsed();
        let step_s = scenario.integration_step.as_secs_f64();
        self.gather(ground, stop).await?;
        for tick in 0..scenario.ticks() {
            let decisions = flock.tick(tick, &self.states, &clock);
            recorder.tick(self.now.as_secs_f64(), &self.states, decisions);
            for (vehicle, decision) in decisions.iter().enumerate() {
                let setpoint = local_ned_setpoint(self.now, ground.target(vehicle), &decision.setpoint);
                let at_us = self.at_us();
                let datagram = ground.send(vehicle, &[setpoint], at_us).await;
                self.datagrams[vehicle].clear();
                self.datagrams[vehicle].extend_from_slice(datagram);
            }
            let before = self.now;
            self.now += scenario.control_period;
            if let Err(error) = self.gather(ground, stop).await {
                self.now = before;
                return Err(error);
            }
            match truth.as_mut().map(Truth::take) {
                Some((start, tracks)) => recorder.truth(start.as_secs_f64(), step_s, &tracks),
                // Without the vehicles at hand their telemetry is all there is to judge by.
                None => {
                    let tracks: Vec<Vec<State>> = self.states.iter().map(|state| vec![*state]).collect();
                    recorder.truth(before.as_secs_f64(), scenario.control_period.as_secs_f64(), &tracks);
                }
            }
            progress.flown(tick + 1);
        }
        Ok(())
    }

    /// Waits until every vehicle has reached `now`; answers those that ask again meanwhile.
    async fn gather(&mut self, ground: &mut Ground, stop: &mut Stop) -> Result<(), GroundError> {
        let now_ms = boot_ms(self.now);
        let mut news = Vec::new();
        let mut behind: Vec<bool> = ground
            .fleet()
            .crafts()
            .iter()
            .map(|craft| craft.position.map(|at| at.time_boot_ms) != Some(now_ms))
            .collect();
        let mut missing = behind.iter().filter(|behind| **behind).count();
        let mut deadline = tokio::time::Instant::now() + PATIENCE;
        while missing > 0 {
            tokio::select! {
                () = stopped(stop) => return Err(GroundError::Interrupted),
                received = ground.recv(self.at_us(), &mut news) => received?,
                () = tokio::time::sleep_until(deadline) => {
                    let missing = (0..behind.len()).filter(|&vehicle| behind[vehicle]).collect();
                    return Err(GroundError::Silent { missing, waited: PATIENCE });
                }
            }
            // A datagram brings the positions of the way too: only its last one tells where the vehicle waits.
            let last = news.iter().rev().find_map(|news| match news {
                News::Position(vehicle) => Some(*vehicle),
                _ => None,
            });
            let Some(vehicle) = last.filter(|&vehicle| behind[vehicle]) else { continue };
            let Some(position) = ground.fleet().crafts()[vehicle].position else { continue };
            if position.time_boot_ms == now_ms {
                behind[vehicle] = false;
                missing -= 1;
                deadline = tokio::time::Instant::now() + PATIENCE;
            } else if !self.datagrams[vehicle].is_empty() {
                let datagram = std::mem::take(&mut self.datagrams[vehicle]);
                ground.send_again(vehicle, &datagram).await;
                self.datagrams[vehicle] = datagram;
            }
        }
        self.states.clear();
        self.states.extend(ground.fleet().crafts().iter().filter_map(|craft| craft.position.map(|at| at.state)));
        Ok(())
    }

    fn at_us(&self) -> u64 {
        LOCKSTEP_EPOCH_US + self.now.as_micros() as u64
    }
}
