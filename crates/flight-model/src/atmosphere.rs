//! Temperature, pressure, density and Mach number in the International Standard Atmosphere (ISO 2533:1975).
//!
//! Altitudes are geopotential, which at the heights of small UAVs is the altitude above mean sea level. The paper's
//! first autopilot holds a Mach number but its commands are in m/s (reading 3): Columba commands m/s, and these
//! functions convert to Mach.

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

/// Pressure at sea level, Pa.
const P0_PA: f64 = 101_325.0;
/// Standard acceleration of free fall, m/s2.
const G0_MPS2: f64 = 9.806_65;

/// Temperature in K at an altitude above mean sea level in m, up to 20 km.
pub fn air_temperature_k(altitude_amsl_m: f64) -> f64 {
    T0_K - LAPSE_K_PER_M * altitude_amsl_m.min(TROPOPAUSE_M)
}

/// Static pressure in Pa at an altitude above mean sea level in m, up to 20 km.
pub fn air_pressure_pa(altitude_amsl_m: f64) -> f64 {
    let temperature_k = air_temperature_k(altitude_amsl_m);
    let troposphere_pa = P0_PA * libm::pow(temperature_k / T0_K, G0_MPS2 / (R_AIR * LAPSE_K_PER_M));
    let above_m = (altitude_amsl_m - TROPOPAUSE_M).max(0.0);
    troposphere_pa * libm::exp(-G0_MPS2 * above_m / (R_AIR * temperature_k))
}

/// Density in kg/m3 at an altitude above mean sea level in m, up to 20 km.
pub fn air_density_kgpm3(altitude_amsl_m: f64) -> f64 {
    air_pressure_pa(altitude_amsl_m) / (R_AIR * air_temperature_k(altitude_amsl_m))
}

/// Speed of sound in m/s at an altitude above mean sea level in m, up to 20 km.
pub fn speed_of_sound_mps(altitude_amsl_m: f64) -> f64 {
    (GAMMA * R_AIR * air_temperature_k(altitude_amsl_m)).sqrt()
}

/// True airspeed of an equivalent airspeed of one, at an altitude above mean sea level in m, in air that is warmer than
/// the standard by so many K: the root of the ratio of densities.
pub fn true_airspeed_ratio(altitude_amsl_m: f64, warmer_k: f64) -> f64 {
    let temperature_k = air_temperature_k(altitude_amsl_m) + warmer_k;
    let density_kgpm3 = air_pressure_pa(altitude_amsl_m) / (R_AIR * temperature_k);
    (P0_PA / (R_AIR * T0_K) / density_kgpm3).sqrt()
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

    #[test]
    fn true_airspeed_grows_with_altitude_and_warmth() {
        assert!((true_airspeed_ratio(0.0, 0.0) - 1.0).abs() < 1e-12);
        assert!((true_airspeed_ratio(5_000.0, 0.0) - (1.225_f64 / 0.736_116).sqrt()).abs() < 1e-4);
        // Measured on an ArduPlane in simulation, 684 m up: 1.065 to 1.0675.
        assert!((true_airspeed_ratio(684.0, 18.0) - 1.066).abs() < 0.002);
    }

    // ISO 2533 tables by geopotential altitude: temperature in K, pressure in Pa, density in kg/m3.
    #[test]
    fn temperature_pressure_and_density_are_those_of_the_standard() {
        for (altitude_m, temperature_k, pressure_pa, density_kgpm3) in [
            (0.0, 288.150, 101_325.0, 1.225_00),
            (1_000.0, 281.650, 89_874.6, 1.111_64),
            (5_000.0, 255.650, 54_019.9, 0.736_116),
            (11_000.0, 216.650, 22_632.0, 0.363_918),
            (20_000.0, 216.650, 5_474.88, 0.088_034_9),
        ] {
            assert!((air_temperature_k(altitude_m) - temperature_k).abs() < 1e-3);
            assert!((air_pressure_pa(altitude_m) / pressure_pa - 1.0).abs() < 2e-5, "{}", air_pressure_pa(altitude_m));
            assert!((air_density_kgpm3(altitude_m) / density_kgpm3 - 1.0).abs() < 2e-5);
        }
    }
}
