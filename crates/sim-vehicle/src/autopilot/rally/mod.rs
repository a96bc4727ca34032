//! Rally points: places to return to that are nearer than home.

pub(crate) mod points;

use crate::autopilot::flight::Flight;
use crate::autopilot::flight::guidance::RallyPlace;
use crate::autopilot::home::Reference;
use crate::error::PlanError;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use mavlink_bridge::dialect::MavCmd;
use mavlink_bridge::{AltitudeDatum, PlanItem};
use points::Approach;

/// Most rally points, as on ArduPilot's larger boards.
pub(crate) const POINTS_MAX: u16 = 50;

const RALLY_POINT: u16 = MavCmd::MAV_CMD_NAV_RALLY_POINT as u32 as u16;

/// The rally points on board.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rally {
    /// What was written, those beyond the total included.
    stored: Vec<PlanItem>,
    /// Of each of them.
    approaches: Vec<Approach>,
    /// RALLY_TOTAL: how many of them count.
    total: usize,
}

/// Whether an item can be a rally point; the result code that says why not, in ArduPilot's order. It keeps altitudes in
/// 16 bits.
pub(crate) fn check(item: &PlanItem) -> Result<(), PlanError> {
    let altitudes_m = f32::from(i16::MIN)..=f32::from(i16::MAX);
    if item.command != RALLY_POINT {
        Err(PlanError::Unsupported)
    } else if !item.position().is_latitude_valid() {
        Err(PlanError::InvalidParam(5))
    } else if !item.position().is_longitude_valid() {
        Err(PlanError::InvalidParam(6))
    } else if !altitudes_m.contains(&item.z_m) {
        Err(PlanError::InvalidParam(7))
    } else if item.altitude_datum().is_none() {
        Err(PlanError::UnsupportedFrame)
    } else {
        Ok(())
    }
}

/// What ArduPilot keeps of a rally point: its place, and its altitude in whole metres above sea level, home or terrain.
pub(crate) fn as_kept(item: &PlanItem) -> PlanItem {
    let frame = match item.altitude_datum() {
        Some(AltitudeDatum::MeanSeaLevel) => 0,
        Some(AltitudeDatum::Home) => 3,
        Some(AltitudeDatum::Terrain) | None => 10,
    };
    let PlanItem { command, latitude_e7, longitude_e7, .. } = *item;
    PlanItem { command, frame, latitude_e7, longitude_e7, z_m: item.z_m.trunc(), ..PlanItem::default() }
}

/// A point of RALLY_TOTAL that nobody has written has a place of zeros.
pub(crate) fn is_there(item: &PlanItem) -> bool {
    !item.position().is_zero()
}

impl Rally {
    pub fn items(&self) -> &[PlanItem] {
        self.stored.get(..self.total).unwrap_or_default()
    }

    pub fn replace(&mut self, items: &[PlanItem]) {
        self.set_total(u16::try_from(items.len()).unwrap_or(POINTS_MAX));
        let slots = self.stored.iter_mut().zip(&mut self.approaches);
        for ((stored, approach), item) in slots.zip(items) {
            (*stored, *approach) = (as_kept(item), Approach::of(item));
        }
    }

    /// The rally point to return to from here: the nearest, if it is within RALLY_LIMIT_KM and, where home counts too
    /// (RALLY_INCL_HOME), nearer than home. None means home.
    pub fn best(&self, flight: &Flight, reference: &Reference<'_>, parameters: &Parameters) -> Option<RallyPlace> {
        let limit_m = 1000.0 * f64::from(parameters.get(Parameter::RallyLimit));
        let home_counts = parameters.get(Parameter::RallyIncludesHome) != 0.0;
        let points = self.items().iter().filter(|item| is_there(item)).map(|item| {
            let at = reference.place_of(item, flight.here());
            (flight.distance_m(at), RallyPlace { at, altitude_m: reference.altitude_of(item) })
        });
        points
            .min_by(|(near_m, _), (far_m, _)| near_m.total_cmp(far_m))
            .filter(|(away_m, _)| limit_m <= 0.0 || *away_m <= limit_m)
            .filter(|(away_m, _)| !home_counts || *away_m < flight.distance_m(reference.home.at()))
            .map(|(_, place)| place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::Autopilot;
    use crate::settings::VehicleSettings;

    fn point(latitude_e7: i32, z_m: f32) -> PlanItem {
        PlanItem {
            command: RALLY_POINT,
            frame: 3,
            latitude_e7,
            longitude_e7: 1_163_400_000,
            z_m,
            ..PlanItem::default()
        }
    }

    #[test]
    fn what_is_no_rally_point_is_refused_by_its_code() {
        let good = point(399_800_000, 90.0);
        assert_eq!(check(&good), Ok(()));
        for (item, result) in [
            (PlanItem { command: 16, ..good }, PlanError::Unsupported),
            (PlanItem { latitude_e7: i32::MIN, ..good }, PlanError::InvalidParam(5)),
            (PlanItem { longitude_e7: i32::MAX, ..good }, PlanError::InvalidParam(6)),
            (PlanItem { z_m: f32::NAN, ..good }, PlanError::InvalidParam(7)),
            (PlanItem { z_m: 40_000.0, ..good }, PlanError::InvalidParam(7)),
            (PlanItem { frame: 1, ..good }, PlanError::UnsupportedFrame),
        ] {
            assert_eq!(check(&item), Err(result), "{item:?}");
        }
    }

    #[test]
    fn the_nearest_point_within_the_limit_is_gone_to() {
        let mut vehicle = Autopilot::new(&VehicleSettings::default(), false);
        let altitude_m = |vehicle: &Autopilot| vehicle.best_rally().map(|rally| rally.altitude_m);
        assert_eq!(altitude_m(&vehicle), None);
        // About 3.3 and 1.1 km to the north, 80 and 90 m above home.
        vehicle.rally.replace(&[point(400_100_000, 80.0), point(399_900_000, 90.0)]);
        assert_eq!(altitude_m(&vehicle), Some(90.0));
        vehicle.set_parameter(Parameter::RallyLimit, 1.0).unwrap();
        assert_eq!(altitude_m(&vehicle), None);
        vehicle.set_parameter(Parameter::RallyLimit, 0.0).unwrap();
        vehicle.set_parameter(Parameter::RallyIncludesHome, 1.0).unwrap();
        assert_eq!(altitude_m(&vehicle), None);
    }
}
