//! What is held and steered for: speed, altitude, and a course, a circle or a place.

use super::attitude::AttitudeTarget;
use super::circle::Circle;
use super::ground::Contact;
use super::guidance::{Aim, Direction, RallyPlace};
use super::ramp::Ramp;
use super::{Flight, Stage};
use flight_model::{Autopilot, Dynamics, State};
use mavlink_bridge::kind::gentle_rate_mps2;
use nalgebra::Vector2;

impl Flight {
    /// Airspeed setpoint, m/s, reached at no more than an acceleration in m/s2 (infinite: at once) from where the
    /// demand is now.
    pub fn set_speed(&mut self, speed_mps: f64, acceleration_mps2: f64) {
        let value = if acceleration_mps2.is_finite() { self.speed_demand_mps() } else { speed_mps };
        self.speed_is_over_ground = false;
        self.speed = Ramp { value, target: speed_mps, per_step: acceleration_mps2 * self.autopilot.step_s() };
    }

    /// Airspeed setpoint, m/s, that came without an acceleration.
    pub fn set_speed_as_led(&mut self, speed_mps: f64) {
        let most_mps2 = self.led_acceleration_mps2;
        // A setpoint that is repeated finds the demand on its way.
        if most_mps2.is_infinite() {
            self.set_speed(speed_mps, most_mps2);
        } else if speed_mps != self.speed.target {
            self.set_speed(speed_mps, gentle_rate_mps2(speed_mps - self.speed_demand_mps(), most_mps2));
        }
    }

    /// The airspeed that it asks of itself at present, m/s. One that was asked for over ground, or before it flew,
    /// counts as the airspeed that it has.
    pub fn speed_demand_mps(&self) -> f64 {
        let is_demanded = self.contact == Contact::Air && !self.speed_is_over_ground;
        if is_demanded { self.speed.value } else { self.airspeed_when_released_mps() }
    }

    /// From now on its airspeed rises where its speed over ground, m/s, would be lower.
    pub fn set_least_ground_speed(&mut self, speed_mps: f64) {
        self.least_ground_speed_mps = speed_mps;
    }

    /// Glides with its engine idle, until another mode is set.
    pub fn glide(&mut self) {
        self.glides = true;
    }

    /// Speed over ground, m/s, by the airspeed that gives it, within the limits.
    pub fn set_ground_speed(&mut self, speed_mps: f64) {
        self.set_speed(speed_mps, f64::INFINITY);
        self.speed_is_over_ground = true;
    }

    /// Altitude setpoint, m above the origin, reached at no more than a rate in m/s (infinite: at once).
    pub fn set_altitude(&mut self, altitude_m: f64, rate_mps: f64) {
        self.altitude_is_slewed = false;
        let value = if rate_mps.is_finite() { self.state.altitude_m } else { altitude_m };
        self.altitude = Ramp { value, target: altitude_m, per_step: rate_mps * self.autopilot.step_s() };
    }

    /// Altitude setpoint of a guided command, as [`set_altitude`](Self::set_altitude); known as such until the next
    /// one.
    pub fn slew_altitude(&mut self, altitude_m: f64, rate_mps: f64) {
        self.set_altitude(altitude_m, rate_mps);
        self.altitude_is_slewed = true;
    }

