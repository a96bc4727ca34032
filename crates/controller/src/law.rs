//! Eq. 4: the flocking law as a whole, for one vehicle. It sums up the terms; Eq. 2 makes a command of the sum.

use crate::command::Commander;
use crate::terms::Neighbour;
use crate::{Expected, LawSettings, Obstacle, terms};
use flight_model::{Setpoint, State, Wind, course_vector, wrap_pi};

/// The vehicle that a command is for.
pub struct Flown<'a> {
    /// What it can fly.
    pub commander: &'a Commander,
    /// Where and how fast it is over ground.
    pub state: &'a State,
    /// The wind around it: it turns and speeds up in the air.
    pub wind: &'a Wind,
}

/// The setpoint of one vehicle: Eq. 4 with given weights (alpha_f, alpha_o, alpha_nv), then Eq. 2.
pub fn command(
    law: &LawSettings,
    expected: &Expected,
    flown: &Flown<'_>,
    neighbours: &[Neighbour],
    obstacles: &[Obstacle],
    weights: [f64; 3],
) -> Setpoint {
    let Flown { commander, state, wind } = flown;
    let position_m = state.position_m();
    let velocity_mps = course_vector(state.course_rad) * state.speed_mps;
    let air = state.in_air(wind);
    let heading = course_vector(air.course_rad);
    let towards = terms::avoidance_course(law, expected, position_m, heading, obstacles);
    let [alpha_f, alpha_o, alpha_nv] = weights;
    let demand_mps2 = terms::formation(law, position_m, neighbours) * alpha_f
        + terms::collision_avoidance(law, position_m, neighbours)
        + terms::obstacle_avoidance(law, expected.speed_mps, towards, velocity_mps) * alpha_o
        + terms::velocity_consensus(law, position_m, velocity_mps, neighbours) * alpha_nv;
    let (speed_mps, course_change_rad) = commander.horizontal(demand_mps2, air.speed_mps, heading);
    let setpoint = Setpoint {
        speed_mps: commander.asked_mps(speed_mps),
        course_rad: wrap_pi(air.course_rad + course_change_rad),
        altitude_m: commander.altitude_m(law, expected.altitude_m, state),
    };
    commander.over_ground(&setpoint, wind)
}
