//! The figures of a flight, each a function from the flight to an SVG: the three of the paper's Fig. 2 and five more.
//!
//! Up to [`LINES_MAX`] vehicles have a line each. More of them are bands of percentiles over the flock, and by number
//! the vehicles that leave the bands.

mod alphas;
mod bank;
mod distances;
mod paths;
mod prediction;
mod spread;

pub use alphas::alphas;
pub use bank::bank;
pub use distances::distances;
pub use paths::paths;
pub use prediction::prediction;
pub use spread::quantile;

use super::{
    chart::{Axis, BELOW_PX, Frame, GUIDE, LEFT_PX, Legend, Mark, RIGHT_PX, SERIES, WIDTH_PX, series},
    svg::{Drawing, Stroke},
};
use crate::flight::{Flight, Row, vehicle_number};
use flight_model::wrap_pi;
use rayon::prelude::*;

/// More vehicles than this are not told apart by lines: there are so many colours, each solid and dashed.
pub const LINES_MAX: usize = 2 * SERIES.len();

/// One vehicle's values over time, s.
pub type VehicleLine = Vec<(f64, f64)>;

/// A figure with its place in a paper.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Its file's name without an ending.
    pub name: &'static str,
    /// What it shows, in a few words.
    pub title: &'static str,
    /// What to know when reading it.
    pub caption: String,
    /// The drawing.
    pub svg: String,
}

/// The names of all figures, in the order of the report.
pub const NAMES: [&str; 8] = ["paths", "distances", "speeds", "courses", "bank", "altitudes", "alphas", "prediction"];

/// All figures, in the order of [`NAMES`].
pub fn all(flight: &Flight) -> Vec<Figure> {
    type Draw = fn(&Flight) -> String;
    let figures: [(&str, &str, String, Draw); 8] = [
        ("paths", "Paths among the obstacles", paths::caption(flight), paths),
        ("distances", "Smallest separation and clearance", distances::caption(flight), distances),
        ("speeds", "Speed", over_flock(flight, "Horizontal speed at each tick."), speeds),
        (
            "courses",
            "Course",
            over_flock(flight, "Course over ground at each tick, clockwise from north: from x towards y."),
            courses,
        ),
        ("bank", "Bank angle", over_flock(flight, bank::CAPTION), bank),
        ("altitudes", "Altitude", over_flock(flight, "Altitude above the scenario's origin at each tick."), altitudes),
        (
            "alphas",
            "Weights from the optimiser",
            "Alpha of the formation, obstacle and neighbour-velocity terms (Eq. 5, 7, 8) over the flock at each tick. \
             1: the term acts as designed; 0: not at all."
                .to_owned(),
            alphas,
        ),
        ("prediction", "Predicted against flown", over_flock(flight, &prediction::caption(flight)), prediction),
    ];
    figures
        .into_par_iter()
        .map(|(name, title, caption, draw)| Figure { name, title, caption, svg: draw(flight) })
        .collect()
}

/// What a dashed line is: what the flock is to settle on, or nothing of the quantity.
const EXPECTED: &str = "expected";
const NONE: &str = "none";

/// A caption, with what the bands are where there are bands.
fn over_flock(flight: &Flight, caption: &str) -> String {
    if flight.trajectory.vehicles <= LINES_MAX {
        return format!("{caption} One line for each UAV.");
    }
    format!(
        "{caption} Bands hold the middle 50 % and 90 % of the flock at each moment. UAVs that leave the bands farthest \
         are drawn, and numbered where they are farthest out."
    )
}

/// Speed over time (the paper's Fig. 2b).
pub fn speeds(flight: &Flight) -> String {
    let expected = flight.field.expected.speed_mps;
    over_time(flight, "speeds", "speed (m/s)", (expected, EXPECTED), 1.0, &lines(flight, |row| row.state.speed_mps))
}

/// Course over time in degrees (the paper's Fig. 2c), on the turn around the expected course.
pub fn courses(flight: &Flight) -> String {
    let expected_rad = wrap_pi(flight.field.expected.course_rad);
    let course_deg = |row: &Row| (expected_rad + wrap_pi(row.state.course_rad - expected_rad)).to_degrees();
    let guide = (expected_rad.to_degrees(), EXPECTED);
    over_time(flight, "courses", "course (\u{b0})", guide, 10.0, &lines(flight, course_deg))
}

