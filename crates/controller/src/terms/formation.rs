//! Eq. 5: the formation term, which keeps neighbours at the desired distance.

use crate::LawSettings;
use crate::terms::Neighbour;
use nalgebra::Vector2;

/// Eq. 5 without its weight: C_f sum (P_j - P_i) ln(d_ij / D_d) over the neighbours within D_c.
pub fn formation(law: &LawSettings, position_m: Vector2<f64>, neighbours: &[Neighbour]) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for neighbour in neighbours {
        let offset = neighbour.position_m - position_m;
        let distance_m = offset.norm();
        if distance_m <= law.communication_distance_m && distance_m > 0.0 {
            sum += offset * libm::log(distance_m / law.desired_distance_m);
        }
    }
    sum * law.formation_gain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::neighbour;

    #[test]
    fn formation_pushes_apart_inside_the_desired_distance() {
        let law = LawSettings::default();
        let push = formation(&law, Vector2::zeros(), &[neighbour(5.0, 0.0, 0.0, 0.0), neighbour(11.0, 0.0, 0.0, 0.0)]);
        assert!((push.x - 0.2 * 5.0 * libm::log(0.5)).abs() < 1e-12, "only the neighbour within D_c acts");
        assert_eq!(push.y, 0.0);
    }

    #[test]
    fn formation_pulls_when_it_sees_farther_than_it_wants() {
        let law = LawSettings { communication_distance_m: 20.0, ..LawSettings::default() };
        assert!(formation(&law, Vector2::zeros(), &[neighbour(15.0, 0.0, 0.0, 0.0)]).x > 0.0);
    }
}
