//! The layers of a scenario: what they come to together, and which of them a setting came from.
//!
//! From the lowest to the topmost: a preset, the scenario file, and what is laid over that, in order. A setting has the
//! value of the topmost layer that has it; a key that no layer has is a default.

use super::airframe::{self, AirframeKey};
use super::diagnostics;
use super::fault::{Fault, Faults, Subject};
use super::file::{Preset, ScenarioFile};
use super::flags;
use super::layer::{self, Found, Layer, Origin};
use super::locate::{key_at, locate, misplaced_array, quote};
use super::source::ConfigError;
use crate::counted::counted;
use controller::ControllerSettings;
use flight_model::Airframe;
use serde::de::DeserializeOwned;
use sim_vehicle::Personality;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use toml_edit::{Document, DocumentMut, Item, TableLike};

/// So often something is put in place of what cannot be read.
const REPAIRS_MAX: usize = 100;
/// More faults than this are counted only.
const FAULTS_SHOWN_MAX: usize = 20;

/// The layers of a scenario.
#[derive(Clone, Debug)]
pub struct Provenance {
    /// The lowest first.
    layers: Arc<[Layer]>,
    /// Which of them is the scenario file.
    file: usize,
    /// The file's name.
    name: Arc<str>,
    /// Lines of the file could not be read: keys that seem to be missing may stand there.
    has_gaps: bool,
}

impl Provenance {
    /// A scenario file by its name, with layers over it.
    pub(super) fn new(name: &str, file: Layer, over: &[&Layer], has_gaps: bool) -> Self {
        let layers: Vec<Layer> = std::iter::once(&file).chain(over.iter().copied()).cloned().collect();
        let provenance = Self { layers: layers.into(), file: 0, name: name.into(), has_gaps };
        let flown = provenance.airframe_of_its_own();
        let layer = |toml: &str| Layer::of_preset(&format!("airframe {}", flown.as_ref()?.0), toml).ok();
        let base = flown.as_ref().and_then(|(_, airframe)| layer(&airframe::toml(airframe)));
        // The paper's speed is no other airframe's.
        let speed = flown
            .as_ref()
            .filter(|_| name == super::PAPER_NAME)
            .and_then(|(_, airframe)| layer(&format!("flock.expected_speed_mps = {:?}", airframe.cruise_speed_mps)));
        let below: Vec<Layer> = provenance.preset().into_iter().chain(base).collect();
        let file = below.len();
        let (own, over) = provenance.layers.split_at(1);
        let layers = below.into_iter().chain(own.iter().cloned()).chain(speed).chain(over.iter().cloned()).collect();
        Self { layers, file, ..provenance }
    }

    /// The airframe that a scenario names, if it does, or what is wrong with it.
    pub(super) fn airframe(&self, file: &ScenarioFile) -> Option<Result<Airframe, String>> {
        let folder = self.folder("airframe");
        let airframe = file.airframe.as_ref()?.resolve(&folder, file.autopilot.personality);
        Some(airframe.map_err(|wrong| match self.find("airframe") {
            Some((_, found)) => format!("{}: {wrong}", found.place),
            None => wrong,
        }))
    }

    /// The airframe that the topmost layer with one names, and how messages call it; none for the paper's and for what
    /// is none.
    fn airframe_of_its_own(&self) -> Option<(String, Airframe)> {
        /// All that an airframe depends on.
        #[derive(serde::Deserialize)]
        struct Keys {
            airframe: AirframeKey,
            #[serde(default)]
            autopilot: Autopilot,
            #[serde(default)]
            dynamics: Speeds,
        }
        #[derive(Default, serde::Deserialize)]
        struct Speeds {
            speed_min_mps: Option<f64>,
            speed_max_mps: Option<f64>,
        }
        #[derive(Default, serde::Deserialize)]
        struct Autopilot {
            #[serde(default)]
            personality: Personality,
        }
        let Keys { airframe, autopilot, dynamics } = toml_edit::de::from_document(self.merged()).ok()?;
        if airframe.is_paper() {
            return None;
        }
        let mut flown = airframe.resolve(&self.folder("airframe"), autopilot.personality).ok()?;
        // It cruises within limits that a scenario narrows.
        let limits = flown.dynamics.limits;
        let slowest_mps = dynamics.speed_min_mps.unwrap_or(limits.speed_min_mps);
        let fastest_mps = dynamics.speed_max_mps.unwrap_or(limits.speed_max_mps);
        if slowest_mps <= fastest_mps {
            flown.cruise_speed_mps = flown.cruise_speed_mps.clamp(slowest_mps, fastest_mps);
        }
        Some((airframe.name().to_owned(), flown))
    }

    /// The layer of the preset that the topmost layer with one names; none for the defaults and for names that are
    /// none.
    fn preset(&self) -> Option<Layer> {
        let document = self.merged();
        let name = document.get("preset").and_then(Item::as_str)?;
        let settings = match Preset::of_name(name)? {
            Preset::Default => return None,
            Preset::Paper => ControllerSettings::paper(),
            Preset::Literal => ControllerSettings::literal(),
        };
        Layer::of_preset(name, &toml_edit::ser::to_string(&settings).ok()?).ok()
    }

