//! On a shared simulated clock no fault of the network changes a flight, not by a bit.
#![allow(clippy::unwrap_used)]

mod common;

use common::{TARGET, decode, peer, positions};
use flight_model::{Setpoint, State};
use mavlink_bridge::dialect::{DialectMessage, MavCmd, Message};
use mavlink_bridge::{Encoder, Target, local_ned_setpoint, state_from_local_position, wire_round, wire_round_setpoint};
use proptest::prelude::*;
use sim_vehicle::{LockstepSettings, TelemetryRates, Vehicle, VehicleSettings};
use std::time::Duration;

const PERIOD: Duration = Duration::from_millis(500);
const TICKS: u32 = 40;

fn settings() -> VehicleSettings {
    VehicleSettings { system_id: TARGET, ground: Some(peer(14550)), ..VehicleSettings::default() }
}

fn in_lockstep(settings: VehicleSettings) -> Vehicle {
    Vehicle::in_lockstep(settings, LockstepSettings { period: PERIOD, ..LockstepSettings::default() }).unwrap()
}

/// A controller whose wishes depend on all that it hears, so that the slightest difference grows.
fn law(time: Duration, state: &State) -> Setpoint {
    Setpoint {
        speed_mps: 10.0 + 3.0 * libm::sin(state.x_m),
        course_rad: state.course_rad + libm::sin(state.y_m + time.as_secs_f64()),
        altitude_m: 50.0 + 5.0 * libm::cos(state.x_m + state.speed_mps),
    }
}

fn flown_in_memory() -> Vec<State> {
    let mut vehicle = Vehicle::new(VehicleSettings { ground: None, ..settings() }).unwrap();
    let mut track = Vec::new();
    for tick in 0..TICKS {
        let time = PERIOD * tick;
        vehicle.command(&wire_round_setpoint(&law(time, &wire_round(vehicle.state())))).unwrap();
        vehicle.advance(time + PERIOD, &mut track);
    }
    track
}

/// What happens to one datagram.
#[derive(Clone, Copy, Debug)]
enum Fate {
    Arrives,
    Lost,
    Twice,
    Late(u8),
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![
        3 => Just(Fate::Arrives),
        2 => Just(Fate::Lost),
        1 => Just(Fate::Twice),
        2 => (1..60u8).prop_map(Fate::Late),
    ]
}

/// One direction of a network: datagrams with the round in which they arrive.
#[derive(Default)]
struct Direction {
    under_way: Vec<(usize, Vec<u8>)>,
}

impl Direction {
    fn offer(&mut self, round: usize, datagram: Vec<u8>, fate: Fate) {
        match fate {
            Fate::Arrives => self.under_way.push((round, datagram)),
            Fate::Lost => {}
            Fate::Twice => self.under_way.extend([(round, datagram.clone()), (round + 1, datagram)]),
            Fate::Late(rounds) => self.under_way.push((round + usize::from(rounds), datagram)),
        }
    }

    fn arrivals(&mut self, round: usize) -> Vec<Vec<u8>> {
        let (here, later) = std::mem::take(&mut self.under_way).into_iter().partition(|(due, _)| *due <= round);
        self.under_way = later;
        let here: Vec<(usize, Vec<u8>)> = here;
        here.into_iter().map(|(_, datagram)| datagram).collect()
    }
}

fn flown_over_a_network(fates: &[Fate]) -> (Vec<State>, Vehicle) {
    let mut vehicle = in_lockstep(settings());
    let controller = peer(14550);
    let (mut down, mut up) = (Direction::default(), Direction::default());
    let mut fates = fates.iter().copied().cycle();
    let mut encoder = Encoder::new(255, 190);
    let mut answered: Option<(Duration, Setpoint)> = None;
    let mut track = Vec::new();
    let end = PERIOD * TICKS;
    let mut round = 0;
    while vehicle.time() < end {
        assert!(round < 20_000, "stuck at {:?}", vehicle.time());
        let now = Duration::from_millis(10 * round as u64);
        while let Some(transmit) = vehicle.poll_transmit() {
            assert!(transmit.datagram.len() <= 1200);
            down.offer(round, transmit.datagram, fates.next().unwrap());
        }
        for datagram in down.arrivals(round) {
            let messages = decode(&datagram);
            // A tick's datagrams end with the position at the tick.
            let Some(Message::LOCAL_POSITION_NED(position)) = messages.last() else { continue };
            let time = Duration::from_millis(u64::from(position.time_boot_ms));
            if answered.is_none_or(|(last, _)| time > last) && time.as_millis().is_multiple_of(PERIOD.as_millis()) {
                answered = Some((time, law(time, &state_from_local_position(position))));
            }
            if let Some((time, setpoint)) = answered {
                let target = Target { system_id: TARGET, component_id: 1 };
                let mut datagram = Vec::new();
                encoder.encode(&local_ned_setpoint(time, target, &setpoint), &mut datagram);
                up.offer(round, datagram, fates.next().unwrap());
            }
        }
        for datagram in up.arrivals(round) {
            vehicle.handle(now, &datagram, controller);
            if let Some(until) = vehicle.released_until() {
                vehicle.advance(until, &mut track);
            }
        }
        if vehicle.poll_timeout().is_some_and(|at| at <= now) {
            vehicle.handle_timeout(now);
        }
        round += 1;
    }
    (track, vehicle)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn loss_repetition_and_disorder_change_nothing(fates in prop::collection::vec(fate(), 1..400)) {
        // At least one datagram in each cycle of fates must get through in each direction.
        let fates: Vec<Fate> = fates.into_iter().chain([Fate::Arrives, Fate::Arrives, Fate::Arrives]).collect();
        let (track, vehicle) = flown_over_a_network(&fates);
        prop_assert_eq!(&track, &flown_in_memory());
        prop_assert_eq!(vehicle.counters().setpoints_accepted, u64::from(TICKS));
    }
}

