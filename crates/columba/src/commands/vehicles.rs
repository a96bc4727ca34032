//! `columba vehicles`: the simulated vehicles alone.

use super::table::Table;
use super::{Failure, allow_ports, block_on, stop_on_signal, vehicle_port_refused};
use crate::args::{Cli, VehiclesArgs};
use crate::config::{self, GROUND_PORT, Layer, PLANE, Scenario, VEHICLE_PORT};
use crate::flying;
use crate::view;
use crate::view::orders::{CraftOrders, VERBS};
use anyhow::{Context, anyhow};
use live_view::Scene;
use mavlink_bridge::LinkSettings;
use sim_vehicle::{Host, HostError, HostReport, HostSettings, Observer, OldName, PortLayout, Vehicle};
use std::io::Write;
use std::net::SocketAddr;
use std::sync::Arc;

/// Runs the vehicles until Ctrl-C.
pub fn vehicles(cli: &Cli, args: &VehiclesArgs) -> Result<(), Failure> {
    let layers = if args.config.is_none() && !args.lockstep { with_planes(&cli.layers) } else { cli.layers.clone() };
    let scenario = config::load(args.config.as_deref(), &layers)?;
    let base_port = scenario.link.vehicle_port.unwrap_or(VEHICLE_PORT);
    if scenario.link.layout == PortLayout::Columba {
        check_apart(&scenario, base_port)?;
    }
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
        layout: scenario.link.layout,
        multicast: scenario.link.multicast,
        ..flying::host_settings(&scenario, clock, base_port, link)
    };
    let mut vehicles = flying::vehicle_settings(&scenario, None, epoch_us);
    for (index, vehicle) in vehicles.iter_mut().enumerate() {
        vehicle.ground = ground(&scenario, index);
    }
    let mut view = view::open(&args.view)?;
    let verbs = VERBS.map(str::to_owned).to_vec();
    let scene = Scene { takes_words: true, verbs, ..view::scene_of(&scenario, "columba vehicles") };
    if let Some(view) = &view {
        view.feed().scene(scene.clone());
    }
    let report = block_on(async {
        let host = Host::bind(&settings, vehicles).map_err(|error| match error {
            HostError::Link(_) | HostError::Tcp { .. } | HostError::TooManyPorts { .. } => {
                vehicle_port_refused(&scenario, error)
            }
            other => other.into(),
        })?;
        if !cli.quiet {
            tell_parameters(&scenario, &host);
        }
        if args.json || !cli.quiet {
            let table = Table::of(&host, speed);
            let words = if args.json { table.json() } else { table.words() };
            // Scripts wait for this: it must not stay in a buffer.
            let mut out = std::io::stdout().lock();
            out.write_all(words.as_bytes()).and_then(|()| out.flush()).context("cannot print the table of vehicles")?;
        }
        let observer: Observer = match &view {
            Some(view) => view::watch_vehicles(view.feed(), scene, Arc::new(|_| {}), speed),
            None => Arc::new(|_| {}),
        };
        let orders = CraftOrders::of(&host, view.as_mut()).await.context("--view")?;
        tokio::select! {
            report = host.run(observer, stop) => Ok(report?),
            never = orders.obey() => match never {},
        }
    })?;
    tracing::info!(wire = ?report.wire, "vehicles stopped");
    tell_speed(&report);
    Ok(())
}

