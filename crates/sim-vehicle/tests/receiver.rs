//! A pilot's channels as other people's scripts use them: the mode switch, reversed channels and those above the
//! eighth, and what such scripts begin with: all streams at once, and a reboot.
#![allow(clippy::unwrap_used, deprecated)]

mod common;

use common::{Client, TARGET, quiet, set_parameter, texts};
use mavlink_bridge::dialect::MavCmd::*;
use mavlink_bridge::dialect::MavResult::*;
use mavlink_bridge::dialect::*;
use mavlink_bridge::{Counters, frames};
use sim_vehicle::{Mode, Personality, Plans, Vehicle, VehicleSettings};
use std::collections::BTreeSet;

const LEFT_ALONE: u16 = u16::MAX;

/// Holds some channels, by their numbers, for a second.
fn hold(client: &mut Client, held: &[(usize, u16)]) -> Vec<Message> {
    let mut channels = [LEFT_ALONE; 16];
    held.iter().for_each(|(number, pulse_us)| channels[number - 1] = *pulse_us);
    let mut data = RC_CHANNELS_OVERRIDE_DATA { target_system: TARGET, ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT };
    let fields = [
        &mut data.chan1_raw,
        &mut data.chan2_raw,
        &mut data.chan3_raw,
        &mut data.chan4_raw,
        &mut data.chan5_raw,
        &mut data.chan6_raw,
        &mut data.chan7_raw,
        &mut data.chan8_raw,
        &mut data.chan9_raw,
        &mut data.chan10_raw,
    ];
    fields.into_iter().zip(channels).for_each(|(field, pulse_us)| *field = pulse_us);
    let mut heard = client.ask(&Message::RC_CHANNELS_OVERRIDE(data));
    client.fly(1.0);
    heard.extend(client.collect());
    heard
}

fn channels(client: &mut Client) -> RC_CHANNELS_DATA {
    client.command_long(MAV_CMD_REQUEST_MESSAGE, [65.0, 0.0, 0.0]);
    let request = common::long(TARGET, MAV_CMD_REQUEST_MESSAGE, [65.0, 0.0, 0.0]);
    let found = client.ask(&request).into_iter().find_map(|message| match message {
        Message::RC_CHANNELS(channels) => Some(channels),
        _ => None,
    });
    found.unwrap()
}

#[test]
fn the_mode_switch_changes_the_mode() {
    let mut client = Client::new(quiet());
    client.fly(1.0);
    assert_eq!(client.vehicle.mode(), Mode::Guided, "the switch has not moved");
    for (pulse_us, mode) in [(1000, Mode::Rtl), (1500, Mode::Fbwa), (1800, Mode::Manual)] {
        hold(&mut client, &[(8, pulse_us)]);
        assert_eq!(client.vehicle.mode(), mode);
    }
    client.ask(&set_parameter("FLTMODE1", 12.0));
    hold(&mut client, &[(8, 1000)]);
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    client.ask(&set_parameter("FLTMODE2", 14.0));
    let heard = hold(&mut client, &[(8, 1300)]);
    assert_eq!(texts(&heard), ["Mode AVOID_ADSB is not simulated"]);
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    // Another channel, and none.
    client.ask(&set_parameter("FLTMODE_CH", 5.0));
    hold(&mut client, &[(5, 1500)]);
    assert_eq!(client.vehicle.mode(), Mode::Fbwa);
    client.ask(&set_parameter("FLTMODE_CH", 0.0));
    hold(&mut client, &[(5, 1000), (8, 1000)]);
    assert_eq!(client.vehicle.mode(), Mode::Fbwa);
}

