//! Landing at a place: down a glide slope, a flare, and onto the ground.

use super::{Flight, Stage};
use flight_model::{Setpoint, State};
use std::f64::consts::PI;

/// A landing that is under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    /// Where to, (north, east) in m.
    at: (f64, f64),
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

impl Flight {
    /// Lands at a place, (north, east) in m, on the course from here to there.
    pub fn land_at(&mut self, at: (f64, f64)) {
        self.fly_to(at);
        self.stage = Stage::Landing(Landing { at, approach_altitude_m: self.state.altitude_m, leg: Leg::Approach });
    }

    /// The setpoint of a landing, where `setpoint` would go straight there.
    pub(super) fn land(&mut self, mut landing: Landing, setpoint: &Setpoint) -> Setpoint {
        let state = self.state;
        let (north, east) = (landing.at.0 - state.x_m, landing.at.1 - state.y_m);
        let distance_m = (north * north + east * east).sqrt();
        let bearing_rad = if distance_m > 1e-6 { libm::atan2(east, north) } else { state.course_rad };
        let height_m = state.altitude_m - self.ground_m();
        let (slope_end_m, above_m) = (flare_distance_m(FLARE_HEIGHT_M, &state), height_m - FLARE_HEIGHT_M);
        landing.leg = match landing.leg {
            Leg::Flare(course_rad) => Leg::Flare(course_rad),
            _ if above_m <= 0.0 && distance_m <= flare_distance_m(height_m, &state) => Leg::Flare(bearing_rad),
            Leg::Approach if above_m > FLARE_HEIGHT_M + STEEPEST * (distance_m - slope_end_m).max(0.0) => Leg::Away,
            Leg::Away if above_m <= SLOPE * (distance_m - slope_end_m) => {
                landing.approach_altitude_m = state.altitude_m;
                Leg::Approach
            }
            leg => leg,
        };
        self.stage = Stage::Landing(landing);
        let approach_mps = 0.5 * (self.dynamics.limits.speed_min_mps + setpoint.speed_mps);
        match landing.leg {
            Leg::Away => Setpoint {
                speed_mps: setpoint.speed_mps,
                course_rad: bearing_rad + PI,
                altitude_m: self.altitude_to_climb_at(-SINK_MAX_MPS).max(self.ground_m() + AWAY_HEIGHT_M),
            },
            Leg::Approach => {
                let glide_m = self.ground_m() + FLARE_HEIGHT_M + SLOPE * (distance_m - slope_end_m).max(0.0);
                let altitude_m = if glide_m < landing.approach_altitude_m {
                    let led_m = glide_m + self.altitude_to_climb_at(-SLOPE * state.speed_mps) - state.altitude_m;
                    led_m.max(self.altitude_to_climb_at(-SINK_MAX_MPS))
                } else {
                    landing.approach_altitude_m
                };
                Setpoint { speed_mps: approach_mps, course_rad: setpoint.course_rad, altitude_m }
            }
            Leg::Flare(course_rad) => {
                let altitude_m = self.altitude_to_climb_at(-flare_sink_mps(height_m, &state));
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
