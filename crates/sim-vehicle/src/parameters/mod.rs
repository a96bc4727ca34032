//! The vehicle's parameters: names, types, ranges and values, in ArduPlane 4.7's vocabulary.
//!
//! Every parameter of the table acts. The list of the stock autopilot and parameter files may bring others, which are
//! inert: clients list, read and set them, and they change nothing.

pub(crate) mod check;
pub(crate) mod defaults;
pub(crate) mod file;
mod inert;
pub(crate) mod renamed;
pub(crate) mod table;

use crate::error::ParameterError;
use crate::firmware::rules::Rules;
use crate::settings::VehicleSettings;
use inert::Inert;
use mavlink_bridge::dialect::MavParamType;
use table::{Bounds, ModelBounds, Parameter, Start};

/// One parameter of a vehicle's list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Listed {
    /// One that acts.
    Acting(Parameter),
    /// One that is only kept, by its index among these.
    Inert(usize),
}

/// The values of one vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    rules: &'static Rules,
    /// Those that the autopilot has.
    list: Vec<Parameter>,
    values: [f32; Parameter::COUNT],
    /// Whether somebody has set it: then it is worth keeping.
    is_set: [bool; Parameter::COUNT],
    /// Whether it was set before the start, and not since: then the settings keep it.
    is_default: [bool; Parameter::COUNT],
    /// Behind those of the list.
    inert: Inert,
    first: First,
    model: ModelBounds,
    /// Of the settings, where they have one.
    cruise_speed_mps: Option<f64>,
}

/// What parameters were at the start, before what clients have set.
#[derive(Clone, Debug)]
struct First {
    values: [f32; Parameter::COUNT],
    is_set: [bool; Parameter::COUNT],
    inert: Inert,
}

impl Parameters {
    /// What the settings amount to.
    pub fn new(settings: &VehicleSettings) -> Self {
        Self::with_rules(settings.personality.rules(), settings)
    }

    /// The same of an autopilot of its own rules.
    pub fn with_rules(rules: &'static Rules, settings: &VehicleSettings) -> Self {
        let limits = settings.dynamics.limits;
        let model = ModelBounds {
            speed_min_mps: limits.speed_min_mps as f32,
            speed_max_mps: limits.speed_max_mps as f32,
            climb_max_mps: limits.climb_max_mps as f32,
            sink_max_mps: -limits.climb_min_mps as f32,
            // The bank of the flight model's tightest turn.
            roll_limit_deg: libm::atan(limits.lateral_overload_max).to_degrees() as f32,
            rate_max_hz: settings.fastest_hz().floor() as f32,
        };
        let start = Start {
            system_id: settings.system_id,
            rates: &settings.rates,
            cruise_mps: settings.cruise_speed_mps.unwrap_or(settings.start.speed_mps),
            loiter_radius_m: settings.loiter_radius_m,
            setpoint_timeout_s: settings.setpoint_timeout_s,
            model: &model,
        };
        let mut values = [0.0; Parameter::COUNT];
        for (value, parameter) in values.iter_mut().zip(Parameter::ALL) {
            *value = (parameter.row().initial)(&start);
        }
        for (parameter, value) in rules.initial_parameters {
            values[*parameter as usize] = *value;
        }
        Self {
            rules,
            list: Parameter::ALL.iter().copied().filter(|parameter| (rules.has_parameter)(*parameter)).collect(),
            values,
            is_set: [false; Parameter::COUNT],
            is_default: [false; Parameter::COUNT],
            inert: Inert::default(),
            first: First { values, is_set: [false; Parameter::COUNT], inert: Inert::default() },
            model,
            cruise_speed_mps: settings.cruise_speed_mps,
        }
    }

