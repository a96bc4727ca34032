//! The command line.

mod values;

pub use values::algorithm;

use crate::compare::Seeds;
use crate::config::{Layer, flags};
use crate::help;
use crate::station::frames::Origin;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use mavlink_bridge::kind::AtEnd;
use mavlink_bridge::link::Connection;
use optimizer::Algorithm;
use optimizer::suites::Suite;
use std::ffi::OsString;
use std::path::PathBuf;
use values::{
    area, at_end, dimensions, generations, multi_objective, patience, population, problem, seed, share_seconds, speed,
    threads,
};

/// Flies a flock of UAVs over MAVLink: simulated vehicles, a ground controller that runs MSLPIO, and reports.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = help::PROGRAM)]
pub struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// Print errors only: no progress, no results.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Number of threads that solve, 1 to 1024; default: one for each processor. The results are the same with any
    /// number.
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<u16>,
    /// What the command line lays over the scenario file, the lowest layer first: see [`flags`].
    #[arg(skip)]
    pub layers: Vec<Layer>,
}

impl Cli {
    /// The whole command line, with the flags that stand in for keys of the scenario file.
    pub fn full_command() -> clap::Command {
        flags::add_to(Self::command())
    }

    /// Reads arguments, the first of which is the name of the program.
    ///
    /// # Errors
    /// They are wrong, or ask for help.
    pub fn read(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> Result<Self, clap::Error> {
        let matches = Self::full_command().try_get_matches_from(arguments)?;
        let mut cli = Self::from_arg_matches(&matches)?;
        cli.layers = matches.subcommand().map(|(name, matches)| flags::layers(name, matches)).unwrap_or_default();
        Ok(cli)
    }
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Flies a scenario end to end: vehicles, link and controller. Without a file, the paper's flight.
    ///
    /// By default in lockstep: real MAVLink over UDP in simulated time, as fast as possible; the same seed gives the
    /// same flight to the last bit. The folder of the run holds summary.json, trajectory.parquet, flight.tlog and
    /// report.html.
    #[command(after_long_help = help::RUN)]
    Run(RunArgs),
    /// Runs only the simulated vehicles, for your own controller, ground station or test.
    ///
    /// Each listens on its own UDP port from 14600 up and sends telemetry to 14550, as ArduPlane in GUIDED would.
    #[command(after_long_help = help::VEHICLES)]
    Vehicles(VehiclesArgs),
    /// Runs only the ground controller, with vehicles that run elsewhere.
    ///
    /// Waits until every vehicle of the scenario has sent its position, sets them to GUIDED, arms them and flies them.
    /// Writes the same folder as run.
    #[command(after_long_help = help::FLY)]
    Fly(FlyArgs),
    /// Finds how vehicles answer their setpoints: Eq. 1 with gain and dead times, from a flight of steps or from a log.
    ///
    /// Flies turns, changes of speed and of altitude, each from rest, over one area; says how well Eq. 1 fits them and
    /// where it does not, and writes an airframe file that scenarios name.
    #[command(after_long_help = help::IDENTIFY)]
    Identify(IdentifyArgs),
    /// Shows any autopilots that speak on a link, or telemetry logs, on a page in the browser. Flies nothing.
    ///
    /// Without a file it listens on UDP 14550, where autopilots send their telemetry by default.
    #[command(after_long_help = help::VIEW)]
    View(WatchArgs),
    /// Draws a run's flight for others: a moving picture (APNG) and a still one, from its report.
    #[command(after_long_help = help::SHARE)]
    Share(ShareArgs),
    /// Makes the rest of a folder whose flight was cut off: summary, trajectory and report, from what was written while
    /// it flew.
    Recover(RecoverArgs),
    /// Compares optimisers and settings over many flights: tables with intervals and tests, and figures of each.
    ///
    /// Every contender flies every scenario with every seed, in memory and in parallel. Without a file, the paper's
    /// flight.
    #[command(after_long_help = help::COMPARE)]
    Compare(CompareArgs),
    /// Tells every fault of scenario files and files of contenders, by line.
    #[command(after_long_help = help::CHECK)]
    Check(CheckArgs),
    /// Measures optimisers on test problems whose true fronts are known: ZDT and DTLZ.
    ///
    /// Hypervolume and IGD+ over many seeds. The folder holds fronts.parquet, indicators.parquet,
    /// reference-fronts.parquet, timings.parquet and table.md, which is printed too.
    #[command(after_long_help = help::SUITES)]
    Suites(SuitesArgs),
    /// Prints completions for a shell.
    #[command(after_long_help = help::COMPLETIONS)]
    Completions(CompletionsArgs),
    /// Prints the manual page, of the program or of a subcommand.
    #[command(after_long_help = help::MAN)]
    Man(ManArgs),
}

/// `columba run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Scenario file (TOML); without one, the paper's five UAVs and seven obstacles.
    pub config: Option<PathBuf>,
    /// What happens to the run's folder.
    #[command(flatten)]
    pub folder: FolderArgs,
    /// What carries states and setpoints.
    #[arg(long, value_enum, default_value_t = Transport::Udp)]
    pub transport: Transport,
    /// Flies in real time instead of lockstep, K times as fast as the wall clock: 0.01 to 100.
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = speed)]
    pub speed: Option<f64>,
    /// The page.
    #[command(flatten)]
    pub view: ViewArgs,
}

