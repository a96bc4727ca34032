//! The links of a ground station, on a thread of their own, so that what arrives is stamped when it arrives and not
//! when somebody has time for it.

use super::event::{Events, LinkEvent, Peer, Send, SocketCounters};
use super::spec::{LinkSpec, OpenError};
use super::{Connection, serial, tcp, udp};
use crate::Counters;
use std::io;
use std::net::SocketAddr;
use std::sync::PoisonError;
use std::thread::JoinHandle;
use tokio::sync::{mpsc, oneshot};

/// What may wait to be sent on one link: a serial line that is slower than what it is given loses the rest, and says
/// so.
const QUEUE_MAX: usize = 256;
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
