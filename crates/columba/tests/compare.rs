//! `columba compare` from outside: what it writes, what it goes on with, what it refuses.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

mod common;

use common::{Room, SMALL};
use serde_json::Value;

/// Two contenders over a small scenario, as a user would write them.
const CONTENDERS: &str = "[[contender]]\nname = \"as it is\"\n\n[[contender]]\nname = \"short sighted\"\n\
                          look_ahead.horizon_s = 0.5\noptimizer.algorithm = \"nsga2\"\n";

fn room() -> Room {
    let room = Room::new();
    room.write("small.toml", SMALL);
    room.write("few.toml", CONTENDERS);
    room
}

fn table(room: &Room, folder: &str) -> Value {
    serde_json::from_slice(&room.read(&format!("{folder}/table.json"))).unwrap()
}

#[test]
fn a_comparison_is_a_folder_with_every_file_that_the_documentation_names() {
    let room = room();
    let said = room.columba(&["compare", "small.toml", "--contenders", "few.toml", "--seeds", "3"]).with(0);
    for word in
        ["2 contenders of 1 scenario with 3 seeds: 6 flights.", "| as it is ", "report: compare/small/report.html"]
    {
        assert!(said.out.contains(word), "{word}: {said:?}");
    }
    assert!(said.err.is_empty(), "{said:?}");
    let names = ["flights.parquet", "journal.jsonl", "report.html", "table.json", "table.md", "timings.parquet"];
    let mut files: Vec<String> = names.iter().map(|name| format!("compare/small/{name}")).collect();
    for contender in ["as-it-is", "short-sighted"] {
        for part in ["courses", "paths", "speeds"] {
            files.extend(["png", "svg"].map(|kind| format!("compare/small/figures/small-{contender}-{part}.{kind}")));
        }
    }
    for measure in [
        "speed-convergence",
        "course-convergence",
        "smallest-separation",
        "speed-variation",
        "course-variation",
        "flock-radius",
    ] {
        files.extend(["png", "svg"].map(|kind| format!("compare/small/figures/small-{measure}.{kind}")));
    }
    files.extend(["few.toml".to_owned(), "small.toml".to_owned()]);
    files.sort();
    assert_eq!(room.files(), files);

    let table = table(&room, "compare/small");
    let contenders = &table["scenarios"][0]["contenders"];
    assert_eq!(
        (&contenders[0]["algorithm"], &contenders[1]["algorithm"]),
        (&Value::from("mslpio"), &Value::from("nsga2"))
    );
    assert_eq!((&contenders[1]["flights"], &contenders[1]["success_rate"]), (&Value::from(3), &Value::from(1.0)));
    assert_eq!(table["reference"], Value::from("as it is"));
    assert_eq!(contenders[0]["paper"], Value::Null, "the paper flew another scenario");
}

#[test]
fn what_is_flown_is_not_flown_again_and_other_flights_stay() {
    let room = room();
    let compare = |options: &[&str]| {
        let all: Vec<&str> = ["compare", "small.toml", "--out", "out"].iter().chain(options).copied().collect();
        let said = room.columba(&all).with(0);
        (said.out, String::from_utf8(room.read("out/journal.jsonl")).unwrap())
    };
    let (said, first) = compare(&["--contenders", "few.toml", "--seeds", "2"]);
    assert!(!said.contains("already"), "{said}");
    assert_eq!(first.lines().count(), 4);
    let (said, again) = compare(&["--contenders", "few.toml", "--seeds", "2"]);
    assert!(said.contains("4 of 4 are in out/journal.jsonl already"), "{said}");
    assert_eq!(first, again);
    let figures = || room.files().into_iter().filter(|file| file.contains("figures/")).collect::<Vec<_>>();
    // Three of each contender, and one of each measure.
    assert_eq!(figures().len(), 2 * (3 * 2 + 6));
    room.write("out/figures/own.svg", "somebody's own");

    // The first contender under another name; of the second nothing is asked, of a new seed one flight is.
    let (said, more) = compare(&["--optimizers", "mslpio", "--seeds", "2,9"]);
    assert!(said.contains("1 of 2 are in") && said.contains("3 flights of other comparisons stay in"), "{said}");
    assert!(more.starts_with(&first) && more.lines().count() == 5);
    assert_eq!(table(&room, "out")["scenarios"][0]["contenders"][0]["flights"], Value::from(2));
    let figures = figures();
    assert_eq!(figures.iter().filter(|file| file.contains("small-mslpio-")).count(), 6, "{figures:?}");
    assert!(figures.len() == 2 * (3 + 6) + 1 && figures.contains(&"out/figures/own.svg".to_owned()), "{figures:?}");

    let (said, _) = compare(&["--optimizers", "mslpio", "--seeds", "2,9", "--set", "law.formation_gain=0.3"]);
    assert!(!said.contains("already"), "another setting is another flight: {said}");
}

