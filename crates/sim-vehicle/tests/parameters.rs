//! The parameter protocol as a client meets it.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Client, TARGET, peer, quiet, texts};
use mavlink_bridge::dialect::MavCmd::{MAV_CMD_DO_SET_MODE, MAV_CMD_GUIDED_CHANGE_SPEED};
use mavlink_bridge::dialect::MavResult::{MAV_RESULT_ACCEPTED, MAV_RESULT_FAILED};
use mavlink_bridge::dialect::*;
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Counters, Encoder, Header, Version, frames};
use sim_vehicle::{LockstepSettings, Mode, Vehicle, VehicleSettings};
use std::collections::BTreeMap;
use std::time::Duration;

fn list() -> Message {
    Message::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA { target_system: TARGET, target_component: 1 })
}

fn read(name: &str, param_index: i16) -> Message {
    Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
        param_index,
        target_system: TARGET,
        target_component: 1,
        param_id: name.into(),
    })
}

fn set(name: &str, param_value: f32) -> Message {
    Message::PARAM_SET(PARAM_SET_DATA {
        param_value,
        target_system: TARGET,
        target_component: 1,
        param_id: name.into(),
        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
    })
}

fn values(messages: &[Message]) -> Vec<PARAM_VALUE_DATA> {
    let value = |message: &Message| match message {
        Message::PARAM_VALUE(value) => Some(value.clone()),
        _ => None,
    };
    messages.iter().filter_map(value).collect()
}

fn errors(messages: &[Message]) -> Vec<MavParamError> {
    let error = |message: &Message| match message {
        Message::PARAM_ERROR(error) => Some(error.error),
        _ => None,
    };
    messages.iter().filter_map(error).collect()
}

/// The whole list, as it comes while host time goes on in milliseconds.
fn whole_list(client: &mut Client) -> Vec<PARAM_VALUE_DATA> {
    let mut received = values(&client.ask(&list()));
    for ms in 0..1_000 {
        client.vehicle.handle_timeout(Duration::from_millis(ms));
        received.extend(values(&client.collect()));
    }
    received
}

/// The headers of what comes back on a message.
fn sent_on(client: &mut Client, message: &Message) -> Vec<Header> {
    let datagram = client.encode(message);
    client.vehicle.handle(Duration::ZERO, &datagram, client.address);
    let sent: Vec<u8> = std::iter::from_fn(|| client.vehicle.poll_transmit()).flat_map(|sent| sent.datagram).collect();
    frames(&sent, &mut Counters::default()).map(|frame| frame.header).collect()
}

fn value_of(client: &mut Client, name: &str) -> f32 {
    values(&client.ask(&read(name, -1)))[0].param_value
}

#[test]
fn the_list_comes_whole_in_order_and_spread_over_time() {
    let mut client = Client::new(quiet());
    let at_once = values(&client.ask(&list()));
    assert_eq!(at_once.len(), 5);
    let received = whole_list(&mut client);
    let count = received[0].param_count;
    assert!(count > 10);
    let indices: Vec<u16> = received.iter().map(|value| value.param_index).collect();
    assert_eq!(indices, (0..count).collect::<Vec<u16>>(), "asked again, it begins again");
    assert!(client.vehicle.poll_timeout().is_none(), "and then it is over");
}

#[test]
fn in_lockstep_the_list_goes_on_while_the_clock_stands() {
    let mut client = Client::new(quiet());
    client.vehicle = Vehicle::in_lockstep(quiet(), LockstepSettings::default()).unwrap();
    let mut received = values(&client.ask(&list()));
    let mut now = Duration::ZERO;
    while received.len() < usize::from(received[0].param_count) {
        now = client.vehicle.poll_timeout().unwrap();
        client.vehicle.handle_timeout(now);
        received.extend(values(&client.collect()));
    }
    assert!(now < Duration::from_millis(100), "{now:?}");
    assert_eq!(client.vehicle.time(), Duration::ZERO);
}

