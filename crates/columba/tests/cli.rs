//! The command line: help, exit statuses and refusals, none of which leaves anything behind.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

mod common;

use common::{Room, SMALL, busy_port};

#[test]
fn help_names_every_command_and_every_flag() {
    let room = Room::new();
    let help = room.columba(&["--help"]).with(0).out;
    for word in [
        "run",
        "vehicles",
        "fly",
        "compare",
        "check",
        "completions",
        "man",
        "Exit status: 0 flown",
        "--quiet",
        "--threads",
    ] {
        assert!(help.contains(word), "{word}: {help}");
    }
    let flight = ["--seed", "--preset", "--duration", "--out", "--ground-port", "--loss", "--no-report"];
    let of = |command: &str, flags: &[&str]| {
        let help = room.columba(&[command, "--help"]).with(0).out;
        for flag in flags {
            assert!(help.contains(flag), "{command} {flag}: {help}");
        }
        assert!(!help.contains('\u{1b}'), "no colours where nobody sees them");
        help
    };
    let run = of("run", &flight);
    assert!(run.contains("--transport") && run.contains("columba run --speed 1") && run.contains("Exit status"));
    of("fly", &flight);
    of("fly", &["--lockstep", "--speed", "--vehicle-port"]);
    of(
        "vehicles",
        &["--count", "--vehicle-port", "--ground-port", "--speed", "--lockstep", "--loss", "--seed", "--json"],
    );
    of(
        "compare",
        &[
            "[CONFIG]...",
            "--optimizers",
            "--contenders",
            "--set",
            "--preset",
            "--seeds",
            "--figure-seed",
            "--out",
            "no failure",
        ],
    );
    of("check", &["<CONFIG>...", "docs/scenario.md"]);
}

/// Lines that are not broken are words that cannot be: flags, paths, command lines.
#[test]
fn help_is_readable_in_a_narrow_terminal() {
    let room = Room::new();
    for command in [&["--help"][..], &["run", "--help"], &["vehicles", "--help"], &["compare", "--help"]] {
        let output = room.command(command).env("COLUMNS", "40").output().unwrap();
        let help = String::from_utf8(output.stdout).unwrap();
        let long: Vec<&str> = help.lines().filter(|line| line.chars().count() > 40).collect();
        let breakable = |line: &&&str| line.split_whitespace().count() > 2 && !line.contains("columba ");
        let broken: Vec<&&str> = long.iter().filter(breakable).collect();
        assert!(broken.is_empty(), "{command:?}: {broken:#?}");
    }
}

#[test]
fn completions_and_manual_pages_are_of_this_command_line() {
    let room = Room::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = room.columba(&["completions", shell]).with(0).out;
        for word in ["vehicles", "personality", "set"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let page = room.columba(&["man"]).with(0).out;
    assert!(page.contains(".TH columba 1") && page.contains("columba\\-vehicles(1)"), "{page}");
    let page = room.columba(&["man", "vehicles"]).with(0).out;
    assert!(page.contains(".TH columba-vehicles 1") && page.contains("\\-\\-personality"), "{page}");
    room.columba(&["man", "vehicels"])
        .refused(&["columba: vehicels: must be a subcommand: run, ", "did you mean vehicles?"]);
}

#[test]
fn a_misspelt_subcommand_is_answered_with_the_one_that_was_meant() {
    let room = Room::new();
    for (typed, meant) in [
        ("vehicels", "vehicles"),
        ("vehicle", "vehicles"),
        ("compair", "compare"),
        ("rum", "run"),
        ("chek", "check"),
        ("suite", "suites"),
    ] {
        room.columba(&[typed]).refused(&[&format!("'{typed}'"), &format!("'{meant}'")]);
    }
}

/// Addresses that a client can send to, and a fleet that answers there.
#[test]
fn vehicles_on_all_interfaces_are_printed_with_addresses_of_use() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let arguments =
        ["vehicles", "small.toml", "--host", "0.0.0.0", "--vehicle-port", "0", "--ground-port", "0", "--json"];
    let mut vehicles = room.command(&arguments).stdout(std::process::Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    let mut out = std::io::BufReader::new(vehicles.stdout.take().unwrap());
    std::io::BufRead::read_line(&mut out, &mut line).unwrap();
    vehicles.kill().unwrap();
    vehicles.wait().unwrap();
    let table: serde_json::Value = serde_json::from_str(&line).unwrap();
    let vehicle = &table["vehicles"][0];
    assert_eq!(vehicle["host"], "127.0.0.1", "{table}");
    assert_eq!(vehicle["address"], format!("127.0.0.1:{}", vehicle["port"]), "{table}");
}

#[test]
fn a_run_on_all_interfaces_flies() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    room.columba(&["run", "small.toml", "--host", "0.0.0.0", "--no-report", "-q", "-o", "all"]).with(0);
    room.columba(&["run", "small.toml", "--no-report", "-q", "-o", "one"]).with(0);
    assert!(room.read("all/trajectory.parquet") == room.read("one/trajectory.parquet"));
}

