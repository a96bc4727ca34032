//! One simulated autopilot as a sans-I/O MAVLink state machine, and the host that runs many.

mod flight;
mod loiter;
mod mode;
mod settings;

pub use mode::{Mode, NoSuchMode};
pub use settings::{LockstepSettings, SettingsError, TelemetryRates, VehicleSettings};
