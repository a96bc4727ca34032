//! Parameter files of older autopilots: names that are others now, and values in other units.

use super::file::{ParameterEntry, ParameterFile};
use crate::error::ParameterError;
use crate::firmware::Personality;
use crate::firmware::rules::Rules;

/// A parameter that has another name now.
#[derive(Debug)]
pub(crate) struct Renamed {
    pub old: &'static str,
    /// The new name; a `#` stands for the channel that the value is.
    pub new: &'static str,
    pub conversion: Conversion,
}

/// What becomes of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Conversion {
    /// The same times a factor.
    Times(f64),
    /// It was a channel, which now has a function of this number; 0 was none.
    Channel { function: u16 },
    /// It was of the fence that an ArduPlane had for itself: an altitude whose kind then counts, in the bits of
    /// FENCE_TYPE.
    FenceAltitude { kind: u8 },
    /// The autopilot does not take it over.
    Forgotten,
}

/// An older name in a file, and what was made of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OldName {
    /// The name in the file.
    pub old: String,
    /// What the autopilot calls it now.
    pub new: String,
    /// Whether the value acts under the new name: the autopilot's own conversion takes it over, and no file has the new
    /// name as well.
    pub is_taken: bool,
}

/// Why there is no parameter of a name.
pub(crate) fn no_parameter(rules: &Rules, name: &str) -> ParameterError {
    let old = name.to_owned();
    match find(rules, name) {
        Some(Renamed { new, .. }) => ParameterError::Renamed { old, new: (*new).to_owned() },
        None => ParameterError::Unknown(old),
    }
}

fn find(rules: &Rules, old: &str) -> Option<&'static Renamed> {
    rules.renamed_parameters.iter().find(|renamed| renamed.old.eq_ignore_ascii_case(old))
}

impl ParameterFile {
    /// The same with the names that an autopilot has now, and the values as its own conversion makes them when it is
    /// updated; and which names were older. A value of the new name goes before one of the old.
    #[must_use]
    pub fn renamed_for(&self, personality: Personality) -> (Self, Vec<OldName>) {
        let rules = personality.rules();
        let mut told = Vec::new();
        let is_given = |name: &str| self.entries().iter().any(|entry| entry.name.eq_ignore_ascii_case(name));
        let mut entries = Vec::with_capacity(self.entries().len());
        for entry in self.entries() {
            let Some(renamed) = find(rules, &entry.name) else {
                entries.push(entry.clone());
                continue;
            };
            let new = new_entry(renamed, entry).filter(|new| !is_given(&new.name));
            let name = new.as_ref().map_or_else(|| renamed.new.to_owned(), |new| new.name.clone());
            told.push(OldName { old: entry.name.clone(), new: name, is_taken: new.is_some() });
            entries.extend(new);
        }
        let kinds = fence_kinds(rules, self.entries());
        if kinds != 0 {
            convert_fence(&mut entries, kinds);
        }
        if told.is_empty() { (self.clone(), told) } else { (Self::of(entries), told) }
    }
}

/// A line as the autopilot would have it now; none if it does not take it over.
fn new_entry(renamed: &Renamed, entry: &ParameterEntry) -> Option<ParameterEntry> {
    let (name, value) = match renamed.conversion {
        Conversion::FenceAltitude { .. } => (renamed.new.to_owned(), entry.value),
        Conversion::Times(factor) => (renamed.new.to_owned(), entry.value * factor),
        Conversion::Channel { function } if entry.value >= 1.0 => {
            (renamed.new.replace('#', &format!("{}", entry.value as u8)), f64::from(function))
        }
        Conversion::Channel { .. } | Conversion::Forgotten => return None,
    };
    // The type was that of the old one.
    Some(ParameterEntry { name, value, kind: None, ..entry.clone() })
}

/// The kinds of altitude fences that older names ask for.
fn fence_kinds(rules: &Rules, entries: &[ParameterEntry]) -> u8 {
    let kind_of = |entry: &ParameterEntry| match find(rules, &entry.name)?.conversion {
        Conversion::FenceAltitude { kind } => Some(kind),
        _ => None,
    };
    entries.iter().filter_map(kind_of).fold(0, |kinds, kind| kinds | kind)
}

