//! DO_REPOSITION: a place to fly to and circle, in GUIDED.

use super::request::Command;
use crate::autopilot::Autopilot;
use crate::autopilot::input::check_finite;
use crate::error::CommandError;
use crate::mode::Mode;
use mavlink_bridge::{AltitudeDatum, CommandPosition};

/// As wide as ArduPilot can store it, m.
const RADIUS_MAX_M: f32 = 65_535.0;

/// COMMAND_INT only, as in ArduPlane. Param 2: 1 to go into GUIDED. Param 3: radius in m, 0 for WP_LOITER_RAD. Param 4:
/// anticlockwise if it is a number other than 0. x, y, z: the place. Param 1, a speed, is not read.
pub(crate) fn reposition(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let CommandPosition::Int(position) = command.position else { return Err(CommandError::unsupported()) };
    if position.is_zero() || !position.is_valid() {
        return Err(CommandError::denied("Reposition: no such place"));
    }
    check_finite("Reposition", &[command.z])?;
    let altitude_m = autopilot.altitude_m("Reposition", command.z, command.frame)?;
    let is_above_sea = AltitudeDatum::of_frame(command.frame) == Some(AltitudeDatum::MeanSeaLevel);
    if !is_above_sea && (command.z * 100.0).trunc() == 0.0 {
        return Err(CommandError::denied("Reposition: no altitude above home or terrain"));
    }
    let [_, change_mode, radius_m, turn] = command.params;
    // Whole metres, and the usual radius in the place of one of no more than a metre.
    let whole_m = f64::from(radius_m.min(RADIUS_MAX_M).trunc());
    let radius_m = if whole_m > 1.0 { whole_m } else { autopilot.flight.tuning().loiter_radius_m };
    if autopilot.mode() != Mode::Guided && change_mode as i64 & 1 == 0 {
        return Err(CommandError::failed(format!("Reposition: mode is {}", autopilot.mode())));
    }
    let place = autopilot.reference().locate(position);
    if autopilot.session.fence.is_outside(&autopilot.situation(), place, altitude_m) {
        return Err(CommandError::denied("Reposition: the place is outside the fence"));
    }
    if let Some(reason) = autopilot.session.fence.forbids_mode(Mode::Guided, &autopilot.situation()) {
        return Err(CommandError::failed(reason));
    }
    let clockwise = turn.is_nan() || turn == 0.0;
    autopilot.set_mode(Mode::Guided);
    autopilot.flight.reposition(place, if clockwise { radius_m } else { -radius_m });
    autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
    // Who circles a place need not be told anything more.
    autopilot.stop_setpoint_timeout();
    Ok(())
}
