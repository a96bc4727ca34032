//! Each encoder against what its autopilot was measured to follow.

use super::*;
use crate::dialect::{COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, MavFrame, SET_POSITION_TARGET_LOCAL_NED_DATA};
use proptest::prelude::*;

const TARGET: Target = Target { system_id: 7, component_id: 1 };
const ORIGIN: Geodetic = Geodetic { latitude_deg: -35.36, longitude_deg: 149.16, altitude_amsl_m: 584.0 };
const OLD_PX4: Option<SoftwareVersion> = Some(SoftwareVersion { major: 1, minor: 17, patch: 4 });
const NEW_PX4: Option<SoftwareVersion> = Some(SoftwareVersion { major: 1, minor: 18, patch: 0 });

fn dynamics() -> Dynamics {
    let mut dynamics = Dynamics::default();
    dynamics.limits.lateral_overload_max = 0.7;
    dynamics
}

fn messages(driver: &Driver, setpoint: &Setpoint) -> Result<Vec<Message>, SetpointError> {
    messages_with(driver, setpoint, Some(570.0), 0.0)
}

fn messages_with(
    driver: &Driver,
    setpoint: &Setpoint,
    local_origin_amsl_m: Option<f64>,
    airspeed_excess_mps: f64,
) -> Result<Vec<Message>, SetpointError> {
    let (frame, dynamics) = (LocalFrame::new(ORIGIN), dynamics());
    let situation = Situation { local_origin_amsl_m, airspeed_excess_mps, ..situation(&frame, &dynamics) };
    driver.setpoint(TARGET, setpoint, &situation)
}

fn situation<'a>(frame: &'a LocalFrame, dynamics: &'a Dynamics) -> Situation<'a> {
    Situation {
        state: State { altitude_m: 48.0, speed_mps: 19.0, ..State::default() },
        frame,
        local_origin_amsl_m: Some(570.0),
        dynamics,
        airspeed_excess_mps: 0.0,
        speed_demand_mps: None,
        drift_mps: Vector2::zeros(),
        now: Duration::from_secs(3),
    }
}

fn setpoint(speed_mps: f64, course_deg: f64, altitude_m: f64) -> Setpoint {
    Setpoint { speed_mps, course_rad: course_deg.to_radians(), altitude_m }
}

fn int(message: &Message) -> &COMMAND_INT_DATA {
    match message {
        Message::COMMAND_INT(data) => data,
        other => panic!("{other:?}"),
    }
}

fn long(message: &Message) -> &COMMAND_LONG_DATA {
    match message {
        Message::COMMAND_LONG(data) => data,
        other => panic!("{other:?}"),
    }
}

fn target(message: &Message) -> &SET_POSITION_TARGET_LOCAL_NED_DATA {
    match message {
        Message::SET_POSITION_TARGET_LOCAL_NED(data) => data,
        other => panic!("{other:?}"),
    }
}

#[test]
fn arduplane_takes_three_commands() {
    let driver = Driver::new(AutopilotKind::ArduPlane, None);
    let sent = messages_with(&driver, &setpoint(20.0, -10.0, 50.0), None, -1.25).unwrap();
    let [course, speed, altitude] = &sent[..] else { panic!("{sent:?}") };
    let course = int(course);
    assert_eq!(course.command, MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING);
    assert_eq!((course.param1, course.param3), (0.0, 7.0), "over ground; n_max g of the model");
    assert!((course.param2 - 350.0).abs() < 1e-4);
    let speed = int(speed);
    assert_eq!(speed.command, MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED);
    assert_eq!((speed.param1, speed.param2, speed.param3), (0.0, 18.75, 0.0), "equivalent airspeed, at once");
    let altitude = int(altitude);
    assert_eq!(altitude.command, MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE);
    assert_eq!((altitude.frame, altitude.z, altitude.param3), (MavFrame::MAV_FRAME_GLOBAL, 634.0, 0.0));
    assert!(sent.iter().all(|message| int(message).target_system == 7));
}

