//! PX4 on a multicopter, in Offboard (<https://docs.px4.io/main/en/flight_modes/offboard.html>): a stream of velocities
//! with an altitude.
//!
//! Mask 0xDE3 (vx, vy and z) holds altitude to centimetres. A stream with gaps of more than COM_OF_LOSS_T (1 s) is
//! lost: the vehicle returns, and comes back into Offboard by itself when the stream does. Other masks stop it without
//! a word.

use super::commands::{arm, set_px4_mode};
use super::{Launch, Parameters, Seen, Situation, VehicleLimits, local_ned};
use crate::dialect::Message;
use crate::{SetpointError, Target};
use flight_model::{Setpoint, course_vector};

/// HEARTBEAT.custom_mode: main mode in bits 16 to 23, sub mode above (`px4_custom_mode.h`).
pub(super) const OFFBOARD: u32 = 6 << 16;
pub(super) const TAKEOFF: u32 = 4 << 16 | 2 << 24;
pub(super) const HOLD: u32 = 4 << 16 | 3 << 24;
const RETURN: u32 = 4 << 16 | 5 << 24;
const LAND: u32 = 4 << 16 | 6 << 24;

/// Loiter, return, land.
pub(super) const END_MODES: [u32; 3] = [HOLD, RETURN, LAND];

pub(super) const LIMIT_PARAMETERS: [&str; 5] =
    ["MPC_XY_VEL_MAX", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN", "MPC_TILTMAX_AIR", "MIS_TAKEOFF_ALT"];

/// Above this Offboard takes over, m.
const TAKEN_OFF_M: f64 = 1.5;

const MODES: [(u32, &str); 18] = [
    (1 << 16, "Manual"),
    (2 << 16, "Altitude"),
    (3 << 16, "Position"),
    (3 << 16 | 1 << 24, "Orbit"),
    (3 << 16 | 2 << 24, "Position Slow"),
    (4 << 16 | 1 << 24, "Ready"),
    (TAKEOFF, "Takeoff"),
    (HOLD, "Hold"),
    (4 << 16 | 4 << 24, "Mission"),
    (RETURN, "Return"),
    (LAND, "Land"),
    (4 << 16 | 8 << 24, "Follow Me"),
    (4 << 16 | 9 << 24, "Precision Land"),
    (4 << 16 | 10 << 24, "VTOL Takeoff"),
    (4 << 16 | 19 << 24, "Guided Course"),
    (5 << 16, "Acro"),
    (OFFBOARD, "Offboard"),
    (7 << 16, "Stabilized"),
];

pub(super) fn mode_name(custom_mode: u32) -> Option<&'static str> {
    MODES.iter().find(|(number, _)| *number == custom_mode).map(|(_, name)| *name)
}

/// Takeoff mode, armed; Offboard takes over in the air. The stream must run before.
pub(super) fn launch(target: Target, seen: &Seen) -> Launch {
    if seen.armed && seen.custom_mode == OFFBOARD && !seen.on_ground {
        return Launch::Flying;
    }
    if seen.armed && !seen.on_ground && seen.height_m >= TAKEN_OFF_M {
        return Launch::Send(set_px4_mode(target, OFFBOARD));
    }
    take_off(target, seen)
}

/// Takeoff mode, then armed.
pub(super) fn take_off(target: Target, seen: &Seen) -> Launch {
    match (seen.armed, seen.on_ground) {
        (false, true) if seen.custom_mode != TAKEOFF => Launch::Send(set_px4_mode(target, TAKEOFF)),
        (false, _) => Launch::Send(arm(target)),
        (true, true) if seen.custom_mode != TAKEOFF => Launch::Send(set_px4_mode(target, TAKEOFF)),
        (true, _) => Launch::Wait,
    }
}

/// The velocity that brings the position onto the setpoint's: PX4 holds the velocity that its estimator tells, and its
/// estimator moves the position beside that for seconds, in and after a turn by up to 0.9 m/s.
pub(super) fn setpoint(
    target: Target,
    setpoint: &Setpoint,
    situation: &Situation<'_>,
) -> Result<Vec<Message>, SetpointError> {
    let held = setpoint.speed_mps * course_vector(setpoint.course_rad) - situation.drift_mps;
    let (speed_mps, course_rad) = (held.norm(), libm::atan2(held.y, held.x));
    local_ned(target, &Setpoint { speed_mps, course_rad, ..*setpoint }, situation)
}

pub(super) fn limits(parameters: Parameters<'_>) -> VehicleLimits {
    VehicleLimits {
        speed_min_mps: None,
        speed_max_mps: parameters("MPC_XY_VEL_MAX"),
        speeds_are_air: false,
        bank_max_rad: parameters("MPC_TILTMAX_AIR").map(f64::to_radians),
        climb_max_mps: parameters("MPC_Z_VEL_MAX_UP"),
        sink_max_mps: parameters("MPC_Z_VEL_MAX_DN"),
        takeoff_height_m: parameters("MIS_TAKEOFF_ALT"),
    }
}
