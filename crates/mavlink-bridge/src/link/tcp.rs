//! TCP: a connection that is made again whenever it breaks, or a port where others connect.

use super::event::{Arrival, Events, LinkEvent, Peer, Send};
use super::retry::{RETRY, wait_to_retry};
use super::spec::{LinkSpec, OpenError, resolve};
use super::{Connection, HostPort};
use std::collections::HashMap;
use std::io;
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::task::JoinSet;

/// A connection attempt is given up after this.
const CONNECT_PATIENCE: Duration = Duration::from_secs(5);
/// What may wait for a peer that reads slowly.
const QUEUE_MAX: usize = 256;

/// Keeps a connection to an address.
pub(super) async fn connect(link: usize, address: HostPort, mut taker: mpsc::Receiver<Send>, tell: Events) {
    let mut told = None;
    loop {
        let target = resolve(&Connection::TcpOut(address.clone()), &address);
        let opened = match target {
            Ok(target) => match tokio::time::timeout(CONNECT_PATIENCE, TcpStream::connect(target)).await {
                Ok(opened) => opened.map_err(|error| error.to_string()),
                Err(_) => Err("no answer".to_owned()),
            },
            Err(error) => Err(error.to_string()),
        };
        let reason = match opened {
            Ok(stream) => {
                told = None;
                let _ = tell.send(LinkEvent::Up(link));
                match exchange(link, Peer::Only, &stream, &mut taker, &tell).await {
                    Ended::Broken(reason) => reason,
                    Ended::Closed => return,
                }
            }
            Err(reason) => reason,
        };
        if !wait_to_retry(link, reason, &mut told, &mut taker, &tell).await {
            return;
        }
    }
}

/// Binds a port and starts to accept connections.
pub(super) async fn start_listening(
    tasks: &mut JoinSet<()>,
    link: usize,
    spec: LinkSpec,
    address: &HostPort,
    taker: mpsc::Receiver<Send>,
    tell: Events,
) -> Result<Option<SocketAddr>, OpenError> {
    let bind = resolve(&spec.connection, address)?;
    let refused = |source| OpenError::Tcp { connection: spec.connection.clone(), source };
    let listener = TcpListener::bind(bind).await.map_err(refused)?;
    let local = listener.local_addr().map_err(refused)?;
    let _ = tell.send(LinkEvent::Up(link));
    tasks.spawn(listen(link, listener, taker, tell));
    Ok(Some(local))
}

async fn listen(link: usize, listener: TcpListener, mut taker: mpsc::Receiver<Send>, tell: Events) {
    let mut peers: HashMap<SocketAddr, mpsc::Sender<Send>> = HashMap::new();
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, address)) => {
                    let (queue, mut wanted) = mpsc::channel(QUEUE_MAX);
                    peers.insert(address, queue);
                    let tell = tell.clone();
                    connections.spawn(async move {
                        let peer = Peer::Address(address);
                        exchange(link, peer, &stream, &mut wanted, &tell).await;
                        let _ = tell.send(LinkEvent::Gone(link, peer));
                        address
                    });
                }
                Err(error) => {
                    tracing::debug!(%error, "connection not accepted");
                    tokio::time::sleep(RETRY).await;
                }
            },
            Some(Ok(gone)) = connections.join_next() => {
                peers.remove(&gone);
            }
            wanted = taker.recv() => match wanted {
                Some((Peer::Address(address), bytes)) => if let Some(queue) = peers.get(&address) {
                    let _ = queue.try_send((Peer::Only, bytes));
                },
                Some((Peer::Only, bytes)) => for queue in peers.values() {
                    let _ = queue.try_send((Peer::Only, bytes.clone()));
                },
                None => return,
            },
        }
    }
}

/// How an exchange ended.
enum Ended {
    /// The connection broke.
    Broken(String),
    /// Nobody wants it any more.
    Closed,
}

/// Reads and writes until the connection breaks.
async fn exchange(
    link: usize,
    peer: Peer,
    stream: &TcpStream,
    taker: &mut mpsc::Receiver<Send>,
    tell: &Events,
) -> Ended {
    // Setpoints do not wait to be gathered into larger pieces.
    let _ = stream.set_nodelay(true);
    let mut buffer = vec![0; 1 << 16];
    let mut unsent: Vec<u8> = Vec::new();
    loop {
        tokio::select! {
            ready = stream.readable() => {
                if let Err(error) = ready {
                    return Ended::Broken(error.to_string());
                }
                match stream.try_read(&mut buffer) {
                    Ok(0) => return Ended::Broken("the other end closed the connection".to_owned()),
                    Ok(length) => {
                        let bytes = buffer[..length].to_vec();
                        let arrival = Arrival { link, peer, at: Instant::now(), bytes, is_stream: true };
                        if tell.send(LinkEvent::Arrival(arrival)).is_err() {
                            return Ended::Closed;
                        }
                    }
                    Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                    Err(error) => return Ended::Broken(error.to_string()),
                }
            }
            ready = stream.writable(), if !unsent.is_empty() => {
                if let Err(error) = ready.and_then(|()| write(stream, &mut unsent)) {
                    return Ended::Broken(error.to_string());
                }
            }
            wanted = taker.recv(), if unsent.is_empty() => match wanted {
                Some((_, bytes)) => {
                    unsent = bytes;
                    if let Err(error) = write(stream, &mut unsent) {
                        return Ended::Broken(error.to_string());
                    }
                }
                None => return Ended::Closed,
            },
        }
    }
}

/// Writes what the system takes now.
fn write(stream: &TcpStream, unsent: &mut Vec<u8>) -> io::Result<()> {
    match stream.try_write(unsent) {
        Ok(length) => {
            unsent.drain(..length);
            Ok(())
        }
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
        Err(error) => Err(error),
    }
}
