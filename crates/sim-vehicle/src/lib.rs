//! One simulated vehicle as a sans-I/O MAVLink state machine, and the host that runs many.
//!
//! [`Vehicle`] flies the model of Eq. 1-3 and speaks MAVLink as ArduPlane does in GUIDED, or as another
//! [`Personality`]. It takes datagrams and times and gives datagrams and states; [`Host`] lends sockets and a clock to
//! any number of them.
//!
//! With the feature `testing`, `testing::Client` drives a vehicle in memory by messages, for tests of one's own.

mod autopilot;
mod counters;
mod error;
mod firmware;
mod host;
mod links;
mod lockstep;
mod mode;
mod parameters;
mod protocol;
mod settings;
mod telemetry;
#[cfg(feature = "testing")]
pub mod testing;
mod vehicle;
mod world;

pub use autopilot::plan::Plans;
pub use counters::VehicleCounters;
pub use error::SetpointError;
pub use firmware::Personality;
pub use host::clock::{Advance, Clock, HostError, NETWORK_VEHICLES_MAX, Observer, port_index};
pub use host::layout::PortLayout;
pub use host::lines::Protocol;
pub use host::{Host, HostReport, HostSettings};
pub use links::{PeerId, Transmit};
pub use mode::{Mode, NoSuchMode};
pub use parameters::check::{ParameterFault, check_parameters};
pub use parameters::file::{ParameterFile, ParameterFileError, Place};
pub use parameters::renamed::OldName;
pub use protocol::mission::file::PlanFileError;
pub use settings::{LockstepSettings, SettingsError, VehicleSettings};
pub use telemetry::rates::{LinkUse, TelemetryRates};
pub use vehicle::Vehicle;
