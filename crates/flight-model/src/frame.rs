//! The local frame and WGS-84.

/// A place on the WGS-84 ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Latitude, degrees, north positive.
    pub latitude_deg: f64,
    /// Longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Altitude above mean sea level, m.
    pub altitude_amsl_m: f64,
}

/// A local frame whose X points north and Y east from an origin, altitude counted from the origin upwards.
///
/// North and east are lengths along the ellipsoid, scaled by its radii of curvature at the mean latitude of the origin
/// and the point, as autopilots do for the short ranges of a flight: within 10 km the distance between two points
/// agrees with the geodesic to a few parts in a million. It does not work at the poles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    origin: Geodetic,
}

/// Semi-major axis of WGS-84, m.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// First eccentricity squared of WGS-84.
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_141_316e-3;

impl LocalFrame {
    /// The frame at `origin`.
    pub fn new(origin: Geodetic) -> Self {
        Self { origin }
    }

    /// The origin.
    pub fn origin(&self) -> Geodetic {
        self.origin
    }

    /// From north, east and up of the origin, m, to WGS-84.
    pub fn to_geodetic(&self, x_m: f64, y_m: f64, altitude_m: f64) -> Geodetic {
        let latitude_0 = self.origin.latitude_deg.to_radians();
        // The radius depends on the mean latitude, which depends on the northing: two iterations are exact to 1e-12
        // rad.
        let mut latitude = latitude_0;
        for _ in 0..3 {
            let (meridian_m, _) = radii_m(0.5 * (latitude_0 + latitude));
            latitude = latitude_0 + x_m / meridian_m;
        }
        let (_, parallel_m) = radii_m(0.5 * (latitude_0 + latitude));
        Geodetic {
            latitude_deg: latitude.to_degrees(),
            longitude_deg: wrap_180(self.origin.longitude_deg + (y_m / parallel_m).to_degrees()),
            altitude_amsl_m: self.origin.altitude_amsl_m + altitude_m,
        }
    }

    /// From WGS-84 to (north, east, up) of the origin, m.
    pub fn to_local(&self, place: &Geodetic) -> (f64, f64, f64) {
        let latitude_0 = self.origin.latitude_deg.to_radians();
        let latitude = place.latitude_deg.to_radians();
        let (meridian_m, parallel_m) = radii_m(0.5 * (latitude_0 + latitude));
        let longitude_difference_deg = wrap_180(place.longitude_deg - self.origin.longitude_deg);
        (
            (latitude - latitude_0) * meridian_m,
            longitude_difference_deg.to_radians() * parallel_m,
            place.altitude_amsl_m - self.origin.altitude_amsl_m,
        )
    }
}

/// Radii of curvature along the meridian and of the parallel at a latitude, m.
fn radii_m(latitude_rad: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(latitude_rad);
    let w_squared = 1.0 - ECCENTRICITY_SQUARED * sin * sin;
    let w = w_squared.sqrt();
    (SEMI_MAJOR_M * (1.0 - ECCENTRICITY_SQUARED) / (w_squared * w), SEMI_MAJOR_M * cos / w)
}

fn wrap_180(degrees: f64) -> f64 {
    if (-180.0..=180.0).contains(&degrees) { degrees } else { degrees - 360.0 * ((degrees + 180.0) / 360.0).floor() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geographiclib_rs::{Geodesic, InverseGeodesic};
    use proptest::prelude::*;

    fn frame(latitude_deg: f64, longitude_deg: f64) -> LocalFrame {
        LocalFrame::new(Geodetic { latitude_deg, longitude_deg, altitude_amsl_m: 50.0 })
    }

    proptest! {
        #[test]
        fn there_and_back(lat in -80.0..80.0f64, lon in -180.0..180.0f64, x in -1e4..1e4f64, y in -1e4..1e4f64) {
            let frame = frame(lat, lon);
            let (north, east, up) = frame.to_local(&frame.to_geodetic(x, y, 12.5));
            prop_assert!((north - x).abs() < 1e-6, "{north} {x}");
            prop_assert!((east - y).abs() < 1e-6, "{east} {y}");
            prop_assert_eq!(up, 12.5);
        }

        #[test]
        fn distances_are_geodesic(lat in -60.0..60.0f64, x in -5e3..5e3f64, y in -5e3..5e3f64) {
            let there = frame(lat, 116.34).to_geodetic(x, y, 0.0);
            let geodesic_m: f64 = Geodesic::wgs84().inverse(lat, 116.34, there.latitude_deg, there.longitude_deg);
            let straight_m = (x * x + y * y).sqrt();
            prop_assert!((geodesic_m - straight_m).abs() <= 1e-6 * straight_m + 1e-6, "{geodesic_m} {straight_m}");
        }
    }
}
