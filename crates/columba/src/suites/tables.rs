//! What a comparison leaves behind: Parquet files for scripts and a Markdown table for people.

use super::{Plan, Solve};
use crate::compare::statistics::{Interval, median, median_interval};
use crate::record::{Column, table_parquet};
use optimizer::Algorithm;
use optimizer::suites::Suite;
use parquet::errors::ParquetError;
use std::fmt::Write;

/// The columns of objectives; a problem of fewer has null in the last.
const OBJECTIVES: [&str; 3] = ["f1", "f2", "f3"];

/// `fronts.parquet`: a row for each member of each front, with `problem`, `optimizer`, `seed`, `member` (from 1) and
/// its costs.
pub fn fronts(solves: &[Solve]) -> Result<Vec<u8>, ParquetError> {
    let solve_of: Vec<&Solve> = solves.iter().flat_map(|solve| solve.front.iter().map(move |_| solve)).collect();
    let members = solves.iter().flat_map(|solve| 1..=solve.front.len() as i64).collect();
    let costs: Vec<&[f64]> = solves.iter().flat_map(|solve| &solve.front).map(Vec::as_slice).collect();
    let mut columns = keys(&solve_of);
    columns.push(("member", Column::Integer(members)));
    columns.extend(objectives(&costs));
    table_parquet("fronts", &columns)
}

/// `indicators.parquet`: a row for each solve, with `problem`, `optimizer`, `seed`, `dimensions`, `evaluations`,
/// `hypervolume`, the `reference_point` of it (the same value in every objective) and `igd_plus`.
pub fn indicators(plan: &Plan, solves: &[Solve]) -> Result<Vec<u8>, ParquetError> {
    let solves: Vec<&Solve> = solves.iter().collect();
    let dimensions = |solve: &&Solve| optimizer::Problem::bounds(&plan.problem(solve.problem)).len() as i64;
    let mut columns = keys(&solves);
    columns.extend([
        ("dimensions", Column::Integer(solves.iter().map(dimensions).collect())),
        ("evaluations", Column::Integer(vec![plan.evaluations() as i64; solves.len()])),
        ("hypervolume", doubles(&solves, |solve| Some(solve.hypervolume))),
        ("reference_point", doubles(&solves, |solve| plan.problem(solve.problem).reference_point().first().copied())),
        ("igd_plus", doubles(&solves, |solve| Some(solve.igd_plus))),
    ]);
    table_parquet("indicators", &columns)
}

/// `timings.parquet`: a row for each solve, with `problem`, `optimizer`, `seed` and `solve_us`, its wall time in
/// microseconds.
pub fn timings(solves: &[Solve]) -> Result<Vec<u8>, ParquetError> {
    let solves: Vec<&Solve> = solves.iter().collect();
    let mut columns = keys(&solves);
    columns.push(("solve_us", doubles(&solves, |solve| Some(solve.solve_us))));
    table_parquet("timings", &columns)
}

/// `reference-fronts.parquet`: the points of the true fronts that IGD+ was measured by, with `problem`, `point` (from
/// 1) and costs.
pub fn reference_fronts(plan: &Plan) -> Result<Vec<u8>, ParquetError> {
    let front_of = |&suite: &Suite| (suite.name(), plan.problem(suite).reference_front());
    let fronts: Vec<(&str, Vec<Vec<f64>>)> = plan.problems.iter().map(front_of).collect();
    let names = fronts.iter().flat_map(|(name, front)| front.iter().map(|_| (*name).to_owned())).collect();
    let points = fronts.iter().flat_map(|(_, front)| 1..=front.len() as i64).collect();
    let costs: Vec<&[f64]> = fronts.iter().flat_map(|(_, front)| front).map(Vec::as_slice).collect();
    let mut columns = vec![("problem", Column::Text(names)), ("point", Column::Integer(points))];
    columns.extend(objectives(&costs));
    table_parquet("reference_fronts", &columns)
}

fn keys(solves: &[&Solve]) -> Vec<(&'static str, Column)> {
    vec![
        ("problem", Column::Text(solves.iter().map(|solve| solve.problem.name().to_owned()).collect())),
        ("optimizer", Column::Text(solves.iter().map(|solve| solve.optimizer.key().to_owned()).collect())),
        // Of 64 bits, whatever their sign means to a reader.
        ("seed", Column::Integer(solves.iter().map(|solve| solve.seed as i64).collect())),
    ]
}

fn doubles(solves: &[&Solve], value: impl Fn(&Solve) -> Option<f64>) -> Column {
    Column::Double(solves.iter().map(|solve| value(solve)).collect())
}

fn objectives(costs: &[&[f64]]) -> impl Iterator<Item = (&'static str, Column)> {
    let column = |k: usize| Column::Double(costs.iter().map(|costs| costs.get(k).copied()).collect());
    OBJECTIVES.into_iter().enumerate().map(move |(k, name)| (name, column(k)))
}

/// `table.md`: of each indicator the medians over the seeds and their 95 % intervals, problems by optimisers.
pub fn markdown(plan: &Plan, solves: &[Solve]) -> String {
    let mut text = format!(
        "{} evaluations ({} x {}), {} {}: the median, and between brackets its distribution-free 95 % interval.\n",
        plan.evaluations(),
        plan.population,
        plan.generations,
        plan.seeds.len(),
        if plan.seeds.len() == 1 { "seed" } else { "seeds" }
    );
    text += &table(plan, solves, "Hypervolume (more is better)", |solve| solve.hypervolume);
    text += &table(plan, solves, "IGD+ (less is better)", |solve| solve.igd_plus);
    text
}

fn table(plan: &Plan, solves: &[Solve], title: &str, indicator: fn(&Solve) -> f64) -> String {
    let columns: Vec<&str> = plan.optimizers.iter().map(|optimizer| optimizer.key()).collect();
    let mut text =
        format!("\n{title}\n\n| problem | {} |\n|---|{}\n", columns.join(" | "), "---|".repeat(columns.len()));
    for &problem in &plan.problems {
        let cell = |&optimizer: &Algorithm| {
            let of = |solve: &&Solve| solve.problem == problem && solve.optimizer == optimizer;
            cell(&solves.iter().filter(of).map(indicator).collect::<Vec<f64>>())
        };
        let cells: Vec<String> = plan.optimizers.iter().map(cell).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {} | {} |", problem.name(), cells.join(" | "));
    }
    text
}

fn cell(values: &[f64]) -> String {
    let median = median(values).map_or_else(String::new, |median| format!("{median:.4}"));
    let interval = median_interval(values).map(|Interval { low, high }| format!(" [{low:.4}, {high:.4}]"));
    median + &interval.unwrap_or_default()
}
