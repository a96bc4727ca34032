//! The items of a mission: which of them the vehicle takes, and what is wrong with the others.

use crate::autopilot::home::datum_of;
use crate::autopilot::input::ALTITUDE_MAX_M;
use crate::error::PlanError;
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::MavCmd;
use std::ops::Range;

pub(crate) const WAYPOINT: u16 = MavCmd::MAV_CMD_NAV_WAYPOINT as u32 as u16;
pub(super) const LOITER_UNLIM: u16 = MavCmd::MAV_CMD_NAV_LOITER_UNLIM as u32 as u16;
pub(crate) const LOITER_TURNS: u16 = MavCmd::MAV_CMD_NAV_LOITER_TURNS as u32 as u16;
pub(super) const LOITER_TIME: u16 = MavCmd::MAV_CMD_NAV_LOITER_TIME as u32 as u16;
pub(super) const RETURN_TO_LAUNCH: u16 = MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH as u32 as u16;
pub(super) const LAND: u16 = MavCmd::MAV_CMD_NAV_LAND as u32 as u16;
pub(super) const TAKEOFF: u16 = MavCmd::MAV_CMD_NAV_TAKEOFF as u32 as u16;
pub(super) const CHANGE_ALTITUDE: u16 = MavCmd::MAV_CMD_NAV_CONTINUE_AND_CHANGE_ALT as u32 as u16;
pub(super) const LOITER_TO_ALTITUDE: u16 = MavCmd::MAV_CMD_NAV_LOITER_TO_ALT as u32 as u16;
pub(super) const JUMP: u16 = MavCmd::MAV_CMD_DO_JUMP as u32 as u16;
pub(super) const PARACHUTE: u16 = MavCmd::MAV_CMD_DO_PARACHUTE as u32 as u16;
pub(super) const RELAY: u16 = MavCmd::MAV_CMD_DO_SET_RELAY as u32 as u16;
pub(super) const SERVO: u16 = MavCmd::MAV_CMD_DO_SET_SERVO as u32 as u16;
pub(super) const CHANGE_SPEED: u16 = MavCmd::MAV_CMD_DO_CHANGE_SPEED as u32 as u16;
pub(super) const SET_HOME: u16 = MavCmd::MAV_CMD_DO_SET_HOME as u32 as u16;
pub(crate) const RETURN_PATH_START: u16 = MavCmd::MAV_CMD_DO_RETURN_PATH_START as u32 as u16;
pub(crate) const LAND_START: u16 = MavCmd::MAV_CMD_DO_LAND_START as u32 as u16;
pub(super) const FENCE_ENABLE: u16 = MavCmd::MAV_CMD_DO_FENCE_ENABLE as u32 as u16;
pub(super) const GO_AROUND: u16 = MavCmd::MAV_CMD_DO_GO_AROUND as u32 as u16;
pub(super) const TAG: u16 = MavCmd::MAV_CMD_JUMP_TAG as u32 as u16;
pub(super) const JUMP_TO_TAG: u16 = MavCmd::MAV_CMD_DO_JUMP_TAG as u32 as u16;

/// What ArduPlane takes and has nothing to do with where a vehicle without a payload flies: delays (of which there are
/// none while it is armed), conditions of such items, servos, relays, cameras, gimbals, engines, scripts.
const WITHOUT_EFFECT: [u16; 39] = [
    92, 93, 112, 114, 115, 181, 182, 183, 184, 193, 194, 195, 197, 201, 202, 203, 205, 206, 208, 210, 211, 212, 215,
    216, 217, 218, 222, 223, 531, 532, 534, 1000, 2000, 2001, 2500, 2501, 3000, 42600, 42703,
];

/// The same of a PX4 (`mavlink_mission.cpp`), beyond those: regions of interest, cameras, mounts, gimbals, actuators,
/// gates.
const WITHOUT_EFFECT_BUT_TO_ARDUPLANE: [u16; 12] = [80, 187, 196, 198, 200, 204, 214, 260, 530, 1001, 2003, 4501];

/// Whether an item has a place, as ArduPilot stores it.
pub(crate) fn has_place(command: u16) -> bool {
    const REGIONS: [u16; 3] = [92, 195, 201];
    matches!(
        command,
        WAYPOINT | LOITER_UNLIM | LOITER_TURNS | LOITER_TIME | LOITER_TO_ALTITUDE | LAND | TAKEOFF | CHANGE_ALTITUDE
    ) || matches!(command, SET_HOME | RETURN_PATH_START | LAND_START | GO_AROUND)
        || REGIONS.contains(&command)
}

/// Whether param 4 of an item is a heading, which ground stations leave NaN.
pub(crate) fn has_heading(command: u16) -> bool {
    matches!(command, WAYPOINT | LOITER_UNLIM | LAND | TAKEOFF)
}

