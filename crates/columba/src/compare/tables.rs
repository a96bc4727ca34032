//! The tables of a comparison in words: for `table.md`, the screen and the report.

use super::results::{ContenderSummary, Estimate, MEASURES, Outcome, RankComparison};
use super::statistics::Interval;

/// A table as people read it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// What to know when reading it.
    pub note: String,
    /// The heads of its columns.
    pub head: Vec<String>,
    /// Its rows, each as long as the head; the first cell names the row.
    pub rows: Vec<Vec<String>>,
}

/// What the paper's Table 1 says of its own flight, by algorithm: when speeds and yaw angles converged, s.
const PAPER: [(&str, f64, f64); 3] =
    [("mslpio", 37.0, 33.75), ("mpio", f64::INFINITY, 35.15), ("nsga2", f64::INFINITY, 36.22)];
/// The scenario that reconstructs it.
const PAPER_SCENARIO: &str = "paper";

const NONE: &str = "\u{2013}";
const NEVER: &str = "> T_max";
/// Below it, a difference is called one.
const SIGNIFICANT: f64 = 0.05;

/// When speed and course converged in the paper's own flight, s; none where it has none like this.
pub fn in_the_paper(scenario: &str, algorithm: &str) -> Option<(f64, f64)> {
    let row = PAPER.iter().find(|(name, ..)| scenario == PAPER_SCENARIO && *name == algorithm)?;
    Some((row.1, row.2))
}

/// Everything that another run repeats.
pub fn tables(outcome: &Outcome<'_>) -> Vec<Table> {
    let tables = [convergence(outcome), safety(outcome), smoothness(outcome)];
    tables.into_iter().chain(ranks(outcome)).collect()
}

/// What another run changes.
pub fn times(outcome: &Outcome<'_>) -> Table {
    let number = |value: Option<f64>, decimals| value.map_or_else(|| NONE.to_owned(), |value| fixed(value, decimals));
    Table {
        title: "Solve time".to_owned(),
        note: "Wall time on this machine, while other flights were flown beside: the only figures here that another \
               run changes. Medians over the flights."
            .to_owned(),
        head: words(&["contender", "solve, median (\u{b5}s)", "solve, 99th percentile (\u{b5}s)", "flight (s)"]),
        rows: each(outcome, |summary| {
            let times = summary.times;
            vec![number(times.solve_us_p50, 0), number(times.solve_us_p99, 0), number(times.wall_s, 3)]
        }),
    }
}

/// The paper's Table 1, with its own values beside ours.
fn convergence(outcome: &Outcome<'_>) -> Table {
    let t_max_s = outcome.summaries.first().map_or(0.0, |summary| summary.t_max_s);
    let with_paper =
        outcome.summaries.iter().any(|summary| in_the_paper(outcome.scenario, summary.algorithm).is_some());
    let mut head = words(&["contender", "velocities (s)", "yaw angles (s)"]);
    if with_paper {
        head = words(&["contender", "velocities (s)", "in the paper", "yaw angles (s)", "in the paper"]);
    }
    head.extend(words(&["velocities converged", "yaw angles converged"]));
    let rows = each(outcome, |summary| {
        let paper = in_the_paper(outcome.scenario, summary.algorithm);
        let paper = |of: fn((f64, f64)) -> f64| paper.map_or_else(|| NONE.to_owned(), |times| value(of(times), 2));
        let mut row = vec![estimated(summary, 0)];
        row.extend(with_paper.then(|| paper(|times| times.0)));
        row.push(estimated(summary, 1));
        row.extend(with_paper.then(|| paper(|times| times.1)));
        row.push(share(summary.speed_converged, summary.flights));
        row.push(share(summary.course_converged, summary.flights));
        row
    });
    Table {
        title: "Table 1: convergence times".to_owned(),
        note: format!(
            "T_max = {} s. Medians over the flights with their 95 % intervals; {NEVER} where a flight never converged.",
            short(t_max_s)
        ),
        head,
        rows,
    }
}

