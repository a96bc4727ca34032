//! A world over real MAVLink in real time: the wall clock, or k times it.
//!
//! Every control period the flock decides for the moment at which its commands act, from where each vehicle will be
//! then ([`Watch`]), and the setpoints go out; again within the period where the link loses some.

use super::setpoints::setpoint_messages;
use super::vehicles::unix_us;
use super::{Closed, FlightError, GroundStation, GroundTruth, Interval, Watch, World};
use crate::config::{Scenario, SetpointDialect};
use controller::Decision;
use flight_model::State;
use mavlink_bridge::telemetry::ground_heartbeat;
use std::time::Duration;
use tokio::time::Instant;

/// Vehicles whose position stays unknown for this long before the flight are given up.
const MUSTER_PATIENCE: Duration = Duration::from_secs(15);
/// The delays of links are asked for this often before the flight, with so many looks in between for the answers: one
/// that is lost so often is not waited for.
const DELAY_TRIES: u32 = 8;
const LOOKS: u32 = 6;
const LOOK: Duration = Duration::from_millis(50);

/// Vehicles that keep their own time, behind a link.
pub struct RealTime {
    ground: GroundStation,
    ground_truth: GroundTruth,
    watch: Watch,
    /// Seconds of flight for each second of the wall clock.
    speed: f64,
    setpoints: SetpointDialect,
    /// Heartbeats are due once in so many control periods.
    ticks_per_heartbeat: u64,
    sent: u64,
    /// Flight time counts from here, on the wall clock and on that of the watch.
    started: Instant,
    zero: Duration,
    now: Duration,
    decisions: Vec<Decision>,
    /// Vehicles of which a warning of silence was given.
    silent: Vec<bool>,
    /// Whether a late decision was warned of.
    is_late: bool,
}

impl RealTime {
    /// The vehicles of a scenario as `ground` hears them; their time runs `speed` times as fast as the wall clock.
    pub fn new(scenario: &Scenario, ground: GroundStation, ground_truth: GroundTruth, speed: f64) -> Self {
        Self {
            ground,
            ground_truth,
            watch: Watch::new(scenario),
            speed,
            setpoints: scenario.link.setpoints,
            ticks_per_heartbeat: ((speed / scenario.control_period.as_secs_f64()).round() as u64).max(1),
            sent: 0,
            started: Instant::now(),
            zero: Duration::ZERO,
            now: Duration::ZERO,
            decisions: Vec::new(),
            silent: vec![false; scenario.starts.len()],
            is_late: false,
        }
    }

    /// The watch's clock: flight time that began with the ground station.
    fn watch_now(&self) -> Duration {
        self.ground.now().mul_f64(self.speed)
    }

    /// Takes what comes until a flight time.
    async fn listen_until(&mut self, until: Duration) -> Result<(), FlightError> {
        let until = self.started + until.div_f64(self.speed);
        let mut news = Vec::new();
        loop {
            tokio::select! {
                received = self.ground.recv(unix_us(), &mut news) => received?,
                () = tokio::time::sleep_until(until) => return Ok(()),
            }
            let now = self.watch_now();
            for (vehicle, message) in self.ground.heard() {
                self.watch.hear(*vehicle, message, now);
            }
        }
    }

    /// Asks vehicles that wait for the delays of their links, which the first decisions want to know.
    async fn measure_delays(&mut self) -> Result<(), FlightError> {
        let vehicles = self.ground.fleet().vehicles().len();
        for look in 0..DELAY_TRIES * LOOKS {
            let unknown: Vec<usize> = (0..vehicles).filter(|&vehicle| !self.watch.knows_delay(vehicle)).collect();
            if unknown.is_empty() {
                break;
            }
            if look.is_multiple_of(LOOKS) {
                for vehicle in unknown {
                    let request = Watch::time_request(self.watch_now());
                    self.ground.send(vehicle, &[request], unix_us()).await;
                }
            }
            self.started = Instant::now();
            self.listen_until(LOOK.mul_f64(self.speed)).await?;
        }
        Ok(())
    }

    /// Sends each vehicle its part of the last decisions.
    async fn command(&mut self) {
        let heartbeat = self.sent.is_multiple_of(self.ticks_per_heartbeat).then(ground_heartbeat);
        let decisions = std::mem::take(&mut self.decisions);
        for (vehicle, decision) in decisions.iter().enumerate() {
            let now = self.watch_now();
            let setpoint = self.watch.command(vehicle, decision, now);
            let mut messages = Vec::from_iter(heartbeat.clone());
            messages.push(Watch::time_request(now));
            let target = self.ground.target(vehicle);
            messages.extend(setpoint_messages(self.setpoints, vehicle, target, &setpoint, self.now));
            self.ground.send(vehicle, &messages, unix_us()).await;
        }
        self.decisions = decisions;
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

    fn look(&mut self) {
        let [came, lost] = self.ground.frames();
        self.watch.note_frames(came, lost);
        self.watch.look(self.watch_now());
    }
}

impl World for RealTime {
    fn transport(&self) -> &'static str {
        "real-time"
    }

    async fn prepare(&mut self) -> Result<(), FlightError> {
        let ready = self.ground.make_ready(MUSTER_PATIENCE, unix_us()).await;
        // Vehicles that are observed wait for the flight to begin.
        let they_wait = ready.is_ok() && self.ground_truth.is_observed();
        if they_wait {
            self.measure_delays().await?;
        }
        self.started = Instant::now();
        self.zero = self.watch_now();
        self.ground_truth.start();
        for (vehicle, craft) in self.ground.fleet().vehicles().iter().enumerate() {
            if let Some(position) = craft.position {
                self.watch.hear_position(vehicle, &position, position.heard.mul_f64(self.speed));
                if they_wait {
                    self.watch.begin(vehicle, &position.state, self.zero);
                }
            }
        }
        self.look();
        ready
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

    async fn send(&mut self, decisions: &[Decision]) -> Result<(), FlightError> {
        self.decisions.clear();
        self.decisions.extend_from_slice(decisions);
        if let Some(late_s) = self.watch.decided(self.zero + self.now, self.watch_now())
            && !self.is_late
        {
            let t_s = self.now.as_secs_f64();
            tracing::warn!(t_s, late_s, "a decision came late: the machine cannot keep up");
            self.is_late = true;
        }
        self.command().await;
        self.sent += 1;
        Ok(())
    }

    async fn advance(&mut self, until: Duration) -> Result<(), FlightError> {
        for again in self.watch.sends_again(until.saturating_sub(self.now)) {
            self.listen_until(self.now + again).await?;
            self.command().await;
        }
        self.listen_until(until).await?;
        self.watch_silence();
        let from = std::mem::replace(&mut self.now, until);
        self.look();
        self.ground_truth.advance(from, until, self.watch.states());
        let Interval { start, step, tracks } = self.ground_truth.interval();
        if self.ground_truth.is_observed() {
            self.watch.compare(self.zero + start, step, tracks);
        }
        Ok(())
    }

    fn ground_truth(&mut self) -> Interval<'_> {
        self.ground_truth.interval()
    }

    fn close(self) -> Closed {
        Closed { present: self.watch.figures(), ..self.ground.close() }
    }
}
