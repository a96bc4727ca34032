//! Fences and rally points as a client meets them: uploaded, downloaded, refused, kept, and obeyed.
#![allow(clippy::panic, clippy::unwrap_used, deprecated)]

mod common;

use common::{Client, TARGET, peer, quiet, texts};
use mavlink_bridge::dialect::MavCmd::*;
use mavlink_bridge::dialect::MavMissionResult::*;
use mavlink_bridge::dialect::*;
use mavlink_bridge::{ItemKind, PlanItem, PlanItemMessage, Target};
use proptest::prelude::*;
use sim_vehicle::{Mode, Personality, Plans, Vehicle, VehicleSettings};

const TO: Target = Target { system_id: TARGET, component_id: 1 };
const FENCE: MavMissionType = MavMissionType::MAV_MISSION_TYPE_FENCE;
const RALLY: MavMissionType = MavMissionType::MAV_MISSION_TYPE_RALLY;
const ACCEPTED: Option<MavResult> = Some(MavResult::MAV_RESULT_ACCEPTED);
const FAILED: Option<MavResult> = Some(MavResult::MAV_RESULT_FAILED);

fn item(command: MavCmd, p1: f32, north_m: f64, east_m: f64, z_m: f32) -> PlanItem {
    common::item(command, [p1, 0.0, 0.0, 0.0], north_m, east_m, z_m)
}

/// A square round home, of so many metres each way.
fn square(half_m: f64) -> Vec<PlanItem> {
    let corners = [(-half_m, -half_m), (-half_m, half_m), (half_m, half_m), (half_m, -half_m)];
    corners.map(|(x, y)| item(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 4.0, x, y, 0.0)).to_vec()
}

fn count(mission_type: MavMissionType, count: u16) -> Message {
    Message::MISSION_COUNT(MISSION_COUNT_DATA {
        count,
        mission_type,
        target_system: TARGET,
        ..MISSION_COUNT_DATA::DEFAULT
    })
}

fn send_item(client: &mut Client, mission_type: MavMissionType, seq: u16, item: &PlanItem) -> Vec<Message> {
    let mission_type = mission_type as u8;
    let message = PlanItemMessage { mission_type, seq, item, is_current: false, kind: ItemKind::Int, to: TO };
    let mut datagram = Vec::new();
    client.encoder.encode_plan_item(&message, &mut datagram);
    client.vehicle.handle(client.vehicle.time(), &datagram, client.address);
    client.collect()
}

fn result(messages: &[Message]) -> Option<(MavMissionType, MavMissionResult)> {
    messages.iter().find_map(|message| match message {
        Message::MISSION_ACK(ack) => Some((ack.mission_type, ack.mavtype)),
        _ => None,
    })
}

fn upload(client: &mut Client, kind: MavMissionType, items: &[PlanItem]) -> MavMissionResult {
    let mut answer = client.ask(&count(kind, items.len() as u16));
    for (seq, item) in items.iter().enumerate() {
        answer = send_item(client, kind, seq as u16, item);
    }
    let (answered, result) = result(&answer).unwrap();
    assert_eq!(answered, kind);
    result
}

fn on_board(client: &mut Client, mission_type: MavMissionType) -> Vec<MISSION_ITEM_INT_DATA> {
    let list = MISSION_REQUEST_LIST_DATA { target_system: TARGET, mission_type, ..MISSION_REQUEST_LIST_DATA::DEFAULT };
    let answer = client.ask(&Message::MISSION_REQUEST_LIST(list));
    // A vehicle says first who it is to whom it does not know.
    let Some(Message::MISSION_COUNT(count)) = answer.last() else { panic!("{answer:?}") };
    let read = |seq| {
        let request =
            MISSION_REQUEST_INT_DATA { seq, target_system: TARGET, mission_type, ..MISSION_REQUEST_INT_DATA::DEFAULT };
        match client.ask(&Message::MISSION_REQUEST_INT(request)).as_slice() {
            [Message::MISSION_ITEM_INT(item)] if item.mission_type == mission_type => item.clone(),
            other => panic!("{other:?}"),
        }
    };
    (0..count.count).map(read).collect()
}

