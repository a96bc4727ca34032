//! The vehicle's parameters: names, types, ranges and values, in ArduPlane 4.7's vocabulary.
//!
//! Every one of them acts; what this flight model has no meaning for is not in the list.

pub(crate) mod file;
mod pace;
mod service;

pub(crate) use pace::Pace;
pub(crate) use service::Listings;

use crate::VehicleSettings;
use crate::flight::{TAKEOFF_ALTITUDE_M, Tuning};
use mavlink_bridge::dialect::MavParamType;

/// One parameter. The order is that of the list, and so of the indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parameter {
    SystemId,
    GroundSystemId,
    RateExtendedStatus,
    RatePosition,
    RateExtra1,
    RateExtra2,
    RateExtra3,
    AirspeedCruise,
    AirspeedMin,
    AirspeedMax,
    RollLimit,
    LoiterRadius,
    WaypointRadius,
    RtlRadius,
    RtlAltitude,
    TakeoffAltitude,
    GroundFailsafe,
    LongFailsafeAction,
    LongFailsafeTimeout,
    RunTime,
}

impl Parameter {
    pub const COUNT: usize = 20;
    pub const ALL: [Parameter; Self::COUNT] = [
        Parameter::SystemId,
        Parameter::GroundSystemId,
        Parameter::RateExtendedStatus,
        Parameter::RatePosition,
        Parameter::RateExtra1,
        Parameter::RateExtra2,
        Parameter::RateExtra3,
        Parameter::AirspeedCruise,
        Parameter::AirspeedMin,
        Parameter::AirspeedMax,
        Parameter::RollLimit,
        Parameter::LoiterRadius,
        Parameter::WaypointRadius,
        Parameter::RtlRadius,
        Parameter::RtlAltitude,
        Parameter::TakeoffAltitude,
        Parameter::GroundFailsafe,
        Parameter::LongFailsafeAction,
        Parameter::LongFailsafeTimeout,
        Parameter::RunTime,
    ];

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.name() == name)
    }

    /// ArduPlane's name.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::SystemId => "MAV_SYSID",
            Parameter::GroundSystemId => "MAV_GCS_SYSID",
            Parameter::RateExtendedStatus => "MAV1_EXT_STAT",
            Parameter::RatePosition => "MAV1_POSITION",
            Parameter::RateExtra1 => "MAV1_EXTRA1",
            Parameter::RateExtra2 => "MAV1_EXTRA2",
            Parameter::RateExtra3 => "MAV1_EXTRA3",
            Parameter::AirspeedCruise => "AIRSPEED_CRUISE",
            Parameter::AirspeedMin => "AIRSPEED_MIN",
            Parameter::AirspeedMax => "AIRSPEED_MAX",
            Parameter::RollLimit => "ROLL_LIMIT_DEG",
            Parameter::LoiterRadius => "WP_LOITER_RAD",
            Parameter::WaypointRadius => "WP_RADIUS",
            Parameter::RtlRadius => "RTL_RADIUS",
            Parameter::RtlAltitude => "RTL_ALTITUDE",
            Parameter::TakeoffAltitude => "TKOFF_ALT",
            Parameter::GroundFailsafe => "FS_GCS_ENABL",
            Parameter::LongFailsafeAction => "FS_LONG_ACTN",
            Parameter::LongFailsafeTimeout => "FS_LONG_TIMEOUT",
            Parameter::RunTime => "STAT_RUNTIME",
        }
    }

    /// The type that ArduPlane gives it; the speeds are real here, because a scenario's limits need not be whole.
    pub fn kind(self) -> MavParamType {
        match self {
            Parameter::GroundFailsafe | Parameter::LongFailsafeAction => MavParamType::MAV_PARAM_TYPE_INT8,
            Parameter::AirspeedCruise
            | Parameter::AirspeedMin
            | Parameter::AirspeedMax
            | Parameter::RollLimit
            | Parameter::RtlAltitude
            | Parameter::TakeoffAltitude
            | Parameter::LongFailsafeTimeout => MavParamType::MAV_PARAM_TYPE_REAL32,
            Parameter::RunTime => MavParamType::MAV_PARAM_TYPE_INT32,
            _ => MavParamType::MAV_PARAM_TYPE_INT16,
        }
    }

    pub fn is_read_only(self) -> bool {
        self == Parameter::RunTime
    }
}

