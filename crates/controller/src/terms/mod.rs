//! The control terms of the flocking law (Eq. 5-10) for one vehicle, one file each.
//!
//! This is the law as one reads it. The look-ahead flies the same law for many pigeons at once (`rollout.rs`), and its
//! tests hold it to these functions.

mod collision_avoidance;
mod formation;
mod obstacle_avoidance;
mod velocity_consensus;
mod vertical;

pub use collision_avoidance::collision_avoidance;
pub use formation::formation;
pub(crate) use obstacle_avoidance::half_angle;
pub use obstacle_avoidance::{avoidance_course, detects, obstacle_avoidance};
pub use velocity_consensus::velocity_consensus;
pub use vertical::vertical;

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

#[cfg(test)]
fn neighbour(x: f64, y: f64, vx: f64, vy: f64) -> Neighbour {
    Neighbour { position_m: Vector2::new(x, y), velocity_mps: Vector2::new(vx, vy) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LawSettings;

    #[test]
    fn two_vehicles_in_one_place_give_finite_demands() {
        let law = LawSettings::default();
        let there = [neighbour(0.0, 0.0, 1.0, 0.0)];
        assert_eq!(formation(&law, Vector2::zeros(), &there), Vector2::zeros());
        assert_eq!(collision_avoidance(&law, Vector2::zeros(), &there), Vector2::zeros());
    }
}
