//! `columba check`: what is wrong with scenario files.

use super::Failure;
use crate::args::{CheckArgs, Cli};
use crate::config::{self, Overrides};

/// Checks every file, and says of each what it would fly or what is wrong.
pub fn check(cli: &Cli, args: &CheckArgs) -> Result<(), Failure> {
    let mut faults = Vec::new();
    for path in &args.config {
        match config::load(Some(path), &Overrides::default()) {
            Ok(scenario) if !cli.quiet => super::print_line(format_args!(
                "{}: good: {} UAVs, {} obstacles, {:.1} s",
                path.display(),
                scenario.starts.len(),
                scenario.obstacles.len(),
                scenario.duration.as_secs_f64()
            )),
            Ok(_) => {}
            Err(error) => faults.push(error.to_string()),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::Usage(anyhow::anyhow!(faults.join("\n")))) }
}
