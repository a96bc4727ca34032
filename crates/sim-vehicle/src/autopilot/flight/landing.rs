//! Landing at a place: down a glide slope, a flare, and onto the ground.

use flight_model::{Setpoint, State};
use nalgebra::Vector2;
use std::f64::consts::PI;

/// A landing that is under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    /// Where to, (north, east) in m.
    at: Vector2<f64>,
    /// Altitude until the glide slope is met, m above the origin.
    approach_altitude_m: f64,
    leg: Leg,
}

#[derive(Clone, Copy, Debug)]
enum Leg {
    /// To the place and down.
    Approach,
    /// Away from it and down: it was too high to come down in time.
    Away,
    /// The last metres, on a course, rad.
    Flare(f64),
}

/// Descent of the glide slope over its length.
const SLOPE: f64 = 0.1;
/// The steepest slope that is flown to get down to it.
const STEEPEST: f64 = 0.2;
/// Least height on the way to where the glide slope can be met, m.
const AWAY_HEIGHT_M: f64 = 15.0;
/// Greatest rate of descent before the glide slope, m/s.
const SINK_MAX_MPS: f64 = 3.0;
/// Height at which the flare begins, m: ArduPlane's default of LAND_FLARE_ALT.
const FLARE_HEIGHT_M: f64 = 3.0;
/// Rate of descent at the end of the flare, m/s.
const TOUCH_DOWN_SINK_MPS: f64 = 0.3;

/// What a landing sees of the flight.
pub(super) struct View<'a> {
    pub state: &'a State,
    /// Altitude of the ground, m above the origin.
    pub ground_m: f64,
    /// The least airspeed, m/s.
    pub least_mps: f64,
    /// By how long the altitude loop lags behind a setpoint that moves, s.
    pub altitude_lag_s: f64,
}

impl View<'_> {
    fn altitude_to_climb_at(&self, climb_mps: f64) -> f64 {
        self.state.altitude_m + climb_mps * self.altitude_lag_s
    }
}

impl Landing {
    /// To a place, (north, east) in m, from an altitude.
    pub fn new(at: Vector2<f64>, altitude_m: f64) -> Self {
        Self { at, approach_altitude_m: altitude_m, leg: Leg::Approach }
    }

    /// Its setpoint of this moment, where `setpoint` would go straight there.
    pub fn setpoint(&mut self, view: &View<'_>, setpoint: &Setpoint) -> Setpoint {
        let state = view.state;
        let way = self.at - state.position_m();
        let distance_m = way.norm();
        let bearing_rad = if distance_m > 1e-6 { libm::atan2(way.y, way.x) } else { state.course_rad };
        let height_m = state.altitude_m - view.ground_m;
        let (slope_end_m, above_m) = (flare_distance_m(FLARE_HEIGHT_M, state), height_m - FLARE_HEIGHT_M);
        self.leg = match self.leg {
            Leg::Flare(course_rad) => Leg::Flare(course_rad),
            _ if above_m <= 0.0 && distance_m <= flare_distance_m(height_m, state) => Leg::Flare(bearing_rad),
            Leg::Approach if above_m > FLARE_HEIGHT_M + STEEPEST * (distance_m - slope_end_m).max(0.0) => Leg::Away,
            Leg::Away if above_m <= SLOPE * (distance_m - slope_end_m) => {
                self.approach_altitude_m = state.altitude_m;
                Leg::Approach
            }
            leg => leg,
        };
        let approach_mps = 0.5 * (view.least_mps + setpoint.speed_mps);
        match self.leg {
            Leg::Away => Setpoint {
                speed_mps: setpoint.speed_mps,
                course_rad: bearing_rad + PI,
                altitude_m: view.altitude_to_climb_at(-SINK_MAX_MPS).max(view.ground_m + AWAY_HEIGHT_M),
            },
            Leg::Approach => {
                let glide_m = view.ground_m + FLARE_HEIGHT_M + SLOPE * (distance_m - slope_end_m).max(0.0);
                let altitude_m = if glide_m < self.approach_altitude_m {
                    let led_m = glide_m + view.altitude_to_climb_at(-SLOPE * state.speed_mps) - state.altitude_m;
                    led_m.max(view.altitude_to_climb_at(-SINK_MAX_MPS))
                } else {
                    self.approach_altitude_m
                };
                Setpoint { speed_mps: approach_mps, course_rad: setpoint.course_rad, altitude_m }
            }
            Leg::Flare(course_rad) => {
                let altitude_m = view.altitude_to_climb_at(-flare_sink_mps(height_m, state));
                Setpoint { speed_mps: approach_mps, course_rad, altitude_m }
            }
        }
    }
}

/// Rate of descent in the flare: from that of the glide slope it falls in proportion to the height.
fn flare_sink_mps(height_m: f64, state: &State) -> f64 {
    let slope_mps = (SLOPE * state.speed_mps).max(TOUCH_DOWN_SINK_MPS);
    let share = (height_m / FLARE_HEIGHT_M).clamp(0.0, 1.0);
    TOUCH_DOWN_SINK_MPS + share * (slope_mps - TOUCH_DOWN_SINK_MPS)
}

/// How far a flare from a height goes: the integral of the time that the rate of descent above takes. Against a strong
/// wind the slope's rate is that of the end, and all of the height goes by it.
fn flare_distance_m(height_m: f64, state: &State) -> f64 {
    let height_m = height_m.clamp(0.0, FLARE_HEIGHT_M);
    let excess = flare_sink_mps(height_m, state) / TOUCH_DOWN_SINK_MPS - 1.0;
    let slowing = if excess > 1e-9 { libm::log1p(excess) / excess } else { 1.0 };
    state.speed_mps * height_m / TOUCH_DOWN_SINK_MPS * slowing
}
