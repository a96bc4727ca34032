//! Alpha over time.

use super::{
    bounds,
    spread::{GREATEST, LEAST, MEDIAN, P25, P75, Spread},
    time_frame,
};
use crate::{
    flight::Flight,
    report::{
        chart::{Axis, BELOW_PX, Frame, Legend, Mark, WIDTH_PX, series},
        svg::{Drawing, Stroke},
    },
};

/// Alpha over time: for each term the median over the flock, the band of its middle half, and the band from least to
/// greatest. One panel if all terms share one alpha.
pub fn alphas(flight: &Flight) -> String {
    let rows = &flight.trajectory.rows;
    let shared = rows.iter().all(|row| row.alpha.iter().all(|alpha| *alpha == row.alpha[0]));
    let panels: &[(usize, &str)] =
        if shared { &[(0, "α, all terms")] } else { &[(0, "α formation"), (1, "α obstacle"), (2, "α neighbours")] };
    let legend = Legend::new([
        (Mark::Line(Stroke::solid(series(0), 1.8)), "median".to_owned()),
        (Mark::Band(series(0), INNER + OUTER), "25 to 75 %".to_owned()),
        (Mark::Band(series(0), OUTER), "least to greatest".to_owned()),
    ]);

    let (_, high) = bounds(rows.iter().flat_map(|row| row.alpha).chain([1.0]));
    let (height, gap) = if shared { (230.0, 0.0) } else { (112.0, 22.0) };
    let mut frame =
        time_frame(flight, legend.height(), height, Axis::nice(0.0, high, 1.0, if shared { 5.0 } else { 3.0 }));
    let below = (panels.len() as f64 - 1.0) * (height + gap);
    let mut drawing = Drawing::new(WIDTH_PX, frame.top + below + height + BELOW_PX, "Alpha over time");
    legend.draw(&mut drawing, 0.0);
    for (index, (term, name)) in panels.iter().enumerate() {
        let x_label = if index + 1 == panels.len() { "time (s)" } else { "" };
        frame.draw(&mut drawing, x_label, name);
        frame.clipped(&mut drawing, &format!("alphas-{index}"), |drawing| draw_spread(drawing, &frame, flight, *term));
        frame.top += height + gap;
    }
    drawing.finish()
}

/// Opacities of the bands.
const OUTER: f64 = 0.2;
const INNER: f64 = 0.35;

/// The median and the bands of one term's alpha over the flock.
fn draw_spread(drawing: &mut Drawing, frame: &Frame, flight: &Flight, term: usize) {
    let spreads: Vec<Spread> = flight
        .trajectory
        .iter()
        .filter_map(|(tick, rows)| Spread::of(tick.t_s, rows.iter().filter_map(|row| row.alpha.get(term)).copied()))
        .collect();
    let side = |quantile: usize| spreads.iter().map(move |spread| (spread.t_s, spread.quantiles[quantile]));
    for (low, high, opacity) in [(LEAST, GREATEST, OUTER), (P25, P75, INNER)] {
        let outline = frame.points(side(high).chain(side(low).rev()));
        drawing.area(&outline, series(0), &format!(" fill-opacity=\"{opacity}\""));
    }
    drawing.line(&frame.points(side(MEDIAN)), Stroke::solid(series(0), 1.8));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn one_shared_alpha_is_one_panel() {
        let mut flight = sample::flight(3, 0, 20);
        assert_eq!(alphas(&flight).matches("<clipPath").count(), 3);
        for row in &mut flight.trajectory.rows {
            row.alpha = [row.alpha[0]; 3];
        }
        assert_eq!(alphas(&flight).matches("<clipPath").count(), 1);
    }
}
