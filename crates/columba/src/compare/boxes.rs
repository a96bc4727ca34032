//! Box plots: how each contender's flights are spread, by one measure.

use super::drawing::{Drawing, file_part};
use super::results::{ContenderSummary, MEASURES, Measure, Outcome};
use super::tables;
use crate::report::chart::{
    ALARM, Anchor, Axis, BELOW_PX, Frame, INK, Legend, Mark, RIGHT_PX, WIDTH_PX, diamond, dot, series, text_width_px,
};
use crate::report::figures::quantile;
use crate::report::svg::{Drawing as Svg, Stroke};

const ROW_PX: f64 = 28.0;
/// Half of a box's height.
const BOX_PX: f64 = 8.0;
/// Room for the share of flights that never came there.
const NEVER_PX: f64 = 76.0;
/// In it, the middle of the share, and of the paper's diamond.
const SHARE_PX: f64 = 48.0;
const DIAMOND_PX: f64 = 17.0;
const NAMES_MAX_PX: f64 = 240.0;

/// A figure for each of [`MEASURES`].
pub fn all(outcome: &Outcome<'_>) -> Vec<Drawing> {
    let figure = |(index, measure): (usize, &Measure)| Drawing {
        file: format!("{}-{}", file_part(outcome.scenario), file_part(measure.name)),
        title: capitalised(measure.name),
        svg: draw(outcome, index),
    };
    MEASURES.iter().enumerate().map(figure).collect()
}

/// A row for each contender.
fn draw(outcome: &Outcome<'_>, index: usize) -> String {
    let measure = &MEASURES[index];
    let rows: Vec<Row<'_>> =
        outcome.summaries.iter().map(|summary| Row::of(outcome.scenario, summary, index)).collect();
    let legend = legend(&rows);
    let frame = frame(&rows, legend.height());
    let mut drawing =
        Svg::new(WIDTH_PX, frame.top + frame.height + BELOW_PX, &format!("Box plot of {} by contender", measure.name));
    legend.draw(&mut drawing, 0.0);
    frame.draw_x(&mut drawing, &format!("{} ({})", measure.name, measure.unit));
    let right = frame.left + frame.width;
    if beyond(&rows) {
        drawing.text(right + SHARE_PX, frame.top - 6.0, Anchor::Middle, "never");
    }
    for (number, row) in rows.iter().enumerate() {
        let y = frame.top + (number as f64 + 0.5) * ROW_PX;
        drawing.text(frame.left - 7.0, y + 5.0, Anchor::End, &row.name);
        row.draw(&mut drawing, &frame, y);
        if row.never > 0.0 {
            drawing.text(right + SHARE_PX, y + 5.0, Anchor::Middle, &format!("{:.0} %", 100.0 * row.never));
        }
    }
    drawing.finish()
}

/// One contender.
struct Row<'a> {
    name: String,
    /// In ascending order; infinite for what never came.
    values: &'a [f64],
    never: f64,
    /// What the paper says of its own flight.
    paper: Option<f64>,
}

impl<'a> Row<'a> {
    fn of(scenario: &str, summary: &'a ContenderSummary<'_>, index: usize) -> Self {
        let values = summary.samples[index].as_slice();
        let never = values.iter().filter(|value| **value == f64::INFINITY).count();
        let paper = tables::in_the_paper(scenario, summary.algorithm);
        let of_measure = |(speed_s, course_s)| [Some(speed_s), Some(course_s)].get(index).copied().flatten();
        Self {
            name: shortened(summary.contender),
            values,
            never: never as f64 / values.len().max(1) as f64,
            paper: paper.and_then(of_measure),
        }
    }

    fn finite(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied().chain(self.paper).filter(|value| value.is_finite())
    }

    fn draw(&self, drawing: &mut Svg, frame: &Frame, y: f64) {
        let right = frame.left + frame.width;
        // What never came lies beyond the chart.
        let x = |value: f64| if value.is_finite() { frame.point(value, 0.0).0 } else { right + 6.0 };
        let [p5, p25, median, p75, p95] = [0.05, 0.25, 0.5, 0.75, 0.95].map(|share| quantile(self.values, share));
        if !p5.is_nan() {
            drawing.line(&[(x(p5), y), (x(p95), y)], Stroke::solid(INK, 1.2));
            let outline = [(x(p25), y - BOX_PX), (x(p75), y - BOX_PX), (x(p75), y + BOX_PX), (x(p25), y + BOX_PX)];
            drawing.area(&outline, series(5), " stroke=\"#1a1a1a\" stroke-width=\"1\"");
            if median.is_finite() {
                drawing.line(&[(x(median), y - BOX_PX), (x(median), y + BOX_PX)], Stroke::solid(INK, 2.2));
            }
            for value in self.values.iter().filter(|value| value.is_finite() && (**value < p5 || **value > p95)) {
                dot(drawing, (x(*value), y), 2.2, INK);
            }
        }
        if let Some(paper) = self.paper {
            let at = if paper.is_finite() { x(paper) } else { right + DIAMOND_PX };
            diamond(drawing, (at, y), ALARM);
        }
    }
}

