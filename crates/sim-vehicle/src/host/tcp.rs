//! TCP for vehicles: each port takes several clients, which get telemetry from the moment they connect.
//!
//! Every client has a task of its own, so that one that stops reading stalls nobody: what does not fit into its queue
//! is dropped, whole frames at a time.

use crate::host::clock::HostError;
use crate::links::PeerId;
use mavlink_bridge::Counters;
use mavlink_bridge::link::Framer;
use std::collections::HashMap;
use std::io;
use std::net::{IpAddr, Ipv6Addr, SocketAddr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::task::JoinSet;

/// What comes from the clients of a server.
#[derive(Debug)]
pub(crate) enum Event {
    /// A client has connected.
    Opened(PeerId, mpsc::Sender<Vec<u8>>),
    /// Whole frames from a client.
    Frames(PeerId, Vec<u8>),
    /// A client is gone.
    Closed(PeerId),
}

/// Datagrams that wait for one client.
const QUEUE_MAX: usize = 256;
/// Events that wait for the vehicles: a client that sends faster is not read.
const EVENTS_MAX: usize = 64;
/// Clients of one server.
const CLIENTS_MAX: usize = 64;

/// The ports of one vehicle, or of the vehicles of one group.
#[derive(Debug)]
pub(crate) struct TcpServer {
    addresses: Vec<SocketAddr>,
    clients: HashMap<PeerId, mpsc::Sender<Vec<u8>>>,
    events: mpsc::Receiver<Event>,
    tasks: JoinSet<()>,
}

impl TcpServer {
    /// Listens at every address. Must be called within a Tokio runtime.
    pub fn bind(addresses: &[SocketAddr]) -> Result<Self, HostError> {
        let (sender, events) = mpsc::channel(EVENTS_MAX);
        let mut server = Self { addresses: Vec::new(), clients: HashMap::new(), events, tasks: JoinSet::new() };
        for &address in addresses {
            let listener = listen(address).map_err(|source| HostError::Tcp { address, source })?;
            server.addresses.push(listener.local_addr().map_err(|source| HostError::Tcp { address, source })?);
            server.tasks.spawn(accept(listener, sender.clone()));
        }
        Ok(server)
    }

    /// Where it listens.
    pub fn addresses(&self) -> &[SocketAddr] {
        &self.addresses
    }

    /// Waits for what comes next. Cancel safe.
    pub async fn recv(&mut self) -> Event {
        loop {
            match self.events.recv().await {
                Some(event) => return self.note(event),
                // The accepting tasks hold senders as long as the server lives.
                None => std::future::pending().await,
            }
        }
    }

    /// What has come already.
    pub fn try_recv(&mut self) -> Option<Event> {
        self.events.try_recv().ok().map(|event| self.note(event))
    }

    /// Queues a datagram for a client; `false` if no client has this id.
    pub fn send_to(&mut self, datagram: &[u8], peer: PeerId) -> bool {
        let Some(client) = self.clients.get(&peer) else { return false };
        // What a slow client cannot take is lost, as on a serial line.
        let _ = client.try_send(datagram.to_vec());
        true
    }

    /// Closes the ports and all connections.
    pub async fn close(mut self) {
        self.tasks.shutdown().await;
    }

    fn note(&mut self, event: Event) -> Event {
        match &event {
            Event::Opened(peer, queue) => drop(self.clients.insert(*peer, queue.clone())),
            Event::Closed(peer) => drop(self.clients.remove(peer)),
            Event::Frames(..) => {}
        }
        event
    }
}

fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let listener = std::net::TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    TcpListener::from_std(listener)
}

/// Whether a peer is a client of a server: its id is no address of UDP.
pub(crate) fn is_client(peer: PeerId) -> bool {
    matches!(peer.ip(), IpAddr::V6(ip) if ip.segments()[..4] == DISCARD_PREFIX)
}

/// Addresses that nothing is ever sent to or comes from (RFC 6666).
const DISCARD_PREFIX: [u16; 4] = [0x100, 0, 0, 0];

/// An id that no peer has had before, in this process.
fn new_client() -> PeerId {
    static CLIENTS: AtomicU64 = AtomicU64::new(0);
    let number = CLIENTS.fetch_add(1, Ordering::Relaxed);
    let [a, b, c, d] = [number >> 48, number >> 32, number >> 16, number].map(|part| part as u16);
    SocketAddr::new(IpAddr::V6(Ipv6Addr::new(0x100, 0, 0, 0, a, b, c, d)), 0)
}

/// Takes clients until the server is closed.
async fn accept(listener: TcpListener, events: mpsc::Sender<Event>) {
    let mut clients = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                // One that is too many is closed at once, so that it knows.
                Ok((stream, _)) if clients.len() < CLIENTS_MAX => {
                    clients.spawn(serve(stream, events.clone()));
                }
                Ok(_) => {}
                Err(error) => {
                    // The system has no file descriptor left, for example.
                    tracing::debug!(%error, "cannot accept a TCP client");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
            },
            Some(_) = clients.join_next() => {}
        }
    }
}

/// One client, from its connection to its end.
async fn serve(stream: TcpStream, events: mpsc::Sender<Event>) {
    let (queue, mut wanted) = mpsc::channel(QUEUE_MAX);
    let peer = new_client();
    // Telemetry is late if it waits for more.
    let _ = stream.set_nodelay(true);
    if events.send(Event::Opened(peer, queue)).await.is_ok() {
        let (reads, writes) = (read(&stream, peer, &events), write(&stream, &mut wanted));
        tokio::select! {
            result = reads => note_end(&result),
            result = writes => note_end(&result),
        }
        let _ = events.send(Event::Closed(peer)).await;
    }
}

fn note_end(result: &io::Result<()>) {
    if let Err(error) = result {
        tracing::debug!(%error, "a TCP client is lost");
    }
}

async fn read(stream: &TcpStream, peer: PeerId, events: &mpsc::Sender<Event>) -> io::Result<()> {
    // Frames are counted where the vehicles read them.
    let (mut framer, mut counters) = (Framer::default(), Counters::default());
    let mut chunk = vec![0; 1 << 14];
    loop {
        stream.readable().await?;
        let mut frames = Vec::new();
        match stream.try_read(&mut chunk) {
            Ok(0) => return Ok(()),
            Ok(length) => {
                let bytes = chunk.get(..length).unwrap_or_default();
                framer.push(bytes, &mut counters, |found| frames.extend_from_slice(found.frame().bytes));
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => return Err(error),
        }
        if !frames.is_empty() && events.send(Event::Frames(peer, frames)).await.is_err() {
            return Ok(());
        }
    }
}

async fn write(stream: &TcpStream, wanted: &mut mpsc::Receiver<Vec<u8>>) -> io::Result<()> {
    while let Some(datagram) = wanted.recv().await {
        let mut left = &datagram[..];
        while !left.is_empty() {
            stream.writable().await?;
            match stream.try_write(left) {
                Ok(length) => left = left.get(length..).unwrap_or_default(),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clients_are_told_from_addresses() {
        let [one, other] = [new_client(), new_client()];
        assert!(one != other && is_client(one) && is_client(other));
        assert!(!is_client(SocketAddr::from(([127, 0, 0, 1], 14_550))));
        assert!(!is_client("[::1]:14550".parse().unwrap()));
    }
}
