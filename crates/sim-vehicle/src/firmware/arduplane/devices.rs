//! What an ArduPlane answers to commands for devices that it does not have: cameras, gimbals, grippers and their kin.
//! Recorded of a real one without them (`tests/reference/arduplane.json`).
//!
//! By number, as ArduPilot's own dialect has commands that the common one does not name.

use crate::autopilot::Autopilot;
use crate::autopilot::input::integer;
use crate::error::{CommandError, CommandResult};

const ACCEPTED: Option<CommandResult> = None;
const DENIED: Option<CommandResult> = Some(CommandResult::Denied);
const FAILED: Option<CommandResult> = Some(CommandResult::Failed);

/// A command, its result, which params that result asks for, and what the command is for.
const ANSWERS: [(u16, Option<CommandResult>, Asks, &str); 38] = [
    (185, FAILED, Asks::Nothing, "advanced failsafe"),
    (197, ACCEPTED, Asks::Nothing, "region of interest"),
    (198, ACCEPTED, Asks::Nothing, "region of interest"),
    (202, ACCEPTED, Asks::Nothing, "camera"),
    (203, ACCEPTED, Asks::Nothing, "camera"),
    (204, FAILED, Asks::Nothing, "mount"),
    (205, FAILED, Asks::Nothing, "mount"),
    (206, ACCEPTED, Asks::Nothing, "camera"),
    (209, FAILED, Asks::Nothing, "lift motor"),
    (211, FAILED, Asks::Nothing, "gripper"),
    (212, ACCEPTED, Asks::Nothing, "autotune"),
    (216, FAILED, Asks::Nothing, "sprayer"),
    (218, FAILED, Asks::AtMost(2, 2.0, CommandResult::Denied), "auxiliary function"),
    (223, FAILED, Asks::Nothing, "combustion engine"),
    (500, ACCEPTED, Asks::Nothing, "receiver"),
    (526, FAILED, Asks::Within(&[(1, 1.0, 1.0), (2, 1.0, 1.0)], CommandResult::Unsupported), "memory card"),
    // By rate, in percent, or by itself; not in steps or metres.
    (532, FAILED, Asks::OneOf(1, &[1, 2, 4, 5, 6], CommandResult::Denied), "camera"),
    (534, DENIED, Asks::Nothing, "camera"),
    (1000, FAILED, Asks::Nothing, "gimbal"),
    (1001, FAILED, Asks::Nothing, "gimbal"),
    (2000, FAILED, Asks::AtLeast(1, 0.0, CommandResult::Unsupported), "camera"),
    (2001, ACCEPTED, Asks::Exactly(1, &[0.0], CommandResult::Unsupported), "camera"),
    (2500, FAILED, Asks::Nothing, "camera"),
    (2501, FAILED, Asks::Nothing, "camera"),
    (2520, ACCEPTED, Asks::Nothing, "landing gear"),
    (2600, ACCEPTED, Asks::Exactly(1, &[0.0, 1.0], CommandResult::Failed), "high latency link"),
    (3000, FAILED, Asks::Nothing, "lift motor"),
    (5300, ACCEPTED, Asks::OneOf(1, &[0, 1], CommandResult::Denied), "safety switch"),
    (10_001, FAILED, Asks::Nothing, "transponder"),
    (32_000, ACCEPTED, Asks::ByteOf(1, &[0], CommandResult::Failed), "CAN bus"),
    (42_006, ACCEPTED, Asks::Nothing, "compass calibration"),
    (42_007, ACCEPTED, Asks::OneOf(1, &[1, 2, 3], CommandResult::Denied), "other source of the EKF"),
    (42_424, ACCEPTED, Asks::Within(&[(1, 0.0, 255.0)], CommandResult::Failed), "compass calibration"),
    (42_425, ACCEPTED, Asks::Within(&[(1, 0.0, 255.0)], CommandResult::Failed), "compass calibration"),
    (42_426, ACCEPTED, Asks::Within(&[(1, 0.0, 255.0)], CommandResult::Failed), "compass calibration"),
    (42_700, DENIED, Asks::Nothing, "debugger"),
    (43_004, ACCEPTED, Asks::Within(&[(1, 0.0, f32::INFINITY), (3, 0.0, 360.0)], CommandResult::Denied), "wind"),
    (43_005, ACCEPTED, Asks::Nothing, "rangefinder"),
];

