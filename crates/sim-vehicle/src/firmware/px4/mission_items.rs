//! Which items a PX4 takes into a plan, by their frame (`parse_mavlink_mission_item` of `mavlink_mission.cpp`).

use super::params;
use crate::autopilot::input::ALTITUDE_MAX_M;
use crate::autopilot::plan::PlanKind;
use crate::error::PlanError;
use mavlink_bridge::PlanItem;

/// Items with a place: above sea level (frames 0 and 5) or above home (3 and 6).
const WITH_PLACE: [u16; 20] =
    [16, 17, 19, 21, 22, 31, 80, 84, 85, 195, 201, 212, 400, 4501, 5000, 5001, 5002, 5003, 5004, 5100];
/// Items without a place, in MAV_FRAME_MISSION (2).
const WITHOUT_PLACE: [u16; 33] = [
    20, 80, 93, 112, 177, 178, 179, 187, 189, 196, 197, 200, 201, 203, 204, 205, 206, 211, 212, 214, 260, 400, 530,
    532, 534, 1000, 1001, 2000, 2001, 2003, 2500, 2501, 3000,
];
const DO_WINCH: u16 = 42_600;
/// Corners, circles and rally points have plans of their own. A fence's return point is let through.
const OF_OTHER_PLANS: [u16; 5] = [5001, 5002, 5003, 5004, 5100];
const REGIONS_OF_INTEREST: [u16; 2] = [80, 201];

const GLOBAL_FRAMES: [u8; 4] = [0, 3, 5, 6];
const MISSION_FRAME: u8 = 2;

/// Whether an item can be one of a plan; or why not. `by_integers`: it came as MISSION_ITEM_INT.
pub(in crate::firmware) fn check(kind: PlanKind, item: &PlanItem, by_integers: bool) -> Result<(), PlanError> {
    // The numbers of the INT messages' own frames are none in the older one.
    let has_place = GLOBAL_FRAMES.contains(&item.frame) && (by_integers || item.frame < 5);
    if !has_place && item.frame != MISSION_FRAME {
        return Err(PlanError::UnsupportedFrame);
    }
    params::check_item(item, by_integers && has_place)?;
    if REGIONS_OF_INTEREST.contains(&item.command) {
        check_region(item.params[0], has_place)?;
    }
    let is_known = if has_place {
        WITH_PLACE.contains(&item.command)
    } else {
        WITHOUT_PLACE.contains(&item.command) || item.command == DO_WINCH
    };
    if !is_known {
        return Err(PlanError::Unsupported);
    }
    match kind {
        PlanKind::Mission if OF_OTHER_PLANS.contains(&item.command) => Err(PlanError::OtherPlan),
        // The only thing that is looked at of a fence before it is whole: a polygon has three corners.
        PlanKind::Fence if matches!(item.command, 5001 | 5002) && ((item.params[0] + 0.5) as u16) < 3 => {
            Err(PlanError::TooFewVertices(item.params[0] as u8))
        }
        // A PX4 takes any numbers. We fly by them: they must be numbers that can be flown.
        PlanKind::Mission => check_numbers(item, has_place),
        PlanKind::Fence | PlanKind::Rally => Ok(()),
    }
}

/// An item as it is told again: what a PX4 keeps of it (`format_mavlink_mission_item`). Frames are those of the message
/// that it is told by.
pub(in crate::firmware) fn as_kept(kind: PlanKind, item: &PlanItem, by_integers: bool) -> PlanItem {
    let [p1, p2, p3, p4] = item.params;
    if item.frame == MISSION_FRAME {
        let command = match item.command {
            80 => 201,
            112 => 93,
            other => other,
        };
        let params = if command == 177 { [p1.trunc(), p2.trunc(), p3, p4] } else { item.params };
        return PlanItem { command, params, ..*item };
    }
    let yaw_deg = p4.rem_euclid(360.0);
    let switch = |param: f32| f32::from(u8::from(param > 0.0));
    let params = match item.command {
        16 => [p1, p2, 0.0, yaw_deg],
        17 => [0.0, 0.0, p3, yaw_deg],
        19 => [p1, switch(p2), p3, switch(p4)],
        21 => [p1, p2, 0.0, yaw_deg],
        22 | 84 | 85 => [0.0, 0.0, 0.0, yaw_deg],
        31 => [switch(p1), p2, 0.0, switch(p4)],
        5001 | 5002 => [(p1 + 0.5).trunc(), 0.0, 0.0, 0.0],
        5003 | 5004 => [p1, 0.0, 0.0, 0.0],
        _ => [0.0; 4],
    };
    // Of a fence neither what its altitudes are above nor whether it goes on is kept.
    let is_fence = kind == PlanKind::Fence;
    let is_relative = matches!(item.frame, 3 | 6) && !is_fence;
    let frame = match (is_relative, by_integers) {
        (true, true) => 6,
        (true, false) => 3,
        (false, true) => 5,
        (false, false) => 0,
    };
    let command = if item.command == 80 { 201 } else { item.command };
    PlanItem { params, frame, command, autocontinue: if is_fence { 0 } else { item.autocontinue }, ..*item }
}