fn legend(rows: &[Row<'_>]) -> Legend {
    let mut entries = vec![
        (Mark::Band(series(5), 1.0), "middle half".to_owned()),
        (Mark::Bar(INK), "median".to_owned()),
        (Mark::Line(Stroke::solid(INK, 1.2)), "5 to 95 %".to_owned()),
        (Mark::Dot(INK), "flights beyond".to_owned()),
    ];
    if rows.iter().any(|row| row.paper.is_some()) {
        entries.push((Mark::Diamond(ALARM), "the paper's one flight".to_owned()));
    }
    Legend::new(entries)
}

/// Whether something lies beyond the chart: flights that never came there, or the paper's.
fn beyond(rows: &[Row<'_>]) -> bool {
    rows.iter().any(|row| row.never > 0.0 || row.paper == Some(f64::INFINITY))
}

/// Rows from top to bottom beside their names.
fn frame(rows: &[Row<'_>], legend_px: f64) -> Frame {
    let names_px = rows.iter().map(|row| text_width_px(&row.name)).fold(40.0, f64::max).min(NAMES_MAX_PX);
    let beyond = beyond(rows);
    let values = || rows.iter().flat_map(Row::finite);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let left = names_px + 14.0;
    Frame {
        left,
        top: legend_px + if beyond { 14.0 } else { 0.0 },
        width: WIDTH_PX - left - if beyond { NEVER_PX } else { RIGHT_PX },
        height: ROW_PX * rows.len().max(1) as f64,
        x: Axis::nice(low, high, (0.02 * high.abs()).max(1e-3), 5.0),
        y: Axis::exact(0.0, 1.0, 1.0),
    }
}

/// A name that has room beside the chart.
fn shortened(name: &str) -> String {
    if text_width_px(name) <= NAMES_MAX_PX {
        return name.to_owned();
    }
    let mut short = String::new();
    for character in name.chars() {
        if text_width_px(&short) > NAMES_MAX_PX - 20.0 {
            break;
        }
        short.push(character);
    }
    short + "..."
}

fn capitalised(words: &str) -> String {
    let mut characters = words.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

#[cfg(test)]
mod tests {
    use super::super::results::{outcomes, tests::flown};
    use super::super::{Planned, plan::tests::plan, results};
    use super::*;
    use crate::flight::Summary;

    /// Of the first contender every flight converges at 20 s and more, of the second every second one.
    fn figures(names: &[&str]) -> Vec<Drawing> {
        let plan = plan(names, &[], &(1..=40).collect::<Vec<u64>>()).unwrap();
        let flights: Vec<Summary> = plan
            .flights()
            .map(|Planned { contender, seed, .. }| {
                let converged = contender == 0 || seed.is_multiple_of(2);
                flown(seed, converged.then_some(20.0 + 0.1 * seed as f64), 2.0 + 0.01 * seed as f64)
            })
            .collect();
        let rows: Vec<results::Row<'_>> = plan
            .flights()
            .zip(&flights)
            .map(|(planned, summary)| results::Row {
                scenario: &plan.scenarios[0],
                contender: &plan.contenders[planned.contender],
                seed: planned.seed,
                evaluations: 651,
                summary,
            })
            .collect();
        all(&outcomes(&plan, &rows)[0])
    }

    #[test]
    fn every_measure_has_a_figure_with_a_row_for_each_contender() {
        let figures = figures(&["one", "other"]);
        let files: Vec<&str> = figures.iter().map(|figure| figure.file.as_str()).collect();
        assert_eq!(
            files,
            [
                "paper-speed-convergence",
                "paper-course-convergence",
                "paper-smallest-separation",
                "paper-speed-variation",
                "paper-course-variation",
                "paper-flock-radius"
            ]
        );
        for Drawing { svg, .. } in &figures {
            assert!(svg.contains(">one</text>") && svg.contains(">other</text>"), "{svg}");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            crate::report::to_png(svg, 0.5).unwrap();
        }
        let (speed, separation) = (&figures[0].svg, &figures[2].svg);
        assert!(speed.contains(">never</text>") && speed.contains(">50 %</text>"), "{speed}");
        assert!(!separation.contains("never"), "{separation}");
        // Two flights of forty on either side of the middle 90 %, for both contenders.
        assert_eq!(separation.matches("r=\"2.2\"").count(), 2 * 4 + 1);
        // The paper's scenario and its algorithm: 37 s.
        assert!(speed.contains("the paper&#39;s one flight") && !separation.contains("the paper"));
    }

    #[test]
    fn long_names_are_shortened_and_markup_is_text() {
        let long = "a contender with a name that is far too long to be of any use in a figure";
        let figures = figures(&["<b>&", long]);
        assert!(figures[0].svg.contains("&lt;b&gt;&amp;") && !figures[0].svg.contains("<b>"));
        assert!(figures[0].svg.contains("...</text>") && !figures[0].svg.contains(long));
        assert!(text_width_px(&shortened(long)) < NAMES_MAX_PX + 20.0);
    }
}
