//! The parameters of a stock autopilot, as its own simulator lists them: recorded from a real one by
//! `tests/stock_parameters.py`, which says of which version.

use crate::parameters::file::ParameterFile;
use mavlink_bridge::dialect::MavParamType;
use std::collections::HashMap;
use std::sync::OnceLock;

/// A recorded list, read when somebody asks for it first.
pub(crate) struct Stock {
    text: &'static str,
    /// What the autopilot has and does not list, as long as it is switched off.
    unlisted_text: &'static str,
    file: OnceLock<ParameterFile>,
    unlisted: OnceLock<ParameterFile>,
    kinds: OnceLock<HashMap<String, MavParamType>>,
}

impl Stock {
    /// Two lists in QGroundControl's form.
    const fn new(text: &'static str, unlisted_text: &'static str) -> Self {
        Self { text, unlisted_text, file: OnceLock::new(), unlisted: OnceLock::new(), kinds: OnceLock::new() }
    }

    /// What it says.
    pub fn parameters(&self) -> &ParameterFile {
        self.file.get_or_init(|| ParameterFile::recorded(self.text))
    }

    /// What clients can read and set by its name, and no list has.
    pub fn unlisted(&self) -> &ParameterFile {
        self.unlisted.get_or_init(|| ParameterFile::recorded(self.unlisted_text))
    }

    /// The type of a parameter; none if the name is not known. A further battery, sensor or link has the parameters of
    /// the first one.
    pub fn kind(&self, name: &str) -> Option<MavParamType> {
        let kinds = self.kinds.get_or_init(|| {
            let mut kinds = HashMap::new();
            for entry in self.parameters().entries() {
                let Some(kind) = entry.kind else { continue };
                kinds.entry(pattern(&entry.name, "#")).or_insert(kind);
                kinds.insert(entry.name.clone(), kind);
            }
            kinds
        });
        let name = name.to_ascii_uppercase();
        let further = || kinds.get(&pattern(&name, "#")).or_else(|| kinds.get(&pattern(&name, "")));
        kinds.get(&name).or_else(further).copied()
    }
}

/// ArduPlane's.
pub(super) static ARDUPLANE: Stock =
    Stock::new(include_str!("arduplane/stock.params"), include_str!("arduplane/unlisted.params"));
/// PX4's.
pub(super) static PX4: Stock = Stock::new(include_str!("px4/stock.params"), "");

/// A name with something else for each of its numbers.
fn pattern(name: &str, number: &str) -> String {
    let mut pattern = String::with_capacity(name.len());
    let mut was_digit = false;
    for letter in name.chars() {
        let is_digit = letter.is_ascii_digit();
        if !is_digit {
            pattern.push(letter);
        } else if !was_digit {
            pattern.push_str(number);
        }
        was_digit = is_digit;
    }
    pattern
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::MavParamType::{
        MAV_PARAM_TYPE_INT8 as INT8, MAV_PARAM_TYPE_INT16 as INT16, MAV_PARAM_TYPE_INT32 as INT32,
        MAV_PARAM_TYPE_REAL32 as REAL,
    };

    #[test]
    fn every_line_of_the_lists_is_read() {
        for (stock, count) in [(&ARDUPLANE, 1401), (&PX4, 972)] {
            let lines = stock.text.lines().filter(|line| !line.starts_with('#')).count();
            assert_eq!((lines, stock.parameters().entries().len()), (count, count));
            assert!(stock.parameters().entries().iter().all(|entry| entry.kind.is_some()));
            let is_listed = |name: &str| stock.parameters().entries().iter().any(|entry| entry.name == name);
            assert!(stock.unlisted().entries().iter().all(|entry| entry.kind.is_some() && !is_listed(&entry.name)));
        }
    }

    #[test]
    fn types_are_arduplanes_and_a_further_sensor_has_those_of_the_first() {
        for (name, kind) in [
            ("THR_MIN", Some(INT8)),
            ("RC1_MIN", Some(INT16)),
            ("RC14_TRIM", Some(INT16)),
            ("SERVO3_FUNCTION", Some(INT16)),
            ("FLTMODE1", Some(INT8)),
            ("LOG_BITMASK", Some(INT32)),
            ("RLL2SRV_TCONST", Some(REAL)),
            ("TECS_PITCH_MAX", Some(INT8)),
            ("BATT_MONITOR", Some(INT8)),
            ("BATT2_MONITOR", Some(INT8)),
            ("arming_require", Some(INT8)),
            ("NO_SUCH_NAME", None),
        ] {
            assert_eq!(ARDUPLANE.kind(name), kind, "{name}");
        }
        assert_eq!((PX4.kind("CAL_ACC0_ID"), PX4.kind("FW_P_TC")), (Some(INT32), Some(REAL)));
    }
}
