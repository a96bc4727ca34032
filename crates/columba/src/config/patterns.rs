//! Starts of many vehicles.

use super::file::{Pattern, PatternTable};
use flight_model::{State, course_vector, wrap_pi};
use nalgebra::Vector2;
use optimizer::stream;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// A stream that no tick of a flight draws from.
const BEFORE_THE_FLIGHT: u64 = u64::MAX;

/// The starts of a pattern whose vehicles fly as `like` does, but for the spreads. `seed` places random ones.
pub fn starts(table: &PatternTable, like: &State, seed: u64) -> Vec<State> {
    let centre_m = Vector2::new(table.x_m, table.y_m);
    let ahead = course_vector(like.course_rad);
    let right = Vector2::new(-ahead.y, ahead.x);
    let place = |offset_m: Vector2<f64>| {
        let position_m = centre_m + ahead * offset_m.x + right * offset_m.y;
        State { x_m: position_m.x, y_m: position_m.y, ..*like }
    };
    let places: Vec<State> = match table.pattern {
        Pattern::File => table.places.iter().take(table.count()).map(|place| place.start(centre_m, like)).collect(),
        _ => offsets(table, seed).into_iter().map(place).collect(),
    };
    places
        .into_iter()
        .enumerate()
        .map(|(index, start)| {
            let mut rng = stream(seed, index as u64, BEFORE_THE_FLIGHT);
            let mut spread = |spread: f64| rng.random_range(-spread..=spread);
            State {
                altitude_m: start.altitude_m + spread(table.altitude_spread_m),
                speed_mps: start.speed_mps + spread(table.speed_spread_mps),
                course_rad: wrap_pi(start.course_rad + spread(table.course_spread_deg.to_radians())),
                ..start
            }
        })
        .collect()
}

/// Offsets from the centre (ahead, right), m.
fn offsets(table: &PatternTable, seed: u64) -> Vec<Vector2<f64>> {
    let (count, spacing_m) = (table.count(), table.spacing_m);
    let columns = (count as f64).sqrt().ceil().max(1.0) as usize;
    match table.pattern {
        Pattern::Line => {
            (0..count).map(|i| Vector2::new(0.0, (i as f64 - 0.5 * (count as f64 - 1.0)) * spacing_m)).collect()
        }
        Pattern::Grid => (0..count)
            .map(|i| {
                let (row, column) = ((i / columns) as f64, (i % columns) as f64);
                Vector2::new(-row * spacing_m, (column - 0.5 * (columns as f64 - 1.0)) * spacing_m)
            })
            .collect(),
        Pattern::Wedge => (0..count)
            .map(|i| {
                let rank = i.div_ceil(2) as f64;
                let side = if i % 2 == 1 { -1.0 } else { 1.0 };
                Vector2::new(
                    -rank * spacing_m * std::f64::consts::FRAC_1_SQRT_2,
                    side * rank * spacing_m * std::f64::consts::FRAC_1_SQRT_2,
                )
            })
            .collect(),
        // Its places are the file's.
        Pattern::File => Vec::new(),
        Pattern::Random => random(count, columns as f64 * spacing_m, 0.5 * spacing_m, seed),
    }
}

/// Places in a square, no two nearer than `apart_m`: at half the grid's spacing a square as large as the grid's is
/// never crowded, so that throwing again always ends.
fn random(count: usize, side_m: f64, apart_m: f64, seed: u64) -> Vec<Vector2<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut places: Vec<Vector2<f64>> = Vec::with_capacity(count);
    while places.len() < count {
        let ahead_m = rng.random_range(-side_m..=0.0);
        let place_m = Vector2::new(ahead_m, rng.random_range(-0.5 * side_m..=0.5 * side_m));
        if places.iter().all(|other_m| (other_m - place_m).norm_squared() >= apart_m * apart_m) {
            places.push(place_m);
        }
    }
    places
}