#[test]
fn debug_tells_the_pre_flight_each_tick_and_the_link() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let debug = |arguments: &[&str]| {
        let output = room.command(arguments).env("RUST_LOG", "debug").output().unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    let run = debug(&["run", "small.toml", "--no-report", "-o", "out"]);
    for word in ["ground station bound", "waiting for every vehicle's position", "prepared", "tick=3", "closed"] {
        assert!(run.contains(word), "{word}: {run}");
    }
    for clock in [&[][..], &["--lockstep"]] {
        let port = common::free_ports(1).to_string();
        let fly = ["fly", "small.toml", "--ground-port", &port, "--no-report", "-q", "-o", "none"];
        let mut waiting = room
            .command(&[&fly[..], clock].concat())
            .env("RUST_LOG", "debug")
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let mut told = String::new();
        let mut err = std::io::BufReader::new(waiting.stderr.take().unwrap());
        while !(told.contains("DEBUG") && told.contains(&format!("127.0.0.1:{port}"))) {
            assert!(std::io::BufRead::read_line(&mut err, &mut told).unwrap() > 0, "{told}");
        }
        waiting.kill().unwrap();
        waiting.wait().unwrap();
    }
}

#[test]
fn fly_waits_no_longer_than_it_is_told_and_names_the_address() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let port = common::free_ports(1).to_string();
    let fly = ["fly", "small.toml", "--lockstep", "--ground-port", &port, "--no-report", "-q", "-o", "out"];
    let said = room.columba(&[&fly[..], &["--set", "ground.patience_s=0.3"]].concat()).with(1);
    assert_eq!(said.err, format!("columba: no telemetry on 127.0.0.1:{port} for 0.3 s from vehicle 1\n"));
    room.columba(&["run", "--patience", "0"]).refused(&["columba: --patience 0: must be a number from 0.1 to 86400"]);
}

#[test]
fn check_takes_files_of_contenders_and_tells_every_fault() {
    let room = Room::new();
    room.write("good.toml", "[[contender]]\nname = \"near\"\nlook_ahead.horizon_s = 1.5\n");
    room.write(
        "bad.toml",
        "[[contender]]\nname = \"near\"\nlook_ahead.horizon_s = -1\nlaw.gain = 3\n[[contender]]\nname = \"far\"\n\
         look_ahead.separation_m = \"x\"\n",
    );
    assert_eq!(room.columba(&["check", "good.toml"]).with(0).out, "good.toml: good: 1 contender: near\n");
    let said = room.columba(&["check", "bad.toml"]).with(2);
    let lines: Vec<&str> = said.err.lines().collect();
    assert_eq!(lines.len(), 3, "{said:?}");
    for (line, told) in lines.iter().zip([
        "columba: bad.toml:3: contender \"near\": look_ahead.horizon_s = -1: must be a number greater than 0",
        "columba: bad.toml:4: contender \"near\": law.gain: unknown key",
        "columba: bad.toml:7: contender \"far\": look_ahead.separation_m = \"x\": must be a number",
    ]) {
        assert!(line.starts_with(told), "{said:?}");
    }
}

