//! Pictures of a flight for others: a moving one (APNG, which browsers and READMEs play) and a still one (PNG), drawn
//! from the replay of its report.

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use live_view::wire::{Places, places};
use resvg::tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Trails reach back so far, s.
const TRAIL_S: f64 = 8.0;
/// Frames a second of the moving picture.
const FRAMES_PER_S: u16 = 12;
/// Room around the field, m.
const MARGIN_M: f32 = 12.0;

const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [0, 114, 178];
const TRAIL: [u8; 3] = [176, 211, 232];
const DISC: [u8; 3] = [222, 226, 230];
const EDGE: [u8; 3] = [122, 134, 145];

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum ShareError {
    /// The report has no replay that this version can read.
    #[error("the report has no replay of this version: must be report.html of a flight that has flown")]
    NoReplay,
    /// The picture would have no pixels, or too many.
    #[error("a picture {0} px wide cannot be made")]
    Size(u32),
    /// It cannot be encoded.
    #[error("the picture cannot be encoded: {0}")]
    Encode(#[from] png::EncodingError),
}

/// A flight as its report replays it.
#[derive(Clone, Debug)]
pub struct Replay {
    frames: Vec<Places>,
    /// North, east, radius, m.
    circles: Vec<[f32; 3]>,
}

impl Replay {
    /// From the text of `report.html`.
    ///
    /// # Errors
    /// There is no replay in it.
    pub fn read(report: &str) -> Result<Self, ShareError> {
        let part = |id: &str| -> Option<String> {
            let (_, after) = report.split_once(&format!("id=&quot;{id}&quot;&gt;"))?;
            let (text, _) = after.split_once("&lt;/script&gt;")?;
            Some(text.replace("&quot;", "\"").replace("&#39;", "'").replace("&gt;", ">").replace("&amp;", "&"))
        };
        let head = part("recording").and_then(|head| serde_json::from_str::<serde_json::Value>(&head).ok());
        let bytes = part("recording-frames").and_then(|text| BASE64.decode(text.trim()).ok());
        let (Some(head), Some(bytes)) = (head, bytes) else { return Err(ShareError::NoReplay) };
        let circles = head["scene"]["circles"].as_array().into_iter().flatten();
        let circles =
            circles.map(|one| ["x_m", "y_m", "radius_m"].map(|key| one[key].as_f64().unwrap_or(0.0) as f32)).collect();
        let mut frames = Vec::new();
        let mut at = 0;
        while let Some(length) = bytes.get(at..at + 4) {
            let length = u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
            let frame = bytes.get(at + 4..at + 4 + length).and_then(places).ok_or(ShareError::NoReplay)?;
            frames.push(frame);
            at += 4 + length;
        }
        if frames.is_empty() { Err(ShareError::NoReplay) } else { Ok(Self { frames, circles }) }
    }

    /// When it ends, s.
    fn end_s(&self) -> f64 {
        self.frames.last().map_or(0.0, |frame| frame.time_s)
    }

    /// Where a vehicle is at a time, on the straight line between two frames.
    fn at(&self, vehicle: usize, time_s: f64) -> Option<[f32; 4]> {
        let next = self.frames.partition_point(|frame| frame.time_s < time_s).min(self.frames.len() - 1);
        let (b, a) = (&self.frames[next], &self.frames[next.saturating_sub(1)]);
        let (from, to) = ((*a.vehicles.get(vehicle)?)?, (*b.vehicles.get(vehicle)?)?);
        let span_s = b.time_s - a.time_s;
        let part = if span_s > 0.0 { ((time_s - a.time_s) / span_s).clamp(0.0, 1.0) as f32 } else { 1.0 };
        let [x_m, y_m, altitude_m] = [0, 1, 2].map(|k| from[k] + part * (to[k] - from[k]));
        let turn_rad = (to[3] - from[3] + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU);
        Some([x_m, y_m, altitude_m, from[3] + part * (turn_rad - std::f32::consts::PI)])
    }

    /// The moving picture: the whole flight in so many seconds.
    ///
    /// # Errors
    /// The size cannot be, or the encoder fails.
    pub fn moving(&self, width: u32, seconds: f64) -> Result<Vec<u8>, ShareError> {
        let camera = Camera::over(self, width);
        let frames = ((seconds * f64::from(FRAMES_PER_S)).round() as u32).max(2);
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, camera.width, camera.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.set_animated(frames, 0)?;
        encoder.set_frame_delay(1, FRAMES_PER_S)?;
        let mut writer = encoder.write_header()?;
        for frame in 0..frames {
            let time_s = self.end_s() * f64::from(frame) / f64::from(frames - 1);
            writer.write_image_data(&self.draw(&camera, time_s, TRAIL_S)?)?;
        }
        writer.finish()?;
        Ok(out)
    }

    /// The still picture: the end of the flight, with all of the way.
    ///
    /// # Errors
    /// As [`moving`](Self::moving).
    pub fn still(&self, width: u32) -> Result<Vec<u8>, ShareError> {
        let camera = Camera::over(self, width);
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, camera.width, camera.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.draw(&camera, self.end_s(), f64::INFINITY)?)?;
        writer.finish()?;
        Ok(out)
    }

    /// One picture, three bytes a pixel.
    fn draw(&self, camera: &Camera, time_s: f64, trail_s: f64) -> Result<Vec<u8>, ShareError> {
        let mut map = Pixmap::new(camera.width, camera.height).ok_or(ShareError::Size(camera.width))?;
        map.fill(colour(PAPER));
        for &[x_m, y_m, radius_m] in &self.circles {
            let [across, down] = camera.px(x_m, y_m);
            let Some(disc) = PathBuilder::from_circle(across, down, radius_m * camera.scale) else { continue };
            map.fill_path(&disc, &paint(DISC), FillRule::Winding, Transform::identity(), None);
            map.stroke_path(&disc, &paint(EDGE), &Stroke::default(), Transform::identity(), None);
        }
        let vehicles = self.frames.iter().map(|frame| frame.vehicles.len()).max().unwrap_or(0);
        let size_px = if vehicles > 60 { 4.0 } else { 7.0 };
        let first = self.frames.partition_point(|frame| frame.time_s < time_s - trail_s);
        let last = self.frames.partition_point(|frame| frame.time_s < time_s);
        for vehicle in 0..vehicles {
            let mut way = PathBuilder::new();
            let seen =
                self.frames[first.min(last)..last].iter().map(|frame| frame.vehicles.get(vehicle).copied().flatten());
            for place in seen.chain([self.at(vehicle, time_s)]).flatten() {
                let [across, down] = camera.px(place[0], place[1]);
                if way.is_empty() { way.move_to(across, down) } else { way.line_to(across, down) }
            }
            if let Some(way) = way.finish() {
                map.stroke_path(&way, &paint(TRAIL), &Stroke::default(), Transform::identity(), None);
            }
        }
        for vehicle in 0..vehicles {
            let Some([x_m, y_m, _, course_rad]) = self.at(vehicle, time_s) else { continue };
            let [across, down] = camera.px(x_m, y_m);
            let [ahead_across, ahead_down] = camera.direction(course_rad);
            let mut arrow = PathBuilder::new();
            for (index, (along, aside)) in [(1.0, 0.0), (-0.75, 0.62), (-0.75, -0.62)].into_iter().enumerate() {
                let (along, aside) = (size_px * along, size_px * aside);
                let corner_across = across + along * ahead_across - aside * ahead_down;
                let corner_down = down + along * ahead_down + aside * ahead_across;
                if index == 0 {
                    arrow.move_to(corner_across, corner_down)
                } else {
                    arrow.line_to(corner_across, corner_down)
                }
            }
            arrow.close();
            if let Some(arrow) = arrow.finish() {
                map.fill_path(&arrow, &paint(INK), FillRule::Winding, Transform::identity(), None);
            }
        }
        // All is opaque. Sixteen shades of each colour are fewer bytes, and nobody sees the difference.
        let shade = |byte: u8| ((u16::from(byte) + 8) / 17 * 17) as u8;
        Ok(map.data().chunks_exact(4).flat_map(|pixel| [shade(pixel[0]), shade(pixel[1]), shade(pixel[2])]).collect())
    }
}

