//! What an ArduPlane answers to commands for devices that it does not have: relays, servos of its own choice, cameras,
//! gimbals, grippers and their kin. Recorded of a real one without them (`tests/reference/arduplane.json`).
//!
//! By number, as ArduPilot's own dialect has commands that the common one does not name.

use crate::protocol::command::Refusal;
use mavlink_bridge::dialect::MavResult::{self, MAV_RESULT_ACCEPTED, MAV_RESULT_DENIED, MAV_RESULT_FAILED};

/// A command, its result, and what it is for.
const ANSWERS: [(u16, MavResult, &str); 41] = [
    (181, MAV_RESULT_ACCEPTED, "relay"),
    (182, MAV_RESULT_ACCEPTED, "relay"),
    (183, MAV_RESULT_FAILED, "servo"),
    (184, MAV_RESULT_FAILED, "servo"),
    (185, MAV_RESULT_FAILED, "advanced failsafe"),
    (195, MAV_RESULT_ACCEPTED, "region of interest"),
    (197, MAV_RESULT_ACCEPTED, "region of interest"),
    (198, MAV_RESULT_ACCEPTED, "region of interest"),
    (201, MAV_RESULT_ACCEPTED, "region of interest"),
    (202, MAV_RESULT_ACCEPTED, "camera"),
    (203, MAV_RESULT_ACCEPTED, "camera"),
    (204, MAV_RESULT_FAILED, "mount"),
    (205, MAV_RESULT_FAILED, "mount"),
    (206, MAV_RESULT_ACCEPTED, "camera"),
    (208, MAV_RESULT_ACCEPTED, "parachute"),
    (211, MAV_RESULT_FAILED, "gripper"),
    (212, MAV_RESULT_ACCEPTED, "autotune"),
    (216, MAV_RESULT_FAILED, "sprayer"),
    (218, MAV_RESULT_FAILED, "auxiliary function"),
    (223, MAV_RESULT_FAILED, "combustion engine"),
    (245, MAV_RESULT_DENIED, "parameter storage of another kind"),
    (500, MAV_RESULT_ACCEPTED, "receiver"),
    (532, MAV_RESULT_DENIED, "camera"),
    (534, MAV_RESULT_DENIED, "camera"),
    (1000, MAV_RESULT_FAILED, "gimbal"),
    (1001, MAV_RESULT_FAILED, "gimbal"),
    (2000, MAV_RESULT_FAILED, "camera"),
    (2001, MAV_RESULT_ACCEPTED, "camera"),
    (2500, MAV_RESULT_FAILED, "camera"),
    (2501, MAV_RESULT_FAILED, "camera"),
    (2520, MAV_RESULT_ACCEPTED, "landing gear"),
    (2600, MAV_RESULT_ACCEPTED, "high latency link"),
    (3000, MAV_RESULT_FAILED, "lift motor"),
    (5300, MAV_RESULT_ACCEPTED, "safety switch"),
    (10_001, MAV_RESULT_FAILED, "transponder"),
    (32_000, MAV_RESULT_ACCEPTED, "CAN bus"),
    (42_007, MAV_RESULT_DENIED, "other source of the EKF"),
    (42_425, MAV_RESULT_ACCEPTED, "compass calibration"),
    (42_426, MAV_RESULT_ACCEPTED, "compass calibration"),
    (42_700, MAV_RESULT_DENIED, "debugger"),
    (43_005, MAV_RESULT_ACCEPTED, "rangefinder"),
];

/// DO_PARACHUTE can be switched on and off where there is none, and not released.
const PARACHUTE: u16 = 208;
const RELEASE: f32 = 2.0;

/// The answer to a command for a device that is not there; none if the command is not for one.
pub(crate) fn answer(command: u16, param_1: f32) -> Option<Result<(), Refusal>> {
    let &(_, result, device) = ANSWERS.iter().find(|(number, ..)| *number == command)?;
    let is_release = command == PARACHUTE && param_1 == RELEASE;
    Some(match result {
        _ if is_release => Err(Refusal::failed(format!("There is no {device}"))),
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
        for (command, result, _) in ANSWERS {
            match answer(command, 0.0) {
                Some(Ok(())) => assert_eq!(result, MAV_RESULT_ACCEPTED),
                Some(Err(refusal)) => {
                    assert_eq!(refusal.result, result);
                    assert!(refusal.reason.is_some_and(|reason| reason.len() <= 50));
                }
                None => panic!("{command}"),
            }
        }
        assert_eq!(answer(400, 1.0), None);
        assert!(matches!(answer(PARACHUTE, RELEASE), Some(Err(_))));
    }
}
