//! A fence as it is uploaded: its items, checked as ArduPilot checks them, and the area that they make.

use super::area::{Area, Place, Shape};
use crate::error::PlanError;
use flight_model::{Geodetic, LocalFrame};
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::MavCmd;

pub(super) const RETURN_POINT: u16 = MavCmd::MAV_CMD_NAV_FENCE_RETURN_POINT as u32 as u16;
pub(super) const POLYGON_INCLUSION: u16 = MavCmd::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION as u32 as u16;
const POLYGON_EXCLUSION: u16 = MavCmd::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION as u32 as u16;
const CIRCLE_INCLUSION: u16 = MavCmd::MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION as u32 as u16;
const CIRCLE_EXCLUSION: u16 = MavCmd::MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION as u32 as u16;

/// Most corners of one polygon.
const CORNERS_MAX: f32 = 255.0;

/// Whether an item can be part of a fence; the result code that says why not. Param 1 is a number of corners or a
/// radius.
pub(crate) fn check(item: &PlanItem) -> Result<(), PlanError> {
    if item.altitude_datum().is_none() {
        return Err(PlanError::UnsupportedFrame);
    }
    let p1 = item.params[0];
    match item.command {
        RETURN_POINT => Ok(()),
        POLYGON_INCLUSION | POLYGON_EXCLUSION if p1.is_finite() && p1 <= CORNERS_MAX => Ok(()),
        CIRCLE_INCLUSION | CIRCLE_EXCLUSION if p1.is_finite() => Ok(()),
        POLYGON_INCLUSION | POLYGON_EXCLUSION | CIRCLE_INCLUSION | CIRCLE_EXCLUSION => Err(PlanError::InvalidParam(1)),
        _ => Err(PlanError::Unsupported),
    }
}

/// What ArduPilot keeps of an item: its command, its place, and a radius or a whole number of corners.
pub(super) fn as_kept(item: &PlanItem) -> PlanItem {
    let p1 = match item.command {
        CIRCLE_INCLUSION | CIRCLE_EXCLUSION => item.params[0],
        POLYGON_INCLUSION | POLYGON_EXCLUSION => item.params[0].trunc(),
        _ => 0.0,
    };
    let PlanItem { command, latitude_e7, longitude_e7, .. } = *item;
    PlanItem { command, latitude_e7, longitude_e7, params: [p1, 0.0, 0.0, 0.0], ..PlanItem::default() }
}

/// The area that checked items make, or, in ArduPilot's words, why they make none.
pub(super) fn area(items: &[PlanItem], frame: &LocalFrame) -> Result<Area, PlanError> {
    let mut area = Area::default();
    let mut rest = items;
    while let Some(item) = rest.first() {
        let place = place(item, frame)?;
        let taken = match item.command {
            RETURN_POINT => {
                if area.return_point.replace(place).is_some() {
                    return Err(PlanError::ReturnPoints);
                }
                1
            }
            CIRCLE_INCLUSION | CIRCLE_EXCLUSION => {
                let radius_m = f64::from(item.params[0]);
                if radius_m <= 0.0 {
                    return Err(PlanError::Radius);
                }
                let circle = Shape::Circle { centre: place, radius_m };
                let shapes = if item.command == CIRCLE_INCLUSION { &mut area.inclusions } else { &mut area.exclusions };
                shapes.push(circle);
                1
            }
            _ => {
                let corners = corners(rest, frame)?;
                let count = corners.len();
                let shapes =
                    if item.command == POLYGON_INCLUSION { &mut area.inclusions } else { &mut area.exclusions };
                shapes.push(Shape::Polygon(corners));
                count
            }
        };
        rest = rest.get(taken..).unwrap_or_default();
    }
    Ok(area)
}

/// Whether checked items make a fence anywhere.
pub(crate) fn check_whole(items: &[PlanItem]) -> Result<(), PlanError> {
    let anywhere = Geodetic { latitude_deg: 0.0, longitude_deg: 0.0, altitude_amsl_m: 0.0 };
    area(items, &LocalFrame::new(anywhere)).map(drop)
}

/// FENCE_TOTAL: from the time of fences of one polygon, closed, and a return point. So it is two more than there are
/// corners and circles, and 0 where they are fewer than three.
pub(super) fn total(items: &[PlanItem]) -> u8 {
    match items.iter().filter(|item| item.command != RETURN_POINT).count() {
        0..3 => 0,
        count => u8::try_from(count + 2).unwrap_or(u8::MAX),
    }
}

