//! The present against a vehicle that flies the model, behind a link.

use super::*;
use flight_model::Response;
use proptest::prelude::*;

const PERIOD_S: f64 = 0.5;

/// Flies a vehicle on commands that come late or never, and gives the errors of what was foreseen, m.
fn errors_m(dynamics: &Dynamics, delay_s: f64, every: usize, lost: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut present = Present::new(dynamics);
    let model = Autopilot::new(dynamics, STEP_S);
    let mut state = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
    let (mut track, mut commands) = (vec![state], Vec::<(f64, Setpoint)>::new());
    let mut foreseen = Vec::new();
    present.set_command_delay_s(delay_s);
    for step in 0..2_000_usize {
        let now_s = step as f64 * STEP_S;
        if step.is_multiple_of((PERIOD_S / STEP_S) as usize) {
            let tick = step / 50;
            let course_rad = [0.0, 0.6, -0.5, 0.2, 0.9][tick % 5];
            let setpoint = Setpoint { speed_mps: 9.0 + (tick % 3) as f64, course_rad, altitude_m: 50.0 };
            if now_s > 2.0 {
                let acts_s = now_s + present.acts_after_s();
                foreseen.push((acts_s, present.foresee(acts_s).expect("seen").state.position_m()));
            }
            present.command(now_s, &setpoint);
            if !lost(tick) {
                commands.push((now_s + delay_s, setpoint));
            }
        }
        let acting = |dead_s: f64| commands.iter().rev().find(|(at_s, _)| at_s + dead_s <= now_s + 1e-9).map(|c| c.1);
        let response = dynamics.response;
        if let (Some(course), Some(speed)) = (acting(response.course_dead_time_s), acting(response.speed_dead_time_s)) {
            state = model.step(&state, &Setpoint { speed_mps: speed.speed_mps, ..course });
        } else {
            state = model.step(&state, &state.hold());
        }
        track.push(state);
        // What was flown `delay_s` ago is heard now.
        let heard = (step + 1).checked_sub((delay_s / STEP_S).round() as usize);
        if let Some(heard) = heard.filter(|heard| heard.is_multiple_of(every)) {
            present.hear(heard as f64 * STEP_S, &track[heard]);
        }
    }
    let off_m = |&(at_s, position_m): &(f64, nalgebra::Vector2<f64>)| {
        track.get((at_s / STEP_S).round() as usize).map(|there| (there.position_m() - position_m).norm())
    };
    foreseen.iter().filter_map(off_m).collect()
}

fn root_mean_square_m(errors_m: &[f64]) -> f64 {
    (errors_m.iter().map(|off| off * off).sum::<f64>() / errors_m.len() as f64).sqrt()
}

#[test]
fn a_delay_is_flown_through() {
    let errors_m = errors_m(&Dynamics::default(), 0.2, 10, |_| false);
    assert!(root_mean_square_m(&errors_m) < 0.02, "{errors_m:?}");
}

#[test]
fn a_delay_that_becomes_known_later_holds_for_what_was_before() {
    let seen = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
    let turn = Setpoint { course_rad: 0.5, ..seen.hold() };
    let present = |is_known_first: bool| {
        let mut present = Present::new(&Dynamics::default());
        if is_known_first {
            present.set_command_delay_s(0.2);
        }
        // Flown at 1.0 s and heard 0.2 s later.
        present.hear(if is_known_first { 1.0 } else { 1.2 }, &seen);
        present.command(1.2, &turn);
        if !is_known_first {
            present.shift_heard(-0.2);
            present.set_command_delay_s(0.2);
        }
        // What is heard next was flown before the time at which the last state was thought to be.
        present.hear(1.1, &State { x_m: 1.0, ..seen });
        present.at(1.8).expect("it has been seen")
    };
    let (known, learnt) = (present(true), present(false));
    assert!((known.state.position_m() - learnt.state.position_m()).norm() < 1e-9, "{known:?} {learnt:?}");
    assert!((known.age_s - 0.7).abs() < 1e-9 && (learnt.age_s - 0.7).abs() < 1e-9);
}

#[test]
fn dead_times_are_flown_through() {
    let response =
        Response { course_dead_time_s: 0.17, speed_dead_time_s: 0.3, altitude_dead_time_s: 0.4, ..Response::default() };
    let errors_m = errors_m(&Dynamics { response, ..Dynamics::default() }, 0.2, 10, |_| false);
    assert!(root_mean_square_m(&errors_m) < 0.02, "{errors_m:?}");
}