fn set(client: &mut Client, name: &str, value: f32) {
    let data = PARAM_SET_DATA {
        param_value: value,
        target_system: TARGET,
        param_id: name.into(),
        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        ..PARAM_SET_DATA::DEFAULT
    };
    let answer = client.ask(&Message::PARAM_SET(data));
    assert!(matches!(answer.as_slice(), [Message::PARAM_VALUE(read)] if read.param_value == value), "{answer:?}");
}

fn set_mode(client: &mut Client, mode: Mode) -> Option<MavResult> {
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, mode.number() as f32, 0.0])
}

#[test]
fn the_three_plans_do_not_touch_each_other() {
    let mut client = Client::new(quiet());
    let points =
        [item(MAV_CMD_NAV_RALLY_POINT, 0.0, 50.0, 60.0, 70.0), item(MAV_CMD_NAV_RALLY_POINT, 0.0, 1.0, 2.0, 3.0)];
    // Two uploads at once, by two writers, of two plans.
    client.ask(&count(FENCE, 4));
    client.address = peer(50_000);
    assert_eq!(upload(&mut client, RALLY, &points), MAV_MISSION_ACCEPTED);
    assert_eq!(result(&client.ask(&count(FENCE, 4))), Some((FENCE, MAV_MISSION_DENIED)));
    client.address = peer(40_000);
    let corners = square(200.0);
    let answers: Vec<_> =
        corners.iter().zip(0..).map(|(corner, seq)| send_item(&mut client, FENCE, seq, corner)).collect();
    assert_eq!(result(answers.last().unwrap()), Some((FENCE, MAV_MISSION_ACCEPTED)));
    let fence = on_board(&mut client, FENCE);
    assert_eq!(
        fence.iter().map(|item| (item.x, item.y)).collect::<Vec<_>>(),
        corners.iter().map(|item| (item.latitude_e7, item.longitude_e7)).collect::<Vec<_>>()
    );
    assert!(fence.iter().all(|item| item.param1 == 4.0));
    assert_eq!(on_board(&mut client, RALLY).iter().map(|item| item.z).collect::<Vec<_>>(), [70.0, 3.0]);
    assert_eq!(on_board(&mut client, MavMissionType::MAV_MISSION_TYPE_MISSION).len(), 1, "home");

    let clear = |mission_type| {
        Message::MISSION_CLEAR_ALL(MISSION_CLEAR_ALL_DATA {
            target_system: TARGET,
            mission_type,
            ..MISSION_CLEAR_ALL_DATA::DEFAULT
        })
    };
    assert_eq!(result(&client.ask(&clear(RALLY))), Some((RALLY, MAV_MISSION_ACCEPTED)));
    assert_eq!((on_board(&mut client, RALLY).len(), on_board(&mut client, FENCE).len()), (0, 4));
    let all = MavMissionType::MAV_MISSION_TYPE_ALL;
    assert_eq!(result(&client.ask(&clear(all))), Some((all, MAV_MISSION_ACCEPTED)));
    assert_eq!(on_board(&mut client, FENCE), []);
}

#[test]
fn a_fence_that_makes_no_sense_is_refused_in_the_end_and_the_old_one_stays() {
    let mut client = Client::new(quiet());
    let old = square(200.0);
    assert_eq!(upload(&mut client, FENCE, &old), MAV_MISSION_ACCEPTED);
    let two = [old[0], old[1]];
    assert_eq!(upload(&mut client, FENCE, &two), MAV_MISSION_ERROR);
    assert_eq!(
        upload(&mut client, FENCE, &[item(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, -5.0, 0.0, 0.0, 0.0)]),
        MAV_MISSION_ERROR
    );
    let nan = item(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, f32::NAN, 0.0, 0.0, 0.0);
    assert_eq!(upload(&mut client, FENCE, &[nan]), MAV_MISSION_INVALID_PARAM1);
    let waypoint = item(MAV_CMD_NAV_WAYPOINT, 0.0, 0.0, 0.0, 50.0);
    assert_eq!(upload(&mut client, FENCE, &[waypoint]), MAV_MISSION_UNSUPPORTED);
    assert_eq!(upload(&mut client, RALLY, &[waypoint]), MAV_MISSION_UNSUPPORTED);
    let answer = client.ask(&count(FENCE, 256));
    assert_eq!(result(&answer), Some((FENCE, MAV_MISSION_NO_SPACE)));
    assert_eq!(texts(&answer), ["Only 84 items are supported"]);
    assert_eq!(on_board(&mut client, FENCE).len(), 4);
    // A part that breaks the whole.
    let partial = MISSION_WRITE_PARTIAL_LIST_DATA {
        start_index: 1,
        end_index: 1,
        target_system: TARGET,
        mission_type: FENCE,
        ..MISSION_WRITE_PARTIAL_LIST_DATA::DEFAULT
    };
    client.ask(&Message::MISSION_WRITE_PARTIAL_LIST(partial));
    let answer =
        send_item(&mut client, FENCE, 1, &item(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 5.0, 0.0, 0.0, 0.0));
    assert_eq!(result(&answer), Some((FENCE, MAV_MISSION_ERROR)));
    assert_eq!(texts(&answer), ["Unexpected vertex count want=4 got=5"]);
    assert!(on_board(&mut client, FENCE).iter().all(|item| item.param1 == 4.0));
}

