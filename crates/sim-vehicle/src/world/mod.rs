//! What the world does to the vehicle: weather, sensors that err, a battery that drains, faults. All of it is set by
//! parameters in ArduPilot's names and acts at once; by default there is none of it.

mod battery;
mod gps;
mod noise;
mod sensors;
mod settings;
mod weather;

pub(crate) use battery::{Battery, BatterySettings};
pub(crate) use gps::{Gps, GpsSettings};
pub(crate) use noise::{Noise, Source};
pub(crate) use sensors::{Readings, SensorSettings};
pub(crate) use weather::{Forecast, Weather};

use crate::autopilot::Autopilot;
use crate::parameters::{Parameter, Parameters};
use crate::settings::VehicleSettings;
use std::time::Duration;

/// The world as one vehicle meets it.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub noise: Noise,
    pub weather: Weather,
    pub gps: Gps,
    pub battery: Battery,
    /// By how much the barometer is wrong, m.
    pub barometer_drift_m: f64,
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
}

/// The key of the random numbers of a moment.
pub(crate) fn tick(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

impl Autopilot {
    /// The world goes on by a step, before the vehicle does.
    pub(crate) fn live(&mut self) {
        let step = self.settings.step;
        let step_s = step.as_secs_f64();
        let (parameters, world) = (&self.parameters, &mut self.world);
        let gps = GpsSettings::of(parameters);
        world.gps.step(&gps, self.flight.state(), step);
        let air = self.flight.in_air();
        let sees_ground = gps.has_fix();
        world.weather.step(&Forecast::of(parameters), &world.noise, tick(self.time), &air, step_s, sees_ground);
        let known = (!sees_ground).then(|| world.weather.estimate());
        self.flight.feel(world.weather.wind(), known);
        let throttle = if self.flight.is_engine_running() { self.flight.power_share() } else { 0.0 };
        let battery = BatterySettings::of(parameters);
        world.battery.step(&battery, throttle, step_s);
        let is_whole = parameters.get(Parameter::EngineFail) == 0.0
            || f64::from(parameters.get(Parameter::EngineShare)) > self.flight.power_needed();
        self.flight.set_engine(is_whole && !world.battery.is_empty(&battery));
        world.barometer_drift_m += f64::from(parameters.get(Parameter::BarometerDrift)) * step_s;
    }
}
