//! Parameter files: what `--defaults` reads, and where parameters survive a restart.
//!
//! One parser reads what ArduPilot, PX4 and their ground stations write:
//!
//! - a name and a value in each line, separated by spaces, tabs, a comma or `=` (ArduPilot, MAVProxy, Mission Planner);
//!   a third word `@READONLY` makes the parameter read-only, `@include FILE` reads another file, relative to this one;
//! - five columns: system id, component id, name, value, type (QGroundControl);
//! - `param set NAME VALUE`, also `set-default` and with `-s`: commands of PX4's shell.
//!
//! A `#` begins a comment. The last value of a name counts.

use super::inert::{Inert, InertParameter};
use crate::firmware::rules::Rules;
use mavlink_bridge::PARAMETER_NAME_MAX;
use mavlink_bridge::dialect::MavParamType::{
    self, MAV_PARAM_TYPE_INT8 as INT8, MAV_PARAM_TYPE_INT16 as INT16, MAV_PARAM_TYPE_INT32 as INT32,
    MAV_PARAM_TYPE_REAL32 as REAL, MAV_PARAM_TYPE_UINT8 as UINT8, MAV_PARAM_TYPE_UINT16 as UINT16,
    MAV_PARAM_TYPE_UINT32 as UINT32,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Why a parameter file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ParameterFileError {
    /// It cannot be opened, read or decoded.
    #[error("{}: {}", path.display(), io_reason(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A line has a value that its parameter cannot have.
    #[error("{place}: {reason}")]
    Refused {
        /// File and line.
        place: Place,
        /// What is wrong with it.
        reason: String,
    },
    /// A line is not a name and a number.
    #[error("{place}: expected NAME VALUE, found {text:?}")]
    Line {
        /// File and line.
        place: Place,
        /// What stands there.
        text: String,
    },
    /// Files include one another.
    #[error("{place}: more than {INCLUDES_MAX} levels of @include")]
    Includes {
        /// File and line.
        place: Place,
    },
    /// A file that another one includes cannot be read.
    #[error("{place}: @include {}: {}", path.display(), io_reason(source))]
    Included {
        /// File and line.
        place: Place,
        /// The file that is included.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

fn io_reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "file not found".to_owned(),
        io::ErrorKind::InvalidData => "is not a text file in UTF-8".to_owned(),
        _ => error.to_string(),
    }
}

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    file: Arc<Path>,
    line: usize,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.file.display(), self.line)
    }
}

/// What one line says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ParameterEntry {
    pub name: String,
    pub value: f64,
    /// `@READONLY`.
    pub is_read_only: bool,
    /// The type that a file of five columns states.
    pub kind: Option<MavParamType>,
    /// Whether the value is written as a whole number.
    pub is_whole: bool,
    /// Where it stands, if in a file.
    pub place: Option<Place>,
}

impl ParameterEntry {
    /// The type of an inert parameter: that of the file, or of the real autopilot. Of names that it does not know, PX4
    /// writes real numbers with a point; those of an ArduPlane are floats on the wire, whatever the type.
    pub fn kind_for(&self, rules: &Rules) -> MavParamType {
        if rules.tells_whole_numbers_as_floats {
            return REAL;
        }
        let known = self.kind.or_else(|| (rules.stock)().and_then(|stock| stock.kind(&self.name)));
        if !rules.bytewise_parameters {
            return known.unwrap_or(REAL);
        }
        let is_real = known.map_or(!self.is_whole, |kind| kind == REAL);
        if is_real { REAL } else { INT32 }
    }
}

/// What parameter files say, each name once: the last value counts. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct ParameterFile(Arc<Contents>);

#[derive(Debug, Default)]
struct Contents {
    entries: Vec<ParameterEntry>,
    /// The inert parameters of the first vehicle that has asked, for all that pass for the same autopilot, with its
    /// stock parameters or without.
    inert: OnceLock<(&'static Rules, bool, Inert)>,
}

/// Most files that include one another in a row, as in ArduPilot's tools.
const INCLUDES_MAX: usize = 10;

impl ParameterFile {
    /// Reads several files as one.
    ///
    /// # Errors
    /// A file cannot be read, or one of its lines is not a parameter; the message names file and line.
    pub fn read<P: AsRef<Path>>(paths: &[P]) -> Result<Self, ParameterFileError> {
        let mut entries = Vec::new();
        for path in paths {
            let path = path.as_ref();
            let text = std::fs::read_to_string(path);
            let text = text.map_err(|source| ParameterFileError::Io { path: path.to_owned(), source })?;
            parse(path, &text, 0, &mut entries)?;
        }
        Ok(Self::of(entries))
    }

    /// One that is part of the program, and has been tested with it.
    pub(crate) fn recorded(text: &str) -> Self {
        let mut entries = Vec::new();
        // Where a line is wrong, those before it count: a test reads all.
        let _ = parse(Path::new("recorded"), text, 0, &mut entries);
        Self::of(entries)
    }

