//! What an optimiser had to choose from for a vehicle at one control tick, and where each choice would have led.

use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};

/// A Pareto front of two costs, both to be as low as can be, and the choice that was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Choice {
    /// Number of the vehicle.
    pub vehicle: u32,
    /// Flight time of the tick, s.
    pub at_s: f64,
    /// Name of the optimiser.
    pub optimizer: String,
    /// What the two costs are, in words.
    pub costs: [&'static str; 2],
    /// Members, in order of their first cost.
    pub members: Vec<Member>,
    /// How many members the front had: not all of a long one need be told.
    pub front_len: usize,
    /// Index of the member that was chosen.
    pub chosen: usize,
    /// By how much the flight of every member falls short of the least distances, m.
    pub violation_m: f64,
    /// Another way that the vehicle was sent in the end, because the ways of the whole flock came too near.
    pub evasion_path_m: Option<Vec<[f32; 2]>>,
}

/// One choice of weights.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Member {
    /// Weights of the formation, obstacle and neighbour-velocity terms.
    pub weights: [f32; 3],
    /// Its costs.
    pub costs: [f64; 2],
    /// Its predicted way: north and east, m.
    pub path_m: Vec<[f32; 2]>,
}

/// Choices of the past are kept in so many bytes of JSON.
const BYTES_MAX: usize = 16 << 20;

/// Choices of all vehicles as pages are sent them, the newest of each kept longest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choices {
    kept: BTreeMap<u32, VecDeque<(u64, String)>>,
    bytes: usize,
    count: u64,
}

impl Choices {
    /// Keeps a choice, in JSON.
    pub fn push(&mut self, choice: &Choice) {
        let Ok(json) = serde_json::to_string(choice) else { return };
        self.count += 1;
        self.bytes += json.len();
        self.kept.entry(choice.vehicle).or_default().push_back((self.count, json));
        while self.bytes > BYTES_MAX {
            // The oldest of all.
            let oldest = self.kept.values_mut().min_by_key(|kept| kept.front().map_or(u64::MAX, |(count, _)| *count));
            let Some((_, json)) = oldest.and_then(VecDeque::pop_front) else { return };
            self.bytes -= json.len();
        }
    }

    /// The choices of a vehicle that came after the first `seen` of all, as one JSON array, and how many of all there
    /// are; none if there are none.
    pub fn after(&self, vehicle: u32, seen: u64) -> Option<(u64, String)> {
        let kept = self.kept.get(&vehicle)?;
        let new: Vec<&str> = kept.iter().filter(|(count, _)| *count > seen).map(|(_, json)| json.as_str()).collect();
        (!new.is_empty()).then(|| (self.count, format!("[{}]", new.join(","))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(vehicle: u32, at_s: f64, members: usize) -> Choice {
        Choice { vehicle, at_s, members: vec![Member::default(); members], ..Choice::default() }
    }

    #[test]
    fn a_page_gets_the_choices_of_its_vehicle_once_each() {
        let mut choices = Choices::default();
        for (vehicle, at_s) in [(1, 0.0), (7, 0.0), (7, 0.5)] {
            choices.push(&choice(vehicle, at_s, 1));
        }
        let (seen, json) = choices.after(7, 0).unwrap();
        let told: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!((told.as_array().unwrap().len(), &told[1]["at_s"]), (2, &serde_json::json!(0.5)));
        assert_eq!((choices.after(7, seen), choices.after(2, 0)), (None, None));
        choices.push(&choice(7, 1.0, 1));
        assert!(choices.after(7, seen).unwrap().1.starts_with("[{\"vehicle\":7,\"at_s\":1.0"));
    }

    #[test]
    fn the_oldest_go_first_whoever_they_are_of() {
        let mut choices = Choices::default();
        for tick in 0..400 {
            choices.push(&choice(1 + tick % 2, f64::from(tick), 1000));
        }
        assert!(choices.bytes <= BYTES_MAX);
        let first = |vehicle| choices.kept[&vehicle][0].0;
        assert!(first(1) > 1 && first(1).abs_diff(first(2)) <= 1);
    }
}
