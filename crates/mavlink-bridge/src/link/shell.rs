//! The links of a ground station, on a thread of their own, so that what arrives is stamped when it arrives and not
//! when somebody has time for it.

use super::{Connection, HostPort, serial, tcp, udp};
use crate::{Counters, ImpairmentSettings, LinkError};
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot};

/// What may wait to be sent on one link: a serial line that is slower than what it is given loses the rest, and says
/// so.
const QUEUE_MAX: usize = 256;
/// A link that is down is tried again after this.
pub(super) const RETRY: Duration = Duration::from_millis(500);

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

/// A message to a link.
pub(super) type Send = (Peer, Vec<u8>);
/// Where links put what they tell.
pub(super) type Events = mpsc::UnboundedSender<LinkEvent>;

/// What a socket itself counts, for others to read while it runs.
pub(super) type SocketCounters = Arc<Mutex<Counters>>;

/// Open links.
#[derive(Debug)]
pub struct Links {
    queues: Vec<mpsc::Sender<Send>>,
    events: mpsc::UnboundedReceiver<LinkEvent>,
    overflows: Vec<u64>,
    socket_counters: Vec<SocketCounters>,
    addresses: Vec<Option<SocketAddr>>,
    thread: Option<JoinHandle<()>>,
}

impl Links {
    /// Opens links. What waits for others is bound before this returns; what connects to others is tried until it
    /// works.
    ///
    /// # Errors
    /// When an address cannot be bound, or a host name has no address.
    pub fn open(specs: Vec<LinkSpec>) -> Result<Self, OpenError> {
        let (tell, events) = mpsc::unbounded_channel();
        let (queues, takers): (Vec<_>, Vec<_>) = specs.iter().map(|_| mpsc::channel(QUEUE_MAX)).unzip();
        let overflows = vec![0; specs.len()];
        let socket_counters: Vec<SocketCounters> = specs.iter().map(|_| SocketCounters::default()).collect();
        let shared = socket_counters.clone();
        let (opened, is_open) = oneshot::channel();
        let thread = std::thread::Builder::new()
            .name("links".to_owned())
            .spawn(move || run(specs, takers, shared, tell, opened))
            .map_err(OpenError::Thread)?;
        let addresses =
            is_open.blocking_recv().unwrap_or_else(|_| Err(OpenError::Thread(io::ErrorKind::Other.into())))?;
        Ok(Self { queues, events, overflows, socket_counters, addresses, thread: Some(thread) })
    }

    /// The address that a UDP or listening TCP link is bound to.
    pub fn local_address(&self, link: usize) -> Option<SocketAddr> {
        self.addresses.get(link).copied().flatten()
    }

    /// Hands bytes to a link. What the link cannot take, because it is slower than what it is given, is lost and
    /// counted.
    pub fn send(&mut self, link: usize, peer: Peer, bytes: Vec<u8>) {
        if let Some(queue) = self.queues.get(link)
            && queue.try_send((peer, bytes)).is_err()
            && let Some(overflows) = self.overflows.get_mut(link)
        {
            *overflows += 1;
        }
    }

    /// How many datagrams or pieces a link could not take.
    pub fn overflows(&self, link: usize) -> u64 {
        self.overflows.get(link).copied().unwrap_or(0)
    }

    /// What the socket of a UDP link could not send or receive, and what the impairment did to it. Datagrams and bytes
    /// are counted by those who take and give them.
    pub fn socket_counters(&self, link: usize) -> Counters {
        let Some(shared) = self.socket_counters.get(link) else { return Counters::default() };
        let counters = *shared.lock().unwrap_or_else(PoisonError::into_inner);
        Counters {
            send_errors: counters.send_errors,
            receive_errors: counters.receive_errors,
            impairment_lost: counters.impairment_lost,
            impairment_duplicated: counters.impairment_duplicated,
            impairment_reordered: counters.impairment_reordered,
            ..Counters::default()
        }
    }

    /// Waits for what a link tells next; none when all of them have ended. Cancel safe.
    pub async fn next(&mut self) -> Option<LinkEvent> {
        self.events.recv().await
    }

    /// What a link has told and nobody has taken, if anything.
    pub fn try_next(&mut self) -> Option<LinkEvent> {
        self.events.try_recv().ok()
    }
}

impl Drop for Links {
    /// Sends what waits, and ends the thread.
    fn drop(&mut self) {
        self.queues.clear();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn run(
    specs: Vec<LinkSpec>,
    takers: Vec<mpsc::Receiver<Send>>,
    counters: Vec<SocketCounters>,
    tell: Events,
    opened: oneshot::Sender<Result<Vec<Option<SocketAddr>>, OpenError>>,
) {
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => {
            let _ = opened.send(Err(OpenError::Thread(error)));
            return;
        }
    };
    runtime.block_on(async {
        let mut tasks = tokio::task::JoinSet::new();
        let mut addresses = Vec::new();
        for (link, ((spec, taker), counters)) in specs.into_iter().zip(takers).zip(counters).enumerate() {
            let started = match &spec.connection {
                Connection::UdpIn(_) | Connection::UdpOut(_) => {
                    udp::start(&mut tasks, link, spec, counters, taker, tell.clone())
                }
                Connection::TcpIn(address) => {
                    let address = address.clone();
                    tcp::start_listening(&mut tasks, link, spec, &address, taker, tell.clone()).await
                }
                Connection::TcpOut(address) => {
                    tasks.spawn(tcp::connect(link, address.clone(), taker, tell.clone()));
                    Ok(None)
                }
                Connection::Serial { device, baud } => {
                    tasks.spawn(serial::run(link, device.clone(), *baud, taker, tell.clone()));
                    Ok(None)
                }
            };
            match started {
                Ok(address) => addresses.push(address),
                Err(error) => {
                    let _ = opened.send(Err(error));
                    return;
                }
            }
        }
        drop(tell);
        if opened.send(Ok(addresses)).is_ok() {
            while tasks.join_next().await.is_some() {}
        }
    });
}

/// A link is down: says why, once for each reason, and waits until it is to be tried again. What was to be sent
/// meanwhile is out of date then, and thrown away. False when nobody wants the link any more.
pub(super) async fn wait_to_retry(
    link: usize,
    reason: String,
    told: &mut Option<String>,
    taker: &mut mpsc::Receiver<Send>,
    tell: &Events,
) -> bool {
    if told.as_ref() != Some(&reason) {
        if tell.send(LinkEvent::Down(link, reason.clone())).is_err() {
            return false;
        }
        *told = Some(reason);
    }
    let again = tokio::time::sleep(RETRY);
    tokio::pin!(again);
    loop {
        tokio::select! {
            () = &mut again => return true,
            wanted = taker.recv() => if wanted.is_none() { return false },
        }
    }
}

/// The addresses of a host, of which the first is used.
pub(super) fn resolve(connection: &Connection, address: &HostPort) -> Result<SocketAddr, OpenError> {
    let refused = |reason: String| OpenError::Host { connection: connection.clone(), reason };
    let mut found =
        (address.host.as_str(), address.port).to_socket_addrs().map_err(|error| refused(error.to_string()))?;
    found.next().ok_or_else(|| refused("it has no address".to_owned()))
}
