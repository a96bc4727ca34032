//! What a vehicle is told before it flies.

use crate::autopilot::plan::Plans;
use crate::firmware::Personality;
use crate::mode::Mode;
use crate::parameters::file::{ParameterFile, Place};
use crate::telemetry::rates::{LinkUse, TelemetryRates};
use flight_model::{Dynamics, Geodetic, LocalFrame, PlantSettings, RangeError, Ranges, State};
use std::net::SocketAddr;
use std::time::Duration;

/// All that distinguishes one simulated vehicle from another.
#[derive(Clone, Debug)]
pub struct VehicleSettings {
    /// MAVLink system id, 1 to 250.
    pub system_id: u8,
    /// MAVLink component id; an autopilot's is 1.
    pub component_id: u8,
    /// The autopilot that it passes for.
    pub personality: Personality,
    /// Constants of Eq. 1 and 3.
    pub dynamics: Dynamics,
    /// How it flies otherwise than by Eq. 1.
    pub plant: Option<PlantSettings>,
    /// Our controller leads it, and has it change its speed no faster than this, m/s2, by the rule by which a real
    /// ArduPlane is told so with each speed ([`mavlink_bridge::kind::gentle_rate_mps2`]): speeds that come without an
    /// acceleration are flown so. Infinite: these are flown at once.
    pub led_acceleration_mps2: f64,
    /// Integration step.
    pub step: Duration,
    /// Where and how it starts, in the air.
    pub start: State,
    /// It stands on the ground instead, where it starts, at altitude 0 above the origin and on its course: disarmed and
    /// in MANUAL, whatever `armed` and `mode` say, and with its home there. The speed of the start is its cruise speed.
    pub on_ground: bool,
    /// The local frame. Its origin is the home of vehicles that start in the air, and the ground is level with it.
    pub frame: LocalFrame,
    /// Armed at the start. Otherwise it waits motionless where it starts until it is armed.
    pub armed: bool,
    /// Mode at the start.
    pub mode: Mode,
    /// Rates of the telemetry that every link gets until it asks for others.
    pub rates: TelemetryRates,
    /// In GUIDED, time without any setpoint or guided command after which it loiters, s; 0 means never (as ArduPlane).
    pub setpoint_timeout_s: f64,
    /// Radius of LOITER and RTL circles, m.
    pub loiter_radius_m: f64,
    /// Airspeed of the modes that need nobody, m/s; none: the present one. AIRSPEED_CRUISE begins with it.
    pub cruise_speed_mps: Option<f64>,
    /// Parameter files widen the limits of the flight model: they tell which vehicle it is.
    pub files_shape_limits: bool,
    /// Microseconds since the Unix epoch at the vehicle's time zero, for SYSTEM_TIME.
    pub clock_epoch_us: u64,
    /// Where telemetry goes unasked.
    pub ground: Option<SocketAddr>,
    /// Where else it goes unasked.
    pub further_grounds: Vec<SocketAddr>,
    /// What links are for that are those of the autopilot's own simulator: these start with its rates.
    pub link_uses: Vec<(SocketAddr, LinkUse)>,
    /// What every other link is for; none: they start with the vehicle's own rates.
    pub other_link_use: Option<LinkUse>,
    /// Clients find the parameters of the real autopilot that the vehicle does not know, too; they change nothing.
    pub stock_parameters: bool,
    /// Parameter files in place of the vehicle's own defaults. What the vehicle does not know is kept for its clients.
    pub parameter_files: ParameterFile,
    /// Parameters in place of these and of the vehicle's own defaults, by name, in order.
    pub default_parameters: Vec<(String, f32)>,
    /// Parameters that clients set before a restart; they take precedence over those above.
    pub kept_parameters: ParameterFile,
    /// Seed of all noise, as the scenario has it.
    pub seed: u64,
    /// The vehicle's number among those of one seed: each has its own noise.
    pub number: u64,
    /// The plans that were on board before.
    pub plans: Plans,
}

/// How a vehicle waits for the controller when both share a simulated clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LockstepSettings {
    /// Control period T: a setpoint stamped t moves the vehicle from t to t + T. Whole milliseconds.
    pub period: Duration,
    /// Host time after which a waiting vehicle sends its last telemetry again.
    pub resend_after: Duration,
    /// The wait doubles from `resend_after` up to this.
    pub resend_at_most: Duration,
}

/// A setting out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A number outside what its setting allows.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// The start state has a component that is not a finite number.
    #[error("the start state is not finite")]
    StartNotFinite,
    /// A plan that the vehicle refuses; the message says which item and why.
    #[error("{0}")]
    Plan(String),
    /// A parameter that the vehicle does not have, or a value of it that it refuses.
    #[error("{0}")]
    Parameter(String),
    /// A line of a parameter file has a value that the vehicle refuses.
    #[error("{place}: {reason}")]
    ParameterFile {
        /// File and line.
        place: Place,
        /// What is wrong, the name included.
        reason: String,
    },
    /// The control period is not a positive whole number of milliseconds and of integration steps.
    #[error("control period {period:?} is not a whole number of milliseconds and of integration steps ({step:?})")]
    Period {
        /// The control period.
        period: Duration,
        /// The integration step.
        step: Duration,
    },
}

/// A vehicle sends no message more often than 0.8 times for each integration step, as ArduPilot's scheduler allows.
pub(crate) const RATE_PER_STEP_MAX: f64 = 0.8;

