//! One solve, and one tick of a flock: `cargo bench -p controller`.

// A benchmark that cannot start has nothing better to do than say so.
#![allow(clippy::expect_used)]

use controller::{Expected, Flock, FlockSettings, Obstacle};
use divan::{Bencher, black_box};
use flight_model::State;
use std::time::Duration;

fn main() {
    divan::main();
}

/// A flock in rows of five, 6 m apart so that all act on each other, before a field of seven circles.
fn flock(vehicles: usize) -> (Flock, Vec<State>) {
    let circle = |x_m: f64, y_m: f64, radius_m: f64| Obstacle { x_m, y_m, radius_m };
    let settings = FlockSettings {
        obstacles: vec![
            circle(40.0, 12.0, 8.0),
            circle(55.0, -18.0, 10.0),
            circle(100.0, 0.0, 6.0),
            circle(115.0, 24.0, 9.0),
            circle(125.0, -14.0, 12.0),
            circle(135.0, 6.0, 7.0),
            circle(145.0, -32.0, 8.0),
        ],
        ..FlockSettings::new(Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 })
    };
    let state = |i: usize| State {
        x_m: -6.0 * (i / 5) as f64,
        y_m: 6.0 * (i % 5) as f64 - 12.0,
        altitude_m: 50.0,
        speed_mps: 9.0 + 0.3 * (i % 7) as f64,
        course_rad: 0.03 * (i % 5) as f64 - 0.06,
        climb_mps: 0.0,
    };
    (Flock::new(settings, vehicles).expect("default settings"), (0..vehicles).map(state).collect())
}

/// 51 pigeons, 20 iterations, 3 s look-ahead: one vehicle's part of a tick, on one core.
#[divan::bench(args = [4, 8, 16])]
fn solve(bencher: Bencher, neighbours: usize) {
    let (mut flock, states) = flock(neighbours + 1);
    let clock = || Duration::ZERO;
    let mut tick = 0;
    bencher.bench_local(|| {
        tick += 1;
        flock.decide(tick, neighbours / 2, black_box(&states), &clock)
    });
}

/// A whole tick, on all cores.
#[divan::bench(args = [5, 50, 500])]
fn tick(bencher: Bencher, vehicles: usize) {
    let (mut flock, states) = flock(vehicles);
    let clock = || Duration::ZERO;
    let mut tick = 0;
    bencher.bench_local(|| {
        tick += 1;
        flock.tick(tick, black_box(&states), &clock).len()
    });
}