#[test]
fn a_perfect_network_needs_no_second_asking() {
    let (track, vehicle) = flown_over_a_network(&[Fate::Arrives]);
    assert_eq!(track, flown_in_memory());
    assert_eq!(vehicle.counters().setpoints_out_of_step, 0);
}

#[test]
fn only_the_right_stamp_moves_it() {
    let mut vehicle = in_lockstep(settings());
    let mut encoder = Encoder::new(255, 190);
    let mut track = Vec::new();
    let mut offer = |vehicle: &mut Vehicle, stamp_ms: u64| {
        let target = Target { system_id: TARGET, component_id: 1 };
        let setpoint = Setpoint { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
        let mut datagram = Vec::new();
        encoder.encode(&local_ned_setpoint(Duration::from_millis(stamp_ms), target, &setpoint), &mut datagram);
        vehicle.handle(Duration::ZERO, &datagram, peer(14550));
        vehicle.advance(Duration::from_secs(100), &mut track);
        vehicle.time().as_millis() as u64
    };
    assert_eq!(offer(&mut vehicle, 500), 0);
    assert_eq!(offer(&mut vehicle, 0), 500);
    for stamp in [0, 1, 499, 501, 1_000] {
        assert_eq!(offer(&mut vehicle, stamp), 500);
    }
    assert_eq!(offer(&mut vehicle, 500), 1_000);
    assert_eq!(vehicle.counters().setpoints_out_of_step, 6);
    assert_eq!(track.len(), 100);
}

#[test]
fn it_announces_itself_and_asks_again_with_the_same_bytes() {
    let mut vehicle = in_lockstep(settings());
    let first: Vec<_> = std::iter::from_fn(|| vehicle.poll_transmit()).collect();
    assert_eq!(first.len(), 1);
    let ids: Vec<u32> = decode(&first[0].datagram).iter().map(DialectMessage::message_id).collect();
    assert_eq!(ids, [0, 32]);
    assert_eq!(vehicle.poll_timeout(), Some(Duration::from_millis(5)));
    vehicle.handle_timeout(Duration::from_millis(4));
    assert_eq!(vehicle.poll_transmit(), None);
    for now in [5, 15, 35] {
        vehicle.handle_timeout(Duration::from_millis(now));
        assert_eq!(std::iter::from_fn(|| vehicle.poll_transmit()).collect::<Vec<_>>(), first);
    }
    assert_eq!(vehicle.counters().resends, 3);
}

#[test]
fn a_tick_is_one_datagram_that_ends_with_the_position() {
    // Even if the position's own rate is off.
    for local_position_ned_hz in [10.0, 0.0] {
        let rates = TelemetryRates { local_position_ned_hz, ..TelemetryRates::default() };
        let mut vehicle = in_lockstep(VehicleSettings { rates, ..settings() });
        while vehicle.poll_transmit().is_some() {}
        let target = Target { system_id: TARGET, component_id: 1 };
        let mut datagram = Vec::new();
        Encoder::new(255, 190)
            .encode(&local_ned_setpoint(Duration::ZERO, target, &law(PERIOD, vehicle.state())), &mut datagram);
        vehicle.handle(Duration::ZERO, &datagram, peer(14550));
        vehicle.advance(PERIOD, &mut Vec::new());
        let sent: Vec<_> = std::iter::from_fn(|| vehicle.poll_transmit()).collect();
        assert_eq!(sent.len(), 1);
        let messages = decode(&sent[0].datagram);
        let heard = positions(&messages);
        assert_eq!(heard.len(), if local_position_ned_hz == 0.0 { 1 } else { 5 });
        assert_eq!(heard.last().unwrap().time_boot_ms, 500);
        assert_eq!(messages.last().unwrap().message_id(), 32);
        assert_eq!(messages.iter().filter(|message| message.message_id() == 30).count(), 5);
    }
}

#[test]
fn a_refused_setpoint_moves_the_clock_all_the_same() {
    // Otherwise one vehicle in LOITER would stop the whole flock.
    let mut vehicle = in_lockstep(settings());
    let mut encoder = Encoder::new(255, 190);
    let mut datagram = Vec::new();
    encoder.encode(&common::long(TARGET, MavCmd::MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]), &mut datagram);
    let target = Target { system_id: TARGET, component_id: 1 };
    encoder.encode(&local_ned_setpoint(Duration::ZERO, target, &law(PERIOD, vehicle.state())), &mut datagram);
    vehicle.handle(Duration::ZERO, &datagram, peer(14550));
    vehicle.advance(PERIOD, &mut Vec::new());
    assert_eq!(vehicle.time(), PERIOD);
    assert_eq!(vehicle.counters().setpoints_refused, 1);
}

#[test]
fn while_it_waits_its_clock_stands_and_commands_are_answered() {
    let mut vehicle = in_lockstep(VehicleSettings { setpoint_timeout_s: 1.0, ..settings() });
    let mut datagram = Vec::new();
    Encoder::new(255, 190)
        .encode(&common::long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [49.0, 0.0, 0.0]), &mut datagram);
    for second in 0..100 {
        vehicle.handle_timeout(Duration::from_secs(second));
        vehicle.advance(Duration::from_secs(second), &mut Vec::new());
    }
    while vehicle.poll_transmit().is_some() {}
    vehicle.handle(Duration::from_secs(100), &datagram, peer(14550));
    let answer = decode(&vehicle.poll_transmit().unwrap().datagram);
    assert_eq!(answer.iter().map(DialectMessage::message_id).collect::<Vec<_>>(), [77, 49]);
    assert_eq!((vehicle.time(), vehicle.is_in_failsafe()), (Duration::ZERO, false));
}
