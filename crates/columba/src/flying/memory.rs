//! A flight in memory: no sockets, simulated time, as fast as it goes.
//!
//! States and setpoints are rounded as the wire would round them, so that a flight has the same bits as in lockstep.

use super::{Ended, Progress, Recorder, Stop, led_vehicle_settings};
use crate::config::Scenario;
use crate::flight::Flight;
use anyhow::Context;
use controller::Flock;
use flight_model::State;
use mavlink_bridge::{wire_round, wire_round_setpoint};
use sim_vehicle::Vehicle;
use std::time::{Duration, Instant};

/// Flies a scenario from beginning to end, or until `stop`.
pub fn fly(scenario: &Scenario, progress: &Progress, stop: &Stop) -> anyhow::Result<Flight> {
    let mut flock = Flock::new(scenario.flock_settings(), scenario.starts.len())?;
    let mut vehicles = led_vehicle_settings(scenario, None, super::LOCKSTEP_EPOCH_US)
        .into_iter()
        .map(|settings| Vehicle::new(sim_vehicle::VehicleSettings { ground: None, ..settings }))
        .collect::<Result<Vec<_>, _>>()?;
    let mut recorder = Recorder::new(scenario, &scenario.starts);
    let mut tracks: Vec<Vec<State>> = vec![Vec::new(); vehicles.len()];
    let mut states: Vec<State> = vehicles.iter().map(|vehicle| wire_round(vehicle.state())).collect();
    let started = Instant::now();
    let clock = move || started.elapsed();
    let (period_s, step_s) = (scenario.control_period.as_secs_f64(), scenario.integration_step.as_secs_f64());

    let mut ended = Ended::Completed;
    let mut flown = Duration::ZERO;
    for tick in 0..scenario.ticks() {
        if *stop.borrow() {
            ended = Ended::Interrupted;
            break;
        }
        let t_s = tick as f64 * period_s;
        let decisions = flock.tick(tick, &states, &clock);
        recorder.tick(t_s, &states, decisions);
        flown += scenario.control_period;
        for ((vehicle, decision), track) in vehicles.iter_mut().zip(decisions).zip(&mut tracks) {
            track.clear();
            vehicle
                .command(&wire_round_setpoint(&decision.setpoint))
                .context("a simulated vehicle refused a setpoint")?;
            vehicle.advance(flown, track);
        }
        recorder.truth(t_s, step_s, &tracks);
        states.clear();
        states.extend(vehicles.iter().map(|vehicle| wire_round(vehicle.state())));
        progress.flown(tick + 1);
    }
    recorder.last(flown.as_secs_f64(), &states);
    Ok(recorder.finish(scenario, "memory", ended, serde_json::Value::Null))
}
