//! Setpoints as messages for an autopilot, and back.

use crate::Target;
use crate::dialect::{
    COMMAND_INT_DATA, MavCmd, MavFrame, Message, PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use crate::telemetry::{boot_ms, down, speed_and_course, up, wire_velocity};
use flight_model::Setpoint;
use nalgebra::Vector2;
use std::time::Duration;

/// The type mask of [`local_ned_setpoint`]: vx, vy and z are set, all else is ignored.
pub const VELOCITY_AND_ALTITUDE_MASK: u16 = 0x0DE3;

/// What [`local_ned_setpoint`] sends for speeds of less than half of it, m/s: a velocity of zero would have no course.
pub const SPEED_MIN_MPS: f64 = 1.0 / 1024.0;

/// What a SET_POSITION_TARGET_LOCAL_NED asks of a vehicle: velocity, altitude, or both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartialSetpoint {
    /// Horizontal velocity (north, east), m/s.
    pub velocity: Option<Vector2<f64>>,
    /// Altitude above the origin, m.
    pub altitude: Option<f64>,
}

/// Why a setpoint cannot be followed or sent.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SetpointError {
    /// The coordinate frame is not MAV_FRAME_LOCAL_NED.
    #[error("the coordinate frame {0:?} is not followed")]
    Frame(MavFrame),
    /// The type mask asks for something else than vx with vy, or z, or all three.
    #[error("the type mask {0:#06x} is not followed")]
    Mask(u16),
    /// A field that is asked for is not a finite number.
    #[error("a field is not a finite number")]
    NotFinite,
    /// The altitude of the vehicle's local origin is not known, and so neither is what an altitude means to it.
    #[error("the altitude of the vehicle's local origin is not known")]
    OriginUnknown,
}

/// SET_POSITION_TARGET_LOCAL_NED with velocity and altitude, for PX4 multicopters in OFFBOARD and for lockstep, where
/// `time_boot` is the stamp (<https://mavlink.io/en/messages/common.html#SET_POSITION_TARGET_LOCAL_NED>).
///
/// A speed of zero or less is sent as [`SPEED_MIN_MPS`], to keep the course. Numbers that are not finite are sent as
/// they are, and [`setpoint_from_local_ned`] rejects them.
pub fn local_ned_setpoint(time_boot: Duration, target: Target, setpoint: &Setpoint) -> Message {
    Message::SET_POSITION_TARGET_LOCAL_NED(local_ned_data(boot_ms(time_boot), target, setpoint))
}

