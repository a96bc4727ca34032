//! Commands of an autopilot in particular of none: take-off and landing beside ArduPlane's, and PX4's modes, as MAVSDK
//! sets them.

use super::{LAND, MODES};
use crate::autopilot::Autopilot;
use crate::autopilot::input::{check_finite, integer};
use crate::error::CommandError;
use crate::firmware::px4;
use crate::mode::Mode;
use crate::protocol::command::request::Command;
use mavlink_bridge::dialect::MavCmd;

/// Where ArduPlane has ACRO and FBWB, PX4 has the modes that fly by themselves and Offboard. MAVSDK takes any unknown
/// autopilot for a PX4.
const PX4_AUTO: i64 = 4;
const PX4_OFFBOARD: i64 = 6;

pub(in crate::firmware) fn execute(autopilot: &mut Autopilot, command: &Command) -> Option<Result<(), CommandError>> {
    let [p1, p2, p3, _] = command.params;
    Some(match command.command {
        MavCmd::MAV_CMD_DO_SET_MODE if p2 == LAND as f32 => autopilot.enter(Mode::Land),
        MavCmd::MAV_CMD_DO_SET_MODE if matches!(integer(p2), PX4_AUTO | PX4_OFFBOARD) => {
            px4::commands::commanded_mode([p1, p2, p3]).and_then(|mode| enter_as_px4(autopilot, mode))
        }
        MavCmd::MAV_CMD_NAV_LAND => autopilot.enter(Mode::Land),
        MavCmd::MAV_CMD_NAV_TAKEOFF => take_off(autopilot, command),
        _ => return None,
    })
}

fn enter_as_px4(autopilot: &mut Autopilot, mode: Mode) -> Result<(), CommandError> {
    match mode {
        Mode::Offboard => autopilot.enter(Mode::Guided),
        mode if MODES.contains(&mode) => autopilot.enter(mode),
        mode => Err(CommandError::failed(format!("No mode {}", px4::modes::mode_name(mode)))),
    }
}

/// z: the altitude, above what the frame says; not a number, or 0: TKOFF_ALT above home.
fn take_off(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    if command.z.is_infinite() {
        check_finite("Takeoff", &[command.z])?;
    }
    if !autopilot.flight.is_armed() {
        return Err(CommandError::failed("Takeoff: not armed"));
    }
    let altitude_m = match command.z {
        z if z.is_nan() || z == 0.0 => None,
        z => Some(autopilot.altitude_m("Takeoff", z, command.frame)?),
    };
    autopilot.enter(Mode::Takeoff)?;
    if let Some(altitude_m) = altitude_m {
        autopilot.flight.take_off(altitude_m.max(autopilot.flight.state().altitude_m));
    }
    Ok(())
}
