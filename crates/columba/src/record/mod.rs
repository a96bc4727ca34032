//! The record of a run: one folder with `summary.json` and `trajectory.parquet`, none of it ever half-written.

mod folder;
mod parquet;
mod summary;
mod table;

pub use folder::{Occupied, RunFolder, holds_something};
pub use parquet::trajectory_parquet;
pub use summary::summary_json;
pub use table::{Column, table_parquet};

use crate::flight::Flight;

/// Why a run could not be recorded.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The run folder cannot be made or written into.
    #[error("cannot write into the run folder {}: {source}", path.display())]
    Folder {
        /// The folder.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The run folder holds something already, or another run is writing into it.
    #[error("the folder {} is not empty", path.display())]
    Occupied {
        /// The folder.
        path: std::path::PathBuf,
    },
    /// A file of the run cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The trajectory cannot be encoded.
    #[error("cannot encode the trajectory: {0}")]
    Trajectory(#[from] ::parquet::errors::ParquetError),
    /// The summary cannot be encoded.
    #[error("cannot encode the summary: {0}")]
    Summary(#[from] serde_json::Error),
}

/// Writes `summary.json` and `trajectory.parquet`.
pub fn write(folder: &RunFolder, flight: &Flight) -> Result<(), RecordError> {
    folder.write("trajectory.parquet", &trajectory_parquet(&flight.trajectory)?)?;
    folder.write("summary.json", summary_json(&flight.summary)?.as_bytes())
}
