//! Flying a flock over a field, without a wire.

// clippy takes only functions marked as tests for tests; these are their helpers.
#![allow(clippy::expect_used)]

use controller::{Decision, Flock, FlockSettings, Obstacle};
use flight_model::{Autopilot, State};
use std::time::Duration;

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
    let autopilot = Autopilot::new(&settings.dynamics, STEP_S);
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
                let (dx, dy) = (other.x_m - state.x_m, other.y_m - state.y_m);
                self.min_separation_m = self.min_separation_m.min((dx * dx + dy * dy).sqrt());
            }
            for obstacle in obstacles {
                self.min_clearance_m = self.min_clearance_m.min(obstacle.clearance_m(state.x_m, state.y_m));
            }
        }
    }
}
