//! How the vehicle flies: its modes and what feeds the three autopilot loops. Knows no MAVLink.

mod circle;
mod guidance;
mod ramp;
mod tuning;

pub(crate) use guidance::RallyPlace;
pub(crate) use tuning::{TAKEOFF_ALTITUDE_M, TAKEOFF_TOLERANCE_M, Tuning};

use crate::{Mode, VehicleSettings};
use flight_model::{Autopilot, Dynamics, Setpoint, State, wrap_pi};
use guidance::Direction;
use ramp::Ramp;

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
    rally: Option<RallyPlace>,
    speed: Ramp,
    altitude: Ramp,
    direction: Direction,
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
            rally: None,
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
        let course_rad = self.guide_rad();
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

    fn radius_m(&self) -> f64 {
        if self.mode == Mode::Rtl { self.tuning.rtl_radius_m } else { self.tuning.loiter_radius_m }
    }

    /// Speed and altitude of the modes that need nobody.
    fn fly_by_itself(&mut self) {
        if let Some(speed_mps) = self.tuning.cruise_speed_mps {
            self.set_speed(speed_mps, f64::INFINITY);
        }
        let return_altitude_m = self.rally.map(|rally| rally.altitude_m).or(self.tuning.rtl_altitude_m);
        if let Some(altitude_m) = return_altitude_m.filter(|_| self.mode == Mode::Rtl) {
            self.set_altitude(altitude_m, f64::INFINITY);
        }
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
                self.circle(self.rally.map_or(self.home(), |rally| rally.at), self.tuning.rtl_radius_m);
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
mod tests;
