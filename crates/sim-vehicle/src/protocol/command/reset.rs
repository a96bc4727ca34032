//! A reset: one vehicle is as it was when the program started, while time and all others go on. No autopilot has this
//! command; MAVLink leaves MAV_CMD_USER_1 to everybody.

use crate::error::CommandError;
use crate::telemetry::announce::{Component, Kept};

/// Param 1: 1 for the reset, which follows the acknowledgement. Param 2: 1 keeps parameters and plans.
pub(crate) fn ask(component: &mut Component, [which, keeps, ..]: [f32; 4]) -> Result<(), CommandError> {
    if which != 1.0 {
        return Err(CommandError::unsupported());
    }
    if component.autopilot.situation().is_in_lockstep {
        return Err(CommandError::failed("Reset: not in simulated time, which its controller keeps"));
    }
    component.reset_wanted = Some(if keeps == 1.0 { Kept::Stored } else { Kept::Nothing });
    Ok(())
}
