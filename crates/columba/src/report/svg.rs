//! Writing SVG by hand: text, numbers, lines. The same drawing is the same string.

use std::fmt::Write;

/// Text for element content and quoted attributes of XML and HTML. Characters that XML cannot hold become U+FFFD.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\t' | '\n' | '\r' => escaped.push(character),
            '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            _ => escaped.push(character),
        }
    }
    escaped
}

/// A coordinate with at most two decimals and nothing superfluous: `3`, `-0.5`, `12.34`.
pub fn number(value: f64) -> String {
    let fixed = format!("{value:.2}");
    let trimmed = fixed.trim_end_matches('0').trim_end_matches('.');
    if trimmed == "-0" { "0".to_owned() } else { trimmed.to_owned() }
}

/// How text stands to its point.
#[derive(Clone, Copy, Debug)]
pub enum Anchor {
    /// The point is the text's left end.
    Start,
    /// The point is its middle.
    Middle,
    /// The point is its right end.
    End,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// Its colour.
    pub colour: Colour,
    /// Its width, px.
    pub width: f64,
    /// Its dashes, as `stroke-dasharray`; empty for a solid line.
    pub dashes: &'static str,
    /// Its opacity, 0 to 1.
    pub opacity: f64,
}

/// A colour as a value that stands alone, and a class by which the page's style sheet may change it in the dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour {
    /// `#rrggbb`.
    pub hex: &'static str,
    /// The class.
    pub class: &'static str,
}

impl Stroke {
    /// A solid line.
    pub fn solid(colour: Colour, width: f64) -> Self {
        Self { colour, width, dashes: "", opacity: 1.0 }
    }
}

/// A drawing in px, y downwards, on a ground of its own.
#[derive(Clone, Debug)]
pub struct Drawing {
    width: f64,
    height: f64,
    title: String,
    body: String,
}

impl Drawing {
    /// An empty drawing; `title` is what a screen reader says.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        Self { width, height, title: escape(title), body: String::new() }
    }

    /// Adds markup as it is.
    pub fn raw(&mut self, markup: &str) {
        self.body.push_str(markup);
        self.body.push('\n');
    }

    /// Adds text, escaped.
    pub fn text(&mut self, x: f64, y: f64, anchor: Anchor, text: &str) {
        self.text_with(x, y, anchor, "", text);
    }

    /// Adds text that runs upwards along a vertical axis.
    pub fn text_upwards(&mut self, x: f64, y: f64, text: &str) {
        let turn = format!(" transform=\"rotate(-90 {} {})\"", number(x), number(y));
        self.text_with(x, y, Anchor::Middle, &turn, text);
    }

    /// Adds text with attributes of its own.
    pub fn text_with(&mut self, x: f64, y: f64, anchor: Anchor, attributes: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y, text) = (number(x), number(y), escape(text));
        self.raw(&format!("<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\"{attributes}>{text}</text>"));
    }

    /// Adds a line through points. A point that is not finite interrupts it.
    pub fn line(&mut self, points: &[(f64, f64)], stroke: Stroke) {
        let mut path = String::new();
        for run in points.split(|(x, y)| !x.is_finite() || !y.is_finite()).filter(|run| run.len() > 1) {
            for (index, (x, y)) in simplify(run).into_iter().enumerate() {
                // Writing into a string cannot fail.
                let _ = write!(path, "{}{} {}", if index == 0 { 'M' } else { 'L' }, number(x), number(y));
            }
        }
        if path.is_empty() {
            return;
        }
        let Stroke { colour: Colour { hex, class }, width, dashes, opacity } = stroke;
        let dashes = if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") };
        let opacity = if opacity < 1.0 { format!(" stroke-opacity=\"{}\"", number(opacity)) } else { String::new() };
        self.raw(&format!(
            "<path class=\"{class}\" d=\"{path}\" fill=\"none\" color=\"{hex}\" stroke=\"currentColor\" \
             stroke-width=\"{}\" stroke-linejoin=\"round\"{dashes}{opacity}/>",
            number(width)
        ));
    }

    /// Adds a filled outline.
    pub fn area(&mut self, outline: &[(f64, f64)], colour: Colour, attributes: &str) {
        if outline.iter().any(|(x, y)| !x.is_finite() || !y.is_finite()) {
            return;
        }
        let points: Vec<String> = outline.iter().map(|&(x, y)| format!("{},{}", number(x), number(y))).collect();
        self.raw(&format!(
            "<polygon class=\"{}\" points=\"{}\" color=\"{}\" fill=\"currentColor\"{attributes}/>",
            colour.class,
            points.join(" "),
            colour.hex
        ));
    }

    /// The document.
    pub fn finish(self) -> String {
        let Self { width, height, title, body } = self;
        let (width, height) = (number(width), number(height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"DejaVu Sans, Arial, sans-serif\" \
             font-size=\"15\" fill=\"#1a1a1a\" class=\"figure\">\n\
             <title>{title}</title>\n<rect class=\"ground\" width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
             {body}</svg>\n"
        )
    }
}

