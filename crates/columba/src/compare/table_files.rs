//! `table.md` and `table.json`: the tables of a comparison for people and for scripts, without its wall times.

use super::plan::Plan;
use super::results::{ContenderSummary, MEASURES, Outcome, RankComparison};
use super::statistics::Interval;
use super::tables::{self, Table};
use serde_json::{Map, Value, json};

/// What a contender lays over a scenario that it flies as it is.
pub const NOTHING: &str = "# nothing: the scenario as it is";

/// `table.md`.
pub fn markdown(plan: &Plan, outcomes: &[Outcome<'_>]) -> String {
    let mut text = format!("# Comparison\n\n{}\n", headline(plan));
    for outcome in outcomes {
        text += &format!("\n## Scenario {}\n", outcome.scenario);
        for table in tables::tables(outcome) {
            text += &of_table(&table);
        }
    }
    text += "\n## Settings\n\nWhat was laid over the scenarios.\n";
    for (who, toml) in &plan.laid {
        let toml = if toml.is_empty() { NOTHING } else { toml };
        text += &format!("\n### {who}\n\n```toml\n{toml}\n```\n");
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
            let summaries: Vec<Value> =
                outcome.summaries.iter().map(|summary| of_summary(outcome.scenario, summary)).collect();
            let tests: Vec<Value> = outcome.comparisons.iter().map(of_comparison).collect();
            json!({ "scenario": outcome.scenario, "contenders": summaries, "tests": tests })
        })
        .collect();
    let laid: Vec<Value> = plan.laid.iter().map(|(who, toml)| json!({ "for": who, "toml": toml })).collect();
    let table = json!({
        "settings": laid,
        "version": env!("CARGO_PKG_VERSION"),
        "seeds": plan.seeds,
        "reference": plan.contenders.first(),
        "scenarios": scenarios,
    });
    serde_json::to_string_pretty(&table).map(|json| json + "\n")
}

fn of_summary(scenario: &str, summary: &ContenderSummary<'_>) -> Value {
    let share = |part: usize| part as f64 / summary.flights.max(1) as f64;
    let medians: Map<String, Value> = MEASURES
        .iter()
        .zip(&summary.estimates)
        .map(|(measure, estimate)| {
            let estimate = estimate.map(
                |estimate| json!({ "median": number(estimate.median), "interval_95": estimate.interval.map(interval) }),
            );
            (measure.key.to_owned(), estimate.unwrap_or_default())
        })
        .collect();
    let paper = tables::in_the_paper(scenario, summary.algorithm).map(|(speed_s, course_s)| {
        json!({ "speed_convergence_s": number(speed_s), "course_convergence_s": number(course_s) })
    });
    json!({
        "contender": summary.contender,
        "algorithm": summary.algorithm,
        "flights": summary.flights,
        "t_max_s": summary.t_max_s,
        "successes": summary.successes,
        "success_rate": share(summary.successes),
        "success_rate_interval_95": summary.success_interval.map(interval),
        "obstacle_collisions": summary.obstacle_collisions,
        "vehicle_collisions": summary.vehicle_collisions,
        "separation_losses": summary.separation_losses,
        "speed_converged_rate": share(summary.speed_converged),
        "course_converged_rate": share(summary.course_converged),
        "least_separation_m": summary.least_separation_m,
        "least_clearance_m": summary.least_clearance_m,
        "evaluations_per_solve": summary.evaluations,
        "medians": medians,
        "paper": paper,
    })
}

fn of_comparison(comparison: &RankComparison<'_>) -> Value {
    json!({
        "measure": comparison.measure.key,
        "contender": comparison.contender,
        "against": comparison.against,
        "u": comparison.u,
        "p": comparison.p,
        "p_holm": comparison.p_holm,
        "a_better": comparison.better,
    })
}

fn interval(interval: Interval) -> Value {
    json!([number(interval.low), number(interval.high)])
}

