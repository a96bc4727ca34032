//! What an ArduPlane answers to commands for devices that it does not have: relays, servos of its own choice, cameras,
//! gimbals, grippers and their kin. Recorded of a real one without them (`tests/reference/arduplane.json`).
//!
//! By number, as ArduPilot's own dialect has commands that the common one does not name.

use crate::protocol::command::{Refusal, integer};
use mavlink_bridge::dialect::MavResult::{
    self, MAV_RESULT_ACCEPTED, MAV_RESULT_DENIED, MAV_RESULT_FAILED, MAV_RESULT_UNSUPPORTED,
};

/// A command, its result, which params that result asks for, and what the command is for.
const ANSWERS: [(u16, MavResult, Asks, &str); 45] = [
    (181, MAV_RESULT_ACCEPTED, Asks::Nothing, "relay"),
    (182, MAV_RESULT_ACCEPTED, Asks::Nothing, "relay"),
    (183, MAV_RESULT_FAILED, Asks::Nothing, "servo"),
    (184, MAV_RESULT_FAILED, Asks::Nothing, "servo"),
    (185, MAV_RESULT_FAILED, Asks::Nothing, "advanced failsafe"),
    (195, MAV_RESULT_ACCEPTED, Asks::Nothing, "region of interest"),
    (197, MAV_RESULT_ACCEPTED, Asks::Nothing, "region of interest"),
    (198, MAV_RESULT_ACCEPTED, Asks::Nothing, "region of interest"),
    (201, MAV_RESULT_ACCEPTED, Asks::Nothing, "region of interest"),
    (202, MAV_RESULT_ACCEPTED, Asks::Nothing, "camera"),
    (203, MAV_RESULT_ACCEPTED, Asks::Nothing, "camera"),
    (204, MAV_RESULT_FAILED, Asks::Nothing, "mount"),
    (205, MAV_RESULT_FAILED, Asks::Nothing, "mount"),
    (206, MAV_RESULT_ACCEPTED, Asks::Nothing, "camera"),
    (208, MAV_RESULT_ACCEPTED, Asks::OneOf(1, &[0, 1], MAV_RESULT_FAILED), "parachute"),
    (209, MAV_RESULT_FAILED, Asks::Nothing, "lift motor"),
    (211, MAV_RESULT_FAILED, Asks::Nothing, "gripper"),
    (212, MAV_RESULT_ACCEPTED, Asks::Nothing, "autotune"),
    (216, MAV_RESULT_FAILED, Asks::Nothing, "sprayer"),
    (218, MAV_RESULT_FAILED, Asks::AtMost(2, 2.0, MAV_RESULT_DENIED), "auxiliary function"),
    (223, MAV_RESULT_FAILED, Asks::Nothing, "combustion engine"),
    (245, MAV_RESULT_DENIED, Asks::Nothing, "parameter storage of another kind"),
    (500, MAV_RESULT_ACCEPTED, Asks::Nothing, "receiver"),
    (532, MAV_RESULT_DENIED, Asks::Nothing, "camera"),
    (534, MAV_RESULT_DENIED, Asks::Nothing, "camera"),
    (1000, MAV_RESULT_FAILED, Asks::Nothing, "gimbal"),
    (1001, MAV_RESULT_FAILED, Asks::Nothing, "gimbal"),
    (2000, MAV_RESULT_FAILED, Asks::AtLeast(1, 0.0, MAV_RESULT_UNSUPPORTED), "camera"),
    (2001, MAV_RESULT_ACCEPTED, Asks::Only(1, 0.0, MAV_RESULT_UNSUPPORTED), "camera"),
    (2500, MAV_RESULT_FAILED, Asks::Nothing, "camera"),
    (2501, MAV_RESULT_FAILED, Asks::Nothing, "camera"),
    (2520, MAV_RESULT_ACCEPTED, Asks::Nothing, "landing gear"),
    (2600, MAV_RESULT_ACCEPTED, Asks::OneOf(1, &[0, 1], MAV_RESULT_FAILED), "high latency link"),
    (3000, MAV_RESULT_FAILED, Asks::Nothing, "lift motor"),
    (5300, MAV_RESULT_ACCEPTED, Asks::OneOf(1, &[0, 1], MAV_RESULT_DENIED), "safety switch"),
    (10_001, MAV_RESULT_FAILED, Asks::Nothing, "transponder"),
    (32_000, MAV_RESULT_ACCEPTED, Asks::Nothing, "CAN bus"),
    (42_006, MAV_RESULT_ACCEPTED, Asks::Nothing, "compass calibration"),
    (42_007, MAV_RESULT_ACCEPTED, Asks::OneOf(1, &[1, 2, 3], MAV_RESULT_DENIED), "other source of the EKF"),
    (42_425, MAV_RESULT_ACCEPTED, Asks::Nothing, "compass calibration"),
    (42_426, MAV_RESULT_ACCEPTED, Asks::Nothing, "compass calibration"),
    (42_429, MAV_RESULT_FAILED, Asks::Nothing, "accelerometer calibration"),
    (42_700, MAV_RESULT_DENIED, Asks::Nothing, "debugger"),
    (43_004, MAV_RESULT_ACCEPTED, Asks::Within(&[(1, 0.0, f32::INFINITY), (3, 0.0, 360.0)], MAV_RESULT_DENIED), "wind"),
    (43_005, MAV_RESULT_ACCEPTED, Asks::Nothing, "rangefinder"),
];

