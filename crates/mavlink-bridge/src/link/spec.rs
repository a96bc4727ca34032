//! Which link to open, and why it cannot be opened.

use super::{Connection, HostPort};
use crate::{ImpairmentSettings, LinkError};
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};

/// A link to open.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkSpec {
    /// How.
    pub connection: Connection,
    /// UDP addresses to speak to unasked, beside those who speak first.
    pub calls: Vec<SocketAddr>,
    /// What spoils it each way, for tests.
    pub impairment: ImpairmentSettings,
    /// Seed of the impairment.
    pub seed: u64,
}

/// Why a link cannot be opened at all.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// An address that cannot be bound, or settings out of range.
    #[error("{connection}: {source}")]
    Udp {
        /// The link.
        connection: Connection,
        /// Why.
        source: LinkError,
    },
    /// A TCP port that cannot be bound.
    #[error("{connection}: {source}")]
    Tcp {
        /// The link.
        connection: Connection,
        /// Why.
        source: io::Error,
    },
    /// A name that no host has.
    #[error("{connection}: there is no host of that name: {reason}")]
    Host {
        /// The link.
        connection: Connection,
        /// What the system says.
        reason: String,
    },
    /// The thread or its runtime.
    #[error("cannot start the links: {0}")]
    Thread(#[source] io::Error),
}

/// The addresses of a host, of which the first is used.
pub(super) fn resolve(connection: &Connection, address: &HostPort) -> Result<SocketAddr, OpenError> {
    let refused = |reason: String| OpenError::Host { connection: connection.clone(), reason };
    let mut found =
        (address.host.as_str(), address.port).to_socket_addrs().map_err(|error| refused(error.to_string()))?;
    found.next().ok_or_else(|| refused("it has no address".to_owned()))
}
