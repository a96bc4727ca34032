//! What the optimisers of watched vehicles had to choose from, as the page shows it.

use crate::flight::vehicle_number;
use controller::Insight;
use live_view::Feed;
use live_view::choice::{Choice, Member};

/// In a flock of at most so many vehicles all are watched, so that the page can look back at any of them.
const ALL_MAX: usize = 16;
/// What the two costs are.
const COSTS: [&str; 2] = ["progress and velocity (Eq. 11)", "spacing and neighbours' velocity (Eq. 12)"];

/// Indices of the vehicles of which choices are told: those that pages look at, or all of a small flock.
pub fn watched(feed: &Feed, vehicles: usize) -> Vec<usize> {
    if vehicles <= ALL_MAX {
        return (0..vehicles).collect();
    }
    feed.watched().into_iter().filter_map(|number| (number as usize).checked_sub(1)).collect()
}

/// Tells what there was to choose from for the vehicle of an index, at a flight time.
pub fn tell(feed: &Feed, index: usize, insight: &Insight, at_s: f64) {
    if insight.members.is_empty() {
        return;
    }
    let path_m = |path_m: &Vec<[f64; 2]>| path_m.iter().map(|place_m| place_m.map(to_decimetres)).collect();
    let member = |member: &controller::Member| Member {
        weights: member.weights.map(|weight| to_thousandths(weight) as f32),
        costs: member.costs.map(to_thousandths),
        path_m: path_m(&member.path_m),
    };
    feed.choose(Choice {
        vehicle: vehicle_number(index),
        at_s,
        optimizer: insight.optimizer.to_owned(),
        costs: COSTS,
        members: insight.members.iter().map(member).collect(),
        front_len: insight.front_len,
        chosen: insight.chosen,
        violation_m: to_thousandths(insight.violation_m),
        evasion_path_m: insight.evasion_path_m.as_ref().map(path_m),
    });
}

/// A picture needs no more, and the page gets less.
fn to_decimetres(value_m: f64) -> f32 {
    ((value_m * 10.0).round() / 10.0) as f32
}

fn to_thousandths(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}
