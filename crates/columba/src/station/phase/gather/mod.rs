//! Gathering: from wherever vehicles are to the scenario's starts, all at the same time, with the expected course and
//! speed.
//!
//! Each vehicle has a height of its own and a lane of its own: the line through its start along the expected course. It
//! flies to the outbound leg beside its lane, and circles there while others have not taken off yet ([`Gather::hold`]).
//! It follows the outbound leg away from the start, turns, and comes back along its lane. A vehicle that would be early
//! flies further out: each second further out is two seconds later at the start. On the lanes, side by side, all change
//! to the flock's height. No vehicle crosses another one's height before that, nor another one's lane after.
//!
//! Sans-I/O and without memory of messages: states in, setpoints out. Vehicles that hover fly the same way, but climb
//! straight up.

use crate::station::vehicle::track::distance_m;
use controller::{Expected, Obstacle};
use flight_model::{Limits, Setpoint, State, wrap_pi};
use std::f64::consts::{FRAC_PI_2, PI};

/// Metres between the heights of two vehicles.
pub const LAYER_M: f64 = 12.0;
/// So many heights at most; further vehicles share them, far apart from each other.
const LAYERS_MAX: usize = 12;
/// Lateral acceleration of the turn back, m/s2: less than any vehicle can do.
const TURN_MPS2: f64 = 4.5;
/// On its lane a vehicle is within this of the line, m, and of the course, rad.
const LANE_M: f64 = 8.0;
const LANE_RAD: f64 = 0.2;
/// Seconds of flight along the lanes: to settle on them, and to change height.
const SETTLE_S: f64 = 12.0;
/// Seconds of flight to its start that the first vehicle, and the last one, may have left when the flock is gathered.
const AT_START_S: f64 = 1.5;
const NEAR_START_S: f64 = 2.5;
/// Share of the speed by which being early or late is made up for.
const SPEED_SHARE: f64 = 0.15;
/// Vehicles further apart than this need not be apart in height before they turn to their lanes, m.
const APART_M: f64 = 200.0;
/// Those that are nearer must be apart by this share of a layer.
const APART_SHARE: f64 = 0.6;
/// A climb goes straight on where nothing stands in the next seconds, s.
const AHEAD_S: f64 = 10.0;
/// Distances to obstacles' edges that the way to the lanes keeps, m.
const CLEARANCE_M: f64 = 15.0;

/// Where a vehicle is on its way to its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// To its own height, straight on, until nobody near is near it in height.
    Climb,
    /// To the outbound leg.
    Approach,
    /// In a circle at the beginning of the outbound leg, until all have taken off.
    Hold,
    /// Away from its start, beside its lane.
    Outbound,
    /// Turning, and back along its lane.
    Inbound,
}

/// One vehicle's part.
#[derive(Clone, Copy, Debug)]
struct Part {
    start: State,
    layer_m: f64,
    leg: Leg,
    on_lane: bool,
    /// The course on which it climbs.
    climb_rad: Option<f64>,
    /// Whether it climbs straight up.
    hovers: bool,
    /// Whether it takes no part any more.
    gone: bool,
}

/// The gathering of a flock.
#[derive(Clone, Debug)]
pub struct Gather {
    expected: Expected,
    obstacles: Vec<Obstacle>,
    speed_mps: f64,
    turn_radius_m: f64,
    /// The outbound leg goes at least so far behind the starts.
    lead_m: f64,
    parts: Vec<Part>,
    /// When all are to be at their starts, s; none before all are on their outbound legs.
    arrival_s: Option<f64>,
    settling: bool,
    /// Whether nobody leaves for the outbound leg.
    holds: bool,
}

impl Gather {
    /// A gathering to `starts`, each vehicle at a height of its own from the expected altitude upwards.
    pub fn new(starts: &[State], expected: Expected, obstacles: &[Obstacle], limits: &Limits) -> Self {
        let speed_mps = expected.speed_mps;
        let turn_radius_m = (speed_mps * speed_mps / TURN_MPS2).max(10.0);
        let layers = starts.len().clamp(1, LAYERS_MAX);
        let climb_mps = limits.climb_max_mps.min(-limits.climb_min_mps).clamp(0.5, 4.0);
        let descent_s = LAYER_M * layers.saturating_sub(1) as f64 / (0.8 * climb_mps) + 4.0;
        let lead_m = speed_mps * (SETTLE_S + descent_s) + 2.0 * turn_radius_m;
        // Neighbours on the ground of lanes get heights that differ most: the order of the starts from left to right.
        let mut order: Vec<usize> = (0..starts.len()).collect();
        let lateral =
            |start: &State| -start.x_m * libm::sin(expected.course_rad) + start.y_m * libm::cos(expected.course_rad);
        order.sort_by(|&a, &b| lateral(&starts[a]).total_cmp(&lateral(&starts[b])).then(a.cmp(&b)));
        let mut parts: Vec<Part> = starts
            .iter()
            .map(|start| Part {
                start: *start,
                layer_m: expected.altitude_m,
                leg: Leg::Climb,
                on_lane: false,
                climb_rad: None,
                hovers: false,
                gone: false,
            })
            .collect();
        for (rank, index) in order.into_iter().enumerate() {
            parts[index].layer_m = expected.altitude_m + LAYER_M * (rank % layers) as f64;
        }
        Self {
            expected,
            obstacles: obstacles.to_vec(),
            speed_mps,
            turn_radius_m,
            lead_m,
            parts,
            arrival_s: None,
            settling: false,
            holds: false,
        }
    }

