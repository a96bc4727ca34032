//! Algorithm 2, lines 4 to 6: one vehicle's part of a tick: what it perceives, the weights that the optimiser chooses,
//! and the command that follows.

use crate::closest_approach::closest_approach_m;
use crate::command::{Commander, Standing};
use crate::evasion::{Asked, evade};
use crate::forecast::{Forecast, Passage};
use crate::insight::Insight;
use crate::law::{Flown, command};
use crate::look_ahead::{LookAhead, Scene, WeightProblem};
use crate::neighbours::Neighbours;
use crate::rollout::Rollout;
use crate::terms::Neighbour;
use crate::{Decision, FlockSettings, Obstacle, WeightKind, terms};
use flight_model::{Setpoint, State, Wind, course_vector, wrap_pi};
use optimizer::selection::nearest_to_ideal;
use optimizer::{Bounds, Optimizer, SettingsError, Stream, stream};
use std::time::Duration;

/// The flock around a vehicle at one tick.
pub struct Surroundings<'a> {
    pub settings: &'a FlockSettings,
    pub states: &'a [State],
    pub neighbours: &'a Neighbours,
    pub forecast: &'a Forecast,
    /// How far off each position may be, m; empty: not at all.
    pub margins_m: &'a [f64],
    /// The speeds to which Eq. 2 adds, m/s; empty: those of the states.
    pub reference_speeds_mps: &'a [f64],
    /// The winds around the vehicles; empty: calm.
    pub winds: &'a [Wind],
}

impl Surroundings<'_> {
    fn margin_m(&self, vehicle: usize) -> f64 {
        self.margins_m.get(vehicle).copied().unwrap_or(0.0)
    }

    fn wind(&self, vehicle: usize) -> Wind {
        self.winds.get(vehicle).copied().unwrap_or(Wind::CALM)
    }
}

/// One vehicle's optimiser and its buffers, kept from tick to tick so that a tick allocates nothing.
pub struct Pilot {
    look_ahead: LookAhead,
    commander: Commander,
    optimizer: Box<dyn Optimizer>,
    bounds: Vec<Bounds>,
    last_weights: Option<[f64; 3]>,
    /// Airspeed on which the last command settles, m/s, and its heading, rad: the next one does not jump far from it.
    last_command: Option<(f64, f64)>,
    sight: Sight,
    rollout: Box<Rollout>,
    /// Of the last tick, where that is asked for.
    insight: Option<Box<Insight>>,
}

/// What a vehicle perceives at one tick.
#[derive(Default)]
struct Sight {
    /// The nearest others: squared distance and index.
    found: Vec<(f64, u32)>,
    neighbours: Vec<Neighbour>,
    passages: Vec<Passage>,
    wind: Wind,
    margin_m: f64,
    neighbour_margins_m: Vec<f64>,
    obstacles: Vec<Obstacle>,
    close_obstacles: Vec<Obstacle>,
}

impl Pilot {
    pub fn new(settings: &FlockSettings, vehicle: usize) -> Result<Self, SettingsError> {
        let FlockSettings { controller, control_period_s, .. } = settings;
        let dynamics = settings.dynamics_of(vehicle);
        let bounds = Bounds { lower: controller.weights.min, upper: controller.weights.max };
        let dimensions = match controller.weights.kind {
            WeightKind::Shared => 1,
            WeightKind::PerTerm => 3,
        };
        Ok(Self {
            look_ahead: LookAhead::new(&controller.law, &controller.look_ahead, &dynamics, *control_period_s),
            commander: Commander::new(&controller.law, &dynamics, *control_period_s),
            optimizer: settings.optimizer.build()?,
            bounds: vec![bounds; dimensions],
            last_weights: None,
            last_command: None,
            sight: Sight::default(),
            rollout: Box::new(Rollout::new()),
            insight: None,
        })
    }

    /// Whether the next ticks are to be told of.
    pub fn watch(&mut self, is_watched: bool) {
        match is_watched {
            true => drop(self.insight.get_or_insert_default()),
            false => self.insight = None,
        }
    }