#[test]
fn who_uploads_may_begin_anew_with_another_count_or_break_off() {
    let mut client = Client::new(VehicleSettings { personality: Personality::Generic, ..quiet() });
    client.ask(&count(FENCE, 9));
    send_item(&mut client, FENCE, 0, &square(100.0)[0]);
    assert_eq!(upload(&mut client, FENCE, &square(200.0)), MAV_MISSION_ACCEPTED);
    client.ask(&count(FENCE, 9));
    let ack = MISSION_ACK_DATA {
        target_system: TARGET,
        mavtype: MAV_MISSION_OPERATION_CANCELLED,
        mission_type: FENCE,
        ..MISSION_ACK_DATA::DEFAULT
    };
    // Not answered: who begins anew would take it for an answer to that.
    assert_eq!(client.ask(&Message::MISSION_ACK(ack.clone())), []);
    assert_eq!(client.ask(&Message::MISSION_ACK(ack.clone())), []);
    assert_eq!(client.vehicle.poll_timeout(), None);
    client.address = peer(50_000);
    assert_eq!(upload(&mut client, FENCE, &[]), MAV_MISSION_ACCEPTED);
    assert_eq!(on_board(&mut client, FENCE), []);

    // An ArduPlane passes it over: the upload goes on, and nobody else has his turn.
    let mut client = Client::new(quiet());
    client.ask(&count(FENCE, 9));
    assert_eq!(client.ask(&Message::MISSION_ACK(ack)), []);
    assert!(client.vehicle.poll_timeout().is_some());
    client.address = peer(50_000);
    assert_eq!(result(&client.ask(&count(FENCE, 4))), Some((FENCE, MAV_MISSION_DENIED)));
}

#[test]
fn plans_of_an_unknown_type_are_refused_by_it_and_nothing_is_cleared() {
    let mut client = Client::new(quiet());
    assert_eq!(upload(&mut client, FENCE, &square(200.0)), MAV_MISSION_ACCEPTED);
    const CLEAR_ALL: u32 = 45;
    let payload = [TARGET, 1, 200];
    let datagram = common::by_hand(CLEAR_ALL as u8, 232, &payload);
    client.vehicle.handle(client.vehicle.time(), &datagram, client.address);
    let sent = client.vehicle.poll_transmit().unwrap().datagram;
    let mut counters = mavlink_bridge::Counters::default();
    let ack = mavlink_bridge::frames(&sent, &mut counters).find(|frame| frame.header.message_id == 47).unwrap();
    assert_eq!(ack.payload(), [255, 190, MAV_MISSION_UNSUPPORTED as u8, 200]);
    client.collect();
    assert_eq!(on_board(&mut client, FENCE).len(), 4);
}

