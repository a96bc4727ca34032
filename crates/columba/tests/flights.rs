//! Flights of the built program: what they write, that their bytes repeat, and how they end.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

mod common;

use common::{Room, SMALL, free_ports};
use serde_json::Value;
use std::process::Stdio;

/// Two metres before a circle at 10 m/s there is no way round it.
const WALL: &str = r#"[scenario]
name = "wall"
duration_s = 2.0

[flock]
expected_speed_mps = 10.0
expected_altitude_m = 50.0

[[vehicle]]
x_m = 0.0
y_m = 0.0
altitude_m = 50.0
speed_mps = 10.0

[[obstacle]]
x_m = 102.0
y_m = 0.0
radius_m = 100.0
"#;

/// A file with a flock by pattern and one circle, flown for so long.
fn pattern(name: &str, count: usize, duration_s: f64) -> String {
    format!(
        "[scenario]\nname = \"{name}\"\nduration_s = {duration_s:?}\n\n[flock]\nexpected_speed_mps = 10.0\n\
         expected_altitude_m = 50.0\n\n[vehicles]\ncount = {count}\n\n[[obstacle]]\nx_m = 60.0\ny_m = 0.0\n\
         radius_m = 6.0\n"
    )
}

#[test]
fn a_run_writes_what_it_promises_and_nothing_else() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let said = room.columba(&["run", "small.toml"]).with(0);
    assert!(said.err.is_empty(), "{said:?}");
    assert!(
        said.out.contains("small: 1 UAV, 1 obstacle, 2.0 s flown") && said.out.contains("runs/small/report.html"),
        "{said:?}"
    );
    assert!(!said.out.contains('\u{1b}') && !said.out.contains('\r'), "no terminal, no escapes: {said:?}");
    let figures = ["alphas", "altitudes", "bank", "courses", "distances", "paths", "prediction", "speeds"];
    let mut files: Vec<String> = figures
        .iter()
        .flat_map(|name| ["png", "svg"].map(|kind| format!("runs/small/figures/{name}.{kind}")))
        .collect();
    files.extend(
        ["flight.tlog", "report.html", "summary.json", "trajectory.parquet"].map(|name| format!("runs/small/{name}")),
    );
    files.push("small.toml".to_owned());
    assert_eq!(room.files(), files);
    let summary = room.summary("runs/small");
    assert_eq!(
        (&summary["scenario"], &summary["success"], &summary["duration_s"]),
        (&"small".into(), &true.into(), &2.0.into())
    );
    assert_eq!(summary["min_separation_m"], Value::Null);
    // A run without a report or a log leaves none of an older flight's either.
    room.columba(&["run", "small.toml", "--transport", "memory", "--no-report", "--force"]).with(0);
    assert_eq!(room.files(), ["runs/small/summary.json", "runs/small/trajectory.parquet", "small.toml"]);
}

/// The bytes of every file below a folder, by name.
fn contents(room: &Room, folder: &str) -> Vec<(String, Vec<u8>)> {
    let files = room.files().into_iter().filter(|file| file.starts_with(&format!("{folder}/")));
    files.map(|file| (file.clone(), room.read(&file))).collect()
}

#[test]
fn an_earlier_run_is_kept_and_the_new_one_has_a_number() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let run = |options: &[&str]| room.columba(&[&["run", "small.toml", "--no-report"], options].concat());
    let said = run(&[]).with(0);
    assert!(said.out.contains("record: runs/small/summary.json") && !said.out.contains("--force"), "{said:?}");
    let first = contents(&room, "runs/small");
    let said = run(&["--seed", "2"]).with(0);
    assert!(said.out.contains("record: runs/small-2/summary.json"), "{said:?}");
    assert!(said.out.contains("runs/small is not empty and was kept: --force writes into it"), "{said:?}");
    run(&["--seed", "3", "--quiet", "--transport", "memory"]).with(0);
    assert_eq!([2, 3].map(|number| room.summary(&format!("runs/small-{number}"))["seed"].clone()), [2, 3]);
    assert!(contents(&room, "runs/small") == first, "the earlier run is as it was");
    // A folder that the file names is the folder of every run of the file.
    room.write("named.toml", format!("{SMALL}\n[output]\nfolder = \"runs/small\"\n"));
    room.columba(&["run", "named.toml", "--no-report", "-q"]).with(0);
    assert!(room.path("runs/small-4/summary.json").exists());
    assert!(contents(&room, "runs/small") == first);
    run(&["--seed", "4", "--force", "--quiet"]).with(0);
    assert_eq!(room.summary("runs/small")["seed"], 4);
}

