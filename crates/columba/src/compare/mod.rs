//! Comparing optimisers and settings over many flights: the paper's Table 1 and Fig. 2 to 4.
//!
//! A [`Plan`] says which flights; [`campaign`] flies those that the [`Journal`] does not hold yet; [`results`] sums
//! them up by [`statistics`]; `parquet.rs`, `tables.rs`, `table_files.rs`, `boxes.rs` and `report.rs` write what people
//! and scripts read.

mod boxes;
pub mod campaign;
mod drawing;
mod journal;
mod parquet;
mod plan;
mod report;
pub mod results;
mod seeds;
pub mod statistics;
mod table_files;
mod tables;

pub use journal::{Flown, JOURNAL, Journal, JournalError};
pub use plan::{Plan, PlanError, Planned};
pub use report::{Picture, draw};
pub use seeds::Seeds;
pub use table_files::headline;

use crate::record::{RecordError, RunFolder};
use crate::report::ReportError;
use results::{Outcome, Row};

/// Why the results of a comparison could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] RecordError),
    /// A table could not be encoded.
    #[error("cannot encode the flights: {0}")]
    Parquet(#[from] ::parquet::errors::ParquetError),
    /// The same, as JSON.
    #[error("cannot encode the table: {0}")]
    Json(#[from] serde_json::Error),
    /// A figure could not be drawn.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// Every flight of a plan that is flown, in its order.
pub fn rows<'a>(plan: &'a Plan, flown: &'a Flown) -> Vec<Row<'a>> {
    let row = |planned: Planned| {
        let summary = flown.get(&planned.key)?;
        Some(Row {
            scenario: &plan.scenarios[planned.scenario],
            contender: &plan.contenders[planned.contender],
            seed: planned.seed,
            evaluations: plan.optimizer(planned.scenario, planned.contender).evaluations(),
            summary,
        })
    };
    plan.flights().filter_map(row).collect()
}

/// Writes every file of a comparison but its journal: what scripts read, and last the report that leads to it.
///
/// # Errors
/// A file cannot be encoded or written.
pub fn write(
    folder: &RunFolder,
    plan: &Plan,
    rows: &[Row<'_>],
    outcomes: &[Outcome<'_>],
    pictures: &[Picture],
) -> Result<(), CompareError> {
    folder.write("flights.parquet", &parquet::flights_parquet(rows)?)?;
    folder.write("timings.parquet", &parquet::timings_parquet(rows)?)?;
    folder.write("table.json", table_files::json(plan, outcomes)?.as_bytes())?;
    folder.write("table.md", table_files::markdown(plan, outcomes).as_bytes())?;
    Ok(report::write(folder, plan, outcomes, pictures)?)
}

/// What the screen shows of an outcome: its tables, and the times that another run changes.
pub fn screen(outcome: &Outcome<'_>) -> String {
    let tables = tables::tables(outcome).into_iter().chain([tables::times(outcome)]);
    tables.map(|table| table_files::of_table(&table)).collect()
}
