//! What a vehicle makes of parameter files: which of their lines act, and which are inert.

use super::Parameters;
use super::file::{ParameterEntry, ParameterFile};
use super::table::Parameter;
use crate::error::ParameterError;
use crate::settings::VehicleSettings;

impl Parameters {
    /// Makes the parameters of files and of the stock autopilot that the vehicle does not know inert ones, and gives
    /// those of the files that it knows and that are to be set. What it counts itself stays, whatever a file says.
    pub fn adopt<'a>(&mut self, files: &'a ParameterFile, has_stock: bool) -> Vec<(Parameter, &'a ParameterEntry)> {
        self.inert = files.inert(self.rules, has_stock, |name| self.named(name).is_some());
        let known = files.entries().iter().filter_map(|entry| Some((self.named(&entry.name)?, entry)));
        let is_taken = |parameter: &Parameter| !parameter.is_counted() && *parameter != Parameter::Speedup;
        known.filter(|(parameter, _)| is_taken(parameter)).collect()
    }

    /// The parameters that have other values than at the start, with their first values.
    pub fn first_values(&self) -> Vec<(Parameter, f32)> {
        let first = self.list.iter().map(|parameter| (*parameter, self.first.values[*parameter as usize]));
        first
            .filter(|(parameter, value)| self.get(*parameter) != *value)
            .filter(|(parameter, _)| !parameter.is_counted() && *parameter != Parameter::Speedup)
            .collect()
    }

    /// Gives the inert ones their first values, after all others have theirs: none of them is worth keeping any more.
    pub fn reset_inert(&mut self) {
        self.inert = self.first.inert.clone();
        self.is_set = self.first.is_set;
        self.is_default = self.first.is_set;
    }

    /// Takes a value that was set by name before the start.
    pub fn set_inert(&mut self, index: usize, value: f64) -> Result<(), ParameterError> {
        self.inert.set(index, value)
    }
}

/// Widens the limits of the flight model to what parameter files say of the vehicle, which starts at its cruise speed.
pub(crate) fn shape_limits(settings: &mut VehicleSettings) {
    if !settings.files_shape_limits {
        return;
    }
    let parameters = Parameters::new(settings);
    let limits = &mut settings.dynamics.limits;
    for entry in settings.parameter_files.entries() {
        let value = entry.value;
        match parameters.named(&entry.name).filter(|_| value > 0.0 && value.is_finite()) {
            Some(Parameter::AirspeedCruise) => {
                settings.cruise_speed_mps = Some(value);
                settings.start.speed_mps = value;
            }
            Some(Parameter::AirspeedMin) => limits.speed_min_mps = limits.speed_min_mps.min(value),
            Some(Parameter::AirspeedMax) => limits.speed_max_mps = limits.speed_max_mps.max(value),
            Some(Parameter::ClimbMax) => limits.climb_max_mps = limits.climb_max_mps.max(value),
            Some(Parameter::SinkMax) => limits.climb_min_mps = limits.climb_min_mps.min(-value),
            Some(Parameter::RollLimit) if value < BANK_MAX_DEG => {
                limits.lateral_overload_max = limits.lateral_overload_max.max(libm::tan(value.to_radians()));
            }
            _ => {}
        }
    }
}

/// Steeper banks have no level turn.
const BANK_MAX_DEG: f64 = 89.0;

