//! Real links on loopback: what arrives, what is sent, and what happens when the other end goes away and comes back.

use mavlink_bridge::ImpairmentSettings;
use mavlink_bridge::link::{Arrival, LinkEvent, LinkSpec, Links, Peer};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::time::{Duration, Instant};

#[allow(clippy::expect_used)]
fn spec(connection: &str) -> LinkSpec {
    let connection = connection.parse().expect("a connection string");
    LinkSpec { connection, calls: Vec::new(), impairment: ImpairmentSettings::default(), seed: 1 }
}

/// The next event that `wanted` takes.
#[allow(clippy::panic)] // a test's helper
fn wait<T>(links: &mut Links, wanted: impl Fn(&LinkEvent) -> Option<T>) -> T {
    let deadline = Instant::now() + Duration::from_secs(20);
    while Instant::now() < deadline {
        match links.try_next() {
            Some(event) => {
                if let Some(found) = wanted(&event) {
                    return found;
                }
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
    panic!("the event did not come");
}

fn arrival(event: &LinkEvent) -> Option<Arrival> {
    match event {
        LinkEvent::Arrival(arrival) => Some(arrival.clone()),
        _ => None,
    }
}

#[test]
fn udp_speaks_first_and_is_spoken_to() {
    let other = UdpSocket::bind("127.0.0.1:0").unwrap();
    other.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let mut links = Links::open(vec![spec(&format!("udpout:{}", other.local_addr().unwrap()))]).unwrap();
    links.send(0, Peer::Only, b"hello".to_vec());
    let mut buffer = [0; 64];
    let (length, from) = other.recv_from(&mut buffer).unwrap();
    assert_eq!(&buffer[..length], b"hello");
    other.send_to(b"answer", from).unwrap();
    let answer = wait(&mut links, arrival);
    assert_eq!((answer.bytes.as_slice(), answer.is_stream), (&b"answer"[..], false));
    links.send(0, answer.peer, b"again".to_vec());
    assert_eq!(other.recv(&mut buffer).unwrap(), 5);
}

#[test]
fn a_tcp_connection_is_made_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut links = Links::open(vec![spec(&format!("tcp:{}", listener.local_addr().unwrap()))]).unwrap();
    for round in 0..2_u8 {
        let (mut other, _) = listener.accept().unwrap();
        wait(&mut links, |event| (*event == LinkEvent::Up(0)).then_some(()));
        other.write_all(&[round; 3]).unwrap();
        assert_eq!(wait(&mut links, arrival).bytes, [round; 3]);
        links.send(0, Peer::Only, vec![round; 5]);
        let mut heard = [9; 5];
        other.read_exact(&mut heard).unwrap();
        assert_eq!(heard, [round; 5]);
        drop(other);
        let reason = wait(&mut links, |event| match event {
            LinkEvent::Down(0, reason) => Some(reason.clone()),
            _ => None,
        });
        assert!(!reason.is_empty());
    }
}

#[test]
fn a_tcp_port_serves_several_and_forgets_who_goes() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut links = Links::open(vec![spec(&format!("tcpin:{free}"))]).unwrap();
    let address = links.local_address(0).unwrap();
    let mut others: Vec<TcpStream> = (0..2).map(|_| TcpStream::connect(address).unwrap()).collect();
    let mut peers = Vec::new();
    for other in &mut others {
        other.write_all(b"here").unwrap();
        peers.push(wait(&mut links, arrival).peer);
    }
    assert_ne!(peers[0], peers[1]);
    links.send(0, peers[1], b"you".to_vec());
    let mut heard = [0; 3];
    others[1].read_exact(&mut heard).unwrap();
    assert_eq!(&heard, b"you");
    drop(others.remove(0));
    let gone = wait(&mut links, |event| match event {
        LinkEvent::Gone(0, peer) => Some(*peer),
        _ => None,
    });
    assert_eq!(gone, peers[0]);
}

#[test]
fn what_cannot_be_bound_is_told_with_its_name() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let connection = format!("udpin:{}", taken.local_addr().unwrap());
    let error = Links::open(vec![spec(&connection)]).unwrap_err().to_string();
    assert!(error.contains(&connection) && error.contains("busy"), "{error}");
}

#[test]
fn a_serial_port_that_is_not_there_is_told_and_tried_again() {
    let mut links = Links::open(vec![spec("/dev/no-such-port,57600")]).unwrap();
    let reason = wait(&mut links, |event| match event {
        LinkEvent::Down(0, reason) => Some(reason.clone()),
        _ => None,
    });
    assert!(reason.contains("No such file"), "{reason}");
}
