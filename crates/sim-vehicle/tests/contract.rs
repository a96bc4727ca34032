//! What ArduPlane accepts and refuses, asked of the simulated vehicle over its wire.
#![allow(clippy::unwrap_used)]
#![allow(deprecated)]

mod common;

use common::{Client, TARGET, acknowledgement, long, positions, quiet, texts};
use flight_model::Setpoint;
use mavlink_bridge::dialect::MavCmd::*;
use mavlink_bridge::dialect::MavFrame::*;
use mavlink_bridge::dialect::MavResult::*;
use mavlink_bridge::dialect::{
    DialectMessage, MavFrame, MavModeFlag, MavResult, MavState, Message, PING_DATA, PositionTargetTypemask,
    SET_MODE_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA, TIMESYNC_DATA,
};
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Encoder, Target, guided_commands, local_ned_setpoint};
use sim_vehicle::{Mode, Personality, VehicleSettings};
use std::time::Duration;

const NAN: f32 = f32::NAN;
const INFINITY: f32 = f32::INFINITY;

fn setpoint(speed_mps: f64, course_rad: f64, altitude_m: f64) -> Message {
    let target = Target { system_id: TARGET, component_id: 1 };
    local_ned_setpoint(Duration::ZERO, target, &Setpoint { speed_mps, course_rad, altitude_m })
}

#[test]
fn a_guided_speed_moves_by_whole_steps_as_that_of_arduplane() {
    let after_4_s = |speed_mps: f32, acceleration_mps2: f32| {
        let mut client = Client::new(quiet());
        let params = [0.0, speed_mps, acceleration_mps2];
        assert_eq!(client.command_long(MAV_CMD_GUIDED_CHANGE_SPEED, params), Some(MAV_RESULT_ACCEPTED));
        client.fly(4.0).last().unwrap().speed_mps
    };
    // Less than 0.1 m/s2 never raises its demand; it sinks at the next higher step.
    assert!((after_4_s(12.0, 0.09) - 10.0).abs() < 1e-6);
    assert_eq!(after_4_s(12.0, 0.49), after_4_s(12.0, 0.4));
    assert_eq!(after_4_s(8.0, 0.31), after_4_s(8.0, 0.4));
}

#[test]
fn guided_speed_is_accepted_and_refused_as_by_arduplane() {
    let mut client = Client::new(quiet());
    for (params, expected) in [
        ([0.0, 5.0, 0.0], MAV_RESULT_ACCEPTED),
        ([0.0, 15.0, 0.0], MAV_RESULT_ACCEPTED),
        ([0.0, 12.0, -1.0], MAV_RESULT_ACCEPTED),
        ([1.0, 12.0, 0.0], MAV_RESULT_DENIED),
        ([0.0, 4.99, 0.0], MAV_RESULT_FAILED),
        ([0.0, 15.01, 0.0], MAV_RESULT_FAILED),
        ([0.0, NAN, 0.0], MAV_RESULT_DENIED),
        ([0.0, 12.0, NAN], MAV_RESULT_DENIED),
        ([0.0, INFINITY, 0.0], MAV_RESULT_DENIED),
        ([NAN, 12.0, 0.0], MAV_RESULT_DENIED),
    ] {
        let by_int = client.command_int(MAV_CMD_GUIDED_CHANGE_SPEED, params, 0.0, MAV_FRAME_GLOBAL);
        assert_eq!(by_int, Some(expected), "{params:?}");
        assert_eq!(client.command_long(MAV_CMD_GUIDED_CHANGE_SPEED, params), Some(expected), "{params:?}");
    }
}

