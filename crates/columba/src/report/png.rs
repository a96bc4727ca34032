//! The figures as PNG.

use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{self, Options, Tree, fontdb::Database},
};
use std::sync::{Arc, OnceLock};

/// DejaVu Sans with what figures need of it; its licence is beside it. System fonts are never asked: the same figure is
/// the same picture everywhere.
const FONT: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");

/// Why a drawing could not become a picture.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// The SVG does not parse.
    #[error("the drawing cannot be read: {0}")]
    Svg(#[from] usvg::Error),
    /// The picture would have no pixels, or too many.
    #[error("a picture of {width} by {height} px cannot be made")]
    Size {
        /// Width, px.
        width: f64,
        /// Height, px.
        height: f64,
    },
    /// The picture cannot be encoded.
    #[error("the picture cannot be encoded: {0}")]
    Encode(String),
}

/// Greatest side of a picture, px.
const SIDE_MAX_PX: f64 = 16_384.0;

/// A drawing as a PNG with `scale` pixels for every px of the SVG.
pub fn to_png(svg: &str, scale: f64) -> Result<Vec<u8>, PngError> {
    let options = Options { font_family: "DejaVu Sans".to_owned(), fontdb: fonts(), ..Options::default() };
    let tree = Tree::from_str(svg, &options)?;
    let width = (f64::from(tree.size().width()) * scale).ceil();
    let height = (f64::from(tree.size().height()) * scale).ceil();
    let fits = (1.0..=SIDE_MAX_PX).contains(&width) && (1.0..=SIDE_MAX_PX).contains(&height);
    let pixmap = if fits { Pixmap::new(width as u32, height as u32) } else { None };
    let mut pixmap = pixmap.ok_or(PngError::Size { width, height })?;
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|error| PngError::Encode(error.to_string()))
}

fn fonts() -> Arc<Database> {
    static FONTS: OnceLock<Arc<Database>> = OnceLock::new();
    FONTS
        .get_or_init(|| {
            let mut fonts = Database::new();
            fonts.load_font_data(FONT.to_vec());
            fonts.set_sans_serif_family("DejaVu Sans");
            Arc::new(fonts)
        })
        .clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str =
        "<svg xmlns='http://www.w3.org/2000/svg' width='10' height='20'><rect width='10' height='20'/></svg>";

    #[test]
    fn a_picture_has_the_size_asked_for() {
        let picture = Pixmap::decode_png(&to_png(SQUARE, 3.0).unwrap()).unwrap();
        assert_eq!((picture.width(), picture.height()), (30, 60));
    }

    #[test]
    fn text_is_drawn_with_the_font_that_comes_along() {
        let words = |words: &str| {
            let svg = format!(
                "<svg xmlns='http://www.w3.org/2000/svg' width='60' height='20' font-family='DejaVu Sans, Arial, \
                 sans-serif'><text y='15'>{words}</text></svg>"
            );
            let picture = Pixmap::decode_png(&to_png(&svg, 1.0).unwrap()).unwrap();
            picture.pixels().iter().filter(|pixel| pixel.alpha() > 127).count()
        };
        assert_eq!(words(""), 0);
        for character in ["a", "8", "\u{2212}", "\u{b0}", "\u{3b1}", "\u{209b}", "\u{394}"] {
            assert!(words(character) > 3, "{character}");
        }
    }

    #[test]
    fn what_is_no_drawing_and_what_is_too_large_are_errors() {
        assert!(matches!(to_png("<svg", 1.0), Err(PngError::Svg(_))));
        for scale in [0.0, 1e6, f64::NAN] {
            assert!(matches!(to_png(SQUARE, scale), Err(PngError::Size { .. })), "{scale}");
        }
    }
}