#[test]
fn arduplane_is_told_to_change_its_speed_as_gently_as_the_change_is_small() {
    let mut dynamics = dynamics();
    dynamics.response.acceleration_max_mps2 = 0.4;
    let frame = LocalFrame::new(ORIGIN);
    let situation = Situation { speed_demand_mps: Some(19.0), ..situation(&frame, &dynamics) };
    let driver = Driver::new(AutopilotKind::ArduPlane, None);
    // The model's own limit, a quarter of the change in a second, and the least: in whole steps of 0.1 m/s2, half a
    // step more where the demand rises, and less where it falls.
    for (speed_mps, acceleration_mps2) in [(14.0, 0.35), (18.2, 0.15), (19.8, 0.25), (19.1, 0.15), (18.9, 0.05)] {
        let sent = driver.setpoint(TARGET, &setpoint(speed_mps, 0.0, 50.0), &situation).unwrap();
        let speed = int(&sent[1]);
        assert_eq!((speed.command, speed.param3), (MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED, acceleration_mps2));
    }
}

#[test]
fn arduplane_is_never_sent_an_altitude_that_kills_it() {
    let driver = Driver::new(AutopilotKind::ArduPlane, None);
    for altitude_m in [-584.0, -585.0, -584.004, -583.996] {
        let sent = messages(&driver, &setpoint(20.0, 0.0, altitude_m)).unwrap();
        let z = int(&sent[2]).z;
        assert!(z.abs() >= 0.01 && z != -1.0 && z != 0.0, "{z}");
    }
}

#[test]
fn arducopter_takes_velocities_and_holds_altitude_by_them() {
    let sent = messages(&Driver::new(AutopilotKind::ArduCopter, None), &setpoint(4.0, 90.0, 50.0)).unwrap();
    let [message] = &sent[..] else { panic!("{sent:?}") };
    let data = target(message);
    assert_eq!((data.type_mask.bits(), data.coordinate_frame), (0xDC7, MavFrame::MAV_FRAME_LOCAL_NED));
    assert!(data.vx.abs() < 1e-6 && (data.vy - 4.0).abs() < 1e-6);
    assert_eq!(data.vz, -2.0, "2 m too low: 2 m/s up");
    let far_below = messages(&Driver::new(AutopilotKind::ArduCopter, None), &setpoint(4.0, 90.0, 90.0)).unwrap();
    assert_eq!(target(&far_below[0]).vz, -6.0, "the model's climb");
}

#[test]
fn px4_multicopters_take_velocity_and_altitude_above_their_own_origin() {
    let driver = Driver::new(AutopilotKind::Px4Multicopter, None);
    let sent = messages(&driver, &setpoint(10.0, 0.0, 50.0)).unwrap();
    let data = target(&sent[0]);
    assert_eq!((data.type_mask.bits(), data.coordinate_frame), (0xDE3, MavFrame::MAV_FRAME_LOCAL_NED));
    assert_eq!(data.z, -64.0, "584 + 50 above the sea, the origin at 570");
    assert_eq!((data.target_component, data.vx), (1, 10.0));
    assert_eq!(messages_with(&driver, &setpoint(10.0, 0.0, 50.0), None, 0.0), Err(SetpointError::OriginUnknown));
}

#[test]
fn px4_multicopters_are_told_the_velocity_that_brings_their_position_onto_the_course() {
    let (frame, dynamics) = (LocalFrame::new(ORIGIN), dynamics());
    let situation = Situation { drift_mps: Vector2::new(-0.3, 0.5), ..situation(&frame, &dynamics) };
    let driver = Driver::new(AutopilotKind::Px4Multicopter, None);
    let sent = driver.setpoint(TARGET, &setpoint(10.0, 90.0, 50.0), &situation).unwrap();
    let data = target(&sent[0]);
    assert!((data.vx - 0.3).abs() < 1e-6 && (data.vy - 9.5).abs() < 1e-6, "{} {}", data.vx, data.vy);
}

