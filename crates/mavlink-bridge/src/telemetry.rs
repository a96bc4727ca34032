//! A vehicle's state as telemetry messages, and back.
//!
//! Positions and velocities travel as `f32`, north-east-down from the local origin. [`wire_round`] gives what is left of
//! a state after that journey.

// Clients still ask for what the dialect calls superseded.
#![allow(deprecated)]

use crate::coordinates::LatLonE7;
use crate::dialect::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA,
    GPS_RAW_INT_DATA, GpsFixType, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavLandedState, MavModeFlag,
    MavProtocolCapability, MavState, MavType, MavVtolState, Message, PROTOCOL_VERSION_DATA, SYSTEM_TIME_DATA,
    VFR_HUD_DATA, WIND_COV_DATA,
};
use flight_model::{Geodetic, LocalFrame, State, Wind, wrap_pi};
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

/// GLOBAL_POSITION_INT: the state in WGS-84, where the nose points, and the height above a home at an altitude
/// (<https://mavlink.io/en/messages/common.html#GLOBAL_POSITION_INT>). Values beyond a field's range take its bound.
pub fn global_position_int(
    time_boot: Duration,
    state: &State,
    heading_rad: f64,
    frame: &LocalFrame,
    home_altitude_m: f64,
) -> Message {
    let place = frame.to_geodetic(state.x_m, state.y_m, state.altitude_m);
    let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&place);
    let (north_mps, east_mps) = state.velocity_mps();
    // A float to integer cast takes the bound when it overflows and zero for NaN.
    Message::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
        time_boot_ms: boot_ms(time_boot),
        lat: latitude_e7,
        lon: longitude_e7,
        alt: (place.altitude_amsl_m * 1e3).round() as i32,
        relative_alt: ((state.altitude_m - home_altitude_m) * 1e3).round() as i32,
        vx: (north_mps * 1e2).round() as i16,
        vy: (east_mps * 1e2).round() as i16,
        vz: (-state.climb_mps * 1e2).round() as i16,
        hdg: heading_cdeg(heading_rad),
    })
}

/// ATTITUDE with the nose along the way through the air, of which `air` is the state: airspeed and heading
/// (<https://mavlink.io/en/messages/common.html#ATTITUDE>).
pub fn attitude(time_boot: Duration, air: &State, roll_rad: f64, yaw_rate_radps: f64) -> Message {
    Message::ATTITUDE(ATTITUDE_DATA {
        time_boot_ms: boot_ms(time_boot),
        roll: roll_rad as f32,
        pitch: libm::atan2(air.climb_mps, air.speed_mps) as f32,
        yaw: wrap_pi(air.course_rad) as f32,
        rollspeed: 0.0,
        pitchspeed: 0.0,
        yawspeed: yaw_rate_radps as f32,
    })
}

