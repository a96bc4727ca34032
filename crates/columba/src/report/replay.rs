//! The replay: a flight as the live view's page plays it, in the report itself.

use crate::flight::{Flight, Row, Tick, vehicle_number};
use live_view::{Circle, Event, Frame, Least, Recording, Scene, Steering, VehicleNow, Weight};

/// Rows, beyond which ticks are thinned out.
const ROWS_MAX: usize = 150_000;

/// Every how many ticks the replay has one.
pub fn stride(flight: &Flight) -> usize {
    let trajectory = &flight.trajectory;
    trajectory.rows.len().max(trajectory.ticks.len()).div_ceil(ROWS_MAX).max(1)
}

/// The flight as a recording; of a long one not every tick, but the last.
pub fn recording(flight: &Flight) -> Recording {
    let (summary, field) = (&flight.summary, &flight.field);
    let mut recording = Recording::new(Scene {
        title: summary.scenario.clone(),
        source: "report".to_owned(),
        circles: field
            .obstacles
            .iter()
            .map(|disc| Circle { x_m: disc.x_m, y_m: disc.y_m, radius_m: disc.radius_m })
            .collect(),
        separation_m: field.safe_distance_m,
        collision_m: field.collision_distance_m,
        altitude_m: Some(field.expected.altitude_m),
        ..Scene::default()
    });
    events(&summary.station).for_each(|event| recording.tell(event));
    let least = |value_m: Option<f64>, at_s: Option<f64>, vehicles: Vec<u32>| {
        value_m.zip(at_s).map(|(value_m, at_s)| Least { value_m, at_s, vehicles })
    };
    let pair = summary.min_separation_vehicles.map(Vec::from).unwrap_or_default();
    let least_separation = least(summary.min_separation_m, summary.min_separation_at_s, pair);
    let one = summary.min_clearance_vehicle.into_iter().collect();
    let least_clearance = least(summary.min_clearance_m, summary.min_clearance_at_s, one);
    let (stride, last) = (stride(flight), flight.trajectory.ticks.len().saturating_sub(1));
    for (index, (tick, rows)) in flight.trajectory.iter().enumerate() {
        if index % stride == 0 || index == last {
            let mut frame = frame(tick, rows);
            (frame.least_separation, frame.least_clearance) = (least_separation.clone(), least_clearance.clone());
            recording.push(frame);
        }
    }
    recording
}

fn frame(tick: &Tick, rows: &[Row]) -> Frame {
    let vehicle = |(index, row): (usize, &Row)| {
        let (state, setpoint) = (&row.state, &row.setpoint);
        let steering = Steering {
            weights: row.alpha.map(|weight| weight as f32),
            speed_mps: setpoint.speed_mps as f32,
            course_rad: setpoint.course_rad as f32,
            altitude_m: setpoint.altitude_m as f32,
        };
        VehicleNow {
            number: vehicle_number(index),
            x_m: state.x_m as f32,
            y_m: state.y_m as f32,
            altitude_m: state.altitude_m as f32,
            speed_mps: state.speed_mps as f32,
            course_rad: state.course_rad as f32,
            is_armed: true,
            follows: true,
            steering: setpoint.is_finite().then_some(steering),
            ..VehicleNow::default()
        }
    };
    Frame { time_s: tick.t_s, rate: 1.0, vehicles: rows.iter().enumerate().map(vehicle).collect(), ..Frame::default() }
}

/// What the ground station told, of a flight that it flew.
fn events(station: &serde_json::Value) -> impl Iterator<Item = Event> + '_ {
    let told = station.get("events").and_then(serde_json::Value::as_array).into_iter().flatten();
    told.map(|event| Event {
        at_s: event["flight_s"].as_f64().or(event["at_s"].as_f64()).unwrap_or(0.0),
        vehicles: event["vehicle"].as_u64().and_then(|number| u32::try_from(number).ok()).into_iter().collect(),
        weight: match event["weight"].as_str() {
            Some("fault") => Weight::Fault,
            Some("warning") => Weight::Warning,
            _ => Weight::Note,
        },
        text: event["text"].as_str().unwrap_or("").to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    fn frames(recording: &Recording) -> usize {
        let (mut at, mut count) = (0, 0);
        while let Some(length) = recording.frames().get(at..at + 4) {
            at += 4 + u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
            count += 1;
        }
        count
    }

    #[test]
    fn a_flight_is_played_tick_by_tick_with_its_own_least_distances() {
        let flight = sample::flight(3, 2, 5);
        let mut recording = recording(&flight);
        assert_eq!((stride(&flight), frames(&recording)), (1, 5));
        let head: serde_json::Value = serde_json::to_value(recording.head()).unwrap();
        assert_eq!(head["scene"]["circles"].as_array().unwrap().len(), 2);
        assert_eq!(head["least"]["separation"]["value_m"].as_f64(), flight.summary.min_separation_m);
        assert_eq!(head["least"]["is_of_flight"], true);
    }

    #[test]
    fn a_long_flight_is_thinned_but_keeps_its_end() {
        let mut flight = sample::flight(2, 1, 1);
        let rows = flight.trajectory.rows.clone();
        for step in 1..100_001 {
            let tick = Tick { t_s: f64::from(step) * 0.5, ..flight.trajectory.ticks[0] };
            flight.trajectory.push(tick, rows.clone());
        }
        assert_eq!((stride(&flight), frames(&recording(&flight))), (2, 50_001));
    }
}