    /// The same with the file alone and the first layers over it: 0 of them, 1 and so on.
    fn prefixes(&self) -> impl Iterator<Item = Self> {
        let (file, over) = (&self.layers[self.file], &self.layers[self.file + 1..]);
        (0..=over.len()).map(move |count| {
            let over: Vec<&Layer> = over[..count].iter().collect();
            Self::new(&self.name, file.clone(), &over, self.has_gaps)
        })
    }

    /// All layers as one document.
    fn merged(&self) -> DocumentMut {
        let mut merged = DocumentMut::new();
        for layer in self.layers.iter() {
            layer.lay_over(&mut merged);
        }
        merged
    }

    /// All layers as a value of `T`. Every unknown key, wrong type and missing key is a fault; the value then has
    /// something else in their place, so that the rest can be checked. None where there is no such value.
    pub(super) fn read<T: DeserializeOwned>(&self, faults: &mut Faults) -> Option<T> {
        let mut document = self.merged();
        layer::make_explicit(document.as_table_mut());
        for _ in 0..REPAIRS_MAX {
            let misplaced = misplaced_array(document.as_table(), "");
            if misplaced.is_none()
                && let Ok(value) = toml_edit::de::from_document(document.clone())
            {
                return Some(value);
            }
            if faults.len() > FAULTS_SHOWN_MAX || !repair::<T>(&mut document, misplaced, self.has_gaps, faults) {
                break;
            }
        }
        None
    }

    /// The topmost layer that has a key, and where.
    fn find(&self, key: &str) -> Option<(&Layer, Found)> {
        let has = |layer: &'_ Layer| layer.find(key).filter(|found| found.is_there);
        self.layers.iter().rev().find_map(|layer| has(layer).map(|found| (layer, found)))
    }

    /// The folder that a path at a key is relative to.
    pub(super) fn folder(&self, key: &str) -> PathBuf {
        self.find(key).map(|(layer, _)| layer.folder()).unwrap_or_default()
    }

    /// The paths of a list, of all layers that have one: the lowest first, each relative to what it is written in.
    pub(super) fn paths(&self, table: &str, key: &str) -> Vec<PathBuf> {
        self.layers.iter().flat_map(|layer| layer.paths(table, key)).collect()
    }

    /// A value as the system gave it to a flag.
    pub(super) fn raw(&self, key: &str) -> Option<&OsString> {
        self.find(key).and_then(|(layer, _)| layer.raw())
    }

    /// Whether a setting is from the command line.
    pub fn is_of_command_line(&self, key: &str) -> bool {
        self.find(key).is_some_and(|(layer, _)| matches!(layer.origin(), Origin::Flag { .. }))
    }

    /// Where a setting came from, for one that proves wrong only later (a busy port): `--ground-port 14550`,
    /// `field.toml:40: link.ground_port = 14550`, or, where it is a default, the names of the key and of its flag.
    pub fn of(&self, key: &str) -> String {
        match self.find(key) {
            Some((layer, _)) if layer.sets(key) => layer.origin().to_string(),
            Some((_, Found { place, value: Some(value), .. })) => format!("{place}: {key} = {value}"),
            _ => match flags::of_key(key) {
                Some(flag) => format!("{key} (by default; {flag} sets it)"),
                None => format!("{key} (by default)"),
            },
        }
    }

    /// Whether any layer says something of a key.
    pub fn names(&self, key: &str) -> bool {
        self.find(key).is_some()
    }

    /// An error with every fault at its place, in the order of the lines, if there is any. `check` finds the faults of
    /// other layers: a fault of the file that it has only with a layer over it is told with that layer.
    pub(super) fn refuse(&self, faults: &Faults, check: impl Fn(&Self) -> Faults) -> Result<(), ConfigError> {
        if faults.is_empty() {
            return Ok(());
        }
        let prefixes: Vec<Faults> = if self.layers.len() > self.file + 1 {
            self.prefixes().map(|layers| check(&layers)).collect()
        } else {
            Vec::new()
        };
        let blamed = |fault: &Fault| {
            let first = prefixes.iter().position(|faults| faults.has(fault)).filter(|&first| first > 0)?;
            self.layers.get(self.file + first)
        };
        // Enough to sort what is shown by line; finding the lines of tens of thousands would take long.
        let first = faults.iter().take(50 * FAULTS_SHOWN_MAX).map(|fault| self.tell(fault, &blamed));
        let mut error = ConfigError::in_order(faults.placed().iter().cloned().chain(first).collect());
        error.lines.truncate(FAULTS_SHOWN_MAX);
        let more = faults.len().saturating_sub(FAULTS_SHOWN_MAX);
        if more > 0 {
            error.lines.push(format!("{}: and {} more", self.name, counted(more, "fault")));
        }
        Err(error)
    }

