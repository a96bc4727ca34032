//! Many vehicles in one chart: bands of percentiles over the flock, and by number the few vehicles that leave them.

use super::{VehicleLine, is_drawable};
use crate::report::{
    chart::{Anchor, Axis, Frame, INK, Mark, series, tag},
    svg::{Drawing, Stroke},
};

/// So many vehicles beyond the bands are drawn and numbered, at most.
const OUTLIERS_MAX: usize = 4;
/// A vehicle is one of them where it is so far beyond a band, as a share of the chart's height.
const OUTLIER_SHARE: f64 = 0.08;
/// Opacities of the outer and the inner band.
const OUTER: f64 = 0.2;
const INNER: f64 = 0.35;

/// The flock at one moment, in quantiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// When, s.
    pub t_s: f64,
    /// Least, 5 %, 25 %, median, 75 %, 95 %, greatest.
    pub quantiles: [f64; 7],
}

const SHARES: [f64; 7] = [0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0];
/// Indices of the quantiles.
pub const LEAST: usize = 0;
pub const P5: usize = 1;
pub const P25: usize = 2;
pub const MEDIAN: usize = 3;
pub const P75: usize = 4;
pub const P95: usize = 5;
pub const GREATEST: usize = 6;

impl Spread {
    /// The quantiles of some values; none of no drawable value.
    pub fn of(t_s: f64, values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.filter(|value| is_drawable(*value)).collect();
        sorted.sort_by(f64::total_cmp);
        if sorted.is_empty() {
            return None;
        }
        Some(Self { t_s, quantiles: SHARES.map(|share| quantile(&sorted, share)) })
    }
}

/// A quantile of sorted values; between two of them on the straight line from one to the other. NaN of no value.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len().max(1) - 1) as f64;
    let at = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    let (below, above) = (at(place.floor() as usize), at(place.ceil() as usize));
    // Written so, two infinities of one sign are their own mean.
    if below == above { below } else { below + (place - place.floor()) * (above - below) }
}

/// The flock at each moment of its vehicles' lines, which have the same times.
pub fn spreads(lines: &[VehicleLine]) -> Vec<Spread> {
    let moments = lines.iter().map(Vec::len).min().unwrap_or(0);
    let spread = |moment: usize| Spread::of(lines[0][moment].0, lines.iter().map(|line| line[moment].1));
    (0..moments).filter_map(spread).collect()
}

/// A vehicle that leaves the outer band, and where it is farthest from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Its index.
    pub vehicle: usize,
    /// When, and its value there.
    pub at: (f64, f64),
    excess: f64,
}

/// The vehicles that leave the outer band farthest, in order of their numbers.
pub fn outliers(lines: &[VehicleLine], spreads: &[Spread], y: &Axis) -> Vec<Outlier> {
    let farthest = |(vehicle, line): (usize, &VehicleLine)| {
        let excesses = spreads.iter().filter_map(|spread| {
            let &(t_s, value) = line.get(line.partition_point(|(t_s, _)| *t_s < spread.t_s))?;
            let excess = (value - spread.quantiles[P95]).max(spread.quantiles[P5] - value);
            is_drawable(excess).then_some(Outlier { vehicle, at: (t_s, value), excess })
        });
        excesses.max_by(|one, other| one.excess.total_cmp(&other.excess))
    };
    let mut found: Vec<Outlier> = lines.iter().enumerate().filter_map(farthest).collect();
    found.retain(|outlier| outlier.excess > OUTLIER_SHARE * y.span());
    found.sort_by(|one, other| other.excess.total_cmp(&one.excess));
    found.truncate(OUTLIERS_MAX);
    found.sort_by_key(|outlier| outlier.vehicle);
    found
}

/// The legend of [`draw`].
pub fn legend(vehicles: usize, outliers: &[Outlier]) -> Vec<(Mark, String)> {
    let mut entries = vec![
        (Mark::Line(median_stroke()), format!("median of {vehicles} UAVs")),
        (Mark::Band(series(0), OUTER + INNER), "25 to 75 %".to_owned()),
        (Mark::Band(series(0), OUTER), "5 to 95 %".to_owned()),
        (Mark::Line(extreme_stroke()), "least and greatest".to_owned()),
    ];
    for (index, outlier) in outliers.iter().enumerate() {
        entries.push((Mark::Line(outlier_stroke(index)), format!("UAV {}", outlier.vehicle + 1)));
    }
    entries
}

