//! What the parameters say about the world.

use super::battery::BatterySettings;
use super::gps::GpsSettings;
use super::sensors::SensorSettings;
use super::weather::Forecast;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use flight_model::wrap_pi;
use std::time::Duration;

impl Forecast {
    pub fn of(parameters: &Parameters) -> Self {
        let get = |parameter| f64::from(parameters.get(parameter));
        Self {
            speed_mps: get(Parameter::WindSpeed),
            from_rad: wrap_pi(get(Parameter::WindDirection).to_radians()),
            gusts_mps: get(Parameter::WindGusts),
            time_constant_s: get(Parameter::WindTimeConstant),
        }
    }
}

impl GpsSettings {
    pub fn of(parameters: &Parameters) -> Self {
        let get = |parameter| parameters.get(parameter);
        Self {
            is_on: get(Parameter::GpsEnabled) != 0.0 && get(Parameter::GpsFail) == 0.0,
            // In range, so it fits.
            lag: Duration::from_millis(get(Parameter::GpsLag) as u64),
            noise_m: f64::from(get(Parameter::GpsNoise)),
            satellites: get(Parameter::GpsSatellites),
        }
    }
}

impl BatterySettings {
    pub fn of(parameters: &Parameters) -> Self {
        let get = |parameter| f64::from(parameters.get(parameter));
        Self { voltage_v: get(Parameter::SimBatteryVoltage), capacity_ah: get(Parameter::SimBatteryCapacity) }
    }
}

impl SensorSettings {
    pub fn of(parameters: &Parameters) -> Self {
        let get = |parameter| f64::from(parameters.get(parameter));
        Self {
            accelerometer_mps2: get(Parameter::AccelerometerNoise),
            accelerometer_bias_mps2: [
                Parameter::AccelerometerBiasX,
                Parameter::AccelerometerBiasY,
                Parameter::AccelerometerBiasZ,
            ]
            .map(get),
            gyroscope_dps: get(Parameter::GyroscopeNoise),
            compass_mgauss: get(Parameter::CompassNoise),
            barometer_m: get(Parameter::BarometerNoise),
            pitot_pa: get(Parameter::PitotNoise),
            pitot_stuck_mps: get(Parameter::PitotFail),
        }
    }
}
