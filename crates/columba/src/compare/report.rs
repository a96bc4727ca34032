//! `report.html` of a comparison: its tables, and for each contender the paper's Fig. 2 to 4.

use super::boxes;
use super::campaign::{Crew, fly_once};
use super::drawing::{Drawing, file_part};
use super::plan::Plan;
use super::results::{MEASURES, Outcome};
use super::table_files;
use super::tables::{self, Table};
use crate::flight::Flight;
use crate::record::RunFolder;
use crate::report::{CSS, PNG_SCALE, ReportError, escape, figures, fill, headline, to_png};
use anyhow::Context;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

const PAGE: &str = include_str!("../../assets/compare.html");
const COMPARE_CSS: &str = include_str!("../../assets/compare.css");

/// The figures of one contender's flight of one scenario.
pub struct Picture {
    scenario: usize,
    contender: usize,
    /// What it shows, and how the flight was.
    title: String,
    caption: String,
    /// By the names of their files.
    drawings: Vec<Drawing>,
}

/// The three parts of the paper's figures.
type Draw = fn(&Flight) -> String;
const PARTS: [(&str, &str, Draw); 3] = [
    ("paths", "(a) Paths among the obstacles", figures::paths),
    ("speeds", "(b) Speeds", figures::speeds),
    ("courses", "(c) Yaw angles", figures::courses),
];

/// Which of the paper's figures shows an algorithm.
const PAPER_FIGURES: [(&str, &str); 3] = [("mslpio", "Fig. 2"), ("mpio", "Fig. 3"), ("nsga2", "Fig. 4")];

/// Flies every scenario by every contender with one seed and draws it; none where someone asks to stop.
///
/// # Errors
/// A flight cannot be flown.
pub fn draw(plan: &Plan, seed: u64, crew: &Crew) -> anyhow::Result<Option<Vec<Picture>>> {
    let count = plan.scenarios.len() * plan.contenders.len();
    let files = file_names(plan);
    let drawn = Mutex::new(Vec::with_capacity(count));
    crew.work(count, |index| {
        let (scenario, contender) = (index / plan.contenders.len(), index % plan.contenders.len());
        let flown = plan.scenario(scenario, contender, seed)?;
        let flight =
            fly_once(&flown, &crew.stop).with_context(|| format!("{}, seed {seed}", plan.contenders[contender]))?;
        if let Some(flight) = flight {
            let picture = picture(plan, scenario, contender, &flight, &files[index]);
            drawn.lock().unwrap_or_else(PoisonError::into_inner).push(picture);
        }
        Ok(())
    })?;
    let mut drawn = drawn.into_inner().unwrap_or_else(PoisonError::into_inner);
    drawn.sort_by_key(|picture| (picture.scenario, picture.contender));
    Ok((drawn.len() == count).then_some(drawn))
}

fn picture(plan: &Plan, scenario: usize, contender: usize, flight: &Flight, file: &str) -> Picture {
    let summary = &flight.summary;
    let is_paper = tables::in_the_paper(&plan.scenarios[scenario], &summary.algorithm).is_some();
    let in_paper = PAPER_FIGURES.iter().find(|(algorithm, _)| is_paper && *algorithm == summary.algorithm);
    let in_paper = in_paper.map(|(_, figure)| format!(", as in the paper's {figure}")).unwrap_or_default();
    let drawing = |(part, title, draw): (&str, &'static str, Draw)| {
        let file = format!("{file}-{part}");
        // All figures are of one page, and an identifier in it must be of one.
        let own = |svg: String, before: &str| svg.replace(&format!("{before}clip-"), &format!("{before}clip-{file}-"));
        let svg = own(own(draw(flight), "id=\""), "url(#");
        Drawing { svg, file, title: title.to_owned() }
    };
    Picture {
        scenario,
        contender,
        title: format!("{}{in_paper}", plan.contenders[contender]),
        caption: format!("Seed {}. {}.", summary.seed, headline(summary)),
        drawings: PARTS.into_iter().map(drawing).collect(),
    }
}

/// Of each scenario and contender a name that a file can have, each another one.
fn file_names(plan: &Plan) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for scenario in &plan.scenarios {
        for contender in &plan.contenders {
            let name = file_part(&format!("{scenario}-{contender}"));
            let again = (2..).map(|count| format!("{name}-{count}"));
            let free = [name.clone()].into_iter().chain(again).find(|name| !names.contains(name));
            names.push(free.unwrap_or(name));
        }
    }
    names
}

