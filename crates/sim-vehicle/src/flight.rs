//! How the vehicle flies: its modes and what feeds the three autopilot loops. Knows no MAVLink.

use crate::loiter::Circle;
use crate::{Mode, VehicleSettings};
use flight_model::{Autopilot, Dynamics, Setpoint, State, wrap_pi};

/// One vehicle in the air, or motionless on its launch rail while it is disarmed.
#[derive(Clone, Debug)]
pub(crate) struct Flight {
    dynamics: Dynamics,
    /// The three loops, with the lateral limit in force (a guided command may lower it).
    autopilot: Autopilot,
    lateral_limit_mps2: f64,
    tuning: Tuning,
    start: State,
    state: State,
    previous_course_rad: f64,
    mode: Mode,
    armed: bool,
    /// Where GUIDED was entered: released from a course, the vehicle circles here.
    guided_point: (f64, f64),
    speed: Ramp,
    altitude: Ramp,
    direction: Direction,
}

/// What parameters change of the way it flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tuning {
    /// Radius of a circle, m; below zero it is flown anticlockwise.
    pub loiter_radius_m: f64,
    /// The same for the circle round home.
    pub rtl_radius_m: f64,
    /// Altitude of the way home, m above it; none: the present one.
    pub rtl_altitude_m: Option<f64>,
    /// Altitude to which TAKEOFF climbs, m above home.
    pub takeoff_altitude_m: f64,
    /// Speed of LOITER and RTL, m/s; none: the present one.
    pub cruise_speed_mps: Option<f64>,
    /// Greatest horizontal acceleration, as a multiple of gravity, beside the flight model's own.
    pub lateral_overload_max: f64,
}

/// ArduPlane's default of TKOFF_ALT, m.
pub(crate) const TAKEOFF_ALTITUDE_M: f64 = 50.0;
/// A take-off is over when the vehicle is so near to its altitude, m.
pub(crate) const TAKEOFF_TOLERANCE_M: f64 = 2.0;

/// What sets the course.
#[derive(Clone, Copy, Debug)]
enum Direction {
    Course(f64),
    Circle(Circle),
    /// To a place, (north, east) in m.
    Place((f64, f64)),
}

/// A reference that moves to its target by at most so much a step.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    value: f64,
    target: f64,
    per_step: f64,
}

impl Ramp {
    fn at(value: f64) -> Self {
        Self { value, target: value, per_step: f64::INFINITY }
    }

    fn advance(&mut self) -> f64 {
        let error = self.target - self.value;
        self.value =
            if error.abs() <= self.per_step { self.target } else { self.value + self.per_step.copysign(error) };
        self.value
    }
}

impl Flight {
    pub fn new(settings: &VehicleSettings) -> Self {
        let start = State { course_rad: wrap_pi(settings.start.course_rad), ..settings.start };
        let mut flight = Self {
            dynamics: settings.dynamics,
            autopilot: Autopilot::new(&settings.dynamics, settings.step.as_secs_f64()),
            tuning: Tuning {
                loiter_radius_m: settings.loiter_radius_m,
                rtl_radius_m: settings.loiter_radius_m,
                rtl_altitude_m: None,
                cruise_speed_mps: None,
                takeoff_altitude_m: TAKEOFF_ALTITUDE_M,
                lateral_overload_max: f64::INFINITY,
            },
            lateral_limit_mps2: f64::INFINITY,
            start,
            state: State { speed_mps: 0.0, climb_mps: 0.0, ..start },
            previous_course_rad: start.course_rad,
            mode: settings.mode,
            armed: false,
            guided_point: (start.x_m, start.y_m),
            speed: Ramp::at(start.speed_mps),
            altitude: Ramp::at(start.altitude_m),
            direction: Direction::Course(start.course_rad),
        };
        flight.enter(settings.mode);
        if settings.armed {
            flight.arm();
        }
        flight
    }

    pub fn state(&self) -> &State {
        &self.state
    }

    pub fn mode(&self) -> Mode {
        self.mode
    }

    pub fn is_armed(&self) -> bool {
        self.armed
    }

    pub fn limits(&self) -> &flight_model::Limits {
        &self.dynamics.limits
    }

    /// Rate of turn over the last step, rad/s.
    pub fn course_rate_radps(&self) -> f64 {
        wrap_pi(self.state.course_rad - self.previous_course_rad) / self.autopilot.step_s()
    }

    /// The setpoint that the next step starts from, as far as it is known before it.
    pub fn speed_target_mps(&self) -> f64 {
        self.speed.target
    }

