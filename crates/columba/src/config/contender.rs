//! Contenders: ways of flying a scenario that are compared, each a layer over it.

use super::layer::Layer;
use super::source::Source;
use super::{ConfigError, Overrides, Preset, Provenance, Scenario, ScenarioFile};
use optimizer::{Algorithm, OptimizerSettings};
use std::path::Path;
use toml_edit::{Item, Table};

/// One of those that are compared.
#[derive(Clone, Debug)]
pub struct Contender {
    /// What tables and reports call it.
    pub name: String,
    layer: Layer,
}

/// A scenario as a contender flies it, at any seed.
#[derive(Clone, Debug)]
pub struct Entry {
    file: ScenarioFile,
    provenance: Provenance,
}

/// What a comparison decides itself, and why nobody else may.
const RESERVED: [(&str, &str); 2] = [
    ("scenario.name", "must be left out: all contenders fly the same scenario"),
    ("scenario.seed", "must be left out: --seeds says which seeds are flown"),
];
/// Longer names make no table.
const NAME_CHARS_MAX: usize = 60;

impl Contender {
    /// The scenario with another optimiser.
    pub fn with_optimizer(algorithm: Algorithm, name: &str) -> Option<Self> {
        let toml = format!("optimizer.algorithm = \"{}\"", algorithm.key());
        let layer = Layer::of_flag(&format!("contender \"{name}\""), &toml).ok()?;
        Some(Self { name: name.to_owned(), layer })
    }

    /// What it lays over a scenario, as TOML.
    pub fn toml(&self) -> String {
        self.layer.toml()
    }
}

/// Reads a file of `[[contender]]` tables, in their order.
///
/// # Errors
/// One [`ConfigError`] that names every contender that is none, by file and line.
pub fn read_contenders(path: &Path) -> Result<Vec<Contender>, ConfigError> {
    contenders(&Source::read(path, "a file of [[contender]] tables (TOML)")?)
}

pub(super) fn contenders(source: &Source) -> Result<Vec<Contender>, ConfigError> {
    let document = source.parsed()?;
    let root = document.as_table();
    if let Some((key, item)) = root.iter().find(|(key, _)| *key != "contender") {
        let message = format!("{key}: unknown key: a file of contenders has only [[contender]] tables");
        let span = item.span().or_else(|| root.key(key).and_then(toml_edit::Key::span));
        return Err(source.refuse_at(span.map_or(0, |span| span.start), &message));
    }
    let Some(tables) = root.get("contender").and_then(Item::as_array_of_tables).filter(|tables| !tables.is_empty())
    else {
        return Err(ConfigError::new(vec![format!(
            "{}: no contender: must have a table [[contender]] for each, with a name",
            source.name()
        )]));
    };
    let mut contenders: Vec<Contender> = Vec::with_capacity(tables.len());
    let mut lines = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        match contender(source, index + 1, table) {
            Ok(contender) if contenders.iter().any(|other| other.name == contender.name) => {
                let message =
                    format!("contender[{}].name = {:?}: must be no other contender's", index + 1, contender.name);
                lines.extend(source.refuse_at(offset(table, "name"), &message).lines);
            }
            Ok(contender) => contenders.push(contender),
            Err(error) => lines.extend(error.lines),
        }
    }
    if lines.is_empty() { Ok(contenders) } else { Err(ConfigError::new(lines)) }
}

fn contender(source: &Source, number: usize, table: &Table) -> Result<Contender, ConfigError> {
    let path = format!("contender[{number}]");
    let refuse = |key: &str, message: String| source.refuse_at(offset(table, key), &format!("{path}{message}"));
    let name = match table.get("name") {
        None => return Err(refuse("", ": the key name is missing".to_owned())),
        Some(item) => item.as_str().map(str::trim).filter(|name| {
            !name.is_empty() && !name.chars().any(char::is_control) && name.chars().count() <= NAME_CHARS_MAX
        }),
    };
    let Some(name) = name else {
        let wanted = format!("must be a text in quotes, of 1 to {NAME_CHARS_MAX} visible characters");
        return Err(refuse("name", format!(".name: {wanted}")));
    };
    let mut tables = table.clone();
    tables.remove("name");
    let subject = format!("contender \"{name}\"");
    let layer = Layer::of_file(source.name(), source.text(), &path, &subject, Some(&tables));
    let layer = layer.ok_or_else(|| refuse("", ": cannot be read".to_owned()))?;
    reserved(&layer)?;
    Ok(Contender { name: name.to_owned(), layer })
}

