//! The subcommands.

mod check;
mod compare;
mod fly;
mod identify;
mod manual;
mod recover;
mod run;
mod share;
mod suites;
mod table;
mod vehicles;
mod view;

pub use check::check;
pub use compare::compare;
pub use fly::fly;
pub use identify::identify;
pub use manual::{completions, man};
pub use recover::recover;
pub use run::run;
pub use share::share;
pub use suites::suites;
pub use vehicles::vehicles;
pub use view::view;

use crate::args::{Cli, FolderArgs};
use crate::config::Scenario;
use crate::counted::counted;
use crate::flight::Flight;
use crate::flying::{self, Log, Stop};
use crate::record::{self, Occupied, RecordError, RunFolder};
use crate::report;
use crate::station::record::drawable;
use anyhow::{Context, anyhow};
use sim_vehicle::PortLayout;
use std::fmt::Display;
use std::future::Future;
use std::io::{ErrorKind, IsTerminal, Write};
use tokio::sync::watch;
use tracing_subscriber::EnvFilter;

/// How a command ends without success; the exit status is decided here and nowhere else.
#[derive(Debug)]
pub enum Failure {
    /// The flight failed, and how: exit status 1.
    Flight(String),
    /// The arguments or a file are wrong, or something they name cannot be had: exit status 2.
    Usage(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Usage(error.into())
    }
}

/// Warnings to standard error, or what RUST_LOG asks for.
pub fn start_tracing() {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    let colours = std::io::stderr().is_terminal();
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(colours)
        .with_target(false)
        .init();
}

/// Set by Ctrl-C and by a polite kill. A second one ends the program at once.
fn stop_on_signal() -> anyhow::Result<Stop> {
    let (sender, stop) = watch::channel(false);
    ctrlc::set_handler(move || {
        if sender.send_replace(true) {
            std::process::exit(130);
        }
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(stop)
}

/// The pool on which flocks are solved.
fn start_threads(cli: &Cli) -> anyhow::Result<()> {
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    Ok(())
}

/// Runs a future on this thread.
fn block_on<T>(future: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("cannot start the runtime")?
        .block_on(future)
}

/// The run's folder, tried before the flight. Made last of all that can be refused, so that nothing is left of a run
/// that is.
fn open_folder(scenario: &Scenario, args: &FolderArgs) -> anyhow::Result<RunFolder> {
    let occupied = occupied(scenario.provenance.is_of_command_line("output.folder"), args.force);
    RunFolder::open(&scenario.folder, occupied)
        .map_err(|error| folder_refused(&scenario.provenance.of("output.folder"), error))
}

/// What a command does with a folder that is not empty: nothing is overwritten without `--force`.
fn occupied(named: bool, force: bool) -> Occupied {
    match (named, force) {
        (_, true) => Occupied::Overwrite,
        (true, false) => Occupied::Refuse,
        (false, false) => Occupied::Number,
    }
}

/// A folder that cannot be used, and what would be right.
fn folder_refused(whence: &str, error: RecordError) -> anyhow::Error {
    match error {
        RecordError::Occupied { .. } => {
            anyhow!("{whence}: {error}: must be a new or an empty folder; --force replaces the files of an earlier run")
        }
        error => anyhow!("{whence}: {error}: must be a folder that can be made and written into"),
    }
}

/// To standard output: that a folder was not overwritten.
fn print_kept(folder: &RunFolder) {
    if let Some(kept) = folder.kept() {
        print_line(format_args!("  {} is not empty and was kept: --force writes into it", kept.display()));
    }
}

/// The controller's port that cannot be bound.
fn ground_port_refused(scenario: &Scenario, error: impl Into<anyhow::Error>) -> anyhow::Error {
    port_refused(scenario, "link.ground_port", "a free port, or 0 for any", error.into())
}

/// Sees to it that the system lets this program open a port for each vehicle or group.
fn allow_ports(scenario: &Scenario) -> anyhow::Result<()> {
    /// What else is open: the terminal, the runtime, the ground's port, files of the run.
    const OTHERS: u64 = 64;
    let needed = flying::sockets(scenario) as u64 + OTHERS;
    match rlimit::increase_nofile_limit(needed) {
        Ok(allowed) if allowed < needed => Err(anyhow!(
            "{} need {}, and the system allows {allowed} open files: must be at least {needed} \
             (ulimit -n {needed}), or fewer ports (--per-port N)",
            counted(scenario.starts.len(), "vehicle"),
            counted(flying::sockets(scenario), "port")
        )),
        // Where there is no such limit, or none can be found out, the ports will tell.
        _ => Ok(()),
    }
}

/// A vehicle's port that cannot be bound.
fn vehicle_port_refused(scenario: &Scenario, error: impl Into<anyhow::Error>) -> anyhow::Error {
    if scenario.link.layout != PortLayout::Columba {
        return port_refused(scenario, "link.instance", "an instance whose ports are free", error.into());
    }
    let wanted = match flying::ports(scenario) {
        1 => "a free port, or 0 for any".to_owned(),
        count => format!("the first of {count} free ports in a row, or 0 for any"),
    };
    port_refused(scenario, "link.vehicle_port", &wanted, error.into())
}

fn port_refused(scenario: &Scenario, key: &str, wanted: &str, error: anyhow::Error) -> anyhow::Error {
    let no_such_host = error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == ErrorKind::AddrNotAvailable);
    if no_such_host {
        return anyhow!("{}: {error}: must be an address of this machine", scenario.provenance.of("link.host"));
    }
    anyhow!("{}: {error}: must be {wanted}", scenario.provenance.of(key))
}

/// To standard output. A reader that has gone away wants no more.
fn print_line(line: impl Display) {
    let _ = writeln!(std::io::stdout().lock(), "{line}");
}

/// Writes what a flight leaves behind, says where, and how it ended.
fn conclude(
    cli: &Cli,
    scenario: &Scenario,
    folder: &RunFolder,
    flight: &Flight,
    log: Option<Log>,
    with_report: bool,
) -> Result<(), Failure> {
    remove_older(folder, log.is_none(), !with_report)?;
    record::write(folder, flight)?;
    if let Some(log) = log {
        log.write(folder)?;
    }
    if with_report {
        report::write(folder.path(), flight)?;
    }
    told(cli, scenario, folder, flight, with_report)
}

/// The same for a flight whose log is in the folder already, and of which not everything is known.
fn conclude_recorded(
    cli: &Cli,
    scenario: &Scenario,
    folder: &RunFolder,
    flight: &Flight,
    with_report: bool,
) -> Result<(), Failure> {
    remove_older(folder, false, !with_report)?;
    record::write(folder, flight)?;
    if with_report {
        report::write(folder.path(), &drawable(flight))?;
    }
    told(cli, scenario, folder, flight, with_report)
}

/// Says where the flight is written, and how it ended.
fn told(cli: &Cli, scenario: &Scenario, folder: &RunFolder, flight: &Flight, with_report: bool) -> Result<(), Failure> {
    if !cli.quiet {
        say(scenario, folder, flight, with_report);
    }
    let summary = &flight.summary;
    match (&summary.failure, summary.success) {
        (_, true) => Ok(()),
        (Some(failure), false) => Err(Failure::Flight(failure.clone())),
        (None, false) => Err(Failure::Flight("the flight did not succeed".to_owned())),
    }
}

/// Removes what an older run left in the folder and this one does not write: it would tell of another flight.
fn remove_older(folder: &RunFolder, log: bool, report: bool) -> anyhow::Result<()> {
    let figures =
        report::figures::NAMES.iter().flat_map(|name| ["svg", "png"].map(|kind| format!("figures/{name}.{kind}")));
    let report = figures.chain(["report.html".to_owned()]).filter(|_| report);
    for name in report.chain(log.then(|| "flight.tlog".to_owned())) {
        let path = folder.path().join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(anyhow!("cannot remove {} of an older run: {error}", path.display()));
            }
            _ => {}
        }
    }
    // Empty by now, unless somebody keeps something of their own there.
    let _ = std::fs::remove_dir(folder.path().join("figures"));
    Ok(())
}