    /// Integrates one step. On the rail nothing moves.
    pub fn step(&mut self) {
        if !self.armed {
            return;
        }
        if self.mode == Mode::Takeoff {
            self.circle_when_up();
        }
        let course_rad = match &self.direction {
            Direction::Course(course_rad) => *course_rad,
            Direction::Circle(circle) => circle.course_rad(&self.state),
            Direction::Place(place) => self.course_to_rad(*place),
        };
        let setpoint = Setpoint { speed_mps: self.speed.advance(), course_rad, altitude_m: self.altitude.advance() };
        self.previous_course_rad = self.state.course_rad;
        self.state = self.autopilot.step(&self.state, &setpoint);
    }

    /// Leaves the rail with the start's speed and course.
    pub fn arm(&mut self) {
        if !self.armed {
            self.armed = true;
            self.state = self.start;
        }
    }

    /// Changes the mode; asking for the present one changes nothing, as in ArduPlane.
    pub fn set_mode(&mut self, mode: Mode) {
        if mode != self.mode {
            self.mode = mode;
            self.enter(mode);
        }
    }

    /// Speed setpoint, m/s, reached at no more than an acceleration in m/s2 (infinite: at once).
    pub fn set_speed(&mut self, speed_mps: f64, acceleration_mps2: f64) {
        let value = if acceleration_mps2.is_finite() { self.when_released().speed_mps } else { speed_mps };
        self.speed = Ramp { value, target: speed_mps, per_step: acceleration_mps2 * self.autopilot.step_s() };
    }

    /// Altitude setpoint, m above the origin, reached at no more than a rate in m/s (infinite: at once).
    pub fn set_altitude(&mut self, altitude_m: f64, rate_mps: f64) {
        let value = if rate_mps.is_finite() { self.state.altitude_m } else { altitude_m };
        self.altitude = Ramp { value, target: altitude_m, per_step: rate_mps * self.autopilot.step_s() };
    }

    /// Course setpoint, rad, turned to with no more than a lateral acceleration in m/s2 (or the vehicle's own limit).
    pub fn set_course(&mut self, course_rad: f64, lateral_acceleration_mps2: f64) {
        self.direction = Direction::Course(course_rad);
        self.limit_lateral_acceleration(lateral_acceleration_mps2);
    }

    /// In GUIDED, circles another place than where it was entered.
    pub fn reposition(&mut self, place: (f64, f64), radius_m: f64) {
        self.guided_point = place;
        self.circle(place, radius_m);
    }

    fn circle_when_up(&mut self) {
        let is_up = (self.state.altitude_m - self.altitude.target).abs() <= TAKEOFF_TOLERANCE_M;
        if is_up && matches!(self.direction, Direction::Course(_)) {
            self.circle((self.state.x_m, self.state.y_m), self.tuning.loiter_radius_m);
        }
    }

    /// Gives up the course setpoint and circles where GUIDED was entered.
    pub fn release_course(&mut self) {
        self.circle(self.guided_point, self.tuning.loiter_radius_m);
    }