/// `columba vehicles`.
#[derive(Debug, Args)]
pub struct VehiclesArgs {
    /// Scenario file (TOML) for the vehicles' starts and dynamics; without one, the paper's.
    pub config: Option<PathBuf>,
    /// Vehicle seconds for each second of the wall clock, 0.01 to 100.
    #[arg(
        long, value_name = "K", default_value = "1", allow_negative_numbers = true, value_parser = speed,
        conflicts_with = "lockstep",
    )]
    pub speed: f64,
    /// Simulated time: a vehicle moves on only when it has the setpoint stamped with its time.
    #[arg(long)]
    pub lockstep: bool,
    /// Folder that keeps parameters and plans over a restart: vehicle-1.parm, vehicle-1-mission.txt and so on. Without
    /// it, they are not kept.
    #[arg(long, alias = "params-folder", value_name = "DIR")]
    pub state_folder: Option<PathBuf>,
    /// Prints the table of vehicles as JSON.
    #[arg(long)]
    pub json: bool,
    /// The page.
    #[command(flatten)]
    pub view: ViewArgs,
}

/// `columba fly`.
#[derive(Debug, Args)]
pub struct FlyArgs {
    /// Scenario file (TOML); without one, the paper's.
    pub config: Option<PathBuf>,
    /// What happens to the run's folder.
    #[command(flatten)]
    pub folder: FolderArgs,
    /// The vehicles keep simulated time (columba vehicles --lockstep).
    #[arg(long, conflicts_with = "speed")]
    pub lockstep: bool,
    /// Vehicle seconds for each second of the wall clock, as the vehicles were told.
    #[arg(long, value_name = "K", default_value = "1", allow_negative_numbers = true, value_parser = speed)]
    pub speed: f64,
    /// The ground station.
    #[command(flatten)]
    pub station: StationArgs,
    /// The page.
    #[command(flatten)]
    pub view: ViewArgs,
}

