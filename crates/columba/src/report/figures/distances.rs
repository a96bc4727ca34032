//! The smallest separation and the smallest clearance over time, a panel for each with the limits that belong to it.

use super::{bounds, horizontal, is_drawable, time_frame};
use crate::{
    flight::Flight,
    report::{
        chart::{ALARM, Axis, BELOW_PX, GUIDE, Legend, Mark, WIDTH_PX, dot, series},
        svg::{Drawing, Stroke},
    },
};

const PANEL_PX: f64 = 150.0;
/// Between a panel and the legend of the next.
const GAP_PX: f64 = 10.0;

/// One distance over time.
struct Panel {
    name: &'static str,
    stroke: Stroke,
    points: Vec<(f64, f64)>,
    /// When the flight's least distance was, s, and the distance, m: the key figure, exact to the integration step.
    least: Option<(f64, f64)>,
    /// Limits: what they are called, m.
    limits: Vec<(String, f64, Stroke)>,
    /// What the chart shows at least and at most, m. Distances above it matter to nobody.
    enough_m: f64,
}

/// The smallest separation over time against D_s and the collision distance, and the smallest clearance against the
/// obstacles' edges.
pub fn distances(flight: &Flight) -> String {
    let panels: Vec<Panel> = [separation(flight), clearance(flight)]
        .into_iter()
        .filter(|panel| panel.points.iter().any(|(_, value)| is_drawable(*value)))
        .collect();
    let legends: Vec<Legend> = panels.iter().map(|panel| Legend::new(panel.entries())).collect();
    let height: f64 = legends.iter().map(|legend| legend.height() + PANEL_PX + GAP_PX).sum();
    let mut drawing =
        Drawing::new(WIDTH_PX, height.max(PANEL_PX) - GAP_PX + BELOW_PX, "Smallest separation and clearance over time");
    let mut top = 0.0;
    for (index, (panel, legend)) in panels.iter().zip(&legends).enumerate() {
        legend.draw(&mut drawing, top);
        let frame = time_frame(flight, top + legend.height(), PANEL_PX, panel.axis());
        let x_label = if index + 1 == panels.len() { "time (s)" } else { "" };
        frame.draw(&mut drawing, x_label, &format!("{} (m)", panel.name));
        frame.clipped(&mut drawing, panel.name, |drawing| {
            for (_, value, stroke) in &panel.limits {
                horizontal(drawing, &frame, *value, *stroke);
            }
            drawing.line(&frame.points(panel.points.iter().copied()), panel.stroke);
            if let Some((t_s, value)) = panel.least {
                dot(drawing, frame.point(t_s, value), 4.0, panel.stroke.colour);
            }
        });
        top = frame.top + PANEL_PX + GAP_PX;
    }
    drawing.finish()
}

fn separation(flight: &Flight) -> Panel {
    let (field, summary) = (&flight.field, &flight.summary);
    let points: Vec<(f64, f64)> =
        flight.trajectory.ticks.iter().map(|tick| (tick.t_s, tick.min_separation_m)).collect();
    Panel {
        name: "separation",
        stroke: Stroke::solid(series(0), 1.8),
        enough_m: 10.0 * field.safe_distance_m,
        least: summary.min_separation_at_s.zip(summary.min_separation_m),
        points,
        limits: vec![
            (format!("D\u{209b} {} m", field.safe_distance_m), field.safe_distance_m, guide()),
            (format!("collision below {} m", field.collision_distance_m), field.collision_distance_m, alarm()),
        ],
    }
}

fn clearance(flight: &Flight) -> Panel {
    let summary = &flight.summary;
    Panel {
        name: "clearance",
        stroke: Stroke::solid(series(1), 1.8),
        enough_m: 5.0 * flight.field.safe_distance_m,
        least: summary.min_clearance_at_s.zip(summary.min_clearance_m),
        points: flight.trajectory.ticks.iter().map(|tick| (tick.t_s, tick.min_clearance_m)).collect(),
        limits: vec![("collision below 0 m".to_owned(), 0.0, alarm())],
    }
}

fn guide() -> Stroke {
    Stroke { dashes: "7 4", ..Stroke::solid(GUIDE, 1.4) }
}

