//! Eq. 4: the flocking law as a whole, for one vehicle. It sums up the terms; Eq. 2 makes a command of the sum.

use crate::command::Commander;
use crate::terms::Neighbour;
use crate::{Expected, LawSettings, Obstacle, terms};
use flight_model::{Setpoint, State, course_vector, wrap_pi};

/// The setpoint of one vehicle: Eq. 4 with given weights (alpha_f, alpha_o, alpha_nv), then Eq. 2.
pub fn command(
    law: &LawSettings,
    expected: &Expected,
    commander: &Commander,
    state: &State,
    neighbours: &[Neighbour],
    obstacles: &[Obstacle],
    weights: [f64; 3],
) -> Setpoint {
    let position_m = state.position_m();
    let heading = course_vector(state.course_rad);
    let velocity_mps = heading * state.speed_mps;
    let towards = terms::avoidance_course(law, expected, position_m, heading, obstacles);
    let [alpha_f, alpha_o, alpha_nv] = weights;
    let demand_mps2 = terms::formation(law, position_m, neighbours) * alpha_f
        + terms::collision_avoidance(law, position_m, neighbours)
        + terms::obstacle_avoidance(law, expected.speed_mps, towards, velocity_mps) * alpha_o
        + terms::velocity_consensus(law, position_m, velocity_mps, neighbours) * alpha_nv;
    let (speed_mps, course_change_rad) = commander.horizontal(demand_mps2, state.speed_mps, heading);
    Setpoint {
        speed_mps: commander.asked_mps(speed_mps),
        course_rad: wrap_pi(state.course_rad + course_change_rad),
        altitude_m: commander.altitude_m(law, expected.altitude_m, state),
    }
}
