//! Which params of a command a PX4 uses; any other must be left out (`mavlink_command_params.hpp` of 1.18).
//!
//! A param is left out as 0 or NaN. The integers x and y of a mission item with a place are left out as INT32_MAX or
//! INT32_MIN alone.

use crate::error::{CommandError, PlanError};
use crate::protocol::command::request::Command;
use mavlink_bridge::{CommandPosition, LatLonE7, PlanItem};

/// A command, the params that its mission item uses, and those that the command itself uses: each digit is one param.
const USED: [(u16, u32, u32); 46] = [
    (16, 124_567, 124_567),
    (17, 34_567, 34_567),
    (19, 1_234_567, 1_234_567),
    (20, 0, 0),
    (21, 124_567, 124_567),
    // Param 1, the least pitch, is a fixed wing's.
    (22, 14_567, 14_567),
    (31, 124_567, 124_567),
    (80, 123_567, 123_567),
    (84, 4_567, 34_567),
    (85, 34_567, 1_234_567),
    (93, 1234, 1234),
    (112, 1, 1),
    (114, 1, 1),
    (176, 123, 123),
    (177, 12, 12),
    (178, 123, 123),
    (179, 1_234_567, 1_234_567),
    (189, 567, 567),
    (195, 567, 1567),
    (196, 1, 1),
    (197, 1, 1),
    (201, 123, 123),
    (206, 1234, 1234),
    (211, 12, 12),
    (212, 12, 12),
    (214, 123, 123),
    (400, 12, 12),
    (420, 123, 123),
    (530, 12, 12),
    (532, 123, 123),
    (534, 123, 123),
    (611, 0, 567),
    (2000, 1234, 1234),
    (2001, 1, 1),
    (2003, 1234, 1234),
    (2500, 123, 123),
    (2501, 12, 12),
    (3000, 12, 12),
    (4501, 0, 0),
    (5000, 567, 0),
    (5001, 156, 1),
    (5002, 156, 1),
    (5003, 156, 1),
    (5004, 156, 1),
    (5100, 567, 0),
    (42_600, 1234, 1234),
];

/// Whether one of the digits is that param.
const fn has(mut digits: u32, param: u32) -> bool {
    while digits > 0 {
        if digits % 10 == param {
            return true;
        }
        digits /= 10;
    }
    false
}

fn is_left_out(param: f32) -> bool {
    param.is_nan() || param == 0.0
}

/// Whether an integer coordinate says that there is none.
pub(super) fn is_no_coordinate(coordinate: i32) -> bool {
    matches!(coordinate, i32::MAX | i32::MIN)
}

/// The first param, 1 to 7, that is given and not used; none for a command that is not in the table.
fn first_unused(used: Option<u32>, is_given: [bool; 7]) -> Option<u8> {
    let used = used?;
    (1..=7u8).zip(is_given).find(|(param, is_given)| *is_given && !has(used, u32::from(*param))).map(|(param, _)| param)
}

fn row(command: u16) -> Option<&'static (u16, u32, u32)> {
    USED.iter().find(|(number, ..)| *number == command)
}

/// Whether a COMMAND_LONG says as a COMMAND_INT does that there is no place, or the other way round.
fn is_of_the_other_message(position: CommandPosition) -> bool {
    /// NaN, its upper bytes as an integer.
    const NAN: i32 = 0x7FF8_0000;
    match position {
        CommandPosition::Long(params) => {
            let most = i32::MAX as f32;
            params.iter().all(|param| (most.next_down()..=most.next_up()).contains(param))
        }
        CommandPosition::Int(at) => at == LatLonE7 { latitude_e7: NAN, longitude_e7: NAN },
    }
}

/// A param that the command does not use is DENIED.
pub(super) fn check_command(command: &Command) -> Result<(), CommandError> {
    if is_of_the_other_message(command.position) {
        return Err(CommandError::denied("Command: params 5 and 6 are the other message's"));
    }
    let used = row(command.command as u32 as u16).map(|(_, _, used)| *used);
    let [p1, p2, p3, p4] = command.params.map(|param| !is_left_out(param));
    let [p5, p6] = match command.position {
        CommandPosition::Int(LatLonE7 { latitude_e7: i32::MAX, longitude_e7: i32::MAX }) => [false; 2],
        CommandPosition::Int(at) => [at.latitude_e7 != 0, at.longitude_e7 != 0],
        CommandPosition::Long(params) => params.map(|param| !is_left_out(param)),
    };
    match first_unused(used, [p1, p2, p3, p4, p5, p6, !is_left_out(command.z)]) {
        Some(param) => Err(CommandError::denied(format!("Command: param {param} is not supported"))),
        None => Ok(()),
    }
}

/// A param that the mission item does not use is INVALID_PARAM1 to 7. `by_integers`: it came as MISSION_ITEM_INT and
/// has a place.
pub(super) fn check_item(item: &PlanItem, by_integers: bool) -> Result<(), PlanError> {
    let used = row(item.command).map(|(_, used, _)| *used);
    let [p1, p2, p3, p4] = item.params.map(|param| !is_left_out(param));
    let is_given = |coordinate: i32| !is_no_coordinate(coordinate) && (by_integers || coordinate != 0);
    let coordinates = [item.latitude_e7, item.longitude_e7].map(is_given);
    let [p5, p6] = coordinates;
    match first_unused(used, [p1, p2, p3, p4, p5, p6, !is_left_out(item.z_m)]) {
        Some(param) => Err(PlanError::InvalidParam(param)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order_and_its_digits_are_params() {
        assert!(USED.windows(2).all(|pair| pair[0].0 < pair[1].0));
        for (command, item, long) in USED {
            for mut digits in [item, long] {
                let mut before = 8;
                while digits > 0 {
                    assert!((1..before).contains(&(digits % 10)), "{command}");
                    before = digits % 10;
                    digits /= 10;
                }
            }
        }
    }

    #[test]
    fn the_page_has_this_table() {
        const PAGE: &str = include_str!("../../../../../docs/mavlink.md");
        let digits = |used: u32| -> String {
            let digits: Vec<String> = used.to_string().chars().map(String::from).collect();
            if used == 0 { "none".into() } else { digits.join(" ") }
        };
        for (command, item, long) in USED {
            let row = format!(" ({command}) | {} | {} |\n", digits(item), digits(long));
            assert!(PAGE.contains(&row), "{row}");
        }
    }

    #[test]
    fn what_is_left_out_is_0_or_nan_and_as_an_integer_the_bounds() {
        let jump = PlanItem { command: 177, params: [0.0, 3.0, f32::NAN, 0.0], z_m: f32::NAN, ..PlanItem::default() };
        assert_eq!(check_item(&jump, false), Ok(()));
        assert_eq!(check_item(&jump, true), Err(PlanError::InvalidParam(5)));
        let nowhere = PlanItem { latitude_e7: i32::MAX, longitude_e7: i32::MIN, ..jump };
        assert_eq!(check_item(&nowhere, true), Ok(()));
        let turned = PlanItem { params: [0.0, 3.0, 0.0, -1.0], ..jump };
        assert_eq!(check_item(&turned, false), Err(PlanError::InvalidParam(4)));
        // NAV_LOITER_TURNS, which a PX4 has not.
        assert_eq!(check_item(&PlanItem { command: 18, params: [9.0; 4], ..jump }, true), Ok(()));
    }
}
