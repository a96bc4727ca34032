//! The rollout of a generation: its pigeons fly the law (Eq. 4-8) and collect the costs (Eq. 11 and Eq. 12), one array
//! for each quantity, one plain loop for each part of the law.
//!
//! Every loop runs over the pigeons and does the same to each without a branch or a call, so the compiler vectorises
//! it. `terms/mod.rs` has the same law for one vehicle, as in the paper; `look_ahead/tests.rs` compares the two.

// One index runs over a dozen columns at once.
#![allow(clippy::needless_range_loop)]

use crate::command::{Commander, Standing};
use crate::forecast::Passage;
use crate::polynomial::{SINCOS_RANGE_RAD, ln, sincos};
use crate::terms::half_angle;
use crate::{Expected, LawSettings, Obstacle, ObstacleRule, SideRule};
use flight_model::{State, Wind};
use nalgebra::Vector2;

/// Pigeons that fly together; a larger generation flies in several batches.
pub const BATCH: usize = 64;

/// Batches are rounded up to this, the width of the widest vectors.
const VECTOR: usize = 8;

/// One number for each pigeon of a batch.
pub type Each = [f64; BATCH];

/// North and east of each pigeon, m.
pub type Places = (Each, Each);

/// The bounding box of all pigeons. Something far from the box is far from every pigeon, and is skipped for all of them
/// at once.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Extent {
    /// Whether a place is within a distance of the box.
    #[inline(always)]
    pub fn is_within(&self, x_m: f64, y_m: f64, distance_m: f64) -> bool {
        let dx = (self.low.x - x_m).max(x_m - self.high.x).max(0.0);
        let dy = (self.low.y - y_m).max(y_m - self.high.y).max(0.0);
        dx * dx + dy * dy <= distance_m * distance_m
    }
}

impl Extent {
    /// The box around this one and another.
    #[inline(always)]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            low: Vector2::new(self.low.x.min(other.low.x), self.low.y.min(other.low.y)),
            high: Vector2::new(self.high.x.max(other.high.x), self.high.y.max(other.high.y)),
        }
    }

    /// Whether something that goes from one place to another may come within a distance of the box.
    #[inline(always)]
    pub fn may_be_met(&self, from_m: Vector2<f64>, to_m: Vector2<f64>, distance_m: f64) -> bool {
        let (half_x, half_y) = (0.5 * (to_m.x - from_m.x), 0.5 * (to_m.y - from_m.y));
        let half_m = (half_x * half_x + half_y * half_y).sqrt();
        self.is_within(from_m.x + half_x, from_m.y + half_y, distance_m + half_m)
    }

    /// Whether a circle can reach into the corridor of this half width that runs from a place in the box along `ahead`.
    #[inline(always)]
    pub fn may_be_blocked(&self, x_m: f64, y_m: f64, half_width_m: f64, ahead: Vector2<f64>) -> bool {
        let (dx, dy) = (x_m - 0.5 * (self.low.x + self.high.x), y_m - 0.5 * (self.low.y + self.high.y));
        let (half_x, half_y) = (0.5 * (self.high.x - self.low.x), 0.5 * (self.high.y - self.low.y));
        let along_m = dx * ahead.x + dy * ahead.y + (half_x * ahead.x.abs() + half_y * ahead.y.abs());
        let across_m = (ahead.x * dy - ahead.y * dx).abs() - (half_x * ahead.y.abs() + half_y * ahead.x.abs());
        // A micrometre for the rounding of the box against that of the law.
        along_m > -1e-6 && across_m < half_width_m + 1e-6
    }
}

/// The vehicles of a batch, one for each pigeon, and what the law has summed up for them so far.
pub struct Rollout {
    /// Pigeons in the batch, rounded up to full vectors: the last ones are computed and never read.
    pub count: usize,
    x: Each,
    y: Each,
    /// Through the air, and the heading.
    speed: Each,
    cos: Each,
    sin: Each,
    /// Over ground.
    vx: Each,
    vy: Each,
    /// Where the last step began, and where it was half-way.
    start_x: Each,
    start_y: Each,
    middle_x: Each,
    middle_y: Each,
    formation_x: Each,
    formation_y: Each,
    collision_x: Each,
    collision_y: Each,
    velocity_x: Each,
    velocity_y: Each,
    /// Clearance and offset of the obstacle that steers, its inflated radius; clearance is infinite where none does.
    least: Each,
    to_x: Each,
    to_y: Each,
    inflated: Each,
    speed_setpoint: Each,
    course_change: Each,
    /// The turn that the last command still asks for.
    asked: Each,
    pub cost_1: Each,
    pub cost_2: Each,
    pub violation_m: Each,
}

