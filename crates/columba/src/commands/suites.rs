//! `columba suites`: optimisers on test problems.

use super::{Failure, folder_refused, occupied, print_kept, print_line, start_threads};
use crate::args::{Cli, SuitesArgs};
use crate::flying;
use crate::record::RunFolder;
use crate::suites::{self, Plan};
use std::path::Path;

/// The folder where `--out` names none.
const FOLDER: &str = "runs/suites";

/// Solves everything, writes the folder and prints the table.
pub fn suites(cli: &Cli, args: &SuitesArgs) -> Result<(), Failure> {
    let plan = Plan {
        problems: args.problems.clone(),
        optimizers: args.optimizers.clone(),
        seeds: args.seeds.as_slice().to_vec(),
        population: args.population,
        generations: args.generations,
        dimensions: args.dimensions,
    };
    start_threads(cli)?;
    let path = args.out.as_deref().unwrap_or(Path::new(FOLDER));
    let folder = RunFolder::open(path, occupied(args.out.is_some(), args.force))
        .map_err(|error| folder_refused("--out", error))?;
    let bar = flying::progress_over(plan.solves(), "solves", cli.quiet);
    let solves = plan.run(|| bar.inc(1))?;
    bar.finish_and_clear();

    let table = suites::markdown(&plan, &solves);
    folder.write("fronts.parquet", &suites::fronts(&solves)?)?;
    folder.write("indicators.parquet", &suites::indicators(&plan, &solves)?)?;
    folder.write("reference-fronts.parquet", &suites::reference_fronts(&plan)?)?;
    folder.write("timings.parquet", &suites::timings(&solves)?)?;
    folder.write("table.md", table.as_bytes())?;
    if !cli.quiet {
        print_line(format_args!("{table}\nwritten: {}", folder.path().display()));
        print_kept(&folder);
    }
    Ok(())
}
