//! One vehicle's part of a tick: what it sees, the weights that MSLPIO picks for it, and the command that follows.

use crate::command::Commander;
use crate::flights::Flights;
use crate::flock::{Decision, FlockSettings};
use crate::forecast::{Forecast, Passage};
use crate::look_ahead::{LookAhead, Scene, WeightProblem};
use crate::neighbours::Neighbours;
use crate::terms::{self, Neighbour};
use crate::vector::Vec2;
use crate::{Expected, LawSettings, Obstacle, WeightKind, steering};
use flight_model::{Setpoint, State, wrap_pi};
use optimizer::{Bounds, Mslpio, Optimizer, SettingsError, selection::nearest_to_ideal, stream};
use std::time::Duration;

/// The flock around a vehicle at one tick.
pub struct Surroundings<'a> {
    pub settings: &'a FlockSettings,
    pub states: &'a [State],
    pub neighbours: &'a Neighbours,
    pub forecast: &'a Forecast,
}

/// One vehicle's optimiser and its buffers, kept from tick to tick so that a tick allocates nothing.
pub struct Pilot {
    look_ahead: LookAhead,
    commander: Commander,
    optimizer: Mslpio,
    bounds: Vec<Bounds>,
    last_weights: Option<[f64; 3]>,
    found: Vec<(f64, u32)>,
    neighbours: Vec<Neighbour>,
    passages: Vec<Passage>,
    obstacles: Vec<Obstacle>,
    close_obstacles: Vec<Obstacle>,
    flights: Box<Flights>,
}

impl Pilot {
    pub fn new(settings: &FlockSettings) -> Result<Self, SettingsError> {
        let FlockSettings { controller, dynamics, control_period_s, .. } = settings;
        let bounds = Bounds { lower: controller.weights.min, upper: controller.weights.max };
        let dimensions = match controller.weights.kind {
            WeightKind::Shared => 1,
            WeightKind::PerTerm => 3,
        };
        Ok(Self {
            look_ahead: LookAhead::new(&controller.law, &controller.look_ahead, dynamics, *control_period_s),
            commander: Commander::new(&controller.law, dynamics, *control_period_s),
            optimizer: Mslpio::new(settings.optimizer)?,
            bounds: vec![bounds; dimensions],
            last_weights: None,
            found: Vec::new(),
            neighbours: Vec::new(),
            passages: Vec::new(),
            obstacles: Vec::new(),
            close_obstacles: Vec::new(),
            flights: Box::new(Flights::new()),
        })
    }

    /// Algorithm 2, lines 4 to 6, for the vehicle of index `vehicle`.
    pub fn decide(
        &mut self,
        around: &Surroundings<'_>,
        vehicle: usize,
        tick: u64,
        clock: &(dyn Fn() -> Duration + Sync),
    ) -> Decision {
        let settings = around.settings;
        let state = around.states[vehicle];
        self.look_around(around, vehicle);
        let started = clock();
        let (weights, feasible) = self.pick_weights(settings, state, vehicle, tick);
        let solve = clock().saturating_sub(started);
        self.last_weights = Some(weights);
        Decision {
            setpoint: command(
                &settings.controller.law,
                &settings.expected,
                &self.commander,
                &state,
                &self.neighbours,
                &self.obstacles,
                weights,
            ),
            weights,
            feasible,
            solve,
        }
    }

