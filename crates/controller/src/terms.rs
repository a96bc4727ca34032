//! The control terms of the flocking law, one function each (Eq. 5-10), for one vehicle.
//!
//! This is the law as one reads it. The look-ahead flies the same law for many pigeons at once (`look_ahead.rs`), and
//! its tests hold it to these functions.

use crate::LawSettings;
use crate::vector::Vec2;
use flight_model::State;

/// A neighbour's horizontal position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// P_j, m.
    pub position_m: Vec2,
    /// v_j, m/s.
    pub velocity_mps: Vec2,
}

impl Neighbour {
    /// The neighbour that a vehicle in this state is to others.
    pub fn of(state: &State) -> Self {
        let (vx_mps, vy_mps) = state.velocity_mps();
        Self { position_m: Vec2::new(state.x_m, state.y_m), velocity_mps: Vec2::new(vx_mps, vy_mps) }
    }
}

/// Eq. 5 without its weight: C_f sum (P_j - P_i) ln(d_ij / D_d) over the neighbours within D_c.
pub fn formation(law: &LawSettings, position_m: Vec2, neighbours: &[Neighbour]) -> Vec2 {
    let mut sum = Vec2::ZERO;
    for neighbour in neighbours {
        let offset = neighbour.position_m - position_m;
        let distance_m = offset.norm();
        if distance_m <= law.communication_distance_m && distance_m > 0.0 {
            sum = sum + offset * libm::log(distance_m / law.desired_distance_m);
        }
    }
    sum * law.formation_gain
}

/// Eq. 6 with the unit vector from j to i (reading 7): C_c sum (1/d_ij - 1/D_s)^2 over the neighbours within D_s.
pub fn collision_avoidance(law: &LawSettings, position_m: Vec2, neighbours: &[Neighbour]) -> Vec2 {
    let mut sum = Vec2::ZERO;
    for neighbour in neighbours {
        let away = position_m - neighbour.position_m;
        let distance_m = away.norm();
        if distance_m <= law.safe_distance_m && distance_m > 0.0 {
            let closeness = 1.0 / distance_m - 1.0 / law.safe_distance_m;
            sum = sum + away * (closeness * closeness / distance_m);
        }
    }
    sum * law.collision_gain
}

/// Eq. 7 without its weight: C_o (V_e (cos delta, sin delta) - v_i), `towards` being the unit vector along delta.
pub fn obstacle_avoidance(law: &LawSettings, expected_speed_mps: f64, towards: Vec2, velocity_mps: Vec2) -> Vec2 {
    (towards * expected_speed_mps - velocity_mps) * law.obstacle_gain
}

/// Eq. 8 without its weight: C_nv sum (v_j - v_i) over the neighbours within D_c.
pub fn neighbour_velocity(law: &LawSettings, position_m: Vec2, velocity_mps: Vec2, neighbours: &[Neighbour]) -> Vec2 {
    let mut sum = Vec2::ZERO;
    for neighbour in neighbours {
        if (neighbour.position_m - position_m).norm() <= law.communication_distance_m {
            sum = sum + (neighbour.velocity_mps - velocity_mps);
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
        Neighbour { position_m: Vec2::new(x, y), velocity_mps: Vec2::new(vx, vy) }
    }

    #[test]
    fn formation_pushes_apart_inside_the_desired_distance() {
        let law = LawSettings::default();
        let push = formation(&law, Vec2::ZERO, &[neighbour(5.0, 0.0, 0.0, 0.0), neighbour(11.0, 0.0, 0.0, 0.0)]);
        assert!((push.x - 0.2 * 5.0 * libm::log(0.5)).abs() < 1e-12, "only the neighbour within D_c acts");
        assert_eq!(push.y, 0.0);
    }

    #[test]
    fn formation_pulls_when_it_sees_farther_than_it_wants() {
        let law = LawSettings { communication_distance_m: 20.0, ..LawSettings::default() };
        assert!(formation(&law, Vec2::ZERO, &[neighbour(15.0, 0.0, 0.0, 0.0)]).x > 0.0);
    }

    #[test]
    fn collision_avoidance_starts_at_the_safe_distance_and_points_away() {
        let law = LawSettings::default();
        assert_eq!(collision_avoidance(&law, Vec2::ZERO, &[neighbour(2.0, 0.0, 0.0, 0.0)]), Vec2::ZERO);
        let push = collision_avoidance(&law, Vec2::ZERO, &[neighbour(0.0, 1.0, 0.0, 0.0)]);
        assert!((push.y + 1e5 * 0.25).abs() < 1e-6);
    }

    #[test]
    fn two_vehicles_in_one_place_give_finite_demands() {
        let law = LawSettings::default();
        let there = [neighbour(0.0, 0.0, 1.0, 0.0)];
        assert_eq!(formation(&law, Vec2::ZERO, &there), Vec2::ZERO);
        assert_eq!(collision_avoidance(&law, Vec2::ZERO, &there), Vec2::ZERO);
    }

    #[test]
    fn neighbours_velocities_are_matched() {
        let law = LawSettings::default();
        let demand = neighbour_velocity(&law, Vec2::ZERO, Vec2::new(10.0, 0.0), &[neighbour(3.0, 0.0, 9.0, 1.0)]);
        assert!((demand.x + 0.2).abs() < 1e-12 && (demand.y - 0.2).abs() < 1e-12);
    }
}
