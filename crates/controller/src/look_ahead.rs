//! The predicted flight of one vehicle for several choices of weights at once (reading 11).
//!
//! From the present state the flocking law is applied again at every control period, the vehicle flying the exact
//! discretisation of Eq. 1, while the neighbours follow their forecast. On the way the flight collects the costs of
//! Eq. 11 and 12, averaged over the horizon, and how much it violates the two constraints. With a horizon of one control
//! period this is the letter of the paper.
//!
//! What does not depend on the weights is in [`Scene`], computed once per solve.

use crate::command::Commander;
use crate::forecast::Passage;
use crate::lanes::Lanes;
use crate::{Expected, LawSettings, LookAheadSettings, Obstacle, ObstacleRule};
use flight_model::{Dynamics, State};

/// The law and the vehicle, discretised at the control period.
#[derive(Clone, Debug)]
pub struct LookAhead {
    law: LawSettings,
    commander: Commander,
    separation_m: f64,
    clearance_m: f64,
    steps: usize,
    control_period_s: f64,
    /// exp(-h / tau_V), and 1 - exp(-h / tau_phi), over half a control period and a whole one.
    speed_decay: [f64; 2],
    course_gain: [f64; 2],
}

/// What one vehicle sees of the world for one solve.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The vehicle now.
    pub state: State,
    /// What the flock is to do.
    pub expected: Expected,
    /// The obstacles that can matter within the horizon.
    pub obstacles: &'a [Obstacle],
    /// Whether any obstacle is detected now: which case of Eq. 11 holds.
    pub detected: bool,
    /// The neighbours' forecast, neighbour-major: `1 + 2 * steps` passages each, half a control period apart.
    pub neighbours: &'a [Passage],
}

/// alpha_f, alpha_o and alpha_nv of each lane.
pub type Weights = [Lanes; 3];

/// What a predicted flight cost.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Eq. 11.
    pub cost_1: Lanes,
    /// Eq. 12.
    pub cost_2: Lanes,
    /// Sum of the metres by which separation and clearance fall short, at every half control period.
    pub violation_m: Lanes,
}

/// A vehicle of each lane in flight.
#[derive(Clone, Copy)]
struct Flight {
    x: Lanes,
    y: Lanes,
    speed: Lanes,
    cos: Lanes,
    sin: Lanes,
}

/// What the neighbours ask of a vehicle at one instant.
struct Neighbourhood {
    formation: [Lanes; 2],
    collision: [Lanes; 2],
    velocity: [Lanes; 2],
    cost_2: Lanes,
}

impl LookAhead {
    pub fn new(
        law: &LawSettings,
        look_ahead: &LookAheadSettings,
        dynamics: &Dynamics,
        control_period_s: f64,
    ) -> Self {
        let tau = dynamics.time_constants;
        let decays = |tau_s: f64| [0.5, 1.0].map(|part| libm::exp(-part * control_period_s / tau_s));
        Self {
            law: law.clone(),
            commander: Commander::new(law, dynamics, control_period_s),
            separation_m: look_ahead.separation_m,
            clearance_m: look_ahead.clearance_m,
            steps: look_ahead.steps(control_period_s),
            control_period_s,
            speed_decay: decays(tau.speed_s),
            course_gain: decays(tau.course_s).map(|decay| 1.0 - decay),
        }
    }

    /// Flies every lane's weights through the scene.
    #[inline(always)]
    pub fn fly(&self, scene: &Scene<'_>, weights: &Weights) -> Outcome {
        let (sin, cos) = libm::sincos(scene.state.course_rad);
        let mut flight = Flight {
            x: Lanes::splat(scene.state.x_m),
            y: Lanes::splat(scene.state.y_m),
            speed: Lanes::splat(scene.state.speed_mps),
            cos: Lanes::splat(cos),
            sin: Lanes::splat(sin),
        };
        let (ahead_x, ahead_y) = scene.expected.direction();
        let (expected_vx, expected_vy) = (ahead_x * scene.expected.speed_mps, ahead_y * scene.expected.speed_mps);
        let mut outcome = Outcome { cost_1: Lanes::ZERO, cost_2: Lanes::ZERO, violation_m: Lanes::ZERO };

        let mut here = self.neighbourhood(scene, &flight, 0, &mut outcome.violation_m);
        outcome.violation_m = Lanes::ZERO; // what is so already cannot be chosen
        for step in 0..self.steps {
            let demand = self.demand(scene, &flight, &here, weights);
            let middle;
            (middle, flight) = self.advance(&flight, demand);
            self.keep_clear(scene, &middle, 2 * step + 1, &mut outcome.violation_m);
            self.keep_clear_of_obstacles(scene, &flight, &mut outcome.violation_m);
            here = self.neighbourhood(scene, &flight, 2 * step + 2, &mut outcome.violation_m);

            outcome.cost_2 += here.cost_2;
            outcome.cost_1 += if scene.detected {
                -(flight.x * ahead_x + flight.y * ahead_y)
            } else {
                (flight.speed * flight.cos - expected_vx).abs() + (flight.speed * flight.sin - expected_vy).abs()
            };
        }
        let mean = 1.0 / self.steps as f64;
        outcome.cost_1 = outcome.cost_1 * mean;
        outcome.cost_2 = outcome.cost_2 * mean;
        outcome
    }

