//! One simulated autopilot as a sans-I/O MAVLink state machine, and the host that runs many.
//!
//! [`Vehicle`] flies the model of Eq. 1-3 and speaks MAVLink as ArduPlane does in GUIDED. It takes datagrams and times and
//! gives datagrams and states; [`Host`] lends sockets and a clock to any number of them.

mod arming;
mod commands;
mod connection;
mod counters;
mod endpoint;
mod failsafe;
mod fence;
mod flight;
mod home;
mod host;
mod hosting;
mod life;
mod links;
mod lockstep;
mod maintenance;
mod message_requests;
mod mission;
mod mode;
mod parameters;
mod personality;
mod plans;
mod rally;
mod reposition;
mod saying;
mod services;
mod settings;
mod sticks;
mod streams;
mod telemetry;
mod vehicle;

pub use counters::VehicleCounters;
pub use host::{Host, HostReport, HostSettings};
pub use hosting::{Advance, Clock, HostError, NETWORK_VEHICLES_MAX, Observer, port_index};
pub use mode::{Mode, NoSuchMode};
pub use parameters::file::{ParameterFile, ParameterFileError, Place};
pub use parameters::{ParameterFault, check_parameters};
pub use personality::Personality;
pub use plans::{PlanFileError, Plans};
pub use settings::{LockstepSettings, SettingsError, TelemetryRates, VehicleSettings};
pub use vehicle::{PeerId, SetpointRefused, Transmit, Vehicle};