fn alarm() -> Stroke {
    Stroke { dashes: "2 3", ..Stroke::solid(ALARM, 1.6) }
}

impl Panel {
    fn entries(&self) -> Vec<(Mark, String)> {
        let words = self.least.map_or_else(
            || self.name.to_owned(),
            |(t_s, value)| format!("{} (least {value:.2} m at {t_s:.1} s)", self.name).replace('-', "\u{2212}"),
        );
        let limits = self.limits.iter().map(|(words, _, stroke)| (Mark::Line(*stroke), words.clone()));
        [(Mark::Line(self.stroke), words)].into_iter().chain(limits).collect()
    }

    /// From below the least value and the limits to the greatest value that matters.
    fn axis(&self) -> Axis {
        let values = self.points.iter().map(|(_, value)| *value);
        let limits = self.limits.iter().map(|(_, value, _)| *value);
        let least = self.least.map(|(_, value)| value);
        let (low, high) = bounds(values.chain(limits).chain(least).chain([0.0]));
        // Some room below the limit of a collision, where the limit is zero.
        let low = if low < 0.0 { low } else { -0.06 * high.min(self.enough_m) };
        let lowest = if self.limits.iter().any(|(_, value, _)| *value == 0.0) { low } else { 0.0 };
        Axis::exact(lowest, Axis::nice(0.0, high.min(self.enough_m), 1.0, 4.0).high(), 4.0)
    }
}

/// What to know when reading the figure.
pub fn caption(flight: &Flight) -> String {
    let field = &flight.field;
    format!(
        "Above: least horizontal distance between two UAVs. Separation is lost below D\u{209b} = {} m; below {} m the \
         two have collided. Below: least horizontal distance from a UAV to the edge of an obstacle; below 0 the UAV is \
         in the obstacle. Each value is the least of the interval since the tick before, over all integration steps. \
         The dots are the least of the flight. Greater distances are above the charts.",
        field.safe_distance_m, field.collision_distance_m
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn what_there_is_none_of_has_no_panel() {
        let both = distances(&sample::flight(2, 1, 20));
        assert!(both.contains("separation (least") && both.contains("clearance (least"));
        let alone = distances(&sample::flight(1, 1, 20));
        assert!(!alone.contains("separation (least") && alone.contains("clearance (least"));
        let open = distances(&sample::flight(2, 0, 20));
        assert!(open.contains("separation (least") && !open.contains("clearance (least"));
    }

    #[test]
    fn the_least_and_its_time_are_the_key_figures() {
        let mut flight = sample::flight(2, 1, 20);
        // The tick that ends the interval is later than the moment itself.
        flight.trajectory.ticks[7].min_separation_m = 0.126;
        flight.summary.min_separation_m = Some(0.126);
        flight.summary.min_separation_at_s = Some(3.18);
        let svg = distances(&flight);
        assert!(svg.contains("separation (least 0.13 m at 3.2 s)"), "{svg}");
        let figures = crate::report::key_figures::key_figures(&flight);
        let (_, value, note) = figures.iter().find(|(name, ..)| *name == "Smallest separation").unwrap();
        assert!(value == "0.13 m" && note.starts_with("at 3.2 s"), "{value} {note}");
    }

    #[test]
    fn each_limit_is_in_the_panel_that_it_belongs_to() {
        let flight = sample::flight(2, 1, 20);
        let svg = distances(&flight);
        let panels: Vec<&str> = svg.split("<clipPath").skip(1).collect();
        assert_eq!(panels.len(), 2);
        // Separation: D_s and the collision distance. Clearance: the obstacle's edge, and no limit of a separation.
        let limits = |panel: &str| {
            let drawn = panel.split("</g>").next().unwrap();
            (drawn.matches("class=\"guide\"").count(), drawn.matches("class=\"alarm\"").count())
        };
        assert_eq!((limits(panels[0]), limits(panels[1])), ((1, 1), (0, 1)));
        let (one, other) = (separation(&flight), clearance(&flight));
        assert_eq!(one.limits.iter().map(|(_, value, _)| *value).collect::<Vec<_>>(), [5.0, 1.0]);
        assert_eq!(other.limits.iter().map(|(_, value, _)| *value).collect::<Vec<_>>(), [0.0]);
    }
}
