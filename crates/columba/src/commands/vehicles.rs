//! `columba vehicles`: the simulated vehicles alone.

use super::{Failure, block_on, stop_on_signal, vehicle_port_refused};
use crate::args::{Cli, VehiclesArgs};
use crate::config::{self, GROUND_PORT, Overrides, VEHICLE_PORT};
use crate::flying;
use anyhow::Context;
use mavlink_bridge::LinkSettings;
use sim_vehicle::{Host, HostSettings, VehicleSettings};
use std::io::Write;
use std::net::SocketAddr;
use std::sync::Arc;

/// Runs the vehicles until Ctrl-C.
pub fn vehicles(cli: &Cli, args: &VehiclesArgs) -> Result<(), Failure> {
    let overrides = Overrides {
        seed: args.seed,
        vehicle_port: args.vehicle_port,
        ground_port: args.ground_port,
        loss: args.loss,
        count: args.count,
        on_ground: args.on_ground,
        personality: args.personality,
        ..Overrides::default()
    };
    let scenario = config::load(args.config.as_deref(), &overrides)?;
    let stop = stop_on_signal()?;
    let (clock, epoch_us) = flying::clock(&scenario, (!args.lockstep).then_some(args.speed));
    let ground_port = scenario.link.ground_port.unwrap_or(GROUND_PORT);
    let ground = (ground_port > 0).then(|| SocketAddr::new(scenario.link.host, ground_port));
    let impairment = scenario.link.impairment;
    let link =
        LinkSettings { inbound: impairment, outbound: impairment, seed: scenario.seed, ..LinkSettings::default() };
    let base_port = scenario.link.vehicle_port.unwrap_or(VEHICLE_PORT);
    if let Some(folder) = &args.state_folder {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let settings = HostSettings {
        parameters_folder: args.state_folder.clone(),
        ..flying::host_settings(&scenario, clock, base_port, link)
    };
    let personality = scenario.autopilot.personality;
    let vehicles: Vec<VehicleSettings> = flying::vehicle_settings(&scenario, ground, epoch_us)
        .into_iter()
        .map(|settings| VehicleSettings { personality, ..settings })
        .collect();
    let report = block_on(async {
        let host = Host::bind(&settings, vehicles.clone()).map_err(|error| vehicle_port_refused(&scenario, error))?;
        if args.json || !cli.quiet {
            let table = table(&vehicles, host.addresses(), ground, args.json);
            // Scripts wait for this: it must not stay in a buffer.
            let mut out = std::io::stdout().lock();
            out.write_all(table.as_bytes()).and_then(|()| out.flush()).context("cannot print the table of vehicles")?;
        }
        Ok(host.run(Arc::new(|_| {}), stop).await?)
    })?;
    tracing::info!(wire = ?report.wire, "vehicles stopped");
    Ok(())
}

/// Who is where on which port.
fn table(vehicles: &[VehicleSettings], addresses: &[SocketAddr], ground: Option<SocketAddr>, json: bool) -> String {
    let rows = vehicles.iter().zip(addresses).enumerate();
    if json {
        let rows: Vec<serde_json::Value> = rows
            .map(|(index, (vehicle, address))| {
                let start = vehicle.start;
                serde_json::json!({
                    "vehicle": index + 1, "system_id": vehicle.system_id, "component_id": vehicle.component_id,
                    "address": address.to_string(), "host": address.ip().to_string(), "port": address.port(),
                    "x_m": start.x_m, "y_m": start.y_m, "altitude_m": start.altitude_m,
                    "speed_mps": start.speed_mps, "course_rad": start.course_rad,
                })
            })
            .collect();
        return format!(
            "{}\n",
            serde_json::json!({ "ground": ground.map(|address| address.to_string()), "vehicles": rows })
        );
    }
    let mut table =
        format!("{:>7} {:>6}  {:<21} {:>9} {:>9} {:>8}\n", "vehicle", "system", "listens on", "x m", "y m", "alt m");
    for (index, (vehicle, address)) in rows {
        let start = vehicle.start;
        table += &format!(
            "{:>7} {:>6}  {:<21} {:>9.1} {:>9.1} {:>8.1}\n",
            index + 1,
            vehicle.system_id,
            address.to_string(),
            start.x_m,
            start.y_m,
            start.altitude_m
        );
    }
    let unasked = ground.map(|address| format!("{address} and to ")).unwrap_or_default();
    table + &format!("telemetry to {unasked}whoever speaks to a vehicle; Ctrl-C ends\n")
}