    /// What the optimiser had to choose from at the last tick, where that is asked for.
    pub fn insight(&self) -> Option<&Insight> {
        self.insight.as_deref()
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
        self.sight.look_around(around, vehicle);
        let (law, expected) = (&settings.controller.law, &settings.expected);
        let started = clock();
        let mut rng = stream(settings.seed, vehicle as u64, tick);
        let mut problem = WeightProblem {
            look_ahead: &self.look_ahead,
            scene: self.sight.scene(settings, state, self.last_command),
            kind: settings.controller.weights.kind,
            bounds: &self.bounds,
            rollout: &mut self.rollout,
        };
        let insight = self.insight.as_deref_mut();
        let choice = pick_weights(self.optimizer.as_mut(), &mut problem, self.last_weights, &mut rng, insight);
        let solve = clock().saturating_sub(started);
        self.last_weights = Some(choice.weights);
        let sight = &self.sight;
        if let Some(insight) = &mut self.insight {
            (insight.tick, insight.optimizer) = (tick, self.optimizer.name());
            insight.fly(&self.look_ahead, &sight.scene(settings, state, self.last_command), &mut self.rollout);
        }
        let speed_mps = around.reference_speeds_mps.get(vehicle).copied().unwrap_or(state.speed_mps);
        let own = State { speed_mps, ..state };
        let last_heading_rad = self.last_command.map(|(_, heading_rad)| heading_rad);
        let flown = Flown { commander: &self.commander, state: &own, wind: &sight.wind, last_heading_rad };
        let setpoint = command(law, expected, &flown, &sight.neighbours, &sight.obstacles, choice.weights);
        Decision { setpoint, weights: choice.weights, feasible: choice.violation_m <= 0.0, solve }
    }

    /// The decision is another one now; `forecast` is where it leads.
    pub fn evaded(&mut self, forecast: &[Passage]) {
        if let Some(insight) = &mut self.insight {
            insight.evade(forecast);
        }
    }

    /// The decision goes out: the next command does not jump far from it. Gives the heading that it asks for, rad.
    pub fn commit(&mut self, decision: &Decision) -> f64 {
        let in_air = self.commander.in_air(&decision.setpoint, &self.sight.wind);
        self.last_command = Some((self.commander.speed_mps(&in_air), in_air.course_rad));
        in_air.course_rad
    }

    /// Checks a decision again with the forecast of the commands that the other vehicles have been given; returns
    /// another decision if this one leads too near to something.
    pub fn reconsider(&mut self, around: &Surroundings<'_>, vehicle: usize, decision: Decision) -> Option<Decision> {
        let (settings, state) = (around.settings, *around.states.get(vehicle)?);
        let separation_m = settings.controller.look_ahead.separation_m;
        let own = around.forecast.vehicle(vehicle);
        let meets = |&(_, other): &(f64, u32)| {
            let theirs = around.forecast.vehicle(other as usize);
            let offset_m = |instant: usize| theirs[instant].position_m() - own[instant].position_m();
            let wanted_m = separation_m + (around.margin_m(vehicle) + around.margin_m(other as usize));
            (1..own.len()).any(|instant| closest_approach_m(offset_m(instant - 1), offset_m(instant)) < wanted_m)
        };
        if decision.feasible && !self.sight.found.iter().any(meets) {
            return None;
        }
        self.sight.foresee(around);
        let evasion = self.evade(settings, state, decision);
        (evasion != decision).then_some(evasion)
    }

    fn evade(&mut self, settings: &FlockSettings, state: State, decision: Decision) -> Decision {
        let (wind, air) = (self.sight.wind, state.in_air(&self.sight.wind));
        let asked = self.commander.in_air(&decision.setpoint, &wind);
        let by_law = (self.commander.speed_mps(&asked), wrap_pi(asked.course_rad - air.course_rad));
        let asked = Asked { by_law, side_m: settings.side_m };
        let scene = self.sight.scene(settings, state, self.last_command);
        let evasion = evade(&self.look_ahead, &self.commander, &scene, decision.weights, &asked, &mut self.rollout);
        if (evasion.speed_setpoint_mps, evasion.course_change_rad) == by_law {
            return Decision { feasible: evasion.violation_m <= 0.0, ..decision };
        }
        let course_rad = wrap_pi(air.course_rad + evasion.course_change_rad);
        let speed_mps = self.commander.asked_mps(evasion.speed_setpoint_mps);
        let setpoint = Setpoint { speed_mps, course_rad, ..decision.setpoint };
        let setpoint = self.commander.over_ground(&self.commander.forwards(&setpoint, &wind), &wind);
        Decision { setpoint, feasible: evasion.violation_m <= 0.0, ..decision }
    }
}

