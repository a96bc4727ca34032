//! Rally points by ArduPilot's older protocol (RALLY_POINT, GCS_Rally.cpp), one by one. RALLY_TOTAL is how many there
//! are.

use super::{POINTS_MAX, RALLY_POINT, Rally, is_there};
use mavlink_bridge::{AltitudeDatum, LatLonE7, PlanItem, RallyPoint};

/// Bits of RALLY_FLAGS: whether the altitude says above what it is, and what.
const FRAME_IS_GIVEN: u8 = 1 << 2;
const FRAME_SHIFT: u8 = 3;
const FRAME_MASK: u8 = 3;
/// ArduPilot's numbers of them.
const ABOVE_SEA: u8 = 0;
const ABOVE_HOME: u8 = 1;
const ABOVE_TERRAIN: u8 = 3;

/// What an approach to land is told beside the place; it is only kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Approach {
    break_altitude_m: i16,
    land_direction_cdeg: u16,
    /// RALLY_FLAGS.
    flags: u8,
}

impl Approach {
    /// That of a point that was uploaded as an item.
    pub fn of(item: &PlanItem) -> Self {
        let above = match item.altitude_datum() {
            Some(AltitudeDatum::MeanSeaLevel) => ABOVE_SEA,
            Some(AltitudeDatum::Home) | None => ABOVE_HOME,
            Some(AltitudeDatum::Terrain) => ABOVE_TERRAIN,
        };
        Self { flags: FRAME_IS_GIVEN | above << FRAME_SHIFT, ..Self::default() }
    }
}

/// Why a rally point is neither taken nor given, in ArduPilot's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum RallyPointError {
    #[error("Bad rally point ID")]
    Index,
    #[error("Bad rally point count")]
    Count,
    #[error("Failed to get rally point")]
    Empty,
    /// Of this it says nothing.
    #[error("Bad rally point place")]
    Position,
}

impl Rally {
    /// RALLY_TOTAL is set. Points beyond it stay as they were written, and are there again when it grows.
    pub fn set_total(&mut self, total: u16) {
        self.total = usize::from(total.min(POINTS_MAX));
        let length = self.stored.len().max(self.total);
        let nowhere = PlanItem { command: RALLY_POINT, frame: 3, ..PlanItem::default() };
        self.stored.resize(length, nowhere);
        self.approaches.resize(length, Approach::default());
    }

    /// Takes a point.
    pub fn set_point(&mut self, point: &RallyPoint) -> Result<(), RallyPointError> {
        let index = usize::from(point.index);
        if index >= self.total {
            return Err(RallyPointError::Index);
        }
        if usize::from(point.count) != self.total {
            return Err(RallyPointError::Count);
        }
        let RallyPoint { latitude_e7, longitude_e7, altitude_m, break_altitude_m, land_direction_cdeg, flags, .. } =
            *point;
        if !LatLonE7::new(latitude_e7, longitude_e7).is_valid() {
            return Err(RallyPointError::Position);
        }
        let frame = match (flags >> FRAME_SHIFT) & FRAME_MASK {
            ABOVE_SEA if flags & FRAME_IS_GIVEN != 0 => 0,
            ABOVE_TERRAIN if flags & FRAME_IS_GIVEN != 0 => 10,
            _ => 3,
        };
        let z_m = f32::from(altitude_m);
        self.stored[index] =
            PlanItem { command: RALLY_POINT, frame, latitude_e7, longitude_e7, z_m, ..PlanItem::default() };
        self.approaches[index] = Approach { break_altitude_m, land_direction_cdeg, flags };
        Ok(())
    }

    /// A point, for RALLY_FETCH_POINT.
    pub fn point(&self, index: u8) -> Result<RallyPoint, RallyPointError> {
        let at = usize::from(index);
        if at > self.total {
            return Err(RallyPointError::Index);
        }
        let item = self.items().get(at).filter(|item| is_there(item)).ok_or(RallyPointError::Empty)?;
        let Approach { break_altitude_m, land_direction_cdeg, flags } = self.approaches[at];
        Ok(RallyPoint {
            index,
            count: self.total as u8,
            latitude_e7: item.latitude_e7,
            longitude_e7: item.longitude_e7,
            altitude_m: item.z_m as i16,
            break_altitude_m,
            land_direction_cdeg,
            flags,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(index: u8, count: u8) -> RallyPoint {
        let (latitude_e7, longitude_e7) = (-353_000_000, 1_491_000_000 + i32::from(index));
        RallyPoint { index, count, latitude_e7, longitude_e7, altitude_m: 90, flags: 2, ..RallyPoint::default() }
    }

    #[test]
    fn points_are_written_one_by_one_and_read_again() {
        let mut rally = Rally::default();
        rally.set_total(2);
        assert_eq!(rally.set_point(&point(0, 2)), Ok(()));
        let given = RallyPoint { flags: 4, break_altitude_m: 40, land_direction_cdeg: 9000, ..point(1, 2) };
        assert_eq!(rally.set_point(&given), Ok(()));
        assert_eq!((rally.point(0), rally.point(1)), (Ok(point(0, 2)), Ok(given)));
        assert_eq!(rally.items().iter().map(|item| item.frame).collect::<Vec<_>>(), [3, 0]);
    }

    #[test]
    fn refusals_are_arduplanes() {
        let mut rally = Rally::default();
        rally.set_total(2);
        assert_eq!(rally.set_point(&point(2, 2)), Err(RallyPointError::Index));
        assert_eq!(rally.set_point(&point(1, 3)), Err(RallyPointError::Count));
        let nowhere = RallyPoint { latitude_e7: 900_000_001, ..point(0, 2) };
        assert_eq!(rally.set_point(&nowhere), Err(RallyPointError::Position));
        // One past the end is looked for, as in ArduPilot.
        assert_eq!(rally.point(0), Err(RallyPointError::Empty));
        assert_eq!((rally.point(2), rally.point(3)), (Err(RallyPointError::Empty), Err(RallyPointError::Index)));
    }

    #[test]
    fn points_beyond_the_total_are_there_again_when_it_grows() {
        let mut rally = Rally::default();
        rally.set_total(2);
        rally.set_point(&point(1, 2)).unwrap();
        rally.set_total(0);
        assert!(rally.items().is_empty());
        rally.set_total(2);
        assert_eq!(rally.point(1), Ok(point(1, 2)));
    }
}