#[test]
fn guided_altitude_is_accepted_and_refused_as_by_arduplane() {
    let mut client = Client::new(quiet());
    let mut ask =
        |p3, z, frame: MavFrame| client.command_int(MAV_CMD_GUIDED_CHANGE_ALTITUDE, [0.0, 0.0, p3], z, frame).unwrap();
    let above_home = MAV_FRAME_GLOBAL_RELATIVE_ALT;
    for frame in [0, 3, 5, 6, 10, 11] {
        assert_eq!(ask(0.0, 80.0, frame_number(frame)), MAV_RESULT_ACCEPTED, "{frame}");
    }
    for frame in [1, 2, 4, 7, 8, 9, 12, 20, 21] {
        assert_eq!(ask(0.0, 80.0, frame_number(frame)), MAV_RESULT_DENIED, "{frame}");
    }
    for (p3, z) in [(0.0, 0.0), (0.0, -1.0), (0.0, NAN), (NAN, 80.0), (0.0, -INFINITY)] {
        assert_eq!(ask(p3, z, above_home), MAV_RESULT_DENIED, "{p3} {z}");
    }
}

fn frame_number(number: u32) -> MavFrame {
    let frames = [
        MAV_FRAME_GLOBAL,
        MAV_FRAME_LOCAL_NED,
        MAV_FRAME_MISSION,
        MAV_FRAME_GLOBAL_RELATIVE_ALT,
        MAV_FRAME_LOCAL_ENU,
        MAV_FRAME_GLOBAL_INT,
        MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
        MAV_FRAME_LOCAL_OFFSET_NED,
        MAV_FRAME_BODY_NED,
        MAV_FRAME_BODY_OFFSET_NED,
        MAV_FRAME_GLOBAL_TERRAIN_ALT,
        MAV_FRAME_GLOBAL_TERRAIN_ALT_INT,
        MAV_FRAME_BODY_FRD,
        MAV_FRAME_LOCAL_FRD,
        MAV_FRAME_LOCAL_FLU,
    ];
    frames.into_iter().find(|frame| *frame as u32 == number).unwrap()
}

#[test]
fn guided_heading_is_accepted_and_refused_as_by_arduplane() {
    let mut client = Client::new(quiet());
    for (params, expected) in [
        ([0.0, 0.0, 20.0], MAV_RESULT_ACCEPTED),
        ([1.0, 359.99, 20.0], MAV_RESULT_ACCEPTED),
        ([2.0, 0.0, 0.0], MAV_RESULT_ACCEPTED),
        ([0.0, -0.01, 20.0], MAV_RESULT_DENIED),
        ([0.0, 360.0, 20.0], MAV_RESULT_DENIED),
        ([3.0, 90.0, 20.0], MAV_RESULT_DENIED),
        ([-1.0, 90.0, 20.0], MAV_RESULT_DENIED),
        ([0.0, NAN, 20.0], MAV_RESULT_DENIED),
        ([0.0, 90.0, INFINITY], MAV_RESULT_DENIED),
    ] {
        let by_int = client.command_int(MAV_CMD_GUIDED_CHANGE_HEADING, params, 0.0, MAV_FRAME_BODY_NED);
        assert_eq!(by_int, Some(expected), "{params:?}");
        assert_eq!(client.command_long(MAV_CMD_GUIDED_CHANGE_HEADING, params), Some(expected), "{params:?}");
    }
}

#[test]
fn what_is_refused_changes_nothing_and_says_why() {
    let mut client = Client::new(quiet());
    let before = *client.vehicle.state();
    for message in [
        long(TARGET, MAV_CMD_GUIDED_CHANGE_SPEED, [0.0, NAN, 0.0]),
        long(TARGET, MAV_CMD_GUIDED_CHANGE_HEADING, [0.0, 90.0, NAN]),
        long(TARGET, MAV_CMD_DO_SET_MODE, [1.0, 9.0, 0.0]),
        long(TARGET, MAV_CMD_DO_SET_MODE, [1.0, NAN, 0.0]),
        long(TARGET, MAV_CMD_COMPONENT_ARM_DISARM, [0.0, 0.0, 0.0]),
    ] {
        let answer = client.ask(&message);
        assert_ne!(acknowledgement(&answer).unwrap().result, MAV_RESULT_ACCEPTED);
        assert_eq!(texts(&answer).len(), 1, "{message:?}");
    }
    let end = *client.fly(5.0).last().unwrap();
    assert_eq!((end.speed_mps, end.course_rad, end.altitude_m), (before.speed_mps, before.course_rad, 50.0));
    assert_eq!(client.vehicle.mode(), Mode::Guided);
    assert!(client.vehicle.is_armed());
}

