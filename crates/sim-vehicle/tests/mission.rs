//! Missions as a client meets them: uploaded, downloaded, refused, and flown.
#![allow(clippy::panic, clippy::unwrap_used, deprecated)]

mod common;

use common::{Client, TARGET, item, peer, quiet, texts};
use flight_model::State;
use mavlink_bridge::dialect::MavCmd::*;
use mavlink_bridge::dialect::MavMissionResult::*;
use mavlink_bridge::dialect::*;
use mavlink_bridge::{Encoder, ItemKind, PlanItem, PlanItemMessage, Target, Version};
use sim_vehicle::{Mode, Personality, TelemetryRates, VehicleSettings};
use std::time::Duration;

const TO: Target = Target { system_id: TARGET, component_id: 1 };

fn waypoint(north_m: f64, east_m: f64, z_m: f32) -> PlanItem {
    item(MAV_CMD_NAV_WAYPOINT, [0.0; 4], north_m, east_m, z_m)
}

fn square() -> Vec<PlanItem> {
    let corners = [(200.0, 0.0), (200.0, 200.0), (0.0, 200.0), (0.0, 0.0)];
    std::iter::once(waypoint(0.0, 0.0, 0.0)).chain(corners.map(|(x, y)| waypoint(x, y, 60.0))).collect()
}

fn count(count: u16) -> Message {
    Message::MISSION_COUNT(MISSION_COUNT_DATA { count, target_system: TARGET, ..MISSION_COUNT_DATA::DEFAULT })
}

fn send_item(client: &mut Client, seq: u16, item: &PlanItem) -> Vec<Message> {
    let mut datagram = Vec::new();
    let message = PlanItemMessage { mission_type: 0, seq, item, is_current: false, kind: ItemKind::Int, to: TO };
    client.encoder.encode_plan_item(&message, &mut datagram);
    client.vehicle.handle(client.vehicle.time(), &datagram, client.address);
    client.collect()
}

fn result(messages: &[Message]) -> Option<MavMissionResult> {
    messages.iter().find_map(|message| match message {
        Message::MISSION_ACK(ack) => Some(ack.mavtype),
        _ => None,
    })
}

fn wanted(messages: &[Message]) -> Option<u16> {
    messages.iter().find_map(|message| match message {
        Message::MISSION_REQUEST(request) => Some(request.seq),
        Message::MISSION_REQUEST_INT(request) => Some(request.seq),
        _ => None,
    })
}

fn upload(client: &mut Client, items: &[PlanItem]) -> Option<MavMissionResult> {
    let mut answer = client.ask(&count(items.len() as u16));
    while let Some(seq) = wanted(&answer) {
        answer = send_item(client, seq, &items[usize::from(seq)]);
    }
    result(&answer)
}

fn on_board(client: &mut Client) -> Vec<MISSION_ITEM_INT_DATA> {
    let list = MISSION_REQUEST_LIST_DATA { target_system: TARGET, ..MISSION_REQUEST_LIST_DATA::DEFAULT };
    let answer = client.ask(&Message::MISSION_REQUEST_LIST(list));
    let Some(Message::MISSION_COUNT(count)) = answer.iter().find(|m| m.message_id() == 44) else { panic!() };
    (0..count.count)
        .map(|seq| {
            let request = MISSION_REQUEST_INT_DATA { seq, target_system: TARGET, ..MISSION_REQUEST_INT_DATA::DEFAULT };
            match client.ask(&Message::MISSION_REQUEST_INT(request)).pop() {
                Some(Message::MISSION_ITEM_INT(item)) => item,
                other => panic!("{other:?}"),
            }
        })
        .collect()
}

fn reached(messages: &[Message]) -> Vec<u16> {
    let seq = |message: &Message| match message {
        Message::MISSION_ITEM_REACHED(reached) => Some(reached.seq),
        _ => None,
    };
    messages.iter().filter_map(seq).collect()
}

/// The same of a PX4, which tells the last one again.
fn reached_once(heard: &[Message]) -> Vec<u16> {
    let mut told = reached(heard);
    told.dedup();
    told
}

fn nearest(track: &[State], north_m: f64, east_m: f64) -> f64 {
    let distance = |s: &State| ((s.x_m - north_m) * (s.x_m - north_m) + (s.y_m - east_m) * (s.y_m - east_m)).sqrt();
    track.iter().map(distance).fold(f64::INFINITY, f64::min)
}

