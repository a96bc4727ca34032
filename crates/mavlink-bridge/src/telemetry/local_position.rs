//! LOCAL_POSITION_NED and back: positions and velocities travel as `f32`, north-east-down from the local origin.
//! [`wire_round`] gives the state that arrives.

use super::{down, up};
use crate::boot_ms;
use crate::dialect::{LOCAL_POSITION_NED_DATA, Message};
use flight_model::{State, course_vector, wrap_pi};
use nalgebra::Vector2;
use std::time::Duration;

/// LOCAL_POSITION_NED (<https://mavlink.io/en/messages/common.html#LOCAL_POSITION_NED>).
///
/// The horizontal velocity is rounded to 2^-20 m/s, about a micrometre a second, before it is rounded to `f32`: only so
/// can the course come back with the same bits when a state that was on the wire is sent on.
pub fn local_position_ned(time_boot: Duration, state: &State) -> Message {
    Message::LOCAL_POSITION_NED(local_position_data(boot_ms(time_boot), state))
}

/// The state in a LOCAL_POSITION_NED. Numbers that are not finite stay so: check [`State::is_finite`] before use.
pub fn state_from_local_position(position: &LOCAL_POSITION_NED_DATA) -> State {
    let (speed_mps, course_rad) = speed_and_course(Vector2::new(position.vx, position.vy).cast());
    State {
        x_m: f64::from(position.x),
        y_m: f64::from(position.y),
        altitude_m: up(position.z),
        speed_mps,
        course_rad,
        climb_mps: up(position.vz),
    }
}

/// The state that [`state_from_local_position`] reads from [`local_position_ned`]: a run in memory rounds with it, to
/// have the same bits as a run over the wire. Rounding twice is the same as once.
pub fn wire_round(state: &State) -> State {
    state_from_local_position(&local_position_data(0, state))
}

fn local_position_data(time_boot_ms: u32, state: &State) -> LOCAL_POSITION_NED_DATA {
    let velocity_mps = wire_velocity(state.speed_mps, state.course_rad);
    LOCAL_POSITION_NED_DATA {
        time_boot_ms,
        x: state.x_m as f32,
        y: state.y_m as f32,
        z: down(state.altitude_m),
        vx: velocity_mps.x,
        vy: velocity_mps.y,
        vz: down(state.climb_mps),
    }
}

/// Velocity (north, east) on the wire, m/s, from speed in m/s and course in rad.
pub(crate) fn wire_velocity(speed_mps: f64, course_rad: f64) -> Vector2<f32> {
    const GRID: f64 = 1_048_576.0; // 2^20: scaling by it is exact
    // Adding zero turns -0 into 0, so that a course along an axis has one sign.
    (course_vector(course_rad) * speed_mps).map(|component_mps| ((component_mps * GRID).round() / GRID + 0.0) as f32)
}

/// Speed in m/s and course in rad, in (-pi, pi], of a velocity (north, east) in m/s.
pub(crate) fn speed_and_course(velocity_mps: Vector2<f64>) -> (f64, f64) {
    (velocity_mps.norm(), wrap_pi(libm::atan2(velocity_mps.y, velocity_mps.x)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn state() -> impl Strategy<Value = State> {
        (-1e5..1e5f64, -1e5..1e5f64, -500.0..5e3f64, 0.0..300.0f64, -10.0..10.0f64, -50.0..50.0f64).prop_map(
            |(x_m, y_m, altitude_m, speed_mps, course_rad, climb_mps)| State {
                x_m,
                y_m,
                altitude_m,
                speed_mps,
                course_rad: wrap_pi(course_rad),
                climb_mps,
            },
        )
    }

    fn bits(state: &State) -> [u64; 6] {
        [state.x_m, state.y_m, state.altitude_m, state.speed_mps, state.course_rad, state.climb_mps].map(f64::to_bits)
    }

    #[test]
    fn courses_along_the_axes_keep_their_bits() {
        use std::f64::consts::{FRAC_PI_2, PI};
        for course_rad in [0.0, FRAC_PI_2, PI, -FRAC_PI_2] {
            let state = State { speed_mps: 9.0, course_rad, ..State::default() };
            assert_eq!(bits(&wire_round(&state)), bits(&state));
        }
        let south_by_the_other_hand = State { speed_mps: 9.0, course_rad: -PI, ..State::default() };
        assert_eq!(wire_round(&south_by_the_other_hand).course_rad, PI);
    }

    #[test]
    fn a_strangers_negative_zero_is_south_by_plus_pi() {
        let position = LOCAL_POSITION_NED_DATA { vx: -3.0, vy: -0.0, ..LOCAL_POSITION_NED_DATA::DEFAULT };
        assert_eq!(state_from_local_position(&position).course_rad, std::f64::consts::PI);
    }

    #[test]
    fn numbers_that_are_not_finite_are_seen_as_such() {
        let mut position = LOCAL_POSITION_NED_DATA::DEFAULT;
        assert!(state_from_local_position(&position).is_finite());
        position.vy = f32::NAN;
        assert!(!state_from_local_position(&position).is_finite());
        let state = State { altitude_m: f64::INFINITY, ..State::default() };
        assert!(!wire_round(&state).is_finite());
    }

    proptest! {
        #[test]
        fn wire_rounding_is_within_single_precision(state in state()) {
            let rounded = wire_round(&state);
            prop_assert!((rounded.x_m - state.x_m).abs() <= 6e-8 * state.x_m.abs());
            prop_assert!((rounded.altitude_m - state.altitude_m).abs() <= 6e-8 * state.altitude_m.abs());
            prop_assert!((rounded.speed_mps - state.speed_mps).abs() <= 1e-6 + 1e-7 * state.speed_mps);
            let cross_m = state.speed_mps * wrap_pi(rounded.course_rad - state.course_rad);
            prop_assert!(cross_m.abs() <= 1e-6 + 1e-7 * state.speed_mps, "{cross_m}");
        }

        #[test]
        fn wire_rounding_twice_is_once(state in state()) {
            let once = wire_round(&state);
            prop_assert_eq!(bits(&wire_round(&once)), bits(&once));
        }

        // Near the axes one component of the velocity is tiny, and the course has the least to hold on to.
        #[test]
        fn wire_rounding_twice_is_once_near_the_axes(axis in 0..4u8, off in -1e-6..1e-6f64, speed in 0.0..20.0f64) {
            let course_rad = wrap_pi(f64::from(axis) * std::f64::consts::FRAC_PI_2 + off);
            let once = wire_round(&State { speed_mps: speed, course_rad, ..State::default() });
            prop_assert_eq!(bits(&wire_round(&once)), bits(&once));
        }
    }
}