#[test]
fn modes_are_set_by_command_and_by_the_old_message() {
    let mut client = Client::new(quiet());
    for (base, number, expected) in [
        (1.0, 12.0, MAV_RESULT_ACCEPTED),
        (217.0, 7.0, MAV_RESULT_ACCEPTED),
        (1.0, 11.0, MAV_RESULT_ACCEPTED),
        (1.0, 9.0, MAV_RESULT_FAILED),
        (1.0, 99.0, MAV_RESULT_FAILED),
        (1.0, -15.0, MAV_RESULT_FAILED),
        (0.0, 15.0, MAV_RESULT_DENIED),
    ] {
        let before = client.vehicle.mode();
        assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [base, number, 0.0]), Some(expected), "{number}");
        let after = client.vehicle.mode();
        assert_eq!(f64::from(after.number()) == f64::from(number), expected == MAV_RESULT_ACCEPTED);
        assert!(expected == MAV_RESULT_ACCEPTED || after == before);
    }
    // Out of GUIDED the guided commands fail.
    for command in [MAV_CMD_GUIDED_CHANGE_SPEED, MAV_CMD_GUIDED_CHANGE_ALTITUDE, MAV_CMD_GUIDED_CHANGE_HEADING] {
        assert_eq!(client.command_long(command, [0.0, 12.0, 0.0]), Some(MAV_RESULT_FAILED));
    }
    let set_mode = SET_MODE_DATA {
        custom_mode: 15,
        target_system: TARGET,
        base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
    };
    // ArduPlane does not acknowledge it; its heartbeat tells.
    let answer = client.ask(&Message::SET_MODE(set_mode.clone()));
    assert!(matches!(answer.as_slice(), [Message::HEARTBEAT(beat)] if beat.custom_mode == 15));
    assert_eq!(client.vehicle.mode(), Mode::Guided);
    for (personality, custom_mode, mode) in
        [(Personality::Px4, 0x0504_0000, Mode::Rtl), (Personality::Generic, 11, Mode::Rtl)]
    {
        let mut client = Client::new(VehicleSettings { personality, ..quiet() });
        let answer = client.ask(&Message::SET_MODE(SET_MODE_DATA { custom_mode, ..set_mode.clone() }));
        let ack = acknowledgement(&answer).unwrap();
        assert_eq!((ack.command, ack.result, client.vehicle.mode()), (MAV_CMD_DO_SET_MODE, MAV_RESULT_ACCEPTED, mode));
    }
}

#[test]
fn on_the_rail_it_is_armed_and_released() {
    let mut client = Client::new(VehicleSettings { armed: false, ..quiet() });
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [0.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [2.0, 0.0, 0.0]), Some(MAV_RESULT_UNSUPPORTED));
    assert!(client.fly(40.0).iter().all(|state| state.x_m == 0.0 && state.speed_mps == 0.0));
    assert_eq!(client.vehicle.mode(), Mode::Guided, "the time-out does not run on the rail");
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert!((client.fly(1.0).last().unwrap().x_m - 10.0).abs() < 1e-9);
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [0.0, 0.0, 0.0]), Some(MAV_RESULT_FAILED));
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [0.0, 21196.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert!(!client.vehicle.is_armed());
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
}

#[test]
fn others_are_met_with_silence_and_everybody_is_obeyed() {
    let mut client = Client::new(quiet());
    let answer = client.ask(&long(TARGET + 1, MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]));
    assert_eq!((answer.len(), client.vehicle.mode()), (0, Mode::Guided));
    assert_eq!(client.vehicle.counters().frames_for_others, 1);
    // Its own frames, come back from a loop, are not obeyed; a companion computer with its system id is.
    let command = long(0, MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]);
    client.encoder = Encoder::new(TARGET, 1);
    assert_eq!((client.ask(&command).len(), client.vehicle.mode()), (0, Mode::Guided));
    client.encoder = Encoder::new(TARGET, 191);
    let answer = client.ask(&command);
    assert_eq!(acknowledgement(&answer).unwrap().result, MAV_RESULT_ACCEPTED);
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
}

