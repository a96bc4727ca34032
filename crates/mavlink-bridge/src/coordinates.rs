//! Coordinates on the wire: latitude and longitude as integers, and the datum of an altitude by its coordinate frame
//! (MAV_FRAME, <https://mavlink.io/en/messages/common.html#MAV_FRAME>).

// The older numbers of the global frames are still in use.
#![allow(deprecated)]

use crate::dialect::MavFrame;
use flight_model::Geodetic;

/// A latitude and longitude in units of 1e-7 degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct LatLonE7 {
    /// Latitude, 1e-7 degrees, north positive.
    pub latitude_e7: i32,
    /// Longitude, 1e-7 degrees, east positive.
    pub longitude_e7: i32,
}

impl LatLonE7 {
    /// A latitude and a longitude in units of 1e-7 degrees.
    pub fn new(latitude_e7: i32, longitude_e7: i32) -> Self {
        Self { latitude_e7, longitude_e7 }
    }

    /// The nearest latitude and longitude to a place.
    ///
    /// ```
    /// use mavlink_bridge::LatLonE7;
    ///
    /// let place = flight_model::Geodetic { latitude_deg: 39.98, longitude_deg: 116.34, altitude_amsl_m: 50.0 };
    /// let lat_lon = LatLonE7::from_geodetic(&place);
    /// assert_eq!(lat_lon, LatLonE7::new(399_800_000, 1_163_400_000));
    /// assert!(lat_lon.is_valid());
    /// assert!(!LatLonE7::new(900_000_001, 0).is_valid());
    /// ```
    pub fn from_geodetic(place: &Geodetic) -> Self {
        Self {
            latitude_e7: (place.latitude_deg * 1e7).round() as i32,
            longitude_e7: (place.longitude_deg * 1e7).round() as i32,
        }
    }

    /// The place at this latitude and longitude with an altitude above mean sea level, m.
    pub fn to_geodetic(self, altitude_amsl_m: f64) -> Geodetic {
        Geodetic {
            latitude_deg: f64::from(self.latitude_e7) * 1e-7,
            longitude_deg: f64::from(self.longitude_e7) * 1e-7,
            altitude_amsl_m,
        }
    }

    /// Whether both are zero, by which most messages mean that no position is given.
    pub fn is_zero(self) -> bool {
        self == Self::default()
    }

    /// Whether both are in range.
    pub fn is_valid(self) -> bool {
        self.is_latitude_valid() && self.is_longitude_valid()
    }

    /// Whether the latitude is at most 90 degrees either way.
    pub fn is_latitude_valid(self) -> bool {
        self.latitude_e7.unsigned_abs() <= 900_000_000
    }

    /// Whether the longitude is at most 180 degrees either way.
    pub fn is_longitude_valid(self) -> bool {
        self.longitude_e7.unsigned_abs() <= 1_800_000_000
    }
}

/// The reference that an altitude in a global coordinate frame is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AltitudeDatum {
    /// Mean sea level.
    MeanSeaLevel,
    /// The vehicle's home position.
    Home,
    /// The terrain below.
    Terrain,
}

impl AltitudeDatum {
    /// The datum of altitudes in a coordinate frame, by its MAV_FRAME number; none if the frame is not a global one.
    ///
    /// ```
    /// use mavlink_bridge::AltitudeDatum;
    ///
    /// // MAV_FRAME_GLOBAL_RELATIVE_ALT and MAV_FRAME_LOCAL_NED.
    /// assert_eq!(AltitudeDatum::of_frame(3), Some(AltitudeDatum::Home));
    /// assert_eq!(AltitudeDatum::of_frame(1), None);
    /// ```
    pub fn of_frame(frame: u8) -> Option<Self> {
        match mav_frame(frame)? {
            MavFrame::MAV_FRAME_GLOBAL | MavFrame::MAV_FRAME_GLOBAL_INT => Some(Self::MeanSeaLevel),
            MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT | MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT => Some(Self::Home),
            MavFrame::MAV_FRAME_GLOBAL_TERRAIN_ALT | MavFrame::MAV_FRAME_GLOBAL_TERRAIN_ALT_INT => Some(Self::Terrain),
            _ => None,
        }
    }
}

/// The coordinate frame of a MAV_FRAME number; none if the dialect does not have it.
pub fn mav_frame(number: u8) -> Option<MavFrame> {
    num_traits::FromPrimitive::from_u8(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn only_the_six_global_frames_have_a_datum() {
        use AltitudeDatum::{Home, MeanSeaLevel, Terrain};
        let expected = [(0, MeanSeaLevel), (3, Home), (5, MeanSeaLevel), (6, Home), (10, Terrain), (11, Terrain)];
        let read: Vec<_> =
            (0..=255).filter_map(|frame| AltitudeDatum::of_frame(frame).map(|datum| (frame, datum))).collect();
        assert_eq!(read, expected);
    }

    #[test]
    fn the_poles_and_the_antimeridian_are_valid_and_nothing_beyond() {
        for (latitude_e7, longitude_e7) in [(900_000_000, 1_800_000_000), (-900_000_000, -1_800_000_000)] {
            let inside = LatLonE7::new(latitude_e7, longitude_e7);
            assert!(inside.is_valid() && !inside.is_zero());
            let north = LatLonE7::new(latitude_e7 + latitude_e7.signum(), longitude_e7);
            assert!(!north.is_latitude_valid() && north.is_longitude_valid() && !north.is_valid());
            let east = LatLonE7::new(latitude_e7, longitude_e7 + longitude_e7.signum());
            assert!(east.is_latitude_valid() && !east.is_longitude_valid() && !east.is_valid());
        }
        assert!(!LatLonE7::new(i32::MIN, i32::MIN).is_valid());
    }

    proptest! {
        #[test]
        fn degrees_and_back_is_the_same(
            latitude_e7 in -900_000_000..=900_000_000i32, longitude_e7 in -1_800_000_000..=1_800_000_000i32,
        ) {
            let position = LatLonE7::new(latitude_e7, longitude_e7);
            prop_assert_eq!(LatLonE7::from_geodetic(&position.to_geodetic(0.0)), position);
        }
    }
}
