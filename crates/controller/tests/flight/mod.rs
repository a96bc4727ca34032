//! Random fields, and flying a flock over them without a wire.

// Not every test that includes this needs all of it.
#![allow(dead_code)]
// clippy takes only functions marked as tests for tests; these are their helpers.
#![allow(clippy::expect_used)]

use controller::{Decision, Expected, Flock, FlockSettings, Obstacle};
use flight_model::{Autopilot, State};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::time::Duration;

/// The least gap between circles, m.
const GAP_M: f64 = 14.0;

/// 7 to 14 circles of 4 to 14 m, and vehicles at random before them, at least 5 m apart and up to 45 degrees off
/// course.
pub fn field(seed: u64, vehicles: usize) -> (FlockSettings, Vec<State>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = rng.random_range(7..=14);
    let mut obstacles: Vec<Obstacle> = Vec::new();
    while obstacles.len() < count {
        let radius_m = rng.random_range(4.0..14.0);
        let circle =
            Obstacle { x_m: rng.random_range(45.0 + radius_m..330.0), y_m: rng.random_range(-50.0..50.0), radius_m };
        if obstacles.iter().all(|other| other.clearance_m(circle.centre_m()) - radius_m >= GAP_M) {
            obstacles.push(circle);
        }
    }
    let half_width_m = 2.5 * vehicles as f64;
    let mut starts: Vec<State> = Vec::new();
    while starts.len() < vehicles {
        let start = State {
            x_m: rng.random_range(-20.0..15.0),
            y_m: rng.random_range(-half_width_m..half_width_m),
            altitude_m: rng.random_range(35.0..65.0),
            speed_mps: rng.random_range(5.0..15.0),
            course_rad: rng.random_range(-0.8..0.8),
            climb_mps: 0.0,
        };
        let apart = |other: &State| {
            let (dx, dy) = (other.x_m - start.x_m, other.y_m - start.y_m);
            dx * dx + dy * dy > 25.0
        };
        if starts.iter().all(apart) {
            starts.push(start);
        }
    }
    let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
    (FlockSettings { obstacles, seed, ..FlockSettings::new(expected) }, starts)
}

/// The integration step, s.
const STEP_S: f64 = 0.01;

/// How near a flight came to what it must not touch, what was decided on the way, and where it ended.
#[derive(Clone, Debug)]
pub struct Flown {
    pub min_separation_m: f64,
    pub min_clearance_m: f64,
    pub decisions: Vec<Vec<Decision>>,
    pub states: Vec<State>,
}

pub fn fly(settings: &FlockSettings, starts: &[State], ticks: u64) -> Flown {
    let mut flock = Flock::new(settings.clone(), starts.len()).expect("valid settings");
    let autopilot = Autopilot::new(&settings.dynamics_of(0), STEP_S);
    let steps = (settings.control_period_s / STEP_S).round() as usize;
    let mut flown = Flown {
        min_separation_m: f64::INFINITY,
        min_clearance_m: f64::INFINITY,
        decisions: Vec::new(),
        states: starts.to_vec(),
    };
    for tick in 0..ticks {
        let decisions = flock.tick(tick, &flown.states, &|| Duration::ZERO).to_vec();
        for _ in 0..steps {
            for (state, decision) in flown.states.iter_mut().zip(&decisions) {
                *state = autopilot.step(state, &decision.setpoint);
            }
            flown.judge(&settings.obstacles);
        }
        flown.decisions.push(decisions);
    }
    flown
}

impl Flown {
    fn judge(&mut self, obstacles: &[Obstacle]) {
        for (index, state) in self.states.iter().enumerate() {
            for other in &self.states[..index] {
                let separation_m = (other.position_m() - state.position_m()).norm();
                self.min_separation_m = self.min_separation_m.min(separation_m);
            }
            for obstacle in obstacles {
                self.min_clearance_m = self.min_clearance_m.min(obstacle.clearance_m(state.position_m()));
            }
        }
    }
}
