//! What a comparison found: a row for each flight, a summary for each contender, and the tests between them.

use super::plan::Plan;
use super::statistics::{Interval, holm, mann_whitney, median, median_interval, wilson_interval};
use crate::flight::Summary;

/// A flight.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// Its scenario's name.
    pub scenario: &'a str,
    /// Who flew it.
    pub contender: &'a str,
    /// Its seed.
    pub seed: u64,
    /// Candidates that are evaluated for a vehicle at a tick.
    pub evaluations: usize,
    /// How it was.
    pub summary: &'a Summary,
}

/// A figure of a flight by which contenders are ranked.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Its name in `summary.json`.
    pub key: &'static str,
    /// Its name in words.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// With so many decimals it is printed.
    pub decimals: usize,
    /// Whether less of it is better.
    pub less_is_better: bool,
    /// Its value; none where the flight has none, infinite for what never came.
    pub value: fn(&Summary) -> Option<f64>,
}

/// The measures, in the order of every table.
pub const MEASURES: [Measure; 6] = [
    Measure {
        key: "speed_convergence_s",
        name: "speed convergence",
        unit: "s",
        decimals: 2,
        less_is_better: true,
        value: |summary| Some(summary.speed_convergence_s.unwrap_or(f64::INFINITY)),
    },
    Measure {
        key: "course_convergence_s",
        name: "course convergence",
        unit: "s",
        decimals: 2,
        less_is_better: true,
        value: |summary| Some(summary.course_convergence_s.unwrap_or(f64::INFINITY)),
    },
    Measure {
        key: "min_separation_m",
        name: "smallest separation",
        unit: "m",
        decimals: 2,
        less_is_better: false,
        value: |summary| summary.min_separation_m,
    },
    Measure {
        key: "speed_variation_mps",
        name: "speed variation",
        unit: "m/s",
        decimals: 2,
        less_is_better: true,
        value: |summary| Some(summary.speed_variation_mps),
    },
    Measure {
        key: "course_variation_rad",
        name: "course variation",
        unit: "rad",
        decimals: 3,
        less_is_better: true,
        value: |summary| Some(summary.course_variation_rad),
    },
    Measure {
        key: "flock_radius_m",
        name: "flock radius",
        unit: "m",
        decimals: 2,
        less_is_better: true,
        value: |summary| Some(summary.flock_radius_m),
    },
];

/// A median with its 95 % interval, which few flights do not have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The median over the flights; infinite where half of them never came there.
    pub median: f64,
    /// Its interval, whatever the distribution.
    pub interval: Option<Interval>,
}

/// How one contender flew one scenario.
#[derive(Clone, Debug)]
pub struct ContenderSummary<'a> {
    /// Who.
    pub contender: &'a str,
    /// With which optimiser.
    pub algorithm: &'a str,
    /// How many flights.
    pub flights: usize,
    /// T_max, s.
    pub t_max_s: f64,
    /// Flights that reached their end without a collision.
    pub successes: usize,
    /// The 95 % interval of their share.
    pub success_interval: Option<Interval>,
    /// Collisions with obstacles, in all flights.
    pub obstacle_collisions: u64,
    /// Collisions between vehicles.
    pub vehicle_collisions: u64,
    /// How often two vehicles came within D_s.
    pub separation_losses: u64,
    /// Flights in which every vehicle's speed converged.
    pub speed_converged: usize,
    /// Flights in which every vehicle's course did.
    pub course_converged: usize,
    /// The smallest separation of all flights, m.
    pub least_separation_m: Option<f64>,
    /// The smallest clearance of all flights, m.
    pub least_clearance_m: Option<f64>,
    /// Every flight's value of each of [`MEASURES`], in ascending order; infinite for what never came.
    pub samples: [Vec<f64>; MEASURES.len()],
    /// Of each of [`MEASURES`].
    pub estimates: [Option<Estimate>; MEASURES.len()],
    /// Candidates that are evaluated for a vehicle at a tick.
    pub evaluations: usize,
    /// What the machine took for it, which another run changes.
    pub times: Times,
}

/// Wall times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// The median over the flights of a flight's median solve, us.
    pub solve_us_p50: Option<f64>,
    /// The same of its 99th percentile.
    pub solve_us_p99: Option<f64>,
    /// The median flight, s.
    pub wall_s: Option<f64>,
}

