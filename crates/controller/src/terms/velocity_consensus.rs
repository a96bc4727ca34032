//! Eq. 8: the velocity consensus term, which matches the velocity of the neighbours.

use crate::LawSettings;
use crate::terms::Neighbour;
use nalgebra::Vector2;

/// Eq. 8 without its weight: C_nv sum (v_j - v_i) over the neighbours within D_c.
pub fn velocity_consensus(
    law: &LawSettings,
    position_m: Vector2<f64>,
    velocity_mps: Vector2<f64>,
    neighbours: &[Neighbour],
) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for neighbour in neighbours {
        if (neighbour.position_m - position_m).norm() <= law.communication_distance_m {
            sum += neighbour.velocity_mps - velocity_mps;
        }
    }
    sum * law.neighbour_velocity_gain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::neighbour;

    #[test]
    fn neighbours_velocities_are_matched() {
        let law = LawSettings::default();
        let demand =
            velocity_consensus(&law, Vector2::zeros(), Vector2::new(10.0, 0.0), &[neighbour(3.0, 0.0, 9.0, 1.0)]);
        assert!((demand.x + 0.2).abs() < 1e-12 && (demand.y - 0.2).abs() < 1e-12);
    }
}