/// The farthest that a line may leave a point it no longer goes through, px: nobody sees it at any print size.
const TOLERANCE_PX: f64 = 0.08;

/// The line with the points left out that lie on it anyway (Ramer, Douglas and Peucker).
fn simplify(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut keep = vec![false; points.len()];
    let mut spans = vec![(0, points.len().saturating_sub(1))];
    while let Some((first, last)) = spans.pop() {
        let (Some(&from), Some(&to)) = (points.get(first), points.get(last)) else { continue };
        let inner = points.iter().enumerate().take(last).skip(first + 1);
        let farthest = inner
            .map(|(index, &point)| (index, squared_distance(point, from, to)))
            .max_by(|(_, one), (_, other)| one.total_cmp(other));
        for end in [first, last] {
            if let Some(keep) = keep.get_mut(end) {
                *keep = true;
            }
        }
        if let Some((index, distance)) = farthest
            && distance > TOLERANCE_PX * TOLERANCE_PX
        {
            spans.extend([(first, index), (index, last)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// Squared distance of a point from the segment between two others.
fn squared_distance((x, y): (f64, f64), (ax, ay): (f64, f64), (bx, by): (f64, f64)) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 { (((x - ax) * dx + (y - ay) * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    let (ex, ey) = (x - ax - along * dx, y - ay - along * dy);
    ex * ex + ey * ey
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn markup_in_text_is_text() {
        assert_eq!(escape("<script>'a' & \"b\"</script>\u{1}"), {
            "&lt;script&gt;&#39;a&#39; &amp; &quot;b&quot;&lt;/script&gt;\u{fffd}"
        });
        let mut drawing = Drawing::new(10.0, 10.0, "<b>");
        drawing.text(0.0, 0.0, Anchor::Start, "a<b>");
        assert!(!drawing.finish().contains("<b>"));
    }

    #[test]
    fn numbers_are_short() {
        let shortened: Vec<String> = [0.0, -0.001, 3.0, 12.345_6, -0.5, 100.0].into_iter().map(number).collect();
        assert_eq!(shortened, ["0", "0", "3", "12.35", "-0.5", "100"]);
    }

    #[test]
    fn a_line_breaks_where_there_is_no_number() {
        let mut drawing = Drawing::new(10.0, 10.0, "");
        let points =
            [(0.0, 0.0), (1.0, 1.0), (f64::NAN, 0.0), (2.0, 0.0), (3.0, f64::INFINITY), (4.0, 0.0), (5.0, 1.0)];
        drawing.line(&points, Stroke::solid(Colour { hex: "#000000", class: "ink" }, 1.0));
        let svg = drawing.finish();
        assert!(svg.contains("d=\"M0 0L1 1M4 0L5 1\""), "{svg}");
    }

    #[test]
    fn points_on_a_straight_line_are_left_out_and_corners_are_not() {
        let mut points: Vec<(f64, f64)> = (0..=50).map(|step| (f64::from(step), 0.0)).collect();
        points.extend((1..=50).map(|step| (50.0, f64::from(step))));
        assert_eq!(simplify(&points), [(0.0, 0.0), (50.0, 0.0), (50.0, 50.0)]);
    }

    proptest! {
        #[test]
        fn a_simplified_line_passes_every_point(ys in prop::collection::vec(-50.0..50.0f64, 2..60)) {
            let points: Vec<(f64, f64)> = ys.iter().enumerate().map(|(index, &y)| (index as f64, y)).collect();
            let kept = simplify(&points);
            prop_assert_eq!(kept.first(), points.first());
            prop_assert_eq!(kept.last(), points.last());
            for &point in &points {
                let distances = kept.windows(2).map(|ends| squared_distance(point, ends[0], ends[1]));
                let nearest = distances.fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= TOLERANCE_PX * TOLERANCE_PX + 1e-12);
            }
        }
    }
}