#[test]
fn a_breach_is_told_acted_upon_and_cleared() {
    let mut client = Client::new(quiet());
    assert_eq!(upload(&mut client, FENCE, &square(100.0)), MAV_MISSION_ACCEPTED);
    set(&mut client, "FENCE_ENABLE", 1.0);
    client.fly(9.0);
    assert_eq!((client.vehicle.mode(), texts(&client.collect())), (Mode::Guided, vec![]));
    client.fly(1.1);
    let received = client.collect();
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
    assert_eq!(texts(&received), ["Polygon fence breached", "Manual recovery started"]);
    assert!(received.iter().any(|message| matches!(message, Message::FENCE_STATUS(status)
        if (status.breach_status, status.breach_count) == (1, 1) && status.breach_time > 9_000
            && status.breach_type == FenceBreach::FENCE_BREACH_BOUNDARY)));
    assert_eq!(set_mode(&mut client, Mode::Guided), FAILED);
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
    client.fly(60.0);
    assert_eq!(texts(&client.collect()), ["Fence breach cleared"]);
    assert_eq!(set_mode(&mut client, Mode::Guided), ACCEPTED);
    client.fly(5.0);
    assert_eq!((client.vehicle.mode(), texts(&client.collect())), (Mode::Guided, vec![]));
}

/// A vehicle on its way out of a fence with a return point, in CRUISE.
fn leaving(action: f32) -> Client {
    let mut client = Client::new(quiet());
    let mut items = square(100.0);
    items.push(item(MAV_CMD_NAV_FENCE_RETURN_POINT, 0.0, -20.0, 30.0, 0.0));
    assert_eq!(upload(&mut client, FENCE, &items), MAV_MISSION_ACCEPTED);
    set(&mut client, "FENCE_ACTION", action);
    set(&mut client, "FENCE_ENABLE", 1.0);
    set_mode(&mut client, Mode::Cruise);
    client
}

#[test]
fn a_breach_may_only_be_told() {
    let mut client = leaving(0.0);
    client.fly(150.0);
    assert_eq!(client.vehicle.mode(), Mode::Cruise);
    assert_eq!(texts(&client.collect()), ["Polygon fence breached"]);
}

#[test]
fn a_breach_may_lead_to_the_return_point_until_the_fence_is_off() {
    let mut client = leaving(6.0);
    let state = *client.fly(150.0).last().unwrap();
    assert_eq!(client.vehicle.mode(), Mode::Guided);
    let (north, east) = (state.x_m + 20.0, state.y_m - 30.0);
    assert!(((north * north + east * east).sqrt() - 60.0).abs() < 0.5);
    // Half way between FENCE_ALT_MIN and FENCE_ALT_MAX.
    assert!((state.altitude_m - 45.0).abs() < 0.1);
    assert_eq!(client.command_long(MAV_CMD_DO_FENCE_ENABLE, [0.0; 3]), ACCEPTED);
    client.fly(0.1);
    assert_eq!(client.vehicle.mode(), Mode::Cruise);
}

#[test]
fn rtl_goes_to_the_nearest_rally_point() {
    let mut client = Client::new(quiet());
    let points =
        [item(MAV_CMD_NAV_RALLY_POINT, 0.0, -900.0, 0.0, 70.0), item(MAV_CMD_NAV_RALLY_POINT, 0.0, 300.0, 400.0, 80.0)];
    assert_eq!(upload(&mut client, RALLY, &points), MAV_MISSION_ACCEPTED);
    assert_eq!(set_mode(&mut client, Mode::Rtl), ACCEPTED);
    let state = *client.fly(200.0).last().unwrap();
    let (north, east) = (state.x_m - 300.0, state.y_m - 400.0);
    assert!(((north * north + east * east).sqrt() - 60.0).abs() < 0.5 && (state.altitude_m - 80.0).abs() < 0.1);
}

#[test]
fn outside_its_fence_it_does_not_arm() {
    let mut client = Client::new(VehicleSettings { armed: false, ..quiet() });
    let far = item(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 50.0, 500.0, 0.0, 0.0);
    assert_eq!(upload(&mut client, FENCE, &[far]), MAV_MISSION_ACCEPTED);
    set(&mut client, "FENCE_ENABLE", 1.0);
    client.fly(1.0);
    let arm = common::long(TARGET, MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
    let refused = client.ask(&arm);
    assert_eq!(common::acknowledgement(&refused).unwrap().result, MavResult::MAV_RESULT_FAILED);
    assert_eq!(texts(&refused), ["PreArm: Vehicle breaching Polygon fence", "Arm: Vehicle breaching Polygon fence"]);
    set(&mut client, "FENCE_ENABLE", 0.0);
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), ACCEPTED);
}

