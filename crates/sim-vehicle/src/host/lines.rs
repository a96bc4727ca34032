//! All ways in and out of the vehicles behind one port: UDP, TCP clients, a multicast group, a pilot's transmitter.

use crate::host::clock::HostError;
use crate::host::layout::{PortSet, UdpPort};
use crate::host::tcp::{Event, TcpServer};
use crate::links::PeerId;
use mavlink_bridge::{Counters, LinkError, LinkSettings, MulticastLink, UdpLink};
use std::net::SocketAddr;

/// The lines of one endpoint.
#[derive(Debug)]
pub(crate) struct Lines {
    udp: Udp,
    /// A PX4 has two.
    second: Option<Udp>,
    tcp: Option<TcpServer>,
    group: Option<MulticastLink>,
    transmitter: Option<UdpLink>,
    heard: Vec<u8>,
    pulses: Vec<u8>,
}

/// What has come in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// A datagram, or whole frames of a stream.
    Datagram(PeerId),
    /// What a pilot's transmitter sends.
    Pulses,
    /// A TCP client has connected.
    Opened(PeerId),
    /// A TCP client is gone.
    Closed(PeerId),
}

/// A UDP port and, where it has one partner only, this.
#[derive(Debug)]
struct Udp {
    link: UdpLink,
    partner: Option<Partner>,
    heard: Vec<u8>,
}

/// The one other end of a UDP port, as a PX4 has it: who sends first gets everything from then on. Others are obeyed
/// and not answered.
#[derive(Debug)]
struct Partner {
    /// The vehicles know it by this address, whoever it is.
    name: SocketAddr,
    address: SocketAddr,
    is_found: bool,
}

impl Lines {
    /// Opens the ports, or none of them.
    pub fn open(ports: &PortSet, settings: &LinkSettings, group: Option<MulticastLink>) -> Result<Self, HostError> {
        let mut udp = ports.udp.iter().enumerate();
        let mut next = || udp.next().map(|(number, port)| Udp::open(port, settings, number as u64)).transpose();
        let Some(first) = next()? else { return Err(HostError::TooManyPorts { base_port: 0, count: 0 }) };
        let second = next()?;
        let tcp = (!ports.tcp.is_empty()).then(|| TcpServer::bind(&ports.tcp)).transpose()?;
        let hear = |address: SocketAddr| UdpLink::bind(address, LinkSettings::default());
        let transmitter = ports.transmitter.map(hear).transpose()?;
        Ok(Self { udp: first, second, tcp, group, transmitter, heard: Vec::new(), pulses: Vec::new() })
    }

    /// The address of the first UDP port.
    pub fn local_addr(&self) -> Result<SocketAddr, LinkError> {
        self.udp.link.local_addr()
    }

    /// Every address at which it listens, with the protocol.
    pub fn addresses(&self) -> Vec<(Protocol, SocketAddr)> {
        let udp = [Some(&self.udp), self.second.as_ref()].into_iter().flatten();
        let udp = udp.filter_map(|udp| Some((Protocol::Udp, udp.link.local_addr().ok()?)));
        let tcp = self.tcp.iter().flat_map(TcpServer::addresses).map(|address| (Protocol::Tcp, *address));
        let group = self.group.iter().map(|group| (Protocol::Multicast, group.group()));
        udp.chain(tcp).chain(group).collect()
    }

    /// What all ports have seen.
    pub fn counters(&self) -> Counters {
        let mut counters = self.udp.link.counters();
        if let Some(second) = &self.second {
            counters += second.link.counters();
        }
        counters
    }

    /// Waits for what comes next; a datagram replaces what is in `buf`. Cancel safe.
    pub async fn recv(&mut self, buf: &mut Vec<u8>) -> Result<Arrival, LinkError> {
        let arrival = tokio::select! {
            from = self.udp.recv() => { std::mem::swap(buf, &mut self.udp.heard); Arrival::Datagram(from?) }
            from = recv_second(&mut self.second) => {
                let from = from?;
                if let Some(second) = &mut self.second {
                    std::mem::swap(buf, &mut second.heard);
                }
                Arrival::Datagram(from)
            }
            event = recv_tcp(&mut self.tcp) => take(event, buf),
            heard = recv_pulses(&mut self.transmitter, &mut self.pulses) => {
                heard?;
                std::mem::swap(buf, &mut self.pulses);
                Arrival::Pulses
            }
            from = recv_group(&self.group, &mut self.heard) => {
                std::mem::swap(buf, &mut self.heard);
                Arrival::Datagram(from?)
            }
        };
        Ok(arrival)
    }

