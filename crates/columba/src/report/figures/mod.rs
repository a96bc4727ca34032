//! The figures of a flight, each a function from the flight to an SVG: the three of the paper's Fig. 2 and three more.

mod alphas;
mod distances;
mod paths;

pub use alphas::alphas;
pub use distances::distances;
pub use paths::paths;

use super::{
    chart::{Axis, BELOW_PX, Frame, GUIDE, INK, LEFT_PX, Legend, Mark, RIGHT_PX, SERIES, WIDTH_PX, series},
    svg::{Drawing, Stroke},
};
use crate::flight::{Flight, Row, vehicle_number};
use flight_model::wrap_pi;
use rayon::prelude::*;

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

/// All figures, in the order of the report.
pub fn all(flight: &Flight) -> Vec<Figure> {
    type Draw = fn(&Flight) -> String;
    let figures: [(&str, &str, String, Draw); 6] = [
        ("paths", "Paths among the obstacles", paths::caption(flight), paths),
        ("speeds", "Speeds", "Horizontal speed of every UAV at each tick.".to_owned(), speeds),
        ("courses", "Courses", "Course over ground of every UAV, from x towards y.".to_owned(), courses),
        ("altitudes", "Altitudes", "Altitude of every UAV above the scenario's origin.".to_owned(), altitudes),
        ("distances", "Smallest separation and clearance", distances::caption(flight), distances),
        (
            "alphas",
            "Weights chosen by the optimiser",
            "Alpha of the formation, obstacle and neighbour-velocity terms (Eq. 5, 7, 8): the median over the flock and \
             the band between its least and its greatest."
                .to_owned(),
            alphas,
        ),
    ];
    figures
        .into_par_iter()
        .map(|(name, title, caption, draw)| Figure { name, title, caption, svg: draw(flight) })
        .collect()
}

/// Speed over time (the paper's Fig. 2b).
pub fn speeds(flight: &Flight) -> String {
    let expected = flight.field.expected.speed_mps;
    over_time(flight, "speeds", "speed (m/s)", expected, 1.0, |row| row.state.speed_mps)
}

/// Course over time in degrees (the paper's Fig. 2c), on the turn around the expected course.
pub fn courses(flight: &Flight) -> String {
    let expected_rad = wrap_pi(flight.field.expected.course_rad);
    over_time(flight, "courses", "course (\u{b0})", expected_rad.to_degrees(), 10.0, |row| {
        (expected_rad + wrap_pi(row.state.course_rad - expected_rad)).to_degrees()
    })
}

/// Altitude over time.
pub fn altitudes(flight: &Flight) -> String {
    let expected = flight.field.expected.altitude_m;
    over_time(flight, "altitudes", "altitude (m)", expected, 2.0, |row| row.state.altitude_m)
}

/// A figure with one line for each vehicle and a dashed one for the expected value.
fn over_time(
    flight: &Flight,
    name: &str,
    y_label: &str,
    expected: f64,
    least_span: f64,
    value: impl Fn(&Row) -> f64,
) -> String {
    let trajectory = &flight.trajectory;
    let guide = Stroke { dashes: "7 4", ..Stroke::solid(GUIDE, 1.4) };
    let legend = Legend::new(
        vehicle_entries(trajectory.vehicles, Mark::Line)
            .into_iter()
            .chain([(Mark::Line(guide), "expected".to_owned())]),
    );
    let (low, high) = bounds(trajectory.rows.iter().map(&value).chain([expected]));
    let frame = time_frame(flight, legend.height(), 230.0, Axis::nice(low, high, least_span, 5.0));

    let mut drawing = new_drawing(&frame, &format!("{y_label} over time"));
    legend.draw(&mut drawing);
    frame.draw(&mut drawing, "time (s)", y_label);
    frame.clipped(&mut drawing, name, |drawing| {
        for vehicle in 0..trajectory.vehicles {
            let line: Vec<(f64, f64)> = trajectory.vehicle(vehicle).map(|(t_s, row)| (t_s, value(row))).collect();
            drawing.line(&frame.points(broken_at_seam(&line)), vehicle_stroke(vehicle, trajectory.vehicles));
        }
        horizontal(drawing, &frame, expected, guide);
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

fn vehicle_stroke(vehicle: usize, vehicles: usize) -> Stroke {
    let (width, opacity) = match vehicles {
        0..=8 => (1.7, 1.0),
        9..=30 => (1.2, 0.9),
        _ => (0.9, 0.55),
    };
    Stroke { opacity, ..Stroke::solid(series(vehicle), width) }
}

/// One entry for each vehicle while there are colours for them, one for all beyond that.
fn vehicle_entries(vehicles: usize, mark: fn(Stroke) -> Mark) -> Vec<(Mark, String)> {
    if vehicles > SERIES.len() {
        let stroke = Stroke::solid(INK, 1.2);
        return vec![(mark(stroke), format!("UAVs 1 to {vehicles}, colours repeat"))];
    }
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
        assert_eq!(names, ["paths", "speeds", "courses", "altitudes", "distances", "alphas"]);
        let labels = ["x, north (m)", "speed (m/s)", "course (\u{b0})", "altitude (m)", "distance (m)", "time (s)"];
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
    fn many_vehicles_share_one_entry_of_the_legend() {
        assert_eq!(vehicle_entries(5, Mark::Line).len(), 5);
        assert_eq!(vehicle_entries(50, Mark::Line).len(), 1);
    }
}
