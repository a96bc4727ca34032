//! The smallest separation and clearance over time.

use super::{bounds, horizontal, is_drawable, new_drawing, time_frame};
use crate::{
    flight::Flight,
    report::{
        chart::{ALARM, Axis, GUIDE, INK, Legend, Mark, series},
        svg::{Colour, Stroke, number},
    },
};

/// Points over time, how they are drawn, and what they are called.
type Line = (Vec<(f64, f64)>, Stroke, &'static str);

/// The smallest separation and clearance over time, against D_s and the collision distance.
pub fn distances(flight: &Flight) -> String {
    let Flight { field, trajectory, .. } = flight;
    let separation: Vec<(f64, f64)> = trajectory.ticks.iter().map(|tick| (tick.t_s, tick.min_separation_m)).collect();
    let clearance: Vec<(f64, f64)> = trajectory.ticks.iter().map(|tick| (tick.t_s, tick.min_clearance_m)).collect();

    let yardsticks = [
        (field.safe_distance_m, "D\u{209b}", Stroke { dashes: "7 4", ..Stroke::solid(GUIDE, 1.4) }),
        (field.collision_distance_m, "collision", Stroke { dashes: "2 3", ..Stroke::solid(ALARM, 1.4) }),
    ];
    let lines: Vec<Line> = [
        (separation, Stroke::solid(series(0), 1.8), "separation"),
        (clearance, Stroke::solid(series(1), 1.8), "clearance"),
    ]
    .into_iter()
    .filter(|(points, ..)| points.iter().any(|(_, value)| is_drawable(*value)))
    .collect();

    let mut entries: Vec<(Mark, String)> = Vec::new();
    for (points, stroke, name) in &lines {
        let words = least(points).map_or_else(
            || (*name).to_owned(),
            |(t_s, value)| format!("{name} (least {value:.2} m at {t_s:.1} s)").replace('-', "\u{2212}"),
        );
        entries.push((Mark::Line(*stroke), words));
    }
    // A yardstick after each line: so two rows have room for all.
    for (index, (value, name, stroke)) in yardsticks.iter().enumerate() {
        let entry = (Mark::Line(*stroke), format!("{name} {value} m"));
        entries.insert((2 * index + 1).min(entries.len()), entry);
    }
    let legend = Legend::new(entries);

    // What is near matters: a flock or an obstacle far away may leave the chart at the top.
    let values = || lines.iter().flat_map(|(points, ..)| points.iter().map(|(_, value)| *value));
    let (low, high) = bounds(values().chain([0.0, 1.2 * field.safe_distance_m]));
    let (_, widest) = bounds(trajectory.ticks.iter().map(|tick| tick.min_separation_m));
    let enough = widest.max(4.0 * field.safe_distance_m);
    let frame = time_frame(flight, legend.height(), 230.0, Axis::nice(low, high.min(enough), 1.0, 5.0));

    let mut drawing = new_drawing(&frame, "Smallest separation and clearance over time");
    legend.draw(&mut drawing);
    frame.draw(&mut drawing, "time (s)", "distance (m)");
    frame.clipped(&mut drawing, "distances", |drawing| {
        horizontal(drawing, &frame, 0.0, Stroke::solid(INK, 1.0));
        for (value, _, stroke) in yardsticks {
            horizontal(drawing, &frame, value, stroke);
        }
        for (points, stroke, _) in &lines {
            drawing.line(&frame.points(points.iter().copied()), *stroke);
            if let Some((t_s, value)) = least(points) {
                let ((x, y), Colour { hex, class }) = (frame.point(t_s, value), stroke.colour);
                let (x, y) = (number(x), number(y));
                drawing.raw(&format!(
                    "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"4\" color=\"{hex}\" fill=\"currentColor\"/>"
                ));
            }
        }
    });
    drawing.finish()
}

/// What to know when reading the figure.
pub fn caption(flight: &Flight) -> String {
    let field = &flight.field;
    format!(
        "Least distance between two UAVs and from a UAV to the edge of a circle, over each interval between ticks and at \
         every integration step in it. Below D\u{209b} = {} m separation is lost; below {} m two UAVs collide, and below 0 a \
         UAV is in an obstacle. Large distances may lie above the chart.",
        field.safe_distance_m, field.collision_distance_m
    )
}

fn least(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let drawable = points.iter().copied().filter(|(_, value)| is_drawable(*value));
    drawable.min_by(|(_, one), (_, other)| one.total_cmp(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn what_there_is_none_of_has_no_line() {
        let both = distances(&sample::flight(2, 1, 20));
        assert!(both.contains("separation (least") && both.contains("clearance (least"));
        let alone = distances(&sample::flight(1, 1, 20));
        assert!(!alone.contains("separation (least") && alone.contains("clearance (least"));
        let open = distances(&sample::flight(2, 0, 20));
        assert!(open.contains("separation (least") && !open.contains("clearance (least"));
    }

    #[test]
    fn the_least_and_its_time_are_named() {
        let mut flight = sample::flight(2, 0, 20);
        flight.trajectory.ticks[7].min_separation_m = 0.126;
        assert!(distances(&flight).contains("separation (least 0.13 m at 3.5 s)"));
    }
}
