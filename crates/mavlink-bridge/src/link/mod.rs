//! Links to autopilots: UDP, TCP and serial lines, by the connection strings that users type.
//!
//! [`Connection`] is what a user asks for; [`Links`] opens any number of them, keeps them open, and hands over what
//! arrives. [`Framer`] finds frames in it, [`Signing`] verifies and signs them, [`VehicleClock`] tells when a message
//! was flown. All but [`Links`] is sans-I/O.

mod clock;
mod connection;
mod event;
mod framer;
mod retry;
mod serial;
mod shell;
mod signing;
mod spec;
mod tcp;
mod udp;

pub use clock::VehicleClock;
pub use connection::{Connection, ConnectionError, DEFAULT_BAUD, HostPort};
pub use event::{Arrival, LinkEvent, Peer};
pub use framer::{Found, Framer};
pub use shell::Links;
pub use signing::{KeyError, Rejected, Rejection, Signing, SigningKey, signing_time};
pub use spec::{LinkSpec, OpenError};