    /// Those of the autopilot that has them.
    pub fn rules(&self) -> &'static Rules {
        self.rules
    }

    /// The airspeed of modes that need nobody, where the settings have one, m/s.
    pub fn cruise_speed_mps(&self) -> Option<f64> {
        self.cruise_speed_mps
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.list.len() + self.inert.len()
    }

    /// The parameter of an index.
    pub fn at(&self, index: usize) -> Option<Listed> {
        match self.list.get(index) {
            Some(&parameter) => Some(Listed::Acting(parameter)),
            None => (index < self.count()).then(|| Listed::Inert(index - self.list.len())),
        }
    }

    /// The parameter of a name.
    pub fn find(&self, name: &str) -> Option<Listed> {
        let inert = || self.inert.position(|own| self.is_same_name(own, name)).map(Listed::Inert);
        self.named(name).map(Listed::Acting).or_else(inert)
    }

    /// The parameter of a name among those that act.
    pub fn named(&self, name: &str) -> Option<Parameter> {
        self.list.iter().copied().find(|parameter| self.is_same_name(self.name(*parameter), name))
    }

    /// ArduPilot does not look at the case.
    fn is_same_name(&self, own: &str, name: &str) -> bool {
        if self.rules.parameter_names_have_case { own == name } else { own.eq_ignore_ascii_case(name) }
    }

    /// Names of the parameters that change nothing, and that somebody has named.
    pub fn inert_names(&self) -> impl Iterator<Item = &str> {
        self.inert.named()
    }

    /// How many parameters change nothing.
    pub fn inert_count(&self) -> usize {
        self.inert.len()
    }

    /// Name, type and value on the wire of a parameter; `value` is the present one of a parameter that acts.
    pub fn on_wire(&self, listed: Listed, value: impl FnOnce(Parameter) -> f32) -> (&str, MavParamType, f32) {
        match listed {
            Listed::Acting(parameter) => {
                (self.name(parameter), self.kind(parameter), self.to_wire(parameter, value(parameter)))
            }
            Listed::Inert(index) => {
                let known = self.inert.get(index).zip(self.inert.value(index));
                known.map_or(("", MavParamType::MAV_PARAM_TYPE_REAL32, 0.0), |(own, value)| {
                    let is_bytewise = self.is_bytewise_kind(own.kind());
                    let value = if is_bytewise { f32::from_bits(value as i32 as u32) } else { value as f32 };
                    (own.name(), own.kind(), value)
                })
            }
        }
    }

    /// Takes a value that a client writes to an inert parameter, with the type that it gives.
    pub fn write_inert(&mut self, index: usize, value: f32, kind: u8) -> Result<(), ParameterError> {
        let Some(own) = self.inert.get(index) else { return Ok(()) };
        if self.rules.bytewise_parameters && kind != own.kind() as u8 {
            return Err(ParameterError::Type(own.name().to_owned().into()));
        }
        let is_bytewise = self.is_bytewise_kind(own.kind());
        let value = if is_bytewise { f64::from(value.to_bits() as i32) } else { f64::from(value) };
        self.inert.set(index, value)
    }

    /// What the vehicle calls a parameter.
    pub fn name(&self, parameter: Parameter) -> &'static str {
        (self.rules.parameter)(parameter).0
    }

    /// Of which type the vehicle has a parameter.
    pub fn kind(&self, parameter: Parameter) -> MavParamType {
        (self.rules.parameter)(parameter).1
    }

    /// A value as it stands on the wire: as a number, or in a PX4 an integer by its bytes
    /// (<https://mavlink.io/en/services/parameter.html#parameter-encoding>).
    pub fn to_wire(&self, parameter: Parameter, value: f32) -> f32 {
        if self.is_bytewise(parameter) { f32::from_bits(value as i32 as u32) } else { value }
    }

    /// The value that a writer means who gives a type with it, which ArduPilot does not look at.
    pub fn read_wire(&self, parameter: Parameter, value: f32, kind: u8) -> Result<f32, ParameterError> {
        if self.rules.bytewise_parameters && kind != self.kind(parameter) as u8 {
            return Err(ParameterError::Type(self.name(parameter).into()));
        }
        Ok(if self.is_bytewise(parameter) { value.to_bits() as i32 as f32 } else { value })
    }

    fn is_bytewise(&self, parameter: Parameter) -> bool {
        self.is_bytewise_kind(self.kind(parameter))
    }

    fn is_bytewise_kind(&self, kind: MavParamType) -> bool {
        self.rules.bytewise_parameters && kind != MavParamType::MAV_PARAM_TYPE_REAL32
    }

    #[inline]
    pub fn get(&self, parameter: Parameter) -> f32 {
        self.values[parameter as usize]
    }

    /// Takes a new value, cut off after the point if the parameter is of a whole type.
    pub fn set(&mut self, parameter: Parameter, value: f32) -> Result<(), ParameterError> {
        let name = self.name(parameter);
        if parameter.is_read_only() {
            return Err(ParameterError::ReadOnly(name.into()));
        }
        if !value.is_finite() {
            return Err(ParameterError::NotFinite(name.into()));
        }
        // A generic autopilot tells whole numbers as floats, and they are whole all the same.
        let kind = if self.rules.tells_whole_numbers_as_floats { parameter.kind() } else { self.kind(parameter) };
        let value = if kind == MavParamType::MAV_PARAM_TYPE_REAL32 { value } else { whole(value.into()) as f32 };
        let (least, most) = self.range(parameter);
        if !(least..=most).contains(&value) {
            return Err(ParameterError::Range { name, value, least, most });
        }
        self.values[parameter as usize] = value;
        self.is_set[parameter as usize] = true;
        self.is_default[parameter as usize] = false;
        Ok(())
    }

    /// Takes what has been set so far for defaults, which act and are not kept.
    pub fn make_defaults(&mut self) {
        self.is_default = self.is_set;
        self.inert.make_defaults();
        self.first = First { values: self.values, is_set: self.is_set, inert: self.inert.clone() };
    }

    /// What has been set and is worth keeping, by name.
    pub fn kept(&self) -> impl Iterator<Item = (&str, f64)> {
        // The clock is the host's, and runs as it is told at each start.
        let is_kept = |parameter: Parameter| {
            self.is_set[parameter as usize]
                && !self.is_default[parameter as usize]
                && parameter != Parameter::Speedup
                && !parameter.is_counted()
        };
        let kept = Parameter::ALL.iter().copied().filter(move |parameter| is_kept(*parameter));
        kept.map(|parameter| (self.name(parameter), f64::from(self.get(parameter)))).chain(self.inert.kept())
    }

    /// The value of a parameter that has been set; none if it is as at the start.
    pub fn when_set(&self, parameter: Parameter) -> Option<f64> {
        self.is_set[parameter as usize].then(|| f64::from(self.get(parameter)))
    }

    fn range(&self, parameter: Parameter) -> (f32, f32) {
        (parameter.row().range)(&Bounds { values: &self.values, model: &self.model })
    }
}

