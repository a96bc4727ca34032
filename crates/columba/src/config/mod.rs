//! Scenario files: read, checked, and turned into what flies. `file.rs` is the file as written, `check/` its rules;
//! `swarm.rs` a file of starts, `parameters.rs` parameter files;
//! `source.rs`, `spot.rs`, `refusal.rs` and `provenance.rs` say what is wrong, and where; `contender.rs` and `layer.rs` are what a
//! comparison lays over a scenario.

mod check;
mod contender;
mod file;
mod layer;
mod obstacles;
mod parameters;
mod patterns;
mod preset;
mod provenance;
mod refusal;
mod scenario;
mod source;
mod spot;
mod swarm;

pub use check::{COUNT_MAX, DURATION_MAX_S, SHARE_MAX};
pub use contender::{Contender, Entry, read_contenders};
pub use file::{Pattern, Preset, SetpointDialect};
pub use layer::Layer;
pub use provenance::Provenance;
pub use scenario::{GROUND_PORT, Link, Overrides, Scenario, VEHICLE_PORT, file_name};
pub use source::ConfigError;

use crate::flying::vehicle_settings;
use file::ScenarioFile;
use source::Source;
use std::path::Path;

/// The paper's flight, flown where no scenario is named.
pub const PAPER: &str = include_str!("../../../../config/paper.toml");
/// The name under which messages speak of [`PAPER`].
pub const PAPER_NAME: &str = "config/paper.toml (built in)";

/// Reads and checks a scenario file, or the paper's flight where no path is given.
///
/// # Errors
/// One [`ConfigError`] that names every fault by file, line, key, value and what would be right.
pub fn load(path: Option<&Path>, overrides: &Overrides) -> Result<Scenario, ConfigError> {
    parse(source_of(path)?, overrides)
}

fn source_of(path: Option<&Path>) -> Result<Source, ConfigError> {
    match path {
        Some(path) => Source::read(path, "a scenario file (TOML)"),
        None => Ok(Source::new(PAPER_NAME, PAPER)),
    }
}

fn parse(source: Source, overrides: &Overrides) -> Result<Scenario, ConfigError> {
    let (file, provenance) = tables(source, overrides)?;
    let mut scenario = scenario(file, provenance)?;
    // A path need not be text: it does not go through the file's table.
    if let Some(folder) = &overrides.folder {
        scenario.folder.clone_from(folder);
    }
    Ok(scenario)
}

/// The file, every setting of which is in its range.
fn tables(source: Source, overrides: &Overrides) -> Result<(ScenarioFile, Provenance), ConfigError> {
    let mut file: ScenarioFile = source.parse()?;
    read_swarm(&mut file, &source, overrides)?;
    let folder = Path::new(source.name()).parent().unwrap_or(Path::new(""));
    file.parameters.read(folder, &overrides.parameter_files)?;
    preset::apply(&mut file, &source)?;
    let provenance = Provenance::new(source, overrides);
    let mut faults = check::Faults::default();
    check::tables(&file, &mut faults);
    provenance.refuse(&faults)?;
    Ok((file, provenance))
}

/// Lays the flags over the file, and reads the swarm file that either names: the one of a scenario is beside it.
fn read_swarm(file: &mut ScenarioFile, source: &Source, overrides: &Overrides) -> Result<(), ConfigError> {
    overrides.apply(file);
    let Some(table) = file.vehicles.as_mut().filter(|table| table.pattern == Pattern::File) else { return Ok(()) };
    let Some(path) = &table.file else { return Ok(()) };
    let folder = Path::new(source.name()).parent().filter(|_| overrides.swarm.is_none());
    table.places = swarm::read(&folder.unwrap_or(Path::new("")).join(path))?;
    Ok(())
}

/// What flies with the file's seed: everything random has its place, and every start is free.
fn scenario(mut file: ScenarioFile, provenance: Provenance) -> Result<Scenario, ConfigError> {
    let by_pattern = file.vehicles.is_some();
    let mut faults = check::Faults::default();
    if let Some(table) = file.obstacles {
        file.obstacle = obstacles::scatter(&table, file.scenario.seed);
        check::scattered(&table, file.obstacle.len(), &mut faults);
        provenance.refuse(&faults)?;
    }
    let scenario = Scenario::new(file, provenance);
    check::starts(&scenario, by_pattern, &mut faults);
    check::parameters(&scenario, &vehicle_settings(&scenario, None, 0), &mut faults);
    scenario.provenance.refuse(&faults)?;
    Ok(scenario)
}

#[cfg(test)]
mod tests;
