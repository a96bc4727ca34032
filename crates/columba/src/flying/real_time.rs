//! The controller's side of a real-time flight: real MAVLink over UDP, the wall clock or k times it.
//!
//! Every control period each vehicle's last known position is carried forward to the present, the flock decides, and the
//! setpoints go out. What is lost is lost: the next period sends anew.

use super::ground::{Ground, GroundError, stopped};
use super::vehicles::unix_us;
use super::{Ended, Log, Progress, Recorder, Stop, Truth};
use crate::config::{Scenario, SetpointDialect};
use crate::flight::Flight;
use controller::Flock;
use flight_model::{Setpoint, State};
use mavlink_bridge::dialect::Message;
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Position, guided_commands, local_ned_setpoint};
use std::time::Duration;
use tokio::time::Instant;

/// Vehicles that do not say where they are for this long before the flight are given up.
const MUSTER_PATIENCE: Duration = Duration::from_secs(15);
/// A vehicle in flight that is silent for this long is worth a warning.
const SILENCE: Duration = Duration::from_secs(3);
/// Bank is left to the autopilot's own limit: ArduPlane takes the lateral acceleration's limit in m/s2 with each heading.
const LATERAL_ACCELERATION_MPS2: f64 = 50.0;

/// How fast the vehicles' time runs.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Seconds of flight for each second of the wall clock.
    pub speed: f64,
}

/// Flies a scenario with vehicles that keep their own time. `truth` is how they really fly, where that is known.
pub async fn fly(
    scenario: &Scenario,
    mut ground: Ground,
    mut truth: Option<Truth>,
    pace: Pace,
    progress: &Progress,
    mut stop: Stop,
) -> anyhow::Result<(Flight, Log)> {
    let mut flock = Flock::new(scenario.flock_settings(), scenario.starts.len())?;
    let mut flight =
        RealTime { pace, started: Instant::now(), elapsed: Duration::ZERO, warned: vec![false; scenario.starts.len()] };
    let mustered = ground.make_ready(MUSTER_PATIENCE, unix_us(), &mut stop).await;
    let starts = flight.states(&ground).unwrap_or_else(|| scenario.starts.clone());
    let mut recorder = Recorder::new(scenario, &starts);
    let ended = match mustered {
        Ok(()) => flight.fly(scenario, &mut ground, &mut truth, &mut flock, &mut recorder, progress, &mut stop).await,
        Err(error) => Err(error),
    };
    let ended = Ended::from(ended);
    let last = flight.states(&ground).unwrap_or(starts);
    recorder.last(flight.elapsed.as_secs_f64(), &last);
    let (counters, log) = ground.close();
    Ok((recorder.finish(scenario, "real-time", ended, serde_json::to_value(counters)?), log))
}

struct RealTime {
    pace: Pace,
    started: Instant,
    /// Flight time of the last tick that was reached.
    elapsed: Duration,
    warned: Vec<bool>,
}

impl RealTime {
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
        self.started = Instant::now();
        let started = self.started;
        let clock = move || started.elapsed();
        let offset = truth.as_mut().map_or(Duration::ZERO, Truth::start);
        let step_s = scenario.integration_step.as_secs_f64();
        for tick in 0..=scenario.ticks() {
            let flight_time = scenario.control_period * u32::try_from(tick).unwrap_or(u32::MAX);
            self.listen_until(started + flight_time.div_f64(self.pace.speed), ground, stop).await?;
            let before = self.elapsed;
            self.elapsed = flight_time;
            let Some(states) = self.states(ground) else { continue };
            if tick > 0 {
                match truth.as_mut().map(Truth::take) {
                    Some((start, tracks)) => {
                        recorder.truth(start.saturating_sub(offset).as_secs_f64(), step_s, &tracks)
                    }
                    None => {
                        let tracks: Vec<Vec<State>> = states.iter().map(|state| vec![*state]).collect();
                        recorder.truth(before.as_secs_f64(), scenario.control_period.as_secs_f64(), &tracks);
                    }
                }
                progress.flown(tick);
            }
            if tick == scenario.ticks() {
                break;
            }
            let decisions = flock.tick(tick, &states, &clock);
            recorder.tick(flight_time.as_secs_f64(), &states, decisions);
            let beat = (tick % self.ticks_per_second(scenario) == 0).then(ground_heartbeat);
            for (vehicle, decision) in decisions.iter().enumerate() {
                let mut messages = Vec::from_iter(beat.clone());
                messages.extend(self.setpoint(scenario, ground, vehicle, flight_time, &decision.setpoint));
                ground.send(vehicle, &messages, unix_us()).await;
            }
        }
        Ok(())
    }

    /// Control periods in a second of the wall clock, at which the ground's heartbeat is due.
    fn ticks_per_second(&self, scenario: &Scenario) -> u64 {
        ((self.pace.speed / scenario.control_period.as_secs_f64()).round() as u64).max(1)
    }

    /// The setpoint in the autopilot's own dialect.
    fn setpoint(
        &self,
        scenario: &Scenario,
        ground: &Ground,
        vehicle: usize,
        time: Duration,
        setpoint: &Setpoint,
    ) -> Vec<Message> {
        let target = ground.target(vehicle);
        match scenario.link.setpoints {
            SetpointDialect::LocalNed => vec![local_ned_setpoint(time, target, setpoint)],
            SetpointDialect::Arduplane => {
                match guided_commands(target, setpoint, setpoint.altitude_m, LATERAL_ACCELERATION_MPS2) {
                    Ok(commands) => commands.into(),
                    Err(error) => {
                        tracing::warn!(vehicle = vehicle + 1, %error, "setpoint not sent");
                        Vec::new()
                    }
                }
            }
        }
    }

    /// Takes what comes until an instant.
    async fn listen_until(&mut self, until: Instant, ground: &mut Ground, stop: &mut Stop) -> Result<(), GroundError> {
        let mut news = Vec::new();
        loop {
            tokio::select! {
                () = stopped(stop) => return Err(GroundError::Interrupted),
                received = ground.recv(unix_us(), &mut news) => received?,
                () = tokio::time::sleep_until(until) => break,
            }
        }
        let now = ground.now();
        for (vehicle, craft) in ground.fleet().crafts().iter().enumerate() {
            let silent = craft.last_heard.is_none_or(|heard| now.saturating_sub(heard) > SILENCE);
            if silent && !self.warned[vehicle] {
                tracing::warn!(vehicle = vehicle + 1, "no telemetry for {} s", SILENCE.as_secs());
            }
            self.warned[vehicle] = silent;
        }
        Ok(())
    }

    /// Where all vehicles are now, if all have ever said where they were.
    fn states(&self, ground: &Ground) -> Option<Vec<State>> {
        let now = ground.now();
        let state = |position: Position| self.carry_forward(&position, now);
        ground.fleet().crafts().iter().map(|craft| craft.position.map(state)).collect()
    }

    /// A position that was heard a while ago, moved on at its velocity.
    fn carry_forward(&self, position: &Position, now: Duration) -> State {
        let age_s = now.saturating_sub(position.heard).min(SILENCE).as_secs_f64() * self.pace.speed;
        let state = position.state;
        let (north_mps, east_mps) = state.velocity_mps();
        State {
            x_m: state.x_m + north_mps * age_s,
            y_m: state.y_m + east_mps * age_s,
            altitude_m: state.altitude_m + state.climb_mps * age_s,
            ..state
        }
    }
}
