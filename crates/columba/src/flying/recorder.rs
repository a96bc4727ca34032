//! What is kept of a flight while it flies, and the summary when it is over.

use super::{Closed, FlightError, Interval};
use crate::config::Scenario;
use crate::flight::{Field, Flight, Obstacle, Row, Setting, Summary, Tick, Trajectory, vehicle_number};
use crate::judge::{COLLISION_DISTANCE_M, Judge, Minima, Verdict};
use controller::Decision;
use flight_model::{Setpoint, State};
use std::time::{Duration, Instant};

/// How a flight came to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The scenario is flown.
    Completed,
    /// Someone stopped it.
    Interrupted,
    /// It could not go on, for this reason.
    Failed(String),
}

impl From<Result<(), FlightError>> for Ended {
    fn from(flown: Result<(), FlightError>) -> Self {
        match flown {
            Ok(()) => Self::Completed,
            Err(FlightError::Interrupted) => Self::Interrupted,
            Err(error) => Self::Failed(error.to_string()),
        }
    }
}

/// Keeps every tick of a flight.
pub struct Recorder {
    judge: Judge,
    trajectory: Trajectory,
    solves: Vec<Duration>,
    started: Instant,
    minima: Minima,
}

impl Recorder {
    /// Starts the wall clock of the flight.
    pub fn new(scenario: &Scenario, starts: &[State]) -> Self {
        let judge = Judge::new(
            starts,
            &scenario.obstacles,
            scenario.expected,
            scenario.controller.law.safe_distance_m,
            scenario.dynamics.limits.speed_max_mps,
        );
        Self {
            judge,
            trajectory: Trajectory::new(starts.len()),
            solves: Vec::new(),
            started: Instant::now(),
            minima: Minima { separation_m: f64::INFINITY, clearance_m: f64::INFINITY },
        }
    }

    /// A tick: what the controller saw and decided at a flight time.
    pub fn tick(&mut self, at: Duration, states: &[State], decisions: &[Decision]) {
        let solve_us =
            decisions.iter().map(|d| d.solve.as_secs_f64() * 1e6).sum::<f64>() / decisions.len().max(1) as f64;
        self.solves.extend(decisions.iter().map(|decision| decision.solve));
        let rows = states.iter().zip(decisions).map(|(state, decision)| Row {
            state: *state,
            setpoint: decision.setpoint,
            alpha: decision.weights,
        });
        let Minima { separation_m, clearance_m } = self.minima;
        self.trajectory.push(
            Tick { t_s: at.as_secs_f64(), min_separation_m: separation_m, min_clearance_m: clearance_m, solve_us },
            rows,
        );
    }

    /// The end of a flight: where it left the vehicles, which have no further setpoint.
    pub fn last(&mut self, at: Duration, states: &[State]) {
        let decisions: Vec<Decision> = match self.trajectory.rows.len().checked_sub(states.len()) {
            Some(from) => self.trajectory.rows[from..]
                .iter()
                .map(|row| Decision { setpoint: row.setpoint, weights: row.alpha, ..Decision::default() })
                .collect(),
            None => states.iter().map(|state| Decision { setpoint: state.hold(), ..Decision::default() }).collect(),
        };
        let solves = self.solves.len();
        self.tick(at, states, &decisions);
        self.solves.truncate(solves);
    }

    /// How the vehicles flew since the last tick; gives the least distances of that interval.
    pub fn judge(&mut self, interval: Interval<'_>) -> Minima {
        let Interval { start, step, tracks } = interval;
        self.minima = self.judge.interval(start.as_secs_f64(), step.as_secs_f64(), tracks);
        self.minima
    }

    /// What the flight has come to so far.
    pub fn verdict(&self) -> Verdict {
        self.judge.verdict()
    }

