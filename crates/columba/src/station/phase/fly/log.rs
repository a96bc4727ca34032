//! What the flight of the flock comes to: separation and clearance, and every tick once all of it is heard.

use crate::flight::{Row, Tick, Trajectory};
use crate::judge::Verdict;
use crate::station::Station;
use crate::station::judge::{Ground, Seen, TrackJudge};
use crate::station::record::tick_line;
use flight_model::{Setpoint, State};
use std::collections::VecDeque;
use std::time::Duration;

/// What was decided for a vehicle: its setpoint and its weights.
pub type Choice = (Setpoint, [f64; 3]);

/// A tick whose states are not judged yet.
pub struct Decided {
    /// When, on the station's clock.
    pub at: Duration,
    /// What was decided for each vehicle of the crew; none for one that is no member.
    pub choices: Vec<Option<Choice>>,
    /// Mean time of a solve, microseconds.
    pub solve_us: f64,
}

/// The judge and the trajectory of a flight.
pub struct FlightLog {
    began: Duration,
    judge: TrackJudge,
    trajectory: Trajectory,
    pending: VecDeque<Decided>,
}

/// What the log holds when all is said.
pub struct Logged {
    /// Separation and clearance.
    pub verdict: Verdict,
    /// What these two rest on.
    pub grounds: [Ground; 2],
    /// How long each vehicle was not seen, s.
    pub unseen_s: Vec<f64>,
    /// Every tick.
    pub trajectory: Trajectory,
}

impl FlightLog {
    /// The log of a flight that begins.
    pub fn new(station: &Station, now: Duration) -> Self {
        let scenario = &station.scenario;
        let judge = TrackJudge::new(
            scenario.starts.len(),
            &scenario.obstacles,
            scenario.expected,
            scenario.controller.law.safe_distance_m,
            now.as_secs_f64(),
        );
        let trajectory = Trajectory::new(scenario.starts.len());
        Self { began: now, judge, trajectory, pending: VecDeque::new() }
    }

    /// Takes a tick; its states are judged once they are heard.
    pub fn push(&mut self, decided: Decided) {
        self.pending.push_back(decided);
    }

    /// The least separation and clearance since the last tick, m.
    pub fn recent_m(&self) -> [f64; 2] {
        self.judge.recent_m()
    }

    /// Separation and clearance until now.
    pub fn verdict(&self) -> Verdict {
        self.judge.verdict()
    }

    /// What was last decided for a vehicle of the crew.
    pub fn chosen(&self, index: usize) -> Option<Choice> {
        if let Some(decided) = self.pending.back() {
            return decided.choices.get(index).copied().flatten();
        }
        let last = self.trajectory.rows.len().checked_sub(self.trajectory.vehicles)?;
        let row = self.trajectory.rows.get(last + index)?;
        row.setpoint.is_finite().then_some((row.setpoint, row.alpha))
    }

    /// Judges what was heard, and records ticks whose states are known by now, or never will be.
    pub fn settle(&mut self, station: &mut Station, now: Duration, until_s: f64) {
        let seen: Vec<Seen<'_>> = station
            .crew()
            .map(|index| {
                let vehicle = &station.vehicles[index];
                Seen {
                    track: vehicle.track(),
                    clock_error_s: vehicle.clock().lateness_s().unwrap_or(0.0),
                    is_airborne: !vehicle.on_ground(),
                    is_member: vehicle.is_ours(),
                }
            })
            .collect();
        self.judge.judge(&seen, now.as_secs_f64(), until_s);
        while let Some(decided) = self.pending.pop_front_if(|decided| decided.at.as_secs_f64() <= self.judge.judged_s())
        {
            self.record(station, decided);
        }
    }

    /// The states at the end of the flight, which no setpoint follows.
    pub fn last(&mut self, station: &mut Station, at: Duration) {
        let choices = station.crew().map(|index| self.chosen(index)).collect();
        self.record(station, Decided { at, choices, solve_us: 0.0 });
    }

    /// What was flown at a tick: a state that was not heard is not a number.
    fn record(&mut self, station: &mut Station, decided: Decided) {
        const NONE: Setpoint = Setpoint { speed_mps: f64::NAN, course_rad: f64::NAN, altitude_m: f64::NAN };
        let t_s = decided.at.saturating_sub(self.began).as_secs_f64();
        let [min_separation_m, min_clearance_m] = self.judge.take_recent_m();
        let state = |index: usize| {
            let (state, _) = station.vehicles[..station.crew().end].get(index)?.track().at(decided.at.as_secs_f64())?;
            Some(state)
        };
        let rows: Vec<Row> = (0..self.trajectory.vehicles)
            .map(|index| {
                let choice = decided.choices.get(index).copied().flatten();
                let (setpoint, alpha) = choice.unwrap_or((NONE, [f64::NAN; 3]));
                Row { state: state(index).unwrap_or(UNKNOWN), setpoint, alpha }
            })
            .collect();
        station.write(tick_line(t_s, [min_separation_m, min_clearance_m], &rows));
        self.trajectory.push(Tick { t_s, min_separation_m, min_clearance_m, solve_us: decided.solve_us }, rows);
    }

    /// All of it.
    pub fn into_logged(self) -> Logged {
        Logged {
            verdict: self.judge.verdict(),
            grounds: self.judge.grounds(),
            unseen_s: self.judge.unseen_s().to_vec(),
            trajectory: self.trajectory,
        }
    }
}

/// A state that was not heard.
pub const UNKNOWN: State = State {
    x_m: f64::NAN,
    y_m: f64::NAN,
    altitude_m: f64::NAN,
    speed_mps: f64::NAN,
    course_rad: f64::NAN,
    climb_mps: f64::NAN,
};
