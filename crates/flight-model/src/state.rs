//! The state of a vehicle and its setpoint.

use nalgebra::Vector2;

/// One vehicle's state (Eq. 1) in the local frame: X north, Y east, altitude up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// North of the origin, m (the paper's X).
    pub x_m: f64,
    /// East of the origin, m (the paper's Y).
    pub y_m: f64,
    /// Above the origin, m (the paper's H).
    pub altitude_m: f64,
    /// Horizontal speed over ground, m/s (the paper's V).
    pub speed_mps: f64,
    /// Course over ground from north towards east, rad, in (-pi, pi] (the paper's phi).
    pub course_rad: f64,
    /// Rate of climb, m/s, up positive (the paper's eta).
    pub climb_mps: f64,
}

/// The setpoints of the three autopilots (V_c, phi_c, H_c of Eq. 1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Horizontal speed, m/s.
    pub speed_mps: f64,
    /// Course over ground from north towards east, rad. Any turn: the autopilot takes the short way round.
    pub course_rad: f64,
    /// Altitude above the origin, m.
    pub altitude_m: f64,
}

impl State {
    /// The setpoint that keeps this speed, course and altitude.
    pub fn hold(&self) -> Setpoint {
        Setpoint { speed_mps: self.speed_mps, course_rad: self.course_rad, altitude_m: self.altitude_m }
    }

    /// Horizontal position (north, east) of the origin, m.
    #[inline]
    pub fn position_m(&self) -> Vector2<f64> {
        Vector2::new(self.x_m, self.y_m)
    }

    /// Horizontal velocity (north, east), m/s.
    #[inline]
    pub fn velocity_mps(&self) -> Vector2<f64> {
        course_vector(self.course_rad) * self.speed_mps
    }

    /// Whether every component is a finite number.
    pub fn is_finite(&self) -> bool {
        [self.x_m, self.y_m, self.altitude_m, self.speed_mps, self.course_rad, self.climb_mps]
            .iter()
            .all(|value| value.is_finite())
    }
}

/// The unit vector (north, east) along a course in rad from north towards east.
#[inline]
pub fn course_vector(course_rad: f64) -> Vector2<f64> {
    let (sin, cos) = libm::sincos(course_rad);
    Vector2::new(cos, sin)
}

impl Setpoint {
    /// Whether every component is a finite number.
    pub fn is_finite(&self) -> bool {
        self.speed_mps.is_finite() && self.course_rad.is_finite() && self.altitude_m.is_finite()
    }
}
