//! docs/mavlink.md against the code: what the page says of messages, commands, modes, parameters and refusals is what a
//! vehicle does, and what a vehicle does is on the page.
#![allow(clippy::panic, clippy::unwrap_used, deprecated)]

mod common;

use common::{Client, TARGET, long, texts};
use mavlink_bridge::dialect::*;
use mavlink_bridge::{Counters, frames};
use sim_vehicle::{Mode, VehicleSettings};
use std::collections::{BTreeMap, BTreeSet};

const PAGE: &str = include_str!("../../../docs/mavlink.md");

/// Messages of ArduPilot's own dialect, which the common one does not name.
const OF_ARDUPILOT: [(&str, u32); 17] = [
    ("MEMINFO", 152),
    ("AHRS", 163),
    ("SIMSTATE", 164),
    ("HWSTATUS", 165),
    ("WIND", 168),
    ("RANGEFINDER", 173),
    ("AHRS2", 178),
    ("CAMERA_FEEDBACK", 180),
    ("MAG_CAL_PROGRESS", 191),
    ("EKF_STATUS_REPORT", 193),
    ("PID_TUNING", 194),
    ("DEEPSTALL", 195),
    ("RPM", 226),
    ("AVAILABLE_MODES_MONITOR", 437),
    ("UAVIONIX_ADSB_OUT_STATUS", 10_008),
    ("AOA_SSA", 11_020),
    ("ESC_TELEMETRY_1_TO_4", 11_030),
];

type Names = BTreeSet<String>;

/// The text of a section, from its heading to the next.
fn section(heading: &str) -> &'static str {
    let start = PAGE.find(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("no section {heading}"));
    let rest = &PAGE[start + heading.len() + 4..];
    &rest[..rest.find("\n## ").unwrap_or(rest.len())]
}

