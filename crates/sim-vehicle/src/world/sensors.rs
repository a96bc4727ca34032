//! What the other sensors measure. At rest in their settings they measure what is, exactly.

use super::noise::{Noise, Source};
use flight_model::{air_density_kgpm3, air_pressure_pa, air_temperature_k};

/// The earth's magnetic field, north and down, in mgauss: about that of the middle latitudes, the same everywhere.
const FIELD_MGAUSS: (f64, f64) = (300.0, 400.0);

/// Noise and faults, in ArduPilot's names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorSettings {
    /// SIM_ACC1_RND: standard deviation of each axis, m/s2.
    pub accelerometer_mps2: f64,
    /// SIM_ACC1_BIAS_X, _Y and _Z, m/s2.
    pub accelerometer_bias_mps2: [f64; 3],
    /// SIM_GYR1_RND: standard deviation of each axis, degrees/s.
    pub gyroscope_dps: f64,
    /// SIM_MAG_RND: standard deviation of each axis, mgauss.
    pub compass_mgauss: f64,
    /// SIM_BARO_RND: standard deviation of the height, m.
    pub barometer_m: f64,
    /// SIM_ARSPD_RND: standard deviation of the dynamic pressure, Pa.
    pub pitot_pa: f64,
    /// SIM_ARSPD_FAIL: the airspeed that a broken sensor shows, m/s; 0: it is whole.
    pub pitot_stuck_mps: f64,
}

/// How a vehicle moves at one moment, as its sensors feel it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Above the origin, m.
    pub altitude_m: f64,
    pub climb_mps: f64,
    /// Through the air, true.
    pub airspeed_mps: f64,
    /// True airspeed of a shown one of one.
    pub true_airspeed_ratio: f64,
    pub heading_rad: f64,
    pub roll_rad: f64,
    pub turn_rate_radps: f64,
    /// (north, east, up).
    pub acceleration_mps2: [f64; 3],
    pub gravity_mps2: f64,
}

/// Readings of one moment; axes are those of the airframe: forward, right, down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Readings {
    /// Specific force, m/s2.
    pub force_mps2: [f64; 3],
    /// Rates of turn, rad/s.
    pub rates_radps: [f64; 3],
    /// Magnetic field, mgauss.
    pub field_mgauss: [f64; 3],
    /// Static pressure, Pa.
    pub pressure_pa: f64,
    /// Altitude above mean sea level by that pressure, m.
    pub pressure_altitude_m: f64,
    /// Dynamic pressure, Pa.
    pub dynamic_pressure_pa: f64,
    /// Airspeed by that pressure, m/s.
    pub airspeed_mps: f64,
    /// Temperature of the air, degrees Celsius.
    pub temperature_c: f64,
}

impl Readings {
    /// What the sensors measure of a motion at a tick, when the barometer has drifted by so much and the origin is so
    /// high.
    pub fn take(
        motion: &Motion,
        settings: &SensorSettings,
        noise: &Noise,
        tick: u64,
        drift_m: f64,
        origin_amsl_m: f64,
    ) -> Self {
        let altitude_m = origin_amsl_m + motion.altitude_m;
        let with_noise = |values: [f64; 3], source, deviation: f64| {
            if deviation == 0.0 {
                return values;
            }
            let errors: [f64; 3] = noise.normals(source, tick);
            std::array::from_fn(|axis| values[axis] + deviation * errors[axis])
        };
        let one = |source, deviation: f64| {
            if deviation == 0.0 { 0.0 } else { deviation * noise.normals::<1>(source, tick)[0] }
        };
        let attitude = Attitude::of(motion);
        let [north, east, up] = motion.acceleration_mps2;
        // What an accelerometer feels is the lift and the thrust, not the weight.
        let force = attitude.to_body([north, east, -up - motion.gravity_mps2]);
        let bias = settings.accelerometer_bias_mps2;
        let force = std::array::from_fn(|axis| force[axis] + bias[axis]);
        let pressure_altitude_m = altitude_m + drift_m + one(Source::Barometer, settings.barometer_m);
        let density_kgpm3 = air_density_kgpm3(altitude_m);
        let airspeed_mps = motion.airspeed_mps;
        let (dynamic_pressure_pa, airspeed_mps) = if settings.pitot_stuck_mps > 0.0 {
            let stuck_mps = settings.pitot_stuck_mps;
            (0.5 * density_kgpm3 * stuck_mps * stuck_mps, stuck_mps)
        } else if settings.pitot_pa == 0.0 {
            (0.5 * density_kgpm3 * airspeed_mps * airspeed_mps, airspeed_mps / motion.true_airspeed_ratio)
        } else {
            let pressure_pa = 0.5 * density_kgpm3 * airspeed_mps * airspeed_mps + one(Source::Pitot, settings.pitot_pa);
            (pressure_pa, (2.0 * pressure_pa.abs() / density_kgpm3).sqrt() / motion.true_airspeed_ratio)
        };
        Self {
            force_mps2: with_noise(force, Source::Accelerometer, settings.accelerometer_mps2),
            rates_radps: with_noise(
                attitude.body_rates(motion.turn_rate_radps),
                Source::Gyroscope,
                settings.gyroscope_dps.to_radians(),
            ),
            field_mgauss: with_noise(
                attitude.to_body([FIELD_MGAUSS.0, 0.0, FIELD_MGAUSS.1]),
                Source::Compass,
                settings.compass_mgauss,
            ),
            pressure_pa: air_pressure_pa(pressure_altitude_m),
            pressure_altitude_m,
            dynamic_pressure_pa,
            airspeed_mps,
            temperature_c: air_temperature_k(altitude_m) - 273.15,
        }
    }
}

