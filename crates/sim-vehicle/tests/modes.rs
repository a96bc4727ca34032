//! TAKEOFF and DO_REPOSITION.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Client, TARGET, acknowledgement, quiet};
use flight_model::State;
use mavlink_bridge::dialect::MavCmd::{MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_REPOSITION, MAV_CMD_DO_SET_MODE};
use mavlink_bridge::dialect::MavResult::{self, *};
use mavlink_bridge::dialect::{COMMAND_INT_DATA, MavFrame, Message};
use sim_vehicle::{Mode, VehicleSettings};

fn reposition(client: &mut Client, [north_m, east_m]: [f64; 2], z: f32, params: [f32; 4]) -> MavResult {
    let place = quiet().frame.to_geodetic(north_m, east_m, 0.0);
    let data = COMMAND_INT_DATA {
        param1: params[0],
        param2: params[1],
        param3: params[2],
        param4: params[3],
        x: (place.latitude_deg * 1e7).round() as i32,
        y: (place.longitude_deg * 1e7).round() as i32,
        z,
        command: MAV_CMD_DO_REPOSITION,
        target_system: TARGET,
        frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
        ..COMMAND_INT_DATA::DEFAULT
    };
    acknowledgement(&client.ask(&Message::COMMAND_INT(data))).unwrap().result
}

fn distance(state: &State, [north_m, east_m]: [f64; 2]) -> f64 {
    ((state.x_m - north_m) * (state.x_m - north_m) + (state.y_m - east_m) * (state.y_m - east_m)).sqrt()
}

#[test]
fn a_place_is_circled_as_asked_and_the_timeout_does_not_run() {
    let mut client = Client::new(quiet());
    let place = [300.0, -100.0];
    assert_eq!(reposition(&mut client, place, 80.0, [-1.0, 0.0, 45.0, 1.0]), MAV_RESULT_ACCEPTED);
    let end = *client.fly(120.0).last().unwrap();
    assert!((distance(&end, place) - 45.0).abs() < 0.1 && (end.altitude_m - 80.0).abs() < 0.01);
    let north = end.x_m - place[0];
    let east = end.y_m - place[1];
    let anticlockwise = north * libm::sin(end.course_rad) - east * libm::cos(end.course_rad) < 0.0;
    assert!(anticlockwise);
    assert_eq!(client.vehicle.mode(), Mode::Guided);
    // Outside GUIDED only with the flag.
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 7.0, 0.0]);
    assert_eq!(reposition(&mut client, place, 80.0, [-1.0, 0.0, 0.0, f32::NAN]), MAV_RESULT_FAILED);
    for (z, radius_m) in [(f32::NAN, 0.0), (0.0, 0.0)] {
        assert_eq!(reposition(&mut client, place, z, [-1.0, 1.0, radius_m, 0.0]), MAV_RESULT_DENIED);
    }
    assert_eq!(client.vehicle.mode(), Mode::Cruise);
    assert_eq!(client.command_long(MAV_CMD_DO_REPOSITION, [0.0, 1.0, 0.0]), Some(MAV_RESULT_UNSUPPORTED));
}

#[test]
fn takeoff_climbs_to_its_altitude_and_circles_there() {
    let start = State { altitude_m: 5.0, ..quiet().start };
    let mut client = Client::new(VehicleSettings { armed: false, start, ..quiet() });
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 13.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    client.fly(5.0);
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    let track = client.fly(120.0);
    let up = track.iter().find(|state| state.altitude_m >= 48.0).unwrap();
    assert!(up.y_m.abs() < 1e-9, "straight on");
    let end = track.last().unwrap();
    assert!((end.altitude_m - 50.0).abs() < 0.01 && (distance(end, [up.x_m, up.y_m]) - 60.0).abs() < 0.3);
    assert_eq!(client.vehicle.mode(), Mode::Takeoff);
}
