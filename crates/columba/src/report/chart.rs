//! The parts of a chart: axes with round ticks, a frame that maps data to px, a legend above it.

pub use super::svg::Anchor;
use super::svg::{Colour, Drawing, Stroke, number};

/// Every figure is as wide as a column of a paper at 0.45 pt/px; its text is then 6.7 pt.
pub const WIDTH_PX: f64 = 560.0;

/// Text, axes.
pub const INK: Colour = Colour { hex: "#1a1a1a", class: "ink" };
/// What stays behind the data.
pub const FAINT: Colour = Colour { hex: "#dddddd", class: "faint" };
/// Expected values and yardsticks.
pub const GUIDE: Colour = Colour { hex: "#6b6b6b", class: "guide" };
/// Limits that must not be crossed, and where they were.
pub const ALARM: Colour = Colour { hex: "#c1121f", class: "alarm" };
/// Colours of the vehicles, in turn: told apart by every common kind of colour vision (Okabe and Ito's set without
/// yellow and black, which a white or a dark page swallows, and with a grey and an olive).
pub const SERIES: [Colour; 8] = [
    Colour { hex: "#0072b2", class: "s1" },
    Colour { hex: "#d55e00", class: "s2" },
    Colour { hex: "#009e73", class: "s3" },
    Colour { hex: "#cc79a7", class: "s4" },
    Colour { hex: "#e69f00", class: "s5" },
    Colour { hex: "#56b4e9", class: "s6" },
    Colour { hex: "#7f7f7f", class: "s7" },
    Colour { hex: "#999933", class: "s8" },
];

/// The colour of a vehicle.
pub fn series(index: usize) -> Colour {
    SERIES.get(index % SERIES.len()).copied().unwrap_or(INK)
}

/// A range and its ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    step: f64,
    /// Whether the axis runs from right to left, or from top to bottom.
    reversed: bool,
}

impl Axis {
    /// The range as it is, with about `count` round ticks inside. A range that is empty or not finite becomes one unit
    /// wide.
    pub fn exact(low: f64, high: f64, count: f64) -> Self {
        let low = if low.is_finite() { low } else { 0.0 };
        // Up to 1e12 times: beyond that neighbouring ticks would be the same number.
        let least = (low.abs() * 1e-12).max(f64::MIN_POSITIVE);
        let high = if high.is_finite() && high - low > least { high } else { low + least.max(1.0) };
        Self { low, high, step: nice_step((high - low) / count), reversed: false }
    }

    /// The range widened outwards to round ticks, and to at least `least_span`.
    pub fn nice(low: f64, high: f64, least_span: f64, count: f64) -> Self {
        let (low, high) = if low.is_finite() && high.is_finite() && low <= high { (low, high) } else { (0.0, 0.0) };
        let missing = (least_span - (high - low)).max(0.0);
        let Self { low, high, step, .. } = Self::exact(low - 0.5 * missing, high + 0.5 * missing, count);
        // A thousandth of a step over a tick is rounding, not data that would need another tick.
        let (first, last) = ((low / step + 1e-3).floor(), (high / step - 1e-3).ceil());
        Self { low: low.min(first * step), high: high.max(last * step), step, reversed: false }
    }