impl Rollout {
    pub const fn new() -> Self {
        const ZERO: Each = [0.0; BATCH];
        Self {
            count: 0,
            x: ZERO,
            y: ZERO,
            speed: ZERO,
            cos: ZERO,
            sin: ZERO,
            vx: ZERO,
            vy: ZERO,
            start_x: ZERO,
            start_y: ZERO,
            middle_x: ZERO,
            middle_y: ZERO,
            formation_x: ZERO,
            formation_y: ZERO,
            collision_x: ZERO,
            collision_y: ZERO,
            velocity_x: ZERO,
            velocity_y: ZERO,
            least: ZERO,
            to_x: ZERO,
            to_y: ZERO,
            inflated: ZERO,
            speed_setpoint: ZERO,
            course_change: ZERO,
            asked: ZERO,
            cost_1: ZERO,
            cost_2: ZERO,
            violation_m: ZERO,
        }
    }

    /// Puts `pigeons` vehicles at `state` in a wind, with what the last command still asks for, and no cost and no
    /// violation yet.
    #[inline(always)]
    pub fn start(&mut self, state: &State, wind: &Wind, standing: Option<Standing>, pigeons: usize) {
        self.count = pigeons.next_multiple_of(VECTOR).min(BATCH);
        let air = state.in_air(wind);
        let (sin, cos) = libm::sincos(air.course_rad);
        let count = self.count;
        for (quantity, value) in [
            (&mut self.x, state.x_m),
            (&mut self.y, state.y_m),
            (&mut self.speed, air.speed_mps),
            (&mut self.cos, cos),
            (&mut self.sin, sin),
            (&mut self.vx, air.speed_mps * cos + wind.north_mps),
            (&mut self.vy, air.speed_mps * sin + wind.east_mps),
            (&mut self.asked, standing.map_or(0.0, |standing| standing.turn_rad)),
            (&mut self.speed_setpoint, standing.map_or(air.speed_mps, |standing| standing.speed_mps)),
            (&mut self.cost_1, 0.0),
            (&mut self.cost_2, 0.0),
            (&mut self.violation_m, 0.0),
        ] {
            quantity[..count].fill(value);
        }
    }

    /// Where the pigeons are.
    pub fn places(&self) -> Places {
        (self.x, self.y)
    }

    /// The box around all pigeons.
    #[inline(always)]
    pub fn extent(&self) -> Extent {
        extent(&self.x, &self.y, self.count)
    }

    /// The box around all pigeons half-way through the last step.
    #[inline(always)]
    pub fn extent_half_way(&self) -> Extent {
        extent(&self.middle_x, &self.middle_y, self.count)
    }

    /// Sets the sums of the last step to zero.
    #[inline(always)]
    pub fn clear_terms(&mut self) {
        let count = self.count.min(BATCH);
        for sum in [
            &mut self.formation_x,
            &mut self.formation_y,
            &mut self.collision_x,
            &mut self.collision_y,
            &mut self.velocity_x,
            &mut self.velocity_y,
            &mut self.to_x,
            &mut self.to_y,
            &mut self.inflated,
        ] {
            sum[..count].fill(0.0);
        }
        self.least[..count].fill(f64::INFINITY);
    }

    /// Adds one neighbour's share of Eq. 5, 6 and 8 (without their gains) and, where `judged`, of Eq. 12.
    #[inline(always)]
    pub fn add_neighbour(&mut self, law: &LawSettings, there: &Passage, judged: bool) {
        let (communication_m, safe_m, desired_m) =
            (law.communication_distance_m, law.safe_distance_m, law.desired_distance_m);
        let (per_desired_squared, per_safe) = (1.0 / (desired_m * desired_m), 1.0 / safe_m);
        let pulls = communication_m > desired_m;
        let influence = if judged { law.influence_factor } else { 0.0 };
        for i in 0..self.count.min(BATCH) {
            let (dx, dy) = (there.x_m - self.x[i], there.y_m - self.y[i]);
            // Two vehicles in one place have no direction to part in: the floor keeps every quotient finite.
            let squared = dx * dx + dy * dy;
            let squared = if squared > 1e-12 { squared } else { 1e-12 };
            let distance = squared.sqrt();
            let near = if distance <= communication_m { 1.0 } else { 0.0 };

            let pull = near * 0.5 * ln(squared * per_desired_squared);
            self.formation_x[i] += dx * pull;
            self.formation_y[i] += dy * pull;

            let inverse = 1.0 / distance;
            let closeness = inverse - per_safe;
            let push = if distance <= safe_m { closeness * closeness * inverse } else { 0.0 };
            self.collision_x[i] -= dx * push;
            self.collision_y[i] -= dy * push;

            let (dvx, dvy) = (there.vx_mps - self.vx[i], there.vy_mps - self.vy[i]);
            self.velocity_x[i] += near * dvx;
            self.velocity_y[i] += near * dvy;

            let gap = desired_m - distance;
            let gap = if pulls { gap.abs() } else { gap };
            self.cost_2[i] += influence * near * (gap + dvx.abs() + dvy.abs());
        }
    }

