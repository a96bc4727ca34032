//! `columba fly`: the controller, against whatever answers.

use super::{Failure, block_on, conclude, ground_port_refused, open_folder, start_threads, stop_on_signal};
use crate::args::{Cli, FlyArgs};
use crate::config::{self, GROUND_PORT, Scenario};
use crate::flying::{self, GroundStation, GroundTruth, Lockstep, Progress, RealTime};
use anyhow::anyhow;
use sim_vehicle::NETWORK_VEHICLES_MAX;
use std::net::SocketAddr;

/// Flies the scenario with vehicles that run elsewhere and writes its folder.
pub fn fly(cli: &Cli, args: &FlyArgs) -> Result<(), Failure> {
    let scenario = config::load(args.config.as_deref(), &cli.layers)?;
    let addresses = addresses(&scenario);
    if addresses.is_none() && scenario.starts.len() > NETWORK_VEHICLES_MAX {
        return Err(anyhow!(
            "{} vehicles are more than one network of {NETWORK_VEHICLES_MAX}, so that system ids come again: must name \
             their first port (--vehicle-port)",
            scenario.starts.len()
        )
        .into());
    }
    start_threads(cli)?;
    let stop = stop_on_signal()?;
    let progress = Progress::new(scenario.ticks(), scenario.control_period, cli.quiet);
    let (folder, flight, log) = block_on(async {
        let address = SocketAddr::new(scenario.link.host, scenario.link.ground_port.unwrap_or(GROUND_PORT));
        let mut ground =
            GroundStation::bind(&scenario, address).map_err(|error| ground_port_refused(&scenario, error))?;
        let folder = open_folder(&scenario, &args.folder)?;
        ground.expect(scenario.starts.len(), addresses.as_deref());
        let ground_truth = GroundTruth::telemetry();
        let (flight, log) = if args.lockstep {
            flying::fly(&scenario, Lockstep::new(&scenario, ground, ground_truth), &progress, stop).await
        } else {
            flying::fly(&scenario, RealTime::new(&scenario, ground, ground_truth, args.speed), &progress, stop).await
        }?;
        Ok((folder, flight, log))
    })?;
    drop(progress);
    conclude(cli, &scenario, &folder, &flight, log, !args.folder.no_report)
}

/// The vehicles' addresses, where the scenario names their first port.
fn addresses(scenario: &Scenario) -> Option<Vec<SocketAddr>> {
    let first = scenario.link.vehicle_port.filter(|&port| port > 0)?;
    let port = |index: usize| {
        u16::try_from(usize::from(first) + sim_vehicle::port_index(index, scenario.link.vehicles_per_port)).ok()
    };
    (0..scenario.starts.len()).map(|index| port(index).map(|port| SocketAddr::new(scenario.link.host, port))).collect()
}