    /// Flies by other parameters from now on: a circle whose radius has changed is flown with the new one where it is. In
    /// AUTO the mission says how wide.
    pub fn retune(&mut self, tuning: Tuning) {
        let old_radius_m = self.radius_m();
        self.tuning = tuning;
        match self.direction {
            Direction::Circle(circle) if self.mode != Mode::Auto && self.radius_m() != old_radius_m => {
                self.circle(circle.centre(), self.radius_m());
            }
            _ => self.limit_lateral_acceleration(self.lateral_limit_mps2),
        }
        match self.mode {
            Mode::Loiter | Mode::Rtl => self.fly_by_itself(),
            Mode::Auto | Mode::Cruise | Mode::Guided | Mode::Takeoff => {}
        }
    }

    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// Flies to a place, (north, east) in m, and over it.
    pub fn fly_to(&mut self, place: (f64, f64)) {
        self.limit_lateral_acceleration(f64::INFINITY);
        self.direction = Direction::Place(place);
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

    /// The course to a place. The course loop lags by its time constant behind a bearing that turns, which is fed forward:
    /// so the vehicle flies over the place and not past it. One that is too near to turn to would be circled for ever:
    /// the vehicle first flies away.
    fn course_to_rad(&self, (x_m, y_m): (f64, f64)) -> f64 {
        const AHEAD_RAD: f64 = 1.0;
        let (north, east) = (x_m - self.state.x_m, y_m - self.state.y_m);
        let distance_m = (north * north + east * east).sqrt();
        if distance_m < 1e-6 {
            return self.state.course_rad;
        }
        let speed_mps = self.state.speed_mps;
        let lag_m = speed_mps * self.dynamics.time_constants.course_s;
        let tightest_m = speed_mps * speed_mps / self.limited_dynamics().limits.lateral_acceleration_max_mps2();
        let bearing_rad = libm::atan2(east, north);
        let off_rad = wrap_pi(bearing_rad - self.state.course_rad);
        if off_rad.abs() > AHEAD_RAD && distance_m < 4.0 * lag_m.max(tightest_m) {
            return self.state.course_rad;
        }
        bearing_rad + (lag_m * libm::sin(off_rad) / distance_m).clamp(-AHEAD_RAD, AHEAD_RAD)
    }

    fn radius_m(&self) -> f64 {
        if self.mode == Mode::Rtl { self.tuning.rtl_radius_m } else { self.tuning.loiter_radius_m }
    }

    /// Speed and altitude of the modes that need nobody.
    fn fly_by_itself(&mut self) {
        if let Some(speed_mps) = self.tuning.cruise_speed_mps {
            self.set_speed(speed_mps, f64::INFINITY);
        }
        if let Some(altitude_m) = self.tuning.rtl_altitude_m.filter(|_| self.mode == Mode::Rtl) {
            self.set_altitude(altitude_m, f64::INFINITY);
        }
    }

    fn circle(&mut self, centre: (f64, f64), radius_m: f64) {
        self.limit_lateral_acceleration(f64::INFINITY);
        let dynamics = self.limited_dynamics();
        self.direction = Direction::Circle(Circle::new(centre, radius_m, &dynamics, self.autopilot.step_s()));
    }

    fn limit_lateral_acceleration(&mut self, limit_mps2: f64) {
        self.lateral_limit_mps2 = limit_mps2;
        self.autopilot = Autopilot::new(&self.limited_dynamics(), self.autopilot.step_s());
    }

    /// The flight model with the least of the lateral limits.
    fn limited_dynamics(&self) -> Dynamics {
        let mut dynamics = self.dynamics;
        let overload = (self.lateral_limit_mps2 / dynamics.limits.gravity_mps2).min(self.tuning.lateral_overload_max);
        dynamics.limits.lateral_overload_max = overload.min(dynamics.limits.lateral_overload_max);
        dynamics
    }

    /// What it flies now, or on the rail will fly when it is released.
    fn when_released(&self) -> State {
        if self.armed { self.state } else { self.start }
    }

    /// Every mode begins by holding what the vehicle does.
    fn enter(&mut self, mode: Mode) {
        let now = self.when_released();
        self.speed = Ramp::at(now.speed_mps);
        self.altitude = Ramp::at(now.altitude_m);
        self.set_course(now.course_rad, f64::INFINITY);
        let here = (now.x_m, now.y_m);
        match mode {
            Mode::Cruise => {}
            // Who is higher already stays there, as in ArduPlane.
            Mode::Takeoff => {
                self.set_altitude(self.tuning.takeoff_altitude_m.max(now.altitude_m), f64::INFINITY);
            }
            // The mission says where to; until then, as before.
            Mode::Auto => self.fly_by_itself(),
            Mode::Rtl => {
                self.circle((0.0, 0.0), self.tuning.rtl_radius_m);
                self.fly_by_itself();
            }
            Mode::Loiter => {
                self.circle(here, self.tuning.loiter_radius_m);
                self.fly_by_itself();
            }
            Mode::Guided => {
                self.guided_point = here;
                // Entered in flight, ArduPlane circles until it is told where to go. A start on the rail or in the air
                // goes straight on: the flock's start is already a course.
                if self.armed {
                    self.circle(here, self.tuning.loiter_radius_m);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> VehicleSettings {
        let start = State { x_m: 5.0, y_m: -3.0, altitude_m: 50.0, speed_mps: 10.0, course_rad: 0.3, climb_mps: 0.0 };
        VehicleSettings { start, ..VehicleSettings::default() }
    }

    fn fly(flight: &mut Flight, seconds: f64) -> State {
        for _ in 0..(seconds * 100.0).round() as usize {
            flight.step();
        }
        *flight.state()
    }

    fn from_centre(state: &State, (x, y): (f64, f64)) -> f64 {
        ((state.x_m - x) * (state.x_m - x) + (state.y_m - y) * (state.y_m - y)).sqrt()
    }

    #[test]
    fn armed_it_holds_its_start() {
        let mut flight = Flight::new(&settings());
        let end = fly(&mut flight, 10.0);
        assert!((end.x_m - (5.0 + 100.0 * libm::cos(0.3))).abs() < 1e-9);
        assert!((end.y_m - (-3.0 + 100.0 * libm::sin(0.3))).abs() < 1e-9);
        assert_eq!((end.speed_mps, end.course_rad, end.altitude_m), (10.0, 0.3, 50.0));
    }

    #[test]
    fn disarmed_it_waits_on_the_rail() {
        let mut flight = Flight::new(&VehicleSettings { armed: false, ..settings() });
        let waiting = fly(&mut flight, 5.0);
        assert_eq!((waiting.x_m, waiting.y_m, waiting.speed_mps), (5.0, -3.0, 0.0));
        flight.arm();
        assert_eq!(*flight.state(), settings().start);
        assert!(from_centre(&fly(&mut flight, 1.0), (5.0, -3.0)) > 9.99);
    }

    #[test]
    fn a_ramp_asked_for_on_the_rail_begins_at_the_release() {
        let mut flight = Flight::new(&VehicleSettings { armed: false, ..settings() });
        flight.set_speed(14.0, 0.5);
        fly(&mut flight, 5.0);
        flight.arm();
        let speed_mps = fly(&mut flight, 2.0).speed_mps;
        assert!(speed_mps > 10.0 && speed_mps < 11.0, "{speed_mps}");
    }

    #[test]
    fn a_lateral_limit_is_a_ramp_then_the_closed_form() {
        let mut flight = Flight::new(&settings());
        flight.set_course(1.3, 5.0); // 0.5 rad/s at 10 m/s, left at an error of 0.375 rad
        let end = fly(&mut flight, 3.0);
        let expected = 1.3 - 0.375 * libm::exp(-(3.0 - 1.25) / 0.75);
        assert!((end.course_rad - expected).abs() < 1e-9);
        assert!((flight.course_rate_radps() - 0.5 * libm::exp(-1.75 / 0.75)).abs() < 0.01);
    }

    #[test]
    fn ramps_hold_their_rates() {
        let mut flight = Flight::new(&settings());
        flight.set_speed(14.0, 0.5);
        flight.set_altitude(60.0, 1.0);
        // Behind a ramp a loop lags by its time constant(s): 1 s for speed, 1/3 + 3 s for altitude.
        let end = fly(&mut flight, 7.0);
        assert!((end.speed_mps - (10.0 + 0.5 * (7.0 - 1.0 * (1.0 - libm::exp(-7.0))))).abs() < 0.01);
        let later = fly(&mut flight, 1.0);
        assert!((later.climb_mps - 1.0).abs() < 0.1);
        let end = fly(&mut flight, 30.0);
        assert!((end.speed_mps - 14.0).abs() < 1e-6 && (end.altitude_m - 60.0).abs() < 1e-2);
    }

    #[test]
    fn loiter_circles_where_it_was_entered() {
        let mut flight = Flight::new(&settings());
        fly(&mut flight, 3.0);
        let entry = *flight.state();
        flight.set_mode(Mode::Loiter);
        for _ in 0..100 {
            let state = fly(&mut flight, 1.0);
            assert_eq!(state.altitude_m, entry.altitude_m);
            assert!(from_centre(&state, (entry.x_m, entry.y_m)) < 60.6);
        }
        assert!((from_centre(flight.state(), (entry.x_m, entry.y_m)) - 60.0).abs() < 0.05);
    }

    #[test]
    fn rtl_circles_home() {
        let mut flight = Flight::new(&settings());
        fly(&mut flight, 60.0);
        flight.set_mode(Mode::Rtl);
        let end = fly(&mut flight, 150.0);
        assert!((from_centre(&end, (0.0, 0.0)) - 60.0).abs() < 0.05);
    }

    #[test]
    fn guided_again_circles_and_forgets_old_setpoints() {
        let mut flight = Flight::new(&settings());
        flight.set_course(1.0, 0.05);
        flight.set_mode(Mode::Cruise);
        fly(&mut flight, 1.0);
        flight.set_mode(Mode::Guided);
        let entry = *flight.state();
        let end = fly(&mut flight, 120.0);
        assert!((from_centre(&end, (entry.x_m, entry.y_m)) - 60.0).abs() < 0.05);
        flight.set_course(0.0, f64::INFINITY);
        assert!(fly(&mut flight, 10.0).course_rad.abs() < 1e-4);
        flight.set_mode(Mode::Guided); // a repeat changes nothing
        assert!(fly(&mut flight, 1.0).course_rad.abs() < 1e-4);
        flight.release_course();
        let end = fly(&mut flight, 200.0);
        assert!((from_centre(&end, (entry.x_m, entry.y_m)) - 60.0).abs() < 0.05);
    }
}
