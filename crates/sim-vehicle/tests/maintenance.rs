//! Commands about the autopilot itself, and values that no command takes.
#![allow(clippy::unwrap_used, deprecated)]

mod common;

use common::{Client, TARGET, long, quiet, set_parameter, texts};
use mavlink_bridge::dialect::MavCmd::*;
use mavlink_bridge::dialect::MavResult::*;
use mavlink_bridge::dialect::{
    COMMAND_LONG_DATA, GPS_GLOBAL_ORIGIN_DATA, MavFrame, MavResult, Message, PositionTargetTypemask,
    SET_GPS_GLOBAL_ORIGIN_DATA, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
    TERRAIN_CHECK_DATA,
};
use mavlink_bridge::{Encoder, Version};
use sim_vehicle::{Mode, Personality, VehicleSettings};

const NAN: f32 = f32::NAN;

fn on_ground(personality: Personality) -> Client {
    Client::new(VehicleSettings { on_ground: true, personality, ..quiet() })
}

#[test]
fn a_reboot_keeps_parameters_and_nothing_else() {
    let mut client = on_ground(Personality::ArduPlane);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [0.0; 3]), Some(MAV_RESULT_UNSUPPORTED));
    client.ask(&set_parameter("WP_LOITER_RAD", 75.0));
    client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 15.0, 0.0]);
    client.command_long(MAV_CMD_SET_MESSAGE_INTERVAL, [30.0, 100_000.0, 0.0]);
    client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0]), Some(MAV_RESULT_FAILED));
    client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [0.0; 3]);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(client.vehicle.mode(), Mode::Manual);
    client.fly(2.0);
    assert_eq!(client.collect(), [], "the rates are those of the start");
    let kept: Vec<_> = client.vehicle.set_parameters().collect();
    assert_eq!(kept, [("WP_LOITER_RAD", 75.0)]);
}

#[test]
fn a_px4_reboots_when_disarmed() {
    let mut client = on_ground(Personality::Px4);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [0.0; 3]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0]), Some(MAV_RESULT_DENIED));
}

fn result_of(message: &Message) -> Option<MavResult> {
    match message {
        Message::COMMAND_ACK(ack) => Some(ack.result),
        _ => None,
    }
}

#[test]
fn calibration_is_for_the_ground_and_ends_a_drift() {
    let mut client = on_ground(Personality::ArduPlane);
    // The airspeed that is calibrated with the barometer takes a while, and another one must wait for it.
    let barometer = |client: &mut Client| client.command_long(MAV_CMD_PREFLIGHT_CALIBRATION, [0.0, 0.0, 1.0]);
    assert_eq!(barometer(&mut client), Some(MAV_RESULT_IN_PROGRESS));
    assert_eq!(barometer(&mut client), Some(MAV_RESULT_TEMPORARILY_REJECTED));
    client.fly(2.5);
    let followed: Vec<MavResult> = client.collect().iter().filter_map(result_of).collect();
    assert_eq!(followed, [MAV_RESULT_IN_PROGRESS, MAV_RESULT_ACCEPTED], "that it goes on, and that it is done");
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_CALIBRATION, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_CALIBRATION, [0.0; 3]), Some(MAV_RESULT_UNSUPPORTED));
    client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
    assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_CALIBRATION, [1.0, 0.0, 0.0]), Some(MAV_RESULT_FAILED));
}