fn safety(outcome: &Outcome<'_>) -> Table {
    let metres = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| fixed(value, 2));
    Table {
        title: "Safety".to_owned(),
        note: "A success is a flight to its end without collision; the interval is Wilson's. Collisions and losses of \
               separation are sums over all flights."
            .to_owned(),
        head: words(&[
            "contender",
            "flights",
            "success (%)",
            "collisions with obstacles",
            "between UAVs",
            "separation losses",
            "smallest separation (m)",
            "median",
            "smallest clearance (m)",
        ]),
        rows: each(outcome, |summary| {
            vec![
                summary.flights.to_string(),
                success(summary),
                summary.obstacle_collisions.to_string(),
                summary.vehicle_collisions.to_string(),
                summary.separation_losses.to_string(),
                metres(summary.least_separation_m),
                estimated(summary, 2),
                metres(summary.least_clearance_m),
            ]
        }),
    }
}

fn smoothness(outcome: &Outcome<'_>) -> Table {
    Table {
        title: "Smoothness, tightness and cost".to_owned(),
        note:
            "How much a vehicle changed its speed and turned in all, and how far it was from the flock's centre, the \
               means over the flock: medians over the flights with their 95 % intervals."
                .to_owned(),
        head: words(&[
            "contender",
            "speed variation (m/s)",
            "course variation (rad)",
            "flock radius (m)",
            "evaluations per solve",
        ]),
        rows: each(outcome, |summary| {
            vec![estimated(summary, 3), estimated(summary, 4), estimated(summary, 5), summary.evaluations.to_string()]
        }),
    }
}

/// None where there is nobody to be compared with.
fn ranks(outcome: &Outcome<'_>) -> Option<Table> {
    let against = outcome.comparisons.first()?.against;
    let row = |comparison: &RankComparison<'_>| {
        let verdict = match comparison.better {
            _ if comparison.p_holm >= SIGNIFICANT => "no difference shown",
            better if better > 0.5 => "better",
            _ => "worse",
        };
        let (name, unit) = (comparison.measure.name, comparison.measure.unit);
        vec![
            format!("{name} ({unit})"),
            comparison.contender.to_owned(),
            fixed(comparison.u, 1),
            probability(comparison.p),
            probability(comparison.p_holm),
            fixed(comparison.better, 3),
            verdict.to_owned(),
        ]
    };
    Some(Table {
        title: format!("Rank tests against {against}"),
        note: format!(
            "Two-sided Mann-Whitney U tests with corrections for ties and continuity; what never came ties behind all. \
             p is corrected over the contenders by Holm's method. A is the share of pairs of flights in which the \
             contender's is better than {against}'s, ties counting one half (Vargha and Delaney): 0.5 is no \
             difference. A verdict needs a corrected p below {SIGNIFICANT}."
        ),
        head: words(&["measure", "contender", "U", "p", "p (Holm)", "A", "verdict"]),
        rows: outcome.comparisons.iter().map(row).collect(),
    })
}

fn each(outcome: &Outcome<'_>, cells: impl Fn(&ContenderSummary<'_>) -> Vec<String>) -> Vec<Vec<String>> {
    let row = |summary: &ContenderSummary<'_>| [vec![summary.contender.to_owned()], cells(summary)].concat();
    outcome.summaries.iter().map(row).collect()
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|&word| word.to_owned()).collect()
}

fn success(summary: &ContenderSummary<'_>) -> String {
    let percent = |share: f64| fixed(100.0 * share, 1);
    let rate = percent(summary.successes as f64 / summary.flights.max(1) as f64);
    match summary.success_interval {
        Some(Interval { low, high }) => format!("{rate} [{}, {}]", percent(low), percent(high)),
        None => rate,
    }
}

fn share(part: usize, whole: usize) -> String {
    format!("{part} of {whole}")
}

/// A measure's median with its interval.
fn estimated(summary: &ContenderSummary<'_>, measure: usize) -> String {
    let decimals = MEASURES[measure].decimals;
    match summary.estimates[measure] {
        None => NONE.to_owned(),
        Some(Estimate { median, interval: None }) => value(median, decimals),
        Some(Estimate { median, interval: Some(Interval { low, high }) }) => {
            format!("{} [{}, {}]", value(median, decimals), value(low, decimals), value(high, decimals))
        }
    }
}

fn value(value: f64, decimals: usize) -> String {
    if value.is_finite() { fixed(value, decimals) } else { NEVER.to_owned() }
}

fn fixed(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

fn short(value: f64) -> String {
    fixed(value, 3).trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn probability(p: f64) -> String {
    if p < 0.0001 { "< 0.0001".to_owned() } else { fixed(p, 4) }
}
