//! Alpha over time.

use super::{bounds, is_drawable, time_frame};
use crate::{
    flight::Flight,
    report::{
        chart::{Axis, BELOW_PX, Frame, Legend, Mark, WIDTH_PX, series},
        svg::{Drawing, Stroke},
    },
};

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

fn median(sorted: &[f64]) -> f64 {
    let middle = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    0.5 * (middle((sorted.len().max(1) - 1) / 2) + middle(sorted.len() / 2))
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

    #[test]
    fn the_median_of_an_even_flock_lies_between_the_middle_two() {
        assert_eq!(median(&[1.0, 2.0, 7.0]), 2.0);
        assert_eq!(median(&[1.0, 2.0, 4.0, 7.0]), 3.0);
        assert!(median(&[]).is_nan());
    }
}