    /// Which vehicles can stand in the air: these climb straight up.
    pub fn with_hovering(mut self, hovers: impl Fn(usize) -> bool) -> Self {
        for (index, part) in self.parts.iter_mut().enumerate() {
            part.hovers = hovers(index);
        }
        self
    }

    /// Whether vehicles circle where the outbound leg begins, and wait there for those that are still on the ground.
    pub fn hold(&mut self, holds: bool) {
        self.holds = holds;
    }

    /// The height of a vehicle, m above the scenario's origin.
    pub fn layer_m(&self, vehicle: usize) -> f64 {
        self.parts.get(vehicle).map_or(self.expected.altitude_m, |part| part.layer_m)
    }

    /// Where a vehicle is on its way.
    pub fn leg(&self, vehicle: usize) -> Leg {
        self.parts.get(vehicle).map_or(Leg::Climb, |part| part.leg)
    }

    /// A vehicle takes no part any more.
    pub fn leave(&mut self, vehicle: usize) {
        if let Some(part) = self.parts.get_mut(vehicle) {
            part.gone = true;
        }
    }

    /// Setpoints for all vehicles from where they are; none of one that is not known.
    pub fn step(&mut self, states: &[Option<State>], now_s: f64) -> Vec<Option<Setpoint>> {
        for (index, state) in states.iter().enumerate() {
            if let Some(state) = state {
                let is_apart = self.is_apart(index, state, states);
                self.advance(index, state, is_apart);
            }
        }
        self.time_the_turns(states, now_s);
        let known = |index: usize| states.get(index).copied().flatten();
        self.settling = (0..self.parts.len())
            .all(|index| self.parts[index].gone || (self.parts[index].on_lane && known(index).is_some()));
        states.iter().enumerate().map(|(index, state)| state.map(|state| self.setpoint(index, &state, now_s))).collect()
    }

    /// Whether all are on their lanes, at the flock's height, the first of them is at its start, and the last one near.
    pub fn is_complete(&self, states: &[Option<State>]) -> bool {
        let (mut first_m, mut last_m) = (f64::NEG_INFINITY, f64::INFINITY);
        for (index, state) in states.iter().enumerate() {
            if self.parts.get(index).is_none_or(|part| part.gone) {
                continue;
            }
            let Some(state) = state else { return false };
            let ready = self.parts.get(index).is_some_and(|part| part.on_lane)
                && (state.altitude_m - self.expected.altitude_m).abs() < 2.5
                && self.is_on_lane(index, state);
            if !ready {
                return false;
            }
            let (along_m, _) = self.lane(index, state);
            (first_m, last_m) = (first_m.max(along_m), last_m.min(along_m));
        }
        first_m > -AT_START_S * self.speed_mps && last_m > -NEAR_START_S * self.speed_mps
    }

    /// Whether it has missed its starts: on the lanes, and past them.
    pub fn is_past(&self, states: &[Option<State>]) -> bool {
        let past = |(index, state): (usize, &Option<State>)| {
            state.is_some_and(|state| {
                !self.parts[index].gone
                    && self.parts[index].leg == Leg::Inbound
                    && self.lane(index, &state).0 > 0.5 * self.speed_mps
            })
        };
        states.iter().enumerate().any(past)
    }

    /// Begins the outbound legs anew, for those that were past their starts before all were ready.
    pub fn again(&mut self) {
        for part in &mut self.parts {
            part.leg = Leg::Climb;
            part.on_lane = false;
            part.climb_rad = None;
        }
        self.arrival_s = None;
        self.settling = false;
    }

    /// Distance along the lane from the start, and to the right of it, m.
    fn lane(&self, index: usize, state: &State) -> (f64, f64) {
        let start = &self.parts[index].start;
        let (dx, dy) = (state.x_m - start.x_m, state.y_m - start.y_m);
        let (sin, cos) = libm::sincos(self.expected.course_rad);
        (dx * cos + dy * sin, -dx * sin + dy * cos)
    }