    pub fn is_altitude_slewed(&self) -> bool {
        self.altitude_is_slewed
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

    /// Course setpoint, rad, turned to with no more than a lateral acceleration in m/s2 (or the vehicle's own limit).
    pub fn set_course(&mut self, course_rad: f64, lateral_acceleration_mps2: f64) {
        self.stage = Stage::Normal;
        self.direction = Direction::Course(course_rad);
        self.limit_lateral_acceleration(lateral_acceleration_mps2);
    }

    /// Heading, rad, turned to with no more than a lateral acceleration in m/s2; the wind carries the course away.
    pub fn set_heading(&mut self, heading_rad: f64, lateral_acceleration_mps2: f64) {
        self.set_course(heading_rad, lateral_acceleration_mps2);
        self.direction = Direction::Heading(heading_rad);
    }

    /// Straight on.
    pub fn hold_course(&mut self) {
        self.set_course(self.when_released().course_rad, f64::INFINITY);
    }

    /// Flies to a place, (north, east) in m, and over it.
    pub fn fly_to(&mut self, place: Vector2<f64>) {
        self.fly_toward(None, place, true);
    }

    /// The same along the line from one place to the other; past it, if need be, where it may not fly away first to
    /// have room to turn.
    pub fn fly_leg(&mut self, from: Vector2<f64>, to: Vector2<f64>, may_fly_away: bool) {
        self.fly_toward(Some(from), to, may_fly_away);
    }

    fn fly_toward(&mut self, from: Option<Vector2<f64>>, at: Vector2<f64>, may_fly_away: bool) {
        self.stage = Stage::Normal;
        self.limit_lateral_acceleration(f64::INFINITY);
        self.direction = Direction::Place { at, from, may_fly_away, flies_away: false };
    }

    /// Circles round a place; gives the radius, which is wider than asked for if it cannot turn so tightly.
    pub fn circle_at(&mut self, centre: Vector2<f64>, radius_m: f64) -> f64 {
        self.circle(centre, radius_m);
        match self.direction {
            Direction::Circle(circle) => circle.radius_m(),
            _ => radius_m,
        }
    }

    /// In GUIDED, circles another place than where it was entered.
    pub fn reposition(&mut self, place: Vector2<f64>, radius_m: f64) {
        self.guided_point = place;
        self.circle(place, radius_m);
    }

    /// The place that it circles, (north, east) in m, and the radius, m, below zero anticlockwise.
    pub fn circled(&self) -> Option<(Vector2<f64>, f64)> {
        match &self.direction {
            Direction::Circle(circle) => Some((circle.centre(), circle.signed_radius_m())),
            _ => None,
        }
    }

    /// Gives up the course setpoint and circles where GUIDED was entered.
    pub fn release_course(&mut self) {
        self.circle(self.guided_point, self.tuning.loiter_radius_m);
    }

    /// Where RTL will go when it is entered; none: home.
    pub fn set_rally(&mut self, rally: Option<RallyPlace>) {
        self.rally = rally;
    }

    /// Climbs straight on to an altitude, m above the origin, from the ground or in the air.
    pub fn take_off(&mut self, altitude_m: f64) {
        self.hold_course();
        self.set_altitude(altitude_m, f64::INFINITY);
        self.stage = Stage::Takeoff;
    }

    /// Flies by an attitude from now on, as far as it is asked for; none: as it is steered otherwise.
    pub fn set_attitude(&mut self, attitude: Option<AttitudeTarget>) {
        let was_banked = self.is_banked();
        self.attitude = attitude.filter(|attitude| !attitude.is_empty());
        if self.is_banked() != was_banked {
            self.limit_lateral_acceleration(self.lateral_limit_mps2);
        }
    }

    /// The attitude that it flies by.
    #[inline]
    pub fn attitude(&self) -> Option<&AttitudeTarget> {
        self.attitude.as_ref()
    }

    /// Bank and pitch, rad: those that somebody else sets, or else as it flies.
    pub fn roll_and_pitch_rad(&self) -> [f64; 2] {
        let in_air = self.in_air();
        let flown = self.attitude.unwrap_or_default();
        let roll_rad = flown.roll.map_or_else(|| self.roll_rad(), |roll| roll.rad);
        let climbing_rad = || libm::atan2(in_air.climb_mps, in_air.speed_mps);
        [roll_rad, flown.pitch.map_or_else(climbing_rad, |pitch| pitch.rad)]
    }

    /// Whether somebody else sets its bank.
    pub(super) fn is_banked(&self) -> bool {
        self.attitude.is_some_and(|attitude| attitude.roll.is_some())
    }

    /// What it steers for.
    pub fn aim(&self) -> Aim {
        let (place, course_rad) = self.direction.aim(&self.estimate());
        Aim { place, course_rad, altitude_m: self.altitude.value, airspeed_mps: self.speed.value }
    }

    pub(super) fn circle(&mut self, centre: Vector2<f64>, radius_m: f64) {
        self.stage = Stage::Normal;
        self.limit_lateral_acceleration(f64::INFINITY);
        self.direction = Direction::Circle(Circle::new(centre, radius_m, &self.limited, self.autopilot.step_s()));
    }

    /// The altitude setpoint that makes the altitude loop climb at a rate, m/s: it lags by its time constants behind a
    /// setpoint that moves.
    pub(super) fn altitude_to_climb_at(&self, climb_mps: f64) -> f64 {
        let tau = self.dynamics.time_constants;
        self.state.altitude_m + climb_mps * (tau.altitude_a_s + tau.altitude_b_s)
    }

    /// What it flies now, or will fly when it is released from the rail or has left the ground.
    pub(super) fn when_released(&self) -> State {
        match self.contact {
            Contact::Rail => self.start,
            Contact::Ground => State { speed_mps: self.start.speed_mps, ..self.state },
            Contact::Air => self.state,
        }
    }

    pub(super) fn airspeed_when_released_mps(&self) -> f64 {
        match self.contact {
            Contact::Air => self.equivalent_airspeed_mps(),
            // From the rail it leaves with a speed over ground, and on the ground that speed is its cruise speed.
            Contact::Rail => self.start.speed_mps / self.true_airspeed_ratio(),
            Contact::Ground => self.start.speed_mps,
        }
    }

    pub(super) fn limit_lateral_acceleration(&mut self, limit_mps2: f64) {
        self.lateral_limit_mps2 = limit_mps2;
        self.limited = self.limited_dynamics();
        self.autopilot = Autopilot::new(&self.limited, self.autopilot.step_s());
        if let Some(plant) = &mut self.plant {
            plant.set_limits(&self.limited.limits);
        }
    }

    /// The flight model with the least of the lateral limits.
    fn limited_dynamics(&self) -> Dynamics {
        let mut dynamics = self.dynamics;
        // The limit of a guided course is not that of a bank that is asked for.
        let limit_mps2 = if self.is_banked() { f64::INFINITY } else { self.lateral_limit_mps2 };
        let overload = (limit_mps2 / dynamics.limits.gravity_mps2)
            .min(self.tuning.lateral_overload_max)
            .min(self.first_climb_overload().unwrap_or(f64::INFINITY));
        let limits = &mut dynamics.limits;
        limits.lateral_overload_max = overload.min(limits.lateral_overload_max);
        limits.climb_max_mps = self.tuning.climb_max_mps.min(limits.climb_max_mps);
        limits.climb_min_mps = (-self.tuning.sink_max_mps).max(limits.climb_min_mps);
        dynamics
    }
}
