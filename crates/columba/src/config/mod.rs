//! Scenario files: read, checked, and turned into what flies.
//!
//! `file/` is the file as written, `check/` its rules; `swarm.rs` a file of starts, `parameters.rs` parameter files.
//! Presets, flags and contenders are layers over the file: `layer.rs` is one of them, `provenance.rs` all of them
//! together, `flags.rs` says which flag sets which key, `contender.rs` reads those of a comparison. `source.rs`,
//! `locate.rs`, `fault.rs` and `diagnostics.rs` say what is wrong, and where.

mod airframe;
mod check;
mod contender;
mod diagnostics;
mod fault;
mod file;
pub mod flags;
mod fleet;
mod layer;
mod locate;
mod obstacles;
mod parameters;
mod patterns;
mod provenance;
mod scenario;
mod source;
mod swarm;

pub use airframe::PLANE;
pub use contender::{Contender, Entry, read_contenders, refuse_reserved};
pub use diagnostics::nearest;
pub use file::{Pattern, Preset, SetpointDialect};
pub use layer::Layer;
pub use provenance::Provenance;
pub use scenario::{GROUND_PORT, Link, Scenario, VEHICLE_PORT, file_name};
pub use source::ConfigError;

use crate::flying::vehicle_settings;
use contender::check_contenders;
use fault::Faults;
use file::ScenarioFile;
use source::{Parsed, Source};
use std::path::{Path, PathBuf};

/// The paper's flight, flown where no scenario is named.
pub const PAPER: &str = include_str!("../../../../config/paper.toml");
/// The name under which messages speak of [`PAPER`].
pub const PAPER_NAME: &str = "config/paper.toml (built in)";

/// Reads and checks a scenario file, or the paper's flight where no path is given, with layers over it: the last one is
/// the topmost.
///
/// # Errors
/// One [`ConfigError`] that names every fault by file, line, key, value and what would be right, or by its layer.
pub fn load(path: Option<&Path>, over: &[Layer]) -> Result<Scenario, ConfigError> {
    parse(&source_of(path)?, over)
}

/// Reads and checks the scenario of `columba identify` where no file is named, with layers over it.
///
/// # Errors
/// As [`load`].
pub fn load_identify(over: &[Layer]) -> Result<Scenario, ConfigError> {
    const IDENTIFY: &str = include_str!("../../../../config/identify.toml");
    parse(&Source::new("config/identify.toml (built in)", IDENTIFY), over)
}

/// What the topmost of some layers has for a key, as it is written.
pub fn written(layers: &[Layer], key: &str) -> Option<String> {
    layers.iter().rev().find_map(|layer| layer.find(key).filter(|found| found.is_there)?.value)
}

/// What a file that is to be checked is.
pub enum Checked {
    /// A scenario.
    Scenario(Box<Scenario>),
    /// Contenders of a comparison, by their names.
    Contenders(Vec<String>),
}

/// Checks a scenario file or a file of contenders.
///
/// # Errors
/// As [`load`]; contenders are checked over the paper's flight.
pub fn check_file(path: &Path) -> Result<Checked, ConfigError> {
    let source = Source::read(path, "a scenario file or a file of [[contender]] tables (TOML)")?;
    let is_of_contenders = source
        .parsed()
        .document
        .is_some_and(|document| document.contains_key("contender") && !document.contains_key("scenario"));
    if is_of_contenders {
        let contenders = check_contenders(&source)?;
        return Ok(Checked::Contenders(contenders.into_iter().map(|contender| contender.name).collect()));
    }
    Ok(Checked::Scenario(Box::new(parse(&source, &[])?)))
}

fn source_of(path: Option<&Path>) -> Result<Source, ConfigError> {
    match path {
        Some(path) => Source::read(path, "a scenario file (TOML)"),
        None => Ok(Source::new(PAPER_NAME, PAPER)),
    }
}

fn parse(source: &Source, over: &[Layer]) -> Result<Scenario, ConfigError> {
    let over: Vec<&Layer> = over.iter().collect();
    let (file, provenance) = tables(source, &over)?;
    scenario(file, provenance)
}

