use super::*;
use crate::station::vehicle::track::slant_m;
use flight_model::{Autopilot, Dynamics};
use proptest::prelude::*;

const EXPECTED: Expected = Expected { speed_mps: 20.0, course_rad: 0.3, altitude_m: 50.0 };

fn dynamics() -> Dynamics {
    let mut dynamics = Dynamics::default();
    dynamics.time_constants.course_s = 2.5;
    dynamics.time_constants.speed_s = 2.0;
    (dynamics.limits.speed_min_mps, dynamics.limits.speed_max_mps) = (12.0, 28.0);
    (dynamics.limits.climb_min_mps, dynamics.limits.climb_max_mps) = (-4.0, 4.0);
    dynamics.limits.lateral_overload_max = 1.0;
    dynamics
}

fn starts(count: usize) -> Vec<State> {
    (0..count)
        .map(|k| State {
            x_m: 7.0 * (k % 2) as f64,
            y_m: 44.0 * (k as f64 - 0.5 * (count as f64 - 1.0)),
            altitude_m: 50.0,
            speed_mps: 18.0,
            ..State::default()
        })
        .collect()
}

/// Flies a gathering; gives when it was complete, the least 3-D distance, and where all were then.
fn gathered(starts: &[State], mut states: Vec<State>, obstacles: &[Obstacle]) -> Option<(f64, f64, f64, Vec<State>)> {
    let dynamics = dynamics();
    let autopilot = Autopilot::new(&dynamics, 0.1);
    let mut gather = Gather::new(starts, EXPECTED, obstacles, &dynamics.limits);
    let (mut least_m, mut clearance_m) = (f64::INFINITY, f64::INFINITY);
    let mut setpoints = Vec::new();
    for step in 0..6000 {
        let known: Vec<Option<State>> = states.iter().copied().map(Some).collect();
        if gather.is_complete(&known) {
            return Some((0.1 * f64::from(step), least_m, clearance_m, states));
        }
        if gather.is_past(&known) {
            gather.again();
        }
        if step % 2 == 0 {
            setpoints = gather.step(&known, 0.1 * f64::from(step));
        }
        for (state, setpoint) in states.iter_mut().zip(&setpoints) {
            *state = autopilot.step(state, &setpoint.unwrap());
        }
        for (index, a) in states.iter().enumerate() {
            for b in &states[..index] {
                least_m = least_m.min(slant_m(a, b));
            }
            for circle in obstacles {
                clearance_m = clearance_m.min(circle.clearance_m(a.position_m()));
            }
        }
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn from_anywhere_all_are_at_their_starts_together(
        count in 1..7usize,
        heading in -3.0..3.0f64,
        (x, y) in (-600.0..600.0f64, -600.0..600.0f64),
        turn in -3.0..3.0f64,
    ) {
        check_from_anywhere(count, heading, (x, y), turn)?;
    }
}

/// Its last vehicle was 68 m from its start when the first one was there.
#[test]
fn the_last_one_is_waited_for() {
    check_from_anywhere(3, 1.932, (-576.45, -66.37), 2.887).expect("gathered");
}

/// Homes 60 m apart in a row, airborne at 45 m.
fn check_from_anywhere(
    count: usize,
    heading_rad: f64,
    (x_m, y_m): (f64, f64),
    row_rad: f64,
) -> Result<(), TestCaseError> {
    let starts = starts(count);
    let (sin, cos) = libm::sincos(row_rad);
    let states: Vec<State> = (0..count)
        .map(|k| 60.0 * k as f64)
        .map(|along_m| State {
            x_m: x_m + along_m * cos,
            y_m: y_m + along_m * sin,
            altitude_m: 45.0,
            speed_mps: 20.0,
            course_rad: heading_rad,
            climb_mps: 0.0,
        })
        .collect();
    let (time_s, least_m, _, states) = gathered(&starts, states, &[]).expect("gathered");
    prop_assert!(time_s < 300.0, "{time_s}");
    prop_assert!(least_m > 7.0, "{least_m}");
    for (state, start) in states.iter().zip(&starts) {
        prop_assert!((state.altitude_m - 50.0).abs() < 3.0);
        let off_m = distance_m(state, start);
        prop_assert!(off_m < 60.0, "{off_m}");
        prop_assert!(wrap_pi(state.course_rad - EXPECTED.course_rad).abs() < 0.25);
    }
    for (index, a) in states.iter().enumerate() {
        for b in &states[..index] {
            let apart_m = distance_m(a, b);
            prop_assert!(apart_m > 25.0, "{apart_m}");
        }
    }
    Ok(())
}

#[test]
fn the_way_to_the_lanes_keeps_off_obstacles() {
    let starts = starts(3);
    let obstacles =
        [Obstacle { x_m: 250.0, y_m: 60.0, radius_m: 40.0 }, Obstacle { x_m: 330.0, y_m: -80.0, radius_m: 30.0 }];
    let states: Vec<State> = (0..3)
        .map(|k| State {
            x_m: 500.0,
            y_m: 60.0 * f64::from(k),
            altitude_m: 45.0,
            speed_mps: 20.0,
            course_rad: 0.3,
            climb_mps: 0.0,
        })
        .collect();
    let (_, _, clearance_m, _) = gathered(&starts, states, &obstacles).expect("gathered");
    assert!(clearance_m > 0.0, "{clearance_m}");
}

#[test]
fn while_one_is_on_the_ground_the_others_circle_near_home() {
    let dynamics = dynamics();
    let autopilot = Autopilot::new(&dynamics, 0.1);
    let mut gather = Gather::new(&starts(3), EXPECTED, &[], &dynamics.limits);
    gather.hold(true);
    let home = |k: usize| State { y_m: 60.0 * k as f64, altitude_m: 45.0, speed_mps: 20.0, ..State::default() };
    let mut states = vec![Some(home(0)), Some(home(1)), None];
    let fly = |gather: &mut Gather, states: &mut Vec<Option<State>>, steps: std::ops::Range<u32>| {
        let mut farthest_m: f64 = 0.0;
        for step in steps {
            let setpoints = gather.step(states, 0.1 * f64::from(step));
            for (state, setpoint) in states.iter_mut().zip(setpoints) {
                *state = state.map(|state| autopilot.step(&state, &setpoint.unwrap()));
                farthest_m = state.map_or(farthest_m, |state| farthest_m.max(libm::hypot(state.x_m, state.y_m)));
            }
            if gather.is_complete(states) {
                return (farthest_m, true);
            }
        }
        (farthest_m, false)
    };
    let (farthest_m, is_complete) = fly(&mut gather, &mut states, 0..2400);
    assert!(!is_complete && farthest_m < 800.0, "{farthest_m}");
    assert_eq!([gather.leg(0), gather.leg(1)], [Leg::Hold; 2]);
    states[2] = Some(home(2));
    gather.hold(false);
    assert!(fly(&mut gather, &mut states, 2400..6000).1);
}

#[test]
fn a_vehicle_that_hovers_climbs_straight_up() {
    let mut gather = Gather::new(&starts(2), EXPECTED, &[], &dynamics().limits).with_hovering(|_| true);
    let ground = |y_m: f64| Some(State { y_m, altitude_m: 10.0, speed_mps: 0.2, ..State::default() });
    let setpoints = gather.step(&[ground(0.0), ground(20.0)], 0.0);
    assert!(setpoints.iter().flatten().all(|setpoint| setpoint.speed_mps == 0.0));
}

#[test]
fn heights_differ() {
    let gather = Gather::new(&starts(5), EXPECTED, &[], &dynamics().limits);
    let mut heights: Vec<f64> = (0..5).map(|vehicle| gather.layer_m(vehicle)).collect();
    heights.sort_by(f64::total_cmp);
    assert_eq!(heights, [50.0, 62.0, 74.0, 86.0, 98.0]);
}
