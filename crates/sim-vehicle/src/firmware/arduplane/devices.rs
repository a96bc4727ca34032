//! What an ArduPlane answers to commands for devices that it does not have: relays, servos of its own choice, cameras,
//! gimbals, grippers and their kin. Recorded of a real one without them (`tests/reference/arduplane.json`).
//!
//! By number, as ArduPilot's own dialect has commands that the common one does not name.

use crate::error::{CommandError, CommandResult};

const ACCEPTED: Option<CommandResult> = None;
const DENIED: Option<CommandResult> = Some(CommandResult::Denied);
const FAILED: Option<CommandResult> = Some(CommandResult::Failed);

/// A command, how it is refused, and what it is for.
const ANSWERS: [(u16, Option<CommandResult>, &str); 41] = [
    (181, ACCEPTED, "relay"),
    (182, ACCEPTED, "relay"),
    (183, FAILED, "servo"),
    (184, FAILED, "servo"),
    (185, FAILED, "advanced failsafe"),
    (195, ACCEPTED, "region of interest"),
    (197, ACCEPTED, "region of interest"),
    (198, ACCEPTED, "region of interest"),
    (201, ACCEPTED, "region of interest"),
    (202, ACCEPTED, "camera"),
    (203, ACCEPTED, "camera"),
    (204, FAILED, "mount"),
    (205, FAILED, "mount"),
    (206, ACCEPTED, "camera"),
    (208, ACCEPTED, "parachute"),
    (211, FAILED, "gripper"),
    (212, ACCEPTED, "autotune"),
    (216, FAILED, "sprayer"),
    (218, FAILED, "auxiliary function"),
    (223, FAILED, "combustion engine"),
    (245, DENIED, "parameter storage of another kind"),
    (500, ACCEPTED, "receiver"),
    (532, DENIED, "camera"),
    (534, DENIED, "camera"),
    (1000, FAILED, "gimbal"),
    (1001, FAILED, "gimbal"),
    (2000, FAILED, "camera"),
    (2001, ACCEPTED, "camera"),
    (2500, FAILED, "camera"),
    (2501, FAILED, "camera"),
    (2520, ACCEPTED, "landing gear"),
    (2600, ACCEPTED, "high latency link"),
    (3000, FAILED, "lift motor"),
    (5300, ACCEPTED, "safety switch"),
    (10_001, FAILED, "transponder"),
    (32_000, ACCEPTED, "CAN bus"),
    (42_007, DENIED, "other source of the EKF"),
    (42_425, ACCEPTED, "compass calibration"),
    (42_426, ACCEPTED, "compass calibration"),
    (42_700, DENIED, "debugger"),
    (43_005, ACCEPTED, "rangefinder"),
];

/// DO_PARACHUTE can be switched on and off where there is none, and not released.
const PARACHUTE: u16 = 208;
const RELEASE: f32 = 2.0;

/// The answer to a command for a device that is not there; none if the command is not for one.
pub(crate) fn answer(command: u16, param_1: f32) -> Option<Result<(), CommandError>> {
    let &(_, result, device) = ANSWERS.iter().find(|(number, ..)| *number == command)?;
    let is_release = command == PARACHUTE && param_1 == RELEASE;
    Some(match result {
        _ if is_release => Err(CommandError::failed(format!("There is no {device}"))),
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
        for (command, result, _) in ANSWERS {
            match answer(command, 0.0) {
                Some(Ok(())) => assert_eq!(result, ACCEPTED),
                Some(Err(refusal)) => {
                    assert_eq!(Some(refusal.result), result);
                    assert!(refusal.reason.is_some_and(|reason| reason.len() <= 50));
                }
                None => panic!("{command}"),
            }
        }
        assert_eq!(answer(400, 1.0), None);
        assert!(matches!(answer(PARACHUTE, RELEASE), Some(Err(_))));
    }
}