#[test]
fn parameters_have_their_first_values_again_when_that_is_asked_for() {
    for (personality, p1, name, reboots) in
        [(Personality::ArduPlane, 2.0, "WP_LOITER_RAD", true), (Personality::Px4, 4.0, "NAV_LOITER_RAD", false)]
    {
        let mut client = on_ground(personality);
        let first = client.vehicle.set_parameters().count();
        client.ask(&set_parameter(name, 75.0));
        assert_eq!(client.vehicle.set_parameters().count(), first + 1);
        assert_eq!(client.command_long(MAV_CMD_PREFLIGHT_STORAGE, [p1, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
        assert_eq!(client.vehicle.set_parameters().count(), first + usize::from(reboots), "{personality}");
        client.command_long(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0]);
        assert_eq!(client.vehicle.set_parameters().count(), first, "{personality}");
    }
}

#[test]
fn the_poses_of_a_calibration_are_asked_for_one_after_the_other() {
    let mut client = on_ground(Personality::ArduPlane);
    let accelerometer = Message::COMMAND_LONG(COMMAND_LONG_DATA {
        command: MAV_CMD_PREFLIGHT_CALIBRATION,
        param5: 1.0,
        target_system: TARGET,
        ..COMMAND_LONG_DATA::DEFAULT
    });
    assert_eq!(texts(&client.ask(&accelerometer)), ["Place vehicle level and press any key."]);
}

#[test]
fn arming_check_says_which_checks_there_are() {
    let mut client = on_ground(Personality::ArduPlane);
    client.ask(&set_parameter("SIM_GPS_FAIL", 1.0));
    client.fly(1.0);
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), Some(MAV_RESULT_FAILED));
    client.ask(&set_parameter("ARMING_CHECK", 256.0));
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
}

#[test]
fn what_is_not_a_number_changes_nothing() {
    for personality in Personality::ALL {
        let mut client = Client::new(VehicleSettings { personality, ..quiet() });
        for (command, params) in [
            (MAV_CMD_COMPONENT_ARM_DISARM, [NAN, 21_196.0, 0.0]),
            (MAV_CMD_DO_FENCE_ENABLE, [NAN, 0.0, 0.0]),
            (MAV_CMD_DO_FENCE_ENABLE, [0.0, NAN, 0.0]),
            (MAV_CMD_DO_SET_HOME, [NAN, 0.0, 0.0]),
        ] {
            // To a PX4 what is not a number is left out, and home without a place is where the vehicle is.
            if personality == Personality::Px4 && command == MAV_CMD_DO_SET_HOME {
                continue;
            }
            let result = client.command_long(command, params).unwrap();
            assert!(
                matches!(result, MAV_RESULT_DENIED | MAV_RESULT_UNSUPPORTED),
                "{personality} {command:?} {result:?}"
            );
            assert!(client.vehicle.is_armed());
        }
    }
}

#[test]
fn a_tail_wind_makes_the_run_longer_and_no_more() {
    for wind_mps in [0.0f32, 6.0, 9.0] {
        let parameters = [("SIM_WIND_SPD", wind_mps), ("SIM_WIND_DIR", 180.0), ("SIM_WIND_TC", 0.0)];
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).to_vec();
        let mut client = Client::new(VehicleSettings { on_ground: true, default_parameters: parameters, ..quiet() });
        client.command_long(MAV_CMD_DO_SET_MODE, [1.0, 13.0, 0.0]);
        client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
        client.fly(60.0);
        assert!((client.vehicle.state().altitude_m - 50.0).abs() < 3.0, "in a wind of {wind_mps} m/s");
    }
}

#[test]
fn an_arduplane_takes_the_altitude_of_a_position_target_and_no_more() {
    let mut client = Client::new(quiet());
    let global = |alt: f32, coordinate_frame: MavFrame, mask: u16| {
        Message::SET_POSITION_TARGET_GLOBAL_INT(SET_POSITION_TARGET_GLOBAL_INT_DATA {
            target_system: TARGET,
            lat_int: 1,
            lon_int: 1,
            alt,
            coordinate_frame,
            type_mask: PositionTargetTypemask::from_bits_retain(mask),
            ..SET_POSITION_TARGET_GLOBAL_INT_DATA::DEFAULT
        })
    };
    let relative = MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT;
    client.collect();
    client.ask(&global(80.0, relative, 0x0DFB));
    assert_eq!(client.ask(&global(20.0, relative, 0x0DFC)), [], "z is left out");
    assert_eq!(texts(&client.ask(&global(80.0, MavFrame::MAV_FRAME_BODY_NED, 0x0DFB))).len(), 1);
    client.fly(30.0);
    let state = *client.vehicle.state();
    assert!((state.altitude_m - 80.0).abs() < 0.5 && state.course_rad.abs() < 1e-6);

    let offset = SET_POSITION_TARGET_LOCAL_NED_DATA {
        target_system: TARGET,
        z: -20.0,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_OFFSET_NED,
        type_mask: PositionTargetTypemask::from_bits_retain(0xFFF8),
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
    };
    let offset = Message::SET_POSITION_TARGET_LOCAL_NED(offset);
    assert_eq!(texts(&client.ask(&offset)), ["Change alt to 100.0"]);
    client.ask(&offset);
    client.fly(30.0);
    assert!((client.vehicle.state().altitude_m - 120.0).abs() < 0.5);
    client.collect();
    let mut said = Vec::new();
    for z in [NAN, f32::INFINITY, -1e30] {
        let beyond = SET_POSITION_TARGET_LOCAL_NED_DATA {
            target_system: TARGET,
            z,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_OFFSET_NED,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        };
        said.extend(texts(&client.ask(&Message::SET_POSITION_TARGET_LOCAL_NED(beyond))));
    }
    client.fly(10.0);
    assert_eq!(said, ["Setpoint refused: no such altitude"], "once for a stream of bad ones");
    assert!((client.vehicle.state().altitude_m - 120.0).abs() < 0.5);
}

