//! `columba recover`: the rest of a folder whose flight was cut off.

use super::{Failure, print_line};
use crate::args::{Cli, RecoverArgs};
use crate::record::{self, RunFolder};
use crate::report;
use crate::station::record::{drawable, recover as read};

/// Makes summary.json, trajectory.parquet and the report from what was written while it flew.
pub fn recover(cli: &Cli, args: &RecoverArgs) -> Result<(), Failure> {
    let flight = read(&args.folder)?;
    let folder = RunFolder::create(&args.folder)?;
    record::write(&folder, &flight)?;
    if !args.no_report {
        report::write(folder.path(), &drawable(&flight))?;
    }
    if !cli.quiet {
        let summary = &flight.summary;
        print_line(format_args!(
            "{}: {} vehicles, {:.1} s recovered in {}",
            summary.scenario,
            summary.vehicles,
            summary.duration_s,
            folder.path().display()
        ));
    }
    Ok(())
}
