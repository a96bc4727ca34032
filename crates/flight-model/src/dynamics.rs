//! The constants of Eq. 1 and the limits of Eq. 3, with the paper's values as defaults.

use crate::{RangeError, Ranges};

/// Time constants of the three autopilots (Eq. 1), in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeConstants {
    /// Speed hold, first order (tau_V).
    pub speed_s: f64,
    /// Course hold, first order (tau_phi).
    pub course_s: f64,
    /// Altitude hold, second order: the fast pole (tau_a).
    pub altitude_a_s: f64,
    /// Altitude hold, second order: the slow pole (tau_b).
    pub altitude_b_s: f64,
}

/// Limits of the vehicle (Eq. 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least horizontal speed, m/s.
    pub speed_min_mps: f64,
    /// Greatest horizontal speed, m/s.
    pub speed_max_mps: f64,
    /// Least rate of climb, m/s (negative: descent).
    pub climb_min_mps: f64,
    /// Greatest rate of climb, m/s.
    pub climb_max_mps: f64,
    /// Greatest lateral overload n_max, in units of g. The paper gives no value; 5 is our reading 2.
    pub lateral_overload_max: f64,
    /// Gravitational acceleration, m/s2; the paper prints 10.
    pub gravity_mps2: f64,
}

/// How a real autopilot differs from Eq. 1. The defaults are Eq. 1 as printed, to the last bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Ground speed that the speed loop settles on, as a share of its setpoint.
    pub speed_gain: f64,
    /// A new speed setpoint acts after this, s.
    pub speed_dead_time_s: f64,
    /// A new course setpoint acts after this, s.
    pub course_dead_time_s: f64,
    /// A new altitude setpoint acts after this, s.
    pub altitude_dead_time_s: f64,
    /// The course loop's time constant is that of [`TimeConstants`] at this speed, m/s, and grows in proportion to
    /// speed; none: the same at every speed.
    pub course_reference_speed_mps: Option<f64>,
    /// Fastest change of speed, m/s2; infinite: as fast as the speed loop asks for.
    pub acceleration_max_mps2: f64,
    /// Turns are Eq. 1 up to this course error, rad: a controller asks for no more at once.
    pub course_step_max_rad: f64,
    /// Lateral acceleration in a steady turn, as a share of that of a coordinated turn with the same bank.
    pub turn_share: f64,
}

/// All that distinguishes one vehicle's dynamics from another's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dynamics {
    /// Time constants of Eq. 1.
    pub time_constants: TimeConstants,
    /// Limits of Eq. 3.
    pub limits: Limits,
    /// What Eq. 1 leaves out.
    pub response: Response,
}

impl Default for TimeConstants {
    /// Section 4 of the paper.
    fn default() -> Self {
        Self { speed_s: 1.0, course_s: 0.75, altitude_a_s: 1.0 / 3.0, altitude_b_s: 3.0 }
    }
}

impl Default for Response {
    /// Eq. 1 as printed.
    fn default() -> Self {
        Self {
            speed_gain: 1.0,
            speed_dead_time_s: 0.0,
            course_dead_time_s: 0.0,
            altitude_dead_time_s: 0.0,
            course_reference_speed_mps: None,
            acceleration_max_mps2: f64::INFINITY,
            course_step_max_rad: std::f64::consts::PI,
            turn_share: 1.0,
        }
    }
}

impl Default for Limits {
    /// Section 4 of the paper; n_max is reading 2.
    fn default() -> Self {
        Self {
            speed_min_mps: 5.0,
            speed_max_mps: 15.0,
            climb_min_mps: -6.0,
            climb_max_mps: 6.0,
            lateral_overload_max: 5.0,
            gravity_mps2: 10.0,
        }
    }
}

impl TimeConstants {
    /// Every time constant that is out of its range, by the name that a scenario file gives it.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        for (name, value) in [
            ("speed_time_constant_s", self.speed_s),
            ("course_time_constant_s", self.course_s),
            ("altitude_time_constant_a_s", self.altitude_a_s),
            ("altitude_time_constant_b_s", self.altitude_b_s),
        ] {
            ranges.within(name, value, 0.02, 60.0);
        }
        ranges.errors()
    }
}

impl Response {
    /// Every constant that is out of its range, by the name that a scenario file gives it.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        ranges.within("speed_gain", self.speed_gain, 0.2, 5.0);
        for (name, value) in [
            ("speed_dead_time_s", self.speed_dead_time_s),
            ("course_dead_time_s", self.course_dead_time_s),
            ("altitude_dead_time_s", self.altitude_dead_time_s),
        ] {
            ranges.within(name, value, 0.0, 10.0);
        }
        if let Some(speed_mps) = self.course_reference_speed_mps {
            ranges.within("course_reference_speed_mps", speed_mps, 0.1, 300.0);
        }
        if self.acceleration_max_mps2.is_finite() {
            ranges.within("acceleration_max_mps2", self.acceleration_max_mps2, 0.01, 1e3);
        }
        ranges.within("course_step_max_deg", self.course_step_max_rad.to_degrees(), 1.0, 180.0);
        ranges.within("turn_share", self.turn_share, 0.1, 3.0);
        ranges.errors()
    }
}

impl Dynamics {
    /// Time constant of the course loop at a speed, s.
    pub fn course_time_constant_s(&self, speed_mps: f64) -> f64 {
        match self.response.course_reference_speed_mps {
            // Near standstill a loop that turns at once would leave no time to integrate it in.
            Some(reference_mps) => self.time_constants.course_s * (speed_mps / reference_mps).max(0.1),
            None => self.time_constants.course_s,
        }
    }

    /// Greatest lateral acceleration that turns the vehicle, m/s2: its share of n_max g.
    pub fn turn_acceleration_max_mps2(&self) -> f64 {
        self.response.turn_share * self.limits.lateral_acceleration_max_mps2()
    }

    /// Greatest rate of turn at a speed in m/s, rad/s: n_max g / V (Eq. 3), or the vehicle's share of it.
    pub fn turn_rate_max_radps(&self, speed_mps: f64) -> f64 {
        self.turn_acceleration_max_mps2() / speed_mps
    }

    /// Every constant that is out of its range, by the name that a scenario file gives it.
    pub fn check(&self) -> Vec<RangeError> {
        let Self { time_constants, limits, response } = self;
        let mut ranges = Ranges::default();
        ranges.extend(time_constants.check());
        ranges.within("speed_min_mps", limits.speed_min_mps, 0.1, 300.0);
        ranges.above("speed_max_mps", limits.speed_max_mps, limits.speed_min_mps, 300.0);
        ranges.within("climb_min_mps", limits.climb_min_mps, -100.0, -0.1);
        ranges.within("climb_max_mps", limits.climb_max_mps, 0.1, 100.0);
        ranges.within("lateral_overload_max", limits.lateral_overload_max, 0.1, 20.0);
        ranges.within("gravity_mps2", limits.gravity_mps2, 1.0, 20.0);
        ranges.extend(response.check());
        ranges.errors()
    }
}

impl Limits {
    /// Greatest lateral acceleration n_max g, m/s2.
    pub fn lateral_acceleration_max_mps2(&self) -> f64 {
        self.lateral_overload_max * self.gravity_mps2
    }
}
