//! The command line: help, exit statuses and refusals, none of which leaves anything behind.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

mod common;

use common::{Room, SMALL, busy_port};

#[test]
fn help_names_every_command_and_every_flag() {
    let room = Room::new();
    let help = room.columba(&["--help"]).with(0).out;
    for word in ["run", "vehicles", "fly", "compare", "check", "Exit status: 0 flown", "--quiet", "--threads"] {
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