    pub(super) fn of(entries: Vec<ParameterEntry>) -> Self {
        Self(Arc::new(Contents { entries: last_of_each(entries), inert: OnceLock::new() }))
    }

    /// Whether no file says anything.
    pub fn is_empty(&self) -> bool {
        self.0.entries.is_empty()
    }

    /// The same without the vehicle's system id: for several vehicles, each of which has its own.
    #[must_use]
    pub fn without_system_id(&self) -> Self {
        let is_id = |name: &str| ["MAV_SYSID", "MAV_SYS_ID"].iter().any(|id| name.eq_ignore_ascii_case(id));
        Self::of(self.entries().iter().filter(|entry| !is_id(&entry.name)).cloned().collect())
    }

    pub(crate) fn entries(&self) -> &[ParameterEntry] {
        &self.0.entries
    }

    /// Those that do not act, inert, behind those of the stock autopilot if it is to have them; all vehicles share one
    /// list.
    pub(super) fn inert(&self, rules: &'static Rules, has_stock: bool, acts: impl Fn(&str) -> bool) -> Inert {
        let inert = || {
            Inert::new(
                self.inert_parameters(rules, has_stock, &acts),
                self.unlisted_parameters(rules, has_stock, &acts),
            )
        };
        let (of, with_stock, shared) = self.0.inert.get_or_init(|| (rules, has_stock, inert()));
        if std::ptr::eq(*of, rules) && *with_stock == has_stock { shared.clone() } else { inert() }
    }

    /// What the stock autopilot has and does not list, but for what acts or stands in these files.
    fn unlisted_parameters(&self, rules: &Rules, has_stock: bool, acts: impl Fn(&str) -> bool) -> Vec<InertParameter> {
        let unlisted = (rules.stock)().filter(|_| has_stock).map_or(&[][..], |stock| stock.unlisted().entries());
        let own: BTreeSet<String> = self.entries().iter().map(|entry| rules.parameter_key(&entry.name)).collect();
        let is_free = |entry: &&ParameterEntry| !acts(&entry.name) && !own.contains(&rules.parameter_key(&entry.name));
        unlisted.iter().filter(is_free).map(|entry| InertParameter::new(entry, rules, true)).collect()
    }

    fn inert_parameters(&self, rules: &Rules, has_stock: bool, acts: impl Fn(&str) -> bool) -> Vec<InertParameter> {
        let stock = (rules.stock)().filter(|_| has_stock).map_or(&[][..], |stock| stock.parameters().entries());
        let mut own: BTreeMap<String, &ParameterEntry> =
            self.entries().iter().map(|entry| (rules.parameter_key(&entry.name), entry)).collect();
        let of_stock = stock.iter().filter(|entry| !acts(&entry.name)).map(|entry| {
            match own.remove(&rules.parameter_key(&entry.name)) {
                Some(own) => InertParameter::new(own, rules, false),
                None => InertParameter::new(entry, rules, true),
            }
        });
        let mut inert: Vec<InertParameter> = of_stock.collect();
        let further = self.entries().iter().filter(|entry| own.contains_key(&rules.parameter_key(&entry.name)));
        inert.extend(further.filter(|entry| !acts(&entry.name)).map(|entry| InertParameter::new(entry, rules, false)));
        inert
    }
}

impl FromIterator<(String, f64)> for ParameterFile {
    /// Parameters that stand in no file.
    fn from_iter<I: IntoIterator<Item = (String, f64)>>(values: I) -> Self {
        let entry = |(name, value): (String, f64)| ParameterEntry {
            name,
            value,
            is_read_only: false,
            kind: None,
            is_whole: value.fract() == 0.0,
            place: None,
        };
        Self::of(values.into_iter().map(entry).collect())
    }
}

/// The file of the vehicle of an index in a state folder.
pub(crate) fn path(folder: &Path, vehicle: usize) -> PathBuf {
    folder.join(format!("vehicle-{}.parm", vehicle + 1))
}

/// What is in the file of a vehicle in a state folder; nothing if there is none.
pub(crate) fn read_kept(path: &Path) -> Result<ParameterFile, ParameterFileError> {
    match ParameterFile::read(&[path]) {
        Err(ParameterFileError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
            Ok(ParameterFile::default())
        }
        read => read,
    }
}

/// Writes a file whole, or leaves the old one as it was.
pub(crate) fn write<'a>(path: &Path, values: impl Iterator<Item = (&'a str, f64)>) -> io::Result<()> {
    let mut text = String::new();
    for (name, value) in values {
        // Single precision has shorter words for its numbers. Writing to a string cannot fail.
        let short = value as f32;
        let _ =
            if f64::from(short) == value { writeln!(text, "{name} {short}") } else { writeln!(text, "{name} {value}") };
    }
    let unfinished = path.with_extension("parm.new");
    std::fs::write(&unfinished, text)?;
    std::fs::rename(unfinished, path)
}

