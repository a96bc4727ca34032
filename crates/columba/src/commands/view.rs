//! `columba view`: any autopilots on a link, or logs, on a page in the browser.

use super::{Failure, block_on, stop_on_signal};
use crate::args::{Cli, WatchArgs};
use crate::flying::stopped;
use crate::station::shell;
use crate::view::listen::{self, Asks};
use crate::view::{self, tlog};
use anyhow::{Context, anyhow};
use live_view::{LiveView, Scene, Tape};
use mavlink_bridge::ImpairmentSettings;
use mavlink_bridge::link::{Connection, LinkSpec, Links};

/// Where autopilots and ground stations send telemetry by default.
const DEFAULT_LINK: &str = "udpin:127.0.0.1:14550";

/// Serves the page until Ctrl-C.
pub fn view(_: &Cli, args: &WatchArgs) -> Result<(), Failure> {
    if args.logs.is_empty() { watch_links(args) } else { play_logs(args) }
}

fn watch_links(args: &WatchArgs) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let default: Vec<Connection> = DEFAULT_LINK.parse().into_iter().collect();
    let connections = if args.link.is_empty() { default } else { args.link.clone() };
    let spec = |connection: &Connection| LinkSpec {
        connection: connection.clone(),
        calls: Vec::new(),
        impairment: ImpairmentSettings::default(),
        seed: 0,
    };
    let links = Links::open(connections.iter().map(spec).collect()).map_err(|error| anyhow!("--link {error}"))?;
    let calls =
        connections.iter().enumerate().filter_map(|(link, connection)| shell::calls(link, connection)).collect();
    let names: Vec<String> = connections.iter().map(ToString::to_string).collect();
    let page = LiveView::start(&view::settings(&args.view)?)?;
    view::tell_address(&page);
    let scene = Scene { title: names.join(", "), source: "columba view".to_owned(), ..Scene::default() };
    let asks = match (args.silent, args.plans) {
        (true, _) => Asks::Nothing,
        (false, true) => Asks::Plans,
        (false, false) => Asks::Positions,
    };
    block_on(async {
        listen::listen(page.feed(), links, calls, asks, scene, stop).await;
        Ok(())
    })?;
    Ok(())
}

fn play_logs(args: &WatchArgs) -> Result<(), Failure> {
    let mut stop = stop_on_signal()?;
    let mut logs: Vec<(String, tlog::Log)> = Vec::new();
    for path in &args.logs {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {name}"))?;
        let log = tlog::Log::open(bytes).map_err(|error| anyhow!("{name}: {error}"))?;
        logs.push((name, log));
    }
    let names: Vec<&str> = logs.iter().map(|(name, _)| name.as_str()).collect();
    let scene = Scene { title: names.join(", "), source: "columba view".to_owned(), ..Scene::default() };
    let tape = Tape::default();
    let page = LiveView::play(&view::settings(&args.view)?, tape.clone())?;
    view::tell_address(&page);
    let read = move || {
        if let Err(error) = tlog::play(logs, scene, &tape) {
            tracing::error!(%error, "the logs cannot be played further");
        }
    };
    std::thread::Builder::new().name("log-reader".to_owned()).spawn(read).context("cannot read the logs")?;
    block_on(async {
        stopped(&mut stop).await;
        Ok(())
    })?;
    Ok(())
}
