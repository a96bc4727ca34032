//! Eq. 9 and Eq. 10: the vertical terms, which damp the climb and hold the expected altitude.

use crate::LawSettings;

/// Eq. 9 and 10: u_ev + u_eh, m/s2.
pub fn vertical(law: &LawSettings, expected_altitude_m: f64, altitude_m: f64, climb_mps: f64) -> f64 {
    law.vertical_velocity_gain * (0.0 - climb_mps) + law.altitude_gain * (expected_altitude_m - altitude_m)
}
