//! What a PX4 makes of an uploaded fence (`geofence.cpp`): each polygon and circle for itself, and none that home, or in
//! flight the vehicle, is outside of.

use super::area::{Area, Place, Shape};
use flight_model::{Geodetic, LocalFrame};
use mavlink_bridge::PlanItem;

const RETURN_POINT: u16 = 5000;
const POLYGON_INCLUSION: u16 = 5001;
const POLYGON_EXCLUSION: u16 = 5002;
const CIRCLE_INCLUSION: u16 = 5003;
const CIRCLE_EXCLUSION: u16 = 5004;

/// The area that counts, and what is said of the parts that do not. `flying` is where a vehicle is that would act on a
/// breach at once.
pub(crate) fn area(
    items: &[PlanItem],
    frame: &LocalFrame,
    home: Place,
    flying: Option<Place>,
) -> (Area, Vec<&'static str>) {
    let (mut area, mut said) = (Area::default(), Vec::new());
    let mut rest = items;
    while let Some(item) = rest.first() {
        let (shape, taken) = match item.command {
            POLYGON_INCLUSION | POLYGON_EXCLUSION => polygon(rest, frame),
            CIRCLE_INCLUSION | CIRCLE_EXCLUSION => {
                let (centre, radius_m) = (place(item, frame), f64::from(item.params[0]));
                (Some(Shape::Circle { centre, radius_m }), 1)
            }
            _ => (None, 1),
        };
        rest = rest.get(taken..).unwrap_or_default();
        let is_inclusion = matches!(item.command, POLYGON_INCLUSION | CIRCLE_INCLUSION);
        let Some(shape) = shape else {
            if item.command != RETURN_POINT {
                said.push("Geofence invalid, unknown or incomplete item");
            }
            continue;
        };
        let holds = |place: Place| is_inside(&shape, place) == is_inclusion;
        if !holds(home) {
            said.push("Geofence invalid, doesn't contain Home position");
        } else if flying.is_some_and(|place| !holds(place)) {
            said.push("Geofence invalid, doesn't contain current vehicle position");
        } else if is_inclusion {
            area.inclusions.push(shape);
        } else {
            area.exclusions.push(shape);
        }
    }
    (area, said)
}

/// A circle of no radius has no inside.
fn is_inside(shape: &Shape, place: Place) -> bool {
    match shape {
        Shape::Circle { radius_m, .. } if *radius_m == 0.0 || !radius_m.is_finite() => false,
        shape => shape.contains(place),
    }
}

/// The polygon that begins the items, and how many of them it takes: so many as its first corner says. None where the plan
/// ends before it.
fn polygon(items: &[PlanItem], frame: &LocalFrame) -> (Option<Shape>, usize) {
    let count = items.first().map_or(0, |item| usize::from((item.params[0] + 0.5) as u16));
    match items.get(..count) {
        Some(corners) if count > 0 => {
            (Some(Shape::Polygon(corners.iter().map(|item| place(item, frame)).collect())), count)
        }
        _ => (None, items.len()),
    }
}

fn place(item: &PlanItem, frame: &LocalFrame) -> Place {
    let (north_m, east_m, _) = frame.to_local(&Geodetic {
        latitude_deg: f64::from(item.latitude_e7) * 1e-7,
        longitude_deg: f64::from(item.longitude_e7) * 1e-7,
        altitude_amsl_m: frame.origin().altitude_amsl_m,
    });
    Place::new(north_m, east_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;

    const HOME: Place = Place::new(0.0, 0.0);

    fn item(command: u16, p1: f32, at: Place) -> PlanItem {
        let at = VehicleSettings::default().frame.to_geodetic(at.x, at.y, 0.0);
        PlanItem {
            command,
            params: [p1, 0.0, 0.0, 0.0],
            latitude_e7: (at.latitude_deg * 1e7) as i32,
            longitude_e7: (at.longitude_deg * 1e7) as i32,
            ..PlanItem::default()
        }
    }

    fn square(command: u16, middle: Place) -> Vec<PlanItem> {
        let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
        corners.iter().map(|(dx, dy)| item(command, 4.0, middle + Place::new(*dx, *dy))).collect()
    }

    fn made(items: &[PlanItem], flying: Option<Place>) -> (usize, usize, Vec<&'static str>) {
        let (area, said) = area(items, &VehicleSettings::default().frame, HOME, flying);
        (area.inclusions.len(), area.exclusions.len(), said)
    }

    #[test]
    fn a_part_without_home_does_not_count_and_the_others_do() {
        let without_home = "Geofence invalid, doesn't contain Home position";
        let mut items = square(POLYGON_INCLUSION, HOME);
        items.push(item(CIRCLE_INCLUSION, 0.0, HOME));
        assert_eq!(made(&items, None), (1, 0, vec![without_home]));
        items.extend(square(POLYGON_EXCLUSION, Place::new(100.0, 0.0)));
        items.push(item(CIRCLE_EXCLUSION, 50.0, HOME));
        assert_eq!(made(&items, None), (1, 1, vec![without_home; 2]));
    }

    #[test]
    fn in_flight_the_vehicle_must_be_inside_too() {
        let items = square(POLYGON_INCLUSION, HOME);
        assert_eq!(made(&items, Some(Place::new(5.0, 5.0))), (1, 0, vec![]));
        let said = vec!["Geofence invalid, doesn't contain current vehicle position"];
        assert_eq!(made(&items, Some(Place::new(50.0, 5.0))), (0, 0, said));
    }

    #[test]
    fn what_makes_no_polygon_is_passed_over() {
        let said = vec!["Geofence invalid, unknown or incomplete item"];
        assert_eq!(made(&square(POLYGON_INCLUSION, HOME)[..3], None), (0, 0, said));
        assert_eq!(made(&[item(RETURN_POINT, 0.0, HOME)], None), (0, 0, vec![]));
    }
}