fn fly_mission(items: &[PlanItem], seconds: f64) -> (Client, Vec<State>) {
    let mut client = Client::new(quiet());
    assert_eq!(upload(&mut client, items), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(client.command_long(MAV_CMD_MISSION_START, [0.0; 3]), Some(MavResult::MAV_RESULT_ACCEPTED));
    let track = client.fly(seconds);
    (client, track)
}

#[test]
fn what_is_uploaded_is_downloaded_and_home_is_home() {
    let mut client = Client::new(quiet());
    assert_eq!(on_board(&mut client).len(), 1, "home");
    let items = square();
    assert_eq!(upload(&mut client, &items), Some(MAV_MISSION_ACCEPTED));
    let read = on_board(&mut client);
    assert_eq!(read.len(), 5);
    assert_eq!((read[0].x, read[0].y, read[0].z), (399_800_000, 1_163_400_000, 50.0));
    for (read, item) in read.iter().zip(&items).skip(1) {
        assert_eq!((read.x, read.y, read.z, read.autocontinue), (item.latitude_e7, item.longitude_e7, item.z_m, 1));
    }
    // Nothing has begun, and home is never the current one.
    assert_eq!(read.iter().map(|item| item.current).collect::<Vec<_>>(), [0; 5]);
    // The old request is answered with the old item.
    let request = MISSION_REQUEST_DATA { seq: 2, target_system: TARGET, ..MISSION_REQUEST_DATA::DEFAULT };
    assert!(matches!(
        client.ask(&Message::MISSION_REQUEST(request)).as_slice(),
        [Message::MISSION_ITEM(old)] if old.seq == 2
    ));
    let clear = MISSION_CLEAR_ALL_DATA { target_system: TARGET, ..MISSION_CLEAR_ALL_DATA::DEFAULT };
    assert_eq!(result(&client.ask(&Message::MISSION_CLEAR_ALL(clear))), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(on_board(&mut client), []);
}

fn clear(client: &mut Client) -> Option<MavMissionResult> {
    let clear = MISSION_CLEAR_ALL_DATA { target_system: TARGET, ..MISSION_CLEAR_ALL_DATA::DEFAULT };
    result(&client.ask(&Message::MISSION_CLEAR_ALL(clear)))
}

#[test]
fn a_single_item_on_an_empty_board_comes_behind_home() {
    let one = [waypoint(500.0, 0.0, 80.0)];
    let mut client = Client::new(quiet());
    assert_eq!(upload(&mut client, &one), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(on_board(&mut client).len(), 1, "it takes the place of home, which stays");
    assert_eq!(clear(&mut client), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(upload(&mut client, &one), Some(MAV_MISSION_ACCEPTED));
    let read = on_board(&mut client);
    assert_eq!((read.len(), read[1].x), (2, one[0].latitude_e7));
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]);
    client.fly(1.0);
    assert_eq!(client.vehicle.mode(), Mode::Auto);
}

#[test]
fn a_mission_that_is_cleared_ends_auto_and_one_that_is_replaced_by_nothing_does_not() {
    let mut client = Client::new(quiet());
    upload(&mut client, &square());
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]);
    assert_eq!(clear(&mut client), Some(MAV_MISSION_ERROR), "it is flown");
    assert_eq!(result(&client.ask(&count(0))), Some(MAV_MISSION_ACCEPTED));
    client.fly(5.0);
    assert_eq!(client.vehicle.mode(), Mode::Auto, "it flies on where it was led");
    let mut client = Client::new(VehicleSettings { on_ground: true, ..quiet() });
    upload(&mut client, &square());
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]);
    assert_eq!(clear(&mut client), Some(MAV_MISSION_ACCEPTED), "it is disarmed");
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
}

#[test]
fn a_part_is_replaced_and_the_rest_stays() {
    let mut client = Client::new(quiet());
    upload(&mut client, &square());
    let partial = |start_index, end_index| {
        Message::MISSION_WRITE_PARTIAL_LIST(MISSION_WRITE_PARTIAL_LIST_DATA {
            start_index,
            end_index,
            target_system: TARGET,
            ..MISSION_WRITE_PARTIAL_LIST_DATA::DEFAULT
        })
    };
    assert_eq!(wanted(&client.ask(&partial(2, 3))), Some(2));
    assert_eq!(wanted(&send_item(&mut client, 2, &waypoint(1.0, 1.0, 70.0))), Some(3));
    assert_eq!(result(&send_item(&mut client, 3, &waypoint(2.0, 2.0, 71.0))), Some(MAV_MISSION_ACCEPTED));
    let altitudes: Vec<f32> = on_board(&mut client).iter().map(|item| item.z).collect();
    assert_eq!(altitudes, [50.0, 60.0, 70.0, 71.0, 60.0]);
    for (first, last) in [(-1, 2), (3, 2), (2, 6), (6, 6)] {
        assert_eq!(result(&client.ask(&partial(first, last))), Some(MAV_MISSION_ERROR));
    }
}

