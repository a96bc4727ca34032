//! A UDP link: one socket, any number of peers.
//!
//! Client and server are the same: a client is bound to port 0 and sends first to a peer that it knows. The
//! shells of further transports (TCP, serial) belong beside this file.

use crate::{Counters, Impairment, ImpairmentError, ImpairmentSettings};
use socket2::{Domain, Protocol, Socket, Type};
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use tokio::net::UdpSocket;
use tokio::time::Instant;

/// Settings of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSettings {
    /// Impairment of what is received.
    pub inbound: ImpairmentSettings,
    /// Impairment of what is sent.
    pub outbound: ImpairmentSettings,
    /// Seed of the impairment.
    pub seed: u64,
    /// Which link of that seed this is: links with numbers of their own are impaired independently.
    pub stream: u64,
    /// Size of the socket's receive buffer to ask for, bytes. The system's default loses datagrams from some thousands
    /// a second on; the system may grant less than is asked for (Linux: net.core.rmem_max).
    pub receive_buffer_bytes: usize,
}

impl Default for LinkSettings {
    fn default() -> Self {
        Self {
            inbound: ImpairmentSettings::default(),
            outbound: ImpairmentSettings::default(),
            seed: 0,
            stream: 0,
            receive_buffer_bytes: 4 << 20,
        }
    }
}

/// Why a link does not work.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The address cannot be bound.
    #[error("cannot bind UDP {address}: {}", bind_reason(.source))]
    Bind {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: io::Error,
    },
    /// An impairment setting is out of range.
    #[error("link impairment: {0}")]
    Impairment(#[from] ImpairmentError),
    /// The socket fails again and again.
    #[error("the UDP socket fails")]
    Socket(#[source] io::Error),
}

fn bind_reason(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::AddrInUse => "the port is busy".to_owned(),
        _ => error.to_string(),
    }
}

/// The largest datagram.
const DATAGRAM_MAX: usize = 65_535;

/// After so many errors in a row without a datagram the socket is given up.
const ERRORS_MAX: u32 = 64;

/// A bound socket with its impairment and its counters.
#[derive(Debug)]
pub struct UdpLink {
    socket: UdpSocket,
    inbound: Impairment,
    outbound: Impairment,
    counters: Counters,
    started: Instant,
    received: Box<[u8]>,
    /// A delayed datagram that is due while the socket's send buffer is full.
    unsent: Option<(Vec<u8>, SocketAddr)>,
    errors_in_a_row: u32,
}

impl UdpLink {
    /// Binds a socket. Must be called within a Tokio runtime.
    ///
    /// # Errors
    /// The address cannot be bound, or an impairment setting is out of range.
    pub fn bind(address: SocketAddr, settings: LinkSettings) -> Result<Self, LinkError> {
        let socket =
            open(address, settings.receive_buffer_bytes).map_err(|source| LinkError::Bind { address, source })?;
        Ok(Self {
            socket,
            inbound: Impairment::new(settings.inbound, settings.seed, settings.stream.wrapping_mul(2))?,
            outbound: Impairment::new(
                settings.outbound,
                settings.seed,
                settings.stream.wrapping_mul(2).wrapping_add(1),
            )?,
            counters: Counters::default(),
            started: Instant::now(),
            received: vec![0; DATAGRAM_MAX].into_boxed_slice(),
            unsent: None,
            errors_in_a_row: 0,
        })
    }

    /// The address that the socket is bound to.
    ///
    /// # Errors
    /// The system does not know it.
    pub fn local_addr(&self) -> Result<SocketAddr, LinkError> {
        self.socket.local_addr().map_err(LinkError::Socket)
    }

    /// What was sent, refused and impaired so far. Frames are counted by [`crate::frames`], where they are read.
    pub fn counters(&self) -> Counters {
        let mut counters = self.counters;
        self.inbound.count(&mut counters);
        self.outbound.count(&mut counters);
        counters
    }

    /// Sends a datagram, or hands it to the impairment. A datagram that the socket refuses is counted and lost, as in
    /// UDP. Delayed datagrams are sent by later calls of any method here, and while [`recv`](Self::recv) waits.
    pub async fn send_to(&mut self, datagram: &[u8], address: SocketAddr) {
        if self.outbound.is_none() {
            let result = self.socket.send_to(datagram, address).await;
            self.note_sent(datagram.len(), address, result);
        } else {
            self.outbound.offer(self.started.elapsed(), datagram, address);
            self.send_due();
            while self.unsent.is_some() {
                if let Err(error) = self.socket.writable().await {
                    tracing::debug!(%error, "socket error");
                    self.counters.send_errors += 1;
                    return;
                }
                self.send_due();
            }
        }
    }