#[test]
fn a_named_folder_that_is_not_empty_is_refused_unless_forced() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    std::fs::create_dir_all(room.path("mine/figures")).unwrap();
    for file in ["mine/report.html", "mine/figures/paths.svg", "mine/notes.txt"] {
        room.write(file, "somebody's own");
    }
    let before = contents(&room, "mine");
    for command in [&["run", "small.toml"][..], &["run", "small.toml", "--transport", "memory"], &["suites"]] {
        room.columba(&[command, &["--out", "mine"]].concat()).refused(&[
            "--out",
            "the folder mine is not empty",
            "must be a new or an empty folder",
            "--force",
        ]);
    }
    let fly = ["fly", "small.toml", "--out", "mine", "--ground-port", "0"];
    room.columba(&fly).refused(&["the folder mine is not empty", "--force"]);
    room.columba(&["compare", "small.toml", "--out", "mine"])
        .refused(&["the folder mine is not empty and holds no journal.jsonl", "--force"]);
    assert!(contents(&room, "mine") == before);
    // Forced, files of a run's names are replaced, and no other file is touched.
    room.columba(&["run", "small.toml", "--out", "mine", "--force", "-q"]).with(0);
    assert!(room.read("mine/report.html").len() > 1000 && room.read("mine/figures/paths.svg").len() > 1000);
    assert_eq!(room.read("mine/notes.txt"), b"somebody's own");
}

#[test]
fn runs_that_start_together_have_a_folder_each() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let start = |_| room.command(&["run", "small.toml", "-q", "--no-report"]).stderr(Stdio::piped()).spawn().unwrap();
    let runs: Vec<_> = (0..6).map(start).collect();
    for run in runs {
        let output = run.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let summaries = room.files().into_iter().filter(|file| file.ends_with("/summary.json")).count();
    assert_eq!(summaries, 6);
}

#[test]
fn quiet_says_nothing_of_a_good_flight() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    for transport in ["udp", "memory"] {
        let said = room.columba(&["run", "small.toml", "--quiet", "--no-report", "--transport", transport]).with(0);
        assert!(said.out.is_empty() && said.err.is_empty(), "{said:?}");
    }
}

#[test]
fn logs_are_without_colours_where_nobody_sees_them() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let output = room.command(&["run", "small.toml", "--no-report"]).env("RUST_LOG", "trace").output().unwrap();
    assert!(output.status.success() && !output.stderr.contains(&0x1b));
}

#[test]
fn the_same_seed_gives_the_same_bytes_by_every_way() {
    let room = Room::new();
    let ways: [&[&str]; 6] = [
        &["--transport", "memory"],
        &["--transport", "udp"],
        &["--transport", "udp", "--threads", "1"],
        &["--transport", "memory", "--threads", "2"],
        &["--loss", "0.2"],
        &["--loss", "0.5", "--threads", "1"],
    ];
    let flown: Vec<Vec<u8>> = ways
        .iter()
        .enumerate()
        .map(|(index, way)| {
            let folder = format!("run{index}");
            let arguments = [&["run", "--duration", "12", "--no-report", "-q", "-o", &folder], *way].concat();
            room.columba(&arguments).with(0);
            room.read(&format!("{folder}/trajectory.parquet"))
        })
        .collect();
    for (way, bytes) in ways.iter().zip(&flown).skip(1) {
        assert!(*bytes == flown[0], "{way:?} flew otherwise");
    }
    room.columba(&[
        "run",
        "--duration",
        "12",
        "--no-report",
        "-q",
        "-o",
        "other",
        "--seed",
        "2",
        "--transport",
        "memory",
    ])
    .with(0);
    assert!(room.read("other/trajectory.parquet") != flown[0], "another seed is another flight");
}