    /// Eq. 4, horizontal: the weighted sum of the terms.
    #[inline(always)]
    fn demand(&self, scene: &Scene<'_>, flight: &Flight, here: &Neighbourhood, weights: &Weights) -> [Lanes; 2] {
        let [towards_x, towards_y] = self.steer(scene, flight);
        let speed = scene.expected.speed_mps;
        let obstacle = [
            (towards_x * speed - flight.speed * flight.cos) * self.law.obstacle_gain,
            (towards_y * speed - flight.speed * flight.sin) * self.law.obstacle_gain,
        ];
        let [formation, avoidance, velocity] = *weights;
        [0, 1].map(|k| {
            formation * here.formation[k] + here.collision[k] + avoidance * obstacle[k] + velocity * here.velocity[k]
        })
    }

    /// Eq. 5, 6, 8 and 12 at one instant of the forecast, and the separation constraint.
    #[inline(always)]
    fn neighbourhood(&self, scene: &Scene<'_>, flight: &Flight, instant: usize, violation: &mut Lanes) -> Neighbourhood {
        let law = &self.law;
        let (vx, vy) = (flight.speed * flight.cos, flight.speed * flight.sin);
        let communication = Lanes::splat(law.communication_distance_m);
        let safe = Lanes::splat(law.safe_distance_m);
        let per_desired_squared = 1.0 / (law.desired_distance_m * law.desired_distance_m);
        let both_signs = law.communication_distance_m > law.desired_distance_m;
        let zero = Lanes::ZERO;
        let mut sum = Neighbourhood { formation: [zero; 2], collision: [zero; 2], velocity: [zero; 2], cost_2: zero };
        for neighbour in scene.neighbours.chunks_exact(1 + 2 * self.steps) {
            let there = &neighbour[instant];
            let dx = -(flight.x - there.x_m);
            let dy = -(flight.y - there.y_m);
            // Two vehicles in one place have no direction to part in: the floor keeps every quotient finite.
            let squared = (dx * dx + dy * dy).max(Lanes::splat(1e-12));
            let distance = squared.sqrt();
            *violation += (Lanes::splat(self.separation_m) - distance).max(zero);

            let near = |value: Lanes| communication.select_less(distance, zero, value);
            let pull = near((squared * per_desired_squared).ln() * 0.5);
            sum.formation[0] += dx * pull;
            sum.formation[1] += dy * pull;

            let inverse = Lanes::splat(1.0) / distance;
            let closeness = inverse - 1.0 / law.safe_distance_m;
            let push = safe.select_less(distance, zero, closeness * closeness * inverse);
            sum.collision[0] += -(dx * push);
            sum.collision[1] += -(dy * push);

            let (dvx, dvy) = (-(vx - there.vx_mps), -(vy - there.vy_mps));
            sum.velocity[0] += near(dvx);
            sum.velocity[1] += near(dvy);

            let gap = -(distance - law.desired_distance_m);
            let gap = if both_signs { gap.abs() } else { gap };
            sum.cost_2 += near(gap + dvx.abs() + dvy.abs());
        }
        sum.formation = sum.formation.map(|axis| axis * law.formation_gain);
        sum.collision = sum.collision.map(|axis| axis * law.collision_gain);
        sum.velocity = sum.velocity.map(|axis| axis * law.neighbour_velocity_gain);
        sum.cost_2 = sum.cost_2 * law.influence_factor;
        sum
    }

    /// The unit vector along delta of Eq. 7: `steering::direction`, lane by lane.
    #[inline(always)]
    fn steer(&self, scene: &Scene<'_>, flight: &Flight) -> [Lanes; 2] {
        let law = &self.law;
        let (ahead_x, ahead_y) = scene.expected.direction();
        let none = Lanes::splat(f64::INFINITY);
        let zero = Lanes::ZERO;
        // The steering obstacle: its clearance, the offset to its centre and its inflated radius.
        let (mut least, mut to_x, mut to_y, mut inflated) = (none, zero, zero, zero);
        for obstacle in scene.obstacles {
            let radius = Lanes::splat(obstacle.radius_m);
            let (dx, dy) = (-(flight.x - obstacle.x_m), -(flight.y - obstacle.y_m));
            let clearance = (dx * dx + dy * dy).sqrt() - radius;
            // Each condition in turn throws the obstacle out by making it infinitely far.
            let mut rank = Lanes::splat(law.perception_distance_m).select_less(clearance, none, clearance);
            rank = (-radius).select_less(dx * flight.cos + dy * flight.sin, rank, none);
            if law.obstacle_rule == ObstacleRule::Blocking {
                rank = zero.select_less(dx * ahead_x + dy * ahead_y, rank, none);
                let across = (dy * ahead_x - dx * ahead_y).abs();
                rank = across.select_less(radius + law.obstacle_margin_m, rank, none);
            }
            to_x = rank.select_less(least, dx, to_x);
            to_y = rank.select_less(least, dy, to_y);
            inflated = rank.select_less(least, radius + law.obstacle_margin_m, inflated);
            least = rank.select_less(least, rank, least);
        }
        let [tangent_x, tangent_y] = self.tangent(flight, to_x, to_y, inflated);
        [
            least.select_less(none, tangent_x, Lanes::splat(ahead_x)),
            least.select_less(none, tangent_y, Lanes::splat(ahead_y)),
        ]
    }

