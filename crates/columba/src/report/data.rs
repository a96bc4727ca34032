//! What the page's replay needs of a flight, as compact JSON: whole numbers of mm, mm/s, ms, 0.1 mrad and thousandths.

use crate::flight::{Flight, Row, Tick};
use serde::Serialize;

/// How many vehicles x ticks a page carries, at most: about 6 MB. Longer flights are thinned out.
const ROWS_MAX: usize = 150_000;

/// Columns by tick and vehicle, tick-major.
#[derive(Serialize)]
struct Replay {
    vehicles: usize,
    t: Vec<i64>,
    x: Vec<i64>,
    y: Vec<i64>,
    altitude: Vec<i64>,
    speed: Vec<i64>,
    course: Vec<i64>,
    /// The weights of the formation, obstacle and neighbour-velocity terms.
    weights: [Vec<i64>; 3],
    /// Least over everything since the tick before, also over ticks left out; null where there is none.
    separation: Vec<Option<i64>>,
    clearance: Vec<Option<i64>>,
    obstacles: Vec<[i64; 3]>,
    safe: i64,
    expected_altitude: i64,
}

/// The replay's JSON, safe inside a script element, and every how many ticks it has one.
pub fn replay_json(flight: &Flight) -> Result<(String, usize), serde_json::Error> {
    let trajectory = &flight.trajectory;
    let stride = trajectory.rows.len().max(trajectory.ticks.len()).div_ceil(ROWS_MAX).max(1);
    let last = trajectory.ticks.len().saturating_sub(1);
    let kept: Vec<(&Tick, &[Row])> = trajectory
        .iter()
        .enumerate()
        .filter(|(index, _)| index % stride == 0 || *index == last)
        .map(|(_, tick)| tick)
        .collect();
    let column = |value: fn(&Row) -> f64, unit: f64| {
        kept.iter().flat_map(|(_, rows)| rows.iter()).map(|row| whole(value(row), unit)).collect()
    };
    let minima = |value: fn(&Tick) -> f64| -> Vec<Option<i64>> {
        let mut minima = Vec::with_capacity(kept.len());
        let mut least = f64::INFINITY;
        for (index, tick) in trajectory.ticks.iter().enumerate() {
            least = least.min(value(tick));
            if index % stride == 0 || index == last {
                minima.push(least.is_finite().then(|| whole(least, 1e3)));
                least = f64::INFINITY;
            }
        }
        minima
    };
    let discs = flight.field.obstacles.iter();
    let replay = Replay {
        vehicles: trajectory.vehicles,
        t: kept.iter().map(|(tick, _)| whole(tick.t_s, 1e3)).collect(),
        x: column(|row| row.state.x_m, 1e3),
        y: column(|row| row.state.y_m, 1e3),
        altitude: column(|row| row.state.altitude_m, 1e3),
        speed: column(|row| row.state.speed_mps, 1e3),
        course: column(|row| row.state.course_rad, 1e4),
        weights: [column(|row| row.alpha[0], 1e3), column(|row| row.alpha[1], 1e3), column(|row| row.alpha[2], 1e3)],
        separation: minima(|tick| tick.min_separation_m),
        clearance: minima(|tick| tick.min_clearance_m),
        obstacles: discs.map(|disc| [disc.x_m, disc.y_m, disc.radius_m].map(|m| whole(m, 1e3))).collect(),
        safe: whole(flight.field.safe_distance_m, 1e3),
        expected_altitude: whole(flight.field.expected.altitude_m, 1e3),
    };
    // Only numbers and fixed names today; should a string ever come in, it cannot close the element.
    Ok((serde_json::to_string(&replay)?.replace('<', "\\u003c"), stride))
}

/// The nearest whole number of units; 0 for NaN, and the ends of the range beyond them.
fn whole(value: f64, units_per_one: f64) -> i64 {
    (value * units_per_one).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;
    use serde_json::Value;

    #[test]
    fn the_replay_has_every_value_to_the_millimetre() {
        let flight = sample::flight(3, 2, 5);
        let (json, stride) = replay_json(&flight).unwrap();
        assert_eq!(stride, 1);
        let replay: Value = serde_json::from_str(&json).unwrap();
        let column =
            |name: &str| replay[name].as_array().unwrap().iter().map(|v| v.as_i64().unwrap()).collect::<Vec<_>>();
        assert_eq!(column("t"), [0, 500, 1000, 1500, 2000]);
        let expected: Vec<i64> =
            flight.trajectory.rows.iter().map(|row| (row.state.x_m * 1e3).round() as i64).collect();
        assert_eq!(column("x"), expected);
        assert_eq!(column("course").len(), 15);
        let weights: Vec<i64> = flight.trajectory.rows.iter().map(|row| (row.alpha[1] * 1e3).round() as i64).collect();
        assert_eq!(replay["weights"][1], serde_json::json!(weights));
        assert_eq!(replay["obstacles"].as_array().unwrap().len(), 2);
    }

    #[test]
    fn a_long_flight_is_thinned_but_keeps_its_end_and_its_worst_moment() {
        let mut flight = sample::flight(2, 1, 1);
        let rows = flight.trajectory.rows.clone();
        for step in 1..100_001 {
            let min_separation_m = if step == 50_003 { 0.25 } else { 9.0 };
            let tick = Tick { t_s: f64::from(step) * 0.5, min_separation_m, ..flight.trajectory.ticks[0] };
            flight.trajectory.push(tick, rows.clone());
        }
        let (json, stride) = replay_json(&flight).unwrap();
        let replay: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(stride, 2);
        assert_eq!(replay["t"].as_array().unwrap().last().unwrap().as_i64(), Some(50_000_000));
        assert_eq!(replay["x"].as_array().unwrap().len(), 2 * replay["t"].as_array().unwrap().len());
        let least = replay["separation"].as_array().unwrap().iter().filter_map(Value::as_i64).min();
        assert_eq!(least, Some(250));
    }

    #[test]
    fn nothing_to_measure_is_null() {
        let (json, _) = replay_json(&sample::flight(1, 0, 2)).unwrap();
        let replay: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(replay["separation"], serde_json::json!([null, null]));
        assert_eq!(replay["clearance"], serde_json::json!([null, null]));
    }
}