/// The rows of all tables whose first column is headed so, cell by cell.
fn rows(text: &'static str, first_column: &str) -> Vec<Vec<&'static str>> {
    let mut rows = Vec::new();
    let mut is_ours = false;
    for line in text.lines() {
        match line.strip_prefix("| ") {
            Some(row) => {
                let cells: Vec<&str> = row.trim_end_matches('|').split(" |").map(str::trim).collect();
                is_ours |= cells[0] == first_column;
                if is_ours && cells[0] != first_column {
                    rows.push(cells);
                }
            }
            None => is_ours &= line.starts_with('|'),
        }
    }
    rows
}

/// Words in capitals, such as NAV_LAND, of at least two letters.
fn names(text: &str) -> impl Iterator<Item = &str> {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let is_name = |name: &&str| {
        name.len() > 1
            && name.starts_with(|c: char| c.is_ascii_uppercase())
            && !name.contains(|c: char| c.is_lowercase())
    };
    text.split(move |c| !word(c)).filter(is_name)
}

/// What is written as `NAME (17)` or `NAME (17, words)`.
fn numbered(text: &str) -> BTreeMap<u32, String> {
    let mut found = BTreeMap::new();
    for (at, _) in text.match_indices(" (") {
        let digits: String = text[at + 2..].chars().take_while(char::is_ascii_digit).collect();
        let closed = text[at + 2 + digits.len()..].starts_with([')', ',', ':']);
        let name = names(text[..at].rsplit([' ', '\n', '|']).next().unwrap()).last();
        if let (Ok(number), Some(name), true) = (digits.parse(), name, closed) {
            found.insert(number, name.to_owned());
        }
    }
    found
}

fn flying() -> Client {
    Client::new(VehicleSettings { system_id: TARGET, ground: None, ..VehicleSettings::default() })
}

fn heartbeat() -> Message {
    mavlink_bridge::telemetry::ground_heartbeat()
}

/// How often each message comes in so many seconds, by its id.
fn streamed(client: &mut Client, seconds: f64) -> BTreeMap<u32, usize> {
    client.fly(seconds);
    let mut counts = BTreeMap::new();
    while let Some(transmit) = client.vehicle.poll_transmit() {
        for frame in frames(&transmit.datagram, &mut Counters::default()) {
            *counts.entry(frame.header.message_id).or_default() += 1;
        }
    }
    counts
}

fn message_id(name: &str) -> u32 {
    let own = OF_ARDUPILOT.iter().find(|(own, _)| *own == name).map(|(_, id)| *id);
    own.or_else(|| Message::message_id_from_name(name)).unwrap_or_else(|| panic!("there is no message {name}"))
}

#[test]
fn messages_come_at_the_rates_that_are_told() {
    let mut client = flying();
    client.ask(&heartbeat());
    streamed(&mut client, 1.0);
    let counts = streamed(&mut client, 10.0);
    let mut told = BTreeSet::new();
    for row in rows(section("Telemetry"), "message") {
        for name in names(row[0]) {
            let id = message_id(name);
            assert!(told.insert(id), "{name} is there twice");
            let count = counts.get(&id).copied().unwrap_or(0);
            let rate_hz = row[1].parse::<f64>().unwrap_or(0.0);
            assert_eq!(
                count as f64,
                10.0 * rate_hz,
                "{name} comes {count} times in 10 s, and the page says {}",
                row[1]
            );
            let answer = client.command_long(MavCmd::MAV_CMD_REQUEST_MESSAGE, [id as f32, 0.0, 0.0]);
            assert_eq!(answer, Some(MavResult::MAV_RESULT_ACCEPTED), "{name} on request");
        }
    }
    let requestable = |id: &u32| {
        let answer = client.command_long(MavCmd::MAV_CMD_REQUEST_MESSAGE, [*id as f32, 0.0, 0.0]);
        answer == Some(MavResult::MAV_RESULT_ACCEPTED)
    };
    let known: BTreeSet<u32> = (0..15_000).filter(requestable).chain(counts.into_keys()).collect();
    let untold: Vec<&u32> = known.difference(&told).collect();
    assert!(untold.is_empty(), "the page says nothing of messages {untold:?}");
}

/// COMMAND_LONG or COMMAND_INT with any number, be it one that the dialect does not know.
fn numbered_command(client: &mut Client, message: &Message, number: u16) -> Vec<u8> {
    const HEADER: usize = 10;
    const COMMAND_AT: usize = HEADER + 28;
    let crc_extra = if matches!(message, Message::COMMAND_LONG(_)) { 152 } else { 158 };
    let mut bytes = client.encode(message);
    bytes[COMMAND_AT..COMMAND_AT + 2].copy_from_slice(&number.to_le_bytes());
    let end = bytes.len() - 2;
    let mut crc: u16 = 0xFFFF;
    // X.25, as <https://mavlink.io/en/guide/serialization.html#checksum> has it.
    for byte in bytes[1..end].iter().copied().chain([crc_extra]) {
        let mut mixed = byte ^ (crc & 0xFF) as u8;
        mixed ^= mixed << 4;
        let mixed = u16::from(mixed);
        crc = (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4);
    }
    bytes[end..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// The result in the COMMAND_ACK that is waiting, be it of a command that the dialect does not know.
fn result(client: &mut Client) -> Option<u8> {
    const COMMAND_ACK: u32 = 77;
    let mut result = None;
    while let Some(transmit) = client.vehicle.poll_transmit() {
        for frame in frames(&transmit.datagram, &mut Counters::default()) {
            if frame.header.message_id == COMMAND_ACK {
                // Zeros at the end of a payload are not sent.
                result = Some(frame.payload().get(2).copied().unwrap_or(0));
            }
        }
    }
    result
}

#[test]
fn the_commands_that_are_told_are_those_that_are_obeyed() {
    let told = numbered(&rows(section("Commands"), "command").iter().map(|row| row[0]).collect::<Vec<_>>().join("\n"));
    let mut client = flying();
    let mut obeyed = BTreeMap::new();
    for number in 0..=u16::MAX {
        // STORAGE_FORMAT wants both.
        for (param1, param2) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)] {
            let as_long = Message::COMMAND_LONG(COMMAND_LONG_DATA {
                param1,
                param2,
                target_system: TARGET,
                confirmation: 1,
                ..COMMAND_LONG_DATA::DEFAULT
            });
            let as_int = Message::COMMAND_INT(COMMAND_INT_DATA {
                param1,
                param2,
                target_system: TARGET,
                autocontinue: 1,
                ..COMMAND_INT_DATA::DEFAULT
            });
            for message in [as_long, as_int] {
                let datagram = numbered_command(&mut client, &message, number);
                client.vehicle.handle(client.vehicle.time(), &datagram, client.address);
                if result(&mut client).is_some_and(|result| result != MavResult::MAV_RESULT_UNSUPPORTED as u8) {
                    let name = common::decode_command(&datagram).unwrap_or_else(|| format!("unknown {number}"));
                    obeyed.insert(u32::from(number), name.trim_start_matches("MAV_CMD_").to_owned());
                }
            }
        }
    }
    // Those of ArduPilot's own dialect are known by their number.
    for (number, name) in &mut obeyed {
        if let Some(told) = told.get(number).filter(|_| name.starts_with("unknown")) {
            name.clone_from(told);
        }
    }
    assert_eq!(told, obeyed);
}

#[test]
fn the_modes_that_are_told_are_those_that_there_are() {
    let is_mode = |(number, name): &(u32, String)| *number < 100 && !name.contains('_');
    let told: BTreeMap<u32, String> = numbered(section("Modes and arming")).into_iter().filter(is_mode).collect();
    let mut client = flying();
    let mut known = BTreeMap::new();
    for number in 0..100 {
        let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_DO_SET_MODE, [1.0, number as f32, 0.0]));
        let unknown = |text: &String| text.starts_with("No such mode") || text.ends_with("is not simulated");
        if !texts(&answer).iter().any(unknown) {
            known.insert(number, Mode::from_number(number).unwrap().name().to_owned());
        }
    }
    assert_eq!(told, known);
}