#[test]
fn unknown_commands_are_unsupported_by_their_number() {
    let mut client = Client::new(quiet());
    assert_eq!(client.command_long(MAV_CMD_DO_ORBIT, [0.0; 3]), Some(MAV_RESULT_UNSUPPORTED));
    // A number that the dialect does not have: patch it into a frame and mend the checksum by encoding by hand.
    for number in [60_000u16, 43_001] {
        let mut datagram = client.encode(&long(TARGET, MAV_CMD_DO_PARACHUTE, [1.0; 3]));
        let mut payload = datagram[10..datagram.len() - 2].to_vec();
        payload.resize(33, 0);
        payload[28..30].copy_from_slice(&number.to_le_bytes());
        datagram = common::by_hand(76, 152, &payload);
        client.vehicle.handle(Duration::ZERO, &datagram, client.address);
        let sent = client.vehicle.poll_transmit().unwrap().datagram;
        let mut counters = mavlink_bridge::Counters::default();
        let ack = mavlink_bridge::frames(&sent, &mut counters).find(|frame| frame.header.message_id == 77).unwrap();
        let [low, high] = number.to_le_bytes();
        let expected = if number == 60_000 { MAV_RESULT_UNSUPPORTED } else { MAV_RESULT_DENIED };
        assert_eq!(ack.payload()[..3], [low, high, expected as u8]);
    }
}

#[test]
fn setpoints_are_followed_in_guided_only() {
    let mut client = Client::new(quiet());
    assert_eq!(client.ask(&setpoint(12.0, 1.0, 60.0)).len(), 2, "only the greeting of a new peer");
    let end = *client.fly(25.0).last().unwrap();
    assert!((end.speed_mps - 12.0).abs() < 1e-4 && (end.course_rad - 1.0).abs() < 1e-4);
    assert!((end.altitude_m - 60.0).abs() < 0.01);

    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 7.0, 0.0]);
    let words = texts(&client.ask(&setpoint(8.0, 0.0, 50.0)));
    assert_eq!(words, ["Setpoint refused: mode is CRUISE"]);
    assert_eq!(client.ask(&setpoint(8.0, 0.0, 50.0)), [], "the second refusal in five seconds is silent");
    assert!((client.fly(5.0).last().unwrap().speed_mps - 12.0).abs() < 1e-4);
    assert_eq!(client.vehicle.counters().setpoints_refused, 2);
    assert_eq!(client.vehicle.counters().setpoints_accepted, 1);
}

#[test]
fn partial_setpoints_leave_the_rest_and_bad_ones_everything() {
    let mut client = Client::new(quiet());
    let altitude_only = SET_POSITION_TARGET_LOCAL_NED_DATA {
        z: -55.0,
        type_mask: PositionTargetTypemask::from_bits_retain(0xFFF & !4),
        target_system: TARGET,
        coordinate_frame: MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
    };
    client.ask(&setpoint(11.0, 0.5, 50.0));
    client.ask(&Message::SET_POSITION_TARGET_LOCAL_NED(altitude_only.clone()));
    // A velocity of zero asks for the least speed and says nothing of the course.
    let stop = SET_POSITION_TARGET_LOCAL_NED_DATA {
        type_mask: PositionTargetTypemask::from_bits_retain(0xFFF & !24),
        ..altitude_only.clone()
    };
    let end = *client.fly(20.0).last().unwrap();
    assert!((end.speed_mps - 11.0).abs() < 1e-3 && (end.course_rad - 0.5).abs() < 1e-3);
    assert!((end.altitude_m - 55.0).abs() < 0.01);
    client.ask(&Message::SET_POSITION_TARGET_LOCAL_NED(stop));
    let end = *client.fly(9.0).last().unwrap();
    assert!((end.speed_mps - 5.0).abs() < 1e-3 && (end.course_rad - 0.5).abs() < 1e-3);

    let accepted = client.vehicle.counters().setpoints_accepted;
    for bad in [
        SET_POSITION_TARGET_LOCAL_NED_DATA { z: NAN, ..altitude_only.clone() },
        SET_POSITION_TARGET_LOCAL_NED_DATA { coordinate_frame: MAV_FRAME_BODY_NED, ..altitude_only.clone() },
        SET_POSITION_TARGET_LOCAL_NED_DATA { type_mask: PositionTargetTypemask::empty(), ..altitude_only },
    ] {
        client.ask(&Message::SET_POSITION_TARGET_LOCAL_NED(bad));
    }
    assert_eq!(client.vehicle.counters().setpoints_refused, 3);
    assert_eq!(client.vehicle.counters().setpoints_accepted, accepted);
}