fn number(value: f64) -> Value {
    if value == f64::INFINITY { json!("never") } else { json!(value) }
}

#[cfg(test)]
mod tests {
    use super::super::plan::tests::plan;
    use super::super::results::{Row, outcomes, tests::flown};
    use super::*;
    use crate::flight::Summary;

    /// Of the first contender every flight converges at 20 s and more, of the second none.
    fn flights() -> (Plan, Vec<Summary>) {
        let plan = plan(&["one", "two | three"], &[], &[1, 2, 3, 4, 5, 6, 7]).unwrap();
        let summary = |planned: super::super::Planned| {
            let algorithm = if planned.contender == 0 { "mslpio" } else { "mpio" };
            let converged_s = (planned.contender == 0).then_some(20.0 + planned.seed as f64);
            Summary { algorithm: algorithm.to_owned(), ..flown(planned.seed, converged_s, 2.5) }
        };
        let flights = plan.flights().map(summary).collect();
        (plan, flights)
    }

    fn rows<'a>(plan: &'a Plan, flights: &'a [Summary]) -> Vec<Row<'a>> {
        let row = |(planned, summary): (super::super::Planned, &'a Summary)| Row {
            scenario: &plan.scenarios[planned.scenario],
            contender: &plan.contenders[planned.contender],
            seed: planned.seed,
            evaluations: 651,
            summary,
        };
        plan.flights().zip(flights).map(row).collect()
    }

    #[test]
    fn never_is_printed_as_the_paper_prints_it_and_its_values_stand_beside_ours() {
        let (plan, flights) = flights();
        let text = markdown(&plan, &outcomes(&plan, &rows(&plan, &flights)));
        let lines: Vec<Vec<&str>> =
            text.lines().map(|line| line.split(" | ").map(|cell| cell.trim_matches([' ', '|'])).collect()).collect();
        let line = |name: &str| lines.iter().find(|cells| cells[0] == name).unwrap_or_else(|| panic!("{text}"));
        assert_eq!(line("one")[1..5], ["24.00 [21.00, 27.00]", "37.00", "30.00 [30.00, 30.00]", "33.75"]);
        assert!(text.contains("| two \\| three | > T_max [> T_max, > T_max] |"), "{text}");
        assert!(text.contains("T_max = 42 s"), "{text}");
        assert!(text.ends_with("### two | three\n\n```toml\noptimizer.algorithm = \"mpio\"\n```\n"), "{text}");
        assert!(!text.contains("solve, median"), "wall times are not for this file");
        let widths: Vec<usize> =
            text.lines().filter(|line| line.starts_with("| ")).map(|line| line.chars().count()).collect();
        assert_eq!(widths[0], widths[1], "columns stand under each other");
    }

    #[test]
    fn scripts_find_the_same_by_name() {
        let (plan, flights) = flights();
        let json: Value =
            serde_json::from_str(&json(&plan, &outcomes(&plan, &rows(&plan, &flights))).unwrap()).unwrap();
        let scenario = &json["scenarios"][0];
        let (first, second) = (&scenario["contenders"][0], &scenario["contenders"][1]);
        assert_eq!(first["medians"]["speed_convergence_s"], json!({ "median": 24.0, "interval_95": [21.0, 27.0] }));
        assert_eq!(second["medians"]["speed_convergence_s"]["median"], json!("never"));
        assert_eq!(second["paper"], json!({ "speed_convergence_s": "never", "course_convergence_s": 35.15 }));
        assert_eq!((&first["speed_converged_rate"], &second["speed_converged_rate"]), (&json!(1.0), &json!(0.0)));
        assert_eq!(first["least_clearance_m"], Value::Null);
        let test = &scenario["tests"][0];
        assert_eq!((&test["measure"], &test["against"]), (&json!("speed_convergence_s"), &json!("one")));
        assert_eq!((&test["u"], &test["a_better"]), (&json!(49.0), &json!(0.0)));
    }
}
