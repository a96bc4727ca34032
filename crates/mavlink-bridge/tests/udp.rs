//! Real sockets on the loopback.
#![cfg(test)]

use flight_model::State;
use mavlink_bridge::{
    Counters, Encoder, ImpairmentSettings, LinkError, LinkSettings, Message, UdpLink, frames, local_position_ned,
    messages, state_from_local_position, wire_round,
};
use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

const ANY_PORT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);
/// A test that waits longer than this has failed.
const PATIENCE: Duration = Duration::from_secs(20);

fn bind(settings: LinkSettings) -> UdpLink {
    UdpLink::bind(ANY_PORT, settings).unwrap()
}

async fn recv(link: &mut UdpLink, buf: &mut Vec<u8>) -> SocketAddr {
    tokio::time::timeout(PATIENCE, link.recv(buf)).await.expect("a datagram in time").unwrap()
}

#[tokio::test]
async fn thirty_frames_in_one_datagram_and_an_answer() {
    let mut server = bind(LinkSettings::default());
    let mut client = bind(LinkSettings::default());
    let states: Vec<State> = (0..30)
        .map(|index| State { x_m: 0.1 * f64::from(index), speed_mps: 9.7, course_rad: 0.3, ..State::default() })
        .collect();
    let mut datagram = Vec::new();
    let mut encoder = Encoder::new(1, 1);
    for state in &states {
        encoder.encode(&local_position_ned(Duration::from_millis(500), state), &mut datagram);
    }
    client.send_to(&datagram, server.local_addr().unwrap()).await;

    let mut buf = Vec::new();
    let from = recv(&mut server, &mut buf).await;
    assert_eq!(from, client.local_addr().unwrap());
    let mut counters = Counters::default();
    let received: Vec<State> = messages(&buf, &mut counters)
        .map(|(_, message)| match message {
            Ok(Message::LOCAL_POSITION_NED(position)) => state_from_local_position(&position),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(received, states.iter().map(wire_round).collect::<Vec<_>>());
    assert_eq!((counters.datagrams, counters.frames), (1, 30));

    server.send_to(b"answer", from).await;
    recv(&mut client, &mut buf).await;
    assert_eq!(buf, b"answer");
    let sent = client.counters();
    assert_eq!((sent.datagrams_sent, sent.bytes_sent), (1, datagram.len() as u64));
}

#[tokio::test]
async fn one_socket_serves_many_peers() {
    let mut server = bind(LinkSettings::default());
    let address = server.local_addr().unwrap();
    let mut clients: Vec<UdpLink> = (0..20).map(|_| bind(LinkSettings::default())).collect();
    for (index, client) in clients.iter_mut().enumerate() {
        client.send_to(&[index as u8], address).await;
    }
    let mut buf = Vec::new();
    for _ in 0..clients.len() {
        let from = recv(&mut server, &mut buf).await;
        assert_eq!(from, clients[usize::from(buf[0])].local_addr().unwrap());
        let answer = [buf[0] + 100];
        server.send_to(&answer, from).await;
    }
    for (index, client) in clients.iter_mut().enumerate() {
        recv(client, &mut buf).await;
        assert_eq!(buf, [index as u8 + 100]);
    }
}

#[tokio::test]
async fn a_busy_port_is_said_so() {
    let first = bind(LinkSettings::default());
    let address = first.local_addr().unwrap();
    let error = UdpLink::bind(address, LinkSettings::default()).unwrap_err();
    assert!(matches!(error, LinkError::Bind { .. }));
    assert_eq!(error.to_string(), format!("cannot bind UDP {address}: the port is busy"));
}

#[test]
fn a_link_needs_a_runtime() {
    assert!(matches!(UdpLink::bind(ANY_PORT, LinkSettings::default()), Err(LinkError::Bind { .. })));
}

#[tokio::test]
async fn settings_out_of_range_are_refused() {
    let inbound = ImpairmentSettings { loss: 2.0, ..Default::default() };
    let error = UdpLink::bind(ANY_PORT, LinkSettings { inbound, ..Default::default() }).unwrap_err();
    assert_eq!(error.to_string(), "link impairment: loss is 2, but must be from 0 to 1");
}

#[tokio::test]
async fn a_peer_that_is_gone_does_not_end_the_link() {
    let mut link = bind(LinkSettings::default());
    let gone = bind(LinkSettings::default()).local_addr().unwrap();
    let mut alive = bind(LinkSettings::default());
    for _ in 0..10 {
        link.send_to(b"anybody?", gone).await;
    }
    alive.send_to(b"here", link.local_addr().unwrap()).await;
    let mut buf = Vec::new();
    recv(&mut link, &mut buf).await;
    assert_eq!(buf, b"here");
}

#[tokio::test]
async fn a_datagram_that_cannot_be_sent_is_counted() {
    let mut link = bind(LinkSettings::default());
    let peer = bind(LinkSettings::default()).local_addr().unwrap();
    link.send_to(&vec![0; 70_000], peer).await;
    assert_eq!((link.counters().send_errors, link.counters().datagrams_sent), (1, 0));
}

#[tokio::test]
async fn try_recv_does_not_wait() {
    let mut server = bind(LinkSettings::default());
    let mut client = bind(LinkSettings::default());
    let mut buf = Vec::new();
    assert_eq!(server.try_recv(&mut buf).unwrap(), None);
    client.send_to(b"one", server.local_addr().unwrap()).await;
    client.send_to(b"two", server.local_addr().unwrap()).await;
    recv(&mut server, &mut buf).await;
    assert_eq!(buf, b"one");
    assert_eq!(server.try_recv(&mut buf).unwrap(), Some(client.local_addr().unwrap()));
    assert_eq!(buf, b"two");
    assert_eq!(server.try_recv(&mut buf).unwrap(), None);
}

#[tokio::test]
async fn recv_that_is_dropped_loses_nothing() {
    let mut server = bind(LinkSettings {
        inbound: ImpairmentSettings { delay_ms: 5.0, ..Default::default() },
        ..Default::default()
    });
    let mut client = bind(LinkSettings::default());
    let address = server.local_addr().unwrap();
    let mut buf = Vec::new();
    let mut received = Vec::new();
    for number in 0..50_u8 {
        client.send_to(&[number], address).await;
        tokio::select! {
            result = server.recv(&mut buf) => { result.unwrap(); received.push(buf[0]); }
            () = tokio::time::sleep(Duration::from_millis(1)) => {}
        }
    }
    while received.len() < 50 {
        recv(&mut server, &mut buf).await;
        received.push(buf[0]);
    }
    assert_eq!(received, (0..50).collect::<Vec<u8>>());
}

#[tokio::test]
async fn delayed_datagrams_leave_while_the_link_waits() {
    let settings = ImpairmentSettings { delay_ms: 20.0, ..Default::default() };
    let mut near = bind(LinkSettings { outbound: settings, inbound: settings, ..Default::default() });
    let mut far = bind(LinkSettings::default());
    let (near_address, far_address) = (near.local_addr().unwrap(), far.local_addr().unwrap());
    let started = tokio::time::Instant::now();
    near.send_to(b"ping", far_address).await;
    let echo = async {
        let mut buf = Vec::new();
        recv(&mut far, &mut buf).await;
        far.send_to(&buf, near_address).await;
    };
    let mut buf = Vec::new();
    tokio::join!(echo, async { recv(&mut near, &mut buf).await });
    assert_eq!(buf, b"ping");
    // Not a bound on how fast the machine is: what is delayed may not come early.
    assert!(started.elapsed() >= Duration::from_millis(40));
}

#[tokio::test]
async fn an_impaired_link_loses_by_its_seed() {
    let survivors = |seed: u64| async move {
        let outbound = ImpairmentSettings { loss: 0.3, ..Default::default() };
        let mut sender = bind(LinkSettings { outbound, seed, ..Default::default() });
        let mut receiver = bind(LinkSettings::default());
        let address = receiver.local_addr().unwrap();
        for number in 0..200_u8 {
            sender.send_to(&[number], address).await;
        }
        let lost = sender.counters().impairment_lost;
        let mut buf = Vec::new();
        let mut received = Vec::new();
        for _ in 0..200 - lost {
            recv(&mut receiver, &mut buf).await;
            received.push(buf[0]);
        }
        assert_eq!(sender.counters().datagrams_sent, 200 - lost);
        received
    };
    let (first, second, other) = (survivors(1).await, survivors(1).await, survivors(2).await);
    assert_eq!(first, second);
    assert_ne!(first, other);
    assert!((110..170).contains(&first.len()));
}

#[tokio::test]
async fn nonsense_to_a_port_is_counted_and_the_link_goes_on() {
    let mut server = bind(LinkSettings::default());
    let mut client = bind(LinkSettings::default());
    let address = server.local_addr().unwrap();
    let mut good = Vec::new();
    Encoder::new(1, 1).encode(&local_position_ned(Duration::ZERO, &State::default()), &mut good);
    let mut bad_checksum = good.clone();
    let last = bad_checksum.len() - 1;
    bad_checksum[last] ^= 0xFF;
    for datagram in [&b"nonsense"[..], &[], &good[..good.len() - 4], &bad_checksum, &good] {
        client.send_to(datagram, address).await;
    }
    let mut counters = Counters::default();
    let mut buf = Vec::new();
    for _ in 0..5 {
        recv(&mut server, &mut buf).await;
        frames(&buf, &mut counters).for_each(drop);
    }
    assert_eq!((counters.datagrams, counters.frames, counters.bad_checksum), (5, 1, 1));
    assert_eq!(counters.malformed_bytes, 8 + good.len() as u64 - 4);
}
