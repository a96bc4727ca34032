//! Holds the table "Params that are read" of docs/mavlink.md to the code: a param that is not in it changes no answer.

use crate::error::CommandResult;
use crate::firmware::Personality;
use crate::links::PeerId;
use crate::mode::Mode;
use crate::protocol::Services;
use crate::protocol::command::execute_by_number;
use crate::protocol::command::request::Command;
use crate::settings::VehicleSettings;
use crate::telemetry::announce::Component;
use mavlink_bridge::{CommandPosition, LatLonE7, Version};

const PAGE: &str = include_str!("../../../../../docs/mavlink.md");

/// The rows of the table: a command and the params that are read.
fn rows() -> Vec<(u16, Vec<usize>)> {
    let section = PAGE.split("### Params that are read").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| ") && line.contains('('));
    rows.flat_map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let params: Vec<usize> = cells[0].split(' ').filter_map(|digit| digit.parse().ok()).collect();
        let numbers = cells[1].split('(').skip(1).filter_map(|part| part.split(')').next()?.parse().ok());
        numbers.map(|number| (number, params.clone())).collect::<Vec<(u16, Vec<usize>)>>()
    })
    .collect()
}

/// How a command is refused; none: accepted.
type Answer = Option<CommandResult>;

/// What a vehicle answers, on the ground or in the air and in GUIDED.
fn answer(number: u16, params: [f32; 7], is_int: bool, in_air: bool) -> Answer {
    answer_of(Personality::ArduPlane, number, params, is_int, in_air)
}

fn answer_of(personality: Personality, number: u16, params: [f32; 7], is_int: bool, in_air: bool) -> Answer {
    let settings = VehicleSettings { on_ground: !in_air, personality, ..VehicleSettings::default() };
    let mut component = Component::new(settings, false);
    component.autopilot.start();
    let (link, _) = component.hear(PeerId::from(([127, 0, 0, 1], 14550)), Version::V2);
    if in_air && personality == Personality::ArduPlane {
        component.autopilot.set_mode(Mode::Guided);
    }
    let [p1, p2, p3, p4, p5, p6, z] = params;
    let position = if is_int {
        CommandPosition::Int(LatLonE7 { latitude_e7: p5 as i32, longitude_e7: p6 as i32 })
    } else {
        CommandPosition::Long([p5, p6])
    };
    let frame = is_int.then_some(3);
    let wire = mavlink_bridge::Command { number, params: [p1, p2, p3, p4], position, z, frame };
    let outcome = match Command::read(&wire) {
        Some(command) => Services::default().execute(&mut component, &command, link),
        None => execute_by_number(&mut component.autopilot, &wire),
    };
    outcome.err().map(|refusal| refusal.result)
}

/// Params with which a command that asks for some is accepted.
fn accepted(number: u16) -> [f32; 7] {
    let mut params = [0.0; 7];
    match number {
        176 => params[..2].copy_from_slice(&[1.0, 12.0]),
        178 | 43_000 => params[1] = 10.0,
        186 => params[0] = 60.0,
        192 | 43_001 | 179 => params[4..].copy_from_slice(&[1000.0, 1000.0, 60.0]),
        246 | 519 | 520 | 42_007 => params[0] = 1.0,
        511 | 512 => params[0] = 30.0,
        _ => {}
    }
    params
}

#[test]
fn a_param_that_is_not_in_the_table_is_ignored() {
    let rows = rows();
    assert!(rows.len() > 70, "{}", rows.len());
    for (number, read) in rows {
        for (is_int, in_air) in [(false, false), (false, true), (true, false), (true, true)] {
            let base = accepted(number);
            let expected = answer(number, base, is_int, in_air);
            for param in (1..=7).filter(|param| !read.contains(param)) {
                for value in [1.0, -1.0, 1000.0] {
                    let mut params = base;
                    params[param - 1] = value;
                    let found = answer(number, params, is_int, in_air);
                    assert_eq!(found, expected, "command {number}, param {param} = {value}, {is_int} {in_air}");
                }
            }
        }
    }
}

#[test]
fn a_param_of_the_table_changes_an_answer_where_it_is_refused() {
    for (number, param, value, is_int, in_air, expected) in [
        (176, 2, 99.0, false, true, Some(CommandResult::Failed)),
        (178, 1, 2.0, false, true, Some(CommandResult::Failed)),
        (186, 2, 1.0, false, true, Some(CommandResult::Denied)),
        (192, 7, 0.0, true, true, Some(CommandResult::Denied)),
        (246, 1, 2.0, false, false, Some(CommandResult::Unsupported)),
        (300, 1, 1.0, false, false, Some(CommandResult::Denied)),
        (400, 1, 2.0, false, false, Some(CommandResult::Unsupported)),
        (511, 3, 1.0, false, false, Some(CommandResult::Denied)),
        (601, 1, 65_536.0, false, false, Some(CommandResult::Denied)),
        (43_000, 1, 1.0, false, true, Some(CommandResult::Denied)),
        (43_002, 1, 3.0, false, true, Some(CommandResult::Denied)),
    ] {
        let mut params = accepted(number);
        params[param - 1] = value;
        assert_eq!(answer(number, params, is_int, in_air), expected, "command {number}");
    }
}

#[test]
fn an_armed_vehicle_reboots_by_force_alone() {
    let refused = answer(246, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], false, true);
    let forced = [false, true].map(|is_int| answer(246, [1.0, 0.0, 0.0, 0.0, 0.0, 20_190_226.0, 0.0], is_int, true));
    assert_eq!((refused, forced), (Some(CommandResult::Failed), [None; 2]));
}

/// All numbers of commands that an autopilot answers otherwise than UNSUPPORTED.
fn known(personality: Personality) -> Vec<u16> {
    let ranges = [0..3_100, 4_500..5_400, 10_000..10_010, 31_000..31_020, 32_000..32_010, 40_000..43_100];
    let is_known = |number: &u16| {
        [false, true].into_iter().any(|is_int| {
            let result = answer_of(personality, *number, accepted(*number), is_int, true);
            result != Some(CommandResult::Unsupported)
        })
    };
    ranges.into_iter().flatten().filter(is_known).collect()
}

#[test]
fn every_command_that_an_arduplane_knows_is_in_the_table() {
    let rows: Vec<u16> = rows().into_iter().map(|(number, _)| number).collect();
    let missing: Vec<u16> = known(Personality::ArduPlane).into_iter().filter(|number| !rows.contains(number)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn every_command_that_a_px4_knows_is_in_its_sections() {
    let sections = PAGE.split("\n## Personalities").nth(1).and_then(|rest| rest.split("\n## Generic").next()).unwrap();
    let is_missing = |number: &u16| !sections.contains(&format!("({number})"));
    let missing: Vec<u16> = known(Personality::Px4).into_iter().filter(is_missing).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
