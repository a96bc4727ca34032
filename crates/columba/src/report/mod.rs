//! The report of a flight: `report.html`, which stands alone, and its figures as SVG and PNG.

mod chart;
pub mod figures;
mod png;
#[cfg(test)]
mod sample;
mod svg;

pub use figures::Figure;
pub use png::{PngError, to_png};

use crate::{
    flight::Flight,
    record::{RecordError, RunFolder},
};
use rayon::prelude::*;
use std::path::Path;

/// Pixels of a PNG for every px of the SVG: 480 dots per inch when a figure is as wide as a paper's column.
const PNG_SCALE: f64 = 3.0;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] RecordError),
    /// A figure could not be drawn as PNG.
    #[error("figure {name}: {source}")]
    Png {
        /// The figure.
        name: &'static str,
        /// What went wrong.
        source: PngError,
    },
}

/// Writes `report.html` and `figures/*.svg` and `*.png` into the run folder.
pub fn write(folder: &Path, flight: &Flight) -> Result<(), ReportError> {
    let folder = RunFolder::create(folder)?;
    let figures = figures::all(flight);
    figures.par_iter().try_for_each(|Figure { name, svg, .. }| {
        let png = to_png(svg, PNG_SCALE).map_err(|source| ReportError::Png { name, source })?;
        folder.write(&format!("figures/{name}.svg"), svg.as_bytes())?;
        Ok::<(), ReportError>(folder.write(&format!("figures/{name}.png"), &png)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "writes reports to look at into the folder that COLUMBA_SAMPLES names"]
    fn writes_samples() {
        let folder = std::env::var("COLUMBA_SAMPLES").unwrap();
        let folder = Path::new(&folder);
        for (name, vehicles, obstacles, ticks) in [
            ("five", 5, 7, 85),
            ("one", 1, 7, 85),
            ("open", 3, 0, 85),
            ("fifty", 50, 7, 85),
            ("many", 200, 7, 85),
            ("none", 5, 7, 0),
            ("first", 2, 1, 1),
        ] {
            write(&folder.join(name), &sample::flight(vehicles, obstacles, ticks)).unwrap();
        }
    }
}