/// What a command asks of its params, and the result where they are otherwise. Params are numbered from 1.
#[derive(Clone, Copy, Debug)]
enum Asks {
    Nothing,
    /// The whole number of a param is one of these.
    OneOf(usize, &'static [i64], MavResult),
    Only(usize, f32, MavResult),
    AtMost(usize, f32, MavResult),
    AtLeast(usize, f32, MavResult),
    /// Each param is not below the first bound and not above the second.
    Within(&'static [(usize, f32, f32)], MavResult),
}

impl Asks {
    /// The result where the params are not as they are asked for, and which one it is.
    fn refusal(self, params: [f32; 4]) -> Option<(MavResult, usize)> {
        let param = |number: usize| params[number - 1];
        match self {
            Asks::Nothing => None,
            Asks::OneOf(number, known, result) => {
                (!known.contains(&integer(param(number)))).then_some((result, number))
            }
            Asks::Only(number, only, result) => (param(number) != only).then_some((result, number)),
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

/// The answer to a command for a device that is not there; none if the command is not for one.
pub(crate) fn answer(command: u16, params: [f32; 4]) -> Option<Result<(), Refusal>> {
    let &(_, result, asks, device) = ANSWERS.iter().find(|(number, ..)| *number == command)?;
    if let Some((result, number)) = asks.refusal(params) {
        return Some(Err(Refusal::new(result, format!("There is no {device}, and param {number} is wrong"))));
    }
    Some(match result {
        MAV_RESULT_ACCEPTED => Ok(()),
        refused => Err(Refusal::new(refused, format!("There is no {device}"))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_is_there_once_and_its_reason_fits_a_statustext() {
        assert!(ANSWERS.windows(2).all(|pair| pair[0].0 < pair[1].0));
        for (command, result, ..) in ANSWERS {
            // 42007 has no source of number 0.
            let params = if command == 42_007 { [1.0, 0.0, 0.0, 0.0] } else { [0.0; 4] };
            match answer(command, params) {
                Some(Ok(())) => assert_eq!(result, MAV_RESULT_ACCEPTED),
                Some(Err(refusal)) => {
                    assert_eq!(refusal.result, result);
                    assert!(refusal.reason.is_some_and(|reason| reason.len() <= 50));
                }
                None => panic!("{command}"),
            }
        }
        assert_eq!(answer(400, [1.0; 4]), None);
    }

    #[test]
    fn params_are_read_where_an_arduplane_reads_them() {
        for (command, params, result) in [
            (208, [2.0, 0.0, 0.0, 0.0], MAV_RESULT_FAILED),
            (218, [41.0, 3.0, 0.0, 0.0], MAV_RESULT_DENIED),
            (2001, [1.0, 0.0, 0.0, 0.0], MAV_RESULT_UNSUPPORTED),
            (2600, [2.0, 0.0, 0.0, 0.0], MAV_RESULT_FAILED),
            (5300, [2.0, 0.0, 0.0, 0.0], MAV_RESULT_DENIED),
            (42_007, [4.0, 0.0, 0.0, 0.0], MAV_RESULT_DENIED),
            (43_004, [1.0, 0.0, 361.0, 0.0], MAV_RESULT_DENIED),
        ] {
            assert_eq!(
                answer(command, params).and_then(Result::err).map(|refusal| refusal.result),
                Some(result),
                "{command}"
            );
        }
    }
}