/// FENCE_TYPE and FENCE_ACTION of a fence from before 4.1, whose actions had other numbers.
fn convert_fence(entries: &mut Vec<ParameterEntry>, kinds: u8) {
    const POLYGON: u8 = 4;
    if let Some(action) = entries.iter_mut().find(|entry| entry.name == "FENCE_ACTION") {
        action.value = match action.value as i64 {
            1 => 6.0, // GUIDED
            3 => 7.0, // GUIDED, the throttle the pilot's
            4 => 1.0, // RTL
            _ => 0.0,
        };
    }
    if let Some(like) = entries.first().filter(|_| entries.iter().all(|entry| entry.name != "FENCE_TYPE")).cloned() {
        entries.push(ParameterEntry { name: "FENCE_TYPE".into(), value: f64::from(POLYGON | kinds), ..like });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(values: &[(&str, f64)], personality: Personality) -> (Vec<(String, f64)>, Vec<OldName>) {
        let file: ParameterFile = values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let (file, told) = file.renamed_for(personality);
        (file.entries().iter().map(|entry| (entry.name.clone(), entry.value)).collect(), told)
    }

    #[test]
    fn older_names_are_converted_as_arduplane_converts_them() {
        let given = [("SYSID_THISMAV", 3.0), ("TRIM_ARSPD_CM", 2200.0), ("RST_SWITCH_CH", 7.0), ("FENCE_CHANNEL", 0.0)];
        let (values, told) = converted(&given, Personality::ArduPlane);
        let expected = [("MAV_SYSID", 3.0), ("AIRSPEED_CRUISE", 22.0), ("RC7_OPTION", 96.0)];
        assert_eq!(values, expected.map(|(name, value)| (name.to_owned(), value)));
        let told: Vec<_> = told.iter().map(|name| (&name.old[..], &name.new[..], name.is_taken)).collect();
        assert_eq!(
            told,
            [
                ("SYSID_THISMAV", "MAV_SYSID", true),
                ("TRIM_ARSPD_CM", "AIRSPEED_CRUISE", true),
                ("RST_SWITCH_CH", "RC7_OPTION", true),
                ("FENCE_CHANNEL", "RC#_OPTION", false),
            ]
        );
    }

    #[test]
    fn a_new_name_goes_before_an_old_one_and_what_is_not_taken_over_is_told() {
        let given = [("LIM_ROLL_CD", 6500.0), ("ROLL_LIMIT_DEG", 40.0), ("SR0_EXTRA1", 10.0)];
        let (values, told) = converted(&given, Personality::ArduPlane);
        assert_eq!(values, [("ROLL_LIMIT_DEG".to_owned(), 40.0)]);
        assert!(told.iter().all(|name| !name.is_taken) && told.len() == 2);
    }

    #[test]
    fn a_fence_of_before_has_its_kinds_and_its_action() {
        let (values, _) = converted(&[("FENCE_MAXALT", 90.0), ("FENCE_ACTION", 4.0)], Personality::ArduPlane);
        let expected = [("FENCE_ALT_MAX", 90.0), ("FENCE_ACTION", 1.0), ("FENCE_TYPE", 5.0)];
        assert_eq!(values, expected.map(|(name, value)| (name.to_owned(), value)));
    }

    #[test]
    fn another_autopilot_has_never_had_these_names() {
        let given = [("SYSID_THISMAV", 3.0)];
        assert_eq!(converted(&given, Personality::Px4), (vec![("SYSID_THISMAV".to_owned(), 3.0)], vec![]));
    }

    #[test]
    fn every_new_name_fits_the_wire_and_no_old_one_is_another_new_one() {
        let renamed = Personality::ArduPlane.rules().renamed_parameters;
        for one in renamed {
            assert!(one.new.len() <= mavlink_bridge::PARAMETER_NAME_MAX && one.old != one.new);
            assert!(renamed.iter().filter(|other| other.old == one.old).count() == 1, "{}", one.old);
            assert!(renamed.iter().all(|other| other.new != one.old), "{}", one.old);
        }
    }
}