#[test]
fn any_key_is_set_from_the_command_line() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    room.columba(&[
        "run",
        "small.toml",
        "--set",
        "scenario.duration_s=3",
        "--set",
        "scenario.name=long",
        "--no-report",
        "-q",
    ])
    .with(0);
    assert_eq!(room.summary("runs/long")["duration_s"], 3.0);
    room.columba(&["fly", "--set", "law.gain=1"]).refused(&["columba: --set law.gain=1: unknown key"]);
    room.columba(&["vehicles", "--set", "link.loss=7"])
        .refused(&["columba: --set link.loss=7: must be a number from 0 to"]);
}

#[test]
fn a_flight_without_obstacles_tells_of_none() {
    let room = Room::new();
    let (alone, _) = SMALL.split_once("[[obstacle]]").unwrap();
    room.write("alone.toml", alone);
    let said = room.columba(&["run", "alone.toml", "--no-report"]).with(0);
    assert!(said.out.contains("small: 1 UAV, 0 obstacles, 2.0 s flown"), "{said:?}");
    assert!(!said.out.contains("past the last obstacle"), "{said:?}");
}

#[test]
fn bad_arguments_are_refused_by_name_value_and_range() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    let cases: &[(&[&str], &[&str])] = &[
        (&["run", "--speed", "0"], &["'0'", "--speed", "from 0.01 to 100"]),
        (&["run", "--speed", "nan"], &["'nan'", "--speed"]),
        (&["run", "--threads", "0"], &["'0'", "--threads", "from 1 to 1024"]),
        (&["run", "--loss", "2"], &["columba: --loss 2: must be", "from 0 to 0.95"]),
        (&["run", "--loss", "-0.1"], &["columba: --loss -0.1: must be", "from 0 to 0.95"]),
        (&["run", "--seed", "-1"], &["columba: --seed -1: must be a whole number, 0 or greater"]),
        (&["run", "--duration", "inf"], &["columba: --duration inf: must be", "to 86400"]),
        (&["run", "--vehicle-port", "70000"], &["columba: --vehicle-port 70000: must be", "from 0 to 65535"]),
        (&["run", "--preset", "best"], &["'best'", "default, paper, literal"]),
        (&["run", "--speed", "1", "--transport", "memory"], &["--speed needs --transport udp"]),
        (&["run", "one", "two"], &["'two'"]),
        (&["vehicles", "--count", "0"], &["columba: --count 0: must be", "from 1 to 10000"]),
        (&["vehicles", "--speed", "2", "--lockstep"], &["--speed", "--lockstep"]),
        (&["vehicles", "--vehicle-port", "65535"], &["--vehicle-port 65535: must be at most 65531 for 5 vehicles"]),
        (&["fly", "--lockstep", "--speed", "3"], &["--lockstep", "--speed"]),
        (&["check"], &["<CONFIG>..."]),
        (&["soar"], &["'soar'"]),
        (&["run", "small.toml", "--duration", "0.1"], &["columba: --duration 0.1: must be a number from 0.5"]),
    ];
    for (arguments, words) in cases {
        room.columba(arguments).refused(words);
    }
    assert_eq!(room.files(), ["small.toml"]);
}

#[test]
fn a_bad_file_is_refused_by_every_command_and_leaves_nothing() {
    let room = Room::new();
    room.write("bad.toml", SMALL.replace("radius_m = 8.0", "radius_m = -8.0"));
    for arguments in [
        &["run", "bad.toml"][..],
        &["run", "bad.toml", "--transport", "memory", "-o", "out"],
        &["fly", "bad.toml"],
        &["vehicles", "bad.toml"],
        &["check", "bad.toml"],
    ] {
        room.columba(arguments)
            .refused(&["columba: bad.toml:18: obstacle[1].radius_m = -8.0: must be a number greater than 0"]);
    }
    assert_eq!(room.files(), ["bad.toml"]);
}

#[test]
fn what_is_no_file_is_refused() {
    let room = Room::new();
    room.write("binary.toml", b"[scenario]\nname = \"\xff\"\n");
    room.columba(&["run", "absent.toml"]).refused(&["absent.toml: file not found: must be a scenario file"]);
    room.columba(&["run", "."]).refused(&[".: is a folder: must be a scenario file"]);
    room.columba(&["run", "binary.toml"]).refused(&["binary.toml:2: byte 0xff is not UTF-8"]);
    room.columba(&["run", ""]).refused(&["CONFIG"]);
    assert_eq!(room.files(), ["binary.toml"]);
}

