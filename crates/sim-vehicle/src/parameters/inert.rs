//! Parameters that a vehicle keeps for its clients and does not use: those of the stock autopilot and of parameter
//! files that this simulation has nothing for, such as `THR_MIN` or `RC1_MIN`. Scripts list, read and set them, and
//! nothing else depends on them.

use super::file::ParameterEntry;
use super::whole;
use crate::error::ParameterError;
use crate::firmware::rules::Rules;
use mavlink_bridge::dialect::MavParamType;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The inert parameters of one vehicle, in the order of their indices.
///
/// There are more than a thousand. All vehicles share one list, and each has what has been set of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inert {
    list: Arc<Vec<InertParameter>>,
    /// So many from the first are in the list of a client; the others have a name alone.
    listed: usize,
    /// By index, in place of the value in the list.
    own: BTreeMap<usize, OwnValue>,
}

/// One of them, with its first value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InertParameter {
    name: String,
    kind: MavParamType,
    /// Whole numbers of 32 bits do not fit into single precision.
    value: f64,
    is_read_only: bool,
    /// Whether it is as the stock autopilot has it, and no file says otherwise.
    is_stock: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct OwnValue {
    value: f64,
    /// Whether a client has set it: then the state folder keeps it.
    is_kept: bool,
}

impl Inert {
    /// Those of the stock autopilot and of files, which name each only once, and those that are not listed.
    pub fn new(mut parameters: Vec<InertParameter>, unlisted: Vec<InertParameter>) -> Self {
        let listed = parameters.len();
        parameters.extend(unlisted);
        Self { list: Arc::new(parameters), listed, own: BTreeMap::new() }
    }

    /// How many are listed.
    pub fn len(&self) -> usize {
        self.listed
    }

    pub fn get(&self, index: usize) -> Option<&InertParameter> {
        self.list.get(index)
    }

    /// The present value.
    pub fn value(&self, index: usize) -> Option<f64> {
        self.own.get(&index).map(|own| own.value).or_else(|| self.get(index).map(|parameter| parameter.value))
    }

    /// Names of those that somebody has named: files, the settings or a client.
    pub fn named(&self) -> impl Iterator<Item = &str> {
        let is_named =
            |(index, parameter): &(usize, &InertParameter)| !parameter.is_stock || self.own.contains_key(index);
        self.list.iter().enumerate().filter(is_named).map(|(_, parameter)| parameter.name())
    }

    /// What clients have set, by name.
    pub fn kept(&self) -> impl Iterator<Item = (&str, f64)> {
        let kept = self.own.iter().filter(|(_, own)| own.is_kept);
        kept.filter_map(|(index, own)| Some((self.get(*index)?.name(), own.value)))
    }

    /// The index of the parameter whose name is the right one.
    pub fn position(&self, is_name: impl Fn(&str) -> bool) -> Option<usize> {
        self.list.iter().position(|parameter| is_name(&parameter.name))
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
        let own = OwnValue { value: fit(parameter.kind, value), is_kept: true };
        self.own.insert(index, own);
        Ok(())
    }

    /// What has been set so far is what the vehicle starts with, and is not kept.
    pub fn make_defaults(&mut self) {
        self.own.values_mut().for_each(|own| own.is_kept = false);
    }
}

impl InertParameter {
    /// What one line of a file says, or of the stock list.
    pub fn new(entry: &ParameterEntry, rules: &Rules, is_stock: bool) -> Self {
        let kind = entry.kind_for(rules);
        let value = fit(kind, entry.value);
        Self { name: entry.name.clone(), kind, value, is_read_only: entry.is_read_only, is_stock }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn kind(&self) -> MavParamType {
        self.kind
    }
}

/// A value as a parameter of a type has it: a whole one is cut off after the point, and to what there is room for.
fn fit(kind: MavParamType, value: f64) -> f64 {
    let (least, most) = match kind {
        MavParamType::MAV_PARAM_TYPE_UINT8 => (0.0, f64::from(u8::MAX)),
        MavParamType::MAV_PARAM_TYPE_INT8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
        MavParamType::MAV_PARAM_TYPE_UINT16 => (0.0, f64::from(u16::MAX)),
        MavParamType::MAV_PARAM_TYPE_INT16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
        MavParamType::MAV_PARAM_TYPE_UINT32 => (0.0, f64::from(u32::MAX)),
        MavParamType::MAV_PARAM_TYPE_INT32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
        _ => return value,
    };
    whole(value).clamp(least, most)
}
