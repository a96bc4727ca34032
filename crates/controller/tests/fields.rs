//! Random fields, flown: whatever the field, nobody hits anything and everybody gets through.

mod flight;

use controller::{Expected, FlockSettings, Obstacle};
use flight::fly;
use flight_model::State;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The least gap between circles, m.
const GAP_M: f64 = 14.0;

/// 7 to 14 circles of 4 to 14 m, and vehicles at random before them.
fn field(seed: u64, vehicles: usize) -> (FlockSettings, Vec<State>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = rng.random_range(7..=14);
    let mut obstacles: Vec<Obstacle> = Vec::new();
    while obstacles.len() < count {
        let radius_m = rng.random_range(4.0..14.0);
        let circle =
            Obstacle { x_m: rng.random_range(45.0 + radius_m..330.0), y_m: rng.random_range(-50.0..50.0), radius_m };
        if obstacles.iter().all(|other| other.clearance_m(circle.x_m, circle.y_m) - radius_m >= GAP_M) {
            obstacles.push(circle);
        }
    }
    let half_width_m = 4.0 * vehicles as f64;
    let mut starts: Vec<State> = Vec::new();
    while starts.len() < vehicles {
        let start = State {
            x_m: rng.random_range(-20.0..20.0),
            y_m: rng.random_range(-half_width_m..half_width_m),
            altitude_m: rng.random_range(35.0..65.0),
            speed_mps: rng.random_range(5.0..15.0),
            course_rad: rng.random_range(-0.5..0.5),
            climb_mps: 0.0,
        };
        let apart = |other: &State| {
            let (dx, dy) = (other.x_m - start.x_m, other.y_m - start.y_m);
            dx * dx + dy * dy > 25.0
        };
        if starts.iter().all(apart) {
            starts.push(start);
        }
    }
    let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
    (FlockSettings { obstacles, seed, ..FlockSettings::new(expected) }, starts)
}

fn gets_through(seed: u64, vehicles: usize) {
    let (settings, starts) = field(seed, vehicles);
    let flown = fly(&settings, &starts, 92);
    let told = format!("seed {seed}, {vehicles} vehicles: {:?} {:?}", flown.min_separation_m, flown.min_clearance_m);
    assert!(flown.min_clearance_m > 0.0, "an obstacle was hit: {told}");
    assert!(flown.min_separation_m > settings.controller.law.safe_distance_m, "separation was lost: {told}");
    let last_m = settings.obstacles.iter().map(|circle| circle.x_m + circle.radius_m).fold(0.0, f64::max);
    assert!(flown.states.iter().all(|state| state.x_m > last_m), "somebody stayed behind: {told}");
    assert!(flown.states.iter().all(|state| (state.altitude_m - 50.0).abs() < 0.1), "altitude unsettled: {told}");
}

#[test]
fn five_vehicles_get_through_random_fields() {
    (1..=8).for_each(|seed| gets_through(seed, 5));
}

#[test]
fn twelve_vehicles_get_through_random_fields() {
    (101..=104).for_each(|seed| gets_through(seed, 12));
}