impl Sight {
    /// The input of the look-ahead.
    fn scene(&self, settings: &FlockSettings, state: State, last_command: Option<(f64, f64)>) -> Scene<'_> {
        let (law, position_m) = (&settings.controller.law, state.position_m());
        let heading_rad = state.in_air(&self.wind).course_rad;
        let heading = course_vector(heading_rad);
        Scene {
            state,
            wind: self.wind,
            standing: last_command
                .map(|(speed_mps, last_rad)| Standing { speed_mps, turn_rad: wrap_pi(last_rad - heading_rad) }),
            expected: settings.expected,
            obstacles: &self.obstacles,
            close_obstacles: &self.close_obstacles,
            detected: self.obstacles.iter().any(|obstacle| terms::detects(law, position_m, heading, obstacle)),
            neighbours: &self.passages,
            margin_m: self.margin_m,
            neighbour_margins_m: &self.neighbour_margins_m,
        }
    }

    /// Takes the neighbours' forecast.
    fn foresee(&mut self, around: &Surroundings<'_>) {
        self.passages.clear();
        for &(_, index) in &self.found {
            self.passages.extend_from_slice(around.forecast.vehicle(index as usize));
        }
    }

    /// Fills the buffers with the neighbours and obstacles around the vehicle.
    fn look_around(&mut self, around: &Surroundings<'_>, vehicle: usize) {
        let settings = around.settings;
        let (law, look_ahead) = (&settings.controller.law, &settings.controller.look_ahead);
        let state = &around.states[vehicle];
        let horizon_s = look_ahead.steps(settings.control_period_s) as f64 * settings.control_period_s;
        let reach_m = horizon_s * settings.speed_max_mps();
        let margins_m = 2.0 * around.margins_m.iter().copied().fold(0.0, f64::max);
        let range_m = law.communication_distance_m.max(look_ahead.separation_m + margins_m) + reach_m;
        around.neighbours.nearest(around.states, vehicle, range_m, look_ahead.neighbours_max, &mut self.found);
        self.neighbours.clear();
        self.neighbours.extend(self.found.iter().map(|&(_, index)| Neighbour::of(&around.states[index as usize])));
        self.foresee(around);
        self.wind = around.wind(vehicle);
        self.margin_m = around.margin_m(vehicle);
        self.neighbour_margins_m.clear();
        self.neighbour_margins_m.extend(self.found.iter().map(|&(_, index)| around.margin_m(index as usize)));
        let within =
            |distance_m: f64| move |obstacle: &&Obstacle| obstacle.clearance_m(state.position_m()) <= distance_m;
        self.obstacles.clear();
        self.obstacles.extend(settings.obstacles.iter().filter(within(law.perception_distance_m + reach_m)));
        self.close_obstacles.clear();
        self.close_obstacles
            .extend(self.obstacles.iter().filter(within(look_ahead.clearance_m + reach_m + self.margin_m)));
    }
}

/// Weights, and by how much the flight that they lead to falls short of the constraints.
struct Choice {
    weights: [f64; 3],
    violation_m: f64,
}

/// Algorithm 2, line 5: the member of the Pareto front that is nearest to the ideal (reading 12).
fn pick_weights(
    optimizer: &mut dyn Optimizer,
    problem: &mut WeightProblem<'_>,
    last: Option<[f64; 3]>,
    rng: &mut Stream,
    insight: Option<&mut Insight>,
) -> Choice {
    let dimensions = problem.bounds.len();
    let middle = 0.5 * (problem.bounds[0].lower + problem.bounds[0].upper);
    if let Some(last) = last {
        optimizer.seed_candidates(&last[..dimensions]);
    }
    match optimizer.minimise(problem, rng) {
        Ok(front) => {
            let best = nearest_to_ideal(&front);
            let weights = |member| [0, 1, 2].map(|term| front.position(member, if dimensions == 1 { 0 } else { term }));
            if let Some(insight) = insight {
                insight.take(&front, best, weights);
            }
            Choice { weights: weights(best), violation_m: front.violation()[best] }
        }
        // No finite prediction, which only a state that is not finite causes. The middle of the range is the safest
        // choice.
        Err(_) => {
            if let Some(insight) = insight {
                insight.clear();
            }
            Choice { weights: [middle; 3], violation_m: f64::INFINITY }
        }
    }
}