#[test]
fn what_is_wrong_is_refused_by_its_code_and_nothing_is_half_applied() {
    let mut client = Client::new(quiet());
    upload(&mut client, &square());
    let before = on_board(&mut client);
    let good = waypoint(1.0, 1.0, 10.0);
    for (bad, code) in [
        (PlanItem { params: [f32::NAN; 4], ..good }, MAV_MISSION_INVALID_PARAM1),
        (PlanItem { frame: 1, ..good }, MAV_MISSION_UNSUPPORTED_FRAME),
        (PlanItem { frame: 200, ..good }, MAV_MISSION_UNSUPPORTED_FRAME),
        (PlanItem { command: 60_000, ..good }, MAV_MISSION_UNSUPPORTED),
        (PlanItem { z_m: f32::NAN, ..good }, MAV_MISSION_INVALID_PARAM7),
        (PlanItem { latitude_e7: i32::MAX, ..good }, MAV_MISSION_INVALID_PARAM5_X),
    ] {
        client.ask(&count(3));
        send_item(&mut client, 0, &good);
        let answer = send_item(&mut client, 1, &bad);
        assert_eq!(result(&answer), Some(code));
        assert!(texts(&answer)[0].starts_with("Mission refused: "));
        assert_eq!(result(&send_item(&mut client, 2, &good)), Some(MAV_MISSION_ERROR), "it is over");
        assert_eq!(on_board(&mut client), before);
    }
    assert_eq!(result(&client.ask(&count(1313))), Some(MAV_MISSION_NO_SPACE));
    client.ask(&count(3));
    assert_eq!(result(&send_item(&mut client, 2, &good)), Some(MAV_MISSION_INVALID_SEQUENCE));
    assert_eq!(on_board(&mut client), before);
}

#[test]
fn a_second_writer_is_denied() {
    let mut client = Client::new(quiet());
    client.ask(&count(2));
    client.address = peer(50_000);
    assert_eq!(result(&client.ask(&count(2))), Some(MAV_MISSION_DENIED));
    assert_eq!(result(&send_item(&mut client, 0, &waypoint(0.0, 0.0, 9.0))), Some(MAV_MISSION_DENIED));
    client.address = peer(40_000);
    send_item(&mut client, 0, &waypoint(0.0, 0.0, 9.0));
    assert_eq!(result(&send_item(&mut client, 1, &waypoint(0.0, 0.0, 9.0))), Some(MAV_MISSION_ACCEPTED));
}

