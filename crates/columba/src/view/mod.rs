//! What the page of `--view` and `columba view` is told: scenes and frames of scenarios, simulated vehicles, the ground
//! station, links and logs. The page itself is the crate `live_view`.

mod choices;
mod craft;
mod flock;
mod heard;
mod heard_plans;
pub mod listen;
pub mod orders;
mod plans;
mod read_plans;
mod scene;
mod station;
pub mod tlog;

pub use craft::watch_vehicles;
pub use flock::FlockView;
pub use scene::scene_of;
pub use station::StationView;

use crate::args::ViewArgs;
use anyhow::{Context, anyhow};
use live_view::{LiveView, Settings};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

/// Serves the page where that is asked for, and prints its address.
///
/// # Errors
/// The address cannot be had.
pub fn open(args: &ViewArgs) -> anyhow::Result<Option<LiveView>> {
    let Some(at) = &args.view else { return Ok(None) };
    let view = LiveView::start(&settings(at)?).context("--view")?;
    tell_address(&view);
    Ok(Some(view))
}

/// Prints where the page is. Scripts and people wait for this line, quiet or not.
pub fn tell_address(view: &LiveView) {
    eprintln!("columba: live view: {}", view.url());
}

/// The address of `--view`: a port, or an address with a port.
///
/// # Errors
/// The text is neither.
pub fn settings(at: &str) -> anyhow::Result<Settings> {
    let local = IpAddr::V4(Ipv4Addr::LOCALHOST);
    if let Ok(port) = at.parse() {
        return Ok(Settings { host: local, port });
    }
    let address: SocketAddr = at
        .parse()
        .map_err(|_| anyhow!("--view={at}: must be a port, 0 for any, or an address with a port, as 127.0.0.1:8080"))?;
    Ok(Settings { host: address.ip(), port: address.port() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_is_on_loopback_unless_an_address_is_named() {
        assert!(settings("0").unwrap().host.is_loopback());
        assert_eq!(settings("8080").unwrap().port, 8080);
        assert_eq!(settings("0.0.0.0:81").unwrap().host, IpAddr::from([0, 0, 0, 0]));
        for wrong in ["", "http", "localhost:80", "70000", "1.2.3.4"] {
            assert!(settings(wrong).unwrap_err().to_string().contains("must be a port"), "{wrong}");
        }
    }
}
