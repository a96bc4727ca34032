//! Where to: a course, a circle or a place.

use super::circle::Circle;
use super::ramp::Ramp;
use super::{Flight, Stage, TAKEOFF_TOLERANCE_M};
use crate::mode::Mode;
use flight_model::wrap_pi;

/// What sets the course.
#[derive(Clone, Copy, Debug)]
pub(super) enum Direction {
    Course(f64),
    /// Where the nose points: the course is what the wind makes of it.
    Heading(f64),
    Circle(Circle),
    /// To a place, (north, east) in m.
    Place {
        at: (f64, f64),
        /// Where the line to it begins that is followed; none: from anywhere.
        from: Option<(f64, f64)>,
        flies_away: bool,
    },
}

/// How far ahead on a line a vehicle steers for, s: about what ArduPlane's L1 controller does by default.
const LINE_AHEAD_S: f64 = 4.0;

/// The point of a line that is so far ahead of where the vehicle is abreast of it; none where the line ends before.
fn ahead_on_line(from: (f64, f64), to: (f64, f64), at: (f64, f64), ahead_m: f64) -> Option<(f64, f64)> {
    let (north, east) = (to.0 - from.0, to.1 - from.1);
    let length_m = (north * north + east * east).sqrt();
    if length_m <= ahead_m {
        return None;
    }
    let along_m = ((at.0 - from.0) * north + (at.1 - from.1) * east) / length_m;
    let share = (along_m.max(0.0) + ahead_m) / length_m;
    (share < 1.0).then_some((from.0 + share * north, from.1 + share * east))
}

/// What a vehicle steers for, as it tells others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aim {
    /// The place that is flown to or circled, (north, east) in m; none on a course.
    pub place: Option<(f64, f64)>,
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
    pub at: (f64, f64),
    /// Altitude of the way there, m above the origin.
    pub altitude_m: f64,
}

impl Flight {
    /// Altitude setpoint of a guided command, as [`set_altitude`](Self::set_altitude); known as such until the next one.
    pub fn slew_altitude(&mut self, altitude_m: f64, rate_mps: f64) {
        self.set_altitude(altitude_m, rate_mps);
        self.altitude_is_slewed = true;
    }

    pub fn is_altitude_slewed(&self) -> bool {
        self.altitude_is_slewed
    }

    /// Where RTL will go when it is entered; none: home.
    pub fn set_rally(&mut self, rally: Option<RallyPlace>) {
        self.rally = rally;
    }

    /// In GUIDED, circles another place than where it was entered.
    pub fn reposition(&mut self, place: (f64, f64), radius_m: f64) {
        self.guided_point = place;
        self.circle(place, radius_m);
    }

    /// Gives up the course setpoint and circles where GUIDED was entered.
    pub fn release_course(&mut self) {
        self.circle(self.guided_point, self.tuning.loiter_radius_m);
    }

    /// Flies to a place, (north, east) in m, and over it.
    pub fn fly_to(&mut self, place: (f64, f64)) {
        self.fly_toward(None, place);
    }

    /// The same along the line from one place to the other.
    pub fn fly_leg(&mut self, from: (f64, f64), to: (f64, f64)) {
        self.fly_toward(Some(from), to);
    }

    fn fly_toward(&mut self, from: Option<(f64, f64)>, at: (f64, f64)) {
        self.stage = Stage::Normal;
        self.limit_lateral_acceleration(f64::INFINITY);
        self.direction = Direction::Place { at, from, flies_away: false };
    }

    /// Circles round a place; gives the radius, which is wider than asked for if it cannot turn so tightly.
    pub fn circle_at(&mut self, centre: (f64, f64), radius_m: f64) -> f64 {
        self.circle(centre, radius_m);
        match self.direction {
            Direction::Circle(circle) => circle.radius_m(),
            _ => radius_m,
        }
    }

    /// Straight on.
    pub fn hold_course(&mut self) {
        self.set_course(self.when_released().course_rad, f64::INFINITY);
    }

    /// Climbs at a rate, m/s, until it is told otherwise. Asked for again it changes nothing.
    pub fn climb_at(&mut self, rate_mps: f64) {
        // Further than it will ever climb or sink.
        const FAR_M: f64 = 1e6;
        self.altitude = Ramp {
            value: self.altitude_to_climb_at(rate_mps),
            target: if rate_mps == 0.0 { self.state.altitude_m } else { FAR_M.copysign(rate_mps) },
            per_step: rate_mps.abs() * self.autopilot.step_s(),
        };
    }

