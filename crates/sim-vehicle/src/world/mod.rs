//! What the world does to the vehicle: weather, sensors that err, a battery that drains, faults. All of it is set by
//! parameters in ArduPilot's names and acts at once; by default there is none of it.

mod battery;
mod gps;
mod noise;
mod sensors;
mod settings;
mod weather;

pub(crate) use battery::Battery;
pub(crate) use gps::GpsSettings;
pub(crate) use noise::{Noise, Source};
pub(crate) use sensors::{Motion, Readings};

use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use crate::settings::VehicleSettings;
use battery::BatterySettings;
use flight_model::{State, Wind};
use gps::Gps;
use sensors::SensorSettings;
use std::time::Duration;
use weather::{Forecast, Weather};

/// The world as one vehicle meets it.
#[derive(Clone, Debug)]
pub(crate) struct World {
    noise: Noise,
    weather: Weather,
    gps: Gps,
    battery: Battery,
    /// By how much the barometer is wrong, m.
    barometer_drift_m: f64,
}

/// The key of the random numbers of a moment.
pub(crate) fn tick(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

impl World {
    pub fn new(settings: &VehicleSettings, parameters: &Parameters) -> Self {
        Self {
            noise: Noise::new(settings.seed, settings.number),
            weather: Weather::default(),
            gps: Gps::default(),
            battery: Battery::new(&BatterySettings::of(parameters)),
            barometer_drift_m: 0.0,
        }
    }

    /// The air of the step that begins at `time`, for a vehicle in a state: the wind, and the wind that its autopilot
    /// reckons with while no GPS tells where the air carries it.
    #[inline]
    pub fn blow(
        &mut self,
        parameters: &Parameters,
        time: Duration,
        step: Duration,
        state: &State,
        in_air: &State,
    ) -> (Wind, Option<Wind>) {
        let gps = GpsSettings::of(parameters);
        self.gps.step(&gps, state, step);
        let sees_ground = gps.has_fix();
        let forecast = Forecast::of(parameters);
        self.weather.step(&forecast, &self.noise, tick(time), in_air, step.as_secs_f64(), sees_ground);
        (self.weather.wind(), (!sees_ground).then(|| self.weather.estimate()))
    }

    /// What flying costs in that step: the battery drains by a share of the greatest power, and the barometer drifts.
    /// Gives whether the engine works, of which a share of the greatest power is needed.
    #[inline]
    pub fn drain(&mut self, parameters: &Parameters, step: Duration, power: f64, power_needed: f64) -> bool {
        let step_s = step.as_secs_f64();
        let battery = BatterySettings::of(parameters);
        self.battery.step(&battery, power, step_s);
        self.barometer_drift_m += f64::from(parameters.get(Parameter::BarometerDrift)) * step_s;
        let is_whole = parameters.get(Parameter::EngineFail) == 0.0
            || f64::from(parameters.get(Parameter::EngineShare)) > power_needed;
        is_whole && !self.battery.is_empty(&battery)
    }

    /// The wind as the vehicle's estimator has it.
    #[inline]
    pub fn wind_estimate(&self) -> Wind {
        self.weather.estimate()
    }

    #[inline]
    pub fn battery(&self) -> &Battery {
        &self.battery
    }

    /// Another battery is put in.
    pub fn replace_battery(&mut self) {
        self.battery.replace();
    }

    /// The battery has been charged or changed: such a share is left of it, and of the capacity that the monitor knows.
    pub fn reset_battery(&mut self, parameters: &Parameters, capacity_mah: f64, left: f64) {
        self.battery.reset(&BatterySettings::of(parameters), capacity_mah, left);
    }

    /// The barometer's drift starts anew.
    pub fn calibrate_barometer(&mut self) {
        self.barometer_drift_m = 0.0;
    }

    /// What the GPS measures of a vehicle in a state.
    pub fn measure_place(&self, settings: &GpsSettings, state: &State, time: Duration) -> State {
        self.gps.measure(settings, state, &self.noise, tick(time))
    }

    /// What the other sensors measure of a motion, above an origin that is so high.
    pub fn readings(&self, motion: &Motion, parameters: &Parameters, time: Duration, origin_amsl_m: f64) -> Readings {
        let settings = SensorSettings::of(parameters);
        Readings::take(motion, &settings, &self.noise, tick(time), self.barometer_drift_m, origin_amsl_m)
    }
}