    /// The line of a fault, 0 where it has none, and its message.
    fn tell<'a>(&'a self, fault: &Fault, blamed: &impl Fn(&Fault) -> Option<&'a Layer>) -> (usize, String) {
        let (key, wanted) = (&fault.key, &fault.wanted);
        if let Some((layer, Found { place, line, value, .. })) = self.find(key).filter(|(layer, _)| !layer.is_preset())
        {
            let is_flags_own = layer.sets(key);
            let subject = match &fault.subject {
                Subject::Of(subject) => format!("{subject}: "),
                _ if is_flags_own => String::new(),
                Subject::Key => format!("{key}: "),
                Subject::Value(default) => format!("{key} = {}: ", value.as_ref().unwrap_or(default)),
            };
            let with = blamed(fault).filter(|_| layer.is_file()).map(|layer| format!(": with {}", layer.origin()));
            return (line, format!("{place}{}: {subject}{wanted}", with.unwrap_or_default()));
        }
        let subject = match (&fault.subject, self.find(key)) {
            (Subject::Of(subject), _) => format!("{subject}: "),
            (Subject::Key, _) if key.is_empty() => String::new(),
            (Subject::Key, _) => format!("{key}: "),
            (Subject::Value(_), Some((preset, found))) => {
                format!("{key} = {} (by {}): ", found.value.unwrap_or_default(), preset.origin())
            }
            (Subject::Value(default), None) => format!("{key} = {default} (by default): "),
        };
        // The nearest table of the file that would hold it.
        let near = self.layers[self.file].find(key);
        let line = near.as_ref().map_or(usize::from(key.is_empty()), |found| found.line);
        let place = match near {
            Some(found) => found.place,
            None if line > 0 => format!("{}:{line}", self.name),
            None => self.name.to_string(),
        };
        let with = blamed(fault).map(|layer| format!(": with {}", layer.origin())).unwrap_or_default();
        (line, format!("{place}{with}: {subject}{wanted}"))
    }
}

/// Tells what keeps a document from being a `T`, and puts something else in its place; false where it cannot.
fn repair<T: DeserializeOwned>(
    document: &mut DocumentMut,
    misplaced: Option<String>,
    has_gaps: bool,
    faults: &mut Faults,
) -> bool {
    // Only a text that was parsed has the places that errors name.
    let text = document.to_string();
    let Ok(parsed) = Document::parse(text.as_str()) else { return false };
    let error = toml_edit::de::from_str::<T>(&text).err();
    let unknown = error.as_ref().is_some_and(|error| diagnostics::is_unknown_key(error.message()));
    if let Some(key) = misplaced.filter(|_| !unknown) {
        faults.add_key(&key, diagnostics::TABLE_ONCE);
        return layer::remove(document.as_table_mut(), &key);
    }
    let Some(error) = error else { return false };
    let span = error.span().unwrap_or_default();
    let key = key_at(parsed.as_table(), &span, "").unwrap_or_default();
    if let Some(name) = diagnostics::missing_key(error.message()) {
        // Where a table of the file itself is missing, the reader points at whatever comes first.
        let key = if ["scenario", "flock"].contains(&name) { String::new() } else { key };
        let missing = if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
        let is_told = faults.tells(&missing);
        faults.stand_in(&missing);
        if !is_told && !has_gaps {
            faults.add_missing(&key, name);
        }
        return layer::table_at(document.as_table_mut(), &key).is_some_and(|table| fill(table, name));
    }
    if let Some(meant) = diagnostics::meant_key(error.message(), &key).filter(|meant| !has(&parsed, meant)) {
        // That it is missing follows from the key that is misspelt.
        faults.stand_in(&meant);
    }
    let (subject, wanted) = diagnostics::say(error.message(), &key, &quote(&text, span));
    faults.add_fault(Fault { key: key.clone(), subject, wanted });
    faults.stand_in(&key);
    layer::remove(document.as_table_mut(), &key)
}

fn has(document: &Document<&str>, key: &str) -> bool {
    locate(document.as_table(), key).is_some_and(|found| found.is_there)
}

/// Something in place of a key that is missing; nothing is checked against it.
fn fill(table: &mut dyn TableLike, name: &str) -> bool {
    let item = match name {
        "scenario" | "flock" => toml_edit::table(),
        "name" => toml_edit::value("unnamed"),
        _ => toml_edit::value(1.0),
    };
    table.insert(name, item).is_none()
}

impl Layer {
    fn is_preset(&self) -> bool {
        matches!(self.origin(), Origin::Preset(_))
    }

    fn is_file(&self) -> bool {
        matches!(self.origin(), Origin::File(_))
    }
}

impl Preset {
    /// The preset of a name.
    fn of_name(name: &str) -> Option<Self> {
        <Self as clap::ValueEnum>::from_str(name, false).ok()
    }
}
