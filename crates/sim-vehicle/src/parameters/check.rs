//! Whether the parameters that settings start with are the vehicle's, and in their ranges; for those who check settings
//! before anything flies.

use super::defaults::{in_any_order, shape_limits};
use super::file::Place;
use super::renamed::no_parameter;
use super::{Listed, Parameters};
use crate::error::ParameterError;
use crate::settings::VehicleSettings;

/// A parameter that a vehicle does not take at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterFault {
    /// Its name.
    pub name: String,
    /// The value.
    pub value: f32,
    /// The line of the parameter file that has it; none where no file has.
    pub place: Option<Place>,
    /// What it must be.
    pub wanted: String,
}

/// What is wrong with [`VehicleSettings::parameter_files`] and [`VehicleSettings::default_parameters`]; nothing if a
/// vehicle takes them all.
pub fn check_parameters(settings: &VehicleSettings) -> Vec<ParameterFault> {
    let mut settings = settings.clone();
    shape_limits(&mut settings);
    let mut parameters = Parameters::new(&settings);
    let known = parameters.adopt(&settings.parameter_files, settings.stock_parameters);
    let refused = in_any_order(known, |parameter, entry| parameters.set(parameter, entry.value as f32));
    let mut faults: Vec<ParameterFault> = refused
        .into_iter()
        .map(|(entry, reason)| ParameterFault {
            name: entry.name.clone(),
            value: entry.value as f32,
            place: entry.place.clone(),
            wanted: wanted(&reason),
        })
        .collect();
    for (name, value) in &settings.default_parameters {
        let taken = match parameters.find(name) {
            Some(Listed::Acting(parameter)) => parameters.set(parameter, *value),
            Some(Listed::Inert(index)) => parameters.set_inert(index, f64::from(*value)),
            None => Err(no_parameter(settings.personality.rules(), name)),
        };
        if let Err(reason) = taken {
            faults.push(ParameterFault { name: name.clone(), value: *value, place: None, wanted: wanted(&reason) });
        }
    }
    faults
}

/// What would be right instead.
fn wanted(refused: &ParameterError) -> String {
    match refused {
        ParameterError::Renamed { new, .. } => format!("{new}, as it is called now"),
        ParameterError::Unknown(_) => "the name of a parameter that the vehicle has".to_owned(),
        ParameterError::ReadOnly(_) => "left out: it is only read".to_owned(),
        ParameterError::Type(_) | ParameterError::NotFinite(_) => "a finite number".to_owned(),
        ParameterError::SystemIdTaken(_) => "a number that no other vehicle of the port has".to_owned(),
        ParameterError::Range { least, most, .. } => format!("a number from {least} to {most}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_told_and_the_rest_is_taken() {
        let given = [("WP_RADIUS", 0.0), ("AIRSPEED_CRUISE", 12.0), ("AIRSPEED_MAX", 11.0), ("STAT_RUNTIME", 1.0)];
        let more = [("SYSID_THISMAV", 1.0), ("RTL_RADIUS", f32::NAN)];
        let default_parameters = given.iter().chain(&more).map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let faults = check_parameters(&VehicleSettings { default_parameters, ..VehicleSettings::default() });
        let told: Vec<(&str, &str)> = faults.iter().map(|fault| (&fault.name[..], &fault.wanted[..])).collect();
        assert_eq!(
            told,
            [
                ("WP_RADIUS", "a number from 1 to 32767"),
                ("AIRSPEED_MAX", "a number from 12 to 15"),
                ("STAT_RUNTIME", "left out: it is only read"),
                ("SYSID_THISMAV", "MAV_SYSID, as it is called now"),
                ("RTL_RADIUS", "a finite number"),
            ]
        );
    }
}