/// What is left of a value that must be whole: it is cut off, but for what is as good as the next number (`set_float`
/// of ArduPilot's AP_Param).
fn whole(value: f64) -> f64 {
    const ROUNDING: f64 = 0.01;
    (value + ROUNDING.copysign(value)).trunc()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::Personality;

    fn parameters() -> Parameters {
        Parameters::new(&VehicleSettings::default())
    }

    #[test]
    fn names_are_distinct_and_fit_the_wire() {
        for (index, parameter) in Parameter::ALL.iter().copied().enumerate() {
            assert_eq!(parameter as usize, index);
            assert!(parameter.name().len() <= mavlink_bridge::PARAMETER_NAME_MAX);
            assert_eq!(Parameter::from_name(parameter.name()), Some(parameter));
        }
        assert_eq!(Parameter::from_name("SYSID_THISMAV"), None);
    }

    #[test]
    fn the_page_names_every_parameter() {
        let page = include_str!("../../../../docs/mavlink.md");
        for &parameter in Parameter::ALL {
            assert!(page.contains(parameter.name()), "docs/mavlink.md says nothing of {}", parameter.name());
        }
    }

    #[test]
    fn initial_values_are_in_range() {
        let parameters = parameters();
        for &parameter in Parameter::ALL {
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
    fn whole_types_are_cut_and_what_is_set_is_kept() {
        let mut parameters = parameters();
        parameters.set(Parameter::LoiterRadius, 59.995).unwrap();
        assert_eq!(parameters.get(Parameter::LoiterRadius), 60.0);
        parameters.set(Parameter::LoiterRadius, -79.6).unwrap();
        parameters.set(Parameter::AirspeedCruise, 11.25).unwrap();
        assert_eq!(parameters.kept().collect::<Vec<_>>(), [("AIRSPEED_CRUISE", 11.25), ("WP_LOITER_RAD", -79.0)]);
    }

    #[test]
    fn a_px4_has_its_own_names_and_writes_integers_by_their_bytes() {
        let settings = VehicleSettings { personality: Personality::Px4, ..VehicleSettings::default() };
        let parameters = Parameters::new(&settings);
        let id = parameters.named("MAV_SYS_ID").unwrap();
        assert_eq!(parameters.to_wire(id, 7.0).to_bits(), 7);
        assert_eq!(parameters.read_wire(id, f32::from_bits(7), 6), Ok(7.0));
        assert_eq!(parameters.read_wire(id, 7.0, 9), Err(ParameterError::Type("MAV_SYS_ID".into())));
        let radius = parameters.named("NAV_LOITER_RAD").unwrap();
        assert_eq!((parameters.to_wire(radius, -60.5), parameters.read_wire(radius, -60.5, 9)), (-60.5, Ok(-60.5)));
        for other in ["MAV_SYSID", "WP_LOITER_RAD", "FS_GCS_ENABL"] {
            assert_eq!(parameters.named(other), None);
        }
        assert_eq!(self::parameters().named("COM_OF_LOSS_T"), None);
    }

    #[test]
    fn what_is_set_before_the_start_acts_and_is_not_kept() {
        let mut parameters = parameters();
        parameters.set(Parameter::LoiterRadius, 80.0).unwrap();
        parameters.set(Parameter::RtlRadius, 70.0).unwrap();
        parameters.make_defaults();
        assert_eq!(parameters.when_set(Parameter::LoiterRadius), Some(80.0));
        parameters.set(Parameter::RtlRadius, 75.0).unwrap();
        assert_eq!(parameters.kept().collect::<Vec<_>>(), [("RTL_RADIUS", 75.0)]);
    }
}
