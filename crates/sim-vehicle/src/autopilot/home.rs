//! Home, and where altitudes and places of requests are in the local frame.

use flight_model::LocalFrame;
use mavlink_bridge::{AltitudeDatum, LatLonE7, PlanItem};
use nalgebra::Vector2;

/// A place to return to, in the local frame, and what altitudes above home are above.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Home {
    /// North of the origin, m.
    pub x_m: f64,
    /// East of the origin, m.
    pub y_m: f64,
    /// Above the origin, m.
    pub altitude_m: f64,
}

impl Home {
    /// At a place, (north, east) in m.
    pub fn new(place: Vector2<f64>, altitude_m: f64) -> Self {
        Self { x_m: place.x, y_m: place.y, altitude_m }
    }

    /// (north, east) in m.
    pub fn at(&self) -> Vector2<f64> {
        Vector2::new(self.x_m, self.y_m)
    }
}

/// The local frame and home: what turns places and altitudes of requests into those that are flown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference<'a> {
    pub frame: &'a LocalFrame,
    pub home: Home,
}

impl Reference<'_> {
    /// North and east of the origin, m, of a latitude and longitude.
    pub fn locate(&self, position: LatLonE7) -> Vector2<f64> {
        let (x_m, y_m, _) = self.frame.to_local(&position.to_geodetic(0.0));
        Vector2::new(x_m, y_m)
    }

    /// An altitude above a datum as one above the origin, m: terrain is as high as home.
    pub fn above_origin_m(&self, datum: AltitudeDatum, altitude_m: f64) -> f64 {
        match datum {
            AltitudeDatum::MeanSeaLevel => altitude_m - self.frame.origin().altitude_amsl_m,
            AltitudeDatum::Home | AltitudeDatum::Terrain => altitude_m + self.home.altitude_m,
        }
    }

    /// Where an item is, (north, east) in m; without a place, here.
    pub fn place_of(&self, item: &PlanItem, here: Vector2<f64>) -> Vector2<f64> {
        let position = item.position();
        if position.is_zero() { here } else { self.locate(position) }
    }

    /// The altitude of an item, m above the origin.
    pub fn altitude_of(&self, item: &PlanItem) -> f64 {
        self.above_origin_m(datum_of(item).unwrap_or(AltitudeDatum::Home), f64::from(item.z_m))
    }
}

/// What the altitude of an item is measured from; none in a frame that is not taken. In the mission's own it is the
/// sea.
pub(crate) fn datum_of(item: &PlanItem) -> Option<AltitudeDatum> {
    /// MAV_FRAME_MISSION.
    const MISSION: u8 = 2;
    if item.frame == MISSION { Some(AltitudeDatum::MeanSeaLevel) } else { item.altitude_datum() }
}