/// Where a key of a table is written, or else the table.
fn offset(table: &Table, key: &str) -> usize {
    let span = table.get(key).and_then(Item::span).or_else(|| table.span());
    span.map_or(0, |span| span.start)
}

fn reserved(layer: &Layer) -> Result<(), ConfigError> {
    let told = RESERVED.iter().find_map(|(key, why)| layer.find(key).map(|found| (key, why, found)));
    told.map_or(Ok(()), |(key, why, found)| Err(ConfigError::new(vec![format!("{}: {key}: {why}", found.place)])))
}

impl Layer {
    /// `--set KEY=VALUE`, as in `look_ahead.horizon_s=0.5`. A value that is no TOML is a text.
    ///
    /// # Errors
    /// It has no key, or sets what a comparison decides.
    pub fn setting(text: &str) -> Result<Self, String> {
        let wanted =
            || "must be KEY=VALUE with a key as in docs/scenario.md, such as look_ahead.horizon_s=1.5".to_owned();
        let (key, value) = text.split_once('=').ok_or_else(wanted)?;
        let (key, value) = (key.trim(), value.trim());
        let is_key = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c));
        if !is_key || value.is_empty() {
            return Err(wanted());
        }
        let written = format!("{key} = {value}");
        let quoted = || format!("{key} = {}", toml_edit::Value::from(value));
        let layer =
            Self::of_flag("--set", &written).or_else(|_| Self::of_flag("--set", &quoted())).map_err(|_| wanted())?;
        reserved(&layer).map_err(|error| error.to_string())?;
        Ok(layer)
    }

    /// `--preset`.
    pub fn preset(preset: Preset) -> Option<Self> {
        let name = clap::ValueEnum::to_possible_value(&preset)?;
        Self::of_flag("--preset", &format!("preset = \"{}\"", name.get_name())).ok()
    }
}

impl Entry {
    /// A scenario file (the paper's flight where no path is given) with changes for all contenders, and with each of these.
    ///
    /// # Errors
    /// The file is wrong, or it is with a layer over it; every fault names the contender, and its own line where it has one.
    pub fn of_all(path: Option<&Path>, changes: &[Layer], contenders: &[Contender]) -> Result<Vec<Self>, ConfigError> {
        let ground = super::source_of(path)?;
        let changes: Vec<&Layer> = changes.iter().collect();
        // Each alone before all together: what is wrong without a contender is no contender's fault.
        for layers in [&[][..], &changes] {
            super::tables(ground.with(layers), &Overrides::default())?;
        }
        let mut entries = Vec::with_capacity(contenders.len());
        let mut lines = Vec::new();
        for contender in contenders {
            let layers: Vec<&Layer> = changes.iter().copied().chain([&contender.layer]).collect();
            match super::tables(ground.with(&layers), &Overrides::default()) {
                Ok((file, provenance)) => entries.push(Self { file, provenance }),
                Err(error) => lines.extend(error.lines),
            }
        }
        if lines.is_empty() { Ok(entries) } else { Err(ConfigError::new(lines)) }
    }

    /// The scenario's name.
    pub fn name(&self) -> &str {
        &self.file.scenario.name
    }

    /// Who picks the weights.
    pub fn optimizer(&self) -> &OptimizerSettings {
        &self.file.optimizer
    }

    /// What flies with a seed.
    ///
    /// # Errors
    /// With this seed, a vehicle of a random pattern starts where it must not.
    pub fn scenario(&self, seed: u64) -> Result<Scenario, ConfigError> {
        let mut file = self.file.clone();
        file.scenario.seed = seed;
        super::scenario(file, self.provenance.clone())
            .map_err(|error| ConfigError::new(error.lines.iter().map(|line| format!("{line} (seed {seed})")).collect()))
    }

    /// Everything of the scenario that decides a flight in memory, but for its seed: the same text, the same flight.
    ///
    /// # Errors
    /// A setting cannot be written as JSON, which none that is in its range does.
    pub fn identity(&self) -> Result<String, serde_json::Error> {
        let mut file = self.file.clone();
        file.scenario.seed = 0;
        file.link = Default::default();
        file.output = Default::default();
        serde_json::to_string(&file)
    }
}
