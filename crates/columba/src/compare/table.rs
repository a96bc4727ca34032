//! `table.md` and `table.json`: the tables of a comparison for people and for scripts, without its wall times.

use super::plan::Plan;
use super::results::{Duel, MEASURES, Outcome, Standing};
use super::statistics::Interval;
use super::words::{self, Table};
use serde_json::{Map, Value, json};

/// `table.md`.
pub fn markdown(plan: &Plan, outcomes: &[Outcome<'_>]) -> String {
    let mut text = format!("# Comparison\n\n{}\n", headline(plan));
    for outcome in outcomes {
        text += &format!("\n## Scenario {}\n", outcome.scenario);
        for table in words::tables(outcome) {
            text += &of_table(&table);
        }
    }
    text
}

/// What was compared.
pub fn headline(plan: &Plan) -> String {
    let count = |number: usize, one: &str| format!("{number} {one}{}", if number == 1 { "" } else { "s" });
    format!(
        "{} of {} with {}: {}.",
        count(plan.contenders.len(), "contender"),
        count(plan.scenarios.len(), "scenario"),
        count(plan.seeds.len(), "seed"),
        count(plan.flights().count(), "flight")
    )
}

/// A table, its columns under each other, so that it reads as well unrendered.
pub fn of_table(table: &Table) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let lines: Vec<Vec<String>> =
        [&table.head].into_iter().chain(&table.rows).map(|row| row.iter().map(|text| cell(text)).collect()).collect();
    let widths: Vec<usize> = (0..table.head.len())
        .map(|column| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or_default().max(3))
        .collect();
    let mut rows = lines.iter().map(|line| {
        let cells = line.iter().zip(&widths).enumerate().map(|(column, (text, &width))| {
            if column == 0 { format!(" {text:<width$} ") } else { format!(" {text:>width$} ") }
        });
        format!("|{}|\n", cells.collect::<Vec<_>>().join("|"))
    });
    let head = rows.next().unwrap_or_default();
    let rules = widths.iter().enumerate().map(|(column, width)| {
        if column == 0 { format!("{:-<1$}", ":", width + 2) } else { format!("{:->1$}", ":", width + 2) }
    });
    let rule = format!("|{}|\n", rules.collect::<Vec<_>>().join("|"));
    format!("\n### {}\n\n{head}{rule}{}\n{}\n", table.title, rows.collect::<String>(), table.note)
}

/// `table.json`. What never came is `"never"`, what does not exist `null`.
pub fn json(plan: &Plan, outcomes: &[Outcome<'_>]) -> Result<String, serde_json::Error> {
    let scenarios: Vec<Value> = outcomes
        .iter()
        .map(|outcome| {
            let standings: Vec<Value> = outcome.standings.iter().map(|standing| of_standing(outcome.scenario, standing)).collect();
            let tests: Vec<Value> = outcome.duels.iter().map(of_duel).collect();
            json!({ "scenario": outcome.scenario, "contenders": standings, "tests": tests })
        })
        .collect();
    let table = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "seeds": plan.seeds,
        "reference": plan.contenders.first(),
        "scenarios": scenarios,
    });
    serde_json::to_string_pretty(&table).map(|json| json + "\n")
}

fn of_standing(scenario: &str, standing: &Standing<'_>) -> Value {
    let share = |part: usize| part as f64 / standing.flights.max(1) as f64;
    let medians: Map<String, Value> = MEASURES
        .iter()
        .zip(&standing.estimates)
        .map(|(measure, estimate)| {
            let estimate = estimate.map(|estimate| {
                json!({ "median": number(estimate.median), "interval_95": estimate.interval.map(interval) })
            });
            (measure.key.to_owned(), estimate.unwrap_or_default())
        })
        .collect();
    let paper = words::in_the_paper(scenario, standing.algorithm).map(|(speed_s, course_s)| {
        json!({ "speed_convergence_s": number(speed_s), "course_convergence_s": number(course_s) })
    });
    json!({
        "contender": standing.contender,
        "algorithm": standing.algorithm,
        "flights": standing.flights,
        "t_max_s": standing.t_max_s,
        "successes": standing.successes,
        "success_rate": share(standing.successes),
        "success_rate_interval_95": standing.success_interval.map(interval),
        "obstacle_collisions": standing.obstacle_collisions,
        "vehicle_collisions": standing.vehicle_collisions,
        "separation_losses": standing.separation_losses,
        "speed_converged_rate": share(standing.speed_converged),
        "course_converged_rate": share(standing.course_converged),
        "least_separation_m": standing.least_separation_m,
        "least_clearance_m": standing.least_clearance_m,
        "evaluations_per_solve": standing.evaluations,
        "medians": medians,
        "paper": paper,
    })
}

fn of_duel(duel: &Duel<'_>) -> Value {
    json!({
        "measure": duel.measure.key,
        "contender": duel.contender,
        "against": duel.against,
        "u": duel.u,
        "p": duel.p,
        "p_holm": duel.p_holm,
        "a_better": duel.better,
    })
}

fn interval(interval: Interval) -> Value {
    json!([number(interval.low), number(interval.high)])
}

fn number(value: f64) -> Value {
    if value == f64::INFINITY { json!("never") } else { json!(value) }
}