    /// Lets an obstacle steer each pigeon that detects it and whose way it blocks, if no nearer obstacle does.
    #[inline(always)]
    pub fn offer_obstacle(&mut self, law: &LawSettings, expected: &Expected, obstacle: &Obstacle) {
        let ahead = expected.direction();
        let (ahead_x, ahead_y) = (ahead.x, ahead.y);
        let radius_m = obstacle.radius_m;
        let inflated_m = radius_m + law.obstacle_margin_m;
        let any = law.obstacle_rule == ObstacleRule::Nearest;
        let perception_m = law.perception_distance_m;
        for i in 0..self.count.min(BATCH) {
            let (dx, dy) = (obstacle.x_m - self.x[i], obstacle.y_m - self.y[i]);
            let clearance = (dx * dx + dy * dy).sqrt() - radius_m;
            let detected = (clearance <= perception_m) & (dx * self.cos[i] + dy * self.sin[i] > -radius_m);
            let along = dx * ahead_x + dy * ahead_y;
            let across = (ahead_x * dy - ahead_y * dx).abs();
            let blocks = any | ((along > 0.0) & (across < inflated_m));
            let steers = detected & blocks & (clearance < self.least[i]);
            self.least[i] = if steers { clearance } else { self.least[i] };
            self.to_x[i] = if steers { dx } else { self.to_x[i] };
            self.to_y[i] = if steers { dy } else { self.to_y[i] };
            self.inflated[i] = if steers { inflated_m } else { self.inflated[i] };
        }
    }

    /// Eq. 4 with each pigeon's weights, then Eq. 2: the command that each follows next; the first of all may ask for
    /// any turn.
    #[inline(always)]
    pub fn follow_law(
        &mut self,
        commander: &Commander,
        law: &LawSettings,
        expected: &Expected,
        weights: &[Each; 3],
        is_first: bool,
    ) {
        let step_speed = if is_first { f64::INFINITY } else { commander.course_step_speed_max };
        let command_cost = if is_first { 0.0 } else { law.command_cost_s };
        let side_range = if law.side_rule == SideRule::Command { SINCOS_RANGE_RAD } else { 0.0 };
        let ahead = expected.direction();
        let (ahead_x, ahead_y) = (ahead.x, ahead.y);
        for i in 0..self.count.min(BATCH) {
            let (cos, sin, speed) = (self.cos[i], self.sin[i], self.speed[i]);

            // The tangent of the steering obstacle that needs the smaller turn.
            let distance = (self.to_x[i] * self.to_x[i] + self.to_y[i] * self.to_y[i]).sqrt();
            let distance = if distance > 1e-9 { distance } else { 1e-9 };
            let inverse = 1.0 / distance;
            let (centre_x, centre_y) = (self.to_x[i] * inverse, self.to_y[i] * inverse);
            let (half_sin, half_cos) = half_angle(distance, self.inflated[i], law.obstacle_margin_m);
            let right_x = centre_x * half_cos - centre_y * half_sin;
            let right_y = centre_y * half_cos + centre_x * half_sin;
            let left_x = centre_x * half_cos + centre_y * half_sin;
            let left_y = centre_y * half_cos - centre_x * half_sin;
            let asked = self.asked[i];
            let (asked_sin, asked_cos) = sincos(clamp(asked, -side_range, side_range));
            let (from_x, from_y) = (cos * asked_cos - sin * asked_sin, sin * asked_cos + cos * asked_sin);
            let right = right_x * from_x + right_y * from_y >= left_x * from_x + left_y * from_y;
            let free = self.least[i] == f64::INFINITY;
            let towards_x = if right { right_x } else { left_x };
            let towards_y = if right { right_y } else { left_y };
            let towards_x = if free { ahead_x } else { towards_x };
            let towards_y = if free { ahead_y } else { towards_y };

            // Eq. 4.
            let formation = weights[0][i] * law.formation_gain;
            let avoidance = weights[1][i] * law.obstacle_gain;
            let velocity = weights[2][i] * law.neighbour_velocity_gain;
            let demand_x = formation * self.formation_x[i]
                + law.collision_gain * self.collision_x[i]
                + avoidance * (towards_x * expected.speed_mps - self.vx[i])
                + velocity * self.velocity_x[i];
            let demand_y = formation * self.formation_y[i]
                + law.collision_gain * self.collision_y[i]
                + avoidance * (towards_y * expected.speed_mps - self.vy[i])
                + velocity * self.velocity_y[i];

            // Eq. 2.
            let along = demand_x * cos + demand_y * sin;
            let across = demand_y * cos - demand_x * sin;
            let slowest = commander.speed_min_mps;
            let turning_speed = if speed > slowest { speed } else { slowest };
            let (tau_s, turn_s) = (commander.speed_time_constant_s, commander.turn_time_constant_s);
            let setpoint = clamp(speed + tau_s * along, slowest, commander.speed_max_mps);
            let fastest = if setpoint > turning_speed { setpoint } else { turning_speed };
            let bound = commander.course_change_speed_max / fastest;
            let bound = if bound < commander.course_change_max_rad { bound } else { commander.course_change_max_rad };
            let step = step_speed / turning_speed;
            let step = if step < std::f64::consts::PI { step } else { f64::INFINITY };
            let change = clamp(turn_s * across / turning_speed, asked - step, asked + step);
            let change = clamp(change, -bound, bound);
            self.course_change[i] = change;
            let speed_change = (setpoint - self.speed_setpoint[i]).abs();
            self.cost_1[i] += command_cost * (turning_speed * (change - asked).abs() + speed_change);
            self.speed_setpoint[i] = setpoint;
        }
    }

