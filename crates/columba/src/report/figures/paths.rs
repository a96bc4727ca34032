//! The paths among the circles, as a map.

use super::{LINES_MAX, bounds, vehicle_entries, vehicle_stroke};
use crate::{
    flight::{Flight, Row, vehicle_number},
    report::{
        chart::{
            ALARM, Anchor, Axis, BELOW_PX, DISC, DISC_EDGE, Frame, GUIDE, LEFT_PX, Legend, Mark, RIGHT_PX, SERIES,
            TRIANGLE_EDGE, WIDTH_PX, north_arrow, ring, series, tag, triangle,
        },
        svg::{Colour, Drawing, Stroke, number},
    },
};

/// The flight paths among the circles, with a triangle for every UAV at a few instants (the paper's Fig. 2a). A map
/// that is turned so that north is to the right, as most flights go: east is downwards, and what is left of a UAV is
/// left of it in the drawing. Both axes have the same scale.
pub fn paths(flight: &Flight) -> String {
    let (field, trajectory) = (&flight.field, &flight.trajectory);
    let look = Look::of(trajectory.vehicles);
    let named = if look.lines { Vec::new() } else { named(flight) };
    let mishaps = mishaps(flight);
    let legend = legend(flight, &look, &named, !mishaps.is_empty());
    let (frame, metres_per_px) = map_frame(flight, legend.height());

    let mut drawing =
        Drawing::new(WIDTH_PX, frame.top + frame.height + BELOW_PX, "Map of the flight paths among the obstacles");
    legend.draw(&mut drawing, 0.0);
    frame.draw(&mut drawing, "x, north (m)", "y, east (m)");
    north_arrow(&mut drawing, (frame.left + frame.width, frame.top + frame.height + 36.0));
    frame.clipped(&mut drawing, "paths", |drawing| {
        let circles: Vec<((f64, f64), f64)> = field
            .obstacles
            .iter()
            .map(|disc| (frame.point(disc.x_m, disc.y_m), disc.radius_m / metres_per_px))
            .collect();
        let circle = |drawing: &mut Drawing, ((x, y), radius): ((f64, f64), f64), paint: &str| {
            drawing.raw(&format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {paint}/>",
                number(x),
                number(y),
                number(radius)
            ));
        };
        for &place in &circles {
            circle(drawing, place, DISC);
        }
        let path = |vehicle| trajectory.vehicle(vehicle).map(|(_, row)| (row.state.x_m, row.state.y_m));
        for vehicle in 0..trajectory.vehicles {
            drawing.line(&frame.points(path(vehicle)), look.stroke(vehicle, trajectory.vehicles));
        }
        for (index, named) in named.iter().enumerate() {
            drawing.line(&frame.points(path(named.vehicle)), Stroke::solid(named_colour(index), 1.6));
        }
        for tick in instants(flight) {
            for (vehicle, row) in rows_at(flight, tick).iter().enumerate() {
                let at = frame.point(row.state.x_m, row.state.y_m);
                if !look.lines && circles.iter().any(|circle| covers(at, look.triangle_px, *circle)) {
                    continue;
                }
                let index = named.iter().position(|named| named.vehicle == vehicle);
                let colour = index.map_or_else(|| look.colour(vehicle), named_colour);
                // East is downwards: a course turns clockwise in the drawing, as on a map.
                drawing.area(&triangle(at, -row.state.course_rad, look.triangle_px), colour, TRIANGLE_EDGE);
            }
        }
        // Again, so that no triangle hides where a circle ends.
        for &place in &circles {
            circle(drawing, place, DISC_EDGE);
        }
        let ends = named.iter().filter_map(|named| path(named.vehicle).last());
        let ends: Vec<(f64, f64)> = ends.map(|(x_m, y_m)| frame.point(x_m, y_m)).collect();
        for (index, (named, at)) in named.iter().zip(apart(&ends, &frame)).enumerate() {
            tag(drawing, at, Anchor::Start, named_colour(index), &vehicle_number(named.vehicle).to_string());
        }
        for (x_m, y_m) in mishaps {
            ring(drawing, frame.point(x_m, y_m), ALARM);
        }
    });
    drawing.finish()
}

/// Places for numbers beside these points in px, in the same order: none on another.
fn apart(ends: &[(f64, f64)], frame: &Frame) -> Vec<(f64, f64)> {
    const LINE_PX: f64 = 14.0;
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by(|&one, &other| ends[one].1.total_cmp(&ends[other].1));
    let mut places = ends.to_vec();
    let mut lowest = f64::NEG_INFINITY;
    for index in order {
        let (x, y) = ends[index];
        let y = (y + 5.0).max(lowest + LINE_PX).clamp(frame.top + LINE_PX, frame.top + frame.height - 4.0);
        places[index] = ((x + 8.0).min(frame.left + frame.width - 30.0), y);
        lowest = y;
    }
    places
}

