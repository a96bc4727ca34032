//! Eq. 4: the flocking law as a whole, for one vehicle. It sums up the terms; Eq. 2 makes a command of the sum.

use crate::command::Commander;
use crate::polynomial::SINCOS_RANGE_RAD;
use crate::terms::Neighbour;
use crate::{Expected, LawSettings, Obstacle, SideRule, terms};
use flight_model::{Setpoint, State, Wind, course_vector, wrap_pi};

/// The vehicle that a command is for.
pub struct Flown<'a> {
    /// What it can fly.
    pub commander: &'a Commander,
    /// Where and how fast it is over ground.
    pub state: &'a State,
    /// The wind around it: it turns and speeds up in the air.
    pub wind: &'a Wind,
    /// The heading that its last command asked for, rad; none before the first command.
    pub last_heading_rad: Option<f64>,
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
    let Flown { commander, state, wind, last_heading_rad } = flown;
    let position_m = state.position_m();
    let velocity_mps = course_vector(state.course_rad) * state.speed_mps;
    let air = state.in_air(wind);
    let heading = course_vector(air.course_rad);
    let asked_rad = last_heading_rad.map(|last_rad| wrap_pi(last_rad - air.course_rad));
    let from = match law.side_rule {
        SideRule::Auto | SideRule::Course => heading,
        SideRule::Command => {
            course_vector(air.course_rad + asked_rad.unwrap_or(0.0).clamp(-SINCOS_RANGE_RAD, SINCOS_RANGE_RAD))
        }
    };
    let towards = terms::avoidance_course(law, expected, position_m, heading, from, obstacles);
    let [alpha_f, alpha_o, alpha_nv] = weights;
    let demand_mps2 = terms::formation(law, position_m, neighbours) * alpha_f
        + terms::collision_avoidance(law, position_m, neighbours)
        + terms::obstacle_avoidance(law, expected.speed_mps, towards, velocity_mps) * alpha_o
        + terms::velocity_consensus(law, position_m, velocity_mps, neighbours) * alpha_nv;
    let (speed_mps, course_change_rad) = commander.horizontal(demand_mps2, air.speed_mps, heading, asked_rad);
    let setpoint = Setpoint {
        speed_mps: commander.asked_mps(speed_mps),
        course_rad: wrap_pi(air.course_rad + course_change_rad),
        altitude_m: commander.altitude_m(law, expected.altitude_m, state),
    };
    commander.over_ground(&setpoint, wind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FlockSettings, LawSettings};
    use flight_model::Dynamics;

    /// The course change that the law asks for before a circle that is a little to the right.
    fn change_rad(side_rule: SideRule, last_heading_rad: f64) -> f64 {
        let law = LawSettings { side_rule, ..LawSettings::default() };
        let commander = Commander::new(&law, &Dynamics::default(), 0.5);
        let state = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
        let flown =
            Flown { commander: &commander, state: &state, wind: &Wind::CALM, last_heading_rad: Some(last_heading_rad) };
        let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
        let obstacles = [Obstacle { x_m: 50.0, y_m: 0.5, radius_m: 8.0 }];
        command(&law, &expected, &flown, &[], &obstacles, [1.0; 3]).course_rad
    }

    #[test]
    fn a_vehicle_that_turns_to_a_side_goes_on_to_do_so() {
        assert!(change_rad(SideRule::Course, 0.3) < 0.0, "the smaller turn is to the left");
        assert!(change_rad(SideRule::Command, 0.3) > 0.0, "it turns to the right already");
        assert!(change_rad(SideRule::Command, -0.3) < 0.0);
    }

    #[test]
    fn the_side_is_kept_where_vehicles_answer_late_unless_a_scenario_says_otherwise() {
        let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
        let law = FlockSettings::new(expected).behind_a_link(0.05).controller.law;
        assert!(law.side_rule == SideRule::Auto && law.command_cost_s == 0.0);
        let mut late = FlockSettings::new(expected);
        late.dynamics[0].response.course_dead_time_s = 0.2;
        for late in [late.clone().behind_a_link(0.0), FlockSettings::new(expected).behind_a_link(0.2)] {
            let law = late.controller.law;
            assert!(law.side_rule == SideRule::Command && law.command_cost_s > 0.0);
        }
        let printed = FlockSettings { controller: crate::ControllerSettings::paper(), ..late };
        let law = printed.behind_a_link(0.2).controller.law;
        assert!(law.side_rule == SideRule::Course && law.command_cost_s == 0.0);
    }
}