    /// Commands from elsewhere: a speed setpoint and a course change for each pigeon.
    #[inline(always)]
    pub fn follow(&mut self, speed_setpoint: &Each, course_change: &Each) {
        self.speed_setpoint = *speed_setpoint;
        self.course_change = *course_change;
    }

    /// One control period of Eq. 1 on the command at hand.
    ///
    /// The position follows Simpson's rule over the period; up to its middle the trapezium is enough for a sample.
    #[inline(always)]
    pub fn advance(&mut self, step: &Step) {
        for i in 0..self.count.min(BATCH) {
            let (cos, sin, speed) = (self.cos[i], self.sin[i], self.speed[i]);
            let (setpoint, turn) = (self.speed_setpoint[i], self.course_change[i]);
            let (turn_sin, turn_cos) = sincos(turn * step.course_gain[0]);
            let change = step.acceleration_max_mps2 * step.period_s;
            let free = setpoint + (speed - setpoint) * step.speed_decay[0];
            let speed_1 = clamp(free, speed - 0.5 * change, speed + 0.5 * change);
            let vx_1 = speed_1 * (cos * turn_cos - sin * turn_sin) + step.wind_mps.x;
            let vy_1 = speed_1 * (sin * turn_cos + cos * turn_sin) + step.wind_mps.y;
            let (turn_sin, turn_cos) = sincos(turn * step.course_gain[1]);
            let free = setpoint + (speed - setpoint) * step.speed_decay[1];
            let speed_2 = clamp(free, speed - change, speed + change);
            let cos_2 = cos * turn_cos - sin * turn_sin;
            let sin_2 = sin * turn_cos + cos * turn_sin;
            let (vx_2, vy_2) = (speed_2 * cos_2 + step.wind_mps.x, speed_2 * sin_2 + step.wind_mps.y);
            self.start_x[i] = self.x[i];
            self.start_y[i] = self.y[i];
            self.middle_x[i] = self.x[i] + step.period_s / 4.0 * (self.vx[i] + vx_1);
            self.middle_y[i] = self.y[i] + step.period_s / 4.0 * (self.vy[i] + vy_1);
            self.x[i] += step.period_s / 6.0 * (self.vx[i] + 4.0 * vx_1 + vx_2);
            self.y[i] += step.period_s / 6.0 * (self.vy[i] + 4.0 * vy_1 + vy_2);
            self.asked[i] = turn - turn * step.course_gain[1];
            self.speed[i] = speed_2;
            self.cos[i] = cos_2;
            self.sin[i] = sin_2;
            self.vx[i] = vx_2;
            self.vy[i] = vy_2;
        }
    }

