//! `columba vehicles`: the simulated vehicles alone.

use super::table::Table;
use super::{Failure, allow_ports, block_on, stop_on_signal, vehicle_port_refused};
use crate::args::{Cli, VehiclesArgs};
use crate::config::{self, GROUND_PORT, Scenario, VEHICLE_PORT};
use crate::flying;
use anyhow::{Context, anyhow};
use mavlink_bridge::LinkSettings;
use sim_vehicle::{Host, HostError, HostReport, HostSettings};
use std::io::Write;
use std::net::SocketAddr;
use std::sync::Arc;

/// Runs the vehicles until Ctrl-C.
pub fn vehicles(cli: &Cli, args: &VehiclesArgs) -> Result<(), Failure> {
    let scenario = config::load(args.config.as_deref(), &cli.layers)?;
    let base_port = scenario.link.vehicle_port.unwrap_or(VEHICLE_PORT);
    check_apart(&scenario, base_port)?;
    allow_ports(&scenario)?;
    let stop = stop_on_signal()?;
    let speed = (!args.lockstep).then_some(args.speed);
    let (clock, epoch_us) = flying::clock(&scenario, speed);
    let impairment = scenario.link.impairment;
    let link =
        LinkSettings { inbound: impairment, outbound: impairment, seed: scenario.seed, ..LinkSettings::default() };
    if let Some(folder) = &args.state_folder {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let settings = HostSettings {
        state_folder: args.state_folder.clone(),
        ..flying::host_settings(&scenario, clock, base_port, link)
    };
    let mut vehicles = flying::vehicle_settings(&scenario, None, epoch_us);
    for (index, vehicle) in vehicles.iter_mut().enumerate() {
        vehicle.ground = ground(&scenario, index);
    }
    let report = block_on(async {
        let host = Host::bind(&settings, vehicles).map_err(|error| match error {
            HostError::Link(_) | HostError::TooManyPorts { .. } => vehicle_port_refused(&scenario, error),
            other => other.into(),
        })?;
        if args.json || !cli.quiet {
            let table = Table::of(&host, speed);
            let words = if args.json { table.json() } else { table.words() };
            // Scripts wait for this: it must not stay in a buffer.
            let mut out = std::io::stdout().lock();
            out.write_all(words.as_bytes()).and_then(|()| out.flush()).context("cannot print the table of vehicles")?;
        }
        Ok(host.run(Arc::new(|_| {}), stop).await?)
    })?;
    tracing::info!(wire = ?report.wire, "vehicles stopped");
    tell_speed(&report, args.speed);
    Ok(())
}

/// Where a vehicle sends its telemetry unasked. Each network has a ground port of its own: on one port, vehicles of two
/// networks with the same system id would be taken for one.
fn ground(scenario: &Scenario, vehicle: usize) -> Option<SocketAddr> {
    let first = scenario.link.ground_port.unwrap_or(GROUND_PORT);
    let port = u16::try_from(usize::from(first) + flying::network(vehicle) - 1).ok()?;
    (first > 0).then(|| SocketAddr::new(scenario.link.host, port))
}

/// Vehicles that listened where telemetry goes would hear each other instead of a ground station.
fn check_apart(scenario: &Scenario, base_port: u16) -> anyhow::Result<()> {
    let (first, end) = (usize::from(base_port), usize::from(base_port) + flying::ports(scenario));
    let grounds = (0..scenario.starts.len()).filter_map(|vehicle| ground(scenario, vehicle));
    match grounds.map(|ground| usize::from(ground.port())).find(|port| first > 0 && (first..end).contains(port)) {
        Some(port) => Err(anyhow!(
            "telemetry goes to UDP {port}, which is one of the vehicles' ports, {first} to {}: must be apart \
             (--ground-port, --vehicle-port)",
            end - 1
        )),
        None => Ok(()),
    }
}

/// Says so if the vehicles fell behind the clock: by less than a hundredth, nobody can tell.
fn tell_speed(report: &HostReport, asked: f64) {
    if let Some(reached) = report.speed_reached.filter(|reached| *reached < 0.99 * asked) {
        tracing::warn!("the vehicles fell behind: {reached:.2} times real time instead of {asked}");
    }
}