/// A contender against the first, by one measure.
#[derive(Clone, Copy, Debug)]
pub struct RankComparison<'a> {
    /// By what.
    pub measure: &'static Measure,
    /// Who.
    pub contender: &'a str,
    /// Against whom.
    pub against: &'a str,
    /// Mann and Whitney's U of the contender.
    pub u: f64,
    /// Two-sided.
    pub p: f64,
    /// Corrected for the number of contenders by Holm's method.
    pub p_holm: f64,
    /// The share of pairs of flights in which the contender's is the better one, a tie counting one half: 0.5 is no
    /// difference.
    pub better: f64,
}

/// All of one scenario.
#[derive(Clone, Debug)]
pub struct Outcome<'a> {
    /// The scenario's name.
    pub scenario: &'a str,
    /// Every contender, in the order in which they were named.
    pub summaries: Vec<ContenderSummary<'a>>,
    /// By measure, then contender.
    pub comparisons: Vec<RankComparison<'a>>,
}

/// The outcome of every scenario of a plan. `rows` are all its flights, in its order.
pub fn outcomes<'a>(plan: &'a Plan, rows: &[Row<'a>]) -> Vec<Outcome<'a>> {
    let per_scenario = plan.contenders.len() * plan.seeds.len();
    plan.scenarios
        .iter()
        .zip(rows.chunks(per_scenario.max(1)))
        .map(|(scenario, rows)| {
            let flights: Vec<&[Row<'a>]> = rows.chunks(plan.seeds.len().max(1)).collect();
            let summaries = flights.iter().filter_map(|rows| summarise(rows)).collect();
            Outcome { scenario, summaries, comparisons: comparisons(&flights) }
        })
        .collect()
}

fn summarise<'a>(rows: &[Row<'a>]) -> Option<ContenderSummary<'a>> {
    let first = rows.first()?;
    let flights = || rows.iter().map(|row| row.summary);
    let count = |is: fn(&Summary) -> bool| flights().filter(|&summary| is(summary)).count();
    let sum = |of: fn(&Summary) -> u32| flights().map(|summary| u64::from(of(summary))).sum();
    let least = |of: fn(&Summary) -> Option<f64>| flights().filter_map(of).min_by(f64::total_cmp);
    let middle =
        |of: fn(&Summary) -> f64| median(&flights().map(of).filter(|value| value.is_finite()).collect::<Vec<_>>());
    let successes = count(|summary| summary.success);
    Some(ContenderSummary {
        contender: first.contender,
        algorithm: &first.summary.algorithm,
        flights: rows.len(),
        t_max_s: first.summary.duration_s,
        successes,
        success_interval: wilson_interval(successes, rows.len()),
        obstacle_collisions: sum(|summary| summary.obstacle_collisions),
        vehicle_collisions: sum(|summary| summary.vehicle_collisions),
        separation_losses: sum(|summary| summary.separation_losses),
        speed_converged: count(|summary| summary.speed_convergence_s.is_some()),
        course_converged: count(|summary| summary.course_convergence_s.is_some()),
        least_separation_m: least(|summary| summary.min_separation_m),
        least_clearance_m: least(|summary| summary.min_clearance_m),
        samples: MEASURES.map(|measure| {
            let mut values = values(&measure, rows);
            values.sort_by(f64::total_cmp);
            values
        }),
        estimates: MEASURES.map(|measure| estimate(&values(&measure, rows))),
        evaluations: first.evaluations,
        times: Times {
            solve_us_p50: middle(|summary| summary.solve_us_p50),
            solve_us_p99: middle(|summary| summary.solve_us_p99),
            wall_s: middle(|summary| summary.wall_s),
        },
    })
}