/// Sets parameters, the ranges of some of which depend on others, in whatever order they are given. What is not taken
/// in the end is given back, with the reason.
pub(crate) fn in_any_order<T: Copy>(
    mut left: Vec<(Parameter, T)>,
    mut set: impl FnMut(Parameter, T) -> Result<(), ParameterError>,
) -> Vec<(T, ParameterError)> {
    loop {
        let before = left.len();
        let mut refused = Vec::new();
        left.retain(|(parameter, value)| match set(*parameter, *value) {
            Ok(()) => false,
            Err(reason) => {
                refused.push((*value, reason));
                true
            }
        });
        if left.is_empty() || left.len() == before {
            return refused;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Listed;
    use crate::{Personality, Vehicle};
    use mavlink_bridge::dialect::MavParamType;

    fn files(values: &[(&str, f64)]) -> ParameterFile {
        values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    fn vehicle(values: &[(&str, f64)], personality: Personality) -> Vehicle {
        let parameter_files = files(values);
        Vehicle::new(VehicleSettings { parameter_files, personality, ..VehicleSettings::default() }).unwrap()
    }

    #[test]
    fn known_parameters_act_and_unknown_ones_are_kept_in_the_list() {
        let vehicle =
            vehicle(&[("THR_MIN", 5.0), ("WP_LOITER_RAD", 80.0), ("STAT_RUNTIME", 99.0)], Personality::ArduPlane);
        let bare = Parameters::new(&VehicleSettings::default());
        assert_eq!(vehicle.inert_parameters().collect::<Vec<_>>(), ["THR_MIN"]);
        assert_eq!(vehicle.autopilot().parameters.count(), bare.count() + 1);
        assert_eq!(vehicle.autopilot().parameters.at(bare.count()), Some(Listed::Inert(0)));
        assert_eq!(vehicle.autopilot().parameters.at(bare.count() + 1), None);
        assert_eq!(
            vehicle.autopilot().parameters.find("thr_min"),
            Some(Listed::Inert(0)),
            "ArduPilot does not look at the case"
        );
        assert_eq!(vehicle.autopilot().parameters.get(Parameter::LoiterRadius), 80.0);
        assert_eq!(vehicle.set_parameters().count(), 0, "what a file says is not what a client has set");
    }

    #[test]
    fn ranges_that_depend_on_one_another_are_no_matter_of_order() {
        let taken = [("AIRSPEED_MIN", 12.0), ("AIRSPEED_CRUISE", 13.0), ("AIRSPEED_MAX", 14.0)];
        let vehicle = vehicle(&taken, Personality::ArduPlane);
        assert_eq!(vehicle.autopilot().parameters.get(Parameter::AirspeedMin), 12.0);
        let settings =
            VehicleSettings { parameter_files: files(&[("AIRSPEED_MAX", 16.0)]), ..VehicleSettings::default() };
        assert_eq!(Vehicle::new(settings).unwrap_err().to_string(), "AIRSPEED_MAX 16 is outside [10, 15]");
    }

    #[test]
    fn vehicles_share_their_inert_parameters_until_one_is_set() {
        let settings = VehicleSettings { parameter_files: files(&[("THR_MIN", 5.0)]), ..VehicleSettings::default() };
        let [mut one, other] = [settings.clone(), settings].map(|settings| Vehicle::new(settings).unwrap());
        one.autopilot_mut().parameters.write_inert(0, 7.0, 2).unwrap();
        let value = |vehicle: &Vehicle| vehicle.autopilot().parameters.on_wire(Listed::Inert(0), |_| 0.0).2;
        assert_eq!((value(&one), value(&other)), (7.0, 5.0));
        assert_eq!(one.set_parameters().collect::<Vec<_>>(), [("THR_MIN", 7.0)]);
    }

    #[test]
    fn a_stock_autopilots_parameters_are_there_and_those_of_files_go_before() {
        for (personality, count) in [(Personality::ArduPlane, 1401), (Personality::Px4, 972)] {
            let given = files(&[("thr_min", 5.0), ("NO_SUCH_ONE", 2.0)]);
            let settings = VehicleSettings {
                stock_parameters: true,
                parameter_files: given,
                personality,
                ..VehicleSettings::default()
            };
            let vehicle = Vehicle::new(settings.clone()).unwrap();
            let parameters = &vehicle.autopilot().parameters;
            let names: Vec<String> = (0..parameters.count())
                .map(|index| parameters.on_wire(parameters.at(index).unwrap(), |_| 0.0).0.to_ascii_uppercase())
                .collect();
            let distinct: std::collections::HashSet<&String> = names.iter().collect();
            assert_eq!(distinct.len(), names.len(), "each once");
            for entry in (personality.rules().stock)().unwrap().parameters().entries() {
                assert!(distinct.contains(&entry.name), "{}", entry.name);
            }
            assert!(names.len() > count && names.len() < count + 120, "{}", names.len());
            // A PX4 tells names apart by their case, and has no THR_MIN.
            assert_eq!(vehicle.inert_parameters().collect::<Vec<_>>(), ["thr_min", "NO_SUCH_ONE"]);
            let value = |name| parameters.on_wire(parameters.find(name).unwrap(), |_| 0.0);
            if personality == Personality::ArduPlane {
                assert_eq!(value("THR_MIN"), ("thr_min", MavParamType::MAV_PARAM_TYPE_INT8, 5.0));
                assert_eq!(value("RC1_MIN"), ("RC1_MIN", MavParamType::MAV_PARAM_TYPE_INT16, 1000.0));
            } else {
                assert_eq!(value("FW_P_TC").1, MavParamType::MAV_PARAM_TYPE_REAL32);
            }
            let without = VehicleSettings { stock_parameters: false, ..settings };
            assert_eq!(Vehicle::new(without).unwrap().inert_parameter_count(), 2, "the same files, another list");
        }
    }

    #[test]
    fn whole_numbers_are_cut_to_what_their_type_has_room_for_as_arduplane_does() {
        let mut vehicle = vehicle(&[("THR_MIN", -300.0), ("RC1_MIN", 1000.0)], Personality::ArduPlane);
        let value = |vehicle: &Vehicle, index| vehicle.autopilot().parameters.on_wire(Listed::Inert(index), |_| 0.0).2;
        assert_eq!(value(&vehicle, 0), -128.0);
        for (index, written, kept) in
            [(0, 300.0, 127.0), (0, 12.9, 12.0), (0, 12.995, 13.0), (0, -12.995, -13.0), (1, 40_000.0, 32_767.0)]
        {
            vehicle.autopilot_mut().parameters.write_inert(index, written, 9).unwrap();
            assert_eq!(value(&vehicle, index), kept);
        }
    }

    #[test]
    fn what_clients_have_set_is_restored_where_the_files_have_it() {
        let parameter_files = files(&[("THR_MIN", 5.0)]);
        let kept_parameters = files(&[("THR_MIN", 8.0), ("RTL_RADIUS", 70.0)]);
        let settings = VehicleSettings { parameter_files, kept_parameters, ..VehicleSettings::default() };
        let vehicle = Vehicle::new(settings.clone()).unwrap();
        assert_eq!(vehicle.set_parameters().collect::<Vec<_>>(), [("RTL_RADIUS", 70.0), ("THR_MIN", 8.0)]);
        let settings = VehicleSettings { parameter_files: ParameterFile::default(), ..settings };
        assert_eq!(Vehicle::new(settings).unwrap_err().to_string(), "No parameter THR_MIN");
    }

    #[test]
    fn a_px4_has_whole_numbers_by_their_bytes_to_the_last_digit() {
        let mut vehicle = vehicle(&[("CAL_ACC0_ID", 16_777_217.0), ("FW_P_TC", 0.4)], Personality::Px4);
        let bits = |vehicle: &Vehicle, index| {
            vehicle.autopilot().parameters.on_wire(Listed::Inert(index), |_| 0.0).2.to_bits()
        };
        assert_eq!((bits(&vehicle, 0), bits(&vehicle, 1)), (16_777_217, 0.4_f32.to_bits()));
        vehicle.autopilot_mut().parameters.write_inert(0, f32::from_bits(16_777_219), 6).unwrap();
        assert_eq!(bits(&vehicle, 0), 16_777_219);
        let refused = vehicle.autopilot_mut().parameters.write_inert(0, 3.0, 9).unwrap_err();
        assert_eq!(refused, ParameterError::Type("CAL_ACC0_ID".into()));
    }
}