/// From metres to pixels: a map with north up, or to the right where the field is longer that way.
struct Camera {
    width: u32,
    height: u32,
    scale: f32,
    low: [f32; 2],
    high: [f32; 2],
    north_is_right: bool,
}

impl Camera {
    fn over(replay: &Replay, width: u32) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let places = replay.frames.iter().flat_map(|frame| frame.vehicles.iter().flatten());
        let places = places.map(|place| [place[0], place[1], 0.0]).chain(replay.circles.iter().copied());
        for [x_m, y_m, radius_m] in places {
            for (axis, value_m) in [x_m, y_m].into_iter().enumerate() {
                low[axis] = low[axis].min(value_m - radius_m - MARGIN_M);
                high[axis] = high[axis].max(value_m + radius_m + MARGIN_M);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([-MARGIN_M; 2], [MARGIN_M; 2]);
        }
        let (north_m, east_m) = (high[0] - low[0], high[1] - low[1]);
        let north_is_right = north_m > east_m;
        let (across_m, down_m) = if north_is_right { (north_m, east_m) } else { (east_m, north_m) };
        let scale = width as f32 / across_m;
        let height = ((down_m * scale).round() as u32).clamp(64, width.max(64));
        Self { width, height, scale: scale.min(height as f32 / down_m), low, high, north_is_right }
    }

