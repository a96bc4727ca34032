//! The host over real sockets.
#![allow(clippy::unwrap_used)]

mod common;

use common::{decode, positions};
use flight_model::{Setpoint, State};
use mavlink_bridge::dialect::{DialectMessage, MavCmd, Message};
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{
    Encoder, ImpairmentSettings, LinkSettings, Target, UdpLink, local_ned_setpoint, state_from_local_position,
    wire_round, wire_round_setpoint,
};
use sim_vehicle::{
    Advance, Clock, Host, HostError, HostReport, HostSettings, LockstepSettings, Observer, Vehicle, VehicleSettings,
};
use std::collections::HashMap;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::sync::watch;

const PERIOD: Duration = Duration::from_millis(500);
const TICKS: u32 = 12;
const ANY_PORT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

type Tracks = Arc<Mutex<HashMap<usize, Vec<State>>>>;

/// An observer that joins the stretches and checks that none is missing.
fn recorder() -> (Tracks, Observer) {
    let tracks = Tracks::default();
    let writer = tracks.clone();
    let observer = move |advance: Advance<'_>| {
        let mut tracks = writer.lock().unwrap();
        let track = tracks.entry(advance.vehicle).or_default();
        assert_eq!(advance.start, advance.step * track.len() as u32);
        track.extend_from_slice(advance.track);
    };
    (tracks, Arc::new(observer))
}

fn fleet(count: u8, ground: Option<SocketAddr>) -> Vec<VehicleSettings> {
    (1..=count)
        .map(|system_id| {
            let start = State { y_m: 10.0 * f64::from(system_id), ..VehicleSettings::default().start };
            VehicleSettings { system_id, start, ground, ..VehicleSettings::default() }
        })
        .collect()
}

fn law(state: &State) -> Setpoint {
    Setpoint { speed_mps: 12.0, course_rad: 0.2 * libm::sin(state.y_m + state.x_m), altitude_m: 60.0 }
}

fn flown_in_memory(settings: VehicleSettings) -> Vec<State> {
    let mut vehicle = Vehicle::new(VehicleSettings { ground: None, ..settings }).unwrap();
    let mut track = Vec::new();
    for tick in 0..TICKS {
        vehicle.command(&wire_round_setpoint(&law(&wire_round(vehicle.state())))).unwrap();
        vehicle.advance(PERIOD * (tick + 1), &mut track);
    }
    track
}

/// Answers every position at a tick with the setpoint of that tick, until all vehicles have flown all ticks.
async fn control(mut link: UdpLink, vehicles: usize) {
    let mut encoder = Encoder::new(255, 190);
    let mut datagram = Vec::new();
    let mut reached: HashMap<u8, (u32, Setpoint)> = HashMap::new();
    let end_ms = (PERIOD * TICKS).as_millis() as u32;
    while reached.values().filter(|(time_ms, _)| *time_ms == end_ms).count() < vehicles {
        let from = link.recv(&mut datagram).await.unwrap();
        let mut counters = mavlink_bridge::Counters::default();
        let frame = mavlink_bridge::frames(&datagram, &mut counters).last().unwrap();
        let Ok(Message::LOCAL_POSITION_NED(position)) = frame.message() else { continue };
        let system_id = frame.header.system_id;
        let newest = reached.get(&system_id).copied();
        if newest.is_none_or(|(time_ms, _)| position.time_boot_ms > time_ms) {
            reached.insert(system_id, (position.time_boot_ms, law(&state_from_local_position(&position))));
        }
        let (time_ms, setpoint) = reached[&system_id];
        if time_ms < end_ms {
            let target = Target { system_id, component_id: 1 };
            let mut reply = Vec::new();
            encoder.encode(&local_ned_setpoint(Duration::from_millis(time_ms.into()), target, &setpoint), &mut reply);
            link.send_to(&reply, from).await;
        }
    }
}

