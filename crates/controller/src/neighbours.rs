//! The nearest neighbours of a vehicle.

use flight_model::State;

/// A snapshot of the flock sorted by northing, in which the neighbours of a place are found in a window.
///
/// One sorted axis is enough: it costs one sort per tick, and the search of one window takes little time compared with
/// a solve (a hundred microseconds), even for thousands of vehicles.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    by_northing: Vec<u32>,
}

impl Neighbours {
    /// Takes a new snapshot.
    pub fn update(&mut self, states: &[State]) {
        self.by_northing.clear();
        self.by_northing.extend(0..states.len() as u32);
        self.by_northing
            .sort_unstable_by(|&a, &b| states[a as usize].x_m.total_cmp(&states[b as usize].x_m).then(a.cmp(&b)));
    }

    /// The nearest others within `range_m` of vehicle `of`, nearest first and at most `most`, as (squared distance,
    /// index).
    pub fn nearest(&self, states: &[State], of: usize, range_m: f64, most: usize, found: &mut Vec<(f64, u32)>) {
        found.clear();
        let centre = &states[of];
        let from = self.by_northing.partition_point(|&i| states[i as usize].x_m < centre.x_m - range_m);
        for &index in &self.by_northing[from..] {
            let other = &states[index as usize];
            let offset_m = other.position_m() - centre.position_m();
            if offset_m.x > range_m {
                break;
            }
            let squared_m2 = offset_m.norm_squared();
            if index as usize != of && squared_m2 <= range_m * range_m {
                found.push((squared_m2, index));
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_a_full_search_finds(
            places in prop::collection::vec((-100.0..100.0f64, -100.0..100.0f64), 1..60),
        ) {
            let states: Vec<State> = places.iter().map(|&(x_m, y_m)| State { x_m, y_m, ..State::default() }).collect();
            let mut index = Neighbours::default();
            index.update(&states);
            let mut found = Vec::new();
            for of in 0..states.len() {
                index.nearest(&states, of, 30.0, 8, &mut found);
                let mut wanted: Vec<(f64, u32)> = (0..states.len())
                    .filter(|&other| other != of)
                    .map(|other| ((states[other].position_m() - states[of].position_m()).norm_squared(), other as u32))
                    .filter(|&(squared, _)| squared <= 900.0)
                    .collect();
                wanted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                wanted.truncate(8);
                prop_assert_eq!(&found, &wanted);
            }
        }
    }
}