    /// Adds Eq. 11, in sight of obstacles with a share of the deviation from the expected velocity.
    #[inline(always)]
    pub fn add_progress(&mut self, law: &LawSettings, expected: &Expected, detected: bool) {
        let ahead = expected.direction();
        let (ahead_x, ahead_y) = (ahead.x, ahead.y);
        let (vx, vy) = (ahead_x * expected.speed_mps, ahead_y * expected.speed_mps);
        for i in 0..self.count.min(BATCH) {
            let progress = -(self.x[i] * ahead_x + self.y[i] * ahead_y);
            let deviation = (vx - self.vx[i]).abs() + (vy - self.vy[i]).abs();
            self.cost_1[i] += if detected { progress + law.velocity_cost_s * deviation } else { deviation };
        }
    }

    /// Adds the metres by which the vehicles fell short of `wanted_m` from something in the first half of the last
    /// step, which went from one place to another meanwhile.
    #[inline(always)]
    pub fn keep_off_first_half(&mut self, from_m: Vector2<f64>, to_m: Vector2<f64>, wanted_m: f64) {
        let (start, end) = ((&self.start_x, &self.start_y), (&self.middle_x, &self.middle_y));
        add_shortfall(&mut self.violation_m, start, end, self.count, (from_m, to_m), wanted_m);
    }

    /// The same of the second half.
    #[inline(always)]
    pub fn keep_off_second_half(&mut self, from_m: Vector2<f64>, to_m: Vector2<f64>, wanted_m: f64) {
        let (start, end) = ((&self.middle_x, &self.middle_y), (&self.x, &self.y));
        add_shortfall(&mut self.violation_m, start, end, self.count, (from_m, to_m), wanted_m);
    }
}

/// One control period of the vehicle model.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub period_s: f64,
    /// exp(-h / tau_V) and 1 - exp(-h / tau_phi) over half a period and a whole one.
    pub speed_decay: [f64; 2],
    pub course_gain: [f64; 2],
    /// Fastest change of speed; infinite where there is no such limit.
    pub acceleration_max_mps2: f64,
    /// Of the air over ground (north, east).
    pub wind_mps: Vector2<f64>,
}

/// Shortfalls at the closest approach of two straight motions: two that cross are nearest between two samples. Of the
/// distance d there, (w^2 - d^2) / 2w is the shortfall w - d to first order, and needs no root.
#[inline(always)]
fn add_shortfall(
    sum: &mut Each,
    start: (&Each, &Each),
    end: (&Each, &Each),
    count: usize,
    (from_m, to_m): (Vector2<f64>, Vector2<f64>),
    wanted_m: f64,
) {
    let (squared, scale) = (wanted_m * wanted_m, 0.5 / wanted_m);
    for i in 0..count.min(BATCH) {
        let (x, y) = (from_m.x - start.0[i], from_m.y - start.1[i]);
        let (dx, dy) = (to_m.x - end.0[i] - x, to_m.y - end.1[i] - y);
        let moved = dx * dx + dy * dy;
        let moved = if moved > 1e-12 { moved } else { 1e-12 };
        let nearest = clamp(-(x * dx + y * dy) / moved, 0.0, 1.0);
        let (x, y) = (x + nearest * dx, y + nearest * dy);
        let shortfall = (squared - (x * x + y * y)) * scale;
        sum[i] += if shortfall > 0.0 { shortfall } else { 0.0 };
    }
}

#[inline(always)]
fn extent(x: &Each, y: &Each, count: usize) -> Extent {
    let ((low_x, high_x), (low_y, high_y)) = (range(&x[..count.min(BATCH)]), range(&y[..count.min(BATCH)]));
    Extent { low: Vector2::new(low_x, low_y), high: Vector2::new(high_x, high_y) }
}

/// Least and greatest value; one running value for each place in a vector, so that the loop vectorises.
#[inline(always)]
fn range(values: &[f64]) -> (f64, f64) {
    let (mut low, mut high) = ([f64::INFINITY; VECTOR], [f64::NEG_INFINITY; VECTOR]);
    for chunk in values.chunks_exact(VECTOR) {
        for lane in 0..VECTOR {
            low[lane] = if chunk[lane] < low[lane] { chunk[lane] } else { low[lane] };
            high[lane] = if chunk[lane] > high[lane] { chunk[lane] } else { high[lane] };
        }
    }
    (low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

#[inline(always)]
fn clamp(value: f64, low: f64, high: f64) -> f64 {
    let value = if value > low { value } else { low };
    if value < high { value } else { high }
}