#[test]
fn the_fence_may_be_enabled_by_arming_and_by_a_command() {
    let mut client = Client::new(VehicleSettings { armed: false, ..quiet() });
    assert_eq!(client.command_long(MAV_CMD_DO_FENCE_ENABLE, [1.0, 0.0, 0.0]), FAILED, "there is none");
    upload(&mut client, FENCE, &square(100.0));
    assert_eq!(client.command_long(MAV_CMD_DO_FENCE_ENABLE, [1.0, 0.0, 0.0]), ACCEPTED);
    assert_eq!(client.command_long(MAV_CMD_DO_FENCE_ENABLE, [0.0, 0.0, 0.0]), ACCEPTED);
    assert_eq!(client.command_long(MAV_CMD_DO_FENCE_ENABLE, [3.0, 0.0, 0.0]), FAILED);
    set(&mut client, "FENCE_AUTOENABLE", 3.0);
    let answer = client.ask(&common::long(TARGET, MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]));
    assert!(texts(&answer).contains(&"Polygon fence auto-enabled".to_owned()));
    client.fly(12.0);
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
}

#[test]
fn the_fence_may_be_enabled_by_a_take_off_and_the_floor_is_reached_from_below() {
    let mut client = Client::new(VehicleSettings { on_ground: true, ..quiet() });
    upload(&mut client, FENCE, &square(2000.0));
    set(&mut client, "FENCE_TYPE", 12.0);
    set(&mut client, "FENCE_ALT_MIN", 20.0);
    set(&mut client, "FENCE_AUTOENABLE", 2.0);
    set_mode(&mut client, Mode::Takeoff);
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), ACCEPTED);
    client.fly(40.0);
    let said = texts(&client.collect());
    assert!(said.contains(&"Min Alt fence enabled (auto enable)".to_owned()), "{said:?}");
    assert!(said.contains(&"Polygon fence auto-enabled".to_owned()), "{said:?}");
    assert_eq!(set_mode(&mut client, Mode::Guided), ACCEPTED);
    client.command_int(MAV_CMD_GUIDED_CHANGE_ALTITUDE, [0.0; 3], 10.0, MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT);
    client.fly(20.0);
    assert!(texts(&client.collect()).contains(&"Min Alt fence breached".to_owned()));
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
}

#[test]
fn plans_that_were_on_board_are_there_again_or_the_start_fails() {
    let plans = Plans { fence: square(100.0), ..Plans::default() };
    let mut client = Client::new(VehicleSettings { plans, ..quiet() });
    assert_eq!(on_board(&mut client, FENCE).len(), 4);
    let plans = Plans { fence: square(100.0)[..3].to_vec(), ..Plans::default() };
    let error = Vehicle::new(VehicleSettings { plans, ..quiet() }).unwrap_err();
    assert_eq!(error.to_string(), "Fence refused: Incorrect item count");
}

/// One message of somebody who uploads well or badly.
#[derive(Clone, Debug)]
enum Move {
    Count(u16),
    Item(u16, usize),
    Partial(i16, i16),
    Clear,
    BreakOff,
    Wait,
}

fn a_move() -> impl Strategy<Value = Move> {
    prop_oneof![
        (0..6u16).prop_map(Move::Count),
        (0..6u16, 0..4usize).prop_map(|(seq, choice)| Move::Item(seq, choice)),
        (-1..6i16, -1..6i16).prop_map(|(first, last)| Move::Partial(first, last)),
        Just(Move::Clear),
        Just(Move::BreakOff),
        Just(Move::Wait),
    ]
}

impl Move {
    fn send(&self, client: &mut Client, mission_type: MavMissionType) -> Vec<Message> {
        let corner = square(100.0)[0];
        let choices = [
            corner,
            item(MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, 20.0, 5.0, 5.0, 0.0),
            item(MAV_CMD_NAV_RALLY_POINT, 0.0, 5.0, 5.0, 50.0),
            PlanItem { params: [f32::NAN; 4], ..corner },
        ];
        match *self {
            Move::Count(number) => client.ask(&count(mission_type, number)),
            Move::Item(seq, choice) => send_item(client, mission_type, seq, &choices[choice]),
            Move::Partial(start_index, end_index) => {
                client.ask(&Message::MISSION_WRITE_PARTIAL_LIST(MISSION_WRITE_PARTIAL_LIST_DATA {
                    start_index,
                    end_index,
                    target_system: TARGET,
                    mission_type,
                    ..MISSION_WRITE_PARTIAL_LIST_DATA::DEFAULT
                }))
            }
            Move::Clear => client.ask(&Message::MISSION_CLEAR_ALL(MISSION_CLEAR_ALL_DATA {
                target_system: TARGET,
                mission_type,
                ..MISSION_CLEAR_ALL_DATA::DEFAULT
            })),
            Move::BreakOff => client.ask(&Message::MISSION_ACK(MISSION_ACK_DATA {
                target_system: TARGET,
                mavtype: MAV_MISSION_OPERATION_CANCELLED,
                mission_type,
                ..MISSION_ACK_DATA::DEFAULT
            })),
            Move::Wait => {
                if let Some(due) = client.vehicle.poll_timeout() {
                    client.vehicle.handle_timeout(due);
                }
                client.collect()
            }
        }
    }
}