fn say(scenario: &Scenario, folder: &RunFolder, flight: &Flight, with_report: bool) {
    let summary = &flight.summary;
    let metres = |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| format!("{value:.2} m"));
    let seconds = |value: Option<f64>| value.map_or_else(|| "never".to_owned(), |value| format!("{value:.1} s"));
    print_line(format_args!(
        "{}: {}, {}, {:.1} s flown in {:.2} s ({:.0} times real time, {})",
        scenario.name,
        counted(summary.vehicles, "UAV"),
        counted(summary.obstacles, "obstacle"),
        summary.duration_s,
        summary.wall_s,
        summary.real_time_factor,
        summary.transport
    ));
    print_line(format_args!(
        "  collisions: {} with obstacles, {} between UAVs; smallest separation {}, smallest clearance {}",
        summary.obstacle_collisions,
        summary.vehicle_collisions,
        metres(summary.min_separation_m),
        metres(summary.min_clearance_m)
    ));
    if let Some(lateness) = summary.lateness() {
        print_line(format_args!("  {lateness}"));
    }
    let past = match summary.obstacles {
        0 => String::new(),
        _ => format!("past the last obstacle: {} of {}; ", summary.passed_last_obstacle, summary.vehicles),
    };
    print_line(format_args!(
        "  {past}speed converged {}, course {}, altitude {}",
        seconds(summary.speed_convergence_s),
        seconds(summary.course_convergence_s),
        seconds(summary.altitude_settling_s)
    ));
    let what = if with_report { "report" } else { "record" };
    let file = if with_report { "report.html" } else { "summary.json" };
    print_line(format_args!("  {what}: {}", folder.path().join(file).display()));
    print_kept(folder);
}
