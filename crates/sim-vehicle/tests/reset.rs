//! USER_1 with param 1 = 1: one vehicle as it was when the program started.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Client, TARGET, peer, quiet, set_parameter};
use mavlink_bridge::dialect::MavCmd::{MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_SET_MODE, MAV_CMD_USER_1};
use mavlink_bridge::dialect::MavResult::{MAV_RESULT_ACCEPTED, MAV_RESULT_FAILED, MAV_RESULT_UNSUPPORTED};
use mavlink_bridge::dialect::{COMMAND_LONG_DATA, Message};
use sim_vehicle::{LockstepSettings, Mode, PeerId, Personality, Vehicle, VehicleSettings};
use std::collections::BTreeSet;

fn flown(settings: VehicleSettings) -> Client {
    let mut client = Client::new(settings);
    client.ask(&set_parameter("WP_LOITER_RAD", 75.0));
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 12.0, 0.0]);
    client.fly(20.0);
    client
}

#[test]
fn it_is_where_it_started_and_its_time_goes_on() {
    let settings = VehicleSettings { default_parameters: vec![("RTL_RADIUS".to_owned(), 70.0)], ..quiet() };
    let start = settings.start;
    let mut client = flown(settings);
    assert!(client.vehicle.mode() == Mode::Loiter && client.vehicle.state().x_m != start.x_m);
    let time = client.vehicle.time();
    assert_eq!(client.command_long(MAV_CMD_USER_1, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!((client.vehicle.mode(), *client.vehicle.state(), client.vehicle.time()), (Mode::Guided, start, time));
    assert_eq!(client.vehicle.set_parameters().count(), 0, "what was set is gone");
    assert!(client.vehicle.take_parameters_changed(), "and the state folder is told");
    client.fly(1.0);
    assert!(client.vehicle.time() > time && (client.vehicle.state().x_m - start.x_m - start.speed_mps).abs() < 0.5);
}

#[test]
fn param_2_keeps_parameters() {
    let mut client = flown(quiet());
    assert_eq!(client.command_long(MAV_CMD_USER_1, [1.0, 1.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(client.vehicle.set_parameters().collect::<Vec<_>>(), [("WP_LOITER_RAD", 75.0)]);
    assert_eq!(client.vehicle.mode(), Mode::Guided);
}

#[test]
fn on_the_ground_it_is_disarmed_again() {
    for personality in [Personality::ArduPlane, Personality::Px4, Personality::Generic] {
        let mut client = Client::new(VehicleSettings { on_ground: true, personality, ..quiet() });
        client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
        assert!(client.vehicle.is_armed(), "{personality}");
        assert_eq!(client.command_long(MAV_CMD_USER_1, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
        assert!(!client.vehicle.is_armed(), "{personality}");
    }
}

#[test]
fn all_peers_are_greeted_anew() {
    let mut client = Client::new(quiet());
    client.ask(&set_parameter("RTL_RADIUS", 50.0));
    let reset = COMMAND_LONG_DATA {
        command: MAV_CMD_USER_1,
        param1: 1.0,
        target_system: TARGET,
        target_component: 1,
        ..COMMAND_LONG_DATA::DEFAULT
    };
    let datagram = client.encode(&Message::COMMAND_LONG(reset));
    client.vehicle.handle(client.vehicle.time(), &datagram, peer(40_001));
    let told: BTreeSet<PeerId> = std::iter::from_fn(|| client.vehicle.poll_transmit()).map(|sent| sent.to).collect();
    assert_eq!(told, BTreeSet::from([peer(40_000), peer(40_001)]));
}

#[test]
fn any_other_param_is_unsupported_and_simulated_time_knows_no_reset() {
    let mut client = flown(quiet());
    for which in [0.0, 2.0, f32::NAN] {
        assert_eq!(client.command_long(MAV_CMD_USER_1, [which, 0.0, 0.0]), Some(MAV_RESULT_UNSUPPORTED));
    }
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    client.vehicle = Vehicle::in_lockstep(quiet(), LockstepSettings::default()).unwrap();
    assert_eq!(client.command_long(MAV_CMD_USER_1, [1.0, 0.0, 0.0]), Some(MAV_RESULT_FAILED));
}
