//! Contenders: ways of flying a scenario that are compared, each a layer over it.

use super::layer::{Layer, Origin};
use super::source::{Parsed, Source};
use super::{ConfigError, Provenance, Scenario, ScenarioFile};
use optimizer::{Algorithm, OptimizerSettings};
use std::path::Path;
use toml_edit::{Document, Item, Table};

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
        let layer = Layer::of_contender(name, &toml).ok()?;
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

/// Reads contenders and checks each over the paper's flight.
///
/// # Errors
/// One [`ConfigError`] that names every fault of every contender, by file and line.
pub(super) fn check_contenders(source: &Source) -> Result<Vec<Contender>, ConfigError> {
    let contenders = contenders(source)?;
    Entry::of_all(None, &[], &contenders)?;
    Ok(contenders)
}

pub(super) fn contenders(source: &Source) -> Result<Vec<Contender>, ConfigError> {
    let Parsed { document, errors } = source.parsed();
    let Some(document) = document.filter(|_| errors.is_empty()) else { return Err(ConfigError::in_order(errors)) };
    let root = document.as_table();
    let mut lines = Vec::new();
    for (key, item) in root.iter().filter(|(key, _)| *key != "contender") {
        let message = format!("{key}: unknown key: a file of contenders has only [[contender]] tables");
        let span = item.span().or_else(|| root.key(key).and_then(toml_edit::Key::span));
        lines.push(source.message_at(span.map_or(0, |span| span.start), &message));
    }
    let tables = root.get("contender").and_then(Item::as_array_of_tables).filter(|tables| !tables.is_empty());
    if tables.is_none() && lines.is_empty() {
        let message = format!("{}: no contender: must have a table [[contender]] for each, with a name", source.name());
        return Err(ConfigError::new(vec![message]));
    }
    let mut contenders: Vec<Contender> = Vec::new();
    for (index, table) in tables.into_iter().flatten().enumerate() {
        match contender(source, &document, index + 1, table) {
            Ok(contender) if contenders.iter().any(|other| other.name == contender.name) => {
                let message =
                    format!("contender[{}].name = {:?}: must be no other contender's", index + 1, contender.name);
                lines.push(source.message_at(offset(table, "name"), &message));
            }
            Ok(contender) => contenders.push(contender),
            Err(line) => lines.push(line),
        }
    }
    if lines.is_empty() { Ok(contenders) } else { Err(ConfigError::in_order(lines)) }
}

fn contender(
    source: &Source,
    document: &Document<String>,
    number: usize,
    table: &Table,
) -> Result<Contender, (usize, String)> {
    let path = format!("contender[{number}]");
    let refuse = |key: &str, message: &str| source.message_at(offset(table, key), &format!("{path}{message}"));
    let name = match table.get("name") {
        None => return Err(refuse("", ": the key name is missing")),
        Some(item) => item.as_str().map(str::trim).filter(|name| {
            !name.is_empty() && !name.chars().any(char::is_control) && name.chars().count() <= NAME_CHARS_MAX
        }),
    };
    let Some(name) = name else {
        let wanted = format!(".name: must be a text in quotes, of 1 to {NAME_CHARS_MAX} visible characters");
        return Err(refuse("name", &wanted));
    };
    let mut tables = table.clone();
    tables.remove("name");
    let origin = Origin::Contender { file: Some(source.name().to_owned()), name: name.to_owned() };
    let layer = Layer::of_table(origin, document.clone(), &path, &tables);
    match reserved(&layer) {
        Some(fault) => Err(fault),
        None => Ok(Contender { name: name.to_owned(), layer }),
    }
}

/// Where a key of a table is written, or else the table.
fn offset(table: &Table, key: &str) -> usize {
    let span = table.get(key).and_then(Item::span).or_else(|| table.span());
    span.map_or(0, |span| span.start)
}

/// The line and the message of a key that a comparison decides itself.
fn reserved(layer: &Layer) -> Option<(usize, String)> {
    RESERVED.iter().find_map(|(key, why)| {
        let found = layer.find(key).filter(|found| found.is_there)?;
        let key = if layer.sets(key) { String::new() } else { format!("{key}: ") };
        Some((found.line, format!("{}: {key}{why}", found.place)))
    })
}

/// Refuses layers over all contenders that set what a comparison decides itself.
///
/// # Errors
/// One of them does.
pub fn refuse_reserved(layers: &[Layer]) -> Result<(), ConfigError> {
    let lines: Vec<(usize, String)> = layers.iter().filter_map(reserved).collect();
    if lines.is_empty() { Ok(()) } else { Err(ConfigError::in_order(lines)) }
}

impl Entry {
    /// A scenario file (the paper's flight where no path is given) with changes for all contenders, and with each of
    /// these.
    ///
    /// # Errors
    /// The scenario is wrong, or a contender of it.
    pub fn of_all(path: Option<&Path>, changes: &[Layer], contenders: &[Contender]) -> Result<Vec<Self>, ConfigError> {
        let source = super::source_of(path)?;
        let changes: Vec<&Layer> = changes.iter().collect();
        // What is wrong without a contender is no contender's fault.
        super::tables(&source, &changes)?;
        let mut entries = Vec::with_capacity(contenders.len());
        let mut lines = Vec::new();
        for contender in contenders {
            let layers: Vec<&Layer> = changes.iter().copied().chain([&contender.layer]).collect();
            match super::tables(&source, &layers) {
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
        file.ground = Default::default();
        file.output = Default::default();
        serde_json::to_string(&file)
    }
}
