//! Places as messages tell them: WGS-84 in integers, and in the flight's own frame.

use flight_model::{Geodetic, LocalFrame, State, wrap_pi};
use mavlink_bridge::dialect::{GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA, HOME_POSITION_DATA};

/// 1e-7 degrees of latitude, m.
const METRES_PER_UNIT: f64 = 0.011_132;
/// A vehicle that is slower than this stands: its velocity has no direction, m/s.
const STANDS_MPS: f64 = 0.3;

/// Whether a position is one. Before its estimator has a fix, ArduPilot tells places within metres of 0, 0.
pub fn is_known(data: &GLOBAL_POSITION_INT_DATA) -> bool {
    data.lat.abs() >= 10_000 || data.lon.abs() >= 10_000
}

/// The place of a GLOBAL_POSITION_INT.
pub fn of_position(data: &GLOBAL_POSITION_INT_DATA) -> Geodetic {
    geodetic(data.lat, data.lon, data.alt)
}

/// The place of a HOME_POSITION.
pub fn of_home(data: &HOME_POSITION_DATA) -> Geodetic {
    geodetic(data.latitude, data.longitude, data.altitude)
}

/// The place of a GPS_GLOBAL_ORIGIN.
pub fn of_origin(data: &GPS_GLOBAL_ORIGIN_DATA) -> Geodetic {
    geodetic(data.latitude, data.longitude, data.altitude)
}

/// How far apart two positions are, heights not counted, m.
pub fn apart_m(a: &GLOBAL_POSITION_INT_DATA, b: &GLOBAL_POSITION_INT_DATA) -> f64 {
    let north_m = f64::from(a.lat.abs_diff(b.lat)) * METRES_PER_UNIT;
    let east_m =
        f64::from(a.lon.abs_diff(b.lon)) * METRES_PER_UNIT * libm::cos(of_position(a).latitude_deg.to_radians());
    libm::hypot(north_m, east_m)
}

/// GLOBAL_POSITION_INT in a local frame, at full precision
/// (<https://mavlink.io/en/messages/common.html#GLOBAL_POSITION_INT>). A vehicle that stands has the course of its
/// nose.
pub fn state(data: &GLOBAL_POSITION_INT_DATA, frame: &LocalFrame) -> State {
    let (x_m, y_m, altitude_m) = frame.to_local(&of_position(data));
    let (north_mps, east_mps) = (0.01 * f64::from(data.vx), 0.01 * f64::from(data.vy));
    let speed_mps = (north_mps * north_mps + east_mps * east_mps).sqrt();
    let course_rad = if speed_mps < STANDS_MPS && data.hdg != u16::MAX {
        (0.01 * f64::from(data.hdg)).to_radians()
    } else {
        libm::atan2(east_mps, north_mps)
    };
    State { x_m, y_m, altitude_m, speed_mps, course_rad: wrap_pi(course_rad), climb_mps: -0.01 * f64::from(data.vz) }
}

fn geodetic(latitude: i32, longitude: i32, altitude_mm: i32) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(latitude) * 1e-7,
        longitude_deg: f64::from(longitude) * 1e-7,
        altitude_amsl_m: f64::from(altitude_mm) * 1e-3,
    }
}
