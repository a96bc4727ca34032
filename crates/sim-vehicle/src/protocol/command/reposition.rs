//! DO_REPOSITION: a place to fly to and circle, in GUIDED.

use crate::mode::Mode;
use crate::protocol::command::{Command, Refusal};
use crate::vehicle::Vehicle;
use mavlink_bridge::CommandPosition;

/// As wide as ArduPilot can store it, m.
const RADIUS_MAX_M: f64 = 32_767.0;

impl Vehicle {
    /// COMMAND_INT only, as in ArduPlane. Param 2: 1 to go into GUIDED. Param 3: radius in m, 0 for WP_LOITER_RAD. Param 4:
    /// anticlockwise if it is a number other than 0. x, y, z: the place. Param 1, a speed, is not read.
    pub(crate) fn reposition(&mut self, command: &Command) -> Result<(), Refusal> {
        let CommandPosition::Int(position) = command.position else { return Err(Refusal::unsupported()) };
        if position.is_zero() || !position.is_valid() {
            return Err(Refusal::denied("Reposition: no such place"));
        }
        let altitude_m = self.guided_altitude_m("Reposition", command.z, command.frame)?;
        let [_, change_mode, radius_m, turn] = command.params;
        let radius_m = if radius_m > 0.0 { f64::from(radius_m) } else { self.flight.tuning().loiter_radius_m };
        if !radius_m.is_finite() || radius_m > RADIUS_MAX_M {
            return Err(Refusal::denied(format!("Reposition: {radius_m:e} m is no radius")));
        }
        if self.mode() != Mode::Guided && change_mode as i64 & 1 == 0 {
            return Err(Refusal::failed(format!("Reposition: mode is {}", self.mode())));
        }
        let place = self.to_local(position);
        if self.is_outside_fence(place, altitude_m) {
            return Err(Refusal::denied("Reposition: the place is outside the fence"));
        }
        if let Some(reason) = self.fence_forbids(Mode::Guided) {
            return Err(Refusal::failed(reason));
        }
        let clockwise = turn.is_nan() || turn == 0.0;
        self.set_mode(Mode::Guided);
        self.flight.reposition(place, if clockwise { radius_m } else { -radius_m });
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        // Who circles a place need not be told anything more.
        self.stop_setpoint_timeout();
        Ok(())
    }
}
