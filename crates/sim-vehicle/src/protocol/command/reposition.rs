//! DO_REPOSITION: a place to fly to and circle, in GUIDED.

use super::request::Command;
use crate::autopilot::Autopilot;
use crate::error::CommandError;
use crate::mode::Mode;
use mavlink_bridge::CommandPosition;

/// As wide as ArduPilot can store it, m.
const RADIUS_MAX_M: f64 = 32_767.0;

/// COMMAND_INT only, as in ArduPlane. Param 2: 1 to go into GUIDED. Param 3: radius in m, 0 for WP_LOITER_RAD. Param 4:
/// anticlockwise if it is a number other than 0. x, y, z: the place. Param 1, a speed, is not read.
pub(crate) fn reposition(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let CommandPosition::Int(position) = command.position else { return Err(CommandError::unsupported()) };
    if position.is_zero() || !position.is_valid() {
        return Err(CommandError::denied("Reposition: no such place"));
    }
    let altitude_m = autopilot.guided_altitude_m("Reposition", command.z, command.frame)?;
    let [_, change_mode, radius_m, turn] = command.params;
    let radius_m = if radius_m > 0.0 { f64::from(radius_m) } else { autopilot.flight.tuning().loiter_radius_m };
    if !radius_m.is_finite() || radius_m > RADIUS_MAX_M {
        return Err(CommandError::denied(format!("Reposition: {radius_m:e} m is no radius")));
    }
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
