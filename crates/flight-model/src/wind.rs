//! Wind: a steady wind, the wind triangle, and a step of the autopilots in moving air.

use crate::{Autopilot, Setpoint, State, course_vector, wrap_pi};
use nalgebra::Vector2;

/// Velocity of the air over ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wind {
    /// Towards north, m/s.
    pub north_mps: f64,
    /// Towards east, m/s.
    pub east_mps: f64,
    /// Upwards, m/s.
    pub up_mps: f64,
}

impl Wind {
    /// Still air.
    pub const CALM: Self = Self { north_mps: 0.0, east_mps: 0.0, up_mps: 0.0 };

    /// A level wind of a speed in m/s, from a direction in rad (from north towards east), as in weather reports.
    pub fn from_direction(speed_mps: f64, from_rad: f64) -> Self {
        let from = course_vector(from_rad) * -speed_mps;
        Self { north_mps: from.x, east_mps: from.y, up_mps: 0.0 }
    }

    /// Its horizontal speed, m/s.
    pub fn speed_mps(&self) -> f64 {
        self.horizontal_mps().norm()
    }

    /// Its horizontal part (north, east), m/s.
    #[inline]
    pub fn horizontal_mps(&self) -> Vector2<f64> {
        Vector2::new(self.north_mps, self.east_mps)
    }

    /// The direction that it comes from, rad in [-pi, pi] from north towards east; 0 for still air.
    pub fn direction_rad(&self) -> f64 {
        // Adding zero turns -0 into 0, whose direction is north.
        libm::atan2(0.0 - self.east_mps + 0.0, 0.0 - self.north_mps + 0.0)
    }

    /// Whether the air is still.
    pub fn is_calm(&self) -> bool {
        *self == Self::CALM
    }

    /// The heading that keeps a course over ground at an airspeed in m/s (the wind triangle). If the wind across the
    /// course is stronger than the airspeed, no heading keeps the course: the result is then the heading that drifts
    /// least.
    pub fn heading_rad(&self, course_rad: f64, airspeed_mps: f64) -> f64 {
        let from_left_mps = course_vector(course_rad).perp(&self.horizontal_mps());
        if from_left_mps == 0.0 {
            return course_rad;
        }
        course_rad - libm::asin((from_left_mps / airspeed_mps.max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0))
    }

    /// Whether a heading exists that flies along a course over ground at an airspeed in m/s.
    pub fn lets_fly(&self, course_rad: f64, airspeed_mps: f64) -> bool {
        let course = course_vector(course_rad);
        let across_mps = course.perp(&self.horizontal_mps());
        let along_mps = course.dot(&self.horizontal_mps());
        let rest = airspeed_mps * airspeed_mps - across_mps * across_mps;
        rest > 0.0 && along_mps + rest.sqrt() > 0.0
    }

    /// The airspeed (m/s) and heading (rad) that give a speed in m/s on a course over ground.
    pub fn air_velocity(&self, speed_mps: f64, course_rad: f64) -> (f64, f64) {
        let air = State { speed_mps, course_rad, ..State::default() }.in_air(self);
        (air.speed_mps, air.course_rad)
    }
}

impl State {
    /// The same state relative to the air: airspeed and heading instead of speed and course over ground. At zero
    /// airspeed the heading is the course.
    pub fn in_air(&self, wind: &Wind) -> State {
        if wind.north_mps == 0.0 && wind.east_mps == 0.0 {
            return *self;
        }
        self.with_velocity(self.velocity_mps() - wind.horizontal_mps())
    }

    /// The inverse of [`in_air`](Self::in_air): speed and course over ground from airspeed and heading.
    pub fn over_ground(&self, wind: &Wind) -> State {
        self.in_air(&Wind { north_mps: -wind.north_mps, east_mps: -wind.east_mps, up_mps: -wind.up_mps })
    }