    /// Waits for the next datagram, which replaces the contents of `buf`, and returns its sender. Meanwhile it sends
    /// the delayed datagrams that are due. Cancel safe: no datagram is lost when the future is dropped.
    ///
    /// # Errors
    /// The socket failed many times in a row.
    pub async fn recv(&mut self, buf: &mut Vec<u8>) -> Result<SocketAddr, LinkError> {
        // A flooded link must leave its runtime time for other tasks.
        tokio::task::coop::consume_budget().await;
        loop {
            if let Some(from) = self.try_recv(buf)? {
                return Ok(from);
            }
            let blocked = self.unsent.is_some();
            let outbound_due = if blocked { None } else { self.outbound.next_due() };
            let next_due = [self.inbound.next_due(), outbound_due].into_iter().flatten().min();
            tokio::select! {
                ready = self.socket.readable() => self.note_ready(ready)?,
                ready = self.socket.writable(), if blocked => self.note_ready(ready)?,
                () = tokio::time::sleep_until(self.started + next_due.unwrap_or_default()), if next_due.is_some() => {}
            }
        }
    }

    /// The next datagram if there is one now; see [`recv`](Self::recv). The runtime learns of arrivals only while a
    /// task awaits: call this from a task that also awaits.
    ///
    /// # Errors
    /// The socket failed many times in a row.
    pub fn try_recv(&mut self, buf: &mut Vec<u8>) -> Result<Option<SocketAddr>, LinkError> {
        self.send_due();
        loop {
            if let Some((datagram, from)) = self.inbound.poll(self.started.elapsed()) {
                *buf = datagram;
                return Ok(Some(from));
            }
            match self.socket.try_recv_from(&mut self.received) {
                Ok((length, from)) => {
                    self.errors_in_a_row = 0;
                    let datagram = self.received.get(..length).unwrap_or(&[]);
                    if self.inbound.is_none() {
                        buf.clear();
                        buf.extend_from_slice(datagram);
                        return Ok(Some(from));
                    }
                    self.inbound.offer(self.started.elapsed(), datagram, from);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(None),
                Err(error) => self.note_error(error)?,
            }
        }
    }

    /// Sends what is due until the socket's send buffer is full: then one datagram is left in `unsent`.
    fn send_due(&mut self) {
        while let Some((datagram, address)) = self.unsent.take().or_else(|| self.outbound.poll(self.started.elapsed()))
        {
            let result = self.socket.try_send_to(&datagram, address);
            if matches!(&result, Err(error) if error.kind() == ErrorKind::WouldBlock) {
                self.unsent = Some((datagram, address));
                return;
            }
            self.note_sent(datagram.len(), address, result);
        }
    }

    fn note_sent(&mut self, length: usize, address: SocketAddr, result: io::Result<usize>) {
        match result {
            Ok(_) => {
                self.counters.datagrams_sent += 1;
                self.counters.bytes_sent += length as u64;
            }
            Err(error) => {
                tracing::debug!(%address, %error, "datagram not sent");
                self.counters.send_errors += 1;
            }
        }
    }

    fn note_ready(&mut self, ready: io::Result<()>) -> Result<(), LinkError> {
        ready.or_else(|error| self.note_error(error))
    }

    /// A closed port of one peer must not take the link from the others.
    fn note_error(&mut self, error: io::Error) -> Result<(), LinkError> {
        tracing::debug!(%error, "socket error");
        self.counters.receive_errors += 1;
        self.errors_in_a_row += 1;
        if self.errors_in_a_row < ERRORS_MAX { Ok(()) } else { Err(LinkError::Socket(error)) }
    }
}

fn open(address: SocketAddr, receive_buffer_bytes: usize) -> io::Result<UdpSocket> {
    tokio::runtime::Handle::try_current().map_err(io::Error::other)?;
    let socket = Socket::new(Domain::for_address(address), Type::DGRAM, Some(Protocol::UDP))?;
    if let Err(error) = socket.set_recv_buffer_size(receive_buffer_bytes) {
        tracing::warn!(%address, %error, receive_buffer_bytes, "receive buffer not set");
    }
    socket.set_nonblocking(true)?;
    socket.bind(&address.into())?;
    UdpSocket::from_std(socket.into())
}