#[test]
fn channels_with_a_function_are_switches() {
    let mut client = Client::new(quiet());
    // Before it has a function, a channel does nothing.
    hold(&mut client, &[(9, 1900)]);
    hold(&mut client, &[(9, 1000)]);
    client.ask(&set_parameter("RC9_OPTION", 4.0));
    client.ask(&set_parameter("RC10_OPTION", 56.0));
    hold(&mut client, &[(9, 1000), (10, 1500)]);
    assert_eq!(client.vehicle.mode(), Mode::Guided);
    hold(&mut client, &[(9, 1900)]);
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
    hold(&mut client, &[(10, 1900)]);
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    // Who leaves a mode by its switch goes where the mode switch stands.
    hold(&mut client, &[(8, 1500), (10, 1900)]);
    assert_eq!(client.vehicle.mode(), Mode::Fbwa);
    hold(&mut client, &[(8, 1500), (10, 1000)]);
    assert_eq!(client.vehicle.mode(), Mode::Fbwa);
    hold(&mut client, &[(8, 1500), (10, 1900)]);
    hold(&mut client, &[(8, 1500), (10, 1000)]);
    assert_eq!(client.vehicle.mode(), Mode::Fbwa);
    client.ask(&set_parameter("RC7_OPTION", 11.0));
    client.ask(&set_parameter("FENCE_TYPE", 1.0));
    assert_eq!(texts(&hold(&mut client, &[(7, 1900)])), ["RC7: Fence HIGH"]);
}

#[test]
fn a_function_is_done_by_a_command_too() {
    let mut client = Client::new(quiet());
    let mut function = |number: f32, position: f32| {
        let data =
            COMMAND_LONG_DATA { param1: number, param2: position, target_system: TARGET, ..COMMAND_LONG_DATA::DEFAULT };
        // The command is of ArduPilot's own dialect: its number goes in by hand, into bytes 28 and 29 of the payload.
        let mut payload = [0; 30];
        payload[..4].copy_from_slice(&data.param1.to_le_bytes());
        payload[4..8].copy_from_slice(&data.param2.to_le_bytes());
        payload[28..].copy_from_slice(&218_u16.to_le_bytes());
        let frame = common::by_hand(76, 152, &[&payload[..], &[TARGET, 1, 0]].concat());
        let address = client.address;
        client.vehicle.handle(client.vehicle.time(), &frame, address);
        // The acknowledgement has a number that the common dialect does not know.
        while client.vehicle.poll_transmit().is_some() {}
        client.vehicle.mode()
    };
    assert_eq!(function(56.0, 2.0), Mode::Loiter);
    assert_eq!(function(4.0, 2.0), Mode::Rtl);
    assert_eq!(function(4.0, 3.0), Mode::Rtl);
    assert_eq!(function(4.0, 0.0), Mode::Manual);
}

#[test]
fn a_px4_has_no_mode_switch() {
    let mut client = Client::new(VehicleSettings { personality: Personality::Px4, ..quiet() });
    let before = client.vehicle.mode();
    hold(&mut client, &[(8, 1000)]);
    assert_eq!(client.vehicle.mode(), before);
}

#[test]
fn a_reversed_channel_says_the_opposite() {
    let climbs = |reversed: f32| {
        let mut client = Client::new(quiet());
        client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 5.0, 0.0]);
        client.ask(&set_parameter("RC2_REVERSED", reversed));
        hold(&mut client, &[(2, 1200)]);
        client.fly(1.0).last().unwrap().climb_mps
    };
    assert!(climbs(0.0) < -0.5);
    assert!(climbs(1.0) > 0.5);
}

#[test]
fn channels_above_the_eighth_are_given_back_by_65534() {
    let mut client = Client::new(quiet());
    hold(&mut client, &[(9, 1234), (10, 1700)]);
    hold(&mut client, &[(9, 0), (10, u16::MAX - 1)]);
    let shown = channels(&mut client);
    assert_eq!((shown.chan8_raw, shown.chan9_raw, shown.chan10_raw, shown.chancount), (1800, 1234, 0, 8));
}

