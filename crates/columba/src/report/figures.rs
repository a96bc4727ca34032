//! The figures of a flight, each a function from the flight to an SVG: the three of the paper's Fig. 2 and three more.

use super::{
    chart::{
        ALARM, Axis, BELOW_PX, DISC, Frame, GUIDE, INK, LEFT_PX, Legend, Mark, RIGHT_PX, SERIES, WIDTH_PX, ring,
        series, triangle,
    },
    svg::{Colour, Drawing, Stroke, number},
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
        ("paths", "Paths among the obstacles", paths_caption(flight), paths),
        ("speeds", "Speeds", "Horizontal speed of every UAV at each tick.".to_owned(), speeds),
        ("courses", "Courses", "Course over ground of every UAV, from x towards y.".to_owned(), courses),
        ("altitudes", "Altitudes", "Altitude of every UAV above the scenario's origin.".to_owned(), altitudes),
        ("distances", "Smallest separation and clearance", distances_caption(flight), distances),
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

/// The flight paths among the circles, with a triangle for every UAV at a few instants (the paper's Fig. 2a). Both axes
/// have the same scale.
pub fn paths(flight: &Flight) -> String {
    let (field, trajectory) = (&flight.field, &flight.trajectory);
    let circles = field.obstacles.iter();
    let xs = circles.clone().flat_map(|disc| [disc.x_m - disc.radius_m, disc.x_m + disc.radius_m]);
    let ys = circles.flat_map(|disc| [disc.y_m - disc.radius_m, disc.y_m + disc.radius_m]);
    let (x_low, x_high) = bounds(xs.chain(trajectory.rows.iter().map(|row| row.state.x_m)));
    let (y_low, y_high) = bounds(ys.chain(trajectory.rows.iter().map(|row| row.state.y_m)));

    let mut entries = vec![(Mark::Triangle(GUIDE), "UAV".to_owned())];
    if !field.obstacles.is_empty() {
        entries.push((Mark::Disc, "obstacle".to_owned()));
    }
    entries.extend(vehicle_entries(trajectory.vehicles));
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
                drawing.area(&outline, series(vehicle), " stroke=\"#ffffff\" stroke-width=\"0.7\"");
            }
        }
        for (x_m, y_m) in mishaps {
            ring(drawing, frame.point(x_m, y_m), ALARM);
        }
    });
    drawing.finish()
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

/// The smallest separation and clearance over time, against D_s and the collision distance.
pub fn distances(flight: &Flight) -> String {
    let Flight { field, trajectory, .. } = flight;
    let separation: Vec<(f64, f64)> = trajectory.ticks.iter().map(|tick| (tick.t_s, tick.min_separation_m)).collect();
    let clearance: Vec<(f64, f64)> = trajectory.ticks.iter().map(|tick| (tick.t_s, tick.min_clearance_m)).collect();

    let yardsticks = [
        (field.safe_distance_m, "D\u{209b}", Stroke { dashes: "7 4", ..Stroke::solid(GUIDE, 1.4) }),
        (field.collision_distance_m, "collision", Stroke { dashes: "2 3", ..Stroke::solid(ALARM, 1.4) }),
    ];
    let lines: Vec<(Vec<(f64, f64)>, Stroke, &str)> = [
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
    entries.extend(yardsticks.iter().map(|(value, name, stroke)| (Mark::Line(*stroke), format!("{name} {value} m"))));
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

/// Alpha over time: for each term the median over the flock and the band from least to greatest. One panel if all terms
/// share one alpha.
pub fn alphas(flight: &Flight) -> String {
    let rows = &flight.trajectory.rows;
    let shared = rows.iter().all(|row| row.alpha.iter().all(|alpha| *alpha == row.alpha[0]));
    let panels: &[(usize, &str)] =
        if shared { &[(0, "α, all terms")] } else { &[(0, "α formation"), (1, "α obstacle"), (2, "α neighbours")] };
    let legend = Legend::new([
        (Mark::Line(Stroke::solid(series(0), 1.8)), "median".to_owned()),
        (Mark::Band(series(0)), "least to greatest".to_owned()),
    ]);

    let (_, high) = bounds(rows.iter().flat_map(|row| row.alpha).chain([1.0]));
    let (height, gap) = if shared { (230.0, 0.0) } else { (112.0, 22.0) };
    let mut frame =
        time_frame(flight, legend.height(), height, Axis::nice(0.0, high, 1.0, if shared { 5.0 } else { 3.0 }));
    let below = (panels.len() as f64 - 1.0) * (height + gap);
    let mut drawing = Drawing::new(WIDTH_PX, frame.top + below + height + BELOW_PX, "Alpha over time");
    legend.draw(&mut drawing);
    for (index, (term, name)) in panels.iter().enumerate() {
        let x_label = if index + 1 == panels.len() { "time (s)" } else { "" };
        frame.draw(&mut drawing, x_label, name);
        frame.clipped(&mut drawing, &format!("alphas-{index}"), |drawing| draw_spread(drawing, &frame, flight, *term));
        frame.top += height + gap;
    }
    drawing.finish()
}

/// The median and the band of one term's alpha over the flock.
fn draw_spread(drawing: &mut Drawing, frame: &Frame, flight: &Flight, term: usize) {
    let mut spread = Vec::with_capacity(flight.trajectory.ticks.len());
    for (tick, rows) in flight.trajectory.iter() {
        let alphas = rows.iter().filter_map(|row| row.alpha.get(term)).copied();
        let mut alphas: Vec<f64> = alphas.filter(|alpha| is_drawable(*alpha)).collect();
        alphas.sort_by(f64::total_cmp);
        if let (Some(least), Some(greatest)) = (alphas.first(), alphas.last()) {
            spread.push((tick.t_s, *least, median(&alphas), *greatest));
        }
    }
    let upper = spread.iter().map(|&(t_s, _, _, greatest)| (t_s, greatest));
    let lower = spread.iter().rev().map(|&(t_s, least, ..)| (t_s, least));
    drawing.area(&frame.points(upper.chain(lower)), series(0), " fill-opacity=\"0.25\"");
    let medians = spread.iter().map(|&(t_s, _, median, _)| (t_s, median));
    drawing.line(&frame.points(medians), Stroke::solid(series(0), 1.8));
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
        vehicle_entries(trajectory.vehicles).into_iter().chain([(Mark::Line(guide), "expected".to_owned())]),
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
fn vehicle_entries(vehicles: usize) -> Vec<(Mark, String)> {
    if vehicles > SERIES.len() {
        let stroke = Stroke::solid(INK, 1.2);
        return vec![(Mark::Line(stroke), format!("UAVs 1 to {vehicles}, colours repeat"))];
    }
    let entry = |vehicle| {
        let number = vehicle_number(vehicle);
        let words = if vehicle == 0 { format!("UAV {number}") } else { number.to_string() };
        (Mark::Line(vehicle_stroke(vehicle, vehicles)), words)
    };
    (0..vehicles).map(entry).collect()
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

fn paths_caption(flight: &Flight) -> String {
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

fn distances_caption(flight: &Flight) -> String {
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

fn median(sorted: &[f64]) -> f64 {
    let middle = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    0.5 * (middle((sorted.len().max(1) - 1) / 2) + middle(sorted.len() / 2))
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