    /// The same range from the other end.
    pub fn reversed(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    /// The high end.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// From the low end to the high end.
    pub fn span(&self) -> f64 {
        self.high - self.low
    }

    /// Where the ticks are.
    pub fn ticks(&self) -> Vec<f64> {
        let first = (self.low / self.step - 1e-9).ceil();
        let count = ((self.high / self.step + 1e-9).floor() - first).clamp(0.0, 1000.0) as usize;
        (0..=count).map(|index| (first + index as f64) * self.step).collect()
    }

    /// The low and the high end.
    #[cfg(test)]
    fn range(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// A tick's label: as many decimals as the step needs, with a real minus sign.
    pub fn label(&self, tick: f64) -> String {
        let decimals = (-libm::log10(self.step) - 1e-9).ceil().clamp(0.0, 12.0) as usize;
        let text = format!("{tick:.decimals$}");
        match text.strip_prefix('-') {
            Some(digits) if digits.bytes().all(|digit| digit == b'0' || digit == b'.') => digits.to_owned(),
            Some(digits) => format!("\u{2212}{digits}"),
            None => text,
        }
    }

    fn fraction(&self, value: f64) -> f64 {
        let fraction = (value - self.low) / (self.high - self.low);
        if self.reversed { 1.0 - fraction } else { fraction }
    }
}

/// The least of 1, 2 and 5 times a power of ten that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let power = libm::exp10(libm::log10(raw).floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= raw * (1.0 - 1e-9)).unwrap_or(10.0);
    factor * power
}

/// The rectangle of a chart: where data is, in px of the drawing.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Left edge, px.
    pub left: f64,
    /// Top edge, px.
    pub top: f64,
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
    /// Left to right.
    pub x: Axis,
    /// Bottom to top, unless it is reversed.
    pub y: Axis,
}

/// Room left of a frame for tick labels and the axis label, px.
pub const LEFT_PX: f64 = 66.0;
/// Room right of a frame, px.
pub const RIGHT_PX: f64 = 16.0;
/// Room below a frame for tick labels and the axis label, px.
pub const BELOW_PX: f64 = 50.0;

impl Frame {
    /// A data point in px.
    pub fn point(&self, x: f64, y: f64) -> (f64, f64) {
        (self.left + self.width * self.x.fraction(x), self.top + self.height * (1.0 - self.y.fraction(y)))
    }

    /// Data points in px.
    pub fn points(&self, data: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
        data.into_iter().map(|(x, y)| self.point(x, y)).collect()
    }

    /// Draws grid, border, tick labels and axis labels. An empty x label leaves out the x tick labels, too: a chart
    /// below has them.
    pub fn draw(&self, drawing: &mut Drawing, x_label: &str, y_label: &str) {
        for tick in self.y.ticks() {
            let y = self.point(0.0, tick).1;
            drawing.line(&[(self.left, y), (self.left + self.width, y)], Stroke::solid(FAINT, 1.0));
            drawing.text(self.left - 7.0, y + 5.0, Anchor::End, &self.y.label(tick));
        }
        self.draw_x(drawing, x_label);
        drawing.text_upwards(17.0, self.top + 0.5 * self.height, y_label);
    }

    /// Draws the grid of x, the border, and the labels of x alone: for rows that have names.
    pub fn draw_x(&self, drawing: &mut Drawing, x_label: &str) {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        for tick in self.x.ticks() {
            let x = self.point(tick, 0.0).0;
            drawing.line(&[(x, self.top), (x, bottom)], Stroke::solid(FAINT, 1.0));
            if !x_label.is_empty() {
                drawing.text(x, bottom + 18.0, Anchor::Middle, &self.x.label(tick));
            }
        }
        let corners = [(self.left, self.top), (right, self.top), (right, bottom), (self.left, bottom)];
        let border: Vec<(f64, f64)> = corners.into_iter().chain([(self.left, self.top)]).collect();
        drawing.line(&border, Stroke::solid(INK, 1.0));
        drawing.text(self.left + 0.5 * self.width, bottom + 41.0, Anchor::Middle, x_label);
    }

    /// Draws what `inside` draws, cut off at the frame. `name` must be one of its kind on a page.
    pub fn clipped(&self, drawing: &mut Drawing, name: &str, inside: impl FnOnce(&mut Drawing)) {
        drawing.raw(&format!(
            "<clipPath id=\"clip-{name}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n\
             <g clip-path=\"url(#clip-{name})\">",
            number(self.left),
            number(self.top),
            number(self.width),
            number(self.height)
        ));
        inside(drawing);
        drawing.raw("</g>");
    }
}