#[test]
fn a_collision_is_a_result_and_no_failure() {
    let room = room();
    room.write(
        "wall.toml",
        SMALL.replace("x_m = 70.0\ny_m = 20.0", "x_m = 20.0\ny_m = 0.0") + "[dynamics]\nlateral_overload_max = 0.1\n",
    );
    room.columba(&["compare", "wall.toml", "--optimizers", "mpio", "--seeds", "2", "--quiet"]).with(0);
    let standing = &table(&room, "compare/small")["scenarios"][0]["contenders"][0];
    assert!(standing["contender"] == "MPIO", "{standing}");
    assert_eq!((&standing["success_rate"], &standing["obstacle_collisions"]), (&Value::from(0.0), &Value::from(2)));
    room.columba(&["run", "wall.toml", "--transport", "memory", "--quiet", "--no-report"]).with(1);
}

#[test]
fn several_scenarios_and_one_seed_to_draw() {
    let room = room();
    room.write("other.toml", SMALL.replace("\"small\"", "\"other\""));
    let drawn = ["--figure-seed", "77", "--seeds", "5..6", "--optimizers", "slpio"];
    let all: Vec<&str> = ["compare", "small.toml", "other.toml", "--quiet"].into_iter().chain(drawn).collect();
    let said = room.columba(&all).with(0);
    assert!(said.out.is_empty() && said.err.is_empty(), "{said:?}");
    let table = table(&room, "compare/small-other");
    let names: Vec<&Value> =
        table["scenarios"].as_array().unwrap().iter().map(|outcome| &outcome["scenario"]).collect();
    assert_eq!(names, ["small", "other"]);
    assert_eq!(table["seeds"], serde_json::json!([5, 6]));
    let page = String::from_utf8(room.read("compare/small-other/report.html")).unwrap();
    assert_eq!(page.matches("Seed 77.").count(), 2);
}

#[test]
fn what_is_wrong_is_refused_before_anything_is_written() {
    let room = room();
    room.write("near.toml", "[[contender]]\nname = \"near\"\nlook_ahead.horizon_s = 0\n");
    room.write("taken", "a file");
    let before = room.files();
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["--contenders", "near.toml"],
            &["columba: near.toml:3: contender \"near\": look_ahead.horizon_s = 0: must be"],
        ),
        (&["--contenders", "none.toml"], &["columba: none.toml: file not found: must be a file of [[contender]]"]),
        (&["--set", "law.gain=1"], &["columba: --set law.gain=1: unknown key", "formation_gain"]),
        (&["--set", "law"], &["--set", "must be KEY=VALUE"]),
        (&["--seeds", "5..1"], &["'5..1'", "--seeds", "a range with both ends"]),
        (&["--optimizers", "mslpio,best"], &["'best'", "--optimizers", "mslpio, mpio, nsga2, slpio"]),
        (&["--optimizers", "mpio,mpio"], &["two contenders are named \"MPIO\""]),
        (&["small.toml"], &["two scenarios are named \"small\""]),
        (&["none.toml"], &["columba: none.toml: file not found: must be a scenario file"]),
        (&["--out", "taken"], &["--out: cannot write into the run folder taken", "must be a folder"]),
    ];
    for (options, words) in cases {
        let all: Vec<&str> = ["compare", "small.toml"].iter().chain(*options).copied().collect();
        room.columba(&all).refused(words);
    }
    assert_eq!(room.files(), before);
}