/// Appends what a text says, and what it includes.
fn parse(path: &Path, text: &str, depth: usize, entries: &mut Vec<ParameterEntry>) -> Result<(), ParameterFileError> {
    let file: Arc<Path> = Arc::from(path);
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let place = Place { file: Arc::clone(&file), line: index + 1 };
        if let Some(included) = line.trim().strip_prefix("@include").filter(|rest| rest.starts_with([' ', '\t'])) {
            if depth == INCLUDES_MAX {
                return Err(ParameterFileError::Includes { place });
            }
            let path = path.parent().unwrap_or(Path::new("")).join(included.trim());
            let text = std::fs::read_to_string(&path);
            let text = text.map_err(|source| ParameterFileError::Included { place, path: path.clone(), source })?;
            parse(&path, &text, depth + 1, entries)?;
            continue;
        }
        let content = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = content.split([' ', '\t', ',', '=', '\r']).filter(|word| !word.is_empty()).collect();
        let entry = match words[..] {
            [] => continue,
            ["param", "set" | "set-default", name, value] | ["param", "set" | "set-default", "-s", name, value] => {
                entry(name, value, &place)
            }
            // No parameter has so long a name: ArduPilot passes them over.
            [name, value] if is_too_long(name) && value.parse::<f64>().is_ok() => continue,
            // Those of a camera or a gimbal are not the autopilot's.
            [system, component, ..]
                if words.len() == 5 && is_number(system) && component != "1" && is_number(component) =>
            {
                continue;
            }
            [_, _, name, value, kind] => entry(name, value, &place)
                .and_then(|entry| Some(ParameterEntry { kind: Some(kind_of(kind)?), ..entry })),
            [name, value] => entry(name, value, &place),
            [name, value, "@READONLY"] => {
                entry(name, value, &place).map(|entry| ParameterEntry { is_read_only: true, ..entry })
            }
            _ => None,
        };
        entries.push(entry.ok_or_else(|| ParameterFileError::Line { place, text: line.trim().to_owned() })?);
    }
    Ok(())
}

/// A name and a value; none if they are none.
fn entry(name: &str, value: &str, place: &Place) -> Option<ParameterEntry> {
    let is_name = name.len() <= PARAMETER_NAME_MAX
        && name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let parsed = value.parse::<f64>().ok().or_else(|| hexadecimal(value)).filter(|_| is_name)?;
    Some(ParameterEntry {
        name: name.to_owned(),
        value: parsed,
        is_read_only: false,
        kind: None,
        is_whole: parsed.fract() == 0.0 && !value.contains(['.', 'e', 'E']) || value.starts_with("0x"),
        place: Some(place.clone()),
    })
}