/// What `fly` tells its ground station.
#[derive(Debug, Args)]
pub struct StationArgs {
    /// A link to autopilots, as udpin:127.0.0.1:14550, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT,
    /// serial:/dev/ttyUSB0:57600 or /dev/ttyUSB0,57600; with or without //. May be given several times.
    #[arg(long, value_name = "LINK")]
    pub link: Vec<Connection>,
    /// System ids of the vehicles, in the order of the scenario; by default those that are heard, in their own order.
    #[arg(long, value_name = "IDS", value_delimiter = ',')]
    pub systems: Option<Vec<u8>>,
    /// What vehicles do when the flight is over, fails or is interrupted: loiter, return, land or continue.
    #[arg(long, value_name = "WHAT", default_value = "loiter", value_parser = at_end())]
    pub at_end: AtEnd,
    /// Does all but command: says who is there, what is missing, and what does not fit.
    #[arg(long)]
    pub dry_run: bool,
    /// Where the scenario's frame is: home (of the first vehicle), or LATITUDE,LONGITUDE,ALTITUDE in degrees and m
    /// above mean sea level; by default as the scenario has it.
    #[arg(long, value_name = "PLACE", allow_hyphen_values = true)]
    pub origin: Option<Origin>,
    /// How long vehicles may take to be ready, and then to take off, in seconds.
    #[arg(long, value_name = "S", default_value = "120", value_parser = patience)]
    pub patience: f64,
    /// File with the key of MAVLink 2 signatures, 64 hexadecimal digits or 32 bytes, which its owner alone may read:
    /// what goes out is signed, and what is not signed with it is rejected.
    #[arg(long, value_name = "FILE")]
    pub signing_key: Option<PathBuf>,
}

/// `columba identify`.
#[derive(Debug, Args)]
pub struct IdentifyArgs {
    /// Finds it in this log of MAVLink frames instead, as MAVProxy and fly write it (.tlog); nothing is flown.
    #[arg(long, value_name = "FILE")]
    pub tlog: Option<PathBuf>,
    /// Vehicles turn back before they are further than this from where the steps began, in m; by default 75 s of flight
    /// at the expected speed.
    #[arg(long, value_name = "M", value_parser = area)]
    pub area: Option<f64>,
    /// As for fly.
    #[command(flatten)]
    pub fly: FlyArgs,
}

/// `columba view`.
#[derive(Debug, Args)]
pub struct WatchArgs {
    /// Telemetry logs (tlog) to play back, of Columba or of any ground station. Several are played together.
    #[arg(value_name = "TLOG", conflicts_with = "link")]
    pub logs: Vec<PathBuf>,
    /// A link to listen to, as udpin:127.0.0.1:14550, tcp:HOST:PORT or /dev/ttyUSB0,57600. May be given several times.
    #[arg(long, value_name = "LINK")]
    pub link: Vec<Connection>,
    /// Sends nothing on the links: neither heartbeats, nor requests for positions that do not come by themselves.
    #[arg(long, conflicts_with_all = ["logs", "plans"])]
    pub silent: bool,
    /// Asks each autopilot once for its home, its mission, its fence and its rally points, and draws them. Without this
    /// only those are drawn that others ask for or upload.
    #[arg(long, conflicts_with = "logs")]
    pub plans: bool,
    /// Where the page is: a port on this machine, 0 for any free one, or an address with a port.
    #[arg(long, value_name = "ADDRESS", default_value = "0")]
    pub view: String,
}

/// `columba share`.
#[derive(Debug, Args)]
pub struct ShareArgs {
    /// The folder of the run, with its report.html; moving.png and still.png are written there.
    pub folder: PathBuf,
    /// Width of the pictures in pixels, 100 to 4000.
    #[arg(long, value_name = "PX", default_value = "800", value_parser = clap::value_parser!(u32).range(100..=4000))]
    pub width: u32,
    /// How long the moving picture is, in seconds, 1 to 60; the whole flight is in it.
    #[arg(long, value_name = "S", default_value = "8", value_parser = share_seconds)]
    pub seconds: f64,
}

/// `columba recover`.
#[derive(Debug, Args)]
pub struct RecoverArgs {
    /// The folder of the flight.
    pub folder: PathBuf,
    /// Writes no report and no figures, only the record.
    #[arg(long)]
    pub no_report: bool,
}

