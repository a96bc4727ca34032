//! `columba run`: a scenario end to end.

use super::{
    Failure, allow_ports, block_on, conclude, ground_port_refused, open_folder, start_threads, stop_on_signal,
    vehicle_port_refused,
};
use crate::args::{Cli, RunArgs, Transport};
use crate::config::{self, Scenario, VEHICLE_PORT};
use crate::flight::Flight;
use crate::flying::{self, GroundStation, GroundTruth, Lockstep, Log, Progress, RealTime, Stop};
use crate::record::RunFolder;
use crate::view::{self, FlockView};
use anyhow::anyhow;
use live_view::LiveView;
use mavlink_bridge::LinkSettings;
use sim_vehicle::{Host, HostReport};
use std::net::SocketAddr;
use std::thread::JoinHandle;
use tokio::sync::{oneshot, watch};

/// Flies the scenario and writes its folder.
pub fn run(cli: &Cli, args: &RunArgs) -> Result<(), Failure> {
    let scenario = config::load(args.config.as_deref(), &cli.layers)?;
    if args.transport != Transport::Udp && args.speed.is_some() {
        return Err(anyhow!("--speed needs --transport udp: a run in memory has no clock").into());
    }
    start_threads(cli)?;
    let stop = stop_on_signal()?;
    let view = view::open(&args.view)?;
    if let Some(view) = &view {
        view.feed().scene(view::scene_of(&scenario, "columba run"));
        if args.speed.is_none() && !cli.quiet {
            eprintln!("columba: simulated time is over before it is seen: --speed 1 flies by the clock");
        }
    }
    let over_udp_too = args.transport == Transport::Udp;
    let shown = view.as_ref().map(|view| FlockView::new(view.feed(), over_udp_too));
    let progress = Progress::new(scenario.ticks(), scenario.control_period, cli.quiet).with_view(shown);
    let (folder, flight, log) = match args.transport {
        Transport::Memory => {
            let folder = open_folder(&scenario, &args.folder)?;
            (folder, flying::fly_in_memory(&scenario, &progress, &stop)?, None)
        }
        Transport::Simulated => {
            let folder = open_folder(&scenario, &args.folder)?;
            let (flight, log) = flying::fly_simulated(&scenario, &progress, &stop)?;
            (folder, flight, log)
        }
        Transport::Udp => over_udp(&scenario, args, view.as_ref(), &progress, stop)?,
    };
    drop(progress);
    drop(view);
    conclude(cli, &scenario, &folder, &flight, log, !args.folder.no_report)
}

/// The vehicles on a thread of their own, the controller on this one.
fn over_udp(
    scenario: &Scenario,
    args: &RunArgs,
    view: Option<&LiveView>,
    progress: &Progress,
    stop: Stop,
) -> anyhow::Result<(RunFolder, Flight, Option<Log>)> {
    let speed = args.speed;
    allow_ports(scenario)?;
    block_on(async {
        let mut ground =
            GroundStation::bind(scenario, SocketAddr::new(scenario.link.host, scenario.link.ground_port.unwrap_or(0)))
                .map_err(|error| ground_port_refused(scenario, error))?;
        let (clock, epoch_us) = flying::clock(scenario, speed);
        // Nobody else needs to find the vehicles of a run in lockstep, and several such runs share a machine.
        let base_port = scenario.link.vehicle_port.unwrap_or(if speed.is_some() { VEHICLE_PORT } else { 0 });
        let (observer, begins, ground_truth) = GroundTruth::observed(scenario.starts.len(), scenario.integration_step);
        let observer = match view {
            Some(view) => {
                let scene = view::scene_of(scenario, "columba run");
                view::watch_vehicles(view.feed(), scene, observer, speed)
            }
            None => observer,
        };
        let vehicles = flying::led_vehicle_settings(scenario, Some(ground.address()?), epoch_us);
        // The link's impairment is the ground's: both directions pass there once.
        let settings = flying::host_settings(scenario, clock, base_port, LinkSettings::default());
        let keep_time = speed.is_some();
        let (stop_vehicles, stopped) = watch::channel(false);
        let (tell_addresses, addresses) = oneshot::channel();
        let host: JoinHandle<anyhow::Result<HostReport>> = std::thread::spawn(move || {
            block_on(async move {
                let mut host = Host::bind(&settings, vehicles)?;
                if keep_time {
                    // In lockstep they wait for setpoints anyway.
                    host = host.beginning_when(begins);
                }
                let _ = tell_addresses.send(host.addresses().to_vec());
                Ok(host.run(observer, stopped).await?)
            })
        });
        let flown = match addresses.await {
            Ok(addresses) => {
                ground.expect(addresses.len(), Some(&addresses));
                Ok(fly(scenario, args, ground, ground_truth, progress, stop).await)
            }
            Err(never_sent) => Err(never_sent),
        };
        stop_vehicles.send_replace(true);
        let hosted = host.join().map_err(|_| anyhow!("the vehicles' thread failed"))?;
        match (flown, hosted) {
            // Without its addresses the host did not start, and has said why.
            (Err(_), Err(error)) => Err(vehicle_port_refused(scenario, error)),
            (Err(_), Ok(_)) => Err(anyhow!("the vehicles did not start")),
            (Ok(flown), hosted) => hosted.and(flown),
        }
    })
}

async fn fly(
    scenario: &Scenario,
    args: &RunArgs,
    ground: GroundStation,
    ground_truth: GroundTruth,
    progress: &Progress,
    stop: Stop,
) -> anyhow::Result<(RunFolder, Flight, Option<Log>)> {
    let folder = open_folder(scenario, &args.folder)?;
    let (flight, log) = match args.speed {
        None => flying::fly(scenario, Lockstep::new(scenario, ground, ground_truth), progress, stop).await,
        Some(speed) => {
            flying::fly(scenario, RealTime::new(scenario, ground, ground_truth, speed), progress, stop).await
        }
    }?;
    Ok((folder, flight, log))
}
