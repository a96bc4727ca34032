//! What an ArduPlane answers where it asks more of a command than `protocol/command` does (`handle_command_int_packet`
//! of GCS_Common.cpp and GCS_MAVLink_Plane.cpp).

// Clients still speak what the dialect calls superseded, and autopilots answer.
#![allow(deprecated)]

use super::devices;
use crate::autopilot::Autopilot;
use crate::autopilot::input::ALTITUDE_MAX_M;
use crate::error::CommandError;
use crate::protocol::command::request::Command;
use mavlink_bridge::dialect::{MavCmd, MavFrame};
use mavlink_bridge::{AltitudeDatum, CommandPosition};

/// The answer; none if it is that of every vehicle.
pub(in crate::firmware) fn execute(autopilot: &mut Autopilot, command: &Command) -> Option<Result<(), CommandError>> {
    let is_int = matches!(command.position, CommandPosition::Int(_));
    match command.command {
        // A COMMAND_LONG becomes one in the frame that is asked for. Only a quadplane takes off.
        MavCmd::MAV_CMD_NAV_TAKEOFF if is_int && command.frame != MavFrame::MAV_FRAME_LOCAL_OFFSET_NED as u8 => {
            Some(Err(CommandError::denied("Takeoff: the frame must be LOCAL_OFFSET_NED")))
        }
        MavCmd::MAV_CMD_EXTERNAL_POSITION_ESTIMATE if is_int => Some(external_position(command)),
        MavCmd::MAV_CMD_DO_SET_GLOBAL_ORIGIN if is_int => Some(set_origin(command)),
        MavCmd::MAV_CMD_DO_SET_ROI | MavCmd::MAV_CMD_DO_SET_ROI_LOCATION => Some(look_at(command)),
        // The answer of one that the dialect does not know any more.
        MavCmd::MAV_CMD_REQUEST_PROTOCOL_VERSION if command.params[0] != 1.0 => Some(Err(CommandError::unsupported())),
        _ => devices::execute(autopilot, command.command as u32 as u16, command.params),
    }
}

/// Whether a place can be stored: an altitude that fits, in a frame that has one (`location_from_command_t`). The
/// latitude and longitude are looked at elsewhere.
fn check_place(name: &str, command: &Command) -> Result<(), CommandError> {
    let fits = command.z.abs() <= ALTITUDE_MAX_M;
    if fits && AltitudeDatum::of_frame(command.frame).is_some() {
        return Ok(());
    }
    Err(CommandError::denied(format!("{name}: no such altitude or frame")))
}

/// It has an origin already, the scenario's.
fn set_origin(command: &Command) -> Result<(), CommandError> {
    check_place("Origin", command)?;
    let at = command.lat_lon();
    let is_above_sea = AltitudeDatum::of_frame(command.frame) == Some(AltitudeDatum::MeanSeaLevel);
    if !at.is_valid() || at.is_zero() && command.z == 0.0 && is_above_sea {
        return Err(CommandError::denied("Origin: no such place"));
    }
    Err(CommandError::failed("Origin: it is set"))
}

/// There is no gimbal that would look at a region of interest.
fn look_at(command: &Command) -> Result<(), CommandError> {
    check_place("Region of interest", command)?;
    if command.lat_lon().is_valid() { Ok(()) } else { Err(CommandError::failed("Region of interest: no such place")) }
}

/// A place above sea level without an altitude. With a GPS it is not needed.
fn external_position(command: &Command) -> Result<(), CommandError> {
    // GLOBAL and GLOBAL_INT.
    if !matches!(command.frame, 0 | 5) || !command.z.is_nan() {
        return Err(CommandError::denied("Position: frame GLOBAL, and no altitude"));
    }
    Err(CommandError::failed("Position: the GPS knows it better"))
}