#[test]
fn the_parameters_that_are_told_are_those_that_there_are() {
    let mut client = flying();
    client.ask(&heartbeat());
    let request = PARAM_REQUEST_LIST_DATA { target_system: TARGET, target_component: 1 };
    let mut listed = Names::new();
    let mut received = client.ask(&Message::PARAM_REQUEST_LIST(request));
    while !received.is_empty() {
        for message in received {
            if let Message::PARAM_VALUE(value) = message {
                listed.insert(value.param_id.to_str().unwrap().to_owned());
            }
        }
        // The list is paced by the host's time.
        let due = client.vehicle.poll_timeout().unwrap_or_default();
        client.vehicle.handle_timeout(due);
        received = client.collect();
    }
    // `SIM_ ...` and `_Y (SIM_ACC1_BIAS_Y)` are short for others.
    let whole = |name: &&str| !name.ends_with('_') && !name.starts_with('_') && name.len() > 1;
    let told: Names =
        rows(PAGE, "parameter").iter().flat_map(|row| names(row[0])).filter(whole).map(str::to_owned).collect();
    let unlisted: Vec<&String> = told.difference(&listed).collect();
    assert!(unlisted.is_empty(), "the page tells of parameters that there are not: {unlisted:?}");
    let untold: Vec<&String> = listed.iter().filter(|name| !names(PAGE).any(|told| told == *name)).collect();
    assert!(untold.is_empty(), "the page says nothing of parameters {untold:?}");
}

/// The source of a file of this workspace, without its unit tests.
fn source(path: &str) -> String {
    let text = std::fs::read_to_string(format!("{}/../{path}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    text.split("#[cfg(test)]").next().unwrap().to_owned()
}

/// What follows a prefix in a text, up to the end of the word.
fn after<'a>(text: &'a str, prefix: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(prefix)
        .skip(1)
        .map(|rest| rest.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next().unwrap())
}

#[test]
fn the_messages_that_are_told_are_those_that_are_taken() {
    let told: Names = rows(section("Messages that it takes"), "message")
        .iter()
        .flat_map(|row| names(row[0]))
        .map(str::to_owned)
        .collect();
    let services = source("sim-vehicle/src/protocol/mod.rs");
    let arms = services.lines().filter(|line| line.contains(" =>"));
    let mut taken: Names = arms.flat_map(|arm| after(arm, "Message::")).map(str::to_owned).collect();
    for path in ["mavlink-bridge/src/command.rs", "mavlink-bridge/src/parameter.rs", "mavlink-bridge/src/mission.rs"] {
        let text = source(path);
        taken.extend(text.split("_DATA::ID =>").filter_map(|before| names(before).last()).map(str::to_owned));
        // What comes after the last arm is none.
        let last =
            text.rsplit("_DATA::ID =>").next().and_then(|after| names(after).last()).unwrap_or_default().to_owned();
        taken.remove(&last);
    }
    // Those of ArduPilot's dialect have their numbers there.
    let points = source("mavlink-bridge/src/points.rs");
    let numbers = points.lines().filter_map(|line| line.strip_prefix("const ")?.split_once(": u32"));
    taken.extend(numbers.map(|(name, _)| name.to_owned()));
    assert_eq!(told, taken);
}

#[test]
fn the_refusals_that_are_told_are_those_that_there_are() {
    for (prefix, heading, first_column, accepted) in [
        ("MAV_RESULT_", "Refusals", "what is wrong", "ACCEPTED"),
        ("MAV_MISSION_", "Plans", "what is wrong with an upload", "ACCEPTED"),
    ] {
        let rows = rows(section(heading), first_column);
        let told: Names = rows.iter().flat_map(|row| names(row[row.len() - 1])).map(str::to_owned).collect();
        let mut given = Names::new();
        for path in sources("sim-vehicle/src") {
            let is_code = |name: &&str| *name != accepted && !name.is_empty() && !name.starts_with("TYPE");
            given.extend(after(&source(&path), prefix).filter(is_code).map(str::to_owned));
        }
        // INVALID_PARAM1 to INVALID_PARAM7 are told by the first and the last.
        let is_between = |name: &String| name.starts_with("INVALID_PARAM");
        let untold: Vec<&String> = given.difference(&told).filter(|name| !is_between(name)).collect();
        assert!(untold.is_empty(), "{heading}: the page says nothing of {untold:?}");
        let never: Vec<&String> = told.difference(&given).collect();
        assert!(never.is_empty(), "{heading}: nothing is ever answered with {never:?}");
    }
}

/// All Rust files below a folder of this workspace's crates.
fn sources(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(format!("{}/../{folder}", env!("CARGO_MANIFEST_DIR"))).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            found.extend(sources(&path));
        } else if path.ends_with(".rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
    found
}
