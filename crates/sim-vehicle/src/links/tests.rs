use super::*;
use crate::telemetry::rates::TelemetryRates;
use mavlink_bridge::telemetry::ground_heartbeat;

const NOW: Duration = Duration::ZERO;

fn peer(port: u16) -> PeerId {
    PeerId::from(([127, 0, 0, 1], port))
}

fn links() -> Links {
    let rates = TelemetryRates::OFF;
    Links::new(&VehicleSettings { rates, ground: Some(peer(14550)), ..VehicleSettings::default() })
}

fn drain(links: &mut Links) -> Vec<Transmit> {
    std::iter::from_fn(|| links.poll()).collect()
}

#[test]
fn a_bad_radio_loses_its_share_of_the_frames() {
    let mut links = links();
    let mut heard = |loss| {
        links.set_loss(loss);
        (0..1_000).for_each(|_| links.send_all(&ground_heartbeat()));
        drain(&mut links).iter().map(|sent| frames(&sent.datagram, &mut Counters::default()).count()).sum::<usize>()
    };
    assert_eq!((heard(0.0), heard(1.0)), (1_000, 0));
    assert!((650..750).contains(&heard(0.3)));
}

#[test]
fn silent_peers_are_forgotten_and_the_ground_is_not() {
    let mut links = links();
    assert_eq!(links.hear(peer(1), Version::V2, NOW, NOW), (1, true));
    assert_eq!(links.hear(peer(1), Version::V2, Duration::from_secs(20), NOW), (1, false));
    links.drop_silent(Duration::from_secs(139));
    assert_eq!(links.len(), 2);
    links.drop_silent(Duration::from_secs(140));
    assert_eq!(links.len(), 1);
}

#[test]
fn a_crowd_displaces_the_most_silent() {
    let mut links = links();
    for port in 1..=100u16 {
        links.hear(peer(port), Version::V2, Duration::from_millis(u64::from(port)), NOW);
    }
    assert_eq!(links.len(), LINKS_MAX);
    assert_eq!(links.links[0].peer, peer(14550));
    assert_eq!(links.hear(peer(100), Version::V2, NOW, NOW), (LINKS_MAX - 1, false));
}

#[test]
fn frames_are_packed_and_each_link_counts_its_own() {
    let mut links = links();
    links.hear(peer(1), Version::V2, NOW, NOW);
    for _ in 0..100 {
        links.send_all(&ground_heartbeat());
    }
    links.send(1, &ground_heartbeat());
    let sent = drain(&mut links);
    assert!(sent.iter().all(|transmit| transmit.datagram.len() <= DATAGRAM_BYTES_MAX));
    assert!(sent.len() < 10);
    for (to, expected) in [(peer(14550), 100), (peer(1), 101)] {
        let bytes: Vec<u8> = sent.iter().filter(|t| t.to == to).flat_map(|t| t.datagram.clone()).collect();
        let sequences: Vec<u8> = frames(&bytes, &mut Counters::default()).map(|f| f.header.sequence).collect();
        assert_eq!(sequences, (0..expected).collect::<Vec<u8>>());
    }
}

#[test]
fn a_batch_is_sent_again_as_it_was_and_replies_are_not_part_of_it() {
    let mut links = links();
    links.send(0, &ground_heartbeat());
    links.begin_batch(None);
    (0..60).for_each(|_| links.send(0, &ground_heartbeat()));
    links.end_batch();
    links.send(0, &ground_heartbeat());
    let sent = drain(&mut links);
    links.resend_batch();
    assert_eq!(drain(&mut links), sent[1..sent.len() - 1]);
}
