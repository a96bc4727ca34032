//! A world over real MAVLink in real time: the wall clock, or k times it.
//!
//! Every control period each vehicle's last known position is carried forward to the present, the flock decides, and
//! the setpoints go out. A setpoint that is lost is not repeated: the next period sends a new one.

use super::vehicles::unix_us;
use super::{FlightError, GroundStation, GroundTruth, Interval, Log, World};
use crate::config::{Scenario, SetpointDialect};
use controller::Decision;
use flight_model::{Setpoint, State};
use mavlink_bridge::dialect::Message;
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Position, guided_commands, local_ned_setpoint};
use std::time::Duration;
use tokio::time::Instant;

/// Vehicles whose position stays unknown for this long before the flight are given up.
const MUSTER_PATIENCE: Duration = Duration::from_secs(15);
/// Bank is left to the autopilot's own limit: ArduPlane takes the lateral acceleration's limit in m/s2 with each
/// heading.
const LATERAL_ACCELERATION_MPS2: f64 = 50.0;

/// Vehicles that keep their own time, behind a link.
pub struct RealTime {
    ground: GroundStation,
    ground_truth: GroundTruth,
    /// Seconds of flight for each second of the wall clock.
    speed: f64,
    setpoints: SetpointDialect,
    /// Heartbeats are due once in so many control periods.
    ticks_per_heartbeat: u64,
    sent: u64,
    started: Instant,
    now: Duration,
    states: Vec<State>,
    /// Vehicles of which a warning of silence was given.
    silent: Vec<bool>,
}

impl RealTime {
    /// The vehicles of a scenario as `ground` hears them; their time runs `speed` times as fast as the wall clock.
    pub fn new(scenario: &Scenario, ground: GroundStation, ground_truth: GroundTruth, speed: f64) -> Self {
        let states = scenario.starts.clone();
        Self {
            ground,
            ground_truth,
            speed,
            setpoints: scenario.link.setpoints,
            ticks_per_heartbeat: ((speed / scenario.control_period.as_secs_f64()).round() as u64).max(1),
            sent: 0,
            started: Instant::now(),
            now: Duration::ZERO,
            silent: vec![false; states.len()],
            states,
        }
    }

    /// The setpoint in the autopilot's own dialect.
    fn setpoint(&self, vehicle: usize, setpoint: &Setpoint) -> Vec<Message> {
        let target = self.ground.target(vehicle);
        match self.setpoints {
            SetpointDialect::LocalNed => vec![local_ned_setpoint(self.now, target, setpoint)],
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
    async fn listen_until(&mut self, until: Instant) -> Result<(), FlightError> {
        let mut news = Vec::new();
        loop {
            tokio::select! {
                received = self.ground.recv(unix_us(), &mut news) => received?,
                () = tokio::time::sleep_until(until) => return Ok(()),
            }
        }
    }

    /// Warns of vehicles that have become silent.
    fn watch_silence(&mut self) {
        let (now, silence) = (self.ground.now(), self.ground.settings().silence());
        for (vehicle, (craft, warned)) in self.ground.fleet().vehicles().iter().zip(&mut self.silent).enumerate() {
            let silent = craft.last_heard.is_none_or(|heard| now.saturating_sub(heard) > silence);
            if silent && !*warned {
                tracing::warn!(vehicle = vehicle + 1, "no telemetry for {} s", silence.as_secs_f64());
            }
            *warned = silent;
        }
    }

    /// Takes over where all vehicles are at this moment.
    fn see(&mut self) {
        let (now, silence) = (self.ground.now(), self.ground.settings().silence());
        for (state, craft) in self.states.iter_mut().zip(self.ground.fleet().vehicles()) {
            if let Some(position) = craft.position {
                *state = carry_forward(&position, now.saturating_sub(position.heard).min(silence), self.speed);
            }
        }
    }
}

impl World for RealTime {
    fn transport(&self) -> &'static str {
        "real-time"
    }

    async fn prepare(&mut self) -> Result<(), FlightError> {
        let ready = self.ground.make_ready(MUSTER_PATIENCE, unix_us()).await;
        self.started = Instant::now();
        self.ground_truth.start();
        self.see();
        ready
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn states(&self) -> &[State] {
        &self.states
    }

    async fn send(&mut self, decisions: &[Decision]) -> Result<(), FlightError> {
        let heartbeat = self.sent.is_multiple_of(self.ticks_per_heartbeat).then(ground_heartbeat);
        self.sent += 1;
        for (vehicle, decision) in decisions.iter().enumerate() {
            let mut messages = Vec::from_iter(heartbeat.clone());
            messages.extend(self.setpoint(vehicle, &decision.setpoint));
            self.ground.send(vehicle, &messages, unix_us()).await;
        }
        Ok(())
    }

    async fn advance(&mut self, until: Duration) -> Result<(), FlightError> {
        self.listen_until(self.started + until.div_f64(self.speed)).await?;
        self.watch_silence();
        let from = std::mem::replace(&mut self.now, until);
        self.see();
        self.ground_truth.advance(from, until, &self.states);
        Ok(())
    }

    fn ground_truth(&mut self) -> Interval<'_> {
        self.ground_truth.interval()
    }

    fn close(self) -> (serde_json::Value, Option<Log>) {
        self.ground.close()
    }
}

/// A position that was heard `age` ago, moved on at its velocity.
fn carry_forward(position: &Position, age: Duration, speed: f64) -> State {
    let age_s = age.as_secs_f64() * speed;
    let state = position.state;
    let position_m = state.position_m() + state.velocity_mps() * age_s;
    State { x_m: position_m.x, y_m: position_m.y, altitude_m: state.altitude_m + state.climb_mps * age_s, ..state }
}