    /// The flight as it is to be written.
    pub fn finish(mut self, scenario: &Scenario, transport: &str, ended: Ended, closed: Closed) -> Flight {
        let wall_s = self.started.elapsed().as_secs_f64();
        let duration_s = self.trajectory.ticks.last().map_or(0.0, |tick| tick.t_s);
        let verdict = self.judge.verdict();
        self.solves.sort_unstable();
        let collisions = verdict.obstacle_collisions + verdict.vehicle_collisions;
        let failure = match &ended {
            Ended::Failed(reason) => Some(reason.clone()),
            Ended::Interrupted if verdict.failure.is_none() => Some(format!("interrupted at {duration_s:.1} s")),
            _ => verdict.failure.clone(),
        };
        let summary = Summary {
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            algorithm: scenario.optimizer.algorithm.key().to_owned(),
            preset: name_of(&scenario.preset),
            transport: transport.to_owned(),
            vehicles: self.trajectory.vehicles,
            obstacles: scenario.obstacles.len(),
            duration_s,
            control_period_s: scenario.control_period.as_secs_f64(),
            completed: ended == Ended::Completed,
            interrupted: ended == Ended::Interrupted,
            success: ended == Ended::Completed && collisions == 0,
            failure,
            obstacle_collisions: verdict.obstacle_collisions,
            vehicle_collisions: verdict.vehicle_collisions,
            separation_losses: verdict.separation_losses,
            min_clearance_m: verdict.clearance.map(|least| least.value_m),
            min_clearance_at_s: verdict.clearance.map(|least| least.at_s),
            min_clearance_vehicle: verdict.clearance.map(|least| vehicle_number(least.whose)),
            min_separation_m: verdict.separation.map(|least| least.value_m),
            min_separation_at_s: verdict.separation.map(|least| least.at_s),
            min_separation_vehicles: verdict.separation.map(|least| least.whose.map(vehicle_number)),
            passed_last_obstacle: verdict.passed_last_obstacle,
            speed_convergence_s: verdict.speed_convergence_s,
            course_convergence_s: verdict.course_convergence_s,
            altitude_settling_s: verdict.altitude_settling_s,
            speed_variation_mps: verdict.smoothness.speed_variation_mps(),
            course_variation_rad: verdict.smoothness.course_variation_rad(),
            flock_radius_m: verdict.smoothness.radius_m(),
            flock_radius_end_m: verdict.smoothness.radius_end_m(),
            solve_us_p50: self.percentile_us(0.50),
            solve_us_p99: self.percentile_us(0.99),
            wall_s,
            real_time_factor: if wall_s > 0.0 { duration_s / wall_s } else { 0.0 },
            link: closed.counters,
            present: closed.present,
            station: serde_json::Value::Null,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let dynamics = scenario.flock_settings().dynamics;
        Flight { summary, field: field(scenario), settings: settings(scenario), trajectory: self.trajectory, dynamics }
    }

    /// By nearest rank, of the sorted solves.
    fn percentile_us(&self, share: f64) -> f64 {
        let rank = (share * self.solves.len() as f64).ceil() as usize;
        self.solves.get(rank.saturating_sub(1)).map_or(f64::NAN, |solve| solve.as_secs_f64() * 1e6)
    }
}

/// The field of a scenario.
pub fn field(scenario: &Scenario) -> Field {
    Field {
        obstacles: scenario
            .obstacles
            .iter()
            .map(|circle| Obstacle { x_m: circle.x_m, y_m: circle.y_m, radius_m: circle.radius_m })
            .collect(),
        expected: Setpoint {
            speed_mps: scenario.expected.speed_mps,
            course_rad: scenario.expected.course_rad,
            altitude_m: scenario.expected.altitude_m,
        },
        safe_distance_m: scenario.controller.law.safe_distance_m,
        collision_distance_m: COLLISION_DISTANCE_M,
    }
}

/// The reading of the paper that flew, by the names of the scenario file.
pub fn settings(scenario: &Scenario) -> Vec<Setting> {
    let mut settings = vec![Setting { name: "preset".to_owned(), value: name_of(&scenario.preset) }];
    let algorithm = scenario.optimizer.algorithm.key();
    settings.push(Setting { name: "optimizer.algorithm".to_owned(), value: algorithm.to_owned() });
    if let Some(values) = serde_json::to_value(scenario.optimizer)
        .ok()
        .and_then(|mut table| table.get_mut(algorithm).map(serde_json::Value::take))
    {
        add(&mut settings, &format!("optimizer.{algorithm}"), &values);
    }
    if let Ok(serde_json::Value::Object(tables)) = serde_json::to_value(&scenario.controller) {
        for (table, values) in tables {
            add(&mut settings, &table, &values);
        }
    }
    settings
}

/// Every key of a table of settings.
fn add(settings: &mut Vec<Setting>, table: &str, values: &serde_json::Value) {
    for (key, value) in values.as_object().into_iter().flatten() {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        settings.push(Setting { name: format!("{table}.{key}"), value });
    }
}

/// The name under which a scenario file speaks of an enum's value.
pub fn name_of(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}
