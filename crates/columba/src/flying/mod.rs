//! Flying a scenario: one tick loop over four worlds, and what is kept of a flight.

mod ground_station;
mod ground_truth;
mod lockstep;
mod log;
mod memory;
mod progress;
mod real_time;
mod recorder;
mod setpoints;
mod simulated;
mod summary;
mod vehicles;
mod watch;
mod world;

pub use ground_station::{FlightError, GroundSettings, GroundStation};
pub use ground_truth::GroundTruth;
pub use lockstep::Lockstep;
pub use log::Log;
pub use memory::{Memory, fly_in_memory};
pub use progress::{Progress, progress_over};
pub use real_time::RealTime;
pub use recorder::{Ended, Recorder};
pub use simulated::{Simulated, fly_simulated};
pub use summary::{Solves, field, judged, name_of, planned, settings};
pub use vehicles::{
    LOCKSTEP_EPOCH_US, clock, host_settings, led_vehicle_settings, network, ports, reachable, sockets, vehicle_settings,
};
pub use watch::Watch;
pub use world::{Closed, Interval, World, fly};

/// Lets go of a flight: holds true once someone asks it to end.
pub type Stop = tokio::sync::watch::Receiver<bool>;

/// Resolves once the flight is asked to end.
pub async fn stopped(stop: &mut Stop) {
    // A sender that is gone can ask for nothing any more.
    if stop.wait_for(|stop| *stop).await.is_err() {
        std::future::pending().await
    }
}