/// How vehicles are drawn, by how many there are.
struct Look {
    /// Whether each has a line of its own look.
    lines: bool,
    triangle_px: f64,
}

impl Look {
    fn of(vehicles: usize) -> Self {
        let triangle_px = match vehicles {
            0..=8 => 7.5,
            9..=LINES_MAX => 6.0,
            _ => 3.5,
        };
        Self { lines: vehicles <= LINES_MAX, triangle_px }
    }

    fn stroke(&self, vehicle: usize, vehicles: usize) -> Stroke {
        if self.lines {
            return vehicle_stroke(vehicle, vehicles);
        }
        Stroke { opacity: 0.4, ..Stroke::solid(GUIDE, 0.7) }
    }

    fn colour(&self, vehicle: usize) -> Colour {
        if self.lines { series(vehicle) } else { SERIES[0] }
    }
}

/// A colour for a vehicle that is named among many.
fn named_colour(index: usize) -> Colour {
    series(index + 1)
}

/// A vehicle that the key figures name, and why.
struct Named {
    vehicle: usize,
    why: &'static str,
}

/// The vehicles of the smallest separation and of the smallest clearance.
fn named(flight: &Flight) -> Vec<Named> {
    let summary = &flight.summary;
    let pair = summary.min_separation_vehicles.into_iter().flatten().map(|number| (number, "smallest separation"));
    let nearest = summary.min_clearance_vehicle.into_iter().map(|number| (number, "smallest clearance"));
    let mut named: Vec<Named> = Vec::new();
    for (number, why) in pair.chain(nearest) {
        let Some(vehicle) = (number as usize).checked_sub(1) else { continue };
        if vehicle < flight.trajectory.vehicles && !named.iter().any(|known| known.vehicle == vehicle) {
            named.push(Named { vehicle, why });
        }
    }
    named
}

fn legend(flight: &Flight, look: &Look, named: &[Named], collided: bool) -> Legend {
    let vehicles = flight.trajectory.vehicles;
    let mut entries = if look.lines {
        vehicle_entries(vehicles, |stroke| Mark::Track(stroke, look.triangle_px))
    } else {
        vec![(Mark::Track(look.stroke(0, vehicles), look.triangle_px), format!("{vehicles} UAVs"))]
    };
    for (index, Named { vehicle, why }) in named.iter().enumerate() {
        let words = format!("UAV {}: {why}", vehicle_number(*vehicle));
        entries.push((Mark::Track(Stroke::solid(named_colour(index), 1.6), look.triangle_px), words));
    }
    if !flight.field.obstacles.is_empty() {
        entries.push((Mark::Disc, "obstacle".to_owned()));
    }
    if collided {
        entries.push((Mark::Ring(ALARM), "collision".to_owned()));
    }
    Legend::new(entries)
}

/// A frame around the field and all paths, and the scale that both of its axes have, metres per px. The field fills the
/// width, unless it is taller than a page likes.
fn map_frame(flight: &Flight, top: f64) -> (Frame, f64) {
    let circles = flight.field.obstacles.iter();
    let xs = circles.clone().flat_map(|disc| [disc.x_m - disc.radius_m, disc.x_m + disc.radius_m]);
    let ys = circles.flat_map(|disc| [disc.y_m - disc.radius_m, disc.y_m + disc.radius_m]);
    let rows = &flight.trajectory.rows;
    let (x_low, x_high) = bounds(xs.chain(rows.iter().map(|row| row.state.x_m)));
    let (y_low, y_high) = bounds(ys.chain(rows.iter().map(|row| row.state.y_m)));
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
        top,
        width,
        height,
        x: around(x_low, x_high, width, 7.0),
        y: around(y_low, y_high, height, (height / 38.0).max(2.5)).reversed(),
    };
    (frame, metres_per_px)
}