#[test]
fn what_is_lost_is_asked_for_again_and_in_the_end_given_up() {
    let mut client = Client::new(quiet());
    client.ask(&count(2));
    let mut asked = 0;
    let mut outcome = None;
    while let Some(due) = client.vehicle.poll_timeout() {
        client.vehicle.handle_timeout(due);
        let answer = client.collect();
        asked += usize::from(wanted(&answer) == Some(0));
        outcome = outcome.or(result(&answer));
    }
    assert!(asked >= 15, "{asked}");
    assert_eq!(outcome, Some(MAV_MISSION_OPERATION_CANCELLED));
    // A repeat of an item changes nothing, and a lost acknowledgement is given again.
    let items = square();
    assert_eq!(upload(&mut client, &items), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(result(&send_item(&mut client, 4, &items[4])), Some(MAV_MISSION_ACCEPTED));
    client.ask(&count(5));
    send_item(&mut client, 0, &items[0]);
    send_item(&mut client, 1, &items[1]);
    assert_eq!(send_item(&mut client, 1, &items[1]), []);
    assert_eq!(wanted(&send_item(&mut client, 2, &items[2])), Some(3));
}

#[test]
fn a_client_of_the_first_version_uploads_too() {
    let mut client = Client::new(quiet());
    client.encoder = Encoder::new(255, 190).with_version(Version::V1);
    let answer = client.ask(&count(1));
    assert!(answer.iter().any(|message| matches!(message, Message::MISSION_REQUEST(request) if request.seq == 0)));
    assert_eq!(result(&send_item(&mut client, 0, &waypoint(0.0, 0.0, 0.0))), Some(MAV_MISSION_ACCEPTED));
}

#[test]
fn every_waypoint_is_reached_in_order_and_then_it_returns() {
    let (mut client, track) = fly_mission(&square(), 140.0);
    let received = client.collect();
    assert_eq!(reached(&received), [1, 2, 3, 4]);
    for (north_m, east_m) in [(200.0, 0.0), (200.0, 200.0), (0.0, 200.0), (0.0, 0.0)] {
        assert!(nearest(&track, north_m, east_m) <= 15.0);
    }
    let said = texts(&received);
    assert_eq!(said[..2], ["Mission: 1 WP", "Reached waypoint #1 dist 0m"]);
    assert_eq!(said[8..], ["Mission complete, changing mode to RTL"]);
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
    assert!((track.last().unwrap().altitude_m - 60.0).abs() < 0.1);
}

#[test]
fn a_waypoint_behind_or_beside_is_reached_within_a_small_radius() {
    for (north_m, east_m) in [(-3.0, 0.0), (0.0, 4.0), (2.0, -6.0), (-8.0, 8.0), (-60.0, 1.0), (0.0, 0.0)] {
        let near = item(MAV_CMD_NAV_WAYPOINT, [0.0, 1.0, 0.0, 0.0], north_m, east_m, 50.0);
        let (mut client, track) = fly_mission(&[near, near], 60.0);
        assert_eq!(reached(&client.collect()), [1], "{north_m}, {east_m}");
        assert!(nearest(&track, north_m, east_m) <= 1.05);
    }
}

#[test]
fn every_command_is_flown() {
    let items = [
        waypoint(0.0, 0.0, 0.0),
        item(MAV_CMD_NAV_TAKEOFF, [0.0; 4], 0.0, 0.0, 70.0),
        item(MAV_CMD_DO_CHANGE_SPEED, [0.0, 12.0, -1.0, 0.0], 0.0, 0.0, 0.0),
        waypoint(300.0, 0.0, 70.0),
        item(MAV_CMD_DO_JUMP, [3.0, 2.0, 0.0, 0.0], 0.0, 0.0, 0.0),
        item(MAV_CMD_NAV_LOITER_TURNS, [2.0, 0.0, 40.0, 0.0], 300.0, 100.0, 70.0),
        item(MAV_CMD_NAV_LOITER_TIME, [20.0, 0.0, -30.0, 0.0], 300.0, 200.0, 70.0),
        item(MAV_CMD_NAV_LOITER_UNLIM, [0.0; 4], 0.0, 0.0, 70.0),
    ];
    let (mut client, track) = fly_mission(&items, 300.0);
    // The waypoint again and again, as it is where the vehicle is.
    assert_eq!(reached(&client.collect()), [1, 2, 3, 3, 3, 5, 6]);
    let end = track.last().unwrap();
    assert!((end.speed_mps - 12.0).abs() < 1e-6 && (end.altitude_m - 70.0).abs() < 1e-3);
    assert!(((end.x_m * end.x_m + end.y_m * end.y_m).sqrt() - 60.0).abs() < 0.1);
    assert_eq!(client.vehicle.mode(), Mode::Auto);
    let current = client.ask(&common::long(TARGET, MAV_CMD_REQUEST_MESSAGE, [42.0, 0.0, 0.0]));
    assert!(current.iter().any(|message| matches!(message, Message::MISSION_CURRENT(current)
        if (current.seq, current.total) == (7, 7) && current.mission_state == MissionState::MISSION_STATE_ACTIVE)));
}

#[test]
fn jumps_without_end_end_the_mission() {
    let jump = item(MAV_CMD_DO_JUMP, [1.0, -1.0, 0.0, 0.0], 0.0, 0.0, 0.0);
    let (mut client, track) = fly_mission(&[jump, jump], 5.0);
    assert_eq!((client.vehicle.mode(), track.len()), (Mode::Rtl, 500));
    assert!(texts(&client.collect()).contains(&"Mission goes round in a circle, changing mode to RTL".to_owned()));
}

#[test]
fn the_current_item_is_set_and_auto_goes_on_from_it() {
    let mut client = Client::new(quiet());
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]), Some(MavResult::MAV_RESULT_ACCEPTED));
    assert_eq!(client.vehicle.mode(), Mode::Rtl, "there is no mission yet");
    upload(&mut client, &square());
    assert_eq!(
        client.command_long(MAV_CMD_DO_SET_MISSION_CURRENT, [5.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_DENIED)
    );
    let set = |seq| MISSION_SET_CURRENT_DATA { seq, target_system: TARGET, target_component: 1 };
    let answer = client.ask(&Message::MISSION_SET_CURRENT(set(9)));
    // Told of another item, MAVSDK would ask again at once.
    assert!(answer.len() == 1 && texts(&answer) == ["Mission: no item 9"]);
    let answer = client.ask(&Message::MISSION_SET_CURRENT(set(3)));
    assert!(matches!(answer.as_slice(), [Message::MISSION_CURRENT(current)] if current.seq == 3));
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]), Some(MavResult::MAV_RESULT_ACCEPTED));
    client.fly(5.0);
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 15.0, 0.0]), Some(MavResult::MAV_RESULT_ACCEPTED));
    client.fly(5.0);
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]), Some(MavResult::MAV_RESULT_ACCEPTED));
    client.fly(100.0);
    assert_eq!(reached(&client.collect()), [3, 4]);
    let clear = MISSION_CLEAR_ALL_DATA { target_system: TARGET, ..MISSION_CLEAR_ALL_DATA::DEFAULT };
    client.command_long(MAV_CMD_MISSION_START, [0.0; 3]);
    assert_eq!(client.vehicle.mode(), Mode::Auto);
    assert_eq!(result(&client.ask(&Message::MISSION_CLEAR_ALL(clear))), Some(MAV_MISSION_ERROR), "it is flown");
    assert_eq!((client.vehicle.mode(), on_board(&mut client).len()), (Mode::Auto, 5));
    assert_eq!(result(&client.ask(&count(0))), Some(MAV_MISSION_ACCEPTED));
    client.fly(5.0);
    assert_eq!(client.vehicle.mode(), Mode::Auto, "it flies on where it was led");
    client.vehicle.handle_timeout(Duration::from_secs(1));
}