/// What stands before a legend's words.
#[derive(Clone, Copy, Debug)]
pub enum Mark {
    /// A piece of a line.
    Line(Stroke),
    /// A piece of a line with a triangle of so many px on it: a UAV and its path.
    Track(Stroke, f64),
    /// A disc, as an obstacle.
    Disc,
    /// A band between two lines, with its opacity.
    Band(Colour, f64),
    /// A bar across a row, as a median.
    Bar(Colour),
    /// A dot, as one value.
    Dot(Colour),
    /// A diamond, as a value from elsewhere.
    Diamond(Colour),
    /// A ring, as where something went wrong.
    Ring(Colour),
}

/// Outline of a triangle, so that one on top of another is told apart.
pub const TRIANGLE_EDGE: &str = " stroke=\"#ffffff\" stroke-width=\"0.7\"";

/// Fill and outline of an obstacle.
pub const DISC: &str = "class=\"disc\" fill=\"#e0e0e0\" stroke=\"#8c8c8c\"";

/// The outline of an obstacle alone.
pub const DISC_EDGE: &str = "class=\"disc-edge\" fill=\"none\" stroke=\"#8c8c8c\"";

/// A legend in rows above a chart, so that it covers no data.
#[derive(Clone, Debug)]
pub struct Legend {
    rows: Vec<Vec<(f64, Mark, String)>>,
}

const LEGEND_ROW_PX: f64 = 22.0;
const MARK_PX: f64 = 24.0;

/// How wide text is in DejaVu Sans at 15 px, near enough to place the next entry.
pub fn text_width_px(text: &str) -> f64 {
    let em = |character: char| match character {
        ' ' | '.' | ',' | '(' | ')' | 'i' | 'j' | 'l' => 0.35,
        'm' | 'w' | 'M' | 'W' | '=' | '\u{2212}' => 0.9,
        'A'..='Z' => 0.7,
        _ => 0.62,
    };
    15.0 * text.chars().map(em).sum::<f64>()
}

impl Legend {
    /// Lays out the entries from left to right in as many rows as the width of a figure needs.
    pub fn new(entries: impl IntoIterator<Item = (Mark, String)>) -> Self {
        let mut rows = Vec::new();
        let mut row = Vec::new();
        let mut x = LEFT_PX;
        for (mark, words) in entries {
            let width = MARK_PX + 6.0 + text_width_px(&words);
            if x + width > WIDTH_PX - 4.0 && !row.is_empty() {
                rows.push(std::mem::take(&mut row));
                x = LEFT_PX;
            }
            row.push((x, mark, words));
            x += width + 16.0;
        }
        if !row.is_empty() {
            rows.push(row);
        }
        Self { rows }
    }

    /// The room that the legend takes above a frame, px.
    pub fn height(&self) -> f64 {
        12.0 + LEGEND_ROW_PX * self.rows.len() as f64
    }

    /// Draws the legend from `top` downwards.
    pub fn draw(&self, drawing: &mut Drawing, top: f64) {
        for (index, row) in self.rows.iter().enumerate() {
            let y = top + 16.0 + LEGEND_ROW_PX * index as f64;
            for (x, mark, words) in row {
                draw_mark(drawing, *x, y, *mark);
                drawing.text(x + MARK_PX + 6.0, y + 5.0, Anchor::Start, words);
            }
        }
    }
}