    /// Fills the buffers with what the vehicle sees.
    fn look_around(&mut self, around: &Surroundings<'_>, vehicle: usize) {
        let settings = around.settings;
        let (law, look_ahead) = (&settings.controller.law, &settings.controller.look_ahead);
        let state = &around.states[vehicle];
        let horizon_s = look_ahead.steps(settings.control_period_s) as f64 * settings.control_period_s;
        let reach_m = horizon_s * settings.dynamics.limits.speed_max_mps;
        let range_m = law.communication_distance_m.max(look_ahead.separation_m) + reach_m;
        around.neighbours.nearest(around.states, vehicle, range_m, look_ahead.neighbours_max, &mut self.found);
        self.neighbours.clear();
        self.passages.clear();
        for &(_, index) in &self.found {
            let passages = around.forecast.vehicle(index as usize);
            self.neighbours.push(Neighbour::of(&around.states[index as usize]));
            self.passages.extend_from_slice(passages);
        }
        let within =
            |distance_m: f64| move |obstacle: &&Obstacle| obstacle.clearance_m(state.x_m, state.y_m) <= distance_m;
        self.obstacles.clear();
        self.obstacles.extend(settings.obstacles.iter().filter(within(law.perception_distance_m + reach_m)));
        self.close_obstacles.clear();
        self.close_obstacles.extend(self.obstacles.iter().filter(within(look_ahead.clearance_m + reach_m)));
    }

    /// The weights that the optimiser picks, and whether they keep the constraints.
    fn pick_weights(&mut self, settings: &FlockSettings, state: State, vehicle: usize, tick: u64) -> ([f64; 3], bool) {
        let law = &settings.controller.law;
        let position_m = Vec2::new(state.x_m, state.y_m);
        let heading = heading(&state);
        let mut problem = WeightProblem {
            look_ahead: &self.look_ahead,
            scene: Scene {
                state,
                expected: settings.expected,
                obstacles: &self.obstacles,
                close_obstacles: &self.close_obstacles,
                detected: self.obstacles.iter().any(|obstacle| steering::detects(law, position_m, heading, obstacle)),
                neighbours: &self.passages,
            },
            kind: settings.controller.weights.kind,
            bounds: &self.bounds,
            flights: &mut self.flights,
        };
        let mut rng = stream(settings.seed, vehicle as u64, tick);
        let per_term = problem.kind == WeightKind::PerTerm;
        if let Some(last) = &self.last_weights {
            self.optimizer.seed_candidates(if per_term { last } else { &last[..1] });
        }
        match self.optimizer.minimise(&mut problem, &mut rng) {
            Ok(front) => {
                let best = nearest_to_ideal(&front);
                let weights = [0, 1, 2].map(|term| front.position(best, if per_term { term } else { 0 }));
                (weights, front.violation()[best] <= 0.0)
            }
            // No finite prediction: only a state that is not finite gives that. The middle of the range harms least.
            Err(_) => ([0.5 * (self.bounds[0].lower + self.bounds[0].upper); 3], false),
        }
    }
}

/// Eq. 4 with given weights, then Eq. 2.
pub fn command(
    law: &LawSettings,
    expected: &Expected,
    commander: &Commander,
    state: &State,
    neighbours: &[Neighbour],
    obstacles: &[Obstacle],
    weights: [f64; 3],
) -> Setpoint {
    let position_m = Vec2::new(state.x_m, state.y_m);
    let heading = heading(state);
    let velocity_mps = heading * state.speed_mps;
    let towards = steering::direction(law, expected, position_m, heading, obstacles);
    let [alpha_f, alpha_o, alpha_nv] = weights;
    let demand_mps2 = terms::formation(law, position_m, neighbours) * alpha_f
        + terms::collision_avoidance(law, position_m, neighbours)
        + terms::obstacle_avoidance(law, expected.speed_mps, towards, velocity_mps) * alpha_o
        + terms::neighbour_velocity(law, position_m, velocity_mps, neighbours) * alpha_nv;
    let (speed_mps, course_change_rad) = commander.horizontal(demand_mps2, state.speed_mps, heading);
    Setpoint {
        speed_mps,
        course_rad: wrap_pi(state.course_rad + course_change_rad),
        altitude_m: commander.altitude_m(law, expected.altitude_m, state),
    }
}

pub fn heading(state: &State) -> Vec2 {
    let (sin, cos) = libm::sincos(state.course_rad);
    Vec2::new(cos, sin)
}
