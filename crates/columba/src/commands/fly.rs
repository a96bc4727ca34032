//! `columba fly`: the controller, against whatever answers.
//!
//! In real time by the ground station ([`crate::station`]); in lockstep, and beyond one network of vehicles, by the
//! tick loop that `columba run` has too.

use super::{Failure, block_on, conclude, ground_port_refused, open_folder, start_threads, stop_on_signal};
use crate::args::{Cli, FlyArgs};
use crate::config::{self, GROUND_PORT, Scenario, SetpointDialect};
use crate::flight::Flight;
use crate::flying::{self, GroundStation, GroundTruth, Lockstep, Progress, RealTime};
use crate::identify::flight::StepFlight;
use crate::record::RunFolder;
use crate::station::frames::Origin;
use crate::station::vehicle::routes::Route;
use crate::station::{self, Station, shell};
use crate::view::{self, FlockView, StationView};
use anyhow::{Context, anyhow};
use live_view::LiveView;
use mavlink_bridge::ImpairmentSettings;
use mavlink_bridge::link::{Connection, HostPort, LinkSpec, Links, Peer, SigningKey};
use sim_vehicle::NETWORK_VEHICLES_MAX;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
    let by_tick_loop = args.lockstep
        || scenario.starts.len() > NETWORK_VEHICLES_MAX
        || scenario.link.setpoints == SetpointDialect::LocalNed;
    if by_tick_loop && !args.station.link.is_empty() {
        return Err(anyhow!(
            "--link: must be left out with --lockstep, with more than {NETWORK_VEHICLES_MAX} vehicles, and with [link] \
             setpoints"
        )
        .into());
    }
    start_threads(cli)?;
    let stop = stop_on_signal()?;
    let view = view::open(&args.view)?;
    if !by_tick_loop {
        let (folder, flight) = from_the_ground(cli, args, &scenario, addresses.unwrap_or_default(), None, view, stop)?;
        return conclude_station(cli, &scenario, &folder, &flight, args);
    }
    if let Some(view) = &view {
        view.feed().scene(view::scene_of(&scenario, "columba fly"));
    }
    let shown = view.as_ref().map(|view| FlockView::new(view.feed(), false));
    let progress = Progress::new(scenario.ticks(), scenario.control_period, cli.quiet).with_view(shown);
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

/// A flight of steps that has been flown.
pub(super) struct Flown {
    /// Where it is recorded.
    pub folder: PathBuf,
    /// Why it did not succeed.
    pub failure: Option<String>,
}

/// Flies steps in the place of what a flock would decide, and writes the folder of the run.
pub(super) fn steps(cli: &Cli, args: &FlyArgs, scenario: Scenario, steps: StepFlight) -> Result<Flown, Failure> {
    let stop = stop_on_signal()?;
    let view = view::open(&args.view)?;
    let addresses = addresses(&scenario).unwrap_or_default();
    let (folder, flight) = from_the_ground(cli, args, &scenario, addresses, Some(steps), view, stop)?;
    let failure = match conclude_station(cli, &scenario, &folder, &flight, args) {
        Ok(()) => None,
        Err(Failure::Flight(why)) => Some(why),
        Err(other) => return Err(other),
    };
    Ok(Flown { folder: folder.path().to_path_buf(), failure })
}

