//! Circles, one by one or at random.

use nalgebra::Vector2;
use optimizer::stream;
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// A circle to keep out of.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleTable {
    /// Northing of the centre, m.
    pub x_m: f64,
    /// Easting of the centre, m.
    pub y_m: f64,
    /// Radius, m.
    pub radius_m: f64,
}

/// Circles at random, by the scenario's seed.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ObstaclesTable {
    /// How many.
    pub count: usize,
    /// Least radius, m.
    pub radius_min_m: f64,
    /// Greatest radius, m.
    pub radius_max_m: f64,
    /// Least distance between two edges, m.
    pub gap_m: f64,
    /// Southernmost centre, m.
    pub x_min_m: f64,
    /// Northernmost centre, m.
    pub x_max_m: f64,
    /// Westernmost centre, m.
    pub y_min_m: f64,
    /// Easternmost centre, m.
    pub y_max_m: f64,
}

impl ObstacleTable {
    /// Its centre (north, east), m.
    fn centre_m(&self) -> Vector2<f64> {
        Vector2::new(self.x_m, self.y_m)
    }
}

impl Default for ObstaclesTable {
    fn default() -> Self {
        Self {
            count: 10,
            radius_min_m: 4.0,
            radius_max_m: 14.0,
            gap_m: 14.0,
            x_min_m: 60.0,
            x_max_m: 330.0,
            y_min_m: -50.0,
            y_max_m: 50.0,
        }
    }
}

/// No vehicle has this index: the circles' random numbers are nobody else's.
const NOBODY: u64 = u64::MAX;
/// So often a place is sought for one circle.
const TRIES_MAX: usize = 10_000;

/// The circles of a table, by the seed. Fewer than asked for where the area has no more room, and every circle thrown
/// before that stands.
pub fn scatter(table: &ObstaclesTable, seed: u64) -> Vec<ObstacleTable> {
    let mut rng = stream(seed, NOBODY, 0);
    let mut circles: Vec<ObstacleTable> = Vec::new();
    let mut tries = 0;
    while circles.len() < table.count && tries < TRIES_MAX {
        let radius_m = rng.random_range(table.radius_min_m..=table.radius_max_m);
        let circle = ObstacleTable {
            x_m: rng.random_range(table.x_min_m..=table.x_max_m),
            y_m: rng.random_range(table.y_min_m..=table.y_max_m),
            radius_m,
        };
        tries += 1;
        if circles.iter().all(|other| gap_m(other, &circle) >= table.gap_m) {
            circles.push(circle);
            tries = 0;
        }
    }
    circles
}

/// Between two edges.
fn gap_m(a: &ObstacleTable, b: &ObstacleTable) -> f64 {
    (a.centre_m() - b.centre_m()).norm() - a.radius_m - b.radius_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_keep_their_gap_and_their_area_and_are_others_with_another_seed() {
        let table = ObstaclesTable::default();
        let circles = scatter(&table, 7);
        assert_eq!(circles.len(), 10);
        for (index, a) in circles.iter().enumerate() {
            assert!((table.radius_min_m..=table.radius_max_m).contains(&a.radius_m));
            assert!((table.x_min_m..=table.x_max_m).contains(&a.x_m));
            assert!((table.y_min_m..=table.y_max_m).contains(&a.y_m));
            assert!(circles[..index].iter().all(|b| gap_m(a, b) >= table.gap_m));
        }
        assert_eq!(circles[3].x_m, scatter(&table, 7)[3].x_m);
        assert_ne!(circles[3].x_m, scatter(&table, 8)[3].x_m);
    }

    #[test]
    fn a_full_area_ends_the_search() {
        let circles = scatter(&ObstaclesTable { count: 1000, ..ObstaclesTable::default() }, 1);
        assert!((10..100).contains(&circles.len()), "{}", circles.len());
    }
}