#[test]
fn guided_commands_hold_for_ever_unless_a_time_is_set() {
    let mut client = Client::new(quiet());
    client.command_long(MAV_CMD_GUIDED_CHANGE_HEADING, [0.0, 90.0, 10.0]);
    client.fly(300.0);
    assert_eq!(client.vehicle.mode(), Mode::Guided);
    client.ask(&set_parameter("GUID_TIMEOUT", 5.0));
    client.fly(5.1);
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    assert!(texts(&client.collect()).contains(&"Failsafe: no setpoint for 5 s, LOITER".to_owned()));
}

#[test]
fn long_texts_are_whole_in_mavlink_2_and_cut_in_mavlink_1() {
    let whole = "Takeoff: set mode TAKEOFF, or AUTO with NAV_TAKEOFF";
    let mut client = Client::new(quiet());
    assert_eq!(texts(&client.ask(&long(TARGET, MAV_CMD_NAV_TAKEOFF, [0.0; 3]))), [whole]);
    client.address = common::peer(1);
    client.encoder = Encoder::new(255, 190).with_version(Version::V1);
    client.collect();
    assert_eq!(texts(&client.ask(&long(TARGET, MAV_CMD_NAV_TAKEOFF, [0.0; 3]))), [&whole[..50]]);
}

#[test]
fn mavlink_1_is_not_sent_what_it_cannot_carry() {
    let mut client = Client::new(quiet());
    client.encoder = Encoder::new(255, 190).with_version(Version::V1);
    let protocol_version = client.command_long(MAV_CMD_REQUEST_MESSAGE, [300.0, 0.0, 0.0]);
    assert_eq!(protocol_version, Some(MAV_RESULT_FAILED));
    let odometry = client.command_long(MAV_CMD_REQUEST_MESSAGE, [331.0, 0.0, 0.0]);
    assert_eq!(odometry, Some(MAV_RESULT_FAILED));
    assert_eq!(client.command_long(MAV_CMD_REQUEST_MESSAGE, [31.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
}

#[test]
fn who_sets_the_origin_of_a_px4_is_told_the_one_there_is() {
    let mut client = Client::new(VehicleSettings { personality: Personality::Px4, ..quiet() });
    let set = SET_GPS_GLOBAL_ORIGIN_DATA { target_system: TARGET, ..SET_GPS_GLOBAL_ORIGIN_DATA::DEFAULT };
    let answer = client.ask(&Message::SET_GPS_GLOBAL_ORIGIN(set));
    let is_ours = |data: &GPS_GLOBAL_ORIGIN_DATA| data.latitude == 399_800_000;
    assert!(matches!(answer.last(), Some(Message::GPS_GLOBAL_ORIGIN(data)) if is_ours(data)));
}

#[test]
fn a_px4_orbits_and_follows_sticks_while_they_are_held() {
    let mut client = Client::new(VehicleSettings { personality: Personality::Px4, ..quiet() });
    let above_sea = MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT;
    assert_eq!(client.command_int(MAV_CMD_DO_ORBIT, [-80.0, 0.0, 0.0], 120.0, above_sea), Some(MAV_RESULT_ACCEPTED));
    client.fly(60.0);
    // Its place is that of the command: latitude and longitude 0.
    assert_eq!(client.vehicle.mode(), Mode::Loiter);
    assert!((client.vehicle.state().altitude_m - 70.0).abs() < 0.5, "120 m above the sea, whatever the frame");
    let position = [1.0, 3.0, 0.0];
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, position), Some(MAV_RESULT_TEMPORARILY_REJECTED));
    let sticks = mavlink_bridge::dialect::MANUAL_CONTROL_DATA { target: TARGET, z: 500, ..Default::default() };
    client.ask(&Message::MANUAL_CONTROL(sticks));
    assert_eq!(client.command_long(MAV_CMD_DO_SET_MODE, position), Some(MAV_RESULT_ACCEPTED));
    client.fly(10.0);
    assert_eq!(client.vehicle.mode(), Mode::Rtl);
    assert!(texts(&client.collect()).contains(&"Failsafe activated: manual control lost".to_owned()));
}

#[test]
fn a_px4_takes_off_to_the_altitude_that_it_was_told_before_it_was_armed() {
    let mut client = on_ground(Personality::Px4);
    let frame = MavFrame::MAV_FRAME_GLOBAL;
    // The origin is 50 m above the sea.
    assert_eq!(client.command_int(MAV_CMD_NAV_TAKEOFF, [0.0; 3], 85.0, frame), Some(MAV_RESULT_ACCEPTED));
    assert_eq!(client.command_long(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]), Some(MAV_RESULT_ACCEPTED));
    client.fly(60.0);
    assert!((client.vehicle.state().altitude_m - 35.0).abs() < 2.5);
    client.collect();
    let low = client.command_int(MAV_CMD_NAV_TAKEOFF, [0.0; 3], 60.0, frame);
    assert_eq!(low, Some(MAV_RESULT_ACCEPTED));
}