#[test]
fn without_setpoints_it_loiters_until_guided_is_set_again() {
    let mut client = Client::new(VehicleSettings { setpoint_timeout_s: 3.0, ..quiet() });
    client.ask(&ground_heartbeat());
    client.fly(2.5);
    client.ask(&setpoint(12.0, 1.0, 50.0));
    client.fly(2.99);
    assert_eq!((client.vehicle.mode(), client.vehicle.is_in_failsafe()), (Mode::Guided, false));
    client.fly(0.01);
    assert_eq!((client.vehicle.mode(), client.vehicle.is_in_failsafe()), (Mode::Loiter, true));
    assert_eq!(texts(&client.collect()), ["Failsafe: no setpoint for 3 s, LOITER"]);
    client.ask(&setpoint(12.0, 1.0, 50.0));
    assert_eq!(client.vehicle.mode(), Mode::Loiter, "a setpoint alone does not bring GUIDED back");
    let answer = client.ask(&long(TARGET, MAV_CMD_REQUEST_MESSAGE, [0.0, 0.0, 0.0]));
    assert!(answer.iter().any(|message| matches!(message, Message::HEARTBEAT(heartbeat)
        if heartbeat.system_status == MavState::MAV_STATE_CRITICAL && heartbeat.custom_mode == 12)));
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 15.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert!(!client.vehicle.is_in_failsafe());
    client.ask(&setpoint(12.0, 1.0, 50.0));
    assert!((client.fly(2.9).last().unwrap().speed_mps - 12.0).abs() < 0.2);
    assert_eq!(client.vehicle.counters().failsafes, 1);
}

#[test]
fn the_timeout_can_be_switched_off() {
    let mut client = Client::new(VehicleSettings { setpoint_timeout_s: 0.0, ..quiet() });
    client.fly(600.0);
    assert_eq!(client.vehicle.mode(), Mode::Guided);
}

#[test]
fn message_rates_are_set_for_the_asking_link() {
    let mut client = Client::new(quiet());
    let mut interval = |id: f32, us: f32| client.command_long(MAV_CMD_SET_MESSAGE_INTERVAL, [id, us, 0.0]).unwrap();
    assert_eq!(interval(32.0, 50_000.0), MAV_RESULT_ACCEPTED);
    assert_eq!(interval(32.0, 10_000.0), MAV_RESULT_DENIED, "100 Hz is more than 0.8 of the step rate");
    assert_eq!(interval(9_999.0, 50_000.0), MAV_RESULT_DENIED);
    assert_eq!(interval(32.0, NAN), MAV_RESULT_DENIED);
    client.fly(10.0);
    let received = client.collect();
    assert_eq!(positions(&received).len(), 200);
    assert_eq!(received.len(), 200);
    client.command_long(MAV_CMD_SET_MESSAGE_INTERVAL, [32.0, -1.0, 0.0]);
    client.fly(10.0);
    assert_eq!(client.collect(), []);
    for (id, expected) in [(49.0, 49), (242.0, 242), (1.0, 1), (33.0, 33)] {
        let answer = client.ask(&long(TARGET, MAV_CMD_REQUEST_MESSAGE, [id, 0.0, 0.0]));
        assert_eq!(answer.iter().filter(|message| message.message_id() == expected).count(), 1);
        assert_eq!(acknowledgement(&answer).unwrap().result, MAV_RESULT_ACCEPTED);
    }
    assert_eq!(client.command_long(MAV_CMD_REQUEST_MESSAGE, [261.0, 0.0, 0.0]), Some(MAV_RESULT_FAILED));
}