/// Why a value is not taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ParameterRefused {
    #[error("No parameter {0}")]
    Unknown(String),
    #[error("Param write denied ({0})")]
    ReadOnly(&'static str),
    #[error("{0} is not a finite number")]
    NotFinite(&'static str),
    #[error("{name} {value} is outside [{least}, {most}]")]
    Range { name: &'static str, value: f32, least: f32, most: f32 },
}

/// The values of one vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    values: [f32; Parameter::COUNT],
    /// Whether somebody has set it: then it is worth keeping.
    is_set: [bool; Parameter::COUNT],
    speed_limits_mps: (f32, f32),
    roll_limit_deg: f32,
    rate_max_hz: f32,
}

impl Parameters {
    /// What the settings amount to.
    pub fn new(settings: &VehicleSettings) -> Self {
        let limits = settings.dynamics.limits;
        let mut parameters = Self {
            values: [0.0; Parameter::COUNT],
            is_set: [false; Parameter::COUNT],
            speed_limits_mps: (limits.speed_min_mps as f32, limits.speed_max_mps as f32),
            roll_limit_deg: libm::atan(limits.lateral_overload_max).to_degrees() as f32,
            rate_max_hz: settings.fastest_hz().floor() as f32,
        };
        for parameter in Parameter::ALL {
            parameters.values[parameter as usize] = parameters.initial(parameter, settings);
        }
        parameters
    }

    pub fn get(&self, parameter: Parameter) -> f32 {
        self.values[parameter as usize]
    }

    /// Takes a new value, rounded if the parameter is of a whole type.
    pub fn set(&mut self, parameter: Parameter, value: f32) -> Result<(), ParameterRefused> {
        let name = parameter.name();
        if parameter.is_read_only() {
            return Err(ParameterRefused::ReadOnly(name));
        }
        if !value.is_finite() {
            return Err(ParameterRefused::NotFinite(name));
        }
        let real = parameter.kind() == MavParamType::MAV_PARAM_TYPE_REAL32;
        let value = if real { value } else { value.round() };
        let (least, most) = self.range(parameter);
        if !(least..=most).contains(&value) {
            return Err(ParameterRefused::Range { name, value, least, most });
        }
        self.values[parameter as usize] = value;
        self.is_set[parameter as usize] = true;
        Ok(())
    }

    /// What has been set, by name.
    pub fn kept(&self) -> impl Iterator<Item = (&'static str, f32)> {
        let set = Parameter::ALL.into_iter().filter(|parameter| self.is_set[*parameter as usize]);
        set.map(|parameter| (parameter.name(), self.get(parameter)))
    }

    /// What the parameters make of the flight; what nobody has set stays as the settings have it, to the last bit.
    pub fn tuning(&self, settings: &VehicleSettings) -> Tuning {
        let set = |parameter: Parameter| self.is_set[parameter as usize].then(|| f64::from(self.get(parameter)));
        let loiter_radius_m = set(Parameter::LoiterRadius).unwrap_or(settings.loiter_radius_m);
        let rtl_altitude_m = set(Parameter::RtlAltitude).filter(|altitude_m| *altitude_m >= 0.0);
        Tuning {
            loiter_radius_m,
            rtl_radius_m: set(Parameter::RtlRadius).filter(|radius_m| *radius_m != 0.0).unwrap_or(loiter_radius_m),
            rtl_altitude_m,
            takeoff_altitude_m: f64::from(self.get(Parameter::TakeoffAltitude)),
            cruise_speed_mps: set(Parameter::AirspeedCruise),
            lateral_overload_max: set(Parameter::RollLimit)
                .map_or(f64::INFINITY, |limit_deg| libm::tan(limit_deg.to_radians())),
        }
    }

    fn initial(&self, parameter: Parameter, settings: &VehicleSettings) -> f32 {
        let rates = settings.rates;
        match parameter {
            Parameter::SystemId => f32::from(settings.system_id),
            Parameter::GroundSystemId => 255.0,
            Parameter::RateExtendedStatus => rates.sys_status_hz.round() as f32,
            // Two messages are behind it, which the settings can tell apart.
            Parameter::RatePosition => rates.local_position_ned_hz.max(rates.global_position_int_hz).round() as f32,
            Parameter::RateExtra1 => rates.attitude_hz.round() as f32,
            Parameter::RateExtra2 => rates.vfr_hud_hz.round() as f32,
            Parameter::RateExtra3 => rates.system_time_hz.round() as f32,
            Parameter::AirspeedCruise => settings.start.speed_mps as f32,
            Parameter::AirspeedMin => self.speed_limits_mps.0,
            Parameter::AirspeedMax => self.speed_limits_mps.1,
            Parameter::RollLimit => self.roll_limit_deg,
            Parameter::LoiterRadius => settings.loiter_radius_m.round().min(f64::from(i16::MAX)) as f32,
            // ArduPlane's 90 m would cut the corners of short legs.
            Parameter::WaypointRadius => 15.0,
            // ArduPlane's default climbs to 100 m; ours stays where it is.
            Parameter::RtlAltitude => -1.0,
            Parameter::TakeoffAltitude => TAKEOFF_ALTITUDE_M as f32,
            Parameter::LongFailsafeTimeout => 5.0,
            Parameter::RtlRadius | Parameter::GroundFailsafe | Parameter::LongFailsafeAction | Parameter::RunTime => {
                0.0
            }
        }
    }

    fn range(&self, parameter: Parameter) -> (f32, f32) {
        let (slowest, fastest) = self.speed_limits_mps;
        let radius_most = f32::from(i16::MAX);
        match parameter {
            Parameter::SystemId => (1.0, 250.0),
            Parameter::GroundSystemId => (1.0, 255.0),
            Parameter::RateExtendedStatus
            | Parameter::RatePosition
            | Parameter::RateExtra1
            | Parameter::RateExtra2
            | Parameter::RateExtra3 => (0.0, self.rate_max_hz),
            Parameter::AirspeedCruise => (self.get(Parameter::AirspeedMin), self.get(Parameter::AirspeedMax)),
            Parameter::AirspeedMin => (slowest, self.get(Parameter::AirspeedCruise)),
            Parameter::AirspeedMax => (self.get(Parameter::AirspeedCruise), fastest),
            Parameter::RollLimit => (1.0, self.roll_limit_deg),
            Parameter::LoiterRadius | Parameter::RtlRadius => (-radius_most, radius_most),
            Parameter::WaypointRadius => (1.0, radius_most),
            Parameter::RtlAltitude => (-1.0, 10_000.0),
            Parameter::TakeoffAltitude => (0.0, 200.0),
            Parameter::GroundFailsafe | Parameter::LongFailsafeAction => (0.0, 1.0),
            Parameter::LongFailsafeTimeout => (1.0, 300.0),
            Parameter::RunTime => (0.0, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> Parameters {
        Parameters::new(&VehicleSettings::default())
    }

    #[test]
    fn names_are_distinct_and_fit_the_wire() {
        for (index, parameter) in Parameter::ALL.into_iter().enumerate() {
            assert_eq!(parameter as usize, index);
            assert!(parameter.name().len() <= mavlink_bridge::PARAMETER_NAME_MAX);
            assert_eq!(Parameter::from_name(parameter.name()), Some(parameter));
        }
        assert_eq!(Parameter::from_name("SYSID_THISMAV"), None);
    }

    #[test]
    fn the_page_names_every_parameter() {
        let page = include_str!("../../../../docs/mavlink.md");
        for parameter in Parameter::ALL {
            assert!(page.contains(parameter.name()), "docs/mavlink.md says nothing of {}", parameter.name());
        }
    }

    #[test]
    fn initial_values_are_in_range() {
        let parameters = parameters();
        for parameter in Parameter::ALL {
            let (least, most) = parameters.range(parameter);
            assert!((least..=most).contains(&parameters.get(parameter)), "{}", parameter.name());
        }
    }

    #[test]
    fn refusals_say_why_and_change_nothing() {
        let mut parameters = parameters();
        for (parameter, value, reason) in [
            (Parameter::AirspeedMin, f32::NAN, "AIRSPEED_MIN is not a finite number"),
            (Parameter::AirspeedMin, 10.5, "AIRSPEED_MIN 10.5 is outside [5, 10]"),
            (Parameter::SystemId, 0.4, "MAV_SYSID 0 is outside [1, 250]"),
            (Parameter::RunTime, 1.0, "Param write denied (STAT_RUNTIME)"),
        ] {
            let before = parameters.get(parameter);
            assert_eq!(parameters.set(parameter, value).unwrap_err().to_string(), reason);
            assert_eq!(parameters.get(parameter), before);
        }
        assert_eq!(parameters.kept().count(), 0);
    }

    #[test]
    fn whole_types_are_rounded_and_what_is_set_is_kept() {
        let mut parameters = parameters();
        parameters.set(Parameter::LoiterRadius, -79.6).unwrap();
        parameters.set(Parameter::AirspeedCruise, 11.25).unwrap();
        assert_eq!(parameters.kept().collect::<Vec<_>>(), [("AIRSPEED_CRUISE", 11.25), ("WP_LOITER_RAD", -80.0)]);
    }

    #[test]
    fn nothing_set_tunes_nothing() {
        let settings = VehicleSettings { loiter_radius_m: 60.5, ..VehicleSettings::default() };
        let tuning = Parameters::new(&settings).tuning(&settings);
        assert_eq!((tuning.loiter_radius_m, tuning.rtl_radius_m), (60.5, 60.5));
        assert_eq!(
            (tuning.rtl_altitude_m, tuning.cruise_speed_mps, tuning.lateral_overload_max),
            (None, None, f64::INFINITY)
        );
    }
}
