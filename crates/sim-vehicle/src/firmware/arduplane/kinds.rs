//! The types of ArduPlane's parameters, for those that a file names and this simulation does not use.

use mavlink_bridge::dialect::MavParamType::{
    self, MAV_PARAM_TYPE_INT8 as INT8, MAV_PARAM_TYPE_INT16 as INT16, MAV_PARAM_TYPE_INT32 as INT32,
    MAV_PARAM_TYPE_REAL32 as REAL,
};
use std::collections::HashMap;
use std::sync::OnceLock;

/// Names of the parameters that are whole numbers, as an ArduPlane 4.7 lists them, by their types; a `#` stands for any
/// number.
const WHOLE: &str = include_str!("whole_parameters.txt");

/// The type of a parameter; REAL32 where the name is not known. A further battery, sensor or link has the parameters of
/// the first one.
pub(super) fn of(name: &str) -> MavParamType {
    static KINDS: OnceLock<HashMap<&str, MavParamType>> = OnceLock::new();
    let kinds = KINDS.get_or_init(|| read(WHOLE));
    let numbered = pattern(name, "#");
    let kind = kinds.get(numbered.as_str()).or_else(|| kinds.get(pattern(name, "").as_str()));
    kind.copied().unwrap_or(REAL)
}

fn read(text: &str) -> HashMap<&str, MavParamType> {
    let mut kind = REAL;
    let mut kinds = HashMap::new();
    for word in text.split_whitespace() {
        match word {
            "INT8:" => kind = INT8,
            "INT16:" => kind = INT16,
            "INT32:" => kind = INT32,
            name => {
                kinds.insert(name, kind);
            }
        }
    }
    kinds
}

/// A name with something else for each of its numbers.
fn pattern(name: &str, number: &str) -> String {
    let mut pattern = String::with_capacity(name.len());
    let mut was_digit = false;
    for letter in name.chars() {
        let is_digit = letter.is_ascii_digit();
        if !is_digit {
            pattern.push(letter.to_ascii_uppercase());
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

    #[test]
    fn types_are_arduplanes() {
        for (name, kind) in [
            ("THR_MIN", INT8),
            ("RC1_MIN", INT16),
            ("RC14_TRIM", INT16),
            ("SERVO3_FUNCTION", INT16),
            ("FLTMODE1", INT8),
            ("LOG_BITMASK", INT32),
            ("RLL2SRV_TCONST", REAL),
            ("TECS_PITCH_MAX", INT8),
            ("BATT_MONITOR", INT8),
            ("BATT2_MONITOR", INT8),
            ("arming_require", INT8),
            ("NO_SUCH_NAME", REAL),
        ] {
            assert_eq!(of(name), kind, "{name}");
        }
    }
}