impl Default for VehicleSettings {
    fn default() -> Self {
        Self {
            system_id: 1,
            component_id: 1,
            personality: Personality::default(),
            dynamics: Dynamics::default(),
            plant: None,
            led_acceleration_mps2: f64::INFINITY,
            step: Duration::from_millis(10),
            start: State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() },
            on_ground: false,
            frame: LocalFrame::new(Geodetic { latitude_deg: 39.98, longitude_deg: 116.34, altitude_amsl_m: 50.0 }),
            armed: true,
            mode: Mode::Guided,
            rates: TelemetryRates::default(),
            setpoint_timeout_s: 0.0,
            loiter_radius_m: 60.0,
            clock_epoch_us: 0,
            ground: Some(SocketAddr::from(([127, 0, 0, 1], 14550))),
            further_grounds: Vec::new(),
            link_uses: Vec::new(),
            other_link_use: None,
            cruise_speed_mps: None,
            files_shape_limits: false,
            stock_parameters: false,
            parameter_files: ParameterFile::default(),
            default_parameters: Vec::new(),
            kept_parameters: ParameterFile::default(),
            seed: 0,
            number: 0,
            plans: Plans::default(),
        }
    }
}

impl Default for LockstepSettings {
    fn default() -> Self {
        Self {
            period: Duration::from_millis(500),
            resend_after: Duration::from_millis(5),
            resend_at_most: Duration::from_millis(100),
        }
    }
}

impl VehicleSettings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), SettingsError> {
        if !self.start.is_finite() {
            return Err(SettingsError::StartNotFinite);
        }
        self.check().into_iter().next().map_or(Ok(()), |error| Err(error.into()))
    }

    /// Every setting that is out of its range.
    pub fn check(&self) -> Vec<RangeError> {
        let limits = self.dynamics.limits;
        let mut ranges = Ranges::default();
        ranges.whole("system_id", self.system_id.into(), 1, 250);
        ranges.whole("component_id", self.component_id.into(), 1, 255);
        ranges.within("step_s", self.step.as_secs_f64(), 1e-3, 1.0);
        ranges.within("setpoint_timeout_s", self.setpoint_timeout_s, 0.0, 86_400.0);
        ranges.within("loiter_radius_m", self.loiter_radius_m, 1.0, 10_000.0);
        ranges.within("start.speed_mps", self.start.speed_mps, limits.speed_min_mps, limits.speed_max_mps);
        ranges.within("start.climb_mps", self.start.climb_mps, limits.climb_min_mps, limits.climb_max_mps);
        if self.led_acceleration_mps2 != f64::INFINITY {
            ranges.within("led_acceleration_mps2", self.led_acceleration_mps2, 0.01, 1e3);
        }
        ranges.extend(self.dynamics.check());
        ranges.extend(self.plant.iter().flat_map(PlantSettings::check));
        for (name, rate_hz) in self.rates.named() {
            ranges.within(name, rate_hz, 0.0, self.fastest_hz());
        }
        ranges.errors()
    }
}

impl VehicleSettings {
    /// The greatest rate of a message, Hz.
    pub(crate) fn fastest_hz(&self) -> f64 {
        RATE_PER_STEP_MAX / self.step.as_secs_f64()
    }
}

impl LockstepSettings {
    /// Whether the period fits an integration step and the waits are positive and in order.
    ///
    /// # Errors
    /// The first that is not so.
    pub fn validate(&self, step: Duration) -> Result<(), SettingsError> {
        let (period, step) = (self.period, step);
        let whole = |unit: Duration| unit.as_nanos() > 0 && period.as_nanos().is_multiple_of(unit.as_nanos());
        if period.is_zero() || !whole(step) || !whole(Duration::from_millis(1)) {
            return Err(SettingsError::Period { period, step });
        }
        let (least_s, most_s) = (self.resend_after.as_secs_f64(), self.resend_at_most.as_secs_f64());
        let mut ranges = Ranges::default();
        ranges.within("resend_after_s", least_s, 1e-3, 60.0);
        ranges.within("resend_at_most_s", most_s, least_s, 60.0);
        ranges.errors().into_iter().next().map_or(Ok(()), |error| Err(error.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_in_range() {
        assert_eq!(VehicleSettings::default().validate(), Ok(()));
        assert_eq!(LockstepSettings::default().validate(Duration::from_millis(10)), Ok(()));
    }

    #[test]
    fn a_bad_setting_is_named() {
        let fast = TelemetryRates { attitude_hz: 81.0, ..TelemetryRates::default() };
        let error = VehicleSettings { rates: fast, ..VehicleSettings::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "attitude_hz = 81: must be a number from 0 to 80");
        let off =
            TelemetryRates { extended_sys_state_hz: -1.0, home_position_hz: f64::NAN, ..TelemetryRates::default() };
        let errors = VehicleSettings { rates: off, ..VehicleSettings::default() }.check();
        let names: Vec<&str> = errors.iter().map(|error| error.name).collect();
        assert_eq!(names, ["extended_sys_state_hz", "home_position_hz"]);
        let start = State { speed_mps: f64::NAN, ..VehicleSettings::default().start };
        let error = VehicleSettings { start, ..VehicleSettings::default() }.validate();
        assert_eq!(error, Err(SettingsError::StartNotFinite));
        assert!(VehicleSettings { system_id: 0, ..VehicleSettings::default() }.validate().is_err());
        assert!(VehicleSettings { setpoint_timeout_s: f64::NAN, ..VehicleSettings::default() }.validate().is_err());
    }

    #[test]
    fn a_period_is_whole_steps_and_milliseconds() {
        let step = Duration::from_millis(10);
        for (period_us, fits) in [(0, false), (5_000, false), (10_000, true), (500_000, true), (505_000, false)] {
            let period = Duration::from_micros(period_us);
            assert_eq!(LockstepSettings { period, ..LockstepSettings::default() }.validate(step).is_ok(), fits);
        }
    }
}
