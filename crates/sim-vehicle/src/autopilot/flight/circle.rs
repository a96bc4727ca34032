//! Guidance onto a circle: a vector field of courses.

use flight_model::{Dynamics, State};
use nalgebra::Vector2;
use std::f64::consts::FRAC_PI_2;

/// A circle to fly, clockwise seen from above (as ArduPlane's default) or the other way round.
///
/// Outside and inside the circle the field points back to it: the wanted course is the tangent turned by atan(rate *
/// (distance - radius) / V), so that close by the distance settles with one rate whatever the speed and the radius.
/// That rate is 1/(4 tau) of the course loop, which damps the two together critically. The course loop lags behind a
/// turning setpoint by a time (tau, and half a step for the setpoint being held over it) times the rate of turn: the
/// turn of the circle is fed forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Circle {
    centre: Vector2<f64>,
    radius_m: f64,
    /// 1 clockwise, -1 anticlockwise.
    turn: f64,
    course_time_constant_s: f64,
    course_lag_s: f64,
}

impl Circle {
    /// The circle of `radius_m` round (north, east), anticlockwise if that is below zero, widened if the vehicle could
    /// not turn so tightly at its top speed. The course setpoint will be asked for every `step_s` seconds.
    pub fn new(centre: Vector2<f64>, radius_m: f64, dynamics: &Dynamics, step_s: f64) -> Self {
        let limits = dynamics.limits;
        let tau_s = dynamics.time_constants.course_s;
        let tightest_m = limits.speed_max_mps * limits.speed_max_mps / limits.lateral_acceleration_max_mps2();
        Self {
            centre,
            radius_m: radius_m.abs().max(1.25 * tightest_m),
            turn: if radius_m < 0.0 { -1.0 } else { 1.0 },
            course_time_constant_s: tau_s,
            course_lag_s: step_s / (1.0 - libm::exp(-step_s / tau_s)),
        }
    }

    /// Its radius, m.
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Its radius, m, below zero anticlockwise.
    pub fn signed_radius_m(&self) -> f64 {
        self.turn * self.radius_m
    }

    /// Its centre, (north, east) in m.
    pub fn centre(&self) -> Vector2<f64> {
        self.centre
    }

    /// The course setpoint at a state, rad (any turn).
    pub fn course_rad(&self, state: &State) -> f64 {
        let away = state.position_m() - self.centre;
        let distance_m = away.norm();
        // At the centre every direction leads out: keep the present one.
        let outward_rad = if distance_m > 1e-6 { libm::atan2(away.y, away.x) } else { state.course_rad };
        let rate = 0.25 / self.course_time_constant_s;
        let turn_in = libm::atan(rate * (distance_m - self.radius_m) / state.speed_mps.max(0.1));
        let bearing_rate = state.speed_mps * libm::sin(state.course_rad - outward_rad) / distance_m.max(self.radius_m);
        outward_rad + self.turn * FRAC_PI_2 + self.turn * turn_in + self.course_lag_s * bearing_rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::{Autopilot, Setpoint};
    use proptest::prelude::*;

    fn fly(circle: &Circle, mut state: State, seconds: usize) -> Vec<State> {
        let autopilot = Autopilot::new(&Dynamics::default(), 0.01);
        let mut track = Vec::new();
        for _ in 0..seconds * 100 {
            let setpoint = Setpoint { course_rad: circle.course_rad(&state), ..state.hold() };
            state = autopilot.step(&state, &setpoint);
            track.push(state);
        }
        track
    }

    fn distance(state: &State) -> f64 {
        state.position_m().norm()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn converges_from_anywhere_and_stays(
            x in -300.0..300.0f64, y in -300.0..300.0f64, course in -3.1..3.1f64,
            speed in 5.0..15.0f64, radius in 20.0..100.0f64, turn in prop::sample::select(vec![-1.0, 1.0]),
        ) {
            let circle = Circle::new(Vector2::zeros(), turn * radius, &Dynamics::default(), 0.01);
            let start =
                State { x_m: x, y_m: y, course_rad: course, speed_mps: speed, altitude_m: 50.0, climb_mps: 0.0 };
            let track = fly(&circle, start, 150);
            for state in &track[12_000..] {
                prop_assert!((distance(state) - radius).abs() < 0.05, "{}", distance(state));
                // Clockwise: north turns to east.
                let (sin, cos) = libm::sincos(state.course_rad);
                prop_assert!(turn * (state.x_m * sin - state.y_m * cos) > 0.0);
            }
        }
    }

    #[test]
    fn entered_at_its_centre_it_spirals_out_without_overshoot() {
        let circle = Circle::new(Vector2::zeros(), 60.0, &Dynamics::default(), 0.01);
        let track = fly(&circle, State { speed_mps: 10.0, course_rad: 1.0, ..State::default() }, 60);
        let furthest = track.iter().map(distance).fold(0.0, f64::max);
        assert!(furthest < 60.6, "{furthest}");
        assert!((distance(&track[5_999]) - 60.0).abs() < 0.05);
    }

    #[test]
    fn a_circle_too_tight_to_fly_is_widened() {
        let circle = Circle::new(Vector2::zeros(), 0.1, &Dynamics::default(), 0.01);
        assert!(circle.radius_m > 15.0 * 15.0 / 50.0);
    }
}