/// A flight of a personality along items, from the ground or in the air.
fn fly_as(personality: Personality, on_ground: bool, items: &[PlanItem], seconds: f64) -> (Client, Vec<Message>) {
    let rates = TelemetryRates { sys_status_hz: 10.0, ..TelemetryRates::OFF };
    let mut client = Client::new(VehicleSettings { personality, on_ground, rates, ..quiet() });
    assert_eq!(upload(&mut client, items), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(
        client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_ACCEPTED)
    );
    assert_eq!(client.command_long(MAV_CMD_MISSION_START, [0.0; 3]), Some(MavResult::MAV_RESULT_ACCEPTED));
    client.fly(seconds);
    let heard = client.collect();
    (client, heard)
}

/// It is asked for; a PX4 tells it unasked and on no request.
fn mission_state(client: &mut Client) -> (u16, MissionState) {
    let answer = client.ask(&common::long(TARGET, MAV_CMD_REQUEST_MESSAGE, [42.0, 0.0, 0.0]));
    let state = |message: &Message| match message {
        Message::MISSION_CURRENT(current) => Some((current.seq, current.mission_state)),
        _ => None,
    };
    answer.iter().find_map(state).unwrap_or_else(|| {
        client.collect();
        client.fly(0.2);
        client.collect().iter().rev().find_map(state).unwrap()
    })
}

#[test]
fn a_return_at_the_end_is_reached_and_ends_the_mission() {
    let there = item(MAV_CMD_NAV_WAYPOINT, [0.0, 20.0, 0.0, 0.0], 300.0, 0.0, 60.0);
    // A PX4 takes no place with it.
    let back = item(MAV_CMD_NAV_RETURN_TO_LAUNCH, [0.0; 4], 0.0, 0.0, 0.0);
    let back = PlanItem { frame: 2, latitude_e7: 0, longitude_e7: 0, ..back };
    let (mut client, heard) = fly_as(Personality::Px4, false, &[there, back], 40.0);
    assert_eq!(reached_once(&heard), [0, 1]);
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
    assert_eq!(mission_state(&mut client), (1, MissionState::MISSION_STATE_COMPLETE));
    // To an ArduPlane it stays the current item.
    let (mut client, heard) = fly_as(Personality::ArduPlane, false, &[there, there, back], 40.0);
    assert_eq!((reached(&heard), client.vehicle.mode()), (vec![1], Mode::Rtl));
    assert_eq!(mission_state(&mut client), (2, MissionState::MISSION_STATE_NOT_STARTED));
}