    /// What has come already, if anything; see [`recv`](Self::recv).
    pub fn try_recv(&mut self, buf: &mut Vec<u8>) -> Result<Option<Arrival>, LinkError> {
        for udp in [Some(&mut self.udp), self.second.as_mut()].into_iter().flatten() {
            if let Some(from) = udp.link.try_recv(buf)? {
                return Ok(Some(Arrival::Datagram(udp.name(from))));
            }
        }
        if let Some(transmitter) = &mut self.transmitter
            && transmitter.try_recv(buf)?.is_some()
        {
            return Ok(Some(Arrival::Pulses));
        }
        if let Some(event) = self.tcp.as_mut().and_then(TcpServer::try_recv) {
            return Ok(Some(take(event, buf)));
        }
        match &self.group {
            Some(group) if group.try_recv(buf)? => Ok(Some(Arrival::Datagram(group.group()))),
            _ => Ok(None),
        }
    }

    /// Sends a datagram to a peer.
    pub async fn send_to(&mut self, datagram: &[u8], peer: PeerId) {
        if let Some(group) = self.group.as_ref().filter(|group| group.group() == peer) {
            return group.send(datagram).await;
        }
        if self.tcp.as_mut().is_some_and(|tcp| tcp.send_to(datagram, peer)) || crate::host::tcp::is_client(peer) {
            return;
        }
        let is_seconds = |udp: &&mut Udp| udp.partner.as_ref().is_some_and(|partner| partner.name == peer);
        let udp = self.second.as_mut().filter(is_seconds).unwrap_or(&mut self.udp);
        let address = udp.partner.as_ref().map_or(peer, |partner| partner.address);
        udp.link.send_to(datagram, address).await;
    }

    /// Closes all ports.
    pub async fn close(self) {
        if let Some(tcp) = self.tcp {
            tcp.close().await;
        }
    }
}

/// What an address is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// A UDP port.
    Udp,
    /// A TCP port that takes several clients.
    Tcp,
    /// A UDP multicast group.
    Multicast,
}

impl Udp {
    fn open(port: &UdpPort, settings: &LinkSettings, number: u64) -> Result<Self, HostError> {
        let settings = LinkSettings { stream: settings.stream.wrapping_add(number), ..*settings };
        let partner = port.partner.map(|name| Partner { name, address: name, is_found: false });
        Ok(Self { link: UdpLink::bind(port.bind, settings)?, partner, heard: Vec::new() })
    }

    async fn recv(&mut self) -> Result<PeerId, LinkError> {
        let from = self.link.recv(&mut self.heard).await?;
        Ok(self.name(from))
    }

    /// Who the vehicles take a sender for.
    fn name(&mut self, from: SocketAddr) -> PeerId {
        let Some(partner) = &mut self.partner else { return from };
        if !partner.is_found {
            (partner.address, partner.is_found) = (from, true);
        }
        partner.name
    }
}

async fn recv_second(second: &mut Option<Udp>) -> Result<PeerId, LinkError> {
    match second {
        Some(udp) => udp.recv().await,
        None => std::future::pending().await,
    }
}

async fn recv_tcp(tcp: &mut Option<TcpServer>) -> Event {
    match tcp {
        Some(tcp) => tcp.recv().await,
        None => std::future::pending().await,
    }
}

async fn recv_pulses(transmitter: &mut Option<UdpLink>, pulses: &mut Vec<u8>) -> Result<(), LinkError> {
    match transmitter {
        Some(link) => link.recv(pulses).await.map(drop),
        None => std::future::pending().await,
    }
}

async fn recv_group(group: &Option<MulticastLink>, heard: &mut Vec<u8>) -> Result<PeerId, LinkError> {
    match group {
        Some(group) => group.recv(heard).await.map(|()| group.group()),
        None => std::future::pending().await,
    }
}

fn take(event: Event, buf: &mut Vec<u8>) -> Arrival {
    match event {
        Event::Opened(peer, _) => Arrival::Opened(peer),
        Event::Closed(peer) => Arrival::Closed(peer),
        Event::Frames(peer, frames) => {
            *buf = frames;
            Arrival::Datagram(peer)
        }
    }
}
