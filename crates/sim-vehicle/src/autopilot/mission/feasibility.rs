//! Which missions a PX4 fixed wing does not fly, though it takes them (`FeasibilityChecker.cpp`).
//!
//! What it also asks of landings (a slope within FW_LND_ANG, MIS_TKO_LAND_REQ) is not asked here.

use mavlink_bridge::PlanItem;

const RETURN_TO_LAUNCH: u16 = 20;
const LAND: u16 = 21;
const TAKEOFF: u16 = 22;
const VTOL: [u16; 3] = [84, 85, 3000];
const LAND_START: u16 = 189;
/// Items that a take-off may come after. Jumps, delays, speeds, cameras and their kin have no place.
const WITHOUT_POSITION: [u16; 27] = [
    93, 112, 177, 178, 179, 189, 195, 196, 197, 200, 201, 203, 204, 205, 206, 214, 260, 530, 532, 534, 1000, 1001,
    2000, 2001, 2003, 2500, 2501,
];

/// Why a mission is not flown. `above_home_m` gives an item's altitude above home.
pub(crate) fn check(
    items: &[PlanItem],
    is_landed: bool,
    above_home_m: impl Fn(&PlanItem) -> f64,
) -> Result<(), String> {
    let reject = |why: &str| Err(format!("Mission rejected: {why}"));
    let mut has_position = false;
    let mut land_start = None;
    let mut landing = None;
    for (seq, item) in items.iter().enumerate() {
        match item.command {
            LAND if seq == 0 && is_landed => return reject("starts with landing"),
            LAND if seq == 0 => return reject("starts with land waypoint."),
            LAND => landing = Some(seq),
            TAKEOFF if above_home_m(item) <= 0.0 => return reject("Takeoff altitude below home altitude!"),
            TAKEOFF if has_position => return reject("takeoff not first waypoint item"),
            LAND_START if land_start.is_some() => return reject("more than one land start."),
            LAND_START => land_start = Some(seq),
            RETURN_TO_LAUNCH if land_start.is_some() => return reject("land start item before RTL item not possible."),
            command if VTOL.contains(&command) => return reject("it has VTOL items, and this is no VTOL"),
            _ => {}
        }
        has_position |= !WITHOUT_POSITION.contains(&item.command);
    }
    if land_start.is_some_and(|start| landing.is_none_or(|landing| landing < start)) {
        return reject("invalid land start.");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mission(commands: &[u16]) -> Vec<PlanItem> {
        commands.iter().map(|command| PlanItem { command: *command, z_m: 50.0, ..PlanItem::default() }).collect()
    }

    fn verdict(commands: &[u16]) -> Option<String> {
        check(&mission(commands), true, |item| f64::from(item.z_m)).err()
    }

    #[test]
    fn a_mission_that_a_fixed_wing_does_not_fly_is_rejected_in_words() {
        for (commands, why) in [
            (&[21, 16][..], "starts with landing"),
            (&[16, 22], "takeoff not first waypoint item"),
            (&[22, 189, 16, 189, 21], "more than one land start."),
            (&[22, 189, 20], "land start item before RTL item not possible."),
            (&[22, 21, 189], "invalid land start."),
            (&[84, 16], "it has VTOL items, and this is no VTOL"),
        ] {
            assert_eq!(verdict(commands), Some(format!("Mission rejected: {why}")), "{commands:?}");
        }
        let low = [PlanItem { command: 22, ..PlanItem::default() }];
        assert!(check(&low, true, |item| f64::from(item.z_m)).is_err());
    }

    #[test]
    fn others_are_flown() {
        for commands in [&[][..], &[178, 22, 16, 189, 31, 21], &[16, 17], &[2000, 206, 22, 20]] {
            assert_eq!(verdict(commands), None, "{commands:?}");
        }
    }
}