fn draw_mark(drawing: &mut Drawing, x: f64, y: f64, mark: Mark) {
    let centre = format!("cx=\"{}\" cy=\"{}\"", number(x + 0.5 * MARK_PX), number(y));
    match mark {
        Mark::Line(stroke) => drawing.line(&[(x, y), (x + MARK_PX, y)], stroke),
        Mark::Disc => drawing.raw(&format!("<circle {centre} r=\"7.5\" {DISC}/>")),
        Mark::Track(stroke, size) => {
            drawing.line(&[(x, y), (x + MARK_PX, y)], stroke);
            drawing.area(&triangle((x + 13.0, y), 0.0, size), stroke.colour, TRIANGLE_EDGE);
        }
        Mark::Band(colour, opacity) => {
            let outline = [(x, y - 6.0), (x + MARK_PX, y - 6.0), (x + MARK_PX, y + 6.0), (x, y + 6.0)];
            drawing.area(&outline, colour, &format!(" fill-opacity=\"{opacity}\""));
        }
        Mark::Bar(colour) => {
            drawing.line(&[(x + 0.5 * MARK_PX, y - 7.0), (x + 0.5 * MARK_PX, y + 7.0)], Stroke::solid(colour, 2.2))
        }
        Mark::Dot(colour) => dot(drawing, (x + 0.5 * MARK_PX, y), 2.2, colour),
        Mark::Diamond(colour) => diamond(drawing, (x + 0.5 * MARK_PX, y), colour),
        Mark::Ring(colour) => ring(drawing, (x + 0.5 * MARK_PX, y), colour),
    }
}

/// A number at a point in px, readable on any ground.
pub fn tag(drawing: &mut Drawing, (x, y): (f64, f64), anchor: Anchor, colour: Colour, text: &str) {
    let halo = format!(
        " class=\"tag {}\" color=\"{}\" fill=\"currentColor\" font-size=\"13\" font-weight=\"bold\" stroke=\"#ffffff\" \
         stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
        colour.class, colour.hex
    );
    drawing.text_with(x, y, anchor, &halo, text);
}

/// A dot at a point in px.
pub fn dot(drawing: &mut Drawing, (x, y): (f64, f64), radius: f64, colour: Colour) {
    drawing.raw(&format!(
        "<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{radius}\" color=\"{}\" fill=\"currentColor\"/>",
        colour.class,
        number(x),
        number(y),
        colour.hex
    ));
}

/// An arrow to the right that ends at a point in px, and says that north is there.
pub fn north_arrow(drawing: &mut Drawing, (x, y): (f64, f64)) {
    drawing.text(x - 40.0, y + 5.0, Anchor::Middle, "N");
    drawing.line(&[(x - 29.0, y), (x - 7.0, y)], Stroke::solid(INK, 1.6));
    drawing.area(&triangle((x - 7.0, y), 0.0, 7.0), INK, TRIANGLE_EDGE);
}

/// A diamond at a point in px.
pub fn diamond(drawing: &mut Drawing, (x, y): (f64, f64), colour: Colour) {
    drawing.area(&[(x, y - 6.0), (x + 6.0, y), (x, y + 6.0), (x - 6.0, y)], colour, TRIANGLE_EDGE);
}

/// A ring around a point in px.
pub fn ring(drawing: &mut Drawing, (x, y): (f64, f64), colour: Colour) {
    drawing.raw(&format!(
        "<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"8\" fill=\"none\" color=\"{}\" stroke=\"currentColor\" \
         stroke-width=\"2\"/>",
        colour.class,
        number(x),
        number(y),
        colour.hex
    ));
}