    fn is_on_lane(&self, index: usize, state: &State) -> bool {
        let (_, right_m) = self.lane(index, state);
        right_m.abs() < LANE_M && wrap_pi(state.course_rad - self.expected.course_rad).abs() < LANE_RAD
    }

    /// Where the outbound leg of a vehicle begins.
    fn outbound_begin_m(&self, index: usize) -> (f64, f64) {
        let start = &self.parts[index].start;
        let (sin, cos) = libm::sincos(self.expected.course_rad);
        let (back_m, right_m) = (-0.5 * self.lead_m, self.outbound_m());
        (start.x_m + back_m * cos - right_m * sin, start.y_m + back_m * sin + right_m * cos)
    }

    /// The lateral place of the outbound leg: one turn beside the lane.
    fn outbound_m(&self) -> f64 {
        2.0 * self.turn_radius_m
    }

    /// Whether all that are near are above or below it.
    fn is_apart(&self, index: usize, state: &State, states: &[Option<State>]) -> bool {
        states.iter().enumerate().all(|(other, theirs)| {
            let Some(theirs) = theirs.filter(|_| other != index && !self.parts[other].gone) else { return true };
            let shares_a_layer = (self.parts[other].layer_m - self.parts[index].layer_m).abs() < 1.0;
            shares_a_layer
                || distance_m(state, &theirs) > APART_M
                || (state.altitude_m - theirs.altitude_m).abs() > APART_SHARE * LAYER_M
        })
    }

    fn advance(&mut self, index: usize, state: &State, is_apart: bool) {
        let (along_m, right_m) = self.lane(index, state);
        let (outbound_m, lead_m, radius_m) = (self.outbound_m(), self.lead_m, self.turn_radius_m);
        let (on_lane, holds) = (self.is_on_lane(index, state), self.holds);
        let part = &mut self.parts[index];
        part.climb_rad.get_or_insert(state.course_rad);
        match part.leg {
            Leg::Climb if (state.altitude_m - part.layer_m).abs() < 4.0 && is_apart => part.leg = Leg::Approach,
            Leg::Approach => {
                let is_there =
                    (along_m + 0.5 * lead_m).abs() < 0.45 * lead_m && (right_m - outbound_m).abs() < 1.5 * radius_m;
                if is_there || (along_m < -lead_m && (right_m - outbound_m).abs() < 3.0 * radius_m) {
                    part.leg = if holds { Leg::Hold } else { Leg::Outbound };
                }
            }
            Leg::Hold if !holds => part.leg = Leg::Outbound,
            Leg::Inbound => part.on_lane |= on_lane,
            _ => {}
        }
    }

    /// Seconds from now until a vehicle that turns back now is at its start.
    fn time_to_start_s(&self, along_m: f64) -> f64 {
        (PI * self.turn_radius_m + (-along_m).max(0.0)) / self.speed_mps
    }

    /// Decides who turns back now. The common arrival is that of the one that needs longest.
    fn time_the_turns(&mut self, states: &[Option<State>], now_s: f64) {
        let is_out = |part: &Part| part.gone || matches!(part.leg, Leg::Outbound | Leg::Inbound);
        if !self.parts.iter().all(is_out) {
            return;
        }
        let along: Vec<Option<f64>> = states
            .iter()
            .enumerate()
            .map(|(index, state)| state.filter(|_| !self.parts[index].gone).map(|state| self.lane(index, &state).0))
            .collect();
        if self.arrival_s.is_none() {
            let longest_s = along
                .iter()
                .flatten()
                .map(|&along_m| {
                    self.time_to_start_s(along_m.min(-self.lead_m))
                        + ((along_m + self.lead_m) / self.speed_mps).max(0.0)
                })
                .fold(0.0, f64::max);
            self.arrival_s = Some(now_s + longest_s + 2.0);
        }
        let Some(arrival_s) = self.arrival_s else { return };
        for (index, along_m) in along.into_iter().enumerate() {
            let Some(along_m) = along_m else { continue };
            let is_time = self.time_to_start_s(along_m) >= arrival_s - now_s;
            if self.parts[index].leg == Leg::Outbound && is_time {
                self.parts[index].leg = Leg::Inbound;
            }
        }
    }