/// Whether AUTO can fly an item of a mission whose items `flown` are flown; the result code that says why not. As
/// ArduPlane's, and beyond it: numbers must be such that the item can be flown.
pub(crate) fn check(item: &PlanItem, flown: Range<u16>) -> Result<(), PlanError> {
    let is_known = has_place(item.command)
        || matches!(item.command, RETURN_TO_LAUNCH | JUMP | CHANGE_SPEED | FENCE_ENABLE | TAG | JUMP_TO_TAG)
        || WITHOUT_EFFECT.contains(&item.command)
        // Where item 0 is flown it is no ArduPlane.
        || flown.start == 0 && WITHOUT_EFFECT_BUT_TO_ARDUPLANE.contains(&item.command);
    if !is_known {
        return Err(PlanError::Unsupported);
    }
    const INVALID: [PlanError; 4] = [
        PlanError::InvalidParam(1),
        PlanError::InvalidParam(2),
        PlanError::InvalidParam(3),
        PlanError::InvalidParam(4),
    ];
    let has_heading = has_heading(item.command);
    for (index, (param, result)) in item.params.iter().zip(INVALID).enumerate() {
        if param.is_infinite() || param.is_nan() && !(has_heading && index == 3) {
            return Err(result);
        }
    }
    if has_place(item.command) {
        check_place(item)?;
    }
    let [p1, ..] = item.params;
    match item.command {
        JUMP if !(f32::from(flown.start)..f32::from(flown.end)).contains(&p1) => Err(PlanError::JumpTarget),
        _ => Ok(()),
    }
}

fn check_place(item: &PlanItem) -> Result<(), PlanError> {
    if !item.position().is_latitude_valid() {
        return Err(PlanError::InvalidParam(5));
    }
    if !item.position().is_longitude_valid() {
        return Err(PlanError::InvalidParam(6));
    }
    if item.z_m.is_nan() || item.z_m.abs() >= ALTITUDE_MAX_M {
        return Err(PlanError::InvalidParam(7));
    }
    if datum_of(item).is_none() {
        return Err(PlanError::UnsupportedFrame);
    }
    Ok(())
}

/// Whether an item is flown to or waited at; others are done on the way (`AP_Mission::is_nav_cmd`).
pub(super) fn is_flown_to(item: &PlanItem) -> bool {
    const NAV_LAST: u16 = 95;
    const OTHERS: [u16; 3] = [213, 42_702, 42_703];
    item.command <= NAV_LAST || OTHERS.contains(&item.command)
}

/// Whether an item leads to another one.
pub(super) fn is_jump(item: &PlanItem) -> bool {
    matches!(item.command, JUMP | JUMP_TO_TAG)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: PlanItem = PlanItem {
        command: WAYPOINT,
        frame: 3,
        z_m: 50.0,
        params: [0.0, 0.0, 0.0, f32::NAN],
        latitude_e7: 0,
        longitude_e7: 0,
        autocontinue: 1,
    };

    #[test]
    fn what_cannot_be_flown_is_refused_by_its_code() {
        assert_eq!(check(&GOOD, 1..2), Ok(()));
        for (item, result) in [
            (PlanItem { command: 82, ..GOOD }, PlanError::Unsupported),
            (PlanItem { command: 60_000, ..GOOD }, PlanError::Unsupported),
            (PlanItem { frame: 1, ..GOOD }, PlanError::UnsupportedFrame),
            (PlanItem { params: [0.0, f32::NAN, 0.0, 0.0], ..GOOD }, PlanError::InvalidParam(2)),
            (PlanItem { params: [0.0, 0.0, 0.0, f32::INFINITY], ..GOOD }, PlanError::InvalidParam(4)),
            (PlanItem { command: LOITER_TIME, ..GOOD }, PlanError::InvalidParam(4)),
            (PlanItem { latitude_e7: 900_000_001, ..GOOD }, PlanError::InvalidParam(5)),
            (PlanItem { longitude_e7: i32::MIN, ..GOOD }, PlanError::InvalidParam(6)),
            (PlanItem { z_m: f32::INFINITY, ..GOOD }, PlanError::InvalidParam(7)),
            (PlanItem { command: JUMP, params: [2.0, 1.0, 0.0, 0.0], ..GOOD }, PlanError::JumpTarget),
        ] {
            assert_eq!(check(&item, 1..2), Err(result), "{item:?}");
        }
    }

    #[test]
    fn what_has_no_place_needs_neither_frame_nor_altitude() {
        for command in [RETURN_TO_LAUNCH, CHANGE_SPEED, 93, 206, 2000] {
            let params = [1.0, 2.0, 0.0, 0.0];
            assert_eq!(
                check(&PlanItem { command, params, frame: 2, z_m: f32::NAN, ..GOOD }, 1..2),
                Ok(()),
                "{command}"
            );
        }
    }
}