/// The file with layers over it, every setting of which is in its range. Everything that is wrong is told at once: that
/// no two vehicles start in one place, too.
fn tables(source: &Source, over: &[&Layer]) -> Result<(ScenarioFile, Provenance), ConfigError> {
    let Parsed { document, errors } = source.parsed();
    let Some(document) = document else { return Err(ConfigError::in_order(errors)) };
    let provenance = Provenance::new(source.name(), Layer::of_file(source.name(), document), over, !errors.is_empty());
    let mut faults = Faults::default();
    faults.add_placed(errors);
    let file = read(&provenance, &mut faults);
    if !faults.is_empty()
        && let Some(file) = &file
    {
        check_places(file.clone(), &provenance, &mut faults);
    }
    provenance.refuse(&faults, faults_of)?;
    let unreadable = || ConfigError::new(vec![format!("{}: must be a scenario file (TOML)", source.name())]);
    file.map(|file| (file, provenance)).ok_or_else(unreadable)
}

/// What the layers come to, and what is wrong with it.
fn read(provenance: &Provenance, faults: &mut Faults) -> Option<ScenarioFile> {
    let mut file: ScenarioFile = provenance.read(faults)?;
    read_swarm(&mut file, provenance, faults);
    if let Err(error) = file.parameters.read(&provenance.paths("parameters", "files")) {
        faults.add_placed([(0, error)]);
    }
    if let Some(Err(message)) = provenance.airframe(&file) {
        faults.add_placed([(0, message)]);
    }
    if let Err(messages) = fleet::airframes(&file, provenance) {
        faults.add_placed(messages.into_iter().map(|message| (0, message)));
    }
    check::tables(&file, faults);
    Some(file)
}

/// Reads the swarm file, which is beside the file that names it.
fn read_swarm(file: &mut ScenarioFile, provenance: &Provenance, faults: &mut Faults) {
    let Some(table) = file.vehicles.as_mut().filter(|table| table.pattern == Pattern::File) else { return };
    let Some(path) = &table.file else { return };
    let path = provenance.raw("vehicles.file").map_or_else(|| path.clone(), PathBuf::from);
    match swarm::read(&provenance.folder("vehicles.file").join(path)) {
        Ok(places) => table.places = places,
        Err(error) => {
            faults.add_placed(error.lines.into_iter().map(|line| (0, line)));
            faults.stand_in("vehicles");
        }
    }
}

/// What flies with the file's seed: everything random has its place, and every start is free.
fn scenario(file: ScenarioFile, provenance: Provenance) -> Result<Scenario, ConfigError> {
    let mut faults = Faults::default();
    let seed = file.scenario.seed;
    let scenario = check_places(file, &provenance, &mut faults);
    provenance.refuse(&faults, |layers| {
        let mut faults = Faults::default();
        if let Some(mut file) = read(layers, &mut faults).filter(|_| faults.is_empty()) {
            file.scenario.seed = seed;
            check_places(file, layers, &mut faults);
        }
        faults
    })?;
    scenario.ok_or_else(|| ConfigError::new(vec!["the scenario cannot be placed".to_owned()]))
}

/// Everything that is wrong with layers.
fn faults_of(layers: &Provenance) -> Faults {
    let mut faults = Faults::default();
    if let Some(file) = read(layers, &mut faults) {
        check_places(file, layers, &mut faults);
    }
    faults
}

/// Puts everything in its place and checks that it is free; none where that cannot be told.
fn check_places(mut file: ScenarioFile, provenance: &Provenance, faults: &mut Faults) -> Option<Scenario> {
    if ["vehicles", "obstacles", "scenario", "flock", "dynamics"].iter().any(|table| faults.is_within(table)) {
        return None;
    }
    let by_pattern = file.vehicles.is_some();
    if let Some(table) = file.obstacles {
        file.obstacle = obstacles::scatter(&table, file.scenario.seed);
        check::scattered(&table, file.obstacle.len(), faults);
        if faults.is_within("obstacles") {
            return None;
        }
    }
    let scenario = Scenario::new(file, provenance.clone());
    check::starts(&scenario, by_pattern, faults);
    if !faults.is_within("autopilot") {
        check::parameters(&scenario, &vehicle_settings(&scenario, None, 0), faults);
    }
    Some(scenario)
}

#[cfg(test)]
mod tests;
