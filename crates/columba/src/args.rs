//! The command line.

use crate::config::{Overrides, Preset};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Flies a flock of UAVs over MAVLink: simulated vehicles, a ground controller that runs MSLPIO, and reports.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = EXIT_STATUS)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// No progress and no closing words, only what went wrong.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Threads that solve; by default as many as the machine has. The flight is the same with any number.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

const EXIT_STATUS: &str = "\
Exit status: 0 flown without collision, 1 the flight failed (what and when is printed), 2 the arguments or a file are wrong.
RUST_LOG=debug prints what the links do.";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Flies a scenario end to end: vehicles, link and controller. Without a file, the paper's flight.
    ///
    /// By default in lockstep: real MAVLink over UDP in simulated time, as fast as it goes, the same seed giving the same
    /// flight to the last bit. The run's folder holds summary.json, trajectory.parquet, flight.tlog and report.html.
    Run(RunArgs),
    /// Runs only the simulated vehicles, for your own controller, ground station or test.
    ///
    /// Each listens on its own UDP port from 14600 up and sends telemetry to 14550, as ArduPlane in GUIDED would.
    Vehicles(VehiclesArgs),
    /// Runs only the ground controller, against whatever answers.
    Fly(FlyArgs),
    /// Says what is wrong with a scenario file, by line.
    Check(CheckArgs),
}

#[derive(Debug, Args)]
pub struct RunArgs {
    /// Scenario file (TOML); without one, the paper's five UAVs and seven obstacles.
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub flight: FlightArgs,
    /// `udp`: real MAVLink on loopback. `memory`: no sockets; the same flight to the last bit.
    #[arg(long, value_enum, default_value_t = Transport::Udp)]
    pub transport: Transport,
    /// Flies in real time instead of lockstep, this many times the wall clock (1: as in life).
    #[arg(long, value_name = "K", value_parser = speed)]
    pub speed: Option<f64>,
    /// First UDP port of the vehicles. By default 14600 in real time, any free ports in lockstep.
    #[arg(long, value_name = "PORT")]
    pub vehicle_port: Option<u16>,
}

#[derive(Debug, Args)]
pub struct VehiclesArgs {
    /// Scenario file (TOML) for the vehicles' starts and dynamics; without one, the paper's.
    pub config: Option<PathBuf>,
    /// So many vehicles in a grid, instead of the file's.
    #[arg(long, value_name = "N")]
    pub count: Option<usize>,
    /// First UDP port; each further vehicle has the next. 0: any free ports.
    #[arg(long, value_name = "PORT")]
    pub vehicle_port: Option<u16>,
    /// UDP port to which telemetry goes unasked.
    #[arg(long, value_name = "PORT")]
    pub ground_port: Option<u16>,
    /// Vehicle seconds for each second of the wall clock.
    #[arg(long, value_name = "K", default_value = "1", value_parser = speed, conflicts_with = "lockstep")]
    pub speed: f64,
    /// Simulated time: a vehicle moves on only when it has the setpoint stamped with its time.
    #[arg(long)]
    pub lockstep: bool,
    /// Share of datagrams lost each way, 0 to 0.95.
    #[arg(long, value_name = "SHARE")]
    pub loss: Option<f64>,
    /// Seed of the link's impairment.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Prints the table of vehicles as JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct FlyArgs {
    /// Scenario file (TOML); without one, the paper's.
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub flight: FlightArgs,
    /// The vehicles keep simulated time (`columba vehicles --lockstep`).
    #[arg(long, conflicts_with = "speed")]
    pub lockstep: bool,
    /// Vehicle seconds for each second of the wall clock, as the vehicles were told.
    #[arg(long, value_name = "K", default_value = "1", value_parser = speed)]
    pub speed: f64,
    /// Speaks first to the vehicles at this port and those after it, instead of waiting for their telemetry.
    #[arg(long, value_name = "PORT")]
    pub vehicle_port: Option<u16>,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scenario files (TOML).
    #[arg(required = true)]
    pub config: Vec<PathBuf>,
}

/// What `run` and `fly` change of a file.
#[derive(Debug, Args)]
pub struct FlightArgs {
    /// Seed of every random number.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Which reading of the paper to start from.
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Flight time, s.
    #[arg(long, value_name = "S")]
    pub duration: Option<f64>,
    /// Folder of the run; by default `runs/<name>`.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// UDP port of the controller.
    #[arg(long, value_name = "PORT")]
    pub ground_port: Option<u16>,
    /// Share of datagrams lost each way, 0 to 0.95.
    #[arg(long, value_name = "SHARE")]
    pub loss: Option<f64>,
    /// Writes no report and no figures, only the record.
    #[arg(long)]
    pub no_report: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Transport {
    Udp,
    Memory,
}

impl FlightArgs {
    /// As what the scenario takes.
    pub fn overrides(&self) -> Overrides {
        Overrides {
            seed: self.seed,
            preset: self.preset,
            duration_s: self.duration,
            folder: self.out.clone(),
            ground_port: self.ground_port,
            loss: self.loss,
            ..Overrides::default()
        }
    }
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if (0.01..=100.0).contains(&speed) => Ok(speed),
        _ => Err("must be a number from 0.01 to 100".to_owned()),
    }
}
