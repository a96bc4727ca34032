//! UDP: one socket, any number of peers.

use super::Connection;
use super::event::{Arrival, Events, LinkEvent, Peer, Send, SocketCounters};
use super::retry::RETRY;
use super::spec::{LinkSpec, OpenError, resolve};
use crate::{Counters, LinkSettings, UdpLink};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::PoisonError;
use std::time::Instant;
use tokio::sync::mpsc;
use tokio::task::JoinSet;

/// Binds the socket and starts to listen.
pub(super) fn start(
    tasks: &mut JoinSet<()>,
    link: usize,
    spec: LinkSpec,
    counters: SocketCounters,
    taker: mpsc::Receiver<Send>,
    tell: Events,
) -> Result<Option<SocketAddr>, OpenError> {
    let (bind, default_peer) = match &spec.connection {
        Connection::UdpOut(address) => {
            let peer = resolve(&spec.connection, address)?;
            (SocketAddr::new(any_host(&peer), 0), Some(peer))
        }
        Connection::UdpIn(address) => (resolve(&spec.connection, address)?, None),
        _ => return Ok(None),
    };
    let settings = LinkSettings {
        inbound: spec.impairment,
        outbound: spec.impairment,
        seed: spec.seed,
        stream: link as u64,
        ..LinkSettings::default()
    };
    let refused = |source| OpenError::Udp { connection: spec.connection.clone(), source };
    let socket = UdpLink::bind(bind, settings).map_err(refused)?;
    let local = socket.local_addr().map_err(refused)?;
    let _ = tell.send(LinkEvent::Up(link));
    tasks.spawn(run(link, socket, default_peer, (bind, settings), counters, taker, tell));
    Ok(Some(local))
}

/// Where a socket that speaks to `peer` is bound: on loopback nobody else need reach it.
fn any_host(peer: &SocketAddr) -> IpAddr {
    match peer.ip() {
        ip if ip.is_loopback() => ip,
        IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    }
}

async fn run(
    link: usize,
    mut socket: UdpLink,
    default_peer: Option<SocketAddr>,
    (bind, settings): (SocketAddr, LinkSettings),
    counters: SocketCounters,
    mut taker: mpsc::Receiver<Send>,
    tell: Events,
) {
    let mut bytes = Vec::new();
    // What a socket that was given up had counted.
    let mut before = Counters::default();
    loop {
        *counters.lock().unwrap_or_else(PoisonError::into_inner) = before + socket.counters();
        tokio::select! {
            biased;
            wanted = taker.recv() => match wanted {
                Some((Peer::Address(address), datagram)) => socket.send_to(&datagram, address).await,
                Some((Peer::Only, datagram)) => if let Some(address) = default_peer {
                    socket.send_to(&datagram, address).await;
                },
                None => return,
            },
            received = socket.recv(&mut bytes) => match received {
                Ok(from) => {
                    let arrival = Arrival {
                        link,
                        peer: Peer::Address(from),
                        at: Instant::now(),
                        bytes: std::mem::take(&mut bytes),
                        is_stream: false,
                    };
                    if tell.send(LinkEvent::Arrival(arrival)).is_err() {
                        return;
                    }
                }
                Err(error) => {
                    let _ = tell.send(LinkEvent::Down(link, error.to_string()));
                    before += socket.counters();
                    loop {
                        tokio::time::sleep(RETRY).await;
                        if tell.is_closed() {
                            return;
                        }
                        if let Ok(again) = UdpLink::bind(bind, settings) {
                            socket = again;
                            break;
                        }
                    }
                    let _ = tell.send(LinkEvent::Up(link));
                }
            },
        }
    }
}