#[test]
fn lost_commands_are_found_out() {
    let lost = |tick: usize| tick % 5 == 2;
    let errors_m = errors_m(&Dynamics::default(), 0.2, 10, lost);
    let nobody_looks = 1.0;
    assert!(root_mean_square_m(&errors_m) < 0.25 * nobody_looks, "{errors_m:?}");
}

#[test]
fn what_is_not_known_grows_with_age() {
    let mut present = Present::new(&Dynamics::default());
    assert_eq!(present.at(0.0), None);
    present.hear(1.0, &State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() });
    let std_m = |at_s: f64| present.at(at_s).expect("seen").position_std_m();
    assert!(std_m(1.0) < std_m(1.5) && std_m(1.5) < std_m(3.0));
    assert_eq!(present.at(0.5).expect("seen").age_s, 0.0, "the past is the last state");
}

#[test]
fn headings_tell_the_turn_between_slow_positions() {
    // A circle of 40 m at 10 m/s, which nobody has commanded.
    let circle = |at_s: f64| State {
        x_m: 40.0 * libm::sin(0.25 * at_s),
        y_m: 40.0 - 40.0 * libm::cos(0.25 * at_s),
        altitude_m: 50.0,
        speed_mps: 10.0,
        course_rad: wrap_pi(0.25 * at_s),
        climb_mps: 0.0,
    };
    let off_m = |with_headings: bool| {
        let mut present = Present::new(&Dynamics::default());
        for step in 0..=29 {
            let at_s = 0.1 * f64::from(step);
            if with_headings {
                present.hear_heading(at_s, 0.25 * at_s + 0.1);
            }
            if step % 10 == 0 {
                present.hear(at_s, &circle(at_s));
            }
        }
        (present.at(2.9).expect("seen").state.position_m() - circle(2.9).position_m()).norm()
    };
    assert!(off_m(false) > 0.9 && off_m(true) < 0.05, "{} {}", off_m(false), off_m(true));
}

#[test]
fn a_bias_is_taken_up_and_the_speed_settles() {
    // The vehicle flies 6 % and 1 m/s faster than asked.
    let mut present = Present::new(&Dynamics::default());
    let mut state = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
    let model = Autopilot::new(&Dynamics::default(), 0.1);
    for step in 0..2_000 {
        let now_s = 0.1 * f64::from(step);
        present.hear(now_s, &state);
        if step % 5 == 0 {
            // Eq. 2 with a gain of 2 for the difference to 10 m/s.
            let speed_mps = present.at(now_s).expect("seen").reference_speed_mps;
            let wanted = Setpoint { speed_mps: speed_mps + 2.0 * (10.0 - speed_mps), ..state.hold() };
            present.command(now_s, &wanted);
        }
        let wanted = present.commands.acting(now_s, &Response::default()).expect("commanded");
        let sent_mps = wanted.speed_mps - present.speed_bias_mps();
        state = model.step(&state, &Setpoint { speed_mps: 1.06 * sent_mps + 1.0, ..wanted });
    }
    assert!((state.speed_mps - 10.0).abs() < 0.02, "{}", state.speed_mps);
    assert!((present.speed_bias_mps() - (1.06 * 10.0 + 1.0 - 10.0) / 1.06).abs() < 0.1);
}

proptest! {
    #[test]
    fn a_prediction_is_finite_whatever_is_heard(
        times in prop::collection::vec((-10.0..10.0f64, -1e3..1e3f64, -50.0..50.0f64), 1..30),
    ) {
        let mut present = Present::new(&Dynamics::default());
        for (index, &(at_s, x_m, speed_mps)) in times.iter().enumerate() {
            present.hear(at_s, &State { x_m, speed_mps, ..State::default() });
            present.hear_heading(at_s, x_m);
            if index % 3 == 0 {
                present.command(at_s, &Setpoint { speed_mps, course_rad: x_m, altitude_m: 0.0 });
            }
            let estimate = present.foresee(at_s + 1.0).expect("something was heard");
            prop_assert!(estimate.state.is_finite() && estimate.position_std_m().is_finite());
        }
    }
}
