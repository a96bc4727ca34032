//! Missions: what is kept, and how AUTO flies it.

mod auto;

pub(crate) use auto::Progress;

use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::{MavCmd, MavMissionResult};

/// Most items, home among them.
pub(crate) const ITEMS_MAX: u16 = 700;

pub(crate) const WAYPOINT: u16 = MavCmd::MAV_CMD_NAV_WAYPOINT as u32 as u16;
const LOITER_UNLIM: u16 = MavCmd::MAV_CMD_NAV_LOITER_UNLIM as u32 as u16;
const LOITER_TURNS: u16 = MavCmd::MAV_CMD_NAV_LOITER_TURNS as u32 as u16;
const LOITER_TIME: u16 = MavCmd::MAV_CMD_NAV_LOITER_TIME as u32 as u16;
const RETURN_TO_LAUNCH: u16 = MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH as u32 as u16;
const TAKEOFF: u16 = MavCmd::MAV_CMD_NAV_TAKEOFF as u32 as u16;
const JUMP: u16 = MavCmd::MAV_CMD_DO_JUMP as u32 as u16;
const CHANGE_SPEED: u16 = MavCmd::MAV_CMD_DO_CHANGE_SPEED as u32 as u16;

/// The mission on board. Item 0 is home, as ArduPilot has it: its contents do not count.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mission {
    pub items: Vec<PlanItem>,
}

impl Mission {
    pub fn len(&self) -> u16 {
        u16::try_from(self.items.len()).unwrap_or(u16::MAX)
    }

    /// Whether there is something to fly.
    pub fn is_flyable(&self) -> bool {
        self.items.len() > 1
    }

    pub fn get(&self, seq: u16) -> Option<&PlanItem> {
        self.items.get(usize::from(seq))
    }
}

/// Whether AUTO can fly an item of a mission of `count` items; the result code that says why not.
pub(crate) fn check(item: &PlanItem, count: u16) -> Result<(), MavMissionResult> {
    let at_place = match item.command {
        WAYPOINT | LOITER_UNLIM | LOITER_TURNS | LOITER_TIME => true,
        RETURN_TO_LAUNCH | TAKEOFF | JUMP | CHANGE_SPEED => false,
        _ => return Err(MavMissionResult::MAV_MISSION_UNSUPPORTED),
    };
    const INVALID: [MavMissionResult; 3] = [
        MavMissionResult::MAV_MISSION_INVALID_PARAM1,
        MavMissionResult::MAV_MISSION_INVALID_PARAM2,
        MavMissionResult::MAV_MISSION_INVALID_PARAM3,
    ];
    // Param 4 is a heading, which ground stations leave NaN.
    if let Some((_, result)) = item.params.iter().zip(INVALID).find(|(param, _)| !param.is_finite()) {
        return Err(result);
    }
    if at_place {
        if item.latitude_e7.unsigned_abs() > 900_000_000 {
            return Err(MavMissionResult::MAV_MISSION_INVALID_PARAM5_X);
        }
        if item.longitude_e7.unsigned_abs() > 1_800_000_000 {
            return Err(MavMissionResult::MAV_MISSION_INVALID_PARAM6_Y);
        }
    }
    if (at_place || item.command == TAKEOFF) && !item.z_m.is_finite() {
        return Err(MavMissionResult::MAV_MISSION_INVALID_PARAM7);
    }
    // Above sea level, home or terrain, each in its old and its new number; or, for what has no place, the mission's own.
    let frame_is_known = matches!(item.frame, 0 | 3 | 5 | 6 | 10 | 11);
    if !frame_is_known && (at_place || item.frame != 2) {
        return Err(MavMissionResult::MAV_MISSION_UNSUPPORTED_FRAME);
    }
    let [p1, p2, ..] = item.params;
    match item.command {
        LOITER_TURNS | LOITER_TIME if p1 < 0.0 => Err(MavMissionResult::MAV_MISSION_INVALID_PARAM1),
        JUMP if !(1.0..f32::from(count)).contains(&p1) => Err(MavMissionResult::MAV_MISSION_INVALID_PARAM1),
        CHANGE_SPEED if p2 <= 0.0 => Err(MavMissionResult::MAV_MISSION_INVALID_PARAM2),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_flown_is_refused_by_its_code() {
        let good = PlanItem {
            command: WAYPOINT,
            frame: 3,
            z_m: 50.0,
            params: [0.0, 0.0, 0.0, f32::NAN],
            ..PlanItem::default()
        };
        assert_eq!(check(&good, 2), Ok(()));
        for (item, result) in [
            (PlanItem { command: 21, ..good }, MavMissionResult::MAV_MISSION_UNSUPPORTED),
            (PlanItem { command: 60_000, ..good }, MavMissionResult::MAV_MISSION_UNSUPPORTED),
            (PlanItem { frame: 1, ..good }, MavMissionResult::MAV_MISSION_UNSUPPORTED_FRAME),
            (PlanItem { frame: 2, ..good }, MavMissionResult::MAV_MISSION_UNSUPPORTED_FRAME),
            (PlanItem { params: [0.0, f32::NAN, 0.0, 0.0], ..good }, MavMissionResult::MAV_MISSION_INVALID_PARAM2),
            (PlanItem { latitude_e7: 900_000_001, ..good }, MavMissionResult::MAV_MISSION_INVALID_PARAM5_X),
            (PlanItem { longitude_e7: i32::MIN, ..good }, MavMissionResult::MAV_MISSION_INVALID_PARAM6_Y),
            (PlanItem { z_m: f32::INFINITY, ..good }, MavMissionResult::MAV_MISSION_INVALID_PARAM7),
            (
                PlanItem { command: JUMP, params: [2.0, 1.0, 0.0, 0.0], ..good },
                MavMissionResult::MAV_MISSION_INVALID_PARAM1,
            ),
            (PlanItem { command: CHANGE_SPEED, ..good }, MavMissionResult::MAV_MISSION_INVALID_PARAM2),
        ] {
            assert_eq!(check(&item, 2), Err(result), "{item:?}");
        }
    }
}
