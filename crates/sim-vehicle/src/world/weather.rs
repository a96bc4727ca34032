//! The weather: a steady wind that changes slowly, gusts, and what the vehicle makes of it.

use super::noise::{Noise, Source};
use flight_model::{Gusts, State, Wind};

/// How fast the estimate of the wind follows, s.
const ESTIMATE_TIME_CONSTANT_S: f64 = 2.0;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Forecast {
    /// SIM_WIND_SPD, m/s.
    pub speed_mps: f64,
    /// SIM_WIND_DIR, where it comes from, rad.
    pub from_rad: f64,
    /// SIM_WIND_TURB: standard deviation of the horizontal gusts, m/s.
    pub gusts_mps: f64,
    /// SIM_WIND_TC: how fast a new wind comes up, s; 0 is at once.
    pub time_constant_s: f64,
}

/// The air at one vehicle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Weather {
    mean: Wind,
    gusts: Gusts,
    gust: Wind,
    estimate: Wind,
}

impl Weather {
    /// Goes on by a step. `air` is the vehicle's state in the air; while the vehicle does not see how it moves over
    /// ground its estimate of the wind stays as it was.
    pub fn step(&mut self, forecast: &Forecast, noise: &Noise, tick: u64, air: &State, step_s: f64, sees_ground: bool) {
        let is_over = self.mean.is_calm() && self.estimate.is_calm() && self.gust.is_calm();
        if forecast.speed_mps == 0.0 && forecast.gusts_mps == 0.0 && is_over {
            return;
        }
        let target = Wind::from_direction(forecast.speed_mps, forecast.from_rad);
        self.mean = approach(&self.mean, &target, forecast.time_constant_s, step_s);
        if sees_ground {
            self.estimate = approach(&self.estimate, &self.mean, ESTIMATE_TIME_CONSTANT_S, step_s);
        }
        if forecast.gusts_mps > 0.0 {
            self.gusts.step(air.speed_mps, air.altitude_m, step_s, noise.normals(Source::Gusts, tick));
            self.gust = self.gusts.velocity(forecast.gusts_mps, air.altitude_m, forecast.from_rad);
        } else {
            (self.gusts, self.gust) = (Gusts::default(), Wind::CALM);
        }
    }

    /// The air as it moves now.
    pub fn wind(&self) -> Wind {
        Wind {
            north_mps: self.mean.north_mps + self.gust.north_mps,
            east_mps: self.mean.east_mps + self.gust.east_mps,
            up_mps: self.mean.up_mps + self.gust.up_mps,
        }
    }

    /// The wind as the vehicle's estimator has it: without the gusts, which it takes for what they are, and late.
    pub fn estimate(&self) -> Wind {
        self.estimate
    }
}

/// A first-order way from one wind to another, which ends there.
fn approach(from: &Wind, to: &Wind, time_constant_s: f64, step_s: f64) -> Wind {
    const NEAR_MPS: f64 = 1e-6;
    let (north_mps, east_mps) = (to.north_mps - from.north_mps, to.east_mps - from.east_mps);
    if from == to || time_constant_s <= 0.0 || north_mps.abs().max(east_mps.abs()) < NEAR_MPS {
        return *to;
    }
    let share = -libm::expm1(-step_s / time_constant_s);
    Wind {
        north_mps: from.north_mps + share * north_mps,
        east_mps: from.east_mps + share * east_mps,
        up_mps: from.up_mps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEST: Forecast =
        Forecast { speed_mps: 6.0, from_rad: -std::f64::consts::FRAC_PI_2, gusts_mps: 0.0, time_constant_s: 5.0 };

    fn after(weather: &mut Weather, forecast: &Forecast, seconds: u64, seed: u64) -> Vec<Wind> {
        let air = State { speed_mps: 10.0, altitude_m: 50.0, ..State::default() };
        (0..100 * seconds)
            .map(|tick| {
                weather.step(forecast, &Noise::new(seed, 1), tick, &air, 0.01, true);
                weather.wind()
            })
            .collect()
    }

    #[test]
    fn a_wind_comes_up_with_its_time_constant_and_goes_down_to_nothing() {
        let mut weather = Weather::default();
        let track = after(&mut weather, &WEST, 60, 1);
        assert!((track[499].speed_mps() - 6.0 * (1.0 - libm::exp(-1.0))).abs() < 1e-9);
        assert!((weather.estimate().east_mps - 6.0).abs() < 1e-3);
        after(&mut weather, &Forecast { speed_mps: 0.0, ..WEST }, 120, 1);
        assert!(weather.wind().is_calm() && weather.estimate().is_calm());
        after(&mut weather, &Forecast { time_constant_s: 0.0, ..WEST }, 1, 1);
        assert!((weather.wind().east_mps - 6.0).abs() < 1e-12);
    }

    #[test]
    fn gusts_are_as_strong_as_asked_for_and_the_estimate_knows_none() {
        let gusty = Forecast { gusts_mps: 1.5, ..WEST };
        let mut weather = Weather::default();
        after(&mut weather, &gusty, 60, 1);
        let track = after(&mut weather, &gusty, 3_000, 2);
        let mean = |value: &dyn Fn(&Wind) -> f64| track.iter().map(value).sum::<f64>() / track.len() as f64;
        assert!((mean(&|wind| wind.east_mps) - 6.0).abs() < 0.5);
        let deviation = mean(&|wind| (wind.east_mps - 6.0) * (wind.east_mps - 6.0)).sqrt();
        assert!((deviation - 1.5).abs() < 0.4, "{deviation}");
        assert!((weather.estimate().east_mps - 6.0).abs() < 1e-3);
    }

    #[test]
    fn each_seed_has_its_own_gusts_and_each_run_the_same() {
        let gusty = Forecast { gusts_mps: 1.0, ..WEST };
        let run = |seed| after(&mut Weather::default(), &gusty, 5, seed);
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }
}
