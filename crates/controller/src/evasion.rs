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

/// A horizontal command and its predicted shortfall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evasion {
    pub speed_setpoint_mps: f64,
    pub course_change_rad: f64,
    /// By how much the flight falls short of the constraints.
    pub violation_m: f64,
}

/// The command that falls short of the constraints least: the present one (speed setpoint, course change), or the
/// mildest of the grid that is better.
pub fn evade(
    look_ahead: &LookAhead,
    commander: &Commander,
    scene: &Scene<'_>,
    weights: [f64; 3],
    present: (f64, f64),
    course_changes_rad: [f64; 2],
    rollout: &mut Rollout,
) -> Evasion {
    let speed_mps = scene.state.speed_mps;
    let mut commands = Commands { speed_setpoint_mps: [present.0; BATCH], course_change_rad: [present.1; BATCH] };
    let grid = COURSES.iter().flat_map(|course| SPEEDS.iter().map(move |speed| (course, speed)));
    let mut count = 1;
    for (&course, &speed) in grid.take(BATCH - 1) {
        let limit_mps = if speed < 0.0 { commander.speed_min_mps } else { commander.speed_max_mps };
        let setpoint_mps = speed_mps + speed.abs() * (limit_mps - speed_mps);
        commands.speed_setpoint_mps[count] = setpoint_mps;
        let change_rad = course * commander.course_bound_rad(speed_mps, setpoint_mps);
        commands.course_change_rad[count] = change_rad.max(course_changes_rad[0]).min(course_changes_rad[1]);
        count += 1;
    }
    let shortfalls_m = look_ahead.try_commands(scene, &commands, weights, count, rollout);
    let mut best = (0, shortfalls_m[0]);
    for (index, &shortfall_m) in shortfalls_m.iter().enumerate() {
        // Less than a millimetre of gain does not justify a harder command.
        if shortfall_m < best.1 - 1e-3 {
            best = (index, shortfall_m);
        }
    }
    Evasion {
        speed_setpoint_mps: commands.speed_setpoint_mps[best.0],
        course_change_rad: commands.course_change_rad[best.0],
        violation_m: best.1,
    }
}