#[test]
fn one_is_read_by_index_and_by_name() {
    let mut client = Client::new(quiet());
    let list: BTreeMap<u16, PARAM_VALUE_DATA> =
        whole_list(&mut client).into_iter().map(|value| (value.param_index, value)).collect();
    for (index, expected) in &list {
        assert_eq!(values(&client.ask(&read("", *index as i16))), std::slice::from_ref(expected));
        let by_name = values(&client.ask(&read(expected.param_id.to_str().unwrap(), -1)));
        assert_eq!(by_name, [PARAM_VALUE_DATA { param_index: u16::MAX, ..expected.clone() }]);
    }
    for (request, words) in [
        (read("SYSID_THISMAV", -1), "No parameter SYSID_THISMAV: it is MAV_SYSID now"),
        (read("", 1000), "No parameter of index 1000"),
        (read("", -2), "No parameter of index -2"),
        (set("NOSUCH", 1.0), "No parameter NOSUCH"),
    ] {
        let answer = client.ask(&request);
        assert_eq!(texts(&answer), [words]);
        assert_eq!(errors(&answer), [MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST]);
        assert_eq!(values(&answer), []);
    }
}

#[test]
fn a_write_is_told_to_everybody_and_a_refusal_to_who_asked() {
    let mut client = Client::new(quiet());
    let hello = client.encode(&ground_heartbeat());
    client.vehicle.handle(Duration::ZERO, &hello, peer(50_000));
    client.collect();
    let datagram = client.encode(&set("WP_LOITER_RAD", 45.4));
    client.vehicle.handle(Duration::ZERO, &datagram, client.address);
    let mut heard = BTreeMap::new();
    while let Some(transmit) = client.vehicle.poll_transmit() {
        heard.entry(transmit.to).or_insert_with(Vec::new).extend(values(&common::decode(&transmit.datagram)));
    }
    assert_eq!(heard.len(), 2);
    assert!(heard.values().all(|values| values.len() == 1 && values[0].param_value == 45.0));

    let owned = |(name, value): (&str, f64)| (name.to_owned(), value);
    let before = client.vehicle.set_parameters().map(owned).collect::<Vec<_>>();
    for (name, value, error) in [
        ("WP_LOITER_RAD", f32::NAN, MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE),
        ("AIRSPEED_MAX", f32::INFINITY, MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE),
        ("AIRSPEED_MAX", 15.5, MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE),
        ("AIRSPEED_MIN", 12.0, MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE),
        ("STAT_RUNTIME", 0.0, MavParamError::MAV_PARAM_ERROR_READ_ONLY),
    ] {
        let unchanged = value_of(&mut client, name);
        let answer = client.ask(&set(name, value));
        assert_eq!(values(&answer).iter().map(|value| value.param_value).collect::<Vec<_>>(), [unchanged]);
        assert_eq!(errors(&answer), [error]);
        assert!(texts(&answer)[0].contains(name), "{name}");
    }
    assert_eq!(client.vehicle.set_parameters().map(owned).collect::<Vec<_>>(), before);
}

#[test]
fn speeds_and_rates_act() {
    let mut client = Client::new(quiet());
    client.ask(&set("AIRSPEED_MAX", 12.0));
    assert_eq!(client.command_long(MAV_CMD_GUIDED_CHANGE_SPEED, [0.0, 12.5, 0.0]), Some(MAV_RESULT_FAILED));
    assert_eq!(client.command_long(MAV_CMD_GUIDED_CHANGE_SPEED, [0.0, 12.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    client.ask(&set("MAV1_POSITION", 20.0));
    client.fly(2.0);
    let received = client.collect();
    assert_eq!(common::positions(&received).len(), 40);
    assert_eq!(received.iter().filter(|message| message.message_id() == 33).count(), 40);
    client.ask(&set("MAV1_POSITION", 0.0));
    client.fly(2.0);
    assert_eq!(client.collect(), []);
}

#[test]
fn circles_and_the_way_home_are_as_set() {
    let mut client = Client::new(quiet());
    client.ask(&set("WP_LOITER_RAD", -30.0));
    client.ask(&set("RTL_RADIUS", 90.0));
    client.ask(&set("RTL_ALTITUDE", 80.0));
    client.ask(&set("AIRSPEED_CRUISE", 8.0));
    let distance = |state: &flight_model::State| (state.x_m * state.x_m + state.y_m * state.y_m).sqrt();
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]);
    let track = client.fly(60.0);
    let end = track.last().unwrap();
    assert!((distance(end) - 30.0).abs() < 0.05, "{}", distance(end));
    let anticlockwise = end.x_m * libm::sin(end.course_rad) - end.y_m * libm::cos(end.course_rad) < 0.0;
    assert!(anticlockwise && (end.speed_mps - 8.0).abs() < 1e-6);
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 11.0, 0.0]);
    let end = *client.fly(120.0).last().unwrap();
    assert!((distance(&end) - 90.0).abs() < 0.05 && (end.altitude_m - 80.0).abs() < 0.01);
    // A change in flight is flown at once.
    client.ask(&set("RTL_RADIUS", 50.0));
    client.ask(&set("RTL_ALTITUDE", 60.0));
    let end = *client.fly(120.0).last().unwrap();
    assert!((distance(&end) - 50.0).abs() < 0.05 && (end.altitude_m - 60.0).abs() < 0.01);
}

