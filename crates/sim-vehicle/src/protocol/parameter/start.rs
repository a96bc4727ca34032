//! The parameters that a vehicle starts with.

use super::ParameterService;
use crate::error::ParameterError;
use crate::parameters::Listed;
use crate::parameters::defaults::in_any_order;
use crate::parameters::file::ParameterEntry;
use crate::parameters::renamed::no_parameter;
use crate::settings::SettingsError;
use crate::telemetry::announce::Component;

impl ParameterService {
    /// Sets what the vehicle starts with: parameter files, values that were set by name, and what a state folder has
    /// kept.
    pub fn start(&mut self, component: &mut Component) -> Result<(), SettingsError> {
        let files = std::mem::take(&mut component.settings.parameter_files);
        let known = component.autopilot.parameters.adopt(&files, component.settings.stock_parameters);
        let refused = in_any_order(known, |parameter, entry| self.set(component, parameter, entry.value as f32));
        refused.into_iter().next().map_or(Ok(()), |(entry, reason)| Err(of_entry(entry, &reason)))?;
        for (name, value) in std::mem::take(&mut component.settings.default_parameters) {
            self.start_one(component, &name, f64::from(value))
                .map_err(|reason| SettingsError::Parameter(reason.to_string()))?;
        }
        component.autopilot.parameters.make_defaults();
        for entry in std::mem::take(&mut component.settings.kept_parameters).entries() {
            let taken = self.start_one(component, &entry.name, entry.value);
            taken.map_err(|reason| of_entry(entry, &reason))?;
        }
        Ok(())
    }

    /// Sets all parameters to what they were at the start, before what a state folder has kept.
    pub fn reset(&mut self, component: &mut Component) {
        let first = component.autopilot.parameters.first_values();
        // They were in range together.
        let _ = in_any_order(first, |parameter, value| self.set(component, parameter, value));
        component.autopilot.parameters.reset_inert();
        self.has_changed = true;
    }

    fn start_one(&mut self, component: &mut Component, name: &str, value: f64) -> Result<(), ParameterError> {
        match component.autopilot.parameters.find(name) {
            Some(Listed::Acting(parameter)) => self.set(component, parameter, value as f32),
            Some(Listed::Inert(index)) => component.autopilot.parameters.set_inert(index, value),
            None => Err(no_parameter(component.autopilot.rules(), name)),
        }
    }
}

fn of_entry(entry: &ParameterEntry, refused: &ParameterError) -> SettingsError {
    let reason = refused.to_string();
    match &entry.place {
        Some(place) => SettingsError::ParameterFile { place: place.clone(), reason },
        None => SettingsError::Parameter(reason),
    }
}