    fn with_velocity(&self, velocity_mps: Vector2<f64>) -> State {
        let speed_mps = velocity_mps.norm();
        let course_rad =
            if speed_mps > 0.0 { wrap_pi(libm::atan2(velocity_mps.y, velocity_mps.x)) } else { self.course_rad };
        State { speed_mps, course_rad, ..*self }
    }
}

impl Setpoint {
    /// The same as airspeed and heading instead of speed and course over ground: what an autopilot that holds those in
    /// a steady wind settles on.
    pub fn in_air(&self, wind: &Wind) -> Setpoint {
        if wind.north_mps == 0.0 && wind.east_mps == 0.0 {
            return *self;
        }
        let air_mps = course_vector(self.course_rad) * self.speed_mps - wind.horizontal_mps();
        let course_rad = wrap_pi(libm::atan2(air_mps.y, air_mps.x));
        Setpoint { speed_mps: air_mps.norm(), course_rad, ..*self }
    }

    /// The inverse of [`in_air`](Self::in_air).
    pub fn over_ground(&self, wind: &Wind) -> Setpoint {
        self.in_air(&Wind { north_mps: -wind.north_mps, east_mps: -wind.east_mps, up_mps: -wind.up_mps })
    }
}

impl Autopilot {
    /// The state one step later in air that moves with `wind` over the step. The setpoint's speed is an airspeed and
    /// its course a heading: the loops and limits of Eq. 1 and 3 act in the air, which carries the vehicle along. When
    /// the wind changes from one step to the next the speed over ground does not: the airspeed does.
    ///
    /// In still air this is [`step`](Self::step), to the last bit. The wind's vertical part is not felt here.
    pub fn step_in_wind(&self, state: &State, setpoint: &Setpoint, wind: &Wind) -> State {
        if wind.north_mps == 0.0 && wind.east_mps == 0.0 {
            return self.step(state, setpoint);
        }
        let next = self.step(&state.in_air(wind), setpoint).over_ground(wind);
        State { x_m: next.x_m + self.step_s() * wind.north_mps, y_m: next.y_m + self.step_s() * wind.east_mps, ..next }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dynamics;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn cruise(course_rad: f64) -> State {
        State { altitude_m: 50.0, speed_mps: 10.0, course_rad, ..State::default() }
    }

    #[test]
    fn a_setpoint_over_ground_is_one_in_the_air_and_back() {
        let wind = Wind { north_mps: -3.0, east_mps: 4.0, up_mps: 0.0 };
        let over_ground = Setpoint { speed_mps: 9.0, course_rad: 2.0, altitude_m: 50.0 };
        let air = over_ground.in_air(&wind);
        let there = course_vector(air.course_rad) * air.speed_mps + wind.horizontal_mps();
        assert!((there - course_vector(2.0) * 9.0).norm() < 1e-12);
        let back = air.over_ground(&wind);
        assert!((back.speed_mps - 9.0).abs() < 1e-12 && (back.course_rad - 2.0).abs() < 1e-12);
        assert_eq!(over_ground.in_air(&Wind::CALM), over_ground);
    }

    /// Flies a course over ground at an airspeed, with the heading of the triangle at each step.
    fn fly(mut state: State, course_rad: f64, airspeed_mps: f64, wind: &Wind, seconds: usize) -> State {
        let autopilot = Autopilot::new(&Dynamics::default(), 0.01);
        for _ in 0..100 * seconds {
            let heading_rad = wind.heading_rad(course_rad, state.in_air(wind).speed_mps);
            let setpoint = Setpoint { speed_mps: airspeed_mps, course_rad: heading_rad, altitude_m: 50.0 };
            state = autopilot.step_in_wind(&state, &setpoint, wind);
        }
        state
    }

    #[test]
    fn a_wind_is_named_after_where_it_comes_from() {
        let west = Wind::from_direction(6.0, -FRAC_PI_2);
        assert!(west.north_mps.abs() < 1e-12 && (west.east_mps - 6.0).abs() < 1e-12);
        assert!((west.speed_mps() - 6.0).abs() < 1e-12);
        assert!((west.direction_rad() + FRAC_PI_2).abs() < 1e-12);
        assert_eq!(Wind::CALM.direction_rad(), 0.0);
    }

    #[test]
    fn across_the_wind_it_crabs_and_keeps_its_course() {
        let wind = Wind::from_direction(6.0, FRAC_PI_2);
        let end = fly(cruise(0.0), 0.0, 10.0, &wind, 20);
        assert!(end.course_rad.abs() < 1e-6, "{}", end.course_rad);
        assert!((end.speed_mps - 8.0).abs() < 1e-6); // 6, 8, 10
        let air = end.in_air(&wind);
        assert!((air.speed_mps - 10.0).abs() < 1e-6 && (air.course_rad - libm::asin(0.6)).abs() < 1e-6);
    }

    #[test]
    fn with_and_against_the_wind_the_speeds_add_up() {
        let wind = Wind::from_direction(4.0, 0.0);
        assert!((fly(cruise(0.0), 0.0, 10.0, &wind, 20).speed_mps - 6.0).abs() < 1e-6);
        assert!((fly(cruise(PI), PI, 10.0, &wind, 20).speed_mps - 14.0).abs() < 1e-6);
    }

    #[test]
    fn a_wind_too_strong_carries_it_away_and_stays_finite() {
        let wind = Wind::from_direction(20.0, 0.0);
        assert!(!wind.lets_fly(0.0, 10.0) && !wind.lets_fly(FRAC_PI_2, 10.0) && wind.lets_fly(PI, 10.0));
        let end = fly(cruise(0.0), 0.0, 10.0, &wind, 60);
        assert!(end.is_finite());
        assert!((end.speed_mps - 10.0).abs() < 1e-6 && (end.course_rad.abs() - PI).abs() < 1e-6);
        assert!(end.x_m < -400.0);
    }

    proptest! {
        #[test]
        fn the_triangle_closes(
            course in -3.1..3.1f64, airspeed in 5.0..15.0f64, speed in 0.0..4.9f64, from in -3.1..3.1f64,
        ) {
            let wind = Wind::from_direction(speed, from);
            prop_assert!(wind.lets_fly(course, airspeed));
            let heading_rad = wind.heading_rad(course, airspeed);
            let over_ground = course_vector(heading_rad) * airspeed + wind.horizontal_mps();
            prop_assert!(wrap_pi(libm::atan2(over_ground.y, over_ground.x) - course).abs() < 1e-9);
            let (back, again) = wind.air_velocity(over_ground.norm(), course);
            prop_assert!((back - airspeed).abs() < 1e-9 && wrap_pi(again - heading_rad).abs() < 1e-9);
        }

        #[test]
        fn still_air_changes_no_bit(course in -3.1..3.1f64, to in -3.1..3.1f64, speed in 5.0..15.0f64) {
            let autopilot = Autopilot::new(&Dynamics::default(), 0.01);
            let setpoint = Setpoint { speed_mps: speed, course_rad: to, altitude_m: 52.0 };
            let state = cruise(course);
            prop_assert_eq!(autopilot.step_in_wind(&state, &setpoint, &Wind::CALM), autopilot.step(&state, &setpoint));
            prop_assert_eq!(Wind::CALM.heading_rad(to, 10.0).to_bits(), to.to_bits());
            prop_assert_eq!(state.in_air(&Wind::CALM), state);
        }

        #[test]
        fn any_wind_leaves_a_finite_flight(
            course in -3.1..3.1f64, speed in 0.0..60.0f64, from in -3.1..3.1f64, airspeed in 5.0..15.0f64,
        ) {
            let wind = Wind::from_direction(speed, from);
            let end = fly(cruise(-course), course, airspeed, &wind, 3);
            prop_assert!(end.is_finite());
        }
    }
}