#[test]
fn the_bank_limit_widens_turns() {
    let turn_rate = |limit_deg: Option<f32>| {
        let mut client = Client::new(quiet());
        if let Some(limit_deg) = limit_deg {
            client.ask(&set("ROLL_LIMIT_DEG", limit_deg));
        }
        client.command_long(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, [0.0, 170.0, 1000.0]);
        client.fly(0.1).last().unwrap().course_rad / 0.1
    };
    // At 45 degrees of bank one g turns it: 10 m/s2 over 10 m/s.
    assert!((turn_rate(Some(45.0)) - 1.0).abs() < 1e-5);
    assert!(turn_rate(None) > 2.0);
}

#[test]
fn a_lost_ground_station_is_noticed_when_asked_for() {
    let mut client = Client::new(quiet());
    let hello = ground_heartbeat();
    client.ask(&hello);
    client.fly(20.0);
    assert!(!client.vehicle.is_in_failsafe(), "off by default");
    client.ask(&set("FS_GCS_ENABL", 1.0));
    client.ask(&set("FS_LONG_ACTN", 1.0));
    client.ask(&hello);
    client.fly(4.9);
    assert_eq!((client.vehicle.mode(), client.vehicle.is_in_failsafe()), (Mode::Guided, false));
    client.collect();
    client.fly(0.2);
    assert_eq!((client.vehicle.mode(), client.vehicle.is_in_failsafe()), (Mode::Rtl, true));
    assert_eq!(texts(&client.collect()), ["GCS Failsafe On: switched to RTL"]);
    assert_eq!(texts(&client.ask(&hello)), ["GCS Failsafe Cleared"]);
    assert_eq!((client.vehicle.mode(), client.vehicle.is_in_failsafe()), (Mode::Rtl, false));
    // Somebody else's heartbeat does not count.
    client.encoder = Encoder::new(254, 190);
    client.fly(5.1);
    client.ask(&hello);
    assert!(client.vehicle.is_in_failsafe());
}

#[test]
fn another_system_id_is_taken_at_once() {
    let mut client = Client::new(quiet());
    let headers = sent_on(&mut client, &set("MAV_SYSID", 42.0));
    assert!(headers.iter().all(|header| header.system_id == TARGET), "the answer comes from whom was asked");
    assert_eq!(client.ask(&read("MAV_SYSID", -1)), [], "which it is no longer");
    let to_all = PARAM_REQUEST_LIST_DATA::DEFAULT;
    assert_eq!(sent_on(&mut client, &Message::PARAM_REQUEST_LIST(to_all))[0].system_id, 42);
}

#[test]
fn what_was_set_before_is_so_from_the_start() {
    let kept_parameters = [("WP_LOITER_RAD".to_owned(), 33.0), ("MAV_SYSID".to_owned(), 9.0)].into_iter().collect();
    let mut client = Client::new(VehicleSettings { kept_parameters, ..quiet() });
    assert_eq!(client.vehicle.settings().system_id, 9);
    assert!(!client.vehicle.take_parameters_changed());
    assert_eq!(client.vehicle.set_parameters().count(), 2);
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]);
    for (name, value, words) in
        [("NOPE", 1.0, "No parameter NOPE"), ("MAV_SYSID", 0.0, "MAV_SYSID 0 is outside [1, 250]")]
    {
        let kept_parameters = [(name.to_owned(), value)].into_iter().collect();
        let settings = VehicleSettings { kept_parameters, ..quiet() };
        assert_eq!(Vehicle::new(settings).unwrap_err().to_string(), words);
    }
}

#[test]
fn a_client_of_the_first_version_is_answered_in_it() {
    let mut client = Client::new(quiet());
    client.encoder = Encoder::new(255, 190).with_version(Version::V1);
    let headers = sent_on(&mut client, &read("WP_LOITER_RAD", -1));
    assert!(headers.len() == 3 && headers.iter().all(|header| header.version == Version::V1));
    client.encoder = Encoder::new(255, 190);
    assert_eq!(sent_on(&mut client, &read("WP_LOITER_RAD", -1))[0].version, Version::V2);
}