/// MAV_ROI of param 1: a location or none with a place; none, the next waypoint or a waypoint without.
fn check_region(mode: f32, has_place: bool) -> Result<(), PlanError> {
    let known: &[i32] = if has_place { &[0, 3] } else { &[0, 1, 2] };
    // No number is no mode.
    let mode = if mode.is_nan() { -1.0 } else { mode };
    if known.contains(&(mode as i32)) { Ok(()) } else { Err(PlanError::InvalidParam(1)) }
}

fn check_numbers(item: &PlanItem, has_place: bool) -> Result<(), PlanError> {
    if let Some((_, param)) = item.params.iter().zip(1..=4).find(|(param, _)| param.is_infinite()) {
        return Err(PlanError::InvalidParam(param));
    }
    if !has_place {
        return Ok(());
    }
    let is_off = |coordinate: i32, most: u32| !params::is_no_coordinate(coordinate) && coordinate.unsigned_abs() > most;
    if is_off(item.latitude_e7, 900_000_000) {
        return Err(PlanError::InvalidParam(5));
    }
    if is_off(item.longitude_e7, 1_800_000_000) {
        return Err(PlanError::InvalidParam(6));
    }
    // One without an altitude is flown at the one that the vehicle has by then.
    if item.z_m.abs() >= ALTITUDE_MAX_M {
        return Err(PlanError::InvalidParam(7));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: PlanItem = PlanItem {
        params: [0.0; 4],
        latitude_e7: 399_800_000,
        longitude_e7: 1_163_400_000,
        z_m: 50.0,
        command: 16,
        frame: 3,
        autocontinue: 1,
    };

    #[test]
    fn an_item_is_checked_by_its_frame_then_by_its_params_then_by_its_command() {
        for (item, result) in [
            (POINT, None),
            (PlanItem { frame: 11, ..POINT }, Some(PlanError::UnsupportedFrame)),
            (PlanItem { frame: 2, ..POINT }, Some(PlanError::Unsupported)),
            (PlanItem { command: 178, ..POINT }, Some(PlanError::InvalidParam(5))),
            (PlanItem { command: 18, params: [-1.0; 4], ..POINT }, Some(PlanError::Unsupported)),
            (
                PlanItem {
                    command: 201,
                    params: [9.0, 0.0, 0.0, 0.0],
                    frame: 2,
                    latitude_e7: 0,
                    longitude_e7: 0,
                    z_m: 0.0,
                    ..POINT
                },
                Some(PlanError::InvalidParam(1)),
            ),
            (PlanItem { command: 5003, params: [9.0, 0.0, 0.0, 0.0], ..POINT }, Some(PlanError::InvalidParam(7))),
            (PlanItem { command: 5003, params: [9.0, 0.0, 0.0, 0.0], z_m: 0.0, ..POINT }, Some(PlanError::OtherPlan)),
            (PlanItem { z_m: f32::INFINITY, ..POINT }, Some(PlanError::InvalidParam(7))),
            (PlanItem { latitude_e7: i32::MAX, ..POINT }, None),
        ] {
            assert_eq!(check(PlanKind::Mission, &item, true).err(), result, "{item:?}");
        }
        assert_eq!(check(PlanKind::Mission, &PlanItem { frame: 6, ..POINT }, false), Err(PlanError::UnsupportedFrame));
    }

    #[test]
    fn an_item_is_told_as_it_is_kept() {
        let item = |command, params, frame| PlanItem { command, params, frame, ..POINT };
        for (kind, given, told) in [
            (PlanKind::Mission, item(16, [1.0, 2.0, 3.0, -90.0], 3), item(16, [1.0, 2.0, 0.0, 270.0], 6)),
            (PlanKind::Mission, item(19, [5.0, 7.0, -60.0, 0.0], 0), item(19, [5.0, 1.0, -60.0, 0.0], 5)),
            (PlanKind::Mission, item(112, [5.0, 0.0, 0.0, 0.0], 2), item(93, [5.0, 0.0, 0.0, 0.0], 2)),
            (PlanKind::Rally, item(5100, [9.0; 4], 6), item(5100, [0.0; 4], 6)),
        ] {
            assert_eq!(as_kept(kind, &given, true), told);
        }
        let fence = as_kept(PlanKind::Fence, &item(5003, [80.0, 0.0, 0.0, 0.0], 3), false);
        assert_eq!((fence.frame, fence.autocontinue, fence.params[0]), (0, 0, 80.0));
    }

    #[test]
    fn of_a_fence_only_the_number_of_corners_is_looked_at() {
        let fence = PlanItem { command: 5003, z_m: 0.0, params: [0.0; 4], latitude_e7: 0, longitude_e7: 0, ..POINT };
        assert_eq!(check(PlanKind::Fence, &fence, true), Ok(()));
        let polygon = PlanItem { command: 5001, ..fence };
        for (corners, result) in [(2.4, Err(PlanError::TooFewVertices(2))), (2.5, Ok(())), (70_000.0, Ok(()))] {
            let polygon = PlanItem { params: [corners, 0.0, 0.0, 0.0], ..polygon };
            assert_eq!(check(PlanKind::Fence, &polygon, true), result, "{corners}");
        }
        // An item of a mission makes no fence, and is let through.
        assert_eq!(check(PlanKind::Fence, &POINT, true), Ok(()));
    }
}