/// The setpoint in a SET_POSITION_TARGET_LOCAL_NED: vx with vy, z, or all three, in MAV_FRAME_LOCAL_NED.
///
/// # Errors
/// The message asks for something that a fixed wing behind speed, course and altitude loops cannot fly (a position, vz,
/// an acceleration, a yaw), or a number is not finite. Such a message is rejected as a whole.
pub fn setpoint_from_local_ned(target: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> Result<PartialSetpoint, SetpointError> {
    if target.coordinate_frame != MavFrame::MAV_FRAME_LOCAL_NED {
        return Err(SetpointError::Frame(target.coordinate_frame));
    }
    let mask = target.type_mask;
    let asks = |ignore_bits: PositionTargetTypemask| !mask.contains(ignore_bits);
    let velocity = PositionTargetTypemask::POSITION_TARGET_TYPEMASK_VX_IGNORE
        | PositionTargetTypemask::POSITION_TARGET_TYPEMASK_VY_IGNORE;
    let altitude = PositionTargetTypemask::POSITION_TARGET_TYPEMASK_Z_IGNORE;
    let all_else = PositionTargetTypemask::from_bits_retain(VELOCITY_AND_ALTITUDE_MASK);
    let half_a_velocity = mask.intersects(velocity) && asks(velocity);
    let nothing = !asks(velocity) && !asks(altitude);
    if asks(all_else) || half_a_velocity || nothing {
        return Err(SetpointError::Mask(mask.bits()));
    }
    let partial = PartialSetpoint {
        velocity: asks(velocity).then(|| Vector2::new(target.vx, target.vy).cast()),
        altitude: asks(altitude).then(|| up(target.z)),
    };
    if partial.is_finite() { Ok(partial) } else { Err(SetpointError::NotFinite) }
}

/// The setpoint that a vehicle reads from [`local_ned_setpoint`]: a run in memory rounds with it, to have the same bits
/// as a run over the wire. Rounding twice is the same as once.
pub fn wire_round_setpoint(setpoint: &Setpoint) -> Setpoint {
    let data = local_ned_data(0, Target::default(), setpoint);
    let (speed_mps, course_rad) = speed_and_course(Vector2::new(data.vx, data.vy).cast());
    Setpoint { speed_mps, course_rad, altitude_m: up(data.z) }
}

impl PartialSetpoint {
    /// The setpoint of a vehicle that has flown `current` until now: what is not asked for stays as it is.
    pub fn over(&self, current: &Setpoint) -> Setpoint {
        let (speed_mps, course_rad) = match self.velocity {
            Some(velocity_mps) => speed_and_course(velocity_mps),
            None => (current.speed_mps, current.course_rad),
        };
        Setpoint { speed_mps, course_rad, altitude_m: self.altitude.unwrap_or(current.altitude_m) }
    }

    fn is_finite(&self) -> bool {
        self.velocity.is_none_or(|velocity| velocity.iter().all(|mps| mps.is_finite()))
            && self.altitude.is_none_or(f64::is_finite)
    }
}

/// The three commands by which ArduPlane follows speed, altitude and course in GUIDED, as COMMAND_INT:
/// MAV_CMD_GUIDED_CHANGE_SPEED, _ALTITUDE and _HEADING (over ground).
///
/// `altitude_above_home_m` replaces the setpoint's altitude, which counts from the local origin.
/// `lateral_acceleration_mps2` limits the bank in turns. Values that ArduPlane handles badly are avoided: the course is
/// in [0, 360) degrees after rounding to `f32`, an altitude within 2 cm of home or of -1 m is moved by 2 cm, and the
/// lateral acceleration is at least ArduPlane's own minimum, 0.05 m/s2.
///
/// # Errors
/// A number is not finite as `f32`: ArduPlane dives or stops when it receives a NaN.
pub fn guided_commands(
    target: Target,
    setpoint: &Setpoint,
    altitude_above_home_m: f64,
    lateral_acceleration_mps2: f64,
) -> Result<[Message; 3], SetpointError> {
    let speed_mps = finite_f32(setpoint.speed_mps)?;
    let altitude_m = flyable_altitude_m(finite_f32(altitude_above_home_m)?);
    let course_deg = course_deg(setpoint.course_rad)?;
    let lateral_mps2 = finite_f32(lateral_acceleration_mps2)?.max(LATERAL_ACCELERATION_MIN_MPS2);
    let command = |command, param1, param2, param3, z| {
        Message::COMMAND_INT(COMMAND_INT_DATA {
            param1,
            param2,
            param3,
            z,
            command,
            target_system: target.system_id,
            target_component: target.component_id,
            frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
            ..COMMAND_INT_DATA::DEFAULT
        })
    };
    Ok([
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED, 0.0, speed_mps, 0.0, 0.0),
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE, 0.0, 0.0, 0.0, altitude_m),
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, 0.0, course_deg, lateral_mps2, 0.0),
    ])
}

const LATERAL_ACCELERATION_MIN_MPS2: f32 = 0.05;

fn local_ned_data(time_boot_ms: u32, target: Target, setpoint: &Setpoint) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
    // Not f64::max, which would make a speed of NaN a valid one.
    let speed_mps = if setpoint.speed_mps < 0.5 * SPEED_MIN_MPS { SPEED_MIN_MPS } else { setpoint.speed_mps };
    let velocity_mps = wire_velocity(speed_mps, setpoint.course_rad);
    SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms,
        z: down(setpoint.altitude_m),
        vx: velocity_mps.x,
        vy: velocity_mps.y,
        type_mask: PositionTargetTypemask::from_bits_retain(VELOCITY_AND_ALTITUDE_MASK),
        target_system: target.system_id,
        target_component: target.component_id,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
    }
}

pub(crate) fn finite_f32(value: f64) -> Result<f32, SetpointError> {
    let value = value as f32;
    if value.is_finite() { Ok(value) } else { Err(SetpointError::NotFinite) }
}