fn values(measure: &Measure, rows: &[Row<'_>]) -> Vec<f64> {
    rows.iter().filter_map(|row| (measure.value)(row.summary)).collect()
}

fn estimate(values: &[f64]) -> Option<Estimate> {
    Some(Estimate { median: median(values)?, interval: median_interval(values) })
}

/// Every contender's flights against the first's.
fn comparisons<'a>(flights: &[&[Row<'a>]]) -> Vec<RankComparison<'a>> {
    let Some((reference, others)) = flights.split_first() else { return Vec::new() };
    let mut comparisons = Vec::new();
    for measure in &MEASURES {
        let against = values(measure, reference);
        let of_measure: Vec<RankComparison<'a>> = others
            .iter()
            .filter_map(|rows| {
                let test = mann_whitney(&values(measure, rows), &against)?;
                let better = if measure.less_is_better { test.smaller } else { 1.0 - test.smaller };
                let (contender, against) = (rows.first()?.contender, reference.first()?.contender);
                Some(RankComparison { measure, contender, against, u: test.u, p: test.p, p_holm: test.p, better })
            })
            .collect();
        let corrected = holm(&of_measure.iter().map(|comparison| comparison.p).collect::<Vec<_>>());
        comparisons.extend(
            of_measure.into_iter().zip(corrected).map(|(comparison, p_holm)| RankComparison { p_holm, ..comparison }),
        );
    }
    comparisons
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A flight that converged then, or never.
    pub fn flown(seed: u64, speed_convergence_s: Option<f64>, min_separation_m: f64) -> Summary {
        Summary {
            algorithm: "mslpio".to_owned(),
            seed,
            duration_s: 42.0,
            completed: true,
            success: min_separation_m >= 1.0,
            vehicle_collisions: (min_separation_m < 1.0).into(),
            speed_convergence_s,
            course_convergence_s: Some(30.0),
            min_separation_m: Some(min_separation_m),
            solve_us_p50: f64::NAN,
            ..Summary::default()
        }
    }

    pub fn rows<'a>(contender: &'a str, flights: &'a [Summary]) -> Vec<Row<'a>> {
        let row =
            |summary: &'a Summary| Row { scenario: "paper", contender, seed: summary.seed, evaluations: 651, summary };
        flights.iter().map(row).collect()
    }

    fn flights(early_s: f64, never: usize, min_separation_m: f64) -> Vec<Summary> {
        let converged = |seed: u64| (seed as usize >= never).then_some(early_s + seed as f64);
        (0..10).map(|seed| flown(seed, converged(seed), min_separation_m)).collect()
    }

    #[test]
    fn a_standing_counts_and_what_never_came_is_later_than_all() {
        let flights = [flights(20.0, 0, 2.5), flights(20.0, 6, 0.5)];
        let summaries = flights.each_ref().map(|flights| summarise(&rows("one", flights)).unwrap());
        assert_eq!((summaries[0].flights, summaries[0].successes, summaries[0].vehicle_collisions), (10, 10, 0));
        assert_eq!((summaries[1].successes, summaries[1].vehicle_collisions), (0, 10));
        assert_eq!((summaries[0].speed_converged, summaries[1].speed_converged), (10, 4));
        assert_eq!(summaries[0].estimates[0].unwrap().median, 24.5);
        assert_eq!(summaries[1].estimates[0].unwrap().median, f64::INFINITY);
        let Interval { low, high } = summaries[0].estimates[0].unwrap().interval.unwrap();
        assert_eq!((low, high), (21.0, 28.0));
        assert_eq!(summaries[0].least_separation_m, Some(2.5));
        assert_eq!(summaries[0].least_clearance_m, None);
        assert_eq!(summaries[0].times.solve_us_p50, None, "no number is no time");
    }

    #[test]
    fn better_is_sooner_but_farther_apart() {
        let (reference, later, nearer) = (flights(20.0, 0, 2.5), flights(40.0, 0, 2.5), flights(20.0, 0, 1.5));
        let flights = [rows("reference", &reference), rows("later", &later), rows("nearer", &nearer)];
        let comparisons = comparisons(&flights.each_ref().map(Vec::as_slice));
        assert_eq!(comparisons.len(), 2 * MEASURES.len());
        let of = |key: &str, contender: &str| {
            *comparisons
                .iter()
                .find(|comparison| comparison.measure.key == key && comparison.contender == contender)
                .unwrap()
        };
        assert_eq!(of("speed_convergence_s", "later").better, 0.0);
        assert_eq!(of("speed_convergence_s", "nearer").better, 0.5);
        assert_eq!(of("min_separation_m", "nearer").better, 0.0);
        assert_eq!(of("min_separation_m", "later").better, 0.5);
        let late = of("speed_convergence_s", "later");
        assert!(late.p < 0.001 && late.p_holm == 2.0 * late.p && late.against == "reference");
    }
}