/// The flags' layers, and beneath them what makes vehicles planes that are not the paper's five: those of a count, a
/// swarm file, or the ports of an autopilot, for which scripts ask for an autopilot's speeds and places.
fn with_planes(flags: &[Layer]) -> Vec<Layer> {
    let written = |key: &str| config::written(flags, key);
    let has_number = written("vehicles.count").is_some() || written("vehicles.file").is_some();
    let ports = written("link.ports").filter(|ports| ports != "\"columba\"");
    let is_paper = match written("airframe") {
        Some(airframe) => airframe == "\"paper\"",
        None => !has_number && ports.is_none(),
    };
    let mut layers = Vec::new();
    let mut lay = |key: &str, toml: &str| layers.extend(Layer::of_flag("--airframe", key, toml).ok());
    if !is_paper {
        // Scripts lean on how these have always flown: by Eq. 1 as it is printed, to the last bit.
        const AS_ALWAYS: &str = "speed_gain = 1.0, course_time_constant_s = 3.2, speed_dead_time_s = 0.0, \
                                 course_dead_time_s = 0.0, altitude_dead_time_s = 0.0, \
                                 course_reference_speed_mps = 0.0, acceleration_max_mps2 = 0.0, \
                                 turn_share = 1.0";
        lay("airframe", &format!("airframe = {{ base = \"{PLANE}\", flies = \"equation-1\", {AS_ALWAYS} }}"));
        if !has_number {
            lay("vehicles.count", "vehicles.count = 5");
        }
    }
    for (key, value) in ports.as_deref().map_or(&[][..], start_of_simulator) {
        lay(key, &format!("{key} = {value:?}"));
    }
    if ports.as_deref() == Some("\"ardupilot\"") {
        // The links have these rates anyhow; the MAV1_ parameters say so, too.
        for rate in ["attitude_hz", "global_position_int_hz", "vfr_hud_hz", "local_position_ned_hz"] {
            lay(&format!("autopilot.{rate}"), &format!("autopilot.{rate} = 1.0"));
        }
    }
    layers.extend(flags.iter().cloned());
    layers
}

/// Where the simulator of the autopilot starts whose ports these are.
fn start_of_simulator(ports: &str) -> &'static [(&'static str, f64)] {
    const LATITUDE: &str = "scenario.origin.latitude_deg";
    const LONGITUDE: &str = "scenario.origin.longitude_deg";
    const ALTITUDE: &str = "scenario.origin.altitude_amsl_m";
    match ports {
        "\"ardupilot\"" => &[(LATITUDE, -35.363262), (LONGITUDE, 149.165237), (ALTITUDE, 584.0)],
        "\"px4\"" => &[(LATITUDE, 47.397742), (LONGITUDE, 8.545594), (ALTITUDE, 488.0)],
        _ => &[],
    }
}

/// Where a vehicle sends its telemetry unasked. Each network has a ground port of its own: on one port, vehicles of two
/// networks with the same system id would be taken for one.
fn ground(scenario: &Scenario, vehicle: usize) -> Option<SocketAddr> {
    let first = scenario.link.ground_port.unwrap_or(GROUND_PORT);
    let port = u16::try_from(usize::from(first) + flying::network(vehicle) - 1).ok()?;
    (first > 0).then(|| flying::reachable(SocketAddr::new(scenario.link.host, port)))
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

/// Names the parameters of files that the vehicles only keep, in one line: all vehicles have the same. Older names are
/// told with those that they have now, the ones that are taken over and the others. Those of a stock autopilot are in
/// the table.
fn tell_parameters(scenario: &Scenario, host: &Host) {
    let (_, old) = scenario.parameter_files.renamed_for(scenario.autopilot.personality);
    let renamed = |is_taken: bool| {
        let names = old.iter().filter(move |name| name.is_taken == is_taken);
        names.map(|OldName { old, new, .. }| format!("{old} ({new})")).collect()
    };
    tell_names("older names, taken over", renamed(true));
    tell_names("older names, not taken over", renamed(false));
    let inert = host.vehicles().next().into_iter().flat_map(Vehicle::inert_parameters);
    tell_names("kept for clients and not used by the vehicles", inert.map(str::to_owned).collect());
}

fn tell_names(what: &str, names: Vec<String>) {
    const NAMED_MAX: usize = 8;
    if names.is_empty() {
        return;
    }
    let named = names.iter().take(NAMED_MAX).cloned().collect::<Vec<_>>().join(", ");
    let more = match names.len().saturating_sub(NAMED_MAX) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    eprintln!("columba: {what}: {named}{more}");
}

/// Says so if the vehicles fell behind the clock: by less than a hundredth, nobody can tell.
fn tell_speed(report: &HostReport) {
    let (Some(reached), Some(asked)) = (report.speed_reached, report.speed_asked) else { return };
    if reached < 0.99 * asked {
        // Where SIM_SPEEDUP changed it on the way, the mean has no end of digits.
        let asked = (asked * 1e3).round() / 1e3;
        tracing::warn!("the vehicles fell behind: {reached:.2} times real time instead of {asked}");
    }
}
