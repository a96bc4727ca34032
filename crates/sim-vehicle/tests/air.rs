//! Wind and gusts: what is held in them, what is said of them.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Client, TARGET, long, quiet, texts};
use flight_model::{Setpoint, State, wrap_pi};
use mavlink_bridge::dialect::{MavCmd, MavFrame, MavResult, Message};
use mavlink_bridge::{Target, local_ned_setpoint};
use sim_vehicle::{Mode, VehicleSettings};
use std::f64::consts::FRAC_PI_2;
use std::time::Duration;

/// In GUIDED northwards at 10 m/s, in a wind that has been there for long.
fn in_wind(speed_mps: f32, from_deg: f32, gusts_mps: f32) -> Client {
    let parameters =
        [("SIM_WIND_SPD", speed_mps), ("SIM_WIND_DIR", from_deg), ("SIM_WIND_TURB", gusts_mps), ("SIM_WIND_TC", 0.0)];
    let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let mut client = Client::new(VehicleSettings {
        default_parameters: parameters,
        setpoint_timeout_s: 0.0,
        seed: 5,
        number: 3,
        ..quiet()
    });
    client.fly(20.0);
    client
}

fn request(client: &mut Client, id: f32) -> Vec<Message> {
    client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [id, 0.0, 0.0]))
}

fn hud(client: &mut Client) -> (f64, f64, i16) {
    let answer = request(client, 74.0);
    let hud = answer.iter().find_map(|message| match message {
        Message::VFR_HUD(hud) => Some((f64::from(hud.airspeed), f64::from(hud.groundspeed), hud.heading)),
        _ => None,
    });
    hud.unwrap()
}

fn wind_cov(client: &mut Client) -> (f64, f64) {
    let answer = request(client, 231.0);
    let wind = answer.iter().find_map(|message| match message {
        Message::WIND_COV(wind) => Some((f64::from(wind.wind_x), f64::from(wind.wind_y))),
        _ => None,
    });
    wind.unwrap()
}

#[test]
fn across_the_wind_the_course_is_held_and_the_airspeed_too() {
    let mut client = in_wind(6.0, 90.0, 0.0);
    for state in client.fly(10.0) {
        assert!(state.course_rad.to_degrees().abs() < 0.01, "{}", state.course_rad.to_degrees());
        assert!((state.speed_mps - 8.0).abs() < 1e-3); // 6, 8, 10
    }
    let (airspeed, ground_speed, heading) = hud(&mut client);
    assert!((airspeed - 10.0).abs() < 1e-3 && (ground_speed - 8.0).abs() < 1e-3);
    assert_eq!(heading, 36); // asin(0.6)
    let (north, east) = wind_cov(&mut client);
    assert!(north.abs() < 0.01 && (east + 6.0).abs() < 0.01);
}

#[test]
fn gusts_and_noise_leave_course_and_estimate_within_their_bounds() {
    let mut client = in_wind(6.0, 90.0, 1.0);
    let track = client.fly(120.0);
    let worst = track.iter().map(|state| state.course_rad.to_degrees().abs()).fold(0.0, f64::max);
    assert!(worst < 1.0, "{worst}");
    let off_m = track.iter().map(|state| (state.altitude_m - 50.0).abs()).fold(0.0, f64::max);
    assert!(off_m > 0.01 && off_m < 2.0, "{off_m}");
    let speeds: Vec<f64> = track.iter().map(|state| state.speed_mps).collect();
    let spread = speeds.iter().copied().fold(0.0, f64::max) - speeds.iter().copied().fold(99.0, f64::min);
    assert!(spread > 0.5, "{spread}");
    let (north, east) = wind_cov(&mut client);
    assert!(north.abs() < 0.6 && (east + 6.0).abs() < 0.6);
}

