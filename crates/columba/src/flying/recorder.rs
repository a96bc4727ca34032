//! What is kept of a flight while it flies, and the summary when it is over.

use super::summary::{self, Solves, field, settings};
use super::{Closed, FlightError, Interval};
use crate::chatter::with_chatter;
use crate::config::Scenario;
use crate::flight::{Flight, Row, Summary, Tick, Trajectory};
use crate::judge::{Judge, Minima, Verdict};
use crate::prediction::with_prediction;
use controller::Decision;
use flight_model::{Dynamics, State};
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
    solves: Solves,
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
            solves: Solves::default(),
            started: Instant::now(),
            minima: Minima { separation_m: f64::INFINITY, clearance_m: f64::INFINITY },
        }
    }

    /// A tick: what the controller saw and decided at a flight time.
    pub fn tick(&mut self, at: Duration, states: &[State], decisions: &[Decision]) {
        decisions.iter().for_each(|decision| self.solves.push(decision.solve));
        self.keep(at, states, decisions);
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
        self.keep(at, states, &decisions);
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

    /// The flight as it is to be written; `dynamics` are those that the controller reckoned with.
    pub fn finish(
        mut self,
        scenario: &Scenario,
        transport: &str,
        dynamics: Vec<Dynamics>,
        ended: Ended,
        closed: Closed,
    ) -> Flight {
        let wall_s = self.started.elapsed().as_secs_f64();
        let duration_s = self.trajectory.ticks.last().map_or(0.0, |tick| tick.t_s);
        let verdict = self.judge.verdict();
        let collisions = verdict.obstacle_collisions + verdict.vehicle_collisions;
        let failure = match &ended {
            Ended::Failed(reason) => Some(reason.clone()),
            Ended::Interrupted if verdict.failure.is_none() => Some(format!("interrupted at {duration_s:.1} s")),
            _ => verdict.failure.clone(),
        };
        let summary = Summary {
            duration_s,
            completed: ended == Ended::Completed,
            interrupted: ended == Ended::Interrupted,
            success: ended == Ended::Completed && collisions == 0,
            failure,
            wall_s,
            real_time_factor: if wall_s > 0.0 { duration_s / wall_s } else { 0.0 },
            link: closed.counters,
            present: closed.present,
            solve_us_p50: self.solves.percentile_us(0.50),
            solve_us_p99: self.solves.percentile_us(0.99),
            ..summary::judged(&verdict, summary::planned(scenario, transport))
        };
        let (field, settings) = (field(scenario), settings(scenario));
        with_chatter(with_prediction(Flight { summary, field, settings, trajectory: self.trajectory, dynamics }))
    }

    fn keep(&mut self, at: Duration, states: &[State], decisions: &[Decision]) {
        let solve_us =
            decisions.iter().map(|d| d.solve.as_secs_f64() * 1e6).sum::<f64>() / decisions.len().max(1) as f64;
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
}