/// Draws the bands, the median, the extremes and the outliers.
pub fn draw(drawing: &mut Drawing, frame: &Frame, lines: &[VehicleLine], spreads: &[Spread], outliers: &[Outlier]) {
    let side = |quantile: usize| spreads.iter().map(move |spread| (spread.t_s, spread.quantiles[quantile]));
    for (low, high, opacity) in [(P5, P95, OUTER), (P25, P75, INNER)] {
        let outline = frame.points(side(high).chain(side(low).rev()));
        drawing.area(&outline, series(0), &format!(" fill-opacity=\"{opacity}\""));
    }
    for quantile in [LEAST, GREATEST] {
        drawing.line(&frame.points(side(quantile)), extreme_stroke());
    }
    drawing.line(&frame.points(side(MEDIAN)), median_stroke());
    for (index, outlier) in outliers.iter().enumerate() {
        if let Some(line) = lines.get(outlier.vehicle) {
            drawing.line(&frame.points(line.iter().copied()), outlier_stroke(index));
        }
    }
    for (index, outlier) in outliers.iter().enumerate() {
        let (x, y) = frame.point(outlier.at.0, outlier.at.1);
        // Inside the frame, whatever the place.
        let x = x.clamp(frame.left + 14.0, frame.left + frame.width - 14.0);
        let y = (y - 6.0).clamp(frame.top + 14.0, frame.top + frame.height - 4.0);
        tag(drawing, (x, y), Anchor::Middle, outlier_stroke(index).colour, &(outlier.vehicle + 1).to_string());
    }
}

fn median_stroke() -> Stroke {
    Stroke::solid(series(0), 1.8)
}

fn extreme_stroke() -> Stroke {
    Stroke { dashes: "2 3", ..Stroke::solid(INK, 0.9) }
}

/// Colours beside that of the bands.
fn outlier_stroke(index: usize) -> Stroke {
    Stroke::solid(series(index + 1), 1.4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_the_values() {
        let sorted = [1.0, 2.0, 4.0, 7.0];
        assert_eq!((quantile(&sorted, 0.0), quantile(&sorted, 0.5), quantile(&sorted, 1.0)), (1.0, 3.0, 7.0));
        assert_eq!(quantile(&sorted, 0.25), 1.75);
        assert_eq!(quantile(&[3.0], 0.95), 3.0);
        assert_eq!(quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.75), f64::INFINITY);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn who_leaves_the_bands_is_named_and_who_does_not_is_not() {
        // Forty vehicles at 10, of which one goes to 12 at 3 s and one to 8.5 at 5 s.
        let line = |vehicle: usize| -> VehicleLine {
            let value = |second: usize| match (vehicle, second) {
                (6, 3) => 12.0,
                (20, 5) => 8.5,
                (30, 7) => f64::NAN,
                _ => 10.0 + 0.001 * vehicle as f64,
            };
            (0..10).map(|second| (second as f64, value(second))).collect()
        };
        let lines: Vec<VehicleLine> = (0..40).map(line).collect();
        let spreads = spreads(&lines);
        assert_eq!(spreads.len(), 10);
        assert!((spreads[3].quantiles[P95] - 10.037).abs() < 0.005, "{:?}", spreads[3]);
        let found = outliers(&lines, &spreads, &Axis::nice(8.5, 12.0, 1.0, 5.0));
        let named: Vec<(usize, (f64, f64))> = found.iter().map(|outlier| (outlier.vehicle, outlier.at)).collect();
        assert_eq!(named, [(6, (3.0, 12.0)), (20, (5.0, 8.5))]);
        assert_eq!(legend(40, &found).last().map(|(_, words)| words.as_str()), Some("UAV 21"));
    }

    #[test]
    fn no_more_are_named_than_one_can_tell_apart() {
        let line =
            |vehicle: usize| vec![(0.0, if vehicle < 3 { 100.0 + vehicle as f64 } else { vehicle as f64 / 200.0 })];
        let lines: Vec<VehicleLine> = (0..200).map(line).collect();
        assert_eq!(outliers(&lines, &spreads(&lines), &Axis::nice(0.0, 102.0, 1.0, 5.0)).len(), 3);
        let line = |vehicle: usize| vec![(0.0, if vehicle < 9 { 100.0 + vehicle as f64 } else { 0.0 })];
        let lines: Vec<VehicleLine> = (0..200).map(line).collect();
        let found = outliers(&lines, &spreads(&lines), &Axis::nice(0.0, 102.0, 1.0, 5.0));
        assert_eq!(found.iter().map(|outlier| outlier.vehicle).collect::<Vec<_>>(), [5, 6, 7, 8]);
        assert!(spreads(&[]).is_empty());
    }
}