/// A triangle around a point in px that points along a course in rad, counted from +x towards the top of the drawing.
pub fn triangle((x, y): (f64, f64), course_rad: f64, size: f64) -> [(f64, f64); 3] {
    let (sin, cos) = libm::sincos(course_rad);
    [(1.0, 0.0), (-0.7, 0.62), (-0.7, -0.62)]
        .map(|(ahead, left)| (x + size * (ahead * cos - left * sin), y - size * (ahead * sin + left * cos)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ticks_are_round_and_labels_have_the_decimals_they_need() {
        let axis = Axis::nice(8.83, 10.42, 1.0, 5.0);
        let labels: Vec<String> = axis.ticks().into_iter().map(|tick| axis.label(tick)).collect();
        assert_eq!(labels, ["8.5", "9.0", "9.5", "10.0", "10.5"]);
        let axis = Axis::exact(-180.0, 180.0, 4.0);
        let labels: Vec<String> = axis.ticks().into_iter().map(|tick| axis.label(tick)).collect();
        assert_eq!(labels, ["\u{2212}100", "0", "100"]);
        let axis = Axis::nice(0.0, 42.0, 1.0, 6.0);
        assert_eq!(axis.range(), (0.0, 50.0));
        assert_eq!(axis.label(-10.0), "\u{2212}10");
    }

    #[test]
    fn a_single_value_and_no_value_get_a_range_around_them() {
        let (low, high) = Axis::nice(50.0, 50.0, 1.0, 5.0).range();
        assert!(low <= 49.5 && high >= 50.5);
        assert_eq!(Axis::nice(f64::INFINITY, f64::NEG_INFINITY, 1.0, 4.0).range(), (-0.5, 0.5));
        assert_eq!(Axis::exact(3.0, f64::NAN, 5.0).range(), (3.0, 4.0));
    }

    #[test]
    fn data_is_mapped_with_y_upwards() {
        let (x, y) = (Axis::exact(0.0, 10.0, 5.0), Axis::exact(-1.0, 1.0, 5.0));
        let frame = Frame { left: 50.0, top: 20.0, width: 100.0, height: 200.0, x, y };
        assert_eq!(frame.point(0.0, -1.0), (50.0, 220.0));
        assert_eq!(frame.point(10.0, 1.0), (150.0, 20.0));
    }

    #[test]
    fn a_reversed_axis_runs_downwards() {
        let (x, y) = (Axis::exact(0.0, 10.0, 5.0), Axis::exact(-1.0, 1.0, 5.0).reversed());
        let frame = Frame { left: 50.0, top: 20.0, width: 100.0, height: 200.0, x, y };
        assert_eq!(frame.point(0.0, -1.0), (50.0, 20.0));
        assert_eq!(frame.point(0.0, 1.0), (50.0, 220.0));
        assert_eq!(frame.y.ticks(), Axis::exact(-1.0, 1.0, 5.0).ticks());
    }

    #[test]
    fn a_triangle_points_along_its_course() {
        let [nose, ..] = triangle((0.0, 0.0), std::f64::consts::FRAC_PI_2, 10.0);
        assert!(nose.0.abs() < 1e-9 && (nose.1 + 10.0).abs() < 1e-9);
    }

    #[test]
    fn a_long_legend_breaks_into_rows() {
        let entry = || (Mark::Disc, "UAV 1".to_owned());
        assert_eq!(Legend::new((0..3).map(|_| entry())).rows.len(), 1);
        let many = Legend::new((0..20).map(|_| entry()));
        assert!(many.rows.len() > 2);
        assert!(many.rows.iter().flatten().all(|(x, ..)| *x < WIDTH_PX - 60.0));
    }

    proptest! {
        #[test]
        fn ticks_lie_in_the_range_and_are_not_too_many(low in -1e6..1e6f64, span in 0.0..1e6f64) {
            let axis = Axis::nice(low, low + span, 1e-3, 5.0);
            let (bottom, top) = axis.range();
            prop_assert!(bottom <= low && top >= low + span);
            let ticks = axis.ticks();
            prop_assert!((2..=8).contains(&ticks.len()), "{:?}", ticks);
            let slack = 1e-6 * (top - bottom);
            prop_assert!(ticks.iter().all(|tick| *tick >= bottom - slack && *tick <= top + slack));
        }

        #[test]
        fn no_range_is_a_panic(low in any::<f64>(), high in any::<f64>()) {
            for axis in [Axis::exact(low, high, 5.0), Axis::nice(low, high, 1.0, 5.0)] {
                prop_assert!(axis.ticks().len() <= 1001);
            }
        }
    }
}
