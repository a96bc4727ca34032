//! `columba identify`: which Eq. 1 vehicles answer by, from a short flight of steps or from a log.

use super::fly::{self, Flown};
use super::{Failure, print_line};
use crate::args::{Cli, IdentifyArgs};
use crate::config;
use crate::counted::counted;
use crate::identify::flight::{StepFlight, StepSettings};
use crate::identify::{Identified, identify as from_records, words};
use anyhow::{Context, anyhow};
use mavlink_bridge::{TlogError, TlogReader, TlogRecord};
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Identifies, prints what is known, and writes an airframe file for each vehicle.
pub fn identify(cli: &Cli, args: &IdentifyArgs) -> Result<(), Failure> {
    if let Some(log) = &args.tlog {
        let folder = match config::written(&cli.layers, "output.folder") {
            Some(folder) => PathBuf::from(folder.trim_matches('"')),
            None => log.parent().map(Path::to_path_buf).unwrap_or_default(),
        };
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        return conclude(cli, log, &folder, args.fly.folder.force);
    }
    if args.fly.lockstep {
        return Err(anyhow!("--lockstep: must be left out: dead times are those of real time").into());
    }
    let mut scenario = match &args.fly.config {
        Some(path) => config::load(Some(path), &cli.layers)?,
        None => config::load_identify(&cli.layers)?,
    };
    let expected = scenario.expected;
    let steps = StepFlight::new(StepSettings {
        speed_mps: expected.speed_mps,
        course_rad: expected.course_rad,
        altitude_m: expected.altitude_m,
        area_m: args.area.unwrap_or(AREA_S * expected.speed_mps),
    });
    scenario.obstacles.clear();
    scenario.control_period = Duration::from_millis(200);
    scenario.duration = Duration::from_secs_f64(steps.longest_s().ceil());
    let Flown { folder, failure } = fly::steps(cli, &args.fly, scenario, steps)?;
    if let Some(why) = failure {
        eprintln!("columba: the flight of steps did not succeed: {why}");
    }
    conclude(cli, &folder.join("flight.tlog"), &folder, true)
}

/// Vehicles keep within so many seconds of flight.
const AREA_S: f64 = 75.0;

fn conclude(cli: &Cli, log: &Path, folder: &Path, force: bool) -> Result<(), Failure> {
    let records = read(log)?;
    let vehicles = from_records(&records);
    if vehicles.is_empty() {
        return Err(Failure::Flight(format!(
            "{}: no vehicle in it has both positions (GLOBAL_POSITION_INT) and setpoints",
            log.display()
        )));
    }
    for vehicle in &vehicles {
        if !cli.quiet {
            print_line(format_args!("{}", words::told(vehicle).trim_end()));
        }
        let path = folder.join(format!("airframe-{}.toml", vehicle.system_id));
        write_new(&path, &words::airframe_toml(vehicle, &log.display().to_string()), force)?;
        if !cli.quiet {
            print_line(format_args!("  written to {}", path.display()));
        }
    }
    let unknown: Vec<String> = vehicles.iter().filter_map(missing).collect();
    if unknown.is_empty() { Ok(()) } else { Err(Failure::Flight(unknown.join("; "))) }
}

/// Which loops of a vehicle are not known.
fn missing(vehicle: &Identified) -> Option<String> {
    let loops = [
        ("speed", vehicle.speed.is_err()),
        ("course", vehicle.course.is_err()),
        ("altitude", vehicle.altitude.is_err()),
    ];
    let names: Vec<&str> = loops.iter().filter(|(_, is_missing)| *is_missing).map(|(name, _)| *name).collect();
    (!names.is_empty()).then(|| format!("vehicle {}: {} not identified", vehicle.system_id, names.join(" and ")))
}

/// All records, up to where a log breaks off.
fn read(log: &Path) -> anyhow::Result<Vec<TlogRecord>> {
    let name = log.display();
    let file = File::open(log).with_context(|| format!("--tlog {name}"))?;
    let mut records = Vec::new();
    for record in TlogReader::new(BufReader::new(file)) {
        match record {
            Ok(record) => records.push(record),
            Err(error @ TlogError::Io(_)) => return Err(error).with_context(|| format!("--tlog {name}")),
            Err(error) => {
                tracing::warn!("{name}: {error} after {}: the rest is left out", counted(records.len(), "frame"));
                break;
            }
        }
    }
    if records.is_empty() {
        return Err(anyhow!("--tlog {name}: must be a log of MAVLink frames with times, as MAVProxy and fly write it"));
    }
    Ok(records)
}

fn write_new(path: &Path, text: &str, force: bool) -> anyhow::Result<()> {
    let mut options = File::options();
    options.write(true).truncate(true);
    let opened = if force { options.create(true).open(path) } else { options.create_new(true).open(path) };
    let mut file = opened.with_context(|| {
        format!("{}: must be a new file, in a folder that can be written into; --force replaces it", path.display())
    })?;
    Ok(file.write_all(text.as_bytes())?)
}