/// Whether a triangle of this size at a point in px would cover a circle.
fn covers((x, y): (f64, f64), size_px: f64, ((circle_x, circle_y), radius): ((f64, f64), f64)) -> bool {
    libm::hypot(x - circle_x, y - circle_y) < radius + size_px
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
    if flight.trajectory.vehicles > LINES_MAX {
        // A crowd of triangles hides the paths.
        let mut chosen = vec![0, ticks.len() / 2, ticks.len() - 1];
        chosen.dedup();
        return chosen;
    }
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
    let when = match flight.trajectory.ticks.len() {
        0 | 1 => String::new(),
        _ if flight.trajectory.vehicles > LINES_MAX => {
            " Triangles point along the course, at the start, halfway and at the end, but not on obstacles.".to_owned()
        }
        _ => {
            let interval_s = instant_interval_s(flight);
            format!(" Triangles point along the course, at the start, every {interval_s} s and at the end.")
        }
    };
    format!(
        "Map with north to the right: x is north, y is east and increases downwards, so that left of a UAV is left in \
         the map. The paper's Fig. 2 has the same x axis and draws y upwards.{when}"
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
        // In the drawing, in the legend, and in the arrow to the north. Circles have their edges drawn a second time.
        assert_eq!(svg.matches("<polygon").count(), 2 * 5 + 2 + 1);
        assert_eq!(svg.matches("<circle").count(), 2 * 3 + 1);
    }

    /// The corners of every triangle in the map, in px.
    fn triangles(svg: &str) -> Vec<Vec<(f64, f64)>> {
        let map = svg.split("<clipPath").nth(1).unwrap();
        let corner = |corner: &str| {
            let (x, y) = corner.split_once(',').unwrap();
            (x.parse().unwrap(), y.parse().unwrap())
        };
        let points = map.split("points=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
        points.map(|points| points.split(' ').map(corner).collect()).collect()
    }

    #[test]
    fn the_figure_is_a_map_and_not_its_mirror_image() {
        // To the north-east: right and down where north is to the right.
        let mut flight = sample::flight(1, 0, 20);
        for (tick, row) in flight.trajectory.rows.iter_mut().enumerate() {
            (row.state.x_m, row.state.y_m) = (5.0 * tick as f64, 5.0 * tick as f64);
            row.state.course_rad = std::f64::consts::FRAC_PI_4;
        }
        let svg = paths(&flight);
        let triangles = triangles(&svg);
        let (first, last) = (&triangles[0], &triangles[triangles.len() - 1]);
        assert!(last[0].0 > first[0].0 + 100.0 && last[0].1 > first[0].1 + 100.0, "{first:?} {last:?}");
        // The nose is the first corner.
        assert!(first[0].0 > first[1].0 && first[0].1 > first[1].1, "{first:?}");
        for words in ["x, north (m)", "y, east (m)", ">N</text>"] {
            assert!(svg.contains(words), "{words}");
        }
        // Labels of y from top to bottom.
        let labels: Vec<f64> = svg
            .lines()
            .filter(|line| line.contains("text-anchor=\"end\""))
            .filter_map(|line| line.split('>').nth(1)?.split('<').next()?.replace('\u{2212}', "-").parse().ok())
            .collect();
        assert!(labels.len() > 2, "{labels:?}");
        let y_px: Vec<f64> = svg
            .lines()
            .filter(|line| line.contains("text-anchor=\"end\""))
            .filter_map(|line| line.split(" y=\"").nth(1)?.split('"').next()?.parse().ok())
            .collect();
        assert!(labels.windows(2).zip(y_px.windows(2)).all(|(y, px)| (y[1] > y[0]) == (px[1] > px[0])));
    }

    #[test]
    fn among_many_vehicles_no_triangle_covers_a_circle_and_the_key_figures_vehicles_are_named() {
        let flight = sample::flight(60, 7, 86);
        let svg = paths(&flight);
        let frame = map_frame(&flight, 0.0);
        let circles: Vec<((f64, f64), f64)> = svg
            .lines()
            .filter(|line| line.starts_with("<circle cx") && line.contains(DISC_EDGE))
            .map(|line| {
                let value = |name: &str| -> f64 {
                    line.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
                };
                ((value("cx"), value("cy")), value("r"))
            })
            .collect();
        assert_eq!(circles.len(), 7);
        let triangles = triangles(&svg);
        assert!(triangles.len() > 150, "{}", triangles.len());
        for triangle in &triangles {
            for &((x, y), radius) in &circles {
                assert!(triangle.iter().all(|corner| libm::hypot(corner.0 - x, corner.1 - y) > radius - 0.1));
            }
        }
        assert!(frame.1 > 0.0);
        // The sample names UAVs 1 and 2 for the separation, and 1 for the clearance.
        assert!(svg.contains("UAV 1: smallest separation") && svg.contains("UAV 2: smallest separation"));
        assert!(!svg.contains("UAV 1: smallest clearance"));
    }

    #[test]
    fn both_axes_have_one_scale() {
        // A circle of 10 m at the middle of two vehicles: its radius in px is as far as its edge in x.
        let mut flight = sample::flight(1, 1, 86);
        flight.field.obstacles[0].radius_m = 10.0;
        let svg = paths(&flight);
        let circle = svg.lines().rfind(|line| line.starts_with("<circle cx")).unwrap();
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
