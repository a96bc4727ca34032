//! The paths among the circles.

use super::{bounds, vehicle_entries, vehicle_stroke};
use crate::{
    flight::{Flight, Row},
    report::{
        chart::{
            ALARM, Axis, BELOW_PX, DISC, Frame, LEFT_PX, Legend, Mark, RIGHT_PX, TRIANGLE_EDGE, WIDTH_PX, ring, series,
            triangle,
        },
        svg::{Drawing, number},
    },
};

/// The flight paths among the circles, with a triangle for every UAV at a few instants (the paper's Fig. 2a). Both axes
/// have the same scale.
pub fn paths(flight: &Flight) -> String {
    let (field, trajectory) = (&flight.field, &flight.trajectory);
    let circles = field.obstacles.iter();
    let xs = circles.clone().flat_map(|disc| [disc.x_m - disc.radius_m, disc.x_m + disc.radius_m]);
    let ys = circles.flat_map(|disc| [disc.y_m - disc.radius_m, disc.y_m + disc.radius_m]);
    let (x_low, x_high) = bounds(xs.chain(trajectory.rows.iter().map(|row| row.state.x_m)));
    let (y_low, y_high) = bounds(ys.chain(trajectory.rows.iter().map(|row| row.state.y_m)));

    let mut entries = vehicle_entries(trajectory.vehicles, Mark::Track);
    if !field.obstacles.is_empty() {
        entries.push((Mark::Disc, "obstacle".to_owned()));
    }
    let mishaps = mishaps(flight);
    if !mishaps.is_empty() {
        entries.push((Mark::Ring(ALARM), "collision".to_owned()));
    }
    let legend = Legend::new(entries);

    // The scale that both axes share: the field fills the width, unless it is taller than a page likes.
    let width = WIDTH_PX - LEFT_PX - RIGHT_PX;
    let margin = 0.03 * (x_high - x_low).max(y_high - y_low) + 1.0;
    let (x_span, y_span) = (x_high - x_low + 2.0 * margin, y_high - y_low + 2.0 * margin);
    let height = (width * y_span / x_span).clamp(110.0, 520.0);
    let metres_per_px = (x_span / width).max(y_span / height);
    let around = |low: f64, high: f64, px: f64, count: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * px * metres_per_px);
        Axis::exact(middle - half, middle + half, count)
    };
    let frame = Frame {
        left: LEFT_PX,
        top: legend.height(),
        width,
        height,
        x: around(x_low, x_high, width, 7.0),
        y: around(y_low, y_high, height, (height / 38.0).max(2.5)),
    };

    let mut drawing = Drawing::new(WIDTH_PX, frame.top + height + BELOW_PX, "Flight paths among the obstacles");
    legend.draw(&mut drawing);
    frame.draw(&mut drawing, "x, north (m)", "y, east (m)");
    frame.clipped(&mut drawing, "paths", |drawing| {
        for disc in &field.obstacles {
            let (x, y) = frame.point(disc.x_m, disc.y_m);
            let radius = number(disc.radius_m / metres_per_px);
            drawing.raw(&format!("<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" {DISC}/>", number(x), number(y)));
        }
        for vehicle in 0..trajectory.vehicles {
            let path = trajectory.vehicle(vehicle).map(|(_, row)| (row.state.x_m, row.state.y_m));
            drawing.line(&frame.points(path), vehicle_stroke(vehicle, trajectory.vehicles));
        }
        let size = if trajectory.vehicles > 30 { 5.0 } else { 7.5 };
        for tick in instants(flight) {
            for (vehicle, row) in rows_at(flight, tick).iter().enumerate() {
                let at = frame.point(row.state.x_m, row.state.y_m);
                let outline = triangle(at, row.state.course_rad, size);
                drawing.area(&outline, series(vehicle), TRIANGLE_EDGE);
            }
        }
        for (x_m, y_m) in mishaps {
            ring(drawing, frame.point(x_m, y_m), ALARM);
        }
    });
    drawing.finish()
}

fn rows_at(flight: &Flight, tick: usize) -> &[Row] {
    flight.trajectory.iter().nth(tick).map(|(_, rows)| rows).unwrap_or_default()
}

/// A round time between triangles, s.
fn instant_interval_s(flight: &Flight) -> f64 {
    let (start, end) = bounds(flight.trajectory.ticks.iter().map(|tick| tick.t_s));
    let ticks = Axis::exact(0.0, end - start, 5.0).ticks();
    ticks.get(1).copied().unwrap_or(1.0)
}

/// The ticks at which triangles are drawn: the first, those nearest to every round time, the last.
fn instants(flight: &Flight) -> Vec<usize> {
    let ticks = &flight.trajectory.ticks;
    let (Some(first), Some(last)) = (ticks.first(), ticks.last()) else { return Vec::new() };
    let interval_s = instant_interval_s(flight);
    let mut chosen = vec![0];
    // No triangle so near to the last that the two would run into one another.
    for round in (1..).map(|count| first.t_s + f64::from(count) * interval_s) {
        if round > last.t_s - 0.4 * interval_s {
            break;
        }
        chosen.push(ticks.partition_point(|tick| tick.t_s < round - 1e-6));
    }
    chosen.push(ticks.len() - 1);
    chosen.dedup();
    chosen
}

/// Where a vehicle was when the flight's worst moment was a collision.
fn mishaps(flight: &Flight) -> Vec<(f64, f64)> {
    let summary = &flight.summary;
    let at = |at_s: Option<f64>, vehicle: Option<u32>| {
        let index = (vehicle? as usize).checked_sub(1)?;
        let nearest = |(t_s, _): &(f64, &Row)| (t_s - at_s.unwrap_or(f64::NAN)).abs();
        let (_, row) = flight.trajectory.vehicle(index).min_by(|one, other| nearest(one).total_cmp(&nearest(other)))?;
        Some((row.state.x_m, row.state.y_m))
    };
    let mut places = Vec::new();
    if summary.min_clearance_m.is_some_and(|clearance_m| clearance_m < 0.0) {
        places.extend(at(summary.min_clearance_at_s, summary.min_clearance_vehicle));
    }
    if summary.min_separation_m.is_some_and(|separation_m| separation_m < flight.field.collision_distance_m) {
        let one = summary.min_separation_vehicles.map(|[one, _]| one);
        places.extend(at(summary.min_separation_at_s, one));
    }
    places
}

/// What to know when reading the figure.
pub fn caption(flight: &Flight) -> String {
    let every = if flight.trajectory.ticks.len() > 1 {
        format!(
            " Triangles point along the course, at the start, every {} s and at the end.",
            instant_interval_s(flight)
        )
    } else {
        String::new()
    };
    format!(
        "Axes as in the paper's Fig. 2: x (north) to the right, y (east) upwards, so left and right are exchanged \
         against a map.{every}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn triangles_stand_at_the_start_at_round_times_and_at_the_end() {
        let flight = sample::flight(2, 0, 86);
        let times: Vec<f64> = instants(&flight).into_iter().map(|tick| flight.trajectory.ticks[tick].t_s).collect();
        assert_eq!(times, [0.0, 10.0, 20.0, 30.0, 42.5]);
        assert_eq!(instants(&sample::flight(2, 0, 1)), [0]);
        assert!(instants(&sample::flight(2, 0, 0)).is_empty());
    }

    #[test]
    fn every_vehicle_has_a_triangle_at_each_instant_and_every_obstacle_a_circle() {
        let flight = sample::flight(2, 3, 86);
        let svg = paths(&flight);
        // In the drawing and in the legend.
        assert_eq!(svg.matches("<polygon").count(), 2 * 5 + 2);
        assert_eq!(svg.matches("<circle").count(), 3 + 1);
    }

    #[test]
    fn both_axes_have_one_scale() {
        // A circle of 10 m at the middle of two vehicles: its radius in px is as far as its edge in x.
        let mut flight = sample::flight(1, 1, 86);
        flight.field.obstacles[0].radius_m = 10.0;
        let svg = paths(&flight);
        let circle = svg.lines().rfind(|line| line.starts_with("<circle")).unwrap();
        let radius: f64 = circle.split("r=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        let width = WIDTH_PX - LEFT_PX - RIGHT_PX;
        let (low, high) = bounds(flight.trajectory.rows.iter().map(|row| row.state.x_m));
        let span = (high - low) * 1.06 + 2.0;
        assert!((radius - 10.0 * width / span).abs() < 0.01, "{radius}");
    }

    #[test]
    fn a_collision_is_ringed_where_it_was() {
        let mut flight = sample::flight(2, 0, 86);
        assert!(mishaps(&flight).is_empty());
        flight.summary.min_separation_m = Some(0.4);
        flight.summary.min_separation_at_s = Some(10.1);
        flight.summary.min_separation_vehicles = Some([2, 1]);
        let row = rows_at(&flight, 20)[1];
        assert_eq!(mishaps(&flight), [(row.state.x_m, row.state.y_m)]);
        // A number that no vehicle has is not a place.
        flight.summary.min_separation_vehicles = Some([0, 9]);
        assert!(mishaps(&flight).is_empty());
    }
}
