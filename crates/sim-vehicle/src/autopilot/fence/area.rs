//! Where a vehicle may be, from above: polygons and circles to stay in and to stay out of. Knows no MAVLink.

use nalgebra::Vector2;

/// A place in the local frame, (north, east) in m.
pub(crate) type Place = Vector2<f64>;

/// What a fence encloses.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Area {
    pub inclusions: Vec<Shape>,
    pub exclusions: Vec<Shape>,
    /// Where a vehicle that has left it is sent.
    pub return_point: Option<Place>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Corners in order; the last joins the first.
    Polygon(Vec<Place>),
    Circle {
        centre: Place,
        radius_m: f64,
    },
}

impl Area {
    /// Whether it has no shape at all: then nobody can leave it.
    pub fn is_open(&self) -> bool {
        self.inclusions.is_empty() && self.exclusions.is_empty()
    }

    /// Whether a place is forbidden: in an exclusion, or outside one of the inclusions, or, where the inclusions are
    /// one union, outside all of them.
    pub fn forbids(&self, place: Place, inclusions_are_one: bool) -> bool {
        if self.exclusions.iter().any(|shape| shape.contains(place)) {
            return true;
        }
        if inclusions_are_one {
            !self.inclusions.is_empty() && !self.inclusions.iter().any(|shape| shape.contains(place))
        } else {
            !self.inclusions.iter().all(|shape| shape.contains(place))
        }
    }

    /// The return point; without one, the middle of the box round the first polygon to stay in, as in ArduPilot.
    pub fn way_back(&self) -> Option<Place> {
        let first = || self.inclusions.iter().find_map(Shape::middle);
        self.return_point.or_else(first)
    }
}

impl Shape {
    /// By the number of edges that a ray to the north meets: odd inside. A place on an edge may be on either side.
    pub fn contains(&self, place: Place) -> bool {
        match self {
            Shape::Circle { centre, radius_m } => (place - centre).norm_squared() <= radius_m * radius_m,
            Shape::Polygon(corners) => {
                let mut is_inside = false;
                let Some(&(mut from)) = corners.last() else { return false };
                for &to in corners {
                    // Half open: a ray through a corner meets one of its two edges.
                    let is_met = (from.y > place.y) != (to.y > place.y);
                    if is_met && place.x < from.x + (to.x - from.x) * (place.y - from.y) / (to.y - from.y) {
                        is_inside = !is_inside;
                    }
                    from = to;
                }
                is_inside
            }
        }
    }

