//! Evasion: other commands where the law leads too near to something.
//!
//! The weights span only the commands that the law can give, and each vehicle chooses its weights without knowing those
//! of the others. Where the commands together lead too near to something, a vehicle tries other commands: a grid of
//! speeds and course changes, each flown for one control period and followed by the law. It takes the mildest of the
//! commands with the least shortfall.

use crate::command::Commander;
use crate::look_ahead::{Commands, LookAhead, Scene};
use crate::rollout::{BATCH, Rollout};

/// Course changes, as shares of the greatest, from the mildest to the hardest. To the right first, as the rules of the
/// air have it for two that meet.
const COURSES: [f64; 9] = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0];
/// Speeds, as shares of the way from the present one to the slowest (negative) or the fastest.
const SPEEDS: [f64; 7] = [0.0, 0.33, -0.33, 0.67, -0.67, 1.0, -1.0];

/// A vehicle turns to a side if its last command asks for more than this, rad.
const TURNING_LEAST_RAD: f64 = 0.05;

/// What a vehicle is asked for at present.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Airspeed, m/s, and change of heading, rad, that the law gives.
    pub by_law: (f64, f64),
    /// A turn to the other side has to be better by this, m.
    pub side_m: f64,
}

impl Asked {
    /// By how much a change of heading has to be better because it turns to another side than the last command still
    /// asks for, m.
    fn handicap_m(&self, change_rad: f64, turning_rad: f64) -> f64 {
        let turns = |rad: f64| rad.abs() > TURNING_LEAST_RAD;
        let is_other = turns(turning_rad) && turns(change_rad) && change_rad * turning_rad < 0.0;
        if is_other { self.side_m } else { 0.0 }
    }
}

/// A horizontal command, of airspeed and heading, and its predicted shortfall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evasion {
    pub speed_setpoint_mps: f64,
    pub course_change_rad: f64,
    /// By how much the flight falls short of the constraints.
    pub violation_m: f64,
}

/// The command that falls short of the constraints least: that of the law, or the mildest of the grid that is better.
pub fn evade(
    look_ahead: &LookAhead,
    commander: &Commander,
    scene: &Scene<'_>,
    weights: [f64; 3],
    asked: &Asked,
    rollout: &mut Rollout,
) -> Evasion {
    let speed_mps = scene.state.in_air(&scene.wind).speed_mps;
    let turning_rad = scene.standing.map(|standing| standing.turn_rad);
    let mut commands =
        Commands { speed_setpoint_mps: [asked.by_law.0; BATCH], course_change_rad: [asked.by_law.1; BATCH] };
    let grid = COURSES.iter().flat_map(|course| SPEEDS.iter().map(move |speed| (course, speed)));
    let mut count = 1;
    for (&course, &speed) in grid.take(BATCH - 1) {
        let limit_mps = if speed < 0.0 { commander.speed_min_mps } else { commander.speed_max_mps };
        let setpoint_mps = speed_mps + speed.abs() * (limit_mps - speed_mps);
        commands.speed_setpoint_mps[count] = setpoint_mps;
        let change_rad = course * commander.course_bound_rad(speed_mps, setpoint_mps);
        commands.course_change_rad[count] = commander.bounded_rad(change_rad, speed_mps, setpoint_mps, turning_rad);
        count += 1;
    }
    let shortfalls_m = look_ahead.try_commands(scene, &commands, weights, count, rollout);
    let costs_m = |index: usize| {
        shortfalls_m[index] + asked.handicap_m(commands.course_change_rad[index], turning_rad.unwrap_or(0.0))
    };
    let mut best = (0, costs_m(0));
    for index in 1..count {
        // Less than a millimetre of gain does not justify a harder command.
        if costs_m(index) < best.1 - 1e-3 {
            best = (index, costs_m(index));
        }
    }
    Evasion {
        speed_setpoint_mps: commands.speed_setpoint_mps[best.0],
        course_change_rad: commands.course_change_rad[best.0],
        violation_m: shortfalls_m[best.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Standing;
    use crate::{Expected, LawSettings, LookAheadSettings, Obstacle};
    use flight_model::{Dynamics, State, Wind};

    /// The course change of an evasion of a circle dead ahead, a little to the right of it.
    fn change_rad(turning_rad: f64, side_m: f64) -> f64 {
        let (law, dynamics) = (LawSettings::default(), Dynamics::default());
        let look_ahead = LookAhead::new(&law, &LookAheadSettings::default(), &dynamics, 0.5);
        let commander = Commander::new(&law, &dynamics, 0.5);
        let obstacles = [Obstacle { x_m: 12.0, y_m: -0.1, radius_m: 4.0 }];
        let scene = Scene {
            state: State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() },
            wind: Wind::CALM,
            standing: Some(Standing { speed_mps: 10.0, turn_rad: turning_rad }),
            expected: Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 },
            obstacles: &obstacles,
            close_obstacles: &obstacles,
            detected: true,
            neighbours: &[],
            margin_m: 0.0,
            neighbour_margins_m: &[],
        };
        let asked = Asked { by_law: (10.0, 0.0), side_m };
        let mut rollout = Box::new(Rollout::new());
        evade(&look_ahead, &commander, &scene, [1.0; 3], &asked, &mut rollout).course_change_rad
    }

    #[test]
    fn an_evasion_keeps_its_side_unless_the_other_one_is_much_better() {
        assert!(change_rad(0.0, 5.0) > 0.1, "to the free side");
        assert!(change_rad(-0.5, 0.0) > 0.1, "whatever was asked before");
        assert!(change_rad(-0.5, 5.0) < -0.1, "but not where sides are kept");
    }
}