/// With the ground station.
fn from_the_ground(
    cli: &Cli,
    args: &FlyArgs,
    scenario: &Scenario,
    addresses: Vec<SocketAddr>,
    steps: Option<StepFlight>,
    view: Option<LiveView>,
    stop: flying::Stop,
) -> Result<(RunFolder, Flight), Failure> {
    let wanted = scenario.starts.len();
    if let Some(ids) = args.station.systems.as_ref().filter(|ids| ids.len() != wanted) {
        return Err(anyhow!(
            "--systems: {} are named, and the scenario has {wanted} vehicles: must be one for each",
            ids.len()
        )
        .into());
    }
    let key = args.station.signing_key.as_deref().map(read_key).transpose()?;
    let specs = links(args, scenario, &addresses);
    let connections: Vec<Connection> = specs.iter().map(|spec| spec.connection.clone()).collect();
    let calls = specs
        .iter()
        .enumerate()
        .flat_map(|(link, spec)| {
            let first = shell::calls(link, &spec.connection);
            first.into_iter().chain(spec.calls.iter().map(move |&address| Route { link, peer: Peer::Address(address) }))
        })
        .collect();
    let links = Links::open(specs).map_err(|error| match args.station.link.is_empty() {
        true => ground_port_refused(scenario, error),
        false => anyhow!("--link {error}"),
    })?;
    let folder = open_folder(scenario, &args.folder)?;
    let patience = Duration::from_secs_f64(args.station.patience);
    let settings = station::Settings {
        at_end: args.station.at_end,
        dry_run: args.station.dry_run,
        system_ids: args.station.systems.clone(),
        origin: args.station.origin.unwrap_or(Origin::Scenario),
        origin_is_named: scenario.provenance.names("scenario.origin.latitude_deg"),
        connect_patience: patience.min(Duration::from_secs(30)),
        ready_patience: patience,
        links: connections.iter().map(ToString::to_string).collect(),
        capacities: connections.iter().map(Connection::capacity_bytes_per_s).collect(),
        calls,
        steps,
    };
    let started = Instant::now();
    let station = Station::new(scenario.clone(), settings, Box::new(move || started.elapsed()));
    let view = view.map(|view| StationView::new(view, scenario));
    let around = shell::Surroundings { links, connections, key, speed: args.speed, quiet: cli.quiet, view };
    let flight = block_on(shell::run(station, around, folder.path(), stop))?;
    Ok((folder, flight))
}

fn conclude_station(
    cli: &Cli,
    scenario: &Scenario,
    folder: &crate::record::RunFolder,
    flight: &crate::flight::Flight,
    args: &FlyArgs,
) -> Result<(), Failure> {
    super::conclude_recorded(cli, scenario, folder, flight, !args.folder.no_report)
}

/// The links of the command line, or the scenario's own port.
fn links(args: &FlyArgs, scenario: &Scenario, addresses: &[SocketAddr]) -> Vec<LinkSpec> {
    let spec = |connection: Connection, calls: Vec<SocketAddr>| LinkSpec {
        connection,
        calls,
        impairment: scenario.link.impairment,
        seed: scenario.seed,
    };
    if args.station.link.is_empty() {
        let port = scenario.link.ground_port.unwrap_or(GROUND_PORT);
        let here = HostPort { host: scenario.link.host.to_string(), port };
        return vec![spec(Connection::UdpIn(here), addresses.to_vec())];
    }
    let mut specs: Vec<LinkSpec> =
        args.station.link.iter().map(|connection| spec(connection.clone(), Vec::new())).collect();
    specs.iter_mut().for_each(|spec| {
        if !matches!(spec.connection, Connection::UdpIn(_) | Connection::UdpOut(_)) {
            spec.impairment = ImpairmentSettings::default();
        }
    });
    specs
}

/// A key that others cannot read.
fn read_key(path: &Path) -> anyhow::Result<SigningKey> {
    let name = path.display();
    let contents = std::fs::read(path).with_context(|| format!("--signing-key {name}"))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::metadata(path)?.permissions().mode();
        if mode & 0o077 != 0 {
            return Err(anyhow!(
                "--signing-key {name}: others may read it: must be its owner's alone (chmod 600 {name})"
            ));
        }
    }
    SigningKey::from_file_contents(&contents).map_err(|error| anyhow!("--signing-key {name}: {error}"))
}

/// The vehicles' addresses, where the scenario names their first port.
fn addresses(scenario: &Scenario) -> Option<Vec<SocketAddr>> {
    let first = scenario.link.vehicle_port.filter(|&port| port > 0)?;
    let port = |index: usize| {
        u16::try_from(usize::from(first) + sim_vehicle::port_index(index, scenario.link.vehicles_per_port)).ok()
    };
    (0..scenario.starts.len()).map(|index| port(index).map(|port| SocketAddr::new(scenario.link.host, port))).collect()
}