#[test]
fn a_course_step_in_wind_settles_as_in_still_air() {
    let mut client = in_wind(6.0, 90.0, 0.0);
    let ack = client.command_int(
        MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING,
        [0.0, 135.0, 50.0],
        0.0,
        MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
    );
    assert_eq!(ack, Some(MavResult::MAV_RESULT_ACCEPTED));
    let end = client.fly(10.0).pop().unwrap();
    assert!((end.course_rad.to_degrees() - 135.0).abs() < 0.01, "{}", end.course_rad.to_degrees());
}

#[test]
fn a_heading_is_held_and_drifts() {
    let mut client = in_wind(6.0, 90.0, 0.0);
    let frame = MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT;
    client.command_int(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, [1.0, 0.0, 50.0], 0.0, frame);
    let end = client.fly(20.0).pop().unwrap();
    assert_eq!(hud(&mut client).2, 0);
    assert!((end.course_rad - libm::atan2(-6.0, 10.0)).abs() < 1e-3);
}

#[test]
fn a_velocity_is_over_ground() {
    let mut client = in_wind(6.0, 90.0, 0.0);
    let target = Target { system_id: TARGET, component_id: 1 };
    let setpoint = Setpoint { speed_mps: 9.0, course_rad: FRAC_PI_2, altitude_m: 50.0 };
    client.ask(&local_ned_setpoint(Duration::ZERO, target, &setpoint));
    let end = client.fly(20.0).pop().unwrap();
    assert!((end.speed_mps - 9.0).abs() < 1e-3 && (end.course_rad - FRAC_PI_2).abs() < 1e-4);
    assert!((hud(&mut client).0 - 15.0).abs() < 1e-3);
    // Faster than the airspeed allows: as fast as it goes, on the same course.
    let fast = Setpoint { speed_mps: 14.0, ..setpoint };
    client.ask(&local_ned_setpoint(Duration::ZERO, target, &fast));
    let end = client.fly(20.0).pop().unwrap();
    assert!((end.speed_mps - 9.0).abs() < 1e-3 && (end.course_rad - FRAC_PI_2).abs() < 1e-4);
}

#[test]
fn circles_stay_round() {
    let mut client = in_wind(6.0, 200.0, 0.0);
    client.command_long(MavCmd::MAV_CMD_NAV_LOITER_UNLIM, [0.0; 3]);
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    let centre = *client.vehicle.state();
    let from_centre = |state: &State| {
        let (north, east) = (state.x_m - centre.x_m, state.y_m - centre.y_m);
        (north * north + east * east).sqrt()
    };
    client.fly(90.0);
    for state in client.fly(120.0) {
        assert!((from_centre(&state) - 60.0).abs() < 3.0, "{}", from_centre(&state));
    }
}

#[test]
fn a_wind_too_strong_is_said_to_be_and_leaves_it_flying() {
    let mut client = in_wind(0.0, 0.0, 0.0);
    let set = |client: &mut Client, value| {
        client.ask(&common::set_parameter("SIM_WIND_SPD", value));
        client.fly(20.0);
        texts(&client.collect())
    };
    let words = set(&mut client, 20.0);
    assert!(words.len() == 1 && words[0].contains("too strong"), "{words:?}");
    assert!(client.vehicle.state().is_finite());
    assert!((wrap_pi(client.vehicle.state().course_rad).abs() - std::f64::consts::PI).abs() < 1e-6);
    let words = set(&mut client, 3.0);
    assert!(words[0].ends_with("course held again"), "{words:?}");
    assert!(client.vehicle.state().course_rad.abs() < 1e-6);
}

#[test]
fn each_vehicle_has_its_own_gusts_and_each_run_the_same() {
    let fly = |seed, number| {
        let parameters = vec![("SIM_WIND_TURB".to_owned(), 1.0)];
        Client::new(VehicleSettings { default_parameters: parameters, seed, number, ..quiet() }).fly(5.0)
    };
    assert_eq!(fly(1, 1), fly(1, 1));
    assert_ne!(fly(1, 1), fly(1, 2));
    assert_ne!(fly(1, 1), fly(2, 1));
}
