//! The closest approach of two straight motions: two that cross are nearest between two samples.

use nalgebra::Vector2;

/// Least distance between two vehicles, m, while the offset from one to the other changes evenly from `from_m` to
/// `to_m`.
pub fn closest_approach_m(from_m: Vector2<f64>, to_m: Vector2<f64>) -> f64 {
    let way = to_m - from_m;
    let share = (-from_m.dot(&way) / way.dot(&way).max(1e-12)).clamp(0.0, 1.0);
    (from_m + way * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_that_cross_are_nearest_between_their_samples() {
        let distance_m = |from: [f64; 2], to: [f64; 2]| closest_approach_m(from.into(), to.into());
        assert!((distance_m([-3.0, 1.0], [5.0, 1.0]) - 1.0).abs() < 1e-12);
        assert_eq!(distance_m([3.0, 4.0], [6.0, 8.0]), 5.0);
        assert_eq!(distance_m([3.0, 4.0], [3.0, 4.0]), 5.0);
    }
}
