//! Positions on the globe: GLOBAL_POSITION_INT, GPS_RAW_INT and GPS_GLOBAL_ORIGIN.

// Clients still request messages that the dialect marks as superseded.
#![allow(deprecated)]

use super::heading_cdeg;
use crate::boot_ms;
use crate::coordinates::LatLonE7;
use crate::dialect::{GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA, GPS_RAW_INT_DATA, GpsFixType, Message};
use flight_model::{Geodetic, LocalFrame, State};
use std::time::Duration;

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
    // A float to integer cast takes the bound when it overflows and zero for NaN.
    let velocity_cmps = (state.velocity_mps() * 1e2).map(|cmps| cmps.round() as i16);
    Message::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
        time_boot_ms: boot_ms(time_boot),
        lat: latitude_e7,
        lon: longitude_e7,
        alt: (place.altitude_amsl_m * 1e3).round() as i32,
        relative_alt: ((state.altitude_m - home_altitude_m) * 1e3).round() as i32,
        vx: velocity_cmps.x,
        vy: velocity_cmps.y,
        vz: (-state.climb_mps * 1e2).round() as i16,
        hdg: heading_cdeg(heading_rad),
    })
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
/// (<https://mavlink.io/en/messages/common.html#GPS_RAW_INT>). Without a fix the place is the last one, and what cannot
/// be known says so.
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