/// What a command asks of its params, and the result where they are otherwise. Params are numbered from 1.
#[derive(Clone, Copy, Debug)]
enum Asks {
    Nothing,
    /// The whole number of a param is one of these.
    OneOf(usize, &'static [i64], CommandResult),
    /// So is its lowest byte.
    ByteOf(usize, &'static [i64], CommandResult),
    /// A param is one of these.
    Exactly(usize, &'static [f32], CommandResult),
    AtMost(usize, f32, CommandResult),
    AtLeast(usize, f32, CommandResult),
    /// Each param is not below the first bound and not above the second.
    Within(&'static [(usize, f32, f32)], CommandResult),
}

impl Asks {
    /// The result where the params are not as they are asked for, and which one it is.
    fn refusal(self, params: [f32; 4]) -> Option<(CommandResult, usize)> {
        let param = |number: usize| params[number - 1];
        match self {
            Asks::Nothing => None,
            Asks::OneOf(number, known, result) => {
                (!known.contains(&integer(param(number)))).then_some((result, number))
            }
            Asks::ByteOf(number, known, result) => {
                (!known.contains(&(integer(param(number)) & 0xFF))).then_some((result, number))
            }
            Asks::Exactly(number, known, result) => (!known.contains(&param(number))).then_some((result, number)),
            Asks::AtMost(number, most, result) => (param(number) > most).then_some((result, number)),
            Asks::AtLeast(number, least, result) => (param(number) < least).then_some((result, number)),
            Asks::Within(bounds, result) => {
                let is_outside =
                    |(number, least, most): &&(usize, f32, f32)| param(*number) < *least || param(*number) > *most;
                bounds.iter().find(is_outside).map(|(number, ..)| (result, *number))
            }
        }
    }
}

/// The calibration of a compass, which is not begun while it is armed.
const START_COMPASS_CALIBRATION: u16 = 42_424;

const ACCEPT_COMPASS_CALIBRATION: u16 = 42_425;
const CANCEL_COMPASS_CALIBRATION: u16 = 42_426;
const PARACHUTE: u16 = 208;

/// The answer to a command for a device that is not there, and what is remembered of it; none if the command is not for
/// one.
pub(crate) fn execute(autopilot: &mut Autopilot, command: u16, params: [f32; 4]) -> Option<Result<(), CommandError>> {
    if command == PARACHUTE {
        return Some(autopilot.command_parachute(params[0]));
    }
    let answer = answer(command, params, autopilot.flight.is_armed())?;
    Some(answer.and_then(|()| calibrate_compasses(&mut autopilot.session.compasses_are_calibrated, command)))
}

/// A calibration that is accepted before it has measured fails, and is over.
fn calibrate_compasses(is_under_way: &mut bool, command: u16) -> Result<(), CommandError> {
    match command {
        START_COMPASS_CALIBRATION => *is_under_way = true,
        CANCEL_COMPASS_CALIBRATION => *is_under_way = false,
        ACCEPT_COMPASS_CALIBRATION if std::mem::take(is_under_way) => {
            return Err(CommandError::failed("Compass calibration: nothing is measured"));
        }
        _ => {}
    }
    Ok(())
}

/// The answer to a command for a device that is not there; none if the command is not for one.
fn answer(command: u16, params: [f32; 4], is_armed: bool) -> Option<Result<(), CommandError>> {
    if command == START_COMPASS_CALIBRATION && is_armed {
        return Some(Err(CommandError::failed("Disarm to allow compass calibration")));
    }
    let &(_, result, asks, device) = ANSWERS.iter().find(|(number, ..)| *number == command)?;
    if let Some((result, number)) = asks.refusal(params) {
        return Some(Err(CommandError::new(result, format!("There is no {device}, and param {number} is wrong"))));
    }
    Some(match result {
        None => Ok(()),
        Some(refused) => Err(CommandError::new(refused, format!("There is no {device}"))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_is_there_once_and_its_reason_fits_a_statustext() {
        assert!(ANSWERS.windows(2).all(|pair| pair[0].0 < pair[1].0));
        for (command, result, ..) in ANSWERS {
            // 42007 has no source of number 0, and 532 no focus.
            let params = if matches!(command, 526 | 532 | 42_007) { [1.0, 1.0, 0.0, 0.0] } else { [0.0; 4] };
            match answer(command, params, false) {
                Some(Ok(())) => assert_eq!(result, ACCEPTED),
                Some(Err(refusal)) => {
                    assert_eq!(Some(refusal.result), result);
                    assert!(refusal.reason.is_some_and(|reason| reason.len() <= 50));
                }
                None => panic!("{command}"),
            }
        }
        assert_eq!(answer(400, [1.0; 4], false), None);
    }

    #[test]
    fn params_are_read_where_an_arduplane_reads_them() {
        for (command, params, result) in [
            (532, [3.0, 0.0, 0.0, 0.0], CommandResult::Denied),
            (532, [4.0, 0.0, 0.0, 0.0], CommandResult::Failed),
            (2600, [0.5, 0.0, 0.0, 0.0], CommandResult::Failed),
            (32_000, [1.0, 0.0, 0.0, 0.0], CommandResult::Failed),
            (42_424, [256.0, 0.0, 0.0, 0.0], CommandResult::Failed),
            (42_426, [-1.0, 0.0, 0.0, 0.0], CommandResult::Failed),
            (218, [41.0, 3.0, 0.0, 0.0], CommandResult::Denied),
            (2001, [1.0, 0.0, 0.0, 0.0], CommandResult::Unsupported),
            (2600, [2.0, 0.0, 0.0, 0.0], CommandResult::Failed),
            (5300, [2.0, 0.0, 0.0, 0.0], CommandResult::Denied),
            (42_007, [4.0, 0.0, 0.0, 0.0], CommandResult::Denied),
            (43_004, [1.0, 0.0, 361.0, 0.0], CommandResult::Denied),
        ] {
            assert_eq!(
                answer(command, params, false).and_then(Result::err).map(|refusal| refusal.result),
                Some(result),
                "{command}"
            );
        }
    }
}
