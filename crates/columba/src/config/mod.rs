//! Scenario files: read, checked, and turned into what flies. `file.rs` is the file as written, `check.rs` its rules;
//! `source.rs`, `refusal.rs` and `provenance.rs` say what is wrong, and where.

mod check;
mod file;
mod obstacles;
mod patterns;
mod preset;
mod provenance;
mod refusal;
mod scenario;
mod source;

pub use check::{COUNT_MAX, DURATION_MAX_S, SHARE_MAX};
pub use file::{Pattern, Preset, SetpointDialect};
pub use provenance::Provenance;
pub use scenario::{GROUND_PORT, Link, Overrides, Scenario, VEHICLE_PORT};
pub use source::ConfigError;

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
    let source = match path {
        Some(path) => Source::read(path)?,
        None => Source::new(PAPER_NAME, PAPER),
    };
    parse(source, overrides)
}

fn parse(source: Source, overrides: &Overrides) -> Result<Scenario, ConfigError> {
    let mut file: ScenarioFile = source.parse()?;
    overrides.apply(&mut file);
    preset::apply(&mut file, &source)?;
    let by_pattern = file.vehicles.is_some();
    let provenance = Provenance::new(source, overrides);
    let mut faults = check::Faults::default();
    check::tables(&file, &mut faults);
    provenance.refuse(&faults)?;
    if let Some(table) = file.obstacles {
        file.obstacle = obstacles::scatter(&table, file.scenario.seed);
        check::scattered(&table, file.obstacle.len(), &mut faults);
        provenance.refuse(&faults)?;
    }
    let mut scenario = Scenario::new(file, provenance);
    check::starts(&scenario, by_pattern, &mut faults);
    scenario.provenance.refuse(&faults)?;
    // A path need not be text: it does not go through the file's table.
    if let Some(folder) = &overrides.folder {
        scenario.folder.clone_from(folder);
    }
    Ok(scenario)
}

#[cfg(test)]
mod tests;