    fn setpoint(&self, index: usize, state: &State, now_s: f64) -> Setpoint {
        let part = &self.parts[index];
        let (along_m, right_m) = self.lane(index, state);
        let course = self.expected.course_rad;
        let altitude_m = if self.settling { self.expected.altitude_m } else { part.layer_m };
        let hold = Setpoint { speed_mps: self.speed_mps, course_rad: course, altitude_m };
        match part.leg {
            Leg::Climb if part.hovers => {
                Setpoint { speed_mps: 0.0, course_rad: part.climb_rad.unwrap_or(state.course_rad), ..hold }
            }
            Leg::Climb if self.is_free_ahead(state, part.climb_rad) => {
                Setpoint { course_rad: part.climb_rad.unwrap_or(state.course_rad), ..hold }
            }
            Leg::Climb | Leg::Approach => {
                Setpoint { course_rad: self.way_to(state, self.outbound_begin_m(index)), ..hold }
            }
            Leg::Hold => {
                let (x_m, y_m) = self.outbound_begin_m(index);
                let (dx, dy) = (x_m - state.x_m, y_m - state.y_m);
                // Clockwise round it: abeam on the circle, more inward outside of it.
                let outside = libm::hypot(dx, dy) / self.turn_radius_m - 1.0;
                let course_rad = wrap_pi(libm::atan2(dy, dx) - FRAC_PI_2 + outside.clamp(-1.0, 1.0));
                Setpoint { course_rad, ..hold }
            }
            Leg::Outbound => {
                // Seen along the outbound leg, which runs the other way, right is left.
                let off_m = self.outbound_m() - right_m;
                Setpoint { course_rad: wrap_pi(course + PI + self.intercept_rad(off_m)), ..hold }
            }
            Leg::Inbound => {
                let turning = wrap_pi(state.course_rad - course).abs() > FRAC_PI_2;
                let course_rad = if turning {
                    // Over the right shoulder, towards the lane: a quarter of a turn ahead of where it is.
                    wrap_pi(state.course_rad + 1.2)
                } else {
                    wrap_pi(course + self.intercept_rad(right_m))
                };
                let wanted_s = self.arrival_s.map_or(0.0, |arrival_s| arrival_s - now_s);
                let need_s = (-along_m).max(0.0) / self.speed_mps;
                let late_s = need_s - wanted_s;
                let share = if turning { 0.0 } else { (late_s / 8.0).clamp(-SPEED_SHARE, SPEED_SHARE) };
                Setpoint { speed_mps: self.speed_mps * (1.0 + share), course_rad, ..hold }
            }
        }
    }

    /// How far to turn off a line's course to come back to it, with `right_m` to the right of it.
    fn intercept_rad(&self, right_m: f64) -> f64 {
        -libm::atan(right_m / (1.6 * self.turn_radius_m).max(15.0)).clamp(-1.2, 1.2)
    }

    /// Whether no obstacle stands on the next seconds of a course.
    fn is_free_ahead(&self, state: &State, course_rad: Option<f64>) -> bool {
        let (sin, cos) = libm::sincos(course_rad.unwrap_or(state.course_rad));
        let ahead_m = AHEAD_S * self.speed_mps;
        self.obstacles.iter().all(|circle| {
            let (ox, oy) = (circle.x_m - state.x_m, circle.y_m - state.y_m);
            let (along_m, aside_m) = (ox * cos + oy * sin, oy * cos - ox * sin);
            let radius_m = circle.radius_m + CLEARANCE_M;
            along_m < 0.0 || along_m - radius_m > ahead_m || aside_m.abs() > radius_m
        })
    }

    /// The course to a place, round the obstacles in the way.
    fn way_to(&self, state: &State, (x_m, y_m): (f64, f64)) -> f64 {
        let (dx, dy) = (x_m - state.x_m, y_m - state.y_m);
        let direct = libm::atan2(dy, dx);
        let distance_m = (dx * dx + dy * dy).sqrt().max(1.0);
        let mut nearest: Option<(f64, f64)> = None;
        for circle in &self.obstacles {
            let (ox, oy) = (circle.x_m - state.x_m, circle.y_m - state.y_m);
            let radius_m = circle.radius_m + CLEARANCE_M;
            let ahead_m = (ox * dx + oy * dy) / distance_m;
            let aside_m = (dx * oy - dy * ox) / distance_m;
            if ahead_m <= -radius_m || ahead_m - radius_m > distance_m || aside_m.abs() >= radius_m {
                continue;
            }
            let centre_m = (ox * ox + oy * oy).sqrt();
            let bearing = libm::atan2(oy, ox);
            // Along the tangent on the nearer side; straight out from within.
            let tangent = if centre_m > radius_m { libm::asin(radius_m / centre_m) } else { PI * 0.6 };
            let side = if aside_m > 0.0 { -1.0 } else { 1.0 };
            if nearest.is_none_or(|(at_m, _)| centre_m < at_m) {
                nearest = Some((centre_m, wrap_pi(bearing + side * tangent)));
            }
        }
        nearest.map_or(direct, |(_, course)| course)
    }
}

#[cfg(test)]
mod tests;