    fn px(&self, x_m: f32, y_m: f32) -> [f32; 2] {
        match self.north_is_right {
            true => [(x_m - self.low[0]) * self.scale, (y_m - self.low[1]) * self.scale],
            false => [(y_m - self.low[1]) * self.scale, (self.high[0] - x_m) * self.scale],
        }
    }

    fn direction(&self, course_rad: f32) -> [f32; 2] {
        let (north, east) = (libm::cosf(course_rad), libm::sinf(course_rad));
        if self.north_is_right { [north, east] } else { [east, -north] }
    }
}

fn colour([red, green, blue]: [u8; 3]) -> Color {
    Color::from_rgba8(red, green, blue, 255)
}

fn paint(rgb: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(colour(rgb));
    paint.anti_alias = true;
    paint
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report;

    fn replay(vehicles: usize) -> Replay {
        let folder = tempfile::tempdir().unwrap();
        report::write(folder.path(), &report::sample::flight(vehicles, 3, 20)).unwrap();
        Replay::read(&std::fs::read_to_string(folder.path().join("report.html")).unwrap()).unwrap()
    }

    #[test]
    fn the_report_is_read_back_and_drawn() {
        let replay = replay(3);
        assert_eq!((replay.frames.len(), replay.circles.len()), (20, 3));
        let moving = replay.moving(320, 1.0).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(&moving)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(12));
        let camera = Camera::over(&replay, 320);
        let picture = replay.draw(&camera, 5.0, TRAIL_S).unwrap();
        let blue = picture.chunks(3).filter(|pixel| pixel[0] < 32 && pixel[2] > 128).count();
        assert!(blue > 30, "three vehicles: {blue} pixels");
        assert!(replay.still(320).unwrap().len() > 1000);
    }

    #[test]
    fn what_is_no_report_is_refused() {
        for text in ["", "<html>", "id=&quot;recording&quot;&gt;{}&lt;/script&gt;"] {
            assert!(matches!(Replay::read(text), Err(ShareError::NoReplay)));
        }
    }
}