/// Sines and cosines of roll, pitch and yaw.
struct Attitude {
    roll: (f64, f64),
    pitch: (f64, f64),
    yaw: (f64, f64),
}

impl Attitude {
    fn of(motion: &Motion) -> Self {
        let pitch_rad = libm::atan2(motion.climb_mps, motion.airspeed_mps);
        Self {
            roll: libm::sincos(motion.roll_rad),
            pitch: libm::sincos(pitch_rad),
            yaw: libm::sincos(motion.heading_rad),
        }
    }

    /// A vector from north, east, down to forward, right, down.
    fn to_body(&self, [north, east, down]: [f64; 3]) -> [f64; 3] {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch), (sin_yaw, cos_yaw)) = (self.roll, self.pitch, self.yaw);
        let (ahead, right) = (north * cos_yaw + east * sin_yaw, east * cos_yaw - north * sin_yaw);
        let (forward, below) = (ahead * cos_pitch - down * sin_pitch, ahead * sin_pitch + down * cos_pitch);
        [forward, right * cos_roll + below * sin_roll, below * cos_roll - right * sin_roll]
    }

    /// The rates about the body's axes of a steady turn.
    fn body_rates(&self, turn_rate_radps: f64) -> [f64; 3] {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (self.roll, self.pitch);
        [-turn_rate_radps * sin_pitch, turn_rate_radps * cos_pitch * sin_roll, turn_rate_radps * cos_pitch * cos_roll]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::flight::Flight;
    use crate::settings::VehicleSettings;

    const WHOLE: SensorSettings = SensorSettings {
        accelerometer_mps2: 0.0,
        accelerometer_bias_mps2: [0.0; 3],
        gyroscope_dps: 0.0,
        compass_mgauss: 0.0,
        barometer_m: 0.0,
        pitot_pa: 0.0,
        pitot_stuck_mps: 0.0,
    };

    fn flown(turn: bool) -> Motion {
        let mut flight = Flight::new(&VehicleSettings::default());
        if turn {
            flight.set_course(3.0, 10.0); // one g sideways: 45 degrees of bank
        }
        for _ in 0..50 {
            flight.step();
        }
        flight.motion()
    }

    fn read(motion: &Motion, settings: &SensorSettings, tick: u64) -> Readings {
        Readings::take(motion, settings, &Noise::new(1, 1), tick, 0.0, 50.0)
    }

    fn near(found: [f64; 3], expected: [f64; 3]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn straight_and_level_it_feels_its_weight_and_the_field() {
        let readings = read(&flown(false), &WHOLE, 1);
        near(readings.force_mps2, [0.0, 0.0, -10.0]);
        near(readings.rates_radps, [0.0; 3]);
        near(readings.field_mgauss, [300.0, 0.0, 400.0]);
        assert_eq!(readings.airspeed_mps, 10.0);
        assert!((readings.pressure_pa - air_pressure_pa(100.0)).abs() < 1e-9);
        assert!((readings.temperature_c - 14.35).abs() < 1e-9);
        assert!((readings.dynamic_pressure_pa - 60.7).abs() < 0.1);
    }

    #[test]
    fn in_a_coordinated_turn_nothing_pulls_sideways() {
        let readings = read(&flown(true), &WHOLE, 1);
        let [forward, right, down] = readings.force_mps2;
        // The acceleration is that of a chord of the circle, half a step behind the bank.
        assert!(
            forward.abs() < 0.1 && right.abs() < 0.1 && (down + 200.0_f64.sqrt()).abs() < 0.1,
            "{forward} {right} {down}"
        );
        let half = 0.5_f64.sqrt();
        let [roll, pitch, yaw] = readings.rates_radps;
        assert!(roll.abs() < 1e-6 && (pitch - half).abs() < 1e-4 && (yaw - half).abs() < 1e-4);
    }

    #[test]
    fn noise_is_as_strong_as_set_and_belongs_to_the_tick() {
        let noisy =
            SensorSettings { accelerometer_mps2: 0.5, gyroscope_dps: 2.0, barometer_m: 1.0, pitot_pa: 5.0, ..WHOLE };
        let motion = flown(false);
        assert_eq!(read(&motion, &noisy, 3), read(&motion, &noisy, 3));
        let deviation = |value: &dyn Fn(&Readings) -> f64| {
            (0..4_000).map(|tick| value(&read(&motion, &noisy, tick))).map(|x| x * x / 4_000.0).sum::<f64>().sqrt()
        };
        assert!((deviation(&|r| r.force_mps2[0]) - 0.5).abs() < 0.03);
        assert!((deviation(&|r| r.rates_radps[2].to_degrees()) - 2.0).abs() < 0.1);
        assert!((deviation(&|r| r.pressure_altitude_m - 100.0) - 1.0).abs() < 0.05);
        assert!((deviation(&|r| r.dynamic_pressure_pa - 60.66) - 5.0).abs() < 0.2);
    }

    #[test]
    fn a_bias_stays_and_a_broken_pitot_is_stuck() {
        let bad = SensorSettings { accelerometer_bias_mps2: [0.1, 0.2, 0.3], pitot_stuck_mps: 3.0, ..WHOLE };
        let readings = read(&flown(false), &bad, 1);
        near(readings.force_mps2, [0.1, 0.2, -9.7]);
        assert_eq!(readings.airspeed_mps, 3.0);
    }
}
