//! The report of a flight: `report.html`, which stands alone, and its figures as SVG and PNG.

pub(crate) mod chart;
pub mod figures;
mod html;
mod key_figures;
mod png;
mod replay;
#[cfg(test)]
pub(crate) mod sample;
pub(crate) mod svg;

pub use figures::Figure;
pub(crate) use html::{CSS, fill};
pub(crate) use key_figures::headline;
pub use png::{PngError, to_png};
pub(crate) use svg::escape;

use crate::{
    flight::Flight,
    record::{RecordError, RunFolder},
};
use rayon::prelude::*;
use std::path::Path;

/// Pixels of a PNG for every px of the SVG: 480 dots per inch when a figure is as wide as a paper's column.
pub(crate) const PNG_SCALE: f64 = 3.0;

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
        name: String,
        /// What went wrong.
        source: PngError,
    },
    /// The replay's data could not be encoded.
    #[error("cannot encode the replay: {0}")]
    Replay(#[from] serde_json::Error),
}

/// Writes `report.html` and `figures/*.svg` and `*.png` into the run folder.
pub fn write(folder: &Path, flight: &Flight) -> Result<(), ReportError> {
    let folder = RunFolder::create(folder)?;
    let figures = figures::all(flight);
    let page = html::page(flight, &figures)?;
    figures.par_iter().try_for_each(|Figure { name, svg, .. }| {
        let png = to_png(svg, PNG_SCALE).map_err(|source| ReportError::Png { name: (*name).to_owned(), source })?;
        folder.write(&format!("figures/{name}.svg"), svg.as_bytes())?;
        Ok::<(), ReportError>(folder.write(&format!("figures/{name}.png"), &png)?)
    })?;
    // Last, so that its links lead somewhere as soon as it is there.
    Ok(folder.write("report.html", page.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_a_page_and_its_figures_and_the_same_each_time() {
        let root = tempfile::tempdir().unwrap();
        let flight = sample::flight(3, 7, 40);
        let names = figures::NAMES;
        let mut files: Vec<String> =
            names.iter().flat_map(|name| [format!("figures/{name}.svg"), format!("figures/{name}.png")]).collect();
        files.push("report.html".to_owned());
        for run in ["one", "other"] {
            write(&root.path().join(run), &flight).unwrap();
        }
        for file in files {
            let one = std::fs::read(root.path().join("one").join(&file)).unwrap();
            assert!(one.len() > 1000, "{file}");
            assert!(one == std::fs::read(root.path().join("other").join(&file)).unwrap(), "{file}");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_is_an_error() {
        let root = tempfile::tempdir().unwrap();
        let taken = root.path().join("taken");
        std::fs::write(&taken, b"").unwrap();
        assert!(matches!(write(&taken, &sample::flight(1, 0, 1)), Err(ReportError::Write(_))));
    }

    #[test]
    #[ignore = "writes runs to look at into the folder that COLUMBA_SAMPLES names"]
    fn writes_samples() {
        let folder = std::env::var("COLUMBA_SAMPLES").unwrap();
        let folder = Path::new(&folder);
        for (name, vehicles, obstacles, ticks) in [
            ("five", 5, 7, 85),
            ("twelve", 12, 7, 85),
            ("one", 1, 7, 85),
            ("open", 3, 0, 85),
            ("fifty", 50, 7, 85),
            ("many", 200, 7, 85),
            ("none", 5, 7, 0),
            ("first", 2, 1, 1),
        ] {
            let (folder, flight) = (folder.join(name), sample::flight(vehicles, obstacles, ticks));
            write(&folder, &flight).unwrap();
            crate::record::write(&RunFolder::create(folder).unwrap(), &flight).unwrap();
        }
    }
}