#[test]
fn all_streams_at_once_bring_all_of_arduplanes() {
    let mut client = Client::new(quiet());
    client.ask(&Message::REQUEST_DATA_STREAM(REQUEST_DATA_STREAM_DATA {
        req_message_rate: 2,
        target_system: TARGET,
        req_stream_id: MavDataStream::MAV_DATA_STREAM_ALL,
        start_stop: 1,
        ..REQUEST_DATA_STREAM_DATA::DEFAULT
    }));
    client.fly(1.0);
    let mut seen = BTreeSet::new();
    while let Some(transmit) = client.vehicle.poll_transmit() {
        seen.extend(frames(&transmit.datagram, &mut Counters::default()).map(|frame| frame.header.message_id));
    }
    // What a real one sent, but what it has no device for.
    let expected = [
        1, 2, 24, 27, 29, 30, 32, 33, 36, 42, 62, 65, 74, 87, 116, 125, 129, 136, 137, 147, 152, 163, 164, 168, 178,
        193, 241, 295, 11_020,
    ];
    for id in expected {
        assert!(seen.contains(&id), "message {id} does not come");
    }
}

#[test]
fn a_reboot_is_counted_and_puts_a_vehicle_that_began_on_the_ground_back() {
    let mut client = Client::new(VehicleSettings { on_ground: true, ..quiet() });
    let boots = |client: &mut Client| {
        let read = PARAM_REQUEST_READ_DATA {
            param_index: -1,
            target_system: TARGET,
            target_component: 1,
            param_id: "STAT_BOOTCNT".into(),
        };
        client.ask(&Message::PARAM_REQUEST_READ(read)).into_iter().find_map(|message| match message {
            Message::PARAM_VALUE(value) => Some(value.param_value),
            _ => None,
        })
    };
    assert_eq!(boots(&mut client), Some(1.0));
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 13.0, 0.0]);
    client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
    let flown = client.fly(20.0);
    assert!(flown.last().unwrap().altitude_m > 10.0);
    client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [0.0, 21_196.0, 0.0]);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(boots(&mut client), Some(2.0));
    let after = *client.fly(1.0).last().unwrap();
    let start = VehicleSettings::default().start;
    assert_eq!((after.x_m, after.y_m, after.altitude_m, after.speed_mps), (start.x_m, start.y_m, 0.0, 0.0));
    assert_eq!(client.vehicle.mode(), Mode::Manual);
}

#[test]
fn a_message_that_is_asked_for_follows_its_acknowledgement() {
    let mut client = Client::new(quiet());
    client.ask(&mavlink_bridge::telemetry::ground_heartbeat());
    for (command, follow) in
        [(MAV_CMD_REQUEST_MESSAGE, [30_u32].as_slice()), (MAV_CMD_GET_HOME_POSITION, [242, 49].as_slice())]
    {
        let heard = client.ask(&common::long(TARGET, command, [follow[0] as f32, 0.0, 0.0]));
        let ids: Vec<u32> = heard.iter().map(Message::message_id).collect();
        assert_eq!(ids, [[77].as_slice(), follow].concat());
    }
}

#[test]
fn auto_without_a_mission_is_not_armed() {
    let mut client = Client::new(VehicleSettings { on_ground: true, ..quiet() });
    let items = [
        common::item(MAV_CMD_NAV_WAYPOINT, [0.0; 4], 0.0, 0.0, 0.0),
        common::item(MAV_CMD_NAV_WAYPOINT, [0.0; 4], 100.0, 0.0, 50.0),
    ];
    client.vehicle = Vehicle::new(VehicleSettings {
        on_ground: true,
        plans: Plans { mission: items.to_vec(), ..Plans::default() },
        ..quiet()
    })
    .unwrap();
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 10.0, 0.0]);
    // As ArduPilot's own tests clear it. Cleared by MISSION_CLEAR_ALL it does not stay in AUTO.
    let nothing = MISSION_COUNT_DATA { target_system: TARGET, ..MISSION_COUNT_DATA::DEFAULT };
    client.ask(&Message::MISSION_COUNT(nothing));
    assert_eq!(client.vehicle.mode(), Mode::Auto);
    let heard = client.ask(&common::long(TARGET, MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]));
    assert_eq!(texts(&heard), ["Arm: Mode requires mission"]);
    let clear = MISSION_CLEAR_ALL_DATA { target_system: TARGET, ..MISSION_CLEAR_ALL_DATA::DEFAULT };
    client.ask(&Message::MISSION_CLEAR_ALL(clear));
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
}