async fn fly_in_lockstep(count: u8, vehicles_per_port: usize, link: LinkSettings) -> (Tracks, HostReport) {
    let ground = UdpLink::bind(ANY_PORT, LinkSettings::default()).unwrap();
    let lockstep = LockstepSettings { period: PERIOD, ..LockstepSettings::default() };
    let settings = HostSettings {
        base_port: 0,
        vehicles_per_port,
        clock: Clock::Lockstep(lockstep),
        link,
        ..HostSettings::default()
    };
    let host = Host::bind(&settings, fleet(count, Some(ground.local_addr().unwrap()))).unwrap();
    assert_eq!(host.addresses().len(), usize::from(count));
    let (tracks, observer) = recorder();
    let (stop, stopped) = watch::channel(false);
    let running = tokio::spawn(host.run(observer, stopped));
    tokio::time::timeout(Duration::from_secs(60), control(ground, count.into())).await.unwrap();
    stop.send(true).unwrap();
    (tracks, running.await.unwrap().unwrap())
}

#[tokio::test]
async fn lockstep_over_udp_is_the_flight_in_memory() {
    for vehicles_per_port in [1, 3, 250] {
        let (tracks, report) = fly_in_lockstep(5, vehicles_per_port, LinkSettings::default()).await;
        for (index, settings) in fleet(5, None).into_iter().enumerate() {
            assert_eq!(tracks.lock().unwrap()[&index], flown_in_memory(settings));
            assert_eq!(report.vehicles[index].setpoints_accepted, u64::from(TICKS));
        }
        assert!(report.wire.datagrams >= 5 * u64::from(TICKS) && report.wire.datagrams_sent >= 5);
        assert_eq!((report.wire.bad_checksum, report.wire.malformed_bytes), (0, 0));
    }
}

#[tokio::test]
async fn lockstep_over_a_bad_link_is_the_flight_in_memory() {
    let bad = ImpairmentSettings { loss: 0.2, duplication: 0.1, reordering: 0.1, delay_ms: 1.0, jitter_ms: 3.0 };
    let link = LinkSettings { inbound: bad, outbound: bad, seed: 3, ..LinkSettings::default() };
    let (tracks, report) = fly_in_lockstep(4, 1, link).await;
    for (index, settings) in fleet(4, None).into_iter().enumerate() {
        assert_eq!(tracks.lock().unwrap()[&index], flown_in_memory(settings));
    }
    assert!(report.wire.impairment_lost > 0);
    assert!(report.vehicles.iter().map(|counters| counters.resends).sum::<u64>() > 0);
}

