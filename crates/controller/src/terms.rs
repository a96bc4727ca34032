//! The control terms of the flocking law, one function each (Eq. 5-10), for one vehicle.
//!
//! This is the law as one reads it. The look-ahead flies the same law for many pigeons at once (`look_ahead.rs`), and
//! its tests hold it to these functions.

use crate::LawSettings;
use flight_model::State;
use nalgebra::Vector2;

/// A neighbour's horizontal position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// P_j, m.
    pub position_m: Vector2<f64>,
    /// v_j, m/s.
    pub velocity_mps: Vector2<f64>,
}

impl Neighbour {
    /// The neighbour that a vehicle in this state is to others.
    pub fn of(state: &State) -> Self {
        Self { position_m: state.position_m(), velocity_mps: state.velocity_mps() }
    }
}

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

/// Eq. 7 without its weight: C_o (V_e (cos delta, sin delta) - v_i), `towards` being the unit vector along delta.
pub fn obstacle_avoidance(
    law: &LawSettings,
    expected_speed_mps: f64,
    towards: Vector2<f64>,
    velocity_mps: Vector2<f64>,
) -> Vector2<f64> {
    (towards * expected_speed_mps - velocity_mps) * law.obstacle_gain
}

/// Eq. 8 without its weight: C_nv sum (v_j - v_i) over the neighbours within D_c.
pub fn neighbour_velocity(
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

/// Eq. 9 and 10: u_ev + u_eh, m/s2.
pub fn vertical(law: &LawSettings, expected_altitude_m: f64, altitude_m: f64, climb_mps: f64) -> f64 {
    law.vertical_velocity_gain * (0.0 - climb_mps) + law.altitude_gain * (expected_altitude_m - altitude_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn neighbour(x: f64, y: f64, vx: f64, vy: f64) -> Neighbour {
        Neighbour { position_m: Vector2::new(x, y), velocity_mps: Vector2::new(vx, vy) }
    }

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

    #[test]
    fn collision_avoidance_starts_at_the_safe_distance_and_points_away() {
        let law = LawSettings::default();
        assert_eq!(collision_avoidance(&law, Vector2::zeros(), &[neighbour(2.0, 0.0, 0.0, 0.0)]), Vector2::zeros());
        let push = collision_avoidance(&law, Vector2::zeros(), &[neighbour(0.0, 1.0, 0.0, 0.0)]);
        assert!((push.y + 1e5 * 0.25).abs() < 1e-6);
    }

    #[test]
    fn two_vehicles_in_one_place_give_finite_demands() {
        let law = LawSettings::default();
        let there = [neighbour(0.0, 0.0, 1.0, 0.0)];
        assert_eq!(formation(&law, Vector2::zeros(), &there), Vector2::zeros());
        assert_eq!(collision_avoidance(&law, Vector2::zeros(), &there), Vector2::zeros());
    }

    #[test]
    fn neighbours_velocities_are_matched() {
        let law = LawSettings::default();
        let demand =
            neighbour_velocity(&law, Vector2::zeros(), Vector2::new(10.0, 0.0), &[neighbour(3.0, 0.0, 9.0, 1.0)]);
        assert!((demand.x + 0.2).abs() < 1e-12 && (demand.y - 0.2).abs() < 1e-12);
    }
}