#[test]
fn check_reports_every_file() {
    let room = Room::new();
    room.write("good.toml", SMALL);
    room.write("also-good.toml", SMALL);
    room.write("bad.toml", SMALL.replace("radius_m", "radus_m"));
    room.write("worse.toml", SMALL.replace("[flock]", "[flock"));
    let said = room.columba(&["check", "good.toml", "bad.toml", "worse.toml", "also-good.toml"]).with(2);
    assert_eq!(said.out, "good.toml: good: 1 UAV, 1 obstacle, 2.0 s\nalso-good.toml: good: 1 UAV, 1 obstacle, 2.0 s\n");
    let lines: Vec<&str> = said.err.lines().collect();
    assert_eq!(lines.len(), 2, "{said:?}");
    assert!(lines[0].starts_with("columba: bad.toml:18: obstacle[1].radus_m: unknown key: did you mean radius_m?"));
    assert!(lines[1].starts_with("columba: worse.toml:5: "));
    let said = room.columba(&["check", "good.toml", "also-good.toml", "--quiet"]).with(0);
    assert!(said.out.is_empty() && said.err.is_empty(), "{said:?}");
}

#[test]
fn a_busy_port_is_refused_by_flag_or_line_and_leaves_nothing() {
    let room = Room::new();
    let (_held, port) = busy_port();
    let flag = port.to_string();
    room.write("small.toml", SMALL);
    room.write("vehicle.toml", format!("{SMALL}\n[link]\nvehicle_port = {port}\n"));
    room.write("ground.toml", format!("{SMALL}\n[link]\nground_port = {port}\n"));
    let by_line = |file: &str, key: &str| format!("columba: {file}:21: {key} = {port}: ");
    for command in ["run", "vehicles"] {
        room.columba(&[command, "vehicle.toml"]).refused(&[
            &by_line("vehicle.toml", "link.vehicle_port"),
            "busy",
            "must be a free port",
        ]);
        let said = format!("columba: --vehicle-port {port}: ");
        room.columba(&[command, "small.toml", "--vehicle-port", &flag]).refused(&[
            &said,
            "busy",
            "must be a free port",
        ]);
    }
    for command in ["run", "fly"] {
        room.columba(&[command, "ground.toml"]).refused(&[
            &by_line("ground.toml", "link.ground_port"),
            "busy",
            "must be a free port",
        ]);
        let said = format!("columba: --ground-port {port}: ");
        room.columba(&[command, "small.toml", "--ground-port", &flag]).refused(&[&said, "busy", "must be a free port"]);
    }
    assert_eq!(room.files(), ["ground.toml", "small.toml", "vehicle.toml"]);
}

#[test]
fn an_address_of_another_machine_is_refused_by_line() {
    let room = Room::new();
    // TEST-NET-3: no machine has it.
    room.write("far.toml", format!("{SMALL}\n[link]\nhost = \"203.0.113.7\"\n"));
    room.columba(&["run", "far.toml"])
        .refused(&["columba: far.toml:21: link.host = \"203.0.113.7\": ", "must be an address of this machine"]);
    assert_eq!(room.files(), ["far.toml"]);
}

#[test]
fn a_folder_that_cannot_be_made_is_refused_by_flag_or_line() {
    let room = Room::new();
    room.write("small.toml", SMALL);
    room.write("taken", "a file");
    room.write("into.toml", format!("{SMALL}\n[output]\nfolder = \"taken/run\"\n"));
    for transport in ["udp", "memory"] {
        room.columba(&["run", "small.toml", "--transport", transport, "--out", "taken"])
            .refused(&["columba: --out taken: cannot write into the run folder taken", "must be a folder"]);
        room.columba(&["run", "into.toml", "--transport", transport])
            .refused(&["columba: into.toml:21: output.folder = \"taken/run\": ", "must be a folder"]);
    }
    assert_eq!(room.read("taken"), b"a file");
    assert_eq!(room.files(), ["into.toml", "small.toml", "taken"]);
}