/// `columba compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Scenario files (TOML); without one, the paper's five UAVs and seven obstacles.
    #[arg(value_name = "CONFIG")]
    pub scenarios: Vec<PathBuf>,
    /// Optimisers, each of which flies the scenarios as they are; by default mslpio,mpio,nsga2. The first contender is
    /// the one that the others are tested against.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = algorithm())]
    pub optimizers: Option<Vec<Algorithm>>,
    /// File of contenders (TOML, docs/compare.md); they follow the optimisers, which are then none by default.
    #[arg(long, value_name = "FILE")]
    pub contenders: Option<PathBuf>,
    /// Seeds: how many (100 is 1 to 100), a range with both ends (101..200), or a list of these (7..7,20..29).
    #[arg(long, value_name = "SEEDS", default_value = "100", allow_hyphen_values = true)]
    pub seeds: Seeds,
    /// Seed of the flights that are drawn; by default the first.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = seed)]
    pub figure_seed: Option<u64>,
    /// Folder of the comparison: new, empty, or one that is continued; by default compare/ and the scenarios' names.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Writes into a folder that is not empty and that no comparison has written: replaces files of the same names.
    #[arg(long)]
    pub force: bool,
}

/// `columba check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scenario files and files of contenders (TOML).
    #[arg(required = true)]
    pub config: Vec<PathBuf>,
}

/// `columba completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: clap_complete::Shell,
}

/// `columba man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// A subcommand; without one, the page is of the program.
    pub command: Option<String>,
}

/// `columba suites`.
#[derive(Debug, Args)]
pub struct SuitesArgs {
    /// Problems: zdt1, zdt2, zdt3, zdt4, zdt6, dtlz1, dtlz2.
    #[arg(
        long, value_name = "NAMES", value_delimiter = ',', default_value = "zdt1,zdt2,zdt3,zdt4,zdt6,dtlz1,dtlz2",
        value_parser = problem,
    )]
    pub problems: Vec<Suite>,
    /// Optimisers: mslpio, mpio, nsga2, random.
    #[arg(
        long, value_name = "NAMES", value_delimiter = ',', default_value = "mslpio,mpio,nsga2",
        value_parser = multi_objective,
    )]
    pub optimizers: Vec<Algorithm>,
    /// How many seeds (31: 1 to 31), or which: 101..200, or 3,5,8..9.
    #[arg(long, value_name = "SEEDS", default_value = "31", allow_hyphen_values = true)]
    pub seeds: Seeds,
    /// Candidates of a generation, and the most members of a front; even, 6 to 10000.
    #[arg(long, value_name = "N", default_value = "100", allow_negative_numbers = true, value_parser = population)]
    pub population: usize,
    /// Generations, the first included, 1 to 100000.
    #[arg(long, value_name = "N", default_value = "250", allow_negative_numbers = true, value_parser = generations)]
    pub generations: usize,
    /// Variables of each problem, 3 to 1000; by default as is customary: ZDT1-3 30, ZDT4 and 6 10, DTLZ1 7, DTLZ2 12.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = dimensions)]
    pub dimensions: Option<usize>,
    /// Folder for the results, new or empty; by default runs/suites, with a number where that is not empty.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Writes into a folder that is not empty: replaces the files of earlier results, keeps all others.
    #[arg(long)]
    pub force: bool,
}

/// What `run` and `fly` do with the folder of the run.
#[derive(Debug, Args)]
pub struct FolderArgs {
    /// Writes into a folder that is not empty: replaces the files of an earlier run, keeps all others.
    #[arg(long)]
    pub force: bool,
    /// Writes no report and no figures, only the record.
    #[arg(long)]
    pub no_report: bool,
}

/// The page in the browser.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// Shows the flight on a page in the browser, and prints its address. On this machine only and on a free port,
    /// unless a port (--view=8080) or an address (--view=0.0.0.0:8080) is named.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "0")]
    pub view: Option<String>,
}

/// What carries states and setpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Transport {
    /// Real MAVLink on loopback.
    Udp,
    /// No sockets; the same flight to the last bit.
    Memory,
    /// No sockets; vehicles and controller as in real time, with a clock and a link that are simulated: the loss and
    /// the delay of the link count, and the flight is repeatable.
    Simulated,
}