/// Altitude over time.
pub fn altitudes(flight: &Flight) -> String {
    let expected = flight.field.expected.altitude_m;
    over_time(
        flight,
        "altitudes",
        "altitude (m)",
        (expected, EXPECTED),
        2.0,
        &lines(flight, |row| row.state.altitude_m),
    )
}

/// A value of every vehicle at each tick.
fn lines(flight: &Flight, value: impl Fn(&Row) -> f64) -> Vec<VehicleLine> {
    let line = |vehicle| flight.trajectory.vehicle(vehicle).map(|(t_s, row)| (t_s, value(row))).collect();
    (0..flight.trajectory.vehicles).map(line).collect()
}

/// A figure of one value over time, with a dashed line at another value, and what that one is.
fn over_time(
    flight: &Flight,
    name: &str,
    y_label: &str,
    (guided, guide_words): (f64, &str),
    least_span: f64,
    lines: &[VehicleLine],
) -> String {
    let guide = Stroke { dashes: "7 4", ..Stroke::solid(GUIDE, 1.4) };
    let (low, high) = bounds(lines.iter().flatten().map(|(_, value)| *value).chain([guided]));
    let y = Axis::nice(low, high, least_span, 7.0);
    let spread = (lines.len() > LINES_MAX).then(|| {
        let spreads = spread::spreads(lines);
        let outliers = spread::outliers(lines, &spreads, &y);
        (spreads, outliers)
    });
    let entries = match &spread {
        Some((_, outliers)) => spread::legend(lines.len(), outliers),
        None => vehicle_entries(lines.len(), Mark::Line),
    };
    let legend = Legend::new(entries.into_iter().chain([(Mark::Line(guide), guide_words.to_owned())]));
    let frame = time_frame(flight, legend.height(), 230.0, y);

    let mut drawing = new_drawing(&frame, &format!("{y_label} over time"));
    legend.draw(&mut drawing, 0.0);
    frame.draw(&mut drawing, "time (s)", y_label);
    frame.clipped(&mut drawing, name, |drawing| {
        match &spread {
            Some((spreads, outliers)) => spread::draw(drawing, &frame, lines, spreads, outliers),
            None => {
                for (vehicle, line) in lines.iter().enumerate() {
                    drawing.line(&frame.points(broken_at_seam(line)), vehicle_stroke(vehicle, lines.len()));
                }
            }
        }
        horizontal(drawing, &frame, guided, guide);
    });
    drawing.finish()
}

/// A line that jumps by more than 180 has crossed the seam of the circle: it is interrupted there. Speeds and altitudes
/// do not jump so.
fn broken_at_seam(line: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut broken = Vec::with_capacity(line.len());
    let mut before = None;
    for &(t_s, value) in line {
        if before.is_some_and(|before: f64| (value - before).abs() > 180.0) {
            broken.push((t_s, f64::NAN));
        }
        broken.push((t_s, value));
        before = Some(value);
    }
    broken
}

/// A frame over the whole flight's time.
fn time_frame(flight: &Flight, top: f64, height: f64, y: Axis) -> Frame {
    let (start, end) = bounds(flight.trajectory.ticks.iter().map(|tick| tick.t_s));
    let x = Axis::exact(start, end, 8.0);
    Frame { left: LEFT_PX, top, width: WIDTH_PX - LEFT_PX - RIGHT_PX, height, x, y }
}

fn new_drawing(frame: &Frame, title: &str) -> Drawing {
    Drawing::new(WIDTH_PX, frame.top + frame.height + BELOW_PX, title)
}

/// A line across the frame.
fn horizontal(drawing: &mut Drawing, frame: &Frame, value: f64, stroke: Stroke) {
    let y = frame.point(0.0, value).1;
    drawing.line(&[(frame.left, y), (frame.left + frame.width, y)], stroke);
}

/// The line of a vehicle: its colour, dashed where the colours come a second time.
fn vehicle_stroke(vehicle: usize, vehicles: usize) -> Stroke {
    let width = if vehicles > SERIES.len() { 1.3 } else { 1.7 };
    let dashes = if vehicle < SERIES.len() { "" } else { "5 2.5" };
    Stroke { dashes, ..Stroke::solid(series(vehicle), width) }
}

