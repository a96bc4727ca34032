//! Who is near to whom, and to which circle: horizontal distances between places of one moment.

use crate::scene::{Circle, VehicleNow};

/// What is near to a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Distance to the nearest vehicle in the air, m; infinite without one.
    pub separation_m: f32,
    /// Its index.
    pub nearest: Option<usize>,
    /// Distance to the edge of the nearest circle, m, negative within it; infinite without circles.
    pub clearance_m: f32,
}

const NOTHING: Near = Near { separation_m: f32::INFINITY, nearest: None, clearance_m: f32::INFINITY };

/// What is near to each vehicle. Those on the ground, and those of which nobody knows where they are, are near to
/// nothing.
pub fn near(vehicles: &[VehicleNow], circles: &[Circle]) -> Vec<Near> {
    let mut near = vec![NOTHING; vehicles.len()];
    let mut order: Vec<usize> =
        (0..vehicles.len()).filter(|&index| vehicles[index].is_placed() && !vehicles[index].is_on_ground).collect();
    // Along the longer side of the flock the sweep passes the fewest vehicles.
    let spread = |of: fn(&VehicleNow) -> f32| {
        let ends = order.iter().map(|&index| of(&vehicles[index]));
        let (low, high) =
            ends.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        high - low
    };
    let along: fn(&VehicleNow) -> f32 =
        if spread(|one| one.x_m) >= spread(|one| one.y_m) { |v| v.x_m } else { |v| v.y_m };
    order.sort_unstable_by(|&a, &b| along(&vehicles[a]).total_cmp(&along(&vehicles[b])));
    for (place, &index) in order.iter().enumerate() {
        let own = &vehicles[index];
        let mut best = NOTHING;
        let mut look = |other: usize| -> bool {
            let one = &vehicles[other];
            if (along(one) - along(own)).abs() >= best.separation_m {
                return false;
            }
            let (north_m, east_m) = (one.x_m - own.x_m, one.y_m - own.y_m);
            let distance_m = (north_m * north_m + east_m * east_m).sqrt();
            if distance_m < best.separation_m {
                (best.separation_m, best.nearest) = (distance_m, Some(other));
            }
            true
        };
        let after = order[place + 1..].iter().take_while(|&&other| look(other)).count();
        let before = order[..place].iter().rev().take_while(|&&other| look(other)).count();
        let _ = (after, before);
        best.clearance_m = clearance_m(own, circles);
        near[index] = best;
    }
    near
}

fn clearance_m(own: &VehicleNow, circles: &[Circle]) -> f32 {
    let (x_m, y_m) = (f64::from(own.x_m), f64::from(own.y_m));
    let to_edge = |circle: &Circle| {
        let (north_m, east_m) = (circle.x_m - x_m, circle.y_m - y_m);
        (north_m * north_m + east_m * east_m).sqrt() - circle.radius_m
    };
    circles.iter().map(to_edge).fold(f64::INFINITY, f64::min) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle(x_m: f32, y_m: f32) -> VehicleNow {
        VehicleNow { x_m, y_m, ..VehicleNow::default() }
    }

    fn square(north_m: f32, east_m: f32) -> f32 {
        north_m * north_m + east_m * east_m
    }

    #[test]
    fn the_sweep_finds_what_trying_all_pairs_finds() {
        // A cheap generator: places on a field that is long in one direction, then in the other.
        let mut seed = 12_345_u32;
        let mut random = |span: f32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 * span
        };
        for (long, wide) in [(500.0, 20.0), (20.0, 500.0), (100.0, 0.0), (0.0, 0.0)] {
            let vehicles: Vec<VehicleNow> = (0..200).map(|_| vehicle(random(long), random(wide))).collect();
            let found = near(&vehicles, &[]);
            for (index, own) in vehicles.iter().enumerate() {
                let others = vehicles.iter().enumerate().filter(|(other, _)| *other != index);
                let least = others
                    .map(|(_, one)| square(one.x_m - own.x_m, one.y_m - own.y_m).sqrt())
                    .fold(f32::INFINITY, f32::min);
                assert_eq!(found[index].separation_m, least);
            }
        }
    }

    #[test]
    fn who_stands_or_is_nowhere_is_near_to_nothing() {
        let mut vehicles = vec![vehicle(0.0, 0.0), vehicle(1.0, 0.0), vehicle(f32::NAN, 0.0), vehicle(5.0, 0.0)];
        vehicles[1].is_on_ground = true;
        let found = near(&vehicles, &[Circle { x_m: 0.0, y_m: 3.0, radius_m: 4.0 }]);
        assert_eq!((found[0].nearest, found[0].separation_m), (Some(3), 5.0));
        assert_eq!((found[0].clearance_m, found[1], found[2]), (-1.0, NOTHING, NOTHING));
    }
}
