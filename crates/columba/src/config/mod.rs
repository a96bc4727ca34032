//! Scenario files: read, checked, and turned into what flies. `file.rs` is the file as written, `check.rs` its rules.

mod check;
mod file;
mod patterns;
mod preset;
mod scenario;
mod source;

pub use file::{Algorithm, Pattern, Preset, SetpointDialect};
pub use scenario::{Link, Overrides, Scenario};
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
    parse(&source, overrides)
}

fn parse(source: &Source, overrides: &Overrides) -> Result<Scenario, ConfigError> {
    let mut file: ScenarioFile = source.parse()?;
    overrides.apply(&mut file);
    preset::apply(&mut file, source)?;
    let mut faults = check::Faults::default();
    check::tables(&file, &mut faults);
    source.refuse(&faults)?;
    let scenario = Scenario::new(file);
    check::starts(&scenario, &mut faults);
    source.refuse(&faults)?;
    Ok(scenario)
}

#[cfg(test)]
mod tests;