/// VFR_HUD (<https://mavlink.io/en/messages/common.html#VFR_HUD>): speed over ground, airspeed as it is measured, where
/// the nose points.
pub fn vfr_hud(
    state: &State,
    airspeed_mps: f64,
    heading_rad: f64,
    altitude_amsl_m: f64,
    throttle_percent: u16,
) -> Message {
    Message::VFR_HUD(VFR_HUD_DATA {
        airspeed: airspeed_mps as f32,
        groundspeed: state.speed_mps as f32,
        alt: altitude_amsl_m as f32,
        climb: state.climb_mps as f32,
        heading: (heading_cdeg(heading_rad) / 100) as i16,
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
    let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(origin);
    Message::GPS_GLOBAL_ORIGIN(GPS_GLOBAL_ORIGIN_DATA {
        latitude: latitude_e7,
        longitude: longitude_e7,
        altitude: (origin.altitude_amsl_m * 1e3).round() as i32,
        time_usec: u64::try_from(time_boot.as_micros()).unwrap_or(u64::MAX),
    })
}

/// GPS_RAW_INT of a receiver that measures `state`, heights above the ellipsoid as above the sea
/// (<https://mavlink.io/en/messages/common.html#GPS_RAW_INT>). Without a fix the place is the last one, and what cannot be
/// known says so.
pub fn gps_raw_int(time_boot: Duration, state: &State, frame: &LocalFrame, has_fix: bool, satellites: u8) -> Message {
    let place = frame.to_geodetic(state.x_m, state.y_m, state.altitude_m);
    let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&place);
    let altitude_mm = (place.altitude_amsl_m * 1e3).round() as i32;
    let known = |value: u16| if has_fix { value } else { u16::MAX };
    Message::GPS_RAW_INT(GPS_RAW_INT_DATA {
        time_usec: u64::try_from(time_boot.as_micros()).unwrap_or(u64::MAX),
        lat: latitude_e7,
        lon: longitude_e7,
        alt: altitude_mm,
        eph: known(100),
        epv: known(100),
        vel: known((state.speed_mps * 1e2).round() as u16),
        cog: known(heading_cdeg(state.course_rad)),
        fix_type: if has_fix { GpsFixType::GPS_FIX_TYPE_3D_FIX } else { GpsFixType::GPS_FIX_TYPE_NO_FIX },
        satellites_visible: satellites,
        alt_ellipsoid: altitude_mm,
        ..GPS_RAW_INT_DATA::DEFAULT
    })
}

/// WIND_COV (<https://mavlink.io/en/messages/common.html#WIND_COV>): the velocity of the air, north-east-down, its spread in
/// m/s, and the altitude in m at which it was measured.
pub fn wind_cov(time_boot: Duration, wind: &Wind, deviation_mps: f64, altitude_amsl_m: f64) -> Message {
    Message::WIND_COV(WIND_COV_DATA {
        time_usec: u64::try_from(time_boot.as_micros()).unwrap_or(u64::MAX),
        wind_x: wind.north_mps as f32,
        wind_y: wind.east_mps as f32,
        wind_z: down(wind.up_mps),
        var_horiz: deviation_mps as f32,
        var_vert: deviation_mps as f32,
        wind_alt: altitude_amsl_m as f32,
        horiz_accuracy: deviation_mps as f32,
        vert_accuracy: deviation_mps as f32,
    })
}

/// AUTOPILOT_VERSION: a released version of the flight software, what it can do, and a number that tells one vehicle from
/// another (<https://mavlink.io/en/messages/common.html#AUTOPILOT_VERSION>).
pub fn autopilot_version([major, minor, patch]: [u8; 3], capabilities: MavProtocolCapability, uid: u64) -> Message {
    const RELEASED: u8 = 255;
    Message::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
        capabilities,
        uid,
        flight_sw_version: u32::from_be_bytes([major, minor, patch, RELEASED]),
        ..AUTOPILOT_VERSION_DATA::DEFAULT
    })
}

/// PROTOCOL_VERSION: MAVLink 2, and MAVLink 1 for those who speak it
/// (<https://mavlink.io/en/messages/common.html#PROTOCOL_VERSION>).
pub fn protocol_version() -> Message {
    Message::PROTOCOL_VERSION(PROTOCOL_VERSION_DATA {
        version: 200,
        min_version: 100,
        max_version: 200,
        ..PROTOCOL_VERSION_DATA::DEFAULT
    })
}