/// Degrees in [0, 360).
pub(crate) fn course_deg(course_rad: f64) -> Result<f32, SetpointError> {
    let turn = course_rad / std::f64::consts::TAU;
    let degrees = finite_f32((turn - turn.floor()) * 360.0)?;
    Ok(if degrees >= 360.0 { 0.0 } else { degrees })
}

/// ArduPlane denies 0 and -1, and crashes on an altitude that rounds to 0 cm.
pub(crate) fn flyable_altitude_m(altitude_m: f32) -> f32 {
    const LEAST_M: f32 = 0.02;
    if altitude_m.abs() < LEAST_M {
        LEAST_M
    } else if (altitude_m + 1.0).abs() < LEAST_M {
        -1.0 + LEAST_M
    } else {
        altitude_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TARGET: Target = Target { system_id: 7, component_id: 1 };

    fn setpoint() -> impl Strategy<Value = Setpoint> {
        (-1.0..50.0f64, -10.0..10.0f64, -500.0..5e3f64).prop_map(|(speed_mps, course_rad, altitude_m)| Setpoint {
            speed_mps,
            course_rad,
            altitude_m,
        })
    }

    fn bits(setpoint: &Setpoint) -> [u64; 3] {
        [setpoint.speed_mps, setpoint.course_rad, setpoint.altitude_m].map(f64::to_bits)
    }

    fn data(setpoint: &Setpoint) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
        let Message::SET_POSITION_TARGET_LOCAL_NED(data) =
            local_ned_setpoint(Duration::from_millis(500), TARGET, setpoint)
        else {
            panic!("another message");
        };
        data
    }

    fn commands(setpoint: &Setpoint, altitude_m: f64, lateral_mps2: f64) -> [COMMAND_INT_DATA; 3] {
        guided_commands(TARGET, setpoint, altitude_m, lateral_mps2).unwrap().map(|message| match message {
            Message::COMMAND_INT(data) => data,
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn the_setpoint_of_an_offboard_multicopter() {
        let data = data(&Setpoint { speed_mps: 10.0, course_rad: std::f64::consts::FRAC_PI_2, altitude_m: 50.0 });
        assert_eq!((data.time_boot_ms, data.target_system, data.target_component), (500, 7, 1));
        assert_eq!((data.vx, data.vy, data.z), (0.0, 10.0, -50.0));
        assert_eq!(data.type_mask.bits(), 0x0DE3);
        assert_eq!(data.coordinate_frame, MavFrame::MAV_FRAME_LOCAL_NED);
    }

    #[test]
    fn masks_are_followed_or_refused_with_the_reason() {
        let mut data = data(&Setpoint { speed_mps: 5.0, course_rad: 0.0, altitude_m: 50.0 });
        let mut read = |mask: u16| {
            data.type_mask = PositionTargetTypemask::from_bits_retain(mask);
            setpoint_from_local_ned(&data)
        };
        let (velocity, altitude) = (Some(Vector2::new(5.0, 0.0)), Some(50.0));
        assert_eq!(read(0x0DE3), Ok(PartialSetpoint { velocity, altitude }));
        assert_eq!(read(0x0DE7), Ok(PartialSetpoint { velocity, altitude: None }));
        assert_eq!(read(0x0DFB), Ok(PartialSetpoint { velocity: None, altitude }));
        // vz, position, acceleration, yaw, yaw rate, one of vx and vy, nothing.
        for mask in [0x0DC7, 0x0DE0, 0x0C23, 0x09E3, 0x05E3, 0x0DEB, 0x0DF3, 0x0DFF, 0x0000] {
            assert_eq!(read(mask), Err(SetpointError::Mask(mask)), "{mask:#06x}");
        }
    }

    #[test]
    fn other_frames_are_refused() {
        let mut data = data(&Setpoint::default());
        data.coordinate_frame = MavFrame::MAV_FRAME_BODY_FRD;
        let refused = Err(SetpointError::Frame(MavFrame::MAV_FRAME_BODY_FRD));
        assert_eq!(setpoint_from_local_ned(&data), refused);
    }

    #[test]
    fn only_fields_that_are_asked_for_must_be_finite() {
        for (speed_mps, course_rad, altitude_m) in [(f64::NAN, 0.0, 0.0), (5.0, f64::NAN, 0.0), (5.0, 0.0, 1e300)] {
            let data = data(&Setpoint { speed_mps, course_rad, altitude_m });
            assert_eq!(setpoint_from_local_ned(&data), Err(SetpointError::NotFinite));
        }
        let mut data = data(&Setpoint { speed_mps: 5.0, course_rad: 0.0, altitude_m: 50.0 });
        (data.x, data.vz, data.yaw) = (f32::NAN, f32::INFINITY, f32::NAN);
        assert!(setpoint_from_local_ned(&data).is_ok());
    }

    #[test]
    fn the_three_commands_of_arduplane() {
        let setpoint = Setpoint { speed_mps: 12.5, course_rad: -std::f64::consts::FRAC_PI_2, altitude_m: 999.0 };
        let [speed, altitude, course] = commands(&setpoint, 60.0, 50.0);
        assert_eq!((speed.command as u16, speed.param1, speed.param2, speed.param3), (43000, 0.0, 12.5, 0.0));
        assert_eq!((altitude.command as u16, altitude.z, altitude.param3), (43001, 60.0, 0.0));
        assert_eq!(altitude.frame as u8, 3);
        assert_eq!((course.command as u16, course.param1, course.param2, course.param3), (43002, 0.0, 270.0, 50.0));
        for command in [speed, altitude, course] {
            assert_eq!((command.target_system, command.target_component), (7, 1));
        }
    }

    #[test]
    fn what_kills_arduplane_is_not_sent() {
        let good = Setpoint { speed_mps: 12.0, course_rad: 0.0, altitude_m: 50.0 };
        for altitude_m in [0.0, -0.0, 0.004, -0.009, -1.0, -1.000_000_1] {
            let [_, altitude, _] = commands(&good, altitude_m, 5.0);
            assert!(altitude.z.abs() >= 0.01 && (altitude.z + 1.0).abs() >= 0.01, "{altitude_m}");
            assert!((f64::from(altitude.z) - altitude_m).abs() < 0.03);
        }
        assert_eq!(commands(&good, 50.0, 0.0)[2].param3, 0.05);
        // Less than half an f32 step below a whole turn.
        assert_eq!(commands(&Setpoint { course_rad: -1e-12, ..good }, 50.0, 5.0)[2].param2, 0.0);
        for (speed_mps, course_rad, altitude_m, lateral) in [
            (f64::NAN, 0.0, 50.0, 5.0),
            (12.0, f64::INFINITY, 50.0, 5.0),
            (12.0, 0.0, f64::NAN, 5.0),
            (12.0, 0.0, 1e39, 5.0),
            (12.0, 0.0, 50.0, f64::NAN),
        ] {
            let refused = guided_commands(TARGET, &Setpoint { speed_mps, course_rad, ..good }, altitude_m, lateral);
            assert_eq!(refused, Err(SetpointError::NotFinite));
        }
    }

    proptest! {
        #[test]
        fn a_vehicle_reads_what_wire_rounding_gives(setpoint in setpoint(), current in setpoint()) {
            let read = setpoint_from_local_ned(&data(&setpoint)).unwrap().over(&current);
            prop_assert_eq!(bits(&read), bits(&wire_round_setpoint(&setpoint)));
        }

        #[test]
        fn wire_rounding_twice_is_once(setpoint in setpoint()) {
            let once = wire_round_setpoint(&setpoint);
            prop_assert_eq!(bits(&wire_round_setpoint(&once)), bits(&once));
        }

        #[test]
        fn slow_setpoints_keep_their_course(speed in -1.0..0.01f64, course in -3.1..3.1f64) {
            let setpoint = Setpoint { speed_mps: speed, course_rad: course, altitude_m: 50.0 };
            let rounded = wire_round_setpoint(&setpoint);
            prop_assert!((rounded.course_rad - course).abs() < 3e-3);
            prop_assert!((rounded.speed_mps - speed.max(0.0)).abs() < 1.1 * SPEED_MIN_MPS);
        }

        #[test]
        fn the_commanded_course_is_a_compass_course(course in -1e4..1e4f64) {
            let setpoint = Setpoint { speed_mps: 12.0, course_rad: course, altitude_m: 50.0 };
            let degrees = f64::from(commands(&setpoint, 50.0, 5.0)[2].param2);
            prop_assert!((0.0..360.0).contains(&degrees));
            prop_assert!(flight_model::wrap_pi(degrees.to_radians() - course).abs() < 1e-6);
        }
    }
}
