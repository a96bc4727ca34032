//! What a link tells, and what it is told.

use crate::Counters;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Instant;
use tokio::sync::mpsc;

/// Who is at the other end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Peer {
    /// The address of a datagram, or of a connection that was accepted.
    Address(SocketAddr),
    /// The only one there can be: of a serial line, or of a connection that was made.
    Only,
}

/// Bytes that arrived.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// The index of the link.
    pub link: usize,
    /// From whom.
    pub peer: Peer,
    /// When.
    pub at: Instant,
    /// A datagram, or the next piece of a stream.
    pub bytes: Vec<u8>,
    /// Whether frames may go on in the next piece.
    pub is_stream: bool,
}

/// What a link tells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// Something arrived.
    Arrival(Arrival),
    /// The link is open, or open again.
    Up(usize),
    /// The link is down, and why; it is tried again.
    Down(usize, String),
    /// A connection that was accepted is gone.
    Gone(usize, Peer),
}

/// A message to a link.
pub(super) type Send = (Peer, Vec<u8>);
/// Where links put what they tell.
pub(super) type Events = mpsc::UnboundedSender<LinkEvent>;

/// What a socket itself counts, for others to read while it runs.
pub(super) type SocketCounters = Arc<Mutex<Counters>>;
