//! Parameters that a vehicle keeps for its clients and does not use: those of a parameter file that this simulation has
//! nothing for, such as `THR_MIN` or `RC1_MIN`. Scripts list, read and set them, and nothing else depends on them.

use super::file::ParameterEntry;
use crate::error::ParameterError;
use crate::firmware::rules::Rules;
use mavlink_bridge::dialect::MavParamType;
use std::sync::Arc;

/// The inert parameters of one vehicle, in the order of their indices.
///
/// A parameter file has more than a thousand. All vehicles that start with it share one list until one of them changes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inert(Arc<Vec<InertParameter>>);

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InertParameter {
    name: String,
    kind: MavParamType,
    /// Whole numbers of 32 bits do not fit into single precision.
    value: f64,
    is_read_only: bool,
    /// Whether a client has set it: then the state folder keeps it.
    is_set: bool,
}

impl Inert {
    /// Those of files, which name each only once.
    pub fn new<'a>(entries: impl Iterator<Item = &'a ParameterEntry>, rules: &Rules) -> Self {
        Self(Arc::new(entries.map(|entry| InertParameter::new(entry, rules)).collect()))
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn get(&self, index: usize) -> Option<&InertParameter> {
        self.0.get(index)
    }

    pub fn iter(&self) -> impl Iterator<Item = &InertParameter> {
        self.0.iter()
    }

    /// The index of the parameter whose name is the right one.
    pub fn position(&self, is_name: impl Fn(&str) -> bool) -> Option<usize> {
        self.0.iter().position(|parameter| is_name(&parameter.name))
    }

    /// Takes a new value, from a client or from what clients have set before.
    pub fn set(&mut self, index: usize, value: f64) -> Result<(), ParameterError> {
        let Some(parameter) = self.get(index) else { return Ok(()) };
        if parameter.is_read_only {
            return Err(ParameterError::ReadOnly(parameter.name.clone().into()));
        }
        if !value.is_finite() {
            return Err(ParameterError::NotFinite(parameter.name.clone().into()));
        }
        self.change(index, value);
        Ok(())
    }

    /// What has been set so far is what the vehicle starts with, and is not kept.
    pub fn make_defaults(&mut self) {
        if self.0.iter().any(|parameter| parameter.is_set) {
            Arc::make_mut(&mut self.0).iter_mut().for_each(|parameter| parameter.is_set = false);
        }
    }

    fn change(&mut self, index: usize, value: f64) {
        if let Some(parameter) = Arc::make_mut(&mut self.0).get_mut(index) {
            parameter.value = if parameter.is_whole() { value.trunc() } else { value };
            parameter.is_set = true;
        }
    }
}

impl InertParameter {
    fn new(entry: &ParameterEntry, rules: &Rules) -> Self {
        let kind = entry.kind_for(rules);
        let mut parameter = Self {
            name: entry.name.clone(),
            kind,
            value: entry.value,
            is_read_only: entry.is_read_only,
            is_set: false,
        };
        if parameter.is_whole() {
            parameter.value = parameter.value.trunc();
        }
        parameter
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn kind(&self) -> MavParamType {
        self.kind
    }

    pub fn value(&self) -> f64 {
        self.value
    }

    pub fn is_set(&self) -> bool {
        self.is_set
    }

    fn is_whole(&self) -> bool {
        self.kind != MavParamType::MAV_PARAM_TYPE_REAL32
    }
}
