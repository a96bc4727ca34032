//! A flight loop of one's own: five vehicles fly past two obstacles, and the loop measures what it wants to know.
//! `cargo run --release -p controller --example 1_own_loop`

use controller::{Expected, Flock, FlockSettings, Obstacle};
use flight_model::{Autopilot, Dynamics, State};
use std::time::Instant;

/// The integration step of the vehicles, s. A control period is a whole number of steps.
const STEP_S: f64 = 0.01;
const DURATION_S: f64 = 30.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // What the flock is to do, and what is in its way.
    let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
    let settings = FlockSettings {
        obstacles: vec![
            Obstacle { x_m: 90.0, y_m: 6.0, radius_m: 10.0 },
            Obstacle { x_m: 190.0, y_m: -14.0, radius_m: 12.0 },
        ],
        ..FlockSettings::new(expected)
    };
    let (obstacles, period_s) = (settings.obstacles.clone(), settings.control_period_s);

    // Five vehicles in a line abreast, each with another speed and course.
    let mut states: Vec<State> = (0..5_u8)
        .map(|vehicle| {
            let place = f64::from(vehicle) - 2.0;
            let (speed_mps, course_rad) = (9.0 + 0.5 * place, 0.1 * place);
            State { y_m: 10.0 * place, altitude_m: 50.0, speed_mps, course_rad, ..State::default() }
        })
        .collect();

    let mut flock = Flock::new(settings, states.len())?;
    let autopilot = Autopilot::new(&Dynamics::default(), STEP_S);
    let steps = (period_s / STEP_S).round() as u64;
    let started = Instant::now();
    let (mut min_separation_m, mut min_clearance_m) = (f64::INFINITY, f64::INFINITY);

    println!("  t, s   mean x, m   spread, m   separation, m   clearance, m");
    for tick in 0..(DURATION_S / period_s) as u64 {
        // One call per control period: the states of all vehicles in, a setpoint for each of them out.
        let decisions = flock.tick(tick, &states, &|| started.elapsed());

        // The loop flies the vehicles, and judges at every step: between two ticks a vehicle moves 5 m.
        for _ in 0..steps {
            for (state, decision) in states.iter_mut().zip(decisions) {
                *state = autopilot.step(state, &decision.setpoint);
            }
            min_separation_m = min_separation_m.min(separation_m(&states));
            min_clearance_m = min_clearance_m.min(clearance_m(&states, &obstacles));
        }
        if tick % 10 == 9 {
            let mean_x_m = states.iter().map(|state| state.x_m).sum::<f64>() / states.len() as f64;
            let time_s = (tick + 1) as f64 * period_s;
            let (spread_m, apart_m) = (spread_m(&states), separation_m(&states));
            let clear_m = clearance_m(&states, &obstacles);
            println!("{time_s:6.1}   {mean_x_m:9.1}   {spread_m:9.1}   {apart_m:13.1}   {clear_m:12.1}");
        }
    }
    println!("least separation {min_separation_m:.2} m, least clearance {min_clearance_m:.2} m");
    if min_separation_m < 1.0 || min_clearance_m < 0.0 {
        return Err("the flock collided".into());
    }
    Ok(())
}

/// The least distance between two vehicles, m.
fn separation_m(states: &[State]) -> f64 {
    let pairs = states.iter().enumerate().flat_map(|(i, a)| states[..i].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| (a.position_m() - b.position_m()).norm()).fold(f64::INFINITY, f64::min)
}

/// The least distance of a vehicle from the edge of an obstacle, m.
fn clearance_m(states: &[State], obstacles: &[Obstacle]) -> f64 {
    let pairs = states.iter().flat_map(|state| obstacles.iter().map(move |obstacle| (state, obstacle)));
    pairs.map(|(state, obstacle)| obstacle.clearance_m(state.position_m())).fold(f64::INFINITY, f64::min)
}

/// The greatest distance between two vehicles, m.
fn spread_m(states: &[State]) -> f64 {
    let pairs = states.iter().enumerate().flat_map(|(i, a)| states[..i].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| (a.position_m() - b.position_m()).norm()).fold(0.0, f64::max)
}