#[test]
fn px4_planes_take_commands_in_guided_course() {
    let sent = messages(&Driver::new(AutopilotKind::Px4FixedWing, NEW_PX4), &setpoint(14.0, 30.0, 50.0)).unwrap();
    let [course, speed, altitude] = &sent[..] else { panic!("{sent:?}") };
    let (course, speed, altitude) = (long(course), long(speed), long(altitude));
    assert_eq!((course.command, course.param1, course.param3), (MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, 0.0, 0.0));
    assert!((course.param2 - 30.0).abs() < 1e-4);
    assert_eq!((speed.command, speed.param1, speed.param2), (MavCmd::MAV_CMD_DO_CHANGE_SPEED, 0.0, 14.0));
    assert_eq!((altitude.command, altitude.param1), (MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE, 634.0));
    // A param that is not used and neither zero nor NaN is denied.
    assert!(sent.iter().all(|message| long(message).param4 == 0.0 && long(message).param7 == 0.0));
}

#[test]
fn older_px4_planes_fly_to_a_place_far_ahead() {
    let driver = Driver::new(AutopilotKind::Px4FixedWing, OLD_PX4);
    assert_eq!(driver.mode_name(driver.flying_mode()), "Hold");
    let sent = messages(&driver, &setpoint(14.0, 0.0, 50.0)).unwrap();
    let data = int(&sent[0]);
    assert_eq!((data.command, data.param1, data.param2), (MavCmd::MAV_CMD_DO_REPOSITION, 14.0, 1.0));
    assert_eq!((data.z, data.y), (634.0, 1_491_600_000), "above mean sea level, due north");
    let north_m = f64::from(data.x - -353_600_000) * 1e-7 * 110_940.0;
    assert!((north_m - 3000.0).abs() < 10.0, "{north_m}");
    assert_eq!(driver.repeat_every(), Some(Duration::from_millis(500)));
    assert_eq!(Driver::new(AutopilotKind::Px4FixedWing, None).flying_mode(), driver.flying_mode());
}

#[test]
fn what_cannot_be_flown_is_refused_by_name() {
    let refused = |autopilot, vehicle| AutopilotKind::identify(autopilot, vehicle).unwrap_err().to_string();
    let rover = refused(MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA, MavType::MAV_TYPE_GROUND_ROVER);
    assert!(rover.starts_with("ardupilotmega on a ground rover cannot be flown"), "{rover}");
    let vtol = refused(MavAutopilot::MAV_AUTOPILOT_PX4, MavType::MAV_TYPE_VTOL_TILTROTOR);
    assert!(vtol.contains("px4 on a vtol tiltrotor"), "{vtol}");
    assert!(AutopilotKind::identify(MavAutopilot::MAV_AUTOPILOT_PPZ, MavType::MAV_TYPE_FIXED_WING).is_err());
}

#[test]
fn no_kind_has_the_number_of_anothers_mode() {
    let copter = Driver::new(AutopilotKind::ArduCopter, None);
    assert_eq!((copter.flying_mode(), copter.mode_name(15)), (4, "AUTOTUNE".to_owned()));
    assert_eq!(copter.mode_name(copter.end_mode(AtEnd::Loiter).unwrap()), "BRAKE");
    let plane = Driver::new(AutopilotKind::ArduPlane, None);
    assert_eq!(plane.mode_name(plane.end_mode(AtEnd::Loiter).unwrap()), "LOITER");
    assert_eq!(plane.end_mode(AtEnd::Continue), None);
    let px4 = Driver::new(AutopilotKind::Px4FixedWing, NEW_PX4);
    assert_eq!((px4.flying_mode(), px4.mode_name(px4.flying_mode())), (0x1304_0000, "Guided Course".to_owned()));
}