    /// What it steers for.
    pub fn aim(&self) -> Aim {
        let state = self.estimate();
        let (place, course_rad) = match self.direction {
            Direction::Course(rad) | Direction::Heading(rad) => (None, rad),
            Direction::Circle(circle) => (Some(circle.centre()), circle.course_rad(&state)),
            Direction::Place { at, .. } => (Some(at), libm::atan2(at.1 - state.y_m, at.0 - state.x_m)),
        };
        Aim { place, course_rad, altitude_m: self.altitude.value, airspeed_mps: self.speed.value }
    }

    /// The course setpoint of this moment, rad (any turn).
    pub(super) fn guide_rad(&mut self) -> f64 {
        match self.direction {
            Direction::Course(rad) | Direction::Heading(rad) => rad,
            Direction::Circle(circle) => circle.course_rad(&self.estimate()),
            Direction::Place { at, from, flies_away } => self.course_to_rad(at, from, flies_away),
        }
    }

    pub(super) fn circle(&mut self, centre: (f64, f64), radius_m: f64) {
        self.stage = Stage::Normal;
        self.limit_lateral_acceleration(f64::INFINITY);
        let dynamics = self.limited_dynamics();
        self.direction = Direction::Circle(Circle::new(centre, radius_m, &dynamics, self.autopilot.step_s()));
    }

    /// Whether TAKEOFF is at its altitude and circles.
    pub fn has_taken_off(&self) -> bool {
        self.mode == Mode::Takeoff && matches!(self.direction, Direction::Circle(_))
    }

    /// Climbs straight on to an altitude, m above the origin, from the ground or in the air.
    pub fn take_off(&mut self, altitude_m: f64) {
        self.hold_course();
        self.set_altitude(altitude_m, f64::INFINITY);
        self.stage = Stage::Takeoff;
    }

    /// Ends a take-off at its altitude. TAKEOFF goes on by circling there; AUTO has its next item.
    pub(super) fn level_off_when_up(&mut self) {
        if (self.state.altitude_m - self.altitude.target).abs() > TAKEOFF_TOLERANCE_M {
            return;
        }
        self.stage = Stage::Normal;
        if self.mode == Mode::Takeoff {
            self.circle((self.state.x_m, self.state.y_m), self.tuning.loiter_radius_m);
        }
    }

    /// The course to a place. The course loop lags by its time constant behind a bearing that turns, which is fed forward:
    /// so the vehicle flies over the place and not past it. One that is too near to turn to would be circled for ever:
    /// the vehicle first flies away, twice as far as it needs to turn round.
    ///
    /// A line is followed by steering for a point of it that is some seconds ahead, and at its end for the place.
    fn course_to_rad(&mut self, at: (f64, f64), from: Option<(f64, f64)>, flies_away: bool) -> f64 {
        const AHEAD_RAD: f64 = 1.0;
        let state = self.estimate();
        let (north, east) = (at.0 - state.x_m, at.1 - state.y_m);
        let distance_m = (north * north + east * east).sqrt();
        if distance_m < 1e-6 {
            return state.course_rad;
        }
        let speed_mps = state.speed_mps;
        let lag_m = speed_mps * self.dynamics.time_constants.course_s;
        let tightest_m = speed_mps * speed_mps / self.limited_dynamics().limits.lateral_acceleration_max_mps2();
        let turn_m = 4.0 * lag_m.max(tightest_m);
        let bearing_rad = libm::atan2(east, north);
        let off_rad = wrap_pi(bearing_rad - state.course_rad);
        let is_too_near = distance_m < if flies_away { 2.0 * turn_m } else { turn_m };
        let flies_away = off_rad.abs() > AHEAD_RAD && is_too_near;
        self.direction = Direction::Place { at, from, flies_away };
        if flies_away {
            return state.course_rad;
        }
        let ahead_m = LINE_AHEAD_S * speed_mps;
        let on_line = from.and_then(|from| ahead_on_line(from, at, (state.x_m, state.y_m), ahead_m));
        if let Some((x_m, y_m)) = on_line {
            return libm::atan2(y_m - state.y_m, x_m - state.x_m);
        }
        bearing_rad + (lag_m * libm::sin(off_rad) / distance_m).clamp(-AHEAD_RAD, AHEAD_RAD)
    }
}