#[test]
fn what_stands_against_arming_is_said_unasked_every_half_minute() {
    let mut client = on_ground(Personality::ArduPlane);
    client.ask(&set_parameter("SIM_GPS_FAIL", 1.0));
    client.fly(75.0);
    let said: Vec<String> = texts(&client.collect()).into_iter().filter(|text| text.starts_with("PreArm")).collect();
    assert_eq!(said, ["PreArm: GPS 1: Bad fix"; 3]);
}

#[test]
fn terrain_is_told_of_a_place_by_an_arduplane() {
    let check = Message::TERRAIN_CHECK(TERRAIN_CHECK_DATA { lat: 473_000_000, lon: 85_000_000 });
    let mut client = on_ground(Personality::ArduPlane);
    let told = client.ask(&check);
    assert!(
        told.iter().any(|message| matches!(message, Message::TERRAIN_REPORT(report)
            if (report.lat, report.lon) == (473_000_000, 85_000_000))),
        "{told:?}"
    );
    let told = on_ground(Personality::Px4).ask(&check);
    assert!(!told.iter().any(|message| matches!(message, Message::TERRAIN_REPORT(_))), "{told:?}");
}

#[test]
fn a_calibration_in_poses_leaves_no_room_for_another_of_the_accelerometer() {
    let mut client = on_ground(Personality::ArduPlane);
    let mut calibrate = |param5: f32| {
        client.ask(&Message::COMMAND_LONG(COMMAND_LONG_DATA {
            param5,
            command: MAV_CMD_PREFLIGHT_CALIBRATION,
            target_system: TARGET,
            ..COMMAND_LONG_DATA::DEFAULT
        }))
    };
    for (kind, expected) in [
        (4.0, MAV_RESULT_ACCEPTED),
        (1.0, MAV_RESULT_ACCEPTED),
        (2.0, MAV_RESULT_TEMPORARILY_REJECTED),
        (4.0, MAV_RESULT_TEMPORARILY_REJECTED),
        (76.0, MAV_RESULT_ACCEPTED),
    ] {
        let told = calibrate(kind);
        let result = told.iter().find_map(|message| match message {
            Message::COMMAND_ACK(ack) => Some(ack.result),
            _ => None,
        });
        assert_eq!(result, Some(expected), "{kind}: {told:?}");
    }
}
