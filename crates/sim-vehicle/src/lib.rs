//! One simulated autopilot as a sans-I/O MAVLink state machine, and the host that runs many.
//!
//! [`Vehicle`] flies the model of Eq. 1-3 and speaks MAVLink as ArduPlane does in GUIDED. It takes datagrams and times and
//! gives datagrams and states; [`Host`] lends sockets and a clock to any number of them.

mod autopilot;
mod counters;
mod firmware;
mod host;
mod links;
mod lockstep;
mod mode;
mod parameters;
mod protocol;
mod settings;
mod telemetry;
mod vehicle;
mod world;

pub use counters::VehicleCounters;
pub use firmware::Personality;
pub use host::clock::{Advance, Clock, HostError, NETWORK_VEHICLES_MAX, Observer, port_index};
pub use host::layout::PortLayout;
pub use host::lines::Protocol;
pub use host::{Host, HostReport, HostSettings};
pub use links::{PeerId, Transmit};
pub use mode::{Mode, NoSuchMode};
pub use parameters::file::{ParameterFile, ParameterFileError, Place};
pub use parameters::{ParameterFault, check_parameters};
pub use protocol::mission::{PlanFileError, Plans};
pub use settings::{LockstepSettings, SettingsError, TelemetryRates, VehicleSettings};
pub use vehicle::{SetpointRefused, Vehicle};
