//! Where the flock flies: the obstacles and what is expected of every vehicle.

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

/// What the flock is to do (v_e and h_e of the paper).
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
    pub fn direction(&self) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.course_rad);
        (cos, sin)
    }
}

impl Obstacle {
    /// Distance from a point to the edge, m; negative inside.
    pub fn clearance_m(&self, x_m: f64, y_m: f64) -> f64 {
        let (dx, dy) = (self.x_m - x_m, self.y_m - y_m);
        (dx * dx + dy * dy).sqrt() - self.radius_m
    }
}