#[tokio::test]
async fn vehicles_stay_at_their_starts_until_the_flight_begins() {
    let settings = HostSettings { base_port: 0, clock: Clock::WALL, ..HostSettings::default() };
    let (tracks, observer) = recorder();
    let (begin, begins) = watch::channel(false);
    let (stop, stopped) = watch::channel(false);
    let host = Host::bind(&settings, fleet(2, None)).unwrap().beginning_when(begins);
    let running = tokio::spawn(host.run(observer, stopped));
    let flown = |index: usize| tracks.lock().unwrap().get(&index).cloned().unwrap_or_default();
    let wait_for = async |is_there: &dyn Fn(&[State]) -> bool| {
        let deadline = tokio::time::Instant::now() + Duration::from_secs(20);
        while !(0..2).all(|index| is_there(&flown(index))) {
            assert!(tokio::time::Instant::now() < deadline);
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    wait_for(&|track| track.len() > 20).await;
    for (index, settings) in fleet(2, None).iter().enumerate() {
        assert!(flown(index).iter().all(|state| *state == settings.start), "with the velocity that it starts with");
    }
    begin.send_replace(true);
    wait_for(&|track| track.last().is_some_and(|last| last.x_m > 1.0)).await;
    stop.send_replace(true);
    running.await.unwrap().unwrap();
}

#[tokio::test]
async fn in_real_time_it_flies_streams_and_obeys() {
    let clock = Clock::RealTime { speed: 20.0, tick: Duration::from_millis(5) };
    let settings = HostSettings { base_port: 0, clock, ..HostSettings::default() };
    let host = Host::bind(&settings, fleet(3, None)).unwrap();
    let addresses = host.addresses().to_vec();
    let (tracks, observer) = recorder();
    let (stop, stopped) = watch::channel(false);
    let running = tokio::spawn(host.run(observer, stopped));

    let mut client = UdpLink::bind(ANY_PORT, LinkSettings::default()).unwrap();
    let mut encoder = Encoder::new(255, 190);
    let mut greeting = Vec::new();
    encoder.encode(&ground_heartbeat(), &mut greeting);
    encoder.encode(&common::long(2, MavCmd::MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]), &mut greeting);
    client.send_to(&greeting, addresses[1]).await;

    let mut received = Vec::new();
    let mut datagram = Vec::new();
    let streamed = |received: &[Message]| positions(received).iter().filter(|p| p.time_boot_ms > 0).count();
    while streamed(&received) < 20 || !received.iter().any(|message| message.message_id() == 77) {
        let from = tokio::time::timeout(Duration::from_secs(20), client.recv(&mut datagram)).await.unwrap().unwrap();
        assert_eq!(from, addresses[1], "only the vehicle that was spoken to speaks to us");
        received.extend(decode(&datagram));
    }
    stop.send(true).unwrap();
    let report = running.await.unwrap().unwrap();
    assert_eq!(report.vehicles[1].commands_accepted, 1);
    assert_eq!(report.wire.frames, 2);
    // What was said is what was flown.
    let tracks = tracks.lock().unwrap();
    for position in positions(&received) {
        let index = position.time_boot_ms as usize / 10;
        if index > 0 {
            assert_eq!(state_from_local_position(&position), wire_round(&tracks[&1][index - 1]));
        }
    }
    assert_eq!(tracks.len(), 3);
}

#[tokio::test]
async fn a_busy_port_is_named_and_nothing_stays_bound() {
    let taken = UdpSocket::bind(ANY_PORT).unwrap();
    let port = taken.local_addr().unwrap().port();
    let base_port = port - 2;
    let settings = HostSettings { base_port, ..HostSettings::default() };
    let error = Host::bind(&settings, fleet(5, None)).unwrap_err();
    // Another program may hold one of the ports before: then that one is named.
    let busy: Vec<u16> = (base_port..=port).filter(|p| error.to_string().contains(&format!(":{p}"))).collect();
    assert_eq!(busy.len(), 1, "{error}");
    assert!(error.to_string().contains("busy"), "{error}");
    for free in base_port..busy[0] {
        assert!(UdpSocket::bind((Ipv4Addr::LOCALHOST, free)).is_ok(), "{free} is still bound");
    }
}

#[tokio::test]
async fn bad_hosts_are_refused_by_name() {
    let refused = |settings: HostSettings, vehicles| Host::bind(&settings, vehicles).unwrap_err();
    let high = HostSettings { base_port: 65_534, ..HostSettings::default() };
    assert!(matches!(refused(high, fleet(3, None)), HostError::TooManyPorts { base_port: 65_534, count: 3 }));
    let grouped = HostSettings { base_port: 0, vehicles_per_port: 250, ..HostSettings::default() };
    let mut twins = fleet(3, None);
    twins[2].system_id = 1;
    let error = refused(grouped, twins);
    assert!(matches!(error, HostError::DuplicateSystemId { first: 0, second: 2, system_id: 1 }));
    let mut bad = fleet(2, None);
    bad[1].loiter_radius_m = -1.0;
    let any = HostSettings { base_port: 0, ..HostSettings::default() };
    assert_eq!(refused(any, bad).to_string(), "vehicle 2: loiter_radius_m = -1: must be a number from 1 to 10000");
}

#[tokio::test]
async fn it_stops_when_nobody_is_left_to_stop_it_and_frees_its_ports() {
    let host = Host::bind(&HostSettings { base_port: 0, ..HostSettings::default() }, fleet(2, None)).unwrap();
    let addresses = host.addresses().to_vec();
    let (stop, stopped) = watch::channel(false);
    let running = tokio::spawn(host.run(recorder().1, stopped));
    drop(stop);
    running.await.unwrap().unwrap();
    for address in addresses {
        assert!(UdpSocket::bind(address).is_ok());
    }
}
