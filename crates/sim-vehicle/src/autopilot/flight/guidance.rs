//! Where to: a course, a circle or a place.

use super::circle::Circle;
use flight_model::{Dynamics, State, wrap_pi};
use nalgebra::Vector2;

/// What sets the course.
#[derive(Clone, Copy, Debug)]
pub(super) enum Direction {
    Course(f64),
    /// Where the nose points: the course is what the wind makes of it.
    Heading(f64),
    Circle(Circle),
    /// To a place, (north, east) in m.
    Place {
        at: Vector2<f64>,
        /// Where the line to it begins that is followed; none: from anywhere.
        from: Option<Vector2<f64>>,
        /// Whether it may fly away first from a place that is too near to turn to.
        may_fly_away: bool,
        flies_away: bool,
    },
}

/// How far ahead on a line a vehicle steers for, s: about what ArduPlane's L1 controller does by default.
const LINE_AHEAD_S: f64 = 4.0;

/// The point of a line that is so far ahead of where the vehicle is abreast of it; none where the line ends before.
fn ahead_on_line(from: Vector2<f64>, to: Vector2<f64>, at: Vector2<f64>, ahead_m: f64) -> Option<Vector2<f64>> {
    let line = to - from;
    let length_m = line.norm();
    if length_m <= ahead_m {
        return None;
    }
    let along_m = (at - from).dot(&line) / length_m;
    let share = (along_m.max(0.0) + ahead_m) / length_m;
    (share < 1.0).then(|| from + line * share)
}

/// What a vehicle steers for, as it tells others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aim {
    /// The place that is flown to or circled, (north, east) in m; none on a course.
    pub place: Option<Vector2<f64>>,
    /// Course setpoint of this moment, rad.
    pub course_rad: f64,
    /// Altitude setpoint of this moment, m above the origin.
    pub altitude_m: f64,
    pub airspeed_mps: f64,
}

/// A place to return to instead of home.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RallyPlace {
    /// (north, east) in m.
    pub at: Vector2<f64>,
    /// Altitude of the way there, m above the origin.
    pub altitude_m: f64,
}

impl Direction {
    /// The course setpoint of this moment, rad (any turn). `dynamics` tells how tightly the vehicle turns now.
    #[inline]
    pub fn course_rad(&mut self, state: &State, dynamics: &Dynamics) -> f64 {
        match self {
            Direction::Course(rad) | Direction::Heading(rad) => *rad,
            Direction::Circle(circle) => circle.course_rad(state),
            Direction::Place { at, from, may_fly_away, flies_away } => {
                let course_rad = course_to_rad(*at, *from, flies_away, state, dynamics);
                if *flies_away && !*may_fly_away { libm::atan2(at.y - state.y_m, at.x - state.x_m) } else { course_rad }
            }
        }
    }

    /// The place that is flown to or circled, (north, east) in m, and the course there, rad; a course has no place.
    pub fn aim(&self, state: &State) -> (Option<Vector2<f64>>, f64) {
        match self {
            Direction::Course(rad) | Direction::Heading(rad) => (None, *rad),
            Direction::Circle(circle) => (Some(circle.centre()), circle.course_rad(state)),
            Direction::Place { at, .. } => (Some(*at), libm::atan2(at.y - state.y_m, at.x - state.x_m)),
        }
    }
}

/// The course to a place. The course loop lags by its time constant behind a bearing that turns, which is fed forward:
/// so the vehicle flies over the place and not past it. One that is too near to turn to would be circled for ever:
/// the vehicle first flies away, twice as far as it needs to turn round.
///
/// A line is followed by steering for a point of it that is some seconds ahead, and at its end for the place.
fn course_to_rad(
    at: Vector2<f64>,
    from: Option<Vector2<f64>>,
    flies_away: &mut bool,
    state: &State,
    dynamics: &Dynamics,
) -> f64 {
    const AHEAD_RAD: f64 = 1.0;
    let way = at - state.position_m();
    let distance_m = way.norm();
    if distance_m < 1e-6 {
        return state.course_rad;
    }
    let speed_mps = state.speed_mps;
    let lag_m = speed_mps * dynamics.time_constants.course_s;
    let tightest_m = speed_mps * speed_mps / dynamics.limits.lateral_acceleration_max_mps2();
    let turn_m = 4.0 * lag_m.max(tightest_m);
    let bearing_rad = libm::atan2(way.y, way.x);
    let off_rad = wrap_pi(bearing_rad - state.course_rad);
    let is_too_near = distance_m < if *flies_away { 2.0 * turn_m } else { turn_m };
    *flies_away = off_rad.abs() > AHEAD_RAD && is_too_near;
    if *flies_away {
        return state.course_rad;
    }
    let ahead_m = LINE_AHEAD_S * speed_mps;
    let on_line = from.and_then(|from| ahead_on_line(from, at, state.position_m(), ahead_m));
    if let Some(ahead) = on_line {
        return libm::atan2(ahead.y - state.y_m, ahead.x - state.x_m);
    }
    bearing_rad + (lag_m * libm::sin(off_rad) / distance_m).clamp(-AHEAD_RAD, AHEAD_RAD)
}