/// One entry for each vehicle.
fn vehicle_entries(vehicles: usize, mark: impl Fn(Stroke) -> Mark) -> Vec<(Mark, String)> {
    let entry = |vehicle| {
        let number = vehicle_number(vehicle);
        let words = if vehicle == 0 { format!("UAV {number}") } else { number.to_string() };
        (mark(vehicle_stroke(vehicle, vehicles)), words)
    };
    (0..vehicles).map(entry).collect()
}

/// Numbers that a chart can have room for: a broken sensor's 1e300 must not flatten everything else.
fn is_drawable(value: f64) -> bool {
    value.abs() < 1e9
}

/// Least and greatest of the drawable values; (0, 0) if there are none.
fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let drawable = values.filter(|value| is_drawable(*value));
    let (low, high) =
        drawable.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn all_figures_are_drawn_with_a_label_and_a_unit_on_each_axis() {
        let figures = all(&sample::flight(5, 7, 60));
        let names: Vec<&str> = figures.iter().map(|figure| figure.name).collect();
        assert_eq!(names, NAMES);
        let labels = [
            "x, north (m)",
            "clearance (m)",
            "speed (m/s)",
            "course (\u{b0})",
            "bank, right (\u{b0})",
            "altitude (m)",
            "time (s)",
        ];
        for (figure, label) in figures.iter().zip(labels) {
            assert!(figure.svg.contains(label), "{}", figure.name);
            assert!(figure.svg.len() > 2000 && !figure.caption.is_empty(), "{}", figure.name);
        }
    }

    #[test]
    fn no_flight_gives_a_drawing_with_a_coordinate_that_is_no_number() {
        let mut broken = sample::flight(3, 2, 20);
        broken.trajectory.rows[4].state.x_m = f64::NAN;
        broken.trajectory.rows[5].state.speed_mps = f64::INFINITY;
        broken.trajectory.rows[6].state.course_rad = 1e300;
        broken.trajectory.rows[7].alpha = [f64::NAN; 3];
        broken.trajectory.ticks[3].min_clearance_m = f64::NAN;
        let degenerate = [(0, 0, 0), (5, 7, 0), (1, 0, 1), (1, 0, 9), (200, 7, 3)];
        let flights = degenerate.map(|(vehicles, obstacles, ticks)| sample::flight(vehicles, obstacles, ticks));
        for flight in flights.iter().chain([&broken]) {
            for Figure { name, svg, .. } in all(flight) {
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}: {svg}");
                crate::report::to_png(&svg, 0.5).unwrap();
            }
        }
    }

    #[test]
    fn a_course_that_crosses_south_is_two_lines() {
        let line = [(0.0, 170.0), (1.0, 179.0), (2.0, -178.0), (3.0, -170.0)];
        let broken = broken_at_seam(&line);
        assert_eq!(broken.len(), 5);
        assert!(broken[2].1.is_nan());
    }

    #[test]
    fn every_line_of_a_figure_is_told_apart_and_more_vehicles_are_bands() {
        let entries = vehicle_entries(LINES_MAX, Mark::Line);
        let styles: std::collections::HashSet<String> = entries.iter().map(|(mark, _)| format!("{mark:?}")).collect();
        assert_eq!(styles.len(), LINES_MAX);
        for (vehicles, bands) in [(LINES_MAX, 0), (LINES_MAX + 1, 2), (200, 2)] {
            let flight = sample::flight(vehicles, 0, 30);
            for svg in [speeds(&flight), courses(&flight), altitudes(&flight), bank(&flight)] {
                // In the drawing and in the legend.
                assert_eq!(svg.matches("<polygon").count(), 2 * bands, "{vehicles}");
                assert!(svg.matches("<path").count() < 60 + vehicles.min(LINES_MAX), "no line for each of {vehicles}");
            }
        }
    }

    #[test]
    fn a_vehicle_that_leaves_the_flock_is_numbered() {
        let mut flight = sample::flight(50, 0, 60);
        for tick in 20..30 {
            flight.trajectory.rows[50 * tick + 41].state.altitude_m = 90.0;
        }
        let svg = altitudes(&flight);
        assert!(svg.contains(">UAV 42</text>") && svg.contains(">42</text>"), "{svg}");
    }
}