/// EXTENDED_SYS_STATE of an aeroplane (<https://mavlink.io/en/messages/common.html#EXTENDED_SYS_STATE>).
pub fn extended_sys_state(landed_state: MavLandedState) -> Message {
    Message::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
        vtol_state: MavVtolState::MAV_VTOL_STATE_UNDEFINED,
        landed_state,
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn state() -> impl Strategy<Value = State> {
        (-1e5..1e5f64, -1e5..1e5f64, -500.0..5e3f64, 0.0..300.0f64, -10.0..10.0f64, -50.0..50.0f64).prop_map(
            |(x_m, y_m, altitude_m, speed_mps, course_rad, climb_mps)| State {
                x_m,
                y_m,
                altitude_m,
                speed_mps,
                course_rad: wrap_pi(course_rad),
                climb_mps,
            },
        )
    }

    fn bits(state: &State) -> [u64; 6] {
        [state.x_m, state.y_m, state.altitude_m, state.speed_mps, state.course_rad, state.climb_mps].map(f64::to_bits)
    }

    #[test]
    fn courses_along_the_axes_keep_their_bits() {
        use std::f64::consts::{FRAC_PI_2, PI};
        for course_rad in [0.0, FRAC_PI_2, PI, -FRAC_PI_2] {
            let state = State { speed_mps: 9.0, course_rad, ..State::default() };
            assert_eq!(bits(&wire_round(&state)), bits(&state));
        }
        let south_by_the_other_hand = State { speed_mps: 9.0, course_rad: -PI, ..State::default() };
        assert_eq!(wire_round(&south_by_the_other_hand).course_rad, PI);
    }

    #[test]
    fn a_strangers_negative_zero_is_south_by_plus_pi() {
        let position = LOCAL_POSITION_NED_DATA { vx: -3.0, vy: -0.0, ..LOCAL_POSITION_NED_DATA::DEFAULT };
        assert_eq!(state_from_local_position(&position).course_rad, std::f64::consts::PI);
    }

    #[test]
    fn numbers_that_are_not_finite_are_seen_as_such() {
        let mut position = LOCAL_POSITION_NED_DATA::DEFAULT;
        assert!(state_from_local_position(&position).is_finite());
        position.vy = f32::NAN;
        assert!(!state_from_local_position(&position).is_finite());
        let state = State { altitude_m: f64::INFINITY, ..State::default() };
        assert!(!wire_round(&state).is_finite());
    }

    #[test]
    fn time_wraps_after_fifty_days() {
        assert_eq!(boot_ms(Duration::from_micros(500_999)), 500);
        assert_eq!(boot_ms(Duration::from_millis((1 << 32) + 7)), 7);
    }

    #[test]
    fn a_known_place_in_wgs_84() {
        let origin = Geodetic { latitude_deg: 39.98, longitude_deg: 116.34, altitude_amsl_m: 50.0 };
        let state = State { altitude_m: 20.5, speed_mps: 10.0, course_rad: -0.1, climb_mps: 1.5, ..State::default() };
        let message =
            global_position_int(Duration::from_secs(3), &state, state.course_rad, &LocalFrame::new(origin), 0.0);
        let expected = GLOBAL_POSITION_INT_DATA {
            time_boot_ms: 3000,
            lat: 399_800_000,
            lon: 1_163_400_000,
            alt: 70_500,
            relative_alt: 20_500,
            vx: 995,
            vy: -100,
            vz: -150,
            hdg: 35_427, // 360 - 5.7296 degrees
        };
        assert_eq!(message, Message::GLOBAL_POSITION_INT(expected));
    }

    proptest! {
        #[test]
        fn wire_rounding_is_within_single_precision(state in state()) {
            let rounded = wire_round(&state);
            prop_assert!((rounded.x_m - state.x_m).abs() <= 6e-8 * state.x_m.abs());
            prop_assert!((rounded.altitude_m - state.altitude_m).abs() <= 6e-8 * state.altitude_m.abs());
            prop_assert!((rounded.speed_mps - state.speed_mps).abs() <= 1e-6 + 1e-7 * state.speed_mps);
            let cross_m = state.speed_mps * wrap_pi(rounded.course_rad - state.course_rad);
            prop_assert!(cross_m.abs() <= 1e-6 + 1e-7 * state.speed_mps, "{cross_m}");
        }

        #[test]
        fn wire_rounding_twice_is_once(state in state()) {
            let once = wire_round(&state);
            prop_assert_eq!(bits(&wire_round(&once)), bits(&once));
        }

        // Near the axes one component of the velocity is tiny, and the course has the least to hold on to.
        #[test]
        fn wire_rounding_twice_is_once_near_the_axes(axis in 0..4u8, off in -1e-6..1e-6f64, speed in 0.0..20.0f64) {
            let course_rad = wrap_pi(f64::from(axis) * std::f64::consts::FRAC_PI_2 + off);
            let once = wire_round(&State { speed_mps: speed, course_rad, ..State::default() });
            prop_assert_eq!(bits(&wire_round(&once)), bits(&once));
        }

        #[test]
        fn the_heading_is_a_compass_heading(course in -1e3..1e3f64) {
            let heading = heading_cdeg(course);
            prop_assert!(heading < 36_000);
            let error = wrap_pi(f64::from(heading) / 100.0 * std::f64::consts::PI / 180.0 - course);
            prop_assert!(error.abs() < 1e-4);
        }
    }
}