    #[inline(always)]
    fn tangent(&self, flight: &Flight, to_x: Lanes, to_y: Lanes, inflated: Lanes) -> [Lanes; 2] {
        let one = Lanes::splat(1.0);
        let distance = (to_x * to_x + to_y * to_y).sqrt().max(Lanes::splat(f64::MIN_POSITIVE));
        let (to_x, to_y) = (to_x / distance, to_y / distance);
        let sin = inflated / distance;
        let cos = (one - (sin * sin).min(one)).sqrt();
        let outward = ((inflated - distance) / self.law.obstacle_margin_m.max(1e-3)).min(one);
        let inside_sin = one / (one + outward * outward).sqrt();
        let (sin, cos) =
            (one.select_less(sin, inside_sin, sin), one.select_less(sin, -(outward * inside_sin), cos));
        let (right_x, right_y) = (to_x * cos - to_y * sin, to_y * cos + to_x * sin);
        let (left_x, left_y) = (to_x * cos + to_y * sin, to_y * cos - to_x * sin);
        let right = right_x * flight.cos + right_y * flight.sin;
        let left = left_x * flight.cos + left_y * flight.sin;
        [right.select_less(left, left_x, right_x), right.select_less(left, left_y, right_y)]
    }

    /// Eq. 2 and one control period of Eq. 1: the vehicle half-way and at the end.
    #[inline(always)]
    fn advance(&self, flight: &Flight, demand: [Lanes; 2]) -> (Flight, Flight) {
        let commander = &self.commander;
        let along = demand[0] * flight.cos + demand[1] * flight.sin;
        let across = demand[1] * flight.cos - demand[0] * flight.sin;
        let (slowest, fastest) = (Lanes::splat(commander.speed_min_mps), Lanes::splat(commander.speed_max_mps));
        let turning_speed = flight.speed.max(slowest);
        let bound = (Lanes::splat(commander.course_change_speed_max) / turning_speed)
            .min(Lanes::splat(commander.course_change_max_rad));
        let speed_setpoint = (flight.speed + along * commander.speed_time_constant_s).clamp(slowest, fastest);
        let change = (across * commander.speed_time_constant_s / turning_speed).clamp(-bound, bound);

        let at = |instant: usize| {
            let (sin, cos) = (change * self.course_gain[instant]).sincos();
            let speed = speed_setpoint + (flight.speed - speed_setpoint) * self.speed_decay[instant];
            (speed, flight.cos * cos - flight.sin * sin, flight.sin * cos + flight.cos * sin)
        };
        let (speed_1, cos_1, sin_1) = at(0);
        let (speed_2, cos_2, sin_2) = at(1);
        let (vx_0, vy_0) = (flight.speed * flight.cos, flight.speed * flight.sin);
        let (vx_1, vy_1) = (speed_1 * cos_1, speed_1 * sin_1);
        // Simpson's rule over the period; up to its middle the trapezium is enough for the constraint's sample.
        let (sixth_s, quarter_s) = (self.control_period_s / 6.0, self.control_period_s / 4.0);
        let middle = Flight {
            x: flight.x + (vx_0 + vx_1) * quarter_s,
            y: flight.y + (vy_0 + vy_1) * quarter_s,
            speed: speed_1,
            cos: cos_1,
            sin: sin_1,
        };
        let end = Flight {
            x: flight.x + (vx_0 + vx_1 * 4.0 + speed_2 * cos_2) * sixth_s,
            y: flight.y + (vy_0 + vy_1 * 4.0 + speed_2 * sin_2) * sixth_s,
            speed: speed_2,
            cos: cos_2,
            sin: sin_2,
        };
        (middle, end)
    }

    /// Both constraints at one instant.
    #[inline(always)]
    fn keep_clear(&self, scene: &Scene<'_>, flight: &Flight, instant: usize, violation: &mut Lanes) {
        for neighbour in scene.neighbours.chunks_exact(1 + 2 * self.steps) {
            let (dx, dy) = (flight.x - neighbour[instant].x_m, flight.y - neighbour[instant].y_m);
            *violation += (Lanes::splat(self.separation_m) - (dx * dx + dy * dy).sqrt()).max(Lanes::ZERO);
        }
        self.keep_clear_of_obstacles(scene, flight, violation);
    }

    #[inline(always)]
    fn keep_clear_of_obstacles(&self, scene: &Scene<'_>, flight: &Flight, violation: &mut Lanes) {
        for obstacle in scene.obstacles {
            let (dx, dy) = (flight.x - obstacle.x_m, flight.y - obstacle.y_m);
            let wanted = Lanes::splat(obstacle.radius_m + self.clearance_m);
            *violation += (wanted - (dx * dx + dy * dy).sqrt()).max(Lanes::ZERO);
        }
    }
}
