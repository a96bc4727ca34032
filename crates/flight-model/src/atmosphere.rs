//! Mach number and true airspeed in the International Standard Atmosphere (ISO 2533:1975).
//!
//! The paper's first autopilot holds a Mach number but its commands are in m/s (reading 3): Columba commands m/s, and
//! these functions convert for those who think in Mach.

/// Sea-level temperature, K.
const T0_K: f64 = 288.15;
/// Temperature lapse rate in the troposphere, K/m.
const LAPSE_K_PER_M: f64 = 0.0065;
/// Top of the troposphere, m; above it the temperature is constant up to 20 km.
const TROPOPAUSE_M: f64 = 11_000.0;
/// Ratio of specific heats of air.
const GAMMA: f64 = 1.4;
/// Specific gas constant of dry air, J/(kg K).
const R_AIR: f64 = 287.052_87;

/// Speed of sound in m/s at an altitude above mean sea level in m, up to 20 km.
pub fn speed_of_sound_mps(altitude_amsl_m: f64) -> f64 {
    let temperature_k = T0_K - LAPSE_K_PER_M * altitude_amsl_m.min(TROPOPAUSE_M);
    (GAMMA * R_AIR * temperature_k).sqrt()
}

/// Mach number of a true airspeed in m/s at an altitude above mean sea level in m.
pub fn mach(true_airspeed_mps: f64, altitude_amsl_m: f64) -> f64 {
    true_airspeed_mps / speed_of_sound_mps(altitude_amsl_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    // ISO 2533 tables: 340.294 m/s at sea level, 336.434 m/s at 1 km, 295.069 m/s from 11 km to 20 km.
    #[test]
    fn agrees_with_the_standard_tables() {
        assert!((speed_of_sound_mps(0.0) - 340.294).abs() < 1e-3);
        assert!((speed_of_sound_mps(1_000.0) - 336.434).abs() < 1e-2);
        assert!((speed_of_sound_mps(15_000.0) - 295.069).abs() < 1e-2);
        assert!((mach(340.294, 0.0) - 1.0).abs() < 1e-5);
    }
}
