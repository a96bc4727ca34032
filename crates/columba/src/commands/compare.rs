//! `columba compare`: contenders over scenarios and seeds.

use super::{Failure, folder_refused, print_line, start_threads, stop_on_signal};
use crate::args::{Cli, CompareArgs};
use crate::compare::campaign::{self, Census, Crew};
use crate::compare::{self, JOURNAL, Journal, JournalError, Plan, results};
use crate::config::{self, Contender};
use crate::counted::counted;
use crate::record::{RunFolder, holds_something};
use anyhow::anyhow;
use optimizer::{Algorithm, OptimizerSettings};
use std::path::PathBuf;

/// Flies whatever is not flown yet, and writes the comparison's folder.
pub fn compare(cli: &Cli, args: &CompareArgs) -> Result<(), Failure> {
    config::refuse_reserved(&cli.layers)?;
    let plan = Plan::new(&args.scenarios, &cli.layers, &contenders(args)?, args.seeds.as_slice())?;
    let figure_seed = args.figure_seed.unwrap_or(plan.seeds[0]);
    start_threads(cli)?;
    let crew = Crew { threads: rayon::current_num_threads(), quiet: cli.quiet, stop: stop_on_signal()? };

    let path = args.out.clone().unwrap_or_else(|| default_folder(&plan));
    if !args.force && holds_something(&path) && !path.join(JOURNAL).exists() {
        return Err(anyhow!(
            "--out: the folder {} is not empty and holds no {JOURNAL}: must be a new or an empty folder, or that of a \
             comparison, which is continued; --force writes into it",
            path.display()
        )
        .into());
    }
    let folder = RunFolder::create(&path).map_err(|error| folder_refused("--out", error))?;
    let (journal, mut flown) = Journal::open(&path).map_err(|error| match error {
        JournalError::Taken(_) => anyhow!("{error}: must be another folder (--out), or wait until it has ended"),
        error => error.into(),
    })?;
    if !cli.quiet {
        announce(&plan, campaign::census(&plan, &flown), &folder);
    }
    let failed = |error: anyhow::Error| Failure::Flight(format!("{error:#}"));
    campaign::fly(&plan, journal, &mut flown, &crew).map_err(failed)?;
    let pictures = compare::draw(&plan, figure_seed, &crew).map_err(failed)?;
    let Some(pictures) = pictures.filter(|_| !*crew.stop.borrow()) else {
        let Census { asked, flown, .. } = campaign::census(&plan, &flown);
        return Err(Failure::Flight(format!(
            "interrupted: {flown} of {asked} flights are in {}; the same command goes on from there",
            path.join(JOURNAL).display()
        )));
    };

    let rows = compare::rows(&plan, &flown);
    let outcomes = results::outcomes(&plan, &rows);
    compare::write(&folder, &plan, &rows, &outcomes, &pictures)?;
    if !cli.quiet {
        for outcome in &outcomes {
            print_line(format_args!("\n## Scenario {}\n{}", outcome.scenario, compare::screen(outcome)));
        }
        print_line(format_args!("report: {}", path.join("report.html").display()));
    }
    Ok(())
}

/// Optimisers as they are named, then those of the file; the paper's three where nothing is asked for.
fn contenders(args: &CompareArgs) -> anyhow::Result<Vec<Contender>> {
    let algorithms: &[Algorithm] = match (&args.optimizers, &args.contenders) {
        (Some(algorithms), _) => algorithms,
        (None, None) => &[Algorithm::Mslpio, Algorithm::Mpio, Algorithm::Nsga2],
        (None, Some(_)) => &[],
    };
    let mut contenders = Vec::new();
    for &algorithm in algorithms {
        let name = OptimizerSettings { algorithm, ..OptimizerSettings::default() }.build()?.name();
        contenders.extend(Contender::with_optimizer(algorithm, name));
    }
    if let Some(path) = &args.contenders {
        contenders.extend(config::read_contenders(path)?);
    }
    Ok(contenders)
}

/// `compare/` and the scenarios' names.
fn default_folder(plan: &Plan) -> PathBuf {
    PathBuf::from("compare").join(config::file_name(&plan.scenarios.join("-")))
}

fn announce(plan: &Plan, census: Census, folder: &RunFolder) {
    let Census { asked, flown, others } = census;
    let journal = folder.path().join(JOURNAL);
    print_line(compare::headline(plan));
    if flown > 0 {
        print_line(format_args!("  {flown} of {asked} are in {} already", journal.display()));
    }
    if others > 0 {
        print_line(format_args!(
            "  {} of other comparisons stay in {}; tables and report are written anew",
            counted(others, "flight"),
            journal.display()
        ));
    }
}
