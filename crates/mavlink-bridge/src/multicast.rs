//! UDP multicast, as ArduPilot's `mcast:` and pymavlink's `mcast:` have it: everybody sends to one group, and hears it.

use crate::LinkError;
use socket2::{Domain, Protocol, Socket, Type};
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use tokio::net::UdpSocket;

/// The group of ArduPilot's `mcast:`.
pub const MULTICAST_GROUP: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(239, 255, 145, 50), 14_550);

/// How far datagrams go, and from how far they are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MulticastScope {
    /// This machine.
    Host,
    /// The network of this machine.
    Network,
}

/// A member of a group: one socket that hears it, one that speaks to it.
#[derive(Debug)]
pub struct MulticastLink {
    group: SocketAddrV4,
    scope: MulticastScope,
    listener: UdpSocket,
    speaker: UdpSocket,
    /// Of the speaker: its own datagrams come back.
    own: SocketAddr,
}

impl MulticastLink {
    /// Joins a group at the interface that the system's routes choose, as pymavlink does. Must be called within a Tokio
    /// runtime.
    ///
    /// # Errors
    /// The system refuses one of the sockets, or has no route to the group.
    pub fn join(group: SocketAddrV4, scope: MulticastScope) -> Result<Self, LinkError> {
        let open = || -> io::Result<Self> {
            let listener = listener(group)?;
            let speaker = speaker(group, scope)?;
            let own = speaker.local_addr()?;
            Ok(Self { group, scope, listener, speaker, own })
        };
        open().map_err(|source| LinkError::Bind { address: SocketAddr::V4(group), source })
    }

    /// The group.
    pub fn group(&self) -> SocketAddr {
        SocketAddr::V4(self.group)
    }

    /// Sends a datagram to the group. What the system refuses is lost, as UDP is.
    pub async fn send(&self, datagram: &[u8]) {
        if let Err(error) = self.speaker.send(datagram).await {
            tracing::debug!(%error, "cannot send to the multicast group");
        }
    }

    /// Waits for the next datagram of somebody else, which replaces what is in `buf`. Cancel safe.
    ///
    /// # Errors
    /// The socket fails.
    pub async fn recv(&self, buf: &mut Vec<u8>) -> Result<(), LinkError> {
        loop {
            if self.try_recv(buf)? {
                return Ok(());
            }
            self.listener.readable().await.map_err(LinkError::Socket)?;
        }
    }

    /// Takes the next datagram of somebody else, if there is one now.
    ///
    /// # Errors
    /// The socket fails.
    pub fn try_recv(&self, buf: &mut Vec<u8>) -> Result<bool, LinkError> {
        buf.resize(DATAGRAM_MAX, 0);
        loop {
            match self.listener.try_recv_from(buf) {
                Ok((length, from)) if self.is_taken(from) => {
                    buf.truncate(length);
                    return Ok(true);
                }
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    buf.clear();
                    return Ok(false);
                }
                Err(error) => return Err(LinkError::Socket(error)),
            }
        }
    }

    fn is_taken(&self, from: SocketAddr) -> bool {
        let is_near = from.ip() == self.own.ip() || from.ip().is_loopback();
        from != self.own && (is_near || self.scope == MulticastScope::Network)
    }
}

/// Larger datagrams are nobody's.
const DATAGRAM_MAX: usize = 2048;

fn listener(group: SocketAddrV4) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    // Every member on this machine has the same port.
    socket.set_reuse_address(true)?;
    socket.set_nonblocking(true)?;
    // Bound to the group itself it hears nothing else.
    let address = if cfg!(unix) { *group.ip() } else { Ipv4Addr::UNSPECIFIED };
    socket.bind(&SocketAddrV4::new(address, group.port()).into())?;
    socket.join_multicast_v4(group.ip(), &Ipv4Addr::UNSPECIFIED)?;
    UdpSocket::from_std(socket.into())
}

fn speaker(group: SocketAddrV4, scope: MulticastScope) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_nonblocking(true)?;
    socket.set_multicast_loop_v4(true)?;
    // A datagram with no hop left reaches the members on this machine.
    socket.set_multicast_ttl_v4(if scope == MulticastScope::Host { 0 } else { 1 })?;
    socket.bind(&SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, 0).into())?;
    socket.connect(&group.into())?;
    UdpSocket::from_std(socket.into())
}
