//! `columba check`: what is wrong with scenario files and files of contenders.

use super::Failure;
use crate::args::{CheckArgs, Cli};
use crate::config::{self, Checked};
use crate::counted::counted;

/// Checks every file, and says of each what it would fly or what is wrong.
pub fn check(cli: &Cli, args: &CheckArgs) -> Result<(), Failure> {
    let mut faults = Vec::new();
    for path in &args.config {
        match config::check_file(path) {
            Ok(_) if cli.quiet => {}
            Ok(Checked::Scenario(scenario)) => super::print_line(format_args!(
                "{}: good: {}, {}, {:.1} s",
                path.display(),
                counted(scenario.starts.len(), "UAV"),
                counted(scenario.obstacles.len(), "obstacle"),
                scenario.duration.as_secs_f64()
            )),
            Ok(Checked::Contenders(names)) => super::print_line(format_args!(
                "{}: good: {}: {}",
                path.display(),
                counted(names.len(), "contender"),
                names.join(", ")
            )),
            Err(error) => faults.push(error.to_string()),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::Usage(anyhow::anyhow!(faults.join("\n")))) }
}
