//! Flying in air that moves. Speeds that are held are airspeeds, courses are over ground; in still air both are the same,
//! to the last bit.

use super::Flight;
use super::ground::Contact;
use super::guidance::Direction;
use flight_model::{Setpoint, State, Wind, wrap_pi};

/// The air round the vehicle, and what its autopilot knows of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// As it is over ground, whether the vehicle feels it or stands.
    outside: Wind,
    /// As the vehicle feels it.
    wind: Wind,
    /// As the autopilot reckons with it: as it is, while a GPS tells where the air carries the vehicle.
    known: Wind,
    /// How far the place where the vehicle believes to be is from where it is, (north, east) in m.
    astray_m: (f64, f64),
    /// The state before the last step, in the wind of that step.
    before: State,
}

impl Air {
    /// Still, round a vehicle that has just begun.
    pub fn at(start: &State) -> Self {
        Self { outside: Wind::CALM, wind: Wind::CALM, known: Wind::CALM, astray_m: (0.0, 0.0), before: *start }
    }
}

impl Flight {
    /// The air of the next step; on the rail and on the ground it is not felt. `known` is the wind that the autopilot
    /// reckons with; none: it sees its way over ground.
    pub fn feel(&mut self, wind: Wind, known: Option<Wind>) {
        if self.contact != Contact::Air {
            self.air = Air { outside: wind, ..Air::at(&self.state) };
            return;
        }
        self.air.outside = wind;
        // A gust from below takes the vehicle along; its altitude loop brings it back.
        self.state.climb_mps += wind.up_mps - self.air.wind.up_mps;
        self.air.wind = wind;
        self.air.known = known.unwrap_or(wind);
        if known.is_none() {
            self.air.astray_m = (0.0, 0.0);
        }
    }

    /// Where and how fast the vehicle believes to be: its true state, unless it has to reckon with a wind that it does not
    /// see.
    pub fn estimate(&self) -> State {
        let Air { wind, known, astray_m: (north_m, east_m), .. } = self.air;
        if known == wind && (north_m, east_m) == (0.0, 0.0) {
            return self.state;
        }
        let moving = self.state.in_air(&wind).over_ground(&known);
        State { x_m: self.state.x_m + north_m, y_m: self.state.y_m + east_m, ..moving }
    }

    /// The airspeed, m/s, that a run on the ground would take off with: against the wind it is faster.
    pub(super) fn lift_off_speed_mps(&self) -> f64 {
        let (sin, cos) = libm::sincos(self.state.course_rad);
        self.state.speed_mps - self.air.outside.north_mps * cos - self.air.outside.east_mps * sin
    }

    /// Speed through the air, m/s, true.
    pub fn airspeed_mps(&self) -> f64 {
        self.in_air().speed_mps
    }

    /// Where its nose points, rad.
    pub fn heading_rad(&self) -> f64 {
        self.in_air().course_rad
    }

    /// The state as the air sees it: airspeed and heading in the place of speed and course over ground.
    pub fn in_air(&self) -> State {
        self.state.in_air(&self.air.wind)
    }

    /// Rate of turn that the loops have flown over the last step, rad/s: what a gust does to the heading is no turn.
    pub fn turn_rate_radps(&self) -> f64 {
        wrap_pi(self.heading_rad() - self.air.before.in_air(&self.air.wind).course_rad) / self.autopilot.step_s()
    }

    /// Acceleration over the last step, (north, east, up) in m/s2.
    pub fn acceleration_mps2(&self) -> [f64; 3] {
        let change_mps = self.state.velocity_mps() - self.air.before.velocity_mps();
        let climb_mps = self.state.climb_mps - self.air.before.climb_mps;
        [change_mps.x, change_mps.y, climb_mps].map(|change| change / self.autopilot.step_s())
    }

    /// Power that the speed asked for needs in level flight, as a share of the motor's greatest.
    pub fn power_needed(&self) -> f64 {
        let share = self.speed.target / self.dynamics.limits.speed_max_mps;
        (share * share * share).clamp(0.0, 1.0)
    }

    /// Power that the motor gives, as a share of its greatest: drag grows with the cube of the airspeed, and a climb costs.
    pub fn power_share(&self) -> f64 {
        let limits = self.dynamics.limits;
        let speed = self.airspeed_mps() / limits.speed_max_mps;
        let climb = self.state.climb_mps / limits.climb_max_mps;
        (speed * speed * speed + 0.5 * climb).clamp(0.0, 1.0)
    }

    /// Bank, rad, of a coordinated turn: the lift's horizontal part is the centripetal force.
    pub fn roll_rad(&self) -> f64 {
        libm::atan(self.airspeed_mps() * self.turn_rate_radps() / self.dynamics.limits.gravity_mps2)
    }

    /// Speed over ground, m/s, by the airspeed that gives it, within the limits.
    pub fn set_ground_speed(&mut self, speed_mps: f64) {
        self.set_speed(speed_mps, f64::INFINITY);
        self.speed_is_over_ground = true;
    }

    /// Heading, rad, turned to with no more than a lateral acceleration in m/s2; the wind carries the course away.
    pub fn set_heading(&mut self, heading_rad: f64, lateral_acceleration_mps2: f64) {
        self.set_course(heading_rad, lateral_acceleration_mps2);
        self.direction = Direction::Heading(heading_rad);
    }

    /// One step without them, on the ground.
    pub(super) fn roll_to(&mut self, state: State) {
        self.air.before = self.state;
        self.state = state;
    }

    /// One step of the loops.
    pub(super) fn fly(&mut self, setpoint: &Setpoint) {
        let (wind, known, step_s) = (self.air.wind, self.air.known, self.autopilot.step_s());
        let setpoint = self.through_the_air(setpoint, self.airspeed_mps());
        self.air.before = self.state;
        self.state = self.autopilot.step_in_wind(&self.state, &setpoint, &wind);
        self.air.astray_m.0 += step_s * (known.north_mps - wind.north_mps);
        self.air.astray_m.1 += step_s * (known.east_mps - wind.east_mps);
    }

    /// A setpoint of what is wanted as airspeed and heading, by the wind triangle. The heading lags behind its setpoint by the
    /// time constant of its loop: the airspeed of then counts, or each gust would turn the course while the airspeed
    /// settles.
    fn through_the_air(&self, setpoint: &Setpoint, airspeed_mps: f64) -> Setpoint {
        let known = self.air.known;
        if known.north_mps == 0.0 && known.east_mps == 0.0 {
            return *setpoint;
        }
        let limits = self.dynamics.limits;
        let mut through = *setpoint;
        if self.speed_is_over_ground {
            let (wanted_mps, _) = known.air_velocity(setpoint.speed_mps, setpoint.course_rad);
            through.speed_mps = wanted_mps.clamp(limits.speed_min_mps, limits.speed_max_mps);
        }
        if !matches!(self.direction, Direction::Heading(_)) {
            let tau = self.dynamics.time_constants;
            let settling_mps = through.speed_mps.clamp(limits.speed_min_mps, limits.speed_max_mps) - airspeed_mps;
            let then_mps = airspeed_mps + settling_mps * (tau.course_s / tau.speed_s).min(1.0);
            through.course_rad = known.heading_rad(setpoint.course_rad, then_mps);
        }
        through
    }
}
