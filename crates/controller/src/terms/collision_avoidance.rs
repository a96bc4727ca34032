//! Eq. 6: the collision avoidance term, which pushes neighbours apart that are nearer than the safe distance.

use crate::LawSettings;
use crate::terms::Neighbour;
use nalgebra::Vector2;

/// Eq. 6 with the unit vector from j to i (reading 7): C_c sum (1/d_ij - 1/D_s)^2 over the neighbours within D_s.
pub fn collision_avoidance(law: &LawSettings, position_m: Vector2<f64>, neighbours: &[Neighbour]) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for neighbour in neighbours {
        let away = position_m - neighbour.position_m;
        let distance_m = away.norm();
        if distance_m <= law.safe_distance_m && distance_m > 0.0 {
            let closeness = 1.0 / distance_m - 1.0 / law.safe_distance_m;
            sum += away * (closeness * closeness / distance_m);
        }
    }
    sum * law.collision_gain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::neighbour;

    #[test]
    fn collision_avoidance_starts_at_the_safe_distance_and_points_away() {
        let law = LawSettings::default();
        assert_eq!(collision_avoidance(&law, Vector2::zeros(), &[neighbour(2.0, 0.0, 0.0, 0.0)]), Vector2::zeros());
        let push = collision_avoidance(&law, Vector2::zeros(), &[neighbour(0.0, 1.0, 0.0, 0.0)]);
        assert!((push.y + 1e5 * 0.25).abs() < 1e-6);
    }
}
