//! Flying a scenario: the same flock over three transports, and what is kept of a flight.

mod ground;
mod lockstep;
mod log;
mod memory;
mod progress;
mod real_time;
mod recorder;
mod truth;
mod vehicles;

pub use ground::{Ground, GroundError};
pub use lockstep::fly as fly_in_lockstep;
pub use log::Log;
pub use memory::fly as fly_in_memory;
pub use progress::{Progress, progress_over};
pub use real_time::{Pace, fly as fly_in_real_time};
pub use recorder::{Ended, Recorder};
pub use truth::{Truth, truth};
pub use vehicles::{LOCKSTEP_EPOCH_US, clock, host_settings, led_vehicle_settings, network, ports, vehicle_settings};

/// Lets go of a flight: holds true once someone asks it to end.
pub type Stop = tokio::sync::watch::Receiver<bool>;
