//! A vehicle's state as telemetry messages, and back.
//!
//! Positions and velocities travel as `f32`, north-east-down from the local origin. [`wire_round`] gives what is left of
//! a state after that journey.

use crate::dialect::{
    ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA,
    MavAutopilot, MavModeFlag, MavState, MavType, Message, SYSTEM_TIME_DATA, VFR_HUD_DATA,
};
use flight_model::{Geodetic, LocalFrame, State, wrap_pi};
use std::f64::consts::TAU;
use std::time::Duration;

/// A time since boot as `time_boot_ms`: whole milliseconds, the rest cut off. It wraps after 2^32 ms (49.7 days).
pub fn boot_ms(time_boot: Duration) -> u32 {
    time_boot.as_millis() as u32
}

/// LOCAL_POSITION_NED (<https://mavlink.io/en/messages/common.html#LOCAL_POSITION_NED>).
///
/// The horizontal velocity is rounded to 2^-20 m/s, about a micrometre a second, before it is rounded to `f32`: only so
/// can the course come back with the same bits when a state that was on the wire is sent on.
pub fn local_position_ned(time_boot: Duration, state: &State) -> Message {
    Message::LOCAL_POSITION_NED(local_position_data(boot_ms(time_boot), state))
}

/// The state in a LOCAL_POSITION_NED. Numbers that are not finite stay so: check [`State::is_finite`] before use.
pub fn state_from_local_position(position: &LOCAL_POSITION_NED_DATA) -> State {
    let (speed_mps, course_rad) = speed_and_course(f64::from(position.vx), f64::from(position.vy));
    State {
        x_m: f64::from(position.x),
        y_m: f64::from(position.y),
        altitude_m: up(position.z),
        speed_mps,
        course_rad,
        climb_mps: up(position.vz),
    }
}

/// Exactly what [`state_from_local_position`] makes of [`local_position_ned`]: a run in memory rounds with it, to have
/// the same bits as a run over the wire. Twice is the same as once.
pub fn wire_round(state: &State) -> State {
    state_from_local_position(&local_position_data(0, state))
}

/// GLOBAL_POSITION_INT: the state in WGS-84, heading along the course
/// (<https://mavlink.io/en/messages/common.html#GLOBAL_POSITION_INT>). Values beyond a field's range take its bound.
pub fn global_position_int(time_boot: Duration, state: &State, frame: &LocalFrame) -> Message {
    let place = frame.to_geodetic(state.x_m, state.y_m, state.altitude_m);
    let (north_mps, east_mps) = state.velocity_mps();
    // A float to integer cast takes the bound when it overflows and zero for NaN.
    Message::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
        time_boot_ms: boot_ms(time_boot),
        lat: (place.latitude_deg * 1e7).round() as i32,
        lon: (place.longitude_deg * 1e7).round() as i32,
        alt: (place.altitude_amsl_m * 1e3).round() as i32,
        relative_alt: (state.altitude_m * 1e3).round() as i32,
        vx: (north_mps * 1e2).round() as i16,
        vy: (east_mps * 1e2).round() as i16,
        vz: (-state.climb_mps * 1e2).round() as i16,
        hdg: heading_cdeg(state.course_rad),
    })
}

/// ATTITUDE with the yaw along the course and the pitch along the flight path
/// (<https://mavlink.io/en/messages/common.html#ATTITUDE>).
pub fn attitude(time_boot: Duration, state: &State, roll_rad: f64, yaw_rate_radps: f64) -> Message {
    Message::ATTITUDE(ATTITUDE_DATA {
        time_boot_ms: boot_ms(time_boot),
        roll: roll_rad as f32,
        pitch: libm::atan2(state.climb_mps, state.speed_mps) as f32,
        yaw: wrap_pi(state.course_rad) as f32,
        rollspeed: 0.0,
        pitchspeed: 0.0,
        yawspeed: yaw_rate_radps as f32,
    })
}

/// VFR_HUD, in still air (<https://mavlink.io/en/messages/common.html#VFR_HUD>).
pub fn vfr_hud(state: &State, altitude_amsl_m: f64, throttle_percent: u16) -> Message {
    Message::VFR_HUD(VFR_HUD_DATA {
        airspeed: state.speed_mps as f32,
        groundspeed: state.speed_mps as f32,
        alt: altitude_amsl_m as f32,
        climb: state.climb_mps as f32,
        heading: (heading_cdeg(state.course_rad) / 100) as i16,
        throttle: throttle_percent,
    })
}

