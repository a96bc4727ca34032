//! The field: obstacles, and the expected velocity and altitude of the flock.

use flight_model::course_vector;
use nalgebra::Vector2;

/// A circular obstacle of unlimited height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Centre, north of the origin, m.
    pub x_m: f64,
    /// Centre, east of the origin, m.
    pub y_m: f64,
    /// Radius, m.
    pub radius_m: f64,
}

/// The velocity and altitude that the flock is to fly (v_e and h_e of the paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// V_e, m/s.
    pub speed_mps: f64,
    /// Course, rad from north towards east.
    pub course_rad: f64,
    /// h_e, m above the origin.
    pub altitude_m: f64,
}

impl Expected {
    /// The unit vector along the expected course (north, east).
    #[inline]
    pub fn direction(&self) -> Vector2<f64> {
        course_vector(self.course_rad)
    }
}

impl Obstacle {
    /// Its centre (north, east), m.
    #[inline]
    pub fn centre_m(&self) -> Vector2<f64> {
        Vector2::new(self.x_m, self.y_m)
    }

    /// Distance from a position (north, east), m, to the edge, m; negative inside.
    #[inline]
    pub fn clearance_m(&self, position_m: Vector2<f64>) -> f64 {
        (self.centre_m() - position_m).norm() - self.radius_m
    }
}