/// Writes `figures/*.svg` and `*.png`, in place of those of an older comparison, and then `report.html`.
pub fn write(
    folder: &RunFolder,
    plan: &Plan,
    outcomes: &[Outcome<'_>],
    pictures: &[Picture],
) -> Result<(), ReportError> {
    remove_older(folder);
    let boxes: Vec<Vec<Drawing>> = outcomes.iter().map(boxes::all).collect();
    let drawings = pictures.iter().flat_map(|picture| &picture.drawings).chain(boxes.iter().flatten());
    let drawings: Vec<&Drawing> = drawings.collect();
    drawings.par_iter().try_for_each(|Drawing { file, svg, .. }| {
        let png = to_png(svg, PNG_SCALE).map_err(|source| ReportError::Png { name: file.clone(), source })?;
        folder.write(&format!("figures/{file}.svg"), svg.as_bytes())?;
        Ok::<(), ReportError>(folder.write(&format!("figures/{file}.png"), &png)?)
    })?;
    Ok(folder.write("report.html", page(plan, outcomes, pictures, &boxes).as_bytes())?)
}

/// Removes what has the name of a figure: it would tell of other contenders. Best effort, for nothing depends on it.
fn remove_older(folder: &RunFolder) {
    let is_ours = |name: &str| {
        let stem = name.strip_suffix(".svg").or(name.strip_suffix(".png"));
        let parts = PARTS.iter().map(|(part, ..)| (*part).to_owned());
        let mut parts = parts.chain(MEASURES.iter().map(|measure| file_part(measure.name)));
        stem.is_some_and(|stem| parts.any(|part| stem.ends_with(&format!("-{part}"))))
    };
    let entries = std::fs::read_dir(folder.path().join("figures")).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_str().is_some_and(is_ours)) {
        let _ = std::fs::remove_file(entry.path());
    }
}

fn page(plan: &Plan, outcomes: &[Outcome<'_>], pictures: &[Picture], boxes: &[Vec<Drawing>]) -> String {
    let title = format!("Comparison on {}", plan.scenarios.join(", "));
    let sections = outcomes.iter().zip(boxes).enumerate().map(|(scenario, (outcome, boxes))| {
        let of_scenario = pictures.iter().filter(|picture| picture.scenario == scenario);
        section(outcome, boxes, of_scenario)
    });
    fill(
        PAGE,
        &[
            ("title", &escape(&title)),
            ("css", CSS),
            ("compare-css", COMPARE_CSS),
            ("subtitle", &escape(&format!("{} {}.", table_files::headline(plan), plan.contenders.join(", ")))),
            ("sections", &sections.collect::<String>()),
            ("laid", &plan.laid.iter().map(laid).collect::<String>()),
            ("version", env!("CARGO_PKG_VERSION")),
        ],
    )
}

/// After which of [`tables::tables`] the measures' figures stand.
const AFTER_TABLE: [usize; MEASURES.len()] = [0, 0, 1, 2, 2, 2];

fn section<'a>(outcome: &Outcome<'_>, boxes: &[Drawing], pictures: impl Iterator<Item = &'a Picture>) -> String {
    let name = escape(outcome.scenario);
    let tables: String = tables::tables(outcome)
        .iter()
        .enumerate()
        .map(|(index, table)| {
            let figures = boxes.iter().zip(AFTER_TABLE).filter(|(_, after)| *after == index);
            let figures: String = figures.map(|(drawing, _)| of_drawing(drawing)).collect();
            let figures = if figures.is_empty() {
                figures
            } else {
                format!("  <div class=\"figures boxes\">\n{figures}  </div>\n")
            };
            of_table(table, "") + &figures
        })
        .collect();
    let times = of_table(&tables::times(outcome), " class=\"times\"");
    let pictures: String = pictures.map(of_picture).collect();
    format!("<section>\n  <h2>Scenario {name}</h2>\n{tables}{times}{pictures}</section>\n")
}

/// What was laid over the scenarios, and by whom.
fn laid((who, toml): &(String, String)) -> String {
    let toml = if toml.is_empty() { table_files::NOTHING } else { toml };
    format!("  <h3>{}</h3>\n  <pre>{}</pre>\n", escape(who), escape(toml))
}