/// The corners of the polygon that begins the items. Every corner says how many there are.
fn corners(items: &[PlanItem], frame: &LocalFrame) -> Result<Vec<Place>, PlanError> {
    let Some(first) = items.first() else { return Ok(Vec::new()) };
    let stated = |item: &PlanItem| item.params[0] as u8;
    let wanted = stated(first);
    let mut corners = Vec::new();
    for item in items.iter().take(usize::from(wanted).max(1)) {
        let count = stated(item);
        let is_corner = matches!(item.command, POLYGON_INCLUSION | POLYGON_EXCLUSION);
        if is_corner && count < 3 {
            return Err(PlanError::TooFewVertices(count));
        }
        if item.command != first.command {
            let what = if is_corner { "vertex type" } else { "type" };
            return Err(PlanError::Command { what, wanted: first.command, got: item.command });
        }
        if count != wanted {
            return Err(PlanError::VertexCount { wanted, got: count });
        }
        corners.push(place(item, frame)?);
    }
    if corners.len() < usize::from(wanted) { Err(PlanError::ItemCount) } else { Ok(corners) }
}

fn place(item: &PlanItem, frame: &LocalFrame) -> Result<Place, PlanError> {
    if !item.position().is_valid() {
        return Err(PlanError::Position);
    }
    let (north_m, east_m, _) = frame.to_local(&item.position().to_geodetic(frame.origin().altitude_amsl_m));
    Ok(Place::new(north_m, east_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;

    fn item(command: u16, p1: f32) -> PlanItem {
        let (latitude_e7, longitude_e7) = (399_800_000, 1_163_400_000);
        PlanItem { command, params: [p1, 0.0, 0.0, 0.0], latitude_e7, longitude_e7, ..PlanItem::default() }
    }

    fn made(items: &[PlanItem]) -> Result<Area, PlanError> {
        area(items, &VehicleSettings::default().frame)
    }

    #[test]
    fn items_make_shapes() {
        let triangle = [item(POLYGON_INCLUSION, 3.0); 3];
        let rest = [item(CIRCLE_EXCLUSION, 50.0), item(RETURN_POINT, 0.0)];
        let area = made(&[&triangle[..], &[item(POLYGON_EXCLUSION, 4.9); 4], &rest].concat()).unwrap();
        assert!(matches!(&area.inclusions[..], [Shape::Polygon(corners)] if corners.len() == 3));
        assert!(matches!(&area.exclusions[..], [Shape::Polygon(corners), Shape::Circle { .. }] if corners.len() == 4));
        assert!(area.return_point.unwrap().amax() < 0.02);
        assert_eq!(made(&[]), Ok(Area::default()));
        assert_eq!(total(&[&triangle[..], &[item(RETURN_POINT, 0.0)]].concat()), 5);
        assert_eq!((total(&triangle), total(&rest), total(&[])), (5, 0, 0));
    }

    #[test]
    fn what_makes_no_sense_as_a_whole_is_put_into_words() {
        let bad = PlanItem { latitude_e7: 900_000_001, ..item(RETURN_POINT, 0.0) };
        for (items, words) in [
            (vec![item(POLYGON_INCLUSION, 2.0); 2], "Invalid vertex count (2)"),
            (vec![item(POLYGON_INCLUSION, -3.0); 3], "Invalid vertex count (0)"),
            (vec![item(POLYGON_INCLUSION, 3.0); 2], "Incorrect item count"),
            (vec![item(POLYGON_INCLUSION, 3.0), item(POLYGON_INCLUSION, 4.0)], "Unexpected vertex count want=3 got=4"),
            (
                vec![item(POLYGON_INCLUSION, 3.0), item(POLYGON_EXCLUSION, 3.0)],
                "Received incorrect vertex type (want=5001 got=5002)",
            ),
            (
                vec![item(POLYGON_INCLUSION, 3.0), item(RETURN_POINT, 0.0)],
                "Received incorrect type (want=5001 got=5000)",
            ),
            (vec![item(CIRCLE_INCLUSION, 0.0)], "Non-positive circle radius"),
            (vec![item(RETURN_POINT, 0.0); 2], "Multiple return points"),
            (vec![bad], "Bad lat or lon"),
        ] {
            assert_eq!(made(&items).unwrap_err().to_string(), words);
        }
    }

    #[test]
    fn what_cannot_be_part_of_a_fence_is_refused_by_its_code() {
        assert_eq!(check(&item(RETURN_POINT, f32::NAN)), Ok(()));
        for (item, result) in [
            (item(16, 0.0), PlanError::Unsupported),
            (PlanItem { frame: 1, ..item(RETURN_POINT, 0.0) }, PlanError::UnsupportedFrame),
            (item(POLYGON_EXCLUSION, 256.0), PlanError::InvalidParam(1)),
            (item(POLYGON_INCLUSION, f32::NAN), PlanError::InvalidParam(1)),
            (item(CIRCLE_EXCLUSION, f32::INFINITY), PlanError::InvalidParam(1)),
        ] {
            assert_eq!(check(&item), Err(result), "{item:?}");
        }
    }
}