/// 0.1 s has no exact binary value: ticks times the period and the sum of the periods are different numbers.
#[test]
fn a_period_that_is_no_binary_fraction_gives_the_same_bytes_by_every_way() {
    let room = Room::new();
    room.write("tenth.toml", SMALL.replace("duration_s = 2.0", "duration_s = 2.0\ncontrol_period_s = 0.1"));
    let [memory, udp] = ["memory", "udp"].map(|transport| {
        room.columba(&["run", "tenth.toml", "--transport", transport, "--no-report", "-q", "-o", transport]).with(0);
        room.read(&format!("{transport}/trajectory.parquet"))
    });
    assert!(memory == udp, "the two transports flew differently");
}

#[test]
fn a_collision_is_exit_status_1_and_says_who_and_when() {
    let room = Room::new();
    room.write("wall.toml", WALL);
    for transport in ["udp", "memory"] {
        let said = room
            .columba(&["run", "wall.toml", "--transport", transport, "--no-report", "--quiet", "-o", transport])
            .with(1);
        assert!(said.out.is_empty(), "{said:?}");
        assert!(
            said.err.starts_with("columba: vehicle 1 entered obstacle 1 at ") && said.err.ends_with(" s\n"),
            "{said:?}"
        );
        let summary = room.summary(transport);
        assert_eq!((&summary["success"], &summary["completed"]), (&false.into(), &true.into()));
        assert!(said.err.contains(summary["failure"].as_str().unwrap()), "{said:?} {summary}");
        assert_eq!(summary["obstacle_collisions"], 1);
    }
}

#[test]
fn two_that_meet_are_told_by_number() {
    let room = Room::new();
    // Head on at 20 m/s with no time to turn.
    let head_on = SMALL.replace(
        "[[obstacle]]\nx_m = 70.0\ny_m = 20.0\nradius_m = 8.0",
        "[[vehicle]]\nx_m = 3.0\ny_m = 0.0\naltitude_m = 50.0\nspeed_mps = 10.0\ncourse_deg = 180.0",
    );
    room.write("head-on.toml", head_on);
    let said = room.columba(&["run", "head-on.toml", "--no-report", "--quiet"]).with(1);
    assert!(said.err.starts_with("columba: vehicles 1 and 2 collided at 0."), "{said:?}");
}

#[test]
fn the_literal_preset_flies() {
    let room = Room::new();
    let said = room.columba(&["run", "--preset", "literal", "--duration", "20", "--no-report", "-o", "out"]);
    // Both are results: the letter of the paper need not fly well.
    assert!(matches!(said.status, Some(0 | 1)), "{said:?}");
    let summary = room.summary("out");
    assert_eq!(
        (&summary["preset"], &summary["completed"], &summary["duration_s"]),
        (&"literal".into(), &true.into(), &20.0.into())
    );
}

#[test]
fn one_vehicle_flies_where_there_is_nothing() {
    let room = Room::new();
    let (alone, _) = SMALL.split_once("[[obstacle]]").unwrap();
    room.write("alone.toml", alone);
    for transport in ["udp", "memory"] {
        room.columba(&["run", "alone.toml", "--transport", transport, "-q", "-o", transport]).with(0);
        let summary = room.summary(transport);
        assert_eq!((&summary["min_separation_m"], &summary["min_clearance_m"]), (&Value::Null, &Value::Null));
    }
    assert!(room.read("udp/trajectory.parquet") == room.read("memory/trajectory.parquet"));
}

#[test]
fn sixty_fly_in_memory_and_over_udp() {
    let room = Room::new();
    room.write("sixty.toml", pattern("sixty", 60, 3.0));
    for transport in ["udp", "memory"] {
        room.columba(&["run", "sixty.toml", "--transport", transport, "-q", "--no-report", "-o", transport]).with(0);
        let summary = room.summary(transport);
        assert_eq!((&summary["vehicles"], &summary["duration_s"]), (&60.into(), &3.0.into()));
    }
    assert!(room.read("udp/trajectory.parquet") == room.read("memory/trajectory.parquet"));
}

#[test]
fn three_hundred_fly_in_lockstep_with_system_ids_used_twice() {
    let room = Room::new();
    room.write("crowd.toml", pattern("crowd", 300, 1.0));
    for transport in ["udp", "memory"] {
        room.columba(&["run", "crowd.toml", "--transport", transport, "-q", "--no-report", "-o", transport]).with(0);
    }
    assert_eq!(room.summary("udp")["vehicles"], 300);
    assert!(room.read("udp/trajectory.parquet") == room.read("memory/trajectory.parquet"));
}