#[test]
fn telemetry_goes_to_the_ground_and_to_whoever_spoke() {
    let defaults = VehicleSettings::default();
    let ground = defaults.ground.unwrap();
    let mut client = Client::new(VehicleSettings { system_id: TARGET, ..defaults });
    client.ask(&ground_heartbeat());
    client.fly(10.0);
    let mut received = std::collections::HashMap::<_, usize>::new();
    while let Some(transmit) = client.vehicle.poll_transmit() {
        let count = common::decode(&transmit.datagram).iter().filter(|m| m.message_id() == 32).count();
        *received.entry(transmit.to).or_default() += count;
    }
    assert_eq!(received[&client.address], 100);
    assert_eq!(received[&ground], 100);
    // Silence of 120 s ends it for the one and not for the other.
    client.vehicle.handle_timeout(Duration::from_secs(121));
    client.fly(1.0);
    let peers: Vec<_> = std::iter::from_fn(|| client.vehicle.poll_transmit()).map(|transmit| transmit.to).collect();
    assert!(!peers.is_empty() && peers.iter().all(|to| *to == ground));
}

#[test]
fn timesync_and_ping_are_answered() {
    let mut client = Client::new(quiet());
    client.fly(2.0);
    let answer = client.ask(&Message::TIMESYNC(TIMESYNC_DATA { ts1: 1234, ..TIMESYNC_DATA::DEFAULT }));
    assert!(
        answer
            .iter()
            .any(|message| matches!(message, Message::TIMESYNC(sync) if sync.ts1 == 1234 && sync.tc1 == 2_000_000_000))
    );
    let answer = client.ask(&Message::PING(PING_DATA { seq: 5, ..PING_DATA::DEFAULT }));
    assert!(
        answer
            .iter()
            .any(|message| matches!(message, Message::PING(ping) if ping.seq == 5 && ping.target_system == 255))
    );
    let own = Message::TIMESYNC(TIMESYNC_DATA { tc1: 1, ts1: 1, ..TIMESYNC_DATA::DEFAULT });
    assert_eq!(client.ask(&own), [], "an answer is not answered");
}

/// The three guided commands as the ground side writes them, seen from outside: within 2 % of the closed form of Eq. 1.
#[test]
fn guided_steps_are_the_closed_form_seen_from_outside() {
    let mut client = Client::new(quiet());
    client.command_long(MAV_CMD_SET_MESSAGE_INTERVAL, [32.0, 100_000.0, 0.0]);
    let start = Setpoint { speed_mps: 12.0, course_rad: 0.6, altitude_m: 52.0 };
    let target = Target { system_id: TARGET, component_id: 1 };
    for command in guided_commands(target, &start, 52.0, 40.0).unwrap() {
        let answer = client.ask(&command);
        assert_eq!(acknowledgement(&answer).unwrap().result, MavResult::MAV_RESULT_ACCEPTED);
    }
    client.fly(10.0);
    let received = client.collect();
    assert!(positions(&received).len() >= 100);
    for position in positions(&received) {
        let t = f64::from(position.time_boot_ms) / 1e3;
        let state = mavlink_bridge::state_from_local_position(&position);
        let (a, b): (f64, f64) = (1.0 / 3.0, 3.0);
        let climbed = 2.0 * (1.0 - (b * libm::exp(-t / b) - a * libm::exp(-t / a)) / (b - a));
        assert!((state.speed_mps - (10.0 + 2.0 * (1.0 - libm::exp(-t)))).abs() < 0.02 * 2.0, "{t}");
        assert!((state.course_rad - 0.6 * (1.0 - libm::exp(-t / 0.75))).abs() < 0.02 * 0.6, "{t}");
        assert!((state.altitude_m - (50.0 + climbed)).abs() < 0.02 * 2.0, "{t}");
    }
}
