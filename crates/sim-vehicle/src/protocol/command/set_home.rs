//! DO_SET_HOME.

use super::request::Command;
use crate::autopilot::Autopilot;
use crate::autopilot::home::Home;
use crate::autopilot::input::{ALTITUDE_MAX_M, check_finite};
use crate::error::CommandError;
use mavlink_bridge::dialect::MavFrame;

/// DO_SET_HOME. Param 1: 1 for where it is, or 0 for the place that comes with it; one of no latitude and longitude
/// means where it is, too, and so does one that is no number in a COMMAND_LONG.
pub(crate) fn set_home(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let [p1, ..] = command.params;
    check_finite("Home", &[p1])?;
    let position = command.lat_lon();
    if p1 == 1.0 || position.is_zero() {
        autopilot.set_home_here();
        autopilot.session.home_is_set = true;
        return Ok(());
    }
    if p1 != 0.0 {
        return Err(CommandError::failed("Home: param 1 is neither 0 nor 1"));
    }
    if !position.is_valid() {
        return Err(CommandError::failed("Home: no such place"));
    }
    if command.z.is_nan() || command.z.abs() >= ALTITUDE_MAX_M {
        return Err(CommandError::denied("Home: no such altitude"));
    }
    // To a PX4 it is above sea level whatever the frame.
    let is_above_sea = autopilot.rules().home_is_above_sea;
    let frame = if is_above_sea { MavFrame::MAV_FRAME_GLOBAL as u8 } else { command.frame };
    let altitude_m = autopilot.altitude_m("Home", command.z, frame)?;
    let place = autopilot.reference().locate(position);
    autopilot.set_home(Home::new(place, altitude_m));
    autopilot.session.home_is_set = true;
    Ok(())
}