/// Follows a launch as an obedient vehicle would, and tells what was sent.
fn launched(driver: &Driver, mut seen: Seen) -> Vec<String> {
    let mut sent = Vec::new();
    for _ in 0..20 {
        match driver.launch(TARGET, &seen, 50.0) {
            Launch::Flying => return sent,
            Launch::Wait => (seen.height_m, seen.climb_mps, seen.on_ground) = (50.0, 0.0, false),
            Launch::Send(message) => {
                let command = long(&message);
                match command.command {
                    MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => seen.armed = true,
                    MavCmd::MAV_CMD_NAV_TAKEOFF => (seen.climb_mps, seen.on_ground) = (2.0, false),
                    MavCmd::MAV_CMD_DO_SET_MODE if driver.kind().name().starts_with("PX4") => {
                        seen.custom_mode = (command.param2 as u32) << 16 | (command.param3 as u32) << 24;
                    }
                    _ => seen.custom_mode = command.param2 as u32,
                }
                sent.push(match command.command {
                    MavCmd::MAV_CMD_DO_SET_MODE => driver.mode_name(seen.custom_mode),
                    MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => "arm".to_owned(),
                    _ => "take off".to_owned(),
                });
            }
        }
    }
    panic!("it never flies: {sent:?}");
}

#[test]
fn each_kind_takes_off_in_its_own_way() {
    let on_ground = Seen { on_ground: true, ..Seen::default() };
    for (kind, version, wanted) in [
        (AutopilotKind::ArduPlane, None, &["TAKEOFF", "arm", "GUIDED"][..]),
        (AutopilotKind::ArduCopter, None, &["GUIDED", "arm", "take off"]),
        (AutopilotKind::Px4Multicopter, None, &["Takeoff", "arm", "Offboard"]),
        (AutopilotKind::Px4FixedWing, NEW_PX4, &["Takeoff", "arm", "Guided Course"]),
        (AutopilotKind::Px4FixedWing, OLD_PX4, &["Takeoff", "arm", "Hold"]),
        (AutopilotKind::Columba, None, &["arm", "take off", "GUIDED"]),
    ] {
        assert_eq!(launched(&Driver::new(kind, version), on_ground), wanted, "{kind:?}");
    }
    let waiting = Seen { height_m: 50.0, custom_mode: 15, ..Seen::default() };
    assert_eq!(launched(&Driver::new(AutopilotKind::ArduPlane, None), waiting), ["arm"], "in the air, and not armed");
}

proptest! {
    #[test]
    fn numbers_are_finite_or_refused(
        speed in prop::num::f64::ANY, course in prop::num::f64::ANY, altitude in prop::num::f64::ANY,
    ) {
        let asked = Setpoint { speed_mps: speed, course_rad: course, altitude_m: altitude };
        for (kind, version) in [
            (AutopilotKind::ArduPlane, None),
            (AutopilotKind::ArduCopter, None),
            (AutopilotKind::Px4Multicopter, None),
            (AutopilotKind::Px4FixedWing, NEW_PX4),
            (AutopilotKind::Columba, None),
        ] {
            for message in messages(&Driver::new(kind, version), &asked).unwrap_or_default() {
                let numbers = match &message {
                    Message::COMMAND_INT(data) => vec![data.param1, data.param2, data.param3, data.param4, data.z],
                    Message::COMMAND_LONG(data) => vec![data.param1, data.param2, data.param3],
                    Message::SET_POSITION_TARGET_LOCAL_NED(data) => vec![data.vx, data.vy, data.vz, data.z],
                    _ => vec![f32::NAN],
                };
                prop_assert!(numbers.iter().all(|number| number.is_finite()), "{message:?}");
            }
        }
    }

    #[test]
    fn courses_are_compass_courses(course in -1e4..1e4f64) {
        let asked = Setpoint { speed_mps: 20.0, course_rad: course, altitude_m: 50.0 };
        let sent = messages(&Driver::new(AutopilotKind::ArduPlane, None), &asked).unwrap();
        prop_assert!((0.0..360.0).contains(&int(&sent[0]).param2));
    }
}
