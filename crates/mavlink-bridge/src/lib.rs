//! Everything that is MAVLink on the wire: framing, telemetry, setpoints, UDP links and what impairs them, logs.
//!
//! This is the only crate of the workspace that names the MAVLink crate; its messages are exported as [`Message`], its
//! enums and payload structs as [`dialect`]. All modules except the links are sans-I/O: bytes and times are arguments.
//!
//! A datagram is read by [`frames`] or [`messages`] and written by [`Encoder`]; [`telemetry`] and [`setpoint`] stand
//! between messages and the flight model; [`UdpLink`] carries datagrams, [`Impairment`] spoils them, [`TlogWriter`]
//! keeps them. Other transports belong beside [`udp`], signatures beside [`frame`], routes between links and cores.
//!
//! ```
//! use mavlink_bridge::{Counters, Encoder, Message, frames, local_position_ned, state_from_local_position};
//! use std::time::Duration;
//!
//! let state = flight_model::State { altitude_m: 50.0, speed_mps: 9.0, ..Default::default() };
//! let mut datagram = Vec::new();
//! Encoder::new(1, 1).encode(&local_position_ned(Duration::from_millis(500), &state), &mut datagram);
//!
//! let mut counters = Counters::default();
//! for frame in frames(&datagram, &mut counters) {
//!     assert_eq!(frame.header.system_id, 1);
//!     if let Ok(Message::LOCAL_POSITION_NED(position)) = frame.message() {
//!         assert_eq!(state_from_local_position(&position), state);
//!     }
//! }
//! assert_eq!(counters.frames, 1);
//! ```

pub mod ardupilot;
pub mod command;
pub mod coordinates;
pub mod counters;
pub mod datagram;
pub mod dialect;
mod dialects;
pub mod encoder;
pub mod fleet;
pub mod frame;
pub mod impairment;
pub mod incoming;
pub mod kind;
pub mod link;
pub mod mission;
pub mod multicast;
pub mod parameter;
pub mod points;
pub mod setpoint;
pub mod telemetry;
pub mod tlog;
pub mod udp;

pub use ardupilot::{ArduPilotMessage, ekf_status_report, wind};
pub use command::{Command, CommandPosition, result_name};
pub use coordinates::{AltitudeDatum, LatLonE7, mav_frame};
pub use counters::{Counters, Order, SequenceTracker};
pub use datagram::{Frames, frames, messages};
pub use dialect::{Message, Target};
pub use encoder::Encoder;
pub use fleet::{Fleet, FleetEvent, Identity, Position, RemoteVehicle};
pub use frame::{Frame, FrameError, Header, Version};
pub use impairment::{Impairment, ImpairmentError, ImpairmentSettings};
pub use incoming::{Incoming, Request, incoming};
pub use mission::{ItemKind, PlanItem, PlanItemMessage, PlanMessage};
pub use multicast::{MULTICAST_GROUP, MulticastLink, MulticastScope};
pub use parameter::{PARAMETER_NAME_MAX, ParameterRequest, parameter_error, parameter_value};
pub use points::{FencePoint, PointRequest, RallyPoint};
pub use setpoint::{
    PartialSetpoint, SetpointError, guided_commands, local_ned_setpoint, setpoint_from_local_ned, wire_round_setpoint,
};
pub use telemetry::{boot_ms, is_autopilot, local_position_ned, state_from_local_position, wire_round};
pub use tlog::{TlogError, TlogReader, TlogRecord, TlogWriter};
pub use udp::{LinkError, LinkSettings, UdpLink};