fn of_table(table: &Table, class: &str) -> String {
    let cells = |row: &[String], tag: &str| -> String {
        let cell = |(column, text): (usize, &String)| match (tag, column) {
            ("td", 0) => format!("<th scope=\"row\">{}</th>", escape(text)),
            ("th", _) => format!("<th scope=\"col\">{}</th>", escape(text)),
            _ => format!("<td>{}</td>", escape(text)),
        };
        row.iter().enumerate().map(cell).collect()
    };
    let rows: String = table.rows.iter().map(|row| format!("      <tr>{}</tr>\n", cells(row, "td"))).collect();
    format!(
        "  <h3>{}</h3>\n  <div class=\"scroll\"><table{class}>\n    <thead><tr>{}</tr></thead>\n    <tbody>\n{rows}    \
         </tbody>\n  </table></div>\n  <p class=\"hint\">{}</p>\n",
        escape(&table.title),
        cells(&table.head, "th"),
        escape(&table.note)
    )
}

fn of_drawing(Drawing { file, title, svg }: &Drawing) -> String {
    format!(
        "    <figure id=\"{file}\">\n      <h4>{}</h4>\n{svg}      <figcaption>\
         <a href=\"figures/{file}.svg\" download>SVG</a> <a href=\"figures/{file}.png\" \
         download>PNG</a></figcaption>\n    </figure>\n",
        escape(title)
    )
}

fn of_picture(picture: &Picture) -> String {
    let drawings: String = picture.drawings.iter().map(of_drawing).collect();
    format!(
        "  <h3>{}</h3>\n  <p class=\"hint\">{}</p>\n  <div class=\"figures\">\n{drawings}  </div>\n",
        escape(&picture.title),
        escape(&picture.caption)
    )
}

#[cfg(test)]
mod tests {
    use super::super::plan::tests::plan;
    use super::super::results::{outcomes, tests::flown};
    use super::*;
    use crate::report::sample;

    fn page_of(names: &[&str]) -> String {
        let plan = plan(names, &[], &[1]).unwrap();
        let files = file_names(&plan);
        let flight = sample::flight(2, 3, 9);
        let pictures: Vec<Picture> =
            (0..names.len()).map(|contender| picture(&plan, 0, contender, &flight, &files[contender])).collect();
        let summaries: Vec<_> = plan.flights().map(|planned| flown(planned.seed, None, 2.0)).collect();
        let rows: Vec<_> = plan
            .flights()
            .zip(&summaries)
            .map(|(planned, summary)| super::super::results::Row {
                scenario: &plan.scenarios[0],
                contender: &plan.contenders[planned.contender],
                seed: planned.seed,
                evaluations: 651,
                summary,
            })
            .collect();
        let outcomes = outcomes(&plan, &rows);
        let boxes: Vec<Vec<Drawing>> = outcomes.iter().map(boxes::all).collect();
        page(&plan, &outcomes, &pictures, &boxes)
    }

    #[test]
    fn every_identifier_is_of_one_thing_and_every_reference_leads_to_one() {
        let page = page_of(&["a b", "a-b", "a_b"]);
        let after = |mark: &str, end: char| -> Vec<String> {
            page.split(mark).skip(1).filter_map(|rest| rest.split(end).next().map(str::to_owned)).collect()
        };
        let mut ids = after(" id=\"", '"');
        let count = ids.len();
        let references = after("url(#", ')');
        assert!(references.len() == 9 && references.iter().all(|reference| ids.contains(reference)), "{references:?}");
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), count, "{ids:?}");
        let files = ["paper-a-b-paths", "paper-a-b-2-speeds", "paper-a-b-3-courses", "paper-speed-convergence"];
        for file in files {
            assert!(page.contains(&format!("href=\"figures/{file}.png\"")), "{file}");
        }
    }

    #[test]
    fn the_page_stands_alone_and_names_are_no_markup() {
        let page = page_of(&["<script>alert(1)</script>{{sections}}", "other"]);
        assert!(!page.contains("<script") && page.contains("&lt;script&gt;alert(1)"));
        assert!(page.ends_with("</html>\n") && page.matches("<h2>Scenario").count() == 1);
        let without_namespace = page.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http:", "https:", "src=", "@import"] {
            assert!(!without_namespace.contains(outside), "{outside}");
        }
    }
}