#[test]
fn a_px4_takes_off_for_a_mission_without_a_take_off() {
    let there = item(MAV_CMD_NAV_WAYPOINT, [0.0, 20.0, 0.0, 0.0], 300.0, 0.0, 60.0);
    for personality in [Personality::Px4, Personality::Generic] {
        let (client, heard) = fly_as(personality, true, &[there], 90.0);
        assert_eq!(reached_once(&heard), [0]);
        assert!((client.vehicle.state().altitude_m - 60.0).abs() < 1.0);
    }
    let (client, _) = fly_as(Personality::ArduPlane, true, &[there, there], 60.0);
    assert_eq!(client.vehicle.state().altitude_m, 0.0, "ArduPlane waits for a take-off");
}

#[test]
fn a_mission_that_is_left_has_not_started_and_a_px4_lets_it_be_cleared() {
    let there = item(MAV_CMD_NAV_WAYPOINT, [0.0, 20.0, 0.0, 0.0], 900.0, 0.0, 60.0);
    let (mut client, _) = fly_as(Personality::Px4, false, &[there, there], 5.0);
    assert_eq!(mission_state(&mut client), (0, MissionState::MISSION_STATE_ACTIVE));
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 4.0, 3.0]);
    // It has reached nothing yet.
    assert_eq!(mission_state(&mut client), (0, MissionState::MISSION_STATE_NOT_STARTED));
    client.command_long(MAV_CMD_MISSION_START, [0.0; 3]);
    let clear = MISSION_CLEAR_ALL_DATA { target_system: TARGET, ..MISSION_CLEAR_ALL_DATA::DEFAULT };
    assert_eq!(result(&client.ask(&Message::MISSION_CLEAR_ALL(clear))), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
}

#[test]
fn legs_are_flown_along_their_lines() {
    let corners = [(400.0, 0.0), (400.0, 400.0), (0.0, 400.0), (0.0, 0.0)];
    let corner = |(north, east)| item(MAV_CMD_NAV_WAYPOINT, [0.0, 10.0, 0.0, 0.0], north, east, 50.0);
    let items: Vec<PlanItem> = [(0.0, 0.0)].iter().chain(&corners).copied().map(corner).collect();
    let parameters = vec![("SIM_WIND_SPD".to_owned(), 6.0), ("SIM_WIND_DIR".to_owned(), 45.0)];
    let mut client = Client::new(VehicleSettings { default_parameters: parameters, ..quiet() });
    assert_eq!(upload(&mut client, &items), Some(MAV_MISSION_ACCEPTED));
    client.command_long(MAV_CMD_MISSION_START, [0.0; 3]);
    let track = client.fly(300.0);
    // In the second half of the second leg, from (400, 0) to (400, 400): the turn onto it is made up for.
    let second = track.iter().filter(|state| state.y_m > 150.0 && state.y_m < 390.0 && state.x_m > 300.0);
    let off_m = second.map(|state| (state.x_m - 400.0).abs()).fold(0.0, f64::max);
    assert!(off_m < 2.0, "{off_m}");
    assert_eq!(reached(&client.collect()), [1, 2, 3, 4]);
}

#[test]
fn do_jump_tag_chooses_the_item_of_that_number() {
    let tag = item(MAV_CMD_JUMP_TAG, [7.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0);
    let mut client = Client::new(quiet());
    upload(&mut client, &[square()[0], square()[1], tag, square()[2]]);
    assert_eq!(client.command_long(MAV_CMD_DO_JUMP_TAG, [7.0, 0.0, 0.0]), Some(MavResult::MAV_RESULT_ACCEPTED));
    // A tag is nowhere: as from an ArduPlane, the item behind it is told.
    assert_eq!(mission_state(&mut client).0, 3);
    assert_eq!(client.command_long(MAV_CMD_DO_JUMP_TAG, [8.0, 0.0, 0.0]), Some(MavResult::MAV_RESULT_FAILED));
}

#[test]
fn the_last_index_there_is_is_no_item() {
    let mut client = Client::new(quiet());
    assert_eq!(upload(&mut client, &square()), Some(MAV_MISSION_ACCEPTED));
    assert_eq!(result(&send_item(&mut client, u16::MAX, &square()[0])), Some(MAV_MISSION_ERROR));
}