/// Whether a word could be a name, but for its length.
fn is_too_long(name: &str) -> bool {
    name.len() > PARAMETER_NAME_MAX && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// Bit masks are written so.
fn hexadecimal(value: &str) -> Option<f64> {
    let digits = value.strip_prefix("0x").or_else(|| value.strip_prefix("0X"))?;
    u32::from_str_radix(digits, 16).ok().map(f64::from)
}

fn is_number(word: &str) -> bool {
    word.parse::<u32>().is_ok()
}

/// A type by its number in MAVLink (<https://mavlink.io/en/messages/common.html#MAV_PARAM_TYPE>).
fn kind_of(number: &str) -> Option<MavParamType> {
    let kinds = [UINT8, INT8, UINT16, INT16, UINT32, INT32, REAL];
    let number: u32 = number.parse().ok()?;
    kinds.into_iter().find(|kind| *kind as u32 == number)
}

/// Each name once, where it stood first, as the last line of it says.
fn last_of_each(entries: Vec<ParameterEntry>) -> Vec<ParameterEntry> {
    let mut at: HashMap<String, usize> = HashMap::new();
    let mut last: Vec<ParameterEntry> = Vec::with_capacity(entries.len());
    for entry in entries {
        match at.get(&entry.name) {
            Some(&index) => last[index] = entry,
            None => {
                at.insert(entry.name.clone(), last.len());
                last.push(entry);
            }
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::Personality;

    fn read(text: &str) -> Result<Vec<ParameterEntry>, ParameterFileError> {
        let mut entries = Vec::new();
        parse(Path::new("x.parm"), text, 0, &mut entries)?;
        Ok(last_of_each(entries))
    }

    fn values(entries: &[ParameterEntry]) -> Vec<(&str, f64)> {
        entries.iter().map(|entry| (&entry.name[..], entry.value)).collect()
    }

    #[test]
    fn commands_of_px4s_shell_are_read_and_names_that_are_too_long_are_passed_over() {
        let text = "# an airframe\nparam set-default ASPD_DO_CHECKS 19\nparam set -s FW_R_LIM 40.5\n\
                    SIM_GPS1_BYTELOSS,0\nTHR_MAX 75\n";
        let entries = read(text).unwrap();
        assert_eq!(values(&entries), [("ASPD_DO_CHECKS", 19.0), ("FW_R_LIM", 40.5), ("THR_MAX", 75.0)]);
        assert!(read("param reset FW_R_LIM\n").is_err());
        assert!(read("SIM_GPS1_BYTELOSS,none\n").is_err());
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = path(folder.path(), 0);
        assert!(path.ends_with("vehicle-1.parm"));
        assert!(read_kept(&path).unwrap().is_empty());
        let written =
            [("WP_LOITER_RAD", -80.0), ("AIRSPEED_CRUISE", f64::from(11.1_f32)), ("CAL_ACC0_ID", 16_777_217.0)];
        write(&path, written.into_iter()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "WP_LOITER_RAD -80\nAIRSPEED_CRUISE 11.1\nCAL_ACC0_ID 16777217\n");
        let read = read_kept(&path).unwrap();
        assert_eq!(
            values(read.entries()),
            [("WP_LOITER_RAD", -80.0), ("AIRSPEED_CRUISE", 11.1), ("CAL_ACC0_ID", 16_777_217.0)]
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn ground_stations_files_are_read_and_nonsense_is_named() {
        let good =
            read("\u{feff}# saved\r\nRTL_RADIUS,90\r\n\nFS_GCS_ENABL\t1 # on\nLOG_BITMASK=0xFF\nRC1_MIN 1000.000000\n")
                .unwrap();
        assert_eq!(
            values(&good),
            [("RTL_RADIUS", 90.0), ("FS_GCS_ENABL", 1.0), ("LOG_BITMASK", 255.0), ("RC1_MIN", 1000.0)]
        );
        for bad in ["A", "A b", "A 1 2", "A 1 @READWRITE", "2A 1", "A-B 1", "A_NAME_OF_MORE_THAN_16 b", "1 1 A 1 7"] {
            let error = read(&format!("B 1\n{bad}")).unwrap_err().to_string();
            assert_eq!(error, format!("x.parm:2: expected NAME VALUE, found {bad:?}"));
        }
    }

    #[test]
    fn the_last_value_of_a_name_counts_and_read_only_is_read() {
        let entries = read("A 1\nB 2 @READONLY\nA 3\n").unwrap();
        assert_eq!(values(&entries), [("A", 3.0), ("B", 2.0)]);
        assert_eq!(
            (entries[0].place.as_ref().unwrap().to_string(), entries[1].is_read_only),
            ("x.parm:3".to_owned(), true)
        );
    }

    #[test]
    fn qgroundcontrols_columns_state_types() {
        let text = "# Onboard parameters for Vehicle 1\n#\n1\t1\tBAT1_N_CELLS\t3\t6\n\
                    1\t1\tFW_P_TC\t0.400000005960464478\t9\n1\t100\tCAM_MODE\t1\t6\n";
        let entries = read(text).unwrap();
        assert_eq!(values(&entries), [("BAT1_N_CELLS", 3.0), ("FW_P_TC", 0.400_000_005_960_464_5)]);
        assert_eq!([0, 1].map(|index| entries[index].kind_for(Personality::Px4.rules())), [INT32, REAL]);
        assert_eq!(entries[0].kind_for(Personality::ArduPlane.rules()), INT32);
    }

    #[test]
    fn without_a_type_a_px4_reads_a_point_as_real() {
        let entries = read("A 3\nB 3.0\nC 1e2\n").unwrap();
        assert_eq!([0, 1, 2].map(|index| entries[index].kind_for(Personality::Px4.rules())), [INT32, REAL, REAL]);
        assert_eq!(entries[0].kind_for(Personality::ArduPlane.rules()), REAL);
    }

    #[test]
    fn files_include_others_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, text).unwrap();
            path
        };
        file("base/all.parm", "@include more.parm\nA 1\nB 1\n");
        file("base/more.parm", "C 1\n");
        let own = file("own.parm", "@include base/all.parm\nB 2\n");
        assert_eq!(values(ParameterFile::read(&[own]).unwrap().entries()), [("C", 1.0), ("A", 1.0), ("B", 2.0)]);
        let missing = file("missing.parm", "A 1\n@include none.parm\n");
        let error = ParameterFile::read(&[&missing]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}:2: @include ", missing.display())), "{error}");
        let circle = file("circle.parm", "@include circle.parm\n");
        let error = ParameterFile::read(&[&circle]).unwrap_err().to_string();
        assert_eq!(error, format!("{}:1: more than 10 levels of @include", circle.display()));
    }
}
