//! Numbers as commands bring them.

use crate::error::CommandError;

/// Altitudes that are no more than that, m either way, can be stored by ArduPilot.
pub(crate) const ALTITUDE_MAX_M: f32 = 83_000.0;

/// Params are compared as integers with what follows the point cut off, as ArduPlane does.
pub(crate) fn integer(param: f32) -> i64 {
    param as i64
}

/// A direction in degrees, in rad.
pub(crate) fn angle_rad(degrees: f32) -> f64 {
    flight_model::wrap_pi(f64::from(degrees).to_radians())
}

/// Refuses what is not a finite number.
pub(crate) fn check_finite(name: &str, values: &[f32]) -> Result<(), CommandError> {
    if values.iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(CommandError::denied(format!("{name}: a parameter is not finite")))
    }
}