proptest! {
    /// Whatever two writers send in whatever order, a plan changes only where its change is accepted, and a fence on
    /// board always makes sense.
    #[test]
    fn nothing_is_half_applied(moves in prop::collection::vec((a_move(), any::<bool>(), any::<bool>()), 1..60)) {
        let mut client = Client::new(quiet());
        let mut plans = [vec![], vec![]];
        for (step, of_fence, by_other) in moves {
            let kind = if of_fence { FENCE } else { RALLY };
            client.address = peer(if by_other { 50_000 } else { 40_000 });
            let answer = step.send(&mut client, kind);
            let was_accepted = answer.iter().any(|message| matches!(message, Message::MISSION_ACK(ack)
                if ack.mavtype == MAV_MISSION_ACCEPTED && ack.mission_type == kind));
            let now = [on_board(&mut client, FENCE), on_board(&mut client, RALLY)];
            let changed = (now[0] != plans[0], now[1] != plans[1]);
            let may = (was_accepted && of_fence, was_accepted && !of_fence);
            prop_assert!((!changed.0 || may.0) && (!changed.1 || may.1), "{step:?}: {answer:?}");
            let is_corner = |command| command == MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION;
            let corners = now[0].iter().filter(|item| is_corner(item.command)).count();
            prop_assert!(corners % 4 == 0 && now[1].iter().all(|item| item.command == MAV_CMD_NAV_RALLY_POINT));
            plans = now;
        }
    }
}

#[test]
fn who_climbs_out_of_a_fence_comes_back_below_it() {
    for (name, limit_m, altitude_m) in [("FENCE_ALT_MAX", 70.0, 90.0), ("FENCE_ALT_MIN", 40.0, 30.0)] {
        let kind = if name == "FENCE_ALT_MAX" { 1.0 } else { 8.0 };
        let parameters = [(name, limit_m), ("FENCE_TYPE", kind), ("FENCE_ENABLE", 1.0)];
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).to_vec();
        let mut client = Client::new(VehicleSettings { default_parameters: parameters, ..quiet() });
        client.fly(1.0);
        assert_eq!(
            client.command_int(
                MAV_CMD_GUIDED_CHANGE_ALTITUDE,
                [0.0; 3],
                altitude_m,
                MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT
            ),
            ACCEPTED,
            "{name}"
        );
        client.fly(60.0);
        assert_eq!(client.vehicle.mode(), Mode::Rtl);
        assert!(texts(&client.collect()).contains(&"Fence breach cleared".to_owned()), "{name}");
        assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 15.0, 0.0]), ACCEPTED);
    }
}

#[test]
fn the_fence_of_a_px4_counts_as_soon_as_it_is_uploaded() {
    let mut client = Client::new(VehicleSettings { personality: Personality::Px4, ..quiet() });
    assert_eq!(upload(&mut client, FENCE, &square(200.0)), MAV_MISSION_ACCEPTED);
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 4.0, 19.0]), ACCEPTED);
    client.fly(25.0);
    // GF_ACTION is 2 at first: Hold, which anybody may leave.
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    let said = texts(&client.collect());
    let told = ["Geofence: approaching or outside geofence", "Failsafe activated"];
    assert!(told.iter().all(|text| said.iter().any(|said| said == text)), "{said:?}");
    assert_eq!(client.command_long(MAV_CMD_NAV_RETURN_TO_LAUNCH, [0.0; 3]), ACCEPTED);
}
