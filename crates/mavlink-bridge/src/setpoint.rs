//! Setpoints as messages for an autopilot, and what a vehicle reads of them.

use crate::Target;
use crate::dialect::{
    COMMAND_INT_DATA, MavCmd, MavFrame, Message, PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use crate::telemetry::{boot_ms, down, speed_and_course, up, wire_velocity};
use flight_model::Setpoint;
use std::time::Duration;

/// The type mask of [`local_ned_setpoint`]: vx, vy and z are set, all else is ignored.
pub const VELOCITY_AND_ALTITUDE_MASK: u16 = 0x0DE3;

/// Least speed that [`local_ned_setpoint`] sends, m/s: a velocity of zero would have no course.
pub const SPEED_MIN_MPS: f64 = 1.0 / 1024.0;

/// What a SET_POSITION_TARGET_LOCAL_NED asks of a vehicle: velocity, altitude, or both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartialSetpoint {
    /// Horizontal velocity (north, east), m/s.
    pub velocity: Option<(f64, f64)>,
    /// Altitude above the origin, m.
    pub altitude: Option<f64>,
}

/// Why a setpoint message is not followed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SetpointRefusal {
    /// The coordinate frame is not MAV_FRAME_LOCAL_NED.
    #[error("the coordinate frame {0:?} is not followed")]
    Frame(MavFrame),
    /// The type mask asks for something else than vx with vy, or z, or all three.
    #[error("the type mask {0:#06x} is not followed")]
    Mask(u16),
    /// A field that is asked for is not a finite number.
    #[error("a field is not a finite number")]
    NotFinite,
}

/// SET_POSITION_TARGET_LOCAL_NED with velocity and altitude, for PX4 multicopters in OFFBOARD and for lockstep, where
/// `time_boot` is the stamp (<https://mavlink.io/en/messages/common.html#SET_POSITION_TARGET_LOCAL_NED>).
///
/// Speeds below [`SPEED_MIN_MPS`] are sent as that, to keep the course. Numbers that are not finite stay so, and are
/// refused by [`setpoint_from_local_ned`].
pub fn local_ned_setpoint(time_boot: Duration, target: Target, setpoint: &Setpoint) -> Message {
    Message::SET_POSITION_TARGET_LOCAL_NED(local_ned_data(boot_ms(time_boot), target, setpoint))
}

/// What a SET_POSITION_TARGET_LOCAL_NED asks for, or why it is not followed.
///
/// Followed are vx with vy, and z, in MAV_FRAME_LOCAL_NED. What a fixed wing behind speed, course and altitude loops
/// cannot fly (position, vz, acceleration, yaw) is refused and not ignored in silence.
pub fn setpoint_from_local_ned(
    target: &SET_POSITION_TARGET_LOCAL_NED_DATA,
) -> Result<PartialSetpoint, SetpointRefusal> {
    if target.coordinate_frame != MavFrame::MAV_FRAME_LOCAL_NED {
        return Err(SetpointRefusal::Frame(target.coordinate_frame));
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
        return Err(SetpointRefusal::Mask(mask.bits()));
    }
    let partial = PartialSetpoint {
        velocity: asks(velocity).then(|| (f64::from(target.vx), f64::from(target.vy))),
        altitude: asks(altitude).then(|| up(target.z)),
    };
    if partial.is_finite() { Ok(partial) } else { Err(SetpointRefusal::NotFinite) }
}

/// Exactly what a vehicle makes of [`local_ned_setpoint`]: a run in memory rounds with it, to have the same bits as a
/// run over the wire. Twice is the same as once.
pub fn wire_round_setpoint(setpoint: &Setpoint) -> Setpoint {
    let data = local_ned_data(0, Target::default(), setpoint);
    let (speed_mps, course_rad) = speed_and_course(f64::from(data.vx), f64::from(data.vy));
    Setpoint { speed_mps, course_rad, altitude_m: up(data.z) }
}

impl PartialSetpoint {
    /// The setpoint of a vehicle that has flown `current` until now: what is not asked for stays as it is.
    pub fn over(&self, current: &Setpoint) -> Setpoint {
        let (speed_mps, course_rad) = match self.velocity {
            Some((north_mps, east_mps)) => speed_and_course(north_mps, east_mps),
            None => (current.speed_mps, current.course_rad),
        };
        Setpoint { speed_mps, course_rad, altitude_m: self.altitude.unwrap_or(current.altitude_m) }
    }

    fn is_finite(&self) -> bool {
        self.velocity.is_none_or(|(north, east)| north.is_finite() && east.is_finite())
            && self.altitude.is_none_or(f64::is_finite)
    }
}

/// The three commands by which ArduPlane follows speed, altitude and course in GUIDED, as COMMAND_INT:
/// MAV_CMD_GUIDED_CHANGE_SPEED, _ALTITUDE and _HEADING (over ground).
///
/// `altitude_above_home_m` stands in for the setpoint's altitude, which counts from the local origin.
/// `lateral_acceleration_mps2` limits the bank in turns. None if a number is not finite. What ArduPlane would choke on is
/// avoided: the course is in [0, 360) degrees after rounding to `f32`, an altitude within 2 cm of home or at -1 m is moved
/// by 2 cm, the lateral acceleration is at least the autopilot's own least, 0.05 m/s2.
pub fn guided_commands(
    target: Target,
    setpoint: &Setpoint,
    altitude_above_home_m: f64,
    lateral_acceleration_mps2: f64,
) -> Option<[Message; 3]> {
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
    Some([
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED, 0.0, speed_mps, 0.0, 0.0),
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE, 0.0, 0.0, 0.0, altitude_m),
        command(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING, 0.0, course_deg, lateral_mps2, 0.0),
    ])
}

const LATERAL_ACCELERATION_MIN_MPS2: f32 = 0.05;

fn local_ned_data(time_boot_ms: u32, target: Target, setpoint: &Setpoint) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
    // Not f64::max, which would make a speed of NaN a valid one.
    let speed_mps = if setpoint.speed_mps < SPEED_MIN_MPS { SPEED_MIN_MPS } else { setpoint.speed_mps };
    let (vx, vy) = wire_velocity(speed_mps, setpoint.course_rad);
    SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms,
        z: down(setpoint.altitude_m),
        vx,
        vy,
        type_mask: PositionTargetTypemask::from_bits_retain(VELOCITY_AND_ALTITUDE_MASK),
        target_system: target.system_id,
        target_component: target.component_id,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
    }
}

fn finite_f32(value: f64) -> Option<f32> {
    let value = value as f32;
    value.is_finite().then_some(value)
}

fn course_deg(course_rad: f64) -> Option<f32> {
    let turn = course_rad / std::f64::consts::TAU;
    let degrees = finite_f32((turn - turn.floor()) * 360.0)?;
    Some(if degrees >= 360.0 { 0.0 } else { degrees })
}

/// ArduPlane denies 0 and -1, and dies of what rounds to 0 cm.
fn flyable_altitude_m(altitude_m: f32) -> f32 {
    const LEAST_M: f32 = 0.02;
    if altitude_m.abs() < LEAST_M {
        LEAST_M
    } else if (altitude_m + 1.0).abs() < LEAST_M {
        -1.0 + LEAST_M
    } else {
        altitude_m
    }
}