/// SYSTEM_TIME (<https://mavlink.io/en/messages/common.html#SYSTEM_TIME>).
pub fn system_time(time_boot: Duration, unix_time: Duration) -> Message {
    Message::SYSTEM_TIME(SYSTEM_TIME_DATA {
        time_unix_usec: u64::try_from(unix_time.as_micros()).unwrap_or(u64::MAX),
        time_boot_ms: boot_ms(time_boot),
    })
}

/// HEARTBEAT (<https://mavlink.io/en/messages/common.html#HEARTBEAT>).
pub fn heartbeat(
    kind: MavType,
    autopilot: MavAutopilot,
    base_mode: MavModeFlag,
    custom_mode: u32,
    status: MavState,
) -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode,
        mavtype: kind,
        autopilot,
        base_mode,
        system_status: status,
        mavlink_version: 3,
    })
}

/// HEARTBEAT of a ground station.
pub fn ground_heartbeat() -> Message {
    heartbeat(
        MavType::MAV_TYPE_GCS,
        MavAutopilot::MAV_AUTOPILOT_INVALID,
        MavModeFlag::empty(),
        0,
        MavState::MAV_STATE_ACTIVE,
    )
}

/// GPS_GLOBAL_ORIGIN (<https://mavlink.io/en/messages/common.html#GPS_GLOBAL_ORIGIN>).
pub fn gps_global_origin(time_boot: Duration, origin: &Geodetic) -> Message {
    Message::GPS_GLOBAL_ORIGIN(GPS_GLOBAL_ORIGIN_DATA {
        latitude: (origin.latitude_deg * 1e7).round() as i32,
        longitude: (origin.longitude_deg * 1e7).round() as i32,
        altitude: (origin.altitude_amsl_m * 1e3).round() as i32,
        time_usec: u64::try_from(time_boot.as_micros()).unwrap_or(u64::MAX),
    })
}

fn local_position_data(time_boot_ms: u32, state: &State) -> LOCAL_POSITION_NED_DATA {
    let (vx, vy) = wire_velocity(state.speed_mps, state.course_rad);
    LOCAL_POSITION_NED_DATA {
        time_boot_ms,
        x: state.x_m as f32,
        y: state.y_m as f32,
        z: down(state.altitude_m),
        vx,
        vy,
        vz: down(state.climb_mps),
    }
}

/// Velocity (north, east) on the wire, m/s, from speed in m/s and course in rad.
pub(crate) fn wire_velocity(speed_mps: f64, course_rad: f64) -> (f32, f32) {
    const GRID: f64 = 1_048_576.0; // 2^20: scaling by it is exact
    let (sin, cos) = libm::sincos(course_rad);
    // Adding zero turns -0 into 0, so that a course along an axis has one sign.
    let on_grid = |component_mps: f64| ((component_mps * GRID).round() / GRID + 0.0) as f32;
    (on_grid(speed_mps * cos), on_grid(speed_mps * sin))
}

/// Speed in m/s and course in rad, in (-pi, pi], of a velocity (north, east) in m/s.
pub(crate) fn speed_and_course(north_mps: f64, east_mps: f64) -> (f64, f64) {
    let speed_mps = (north_mps * north_mps + east_mps * east_mps).sqrt();
    (speed_mps, wrap_pi(libm::atan2(east_mps, north_mps)))
}

/// Up in m or m/s as down on the wire; never -0.
pub(crate) fn down(up: f64) -> f32 {
    (0.0 - up) as f32
}

/// Down on the wire as up in m or m/s; never -0.
pub(crate) fn up(down: f32) -> f64 {
    0.0 - f64::from(down)
}

/// Heading in centidegrees, 0 to 35999.
fn heading_cdeg(course_rad: f64) -> u16 {
    let turn = course_rad / TAU;
    let cdeg = ((turn - turn.floor()) * 36_000.0).round() as u16;
    if cdeg >= 36_000 { 0 } else { cdeg }
}