#[test]
fn runs_beside_each_other_do_not_clash() {
    let room = Room::new();
    let runs: Vec<_> = (0..4)
        .map(|index| {
            let folder = format!("run{index}");
            let arguments = ["run", "--duration", "6", "--no-report", "-q", "-o", &folder];
            room.command(&arguments).stderr(Stdio::piped()).spawn().unwrap()
        })
        .collect();
    for run in runs {
        let output = run.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let first = room.read("run0/trajectory.parquet");
    assert!((1..4).all(|index| room.read(&format!("run{index}/trajectory.parquet")) == first));
}

#[test]
fn runs_into_one_folder_leave_one_whole_flight() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    for _ in 0..3 {
        let arguments = ["run", "small.toml", "-q", "--no-report", "--force"];
        let start = |_| room.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
        let runs: Vec<_> = (0..6).map(start).collect();
        for run in runs {
            let output = run.wait_with_output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
    let files = ["runs/small/flight.tlog", "runs/small/summary.json", "runs/small/trajectory.parquet", "small.toml"];
    assert_eq!(room.files(), files);
}

#[test]
fn vehicles_and_fly_are_a_run_in_two_programs() {
    let room = Room::new();
    let (vehicle_port, ground_port) = (free_ports(5).to_string(), free_ports(1).to_string());
    let ports = ["--vehicle-port", &vehicle_port, "--ground-port", &ground_port];
    let mut vehicles = room.command(&[&["vehicles", "--lockstep", "-q"][..], &ports].concat()).spawn().unwrap();
    let said = room
        .columba(&[&["fly", "--lockstep", "--duration", "8", "--no-report", "-q", "-o", "two"][..], &ports].concat());
    vehicles.kill().unwrap();
    vehicles.wait().unwrap();
    said.with(0);
    room.columba(&["run", "--duration", "8", "--no-report", "-q", "-o", "one"]).with(0);
    // Without the vehicles at hand their telemetry is all there is to judge by: what it says of the flight is the same.
    let [one, two] = ["one", "two"].map(|folder| room.summary(folder));
    for name in ["duration_s", "completed", "success", "speed_convergence_s"] {
        assert_eq!(one[name].is_null(), two[name].is_null(), "{name}");
    }
    assert_eq!((&two["duration_s"], &two["completed"]), (&8.0.into(), &true.into()));
}

#[test]
fn vehicles_that_know_no_ground_station_are_spoken_to_first() {
    let room = Room::new();
    for clock in [&["--lockstep"][..], &["--speed", "1"]] {
        let vehicle_port = free_ports(5).to_string();
        let silent = ["vehicles", "--ground-port", "0", "--vehicle-port", &vehicle_port, "-q"];
        let mut vehicles = room.command(&[&silent[..], clock].concat()).spawn().unwrap();
        let fly =
            ["fly", "--ground-port", "0", "--vehicle-port", &vehicle_port, "--duration", "2", "--no-report", "-q"];
        let said = room.columba(&[&fly[..], clock].concat());
        vehicles.kill().unwrap();
        vehicles.wait().unwrap();
        said.with(0);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_flight_is_written_as_far_as_it_flew() {
    let room = Room::new();
    let arguments = ["run", "--speed", "1", "--vehicle-port", "0", "-o", "out"];
    let flight = room.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Its folder is made once its ports are bound: by then it listens for the signal.
    while !room.path("out").exists() {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let signal = std::process::Command::new("kill").args(["-INT", &flight.id().to_string()]).status().unwrap();
    assert!(signal.success());
    let said: common::Said = flight.wait_with_output().unwrap().into();
    let said = said.with(1);
    assert!(said.err.contains("columba: interrupted at "), "{said:?}");
    let summary = room.summary("out");
    assert_eq!(
        (&summary["interrupted"], &summary["completed"], &summary["success"]),
        (&true.into(), &false.into(), &false.into())
    );
    assert!(room.path("out/flight.tlog").exists());
    for name in ["trajectory.parquet", "report.html"] {
        assert!(room.read(&format!("out/{name}")).len() > 500, "{name}");
    }
}