    fn middle(&self) -> Option<Place> {
        let Shape::Polygon(corners) = self else { return None };
        let first = *corners.first()?;
        let (mut least, mut most) = (first, first);
        for corner in corners {
            least = least.inf(corner);
            most = most.sup(corner);
        }
        Some(0.5 * (least + most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// (north, east) in m.
    type Pair = (f64, f64);

    const SQUARE: [Pair; 4] = [(-10.0, -10.0), (-10.0, 10.0), (10.0, 10.0), (10.0, -10.0)];

    fn at((x, y): Pair) -> Place {
        Place::new(x, y)
    }

    fn polygon(corners: &[Pair]) -> Shape {
        Shape::Polygon(corners.iter().copied().map(at).collect())
    }

    fn cross((ax, ay): Pair, (bx, by): Pair) -> f64 {
        ax * by - ay * bx
    }

    /// How often the polygon goes round the place, by the angles at which its corners are seen.
    fn turns(corners: &[Pair], (x, y): Pair) -> i64 {
        let seen = |corner: Pair| (corner.0 - x, corner.1 - y);
        let angle = |from: Pair, to: Pair| libm::atan2(cross(from, to), from.0 * to.0 + from.1 * to.1);
        let next = corners.iter().cycle().skip(1);
        let sum: f64 = corners.iter().zip(next).map(|(from, to)| angle(seen(*from), seen(*to))).sum();
        (sum / TAU).round() as i64
    }

    fn corners() -> impl Strategy<Value = Vec<Pair>> {
        prop::collection::vec((-100.0..100.0f64, -100.0..100.0f64), 3..20)
    }

    proptest! {
        /// Any polygon, crossing itself or not: inside where it goes round an odd number of times.
        #[test]
        fn inside_is_where_it_goes_round_an_odd_number_of_times(
            corners in corners(), place in (-120.0..120.0f64, -120.0..120.0f64),
        ) {
            prop_assert_eq!(polygon(&corners).contains(at(place)), turns(&corners, place) % 2 != 0);
        }

        #[test]
        fn neither_the_first_corner_nor_the_sense_nor_a_closing_corner_counts(
            corners in corners(), place in (-120.0..120.0f64, -120.0..120.0f64), first in 0..20usize,
        ) {
            let expected = turns(&corners, place) % 2 != 0;
            let mut other = corners.clone();
            other.rotate_left(first % corners.len());
            prop_assert_eq!(polygon(&other).contains(at(place)), expected);
            other.reverse();
            prop_assert_eq!(polygon(&other).contains(at(place)), expected);
            other.push(other[0]);
            prop_assert_eq!(polygon(&other).contains(at(place)), expected);
        }

        /// Neighbours share edges, and every place is in one of them: none falls between, none is in both.
        #[test]
        fn a_place_on_a_common_edge_is_on_one_side_of_it(place in (-10.0..10.0f64, -10.0..10.0f64), on_edge in 0..3u8) {
            let west = [(-11.0, -11.0), (11.0, -11.0), (11.0, 0.0), (-11.0, 0.0)];
            let east = [(-11.0, 0.0), (11.0, 0.0), (11.0, 11.0), (-11.0, 11.0)];
            let place = if on_edge == 0 { (place.0, 0.0) } else { place };
            prop_assert!(polygon(&west).contains(at(place)) != polygon(&east).contains(at(place)));
        }
    }

    #[test]
    fn a_polygon_that_touches_itself_in_a_corner_has_two_rooms() {
        let hourglass = polygon(&[(0.0, 0.0), (10.0, -5.0), (10.0, 5.0), (0.0, 0.0), (-10.0, 5.0), (-10.0, -5.0)]);
        for (place, inside) in [((8.0, 0.0), true), ((-8.0, 0.0), true), ((0.5, 4.0), false), ((0.0, -1.0), false)] {
            assert_eq!(hourglass.contains(at(place)), inside, "{place:?}");
        }
    }

    #[test]
    fn what_is_forbidden() {
        let near = Shape::Circle { centre: Place::zeros(), radius_m: 20.0 };
        let hole = Shape::Circle { centre: Place::zeros(), radius_m: 2.0 };
        let area = Area { inclusions: vec![polygon(&SQUARE), near], exclusions: vec![hole], return_point: None };
        for (place, of_all, of_any) in [
            ((5.0, 5.0), false, false),
            ((1.0, 1.0), true, true),
            ((15.0, 0.0), true, false),
            ((25.0, 0.0), true, true),
        ] {
            assert_eq!((area.forbids(at(place), false), area.forbids(at(place), true)), (of_all, of_any), "{place:?}");
        }
        assert!(!Area::default().forbids(at((1e6, 0.0)), false) && !Area::default().forbids(at((1e6, 0.0)), true));
    }

    #[test]
    fn the_way_back_is_the_return_point_or_the_middle() {
        let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (2.0, 10.0)];
        let mut area = Area { inclusions: vec![polygon(&corners)], ..Area::default() };
        assert_eq!(area.way_back(), Some(at((10.0, 5.0))));
        area.return_point = Some(at((1.0, 2.0)));
        assert_eq!(area.way_back(), Some(at((1.0, 2.0))));
        let hole = Shape::Circle { centre: Place::zeros(), radius_m: 2.0 };
        assert_eq!(Area { exclusions: vec![hole], ..Area::default() }.way_back(), None);
    }
}
