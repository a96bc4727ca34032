//! Which missions a PX4 fixed wing does not fly, though it takes them, and what it says of them: the checks of
//! `FeasibilityChecker.cpp` and `mission_feasibility_checker.cpp`, in their order.

use mavlink_bridge::PlanItem;
use nalgebra::Vector2;

const WAYPOINT: u16 = 16;
const RETURN_TO_LAUNCH: u16 = 20;
const LAND: u16 = 21;
const TAKEOFF: u16 = 22;
const LOITER_TO_ALTITUDE: u16 = 31;
const VTOL_TAKEOFF: u16 = 84;
const VTOL_LAND: u16 = 85;
const VTOL_TRANSITION: u16 = 3000;
const LAND_START: u16 = 189;
const GATE: u16 = 4501;
/// What an upload lets through, and a mission has not.
const FENCE_RETURN_POINT: u16 = 5000;
/// Items with a position, of which distances and fences are asked (`mission_item_utils.h`).
const WITH_POSITION: [u16; 8] = [WAYPOINT, 17, 19, LAND, TAKEOFF, LOITER_TO_ALTITUDE, VTOL_TAKEOFF, VTOL_LAND];
/// Items that a take-off may come after. Jumps, delays, speeds, cameras and their kin have no place.
const BEFORE_TAKEOFF: [u16; 29] = [
    80, 93, 112, 177, 178, 179, 189, 195, 196, 197, 200, 201, 203, 204, 205, 206, 214, 260, 530, 532, 534, 1000, 1001,
    2000, 2001, 2003, 2500, 2501, 3000,
];
/// A gate so near to a waypoint has no direction, m.
const GATE_DISTANCE_M: f64 = 0.05;
/// What the slope of a landing may be steeper than asked for, degrees.
const SLOPE_TOLERANCE_DEG: f64 = 0.1;

/// What a mission is judged by.
pub(crate) struct Conditions<'a> {
    pub is_landed: bool,
    /// MIS_TKO_LAND_REQ.
    pub requirements: u8,
    /// FW_LND_ANG.
    pub landing_angle_deg: f64,
    /// MIS_DIST_1WP; not above 0: no bound.
    pub first_distance_max_m: f64,
    /// (north, east) in m.
    pub home: Vector2<f64>,
    /// Where an item is, (north, east) in m.
    pub place: &'a dyn Fn(&PlanItem) -> Vector2<f64>,
    /// How high an item is, m.
    pub above_home_m: &'a dyn Fn(&PlanItem) -> f64,
    /// Whether an item is outside the fence.
    pub is_outside: &'a dyn Fn(&PlanItem) -> bool,
}

/// Whether a mission is flown, and what is said of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Verdict {
    pub is_flyable: bool,
    pub texts: Vec<String>,
}

/// Judges a mission. Of several faults of one kind the first is told; an item that is not valid ends it.
pub(crate) fn judge(items: &[PlanItem], conditions: &Conditions<'_>) -> Verdict {
    let mut texts = Vec::new();
    let mut checks = Checks::default();
    let mut is_whole = true;
    for (seq, item) in items.iter().enumerate() {
        if let Err(reason) = check_validity(seq, item, conditions) {
            texts.push(reason);
            is_whole = false;
            break;
        }
        for check in CHECKS {
            texts.extend(check(&mut checks, (seq, item), items, conditions));
        }
    }
    let mut is_flyable = is_whole && checks.failed == [false; 5];
    if is_whole && !items.is_empty() {
        let lacks = lacking(&checks, conditions);
        is_flyable &= lacks.is_none();
        texts.extend(lacks.map(str::to_owned));
    }
    let is_outside = |item: &&PlanItem| has_position(item) && (conditions.is_outside)(item);
    if let Some(seq) = items.iter().position(|item| is_outside(&item)) {
        texts.push(format!("Geofence violation for waypoint {}", seq + 1));
        is_flyable = false;
    }
    Verdict { is_flyable, texts }
}

/// What is remembered from item to item.
#[derive(Debug, Default)]
struct Checks {
    failed: [bool; 5],
    last: Option<(Vector2<f64>, u16)>,
    has_first: bool,
    has_takeoff: bool,
    has_place: bool,
    land_start: Option<usize>,
    /// The item before the last landing.
    approach: Option<usize>,
    has_landing: bool,
}

type Check = fn(&mut Checks, (usize, &PlanItem), &[PlanItem], &Conditions<'_>) -> Vec<String>;

/// What is asked of each item, in this order.
const CHECKS: [Check; 6] = [gates, first_distance, takeoff, vehicle, land_pattern, land_approach];

/// Each check stops at its first fault.
#[derive(Clone, Copy)]
enum Fault {
    Gate,
    Takeoff,
    Vehicle,
    Pattern,
    Approach,
}

impl Checks {
    fn has_failed(&self, fault: Fault) -> bool {
        self.failed[fault as usize]
    }

    fn fail(&mut self, fault: Fault, text: impl Into<String>) -> Vec<String> {
        self.failed[fault as usize] = true;
        vec![text.into()]
    }
}

fn has_position(item: &PlanItem) -> bool {
    WITH_POSITION.contains(&item.command)
}

fn check_validity(seq: usize, item: &PlanItem, conditions: &Conditions<'_>) -> Result<(), String> {
    if item.command == FENCE_RETURN_POINT {
        return Err(format!("Mission rejected: item {}: unsupported cmd: {}", seq + 1, item.command));
    }
    if seq == 0 && item.command == LAND && conditions.is_landed {
        return Err("Mission rejected: starts with landing".to_owned());
    }
    Ok(())
}

fn gates(
    checks: &mut Checks,
    (_, item): (usize, &PlanItem),
    _: &[PlanItem],
    conditions: &Conditions<'_>,
) -> Vec<String> {
    if checks.has_failed(Fault::Gate) || !has_position(item) {
        return Vec::new();
    }
    let place = (conditions.place)(item);
    if let Some((last, command)) = checks.last
        && (last - place).norm() < GATE_DISTANCE_M
        && (item.command == GATE || command == GATE)
    {
        return checks.fail(Fault::Gate, "Distance between waypoint and gate too close: 0 meters");
    }
    checks.last = Some((place, item.command));
    Vec::new()
}

/// A warning alone.
fn first_distance(
    checks: &mut Checks,
    (_, item): (usize, &PlanItem),
    _: &[PlanItem],
    conditions: &Conditions<'_>,
) -> Vec<String> {
    let most_m = conditions.first_distance_max_m;
    if checks.has_first || most_m <= 0.0 || !has_position(item) {
        return Vec::new();
    }
    checks.has_first = true;
    let distance_m = ((conditions.place)(item) - conditions.home).norm();
    if distance_m < most_m {
        return Vec::new();
    }
    vec![format!("First waypoint far away from home: {}m. Correct mission loaded?", distance_m as i64)]
}

fn takeoff(
    checks: &mut Checks,
    (_, item): (usize, &PlanItem),
    _: &[PlanItem],
    conditions: &Conditions<'_>,
) -> Vec<String> {
    if checks.has_failed(Fault::Takeoff) {
        return Vec::new();
    }
    if matches!(item.command, TAKEOFF | VTOL_TAKEOFF) {
        if (conditions.above_home_m)(item) < f64::from(f32::EPSILON) {
            return checks.fail(Fault::Takeoff, "Mission rejected: Takeoff altitude below home altitude!");
        }
        checks.has_takeoff = true;
        if checks.has_place {
            return checks.fail(Fault::Takeoff, "Mission rejected: takeoff not first waypoint item");
        }
    }
    checks.has_place |= !BEFORE_TAKEOFF.contains(&item.command);
    Vec::new()
}

fn vehicle(checks: &mut Checks, (_, item): (usize, &PlanItem), _: &[PlanItem], _: &Conditions<'_>) -> Vec<String> {
    if checks.has_failed(Fault::Vehicle) || !matches!(item.command, VTOL_TAKEOFF | VTOL_LAND | VTOL_TRANSITION) {
        return Vec::new();
    }
    checks.fail(Fault::Vehicle, "Mission rejected: Mission contains VTOL items but vehicle is not a VTOL")
}

/// DO_LAND_START: one, with a landing behind it and no return.
fn land_pattern(
    checks: &mut Checks,
    (seq, item): (usize, &PlanItem),
    items: &[PlanItem],
    _: &Conditions<'_>,
) -> Vec<String> {
    if checks.has_failed(Fault::Pattern) {
        return Vec::new();
    }
    match item.command {
        LAND_START if checks.land_start.is_some() => {
            return checks.fail(Fault::Pattern, "Mission rejected: more than one land start.");
        }
        LAND_START => checks.land_start = Some(seq),
        LAND | VTOL_LAND if seq == 0 => {
            return checks.fail(Fault::Pattern, "Mission rejected: starts with land waypoint.");
        }
        LAND | VTOL_LAND => checks.approach = Some(seq - 1),
        RETURN_TO_LAUNCH if checks.land_start.is_some() => {
            return checks.fail(Fault::Pattern, "Mission rejected: land start item before RTL item not possible.");
        }
        _ => {}
    }
    let is_last = seq + 1 == items.len();
    if is_last && checks.land_start.is_some_and(|start| checks.approach.is_none_or(|approach| start > approach)) {
        return checks.fail(Fault::Pattern, "Mission rejected: invalid land start.");
    }
    checks.has_landing = checks.approach.is_some();
    Vec::new()
}

/// A landing comes down from a waypoint or a loiter to altitude, not too steeply.
fn land_approach(
    checks: &mut Checks,
    (seq, item): (usize, &PlanItem),
    items: &[PlanItem],
    conditions: &Conditions<'_>,
) -> Vec<String> {
    let entrance = seq.checked_sub(1).and_then(|before| items.get(before)).filter(|before| has_position(before));
    let Some(entrance) = entrance.filter(|_| item.command == LAND && !checks.has_failed(Fault::Approach)) else {
        return Vec::new();
    };
    let height_m = (conditions.above_home_m)(entrance) - (conditions.above_home_m)(item);
    if height_m < f64::from(f32::EPSILON) {
        let text = "Mission rejected: the approach waypoint must be above the landing point.";
        return checks.fail(Fault::Approach, text);
    }
    let between_m = ((conditions.place)(entrance) - (conditions.place)(item)).norm();
    let distance_m = match entrance.command {
        LOITER_TO_ALTITUDE => {
            let radius_m = f64::from(entrance.params[1].abs());
            if between_m <= radius_m {
                let text = "Mission rejected: the landing point must be outside the orbit radius.";
                return checks.fail(Fault::Approach, text);
            }
            (between_m * between_m - radius_m * radius_m).sqrt()
        }
        WAYPOINT => between_m,
        _ => {
            let text = "Mission rejected: unsupported landing approach entrance waypoint type. Only ORBIT_TO_ALT or \
                        WAYPOINT allowed.";
            return checks.fail(Fault::Approach, text);
        }
    };
    let angle_deg = conditions.landing_angle_deg;
    let steepest = libm::tan((angle_deg + SLOPE_TOLERANCE_DEG).to_radians());
    if height_m / distance_m <= steepest {
        checks.has_landing = true;
        return Vec::new();
    }
    let text = format!(
        "Mission rejected: the landing glide slope is steeper than the vehicle setting of {}.{} degrees.",
        angle_deg as u8,
        ((angle_deg - angle_deg.floor()) * 10.0) as u8
    );
    let mut texts = checks.fail(Fault::Approach, text);
    texts.push(format!(
        "Reduce the glide slope, lower the entrance altitude {} meters, or increase the landing approach distance {} \
         meters.",
        (steepest * distance_m) as u32,
        (height_m / steepest).ceil() as u32
    ));
    texts
}

/// What MIS_TKO_LAND_REQ asks for and is not there.
fn lacking(checks: &Checks, conditions: &Conditions<'_>) -> Option<&'static str> {
    let (has_takeoff, has_landing) = (checks.has_takeoff, checks.has_landing);
    let either = match (has_takeoff, has_landing) {
        (true, false) => Some("Mission rejected: Add Landing item or remove Takeoff."),
        (false, true) => Some("Mission rejected: Add Takeoff item or remove Landing."),
        _ => None,
    };
    match conditions.requirements {
        1 => (!has_takeoff).then_some("Mission rejected: Takeoff waypoint required."),
        2 => (!has_landing).then_some("Mission rejected: Landing waypoint/pattern required."),
        3 => (!has_takeoff || !has_landing).then_some("Mission rejected: Takeoff or Landing item missing."),
        4 => either,
        5 if conditions.is_landed => either,
        5 => (!has_landing).then_some("Mission rejected: Landing waypoint/pattern required."),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Items 500 m apart on a line, 50 m high, landings at 10 m.
    fn mission(commands: &[u16]) -> Vec<PlanItem> {
        let item = |(seq, command): (usize, &u16)| PlanItem {
            command: *command,
            latitude_e7: 500 * seq as i32,
            z_m: if *command == LAND { 10.0 } else { 50.0 },
            ..PlanItem::default()
        };
        commands.iter().enumerate().map(item).collect()
    }

    fn judged(items: &[PlanItem], requirements: u8, is_landed: bool) -> Verdict {
        judge(
            items,
            &Conditions {
                is_landed,
                requirements,
                landing_angle_deg: 5.0,
                first_distance_max_m: 10_000.0,
                home: Vector2::zeros(),
                place: &|item| Vector2::new(f64::from(item.latitude_e7), 0.0),
                above_home_m: &|item| f64::from(item.z_m),
                is_outside: &|item| item.latitude_e7 > 100_000,
            },
        )
    }

    fn verdict(commands: &[u16]) -> Vec<String> {
        judged(&mission(commands), 0, true).texts
    }

    #[test]
    fn a_mission_that_a_fixed_wing_does_not_fly_is_rejected_in_words() {
        for (commands, why) in [
            (&[21, 16][..], "starts with landing"),
            (&[16, 5000, 16], "item 2: unsupported cmd: 5000"),
            (&[16, 22], "takeoff not first waypoint item"),
            (&[22, 189, 16, 189, 16, 21], "more than one land start."),
            (&[22, 189, 20], "land start item before RTL item not possible."),
            (&[22, 16, 21, 189], "invalid land start."),
            (&[84, 16], "Mission contains VTOL items but vehicle is not a VTOL"),
            (
                &[22, 17, 21],
                "unsupported landing approach entrance waypoint type. Only ORBIT_TO_ALT or WAYPOINT allowed.",
            ),
        ] {
            assert_eq!(verdict(commands)[0], format!("Mission rejected: {why}"), "{commands:?}");
            assert!(!judged(&mission(commands), 0, true).is_flyable);
        }
        let low = [PlanItem { command: 22, ..PlanItem::default() }];
        assert!(!judged(&low, 0, true).is_flyable);
        assert_eq!(judged(&mission(&[21]), 0, false).texts, ["Mission rejected: starts with land waypoint."]);
    }

    #[test]
    fn others_are_flown() {
        for commands in [&[][..], &[178, 22, 16, 189, 31, 21], &[16, 17], &[2000, 206, 22, 20], &[22, 16, 93, 21]] {
            assert_eq!(
                judged(&mission(commands), 0, true),
                Verdict { is_flyable: true, texts: vec![] },
                "{commands:?}"
            );
        }
    }

    #[test]
    fn a_landing_comes_down_gently_from_outside_its_circle() {
        let mut items = mission(&[22, 16, 21]);
        items[1].z_m = 60.0;
        let steep = judged(&items, 0, true);
        assert!(!steep.is_flyable);
        assert!(steep.texts[0].ends_with("steeper than the vehicle setting of 5.0 degrees."), "{:?}", steep.texts);
        assert!(steep.texts[1].contains("altitude 44 meters") && steep.texts[1].contains("distance 561 meters"));
        items[1].z_m = 10.0;
        assert!(judged(&items, 0, true).texts[0].contains("must be above the landing point"));
        let mut circle = mission(&[22, 31, 21]);
        circle[1].params[1] = -600.0;
        assert!(judged(&circle, 0, true).texts[0].contains("outside the orbit radius"));
    }

    #[test]
    fn what_is_required_is_asked_for() {
        for (requirements, is_landed, commands, is_flyable) in [
            (1, true, &[16, 16][..], false),
            (1, true, &[22, 16], true),
            (2, true, &[22, 16], false),
            (2, true, &[16, 16, 21], true),
            (3, true, &[22, 16], false),
            (3, true, &[22, 16, 21], true),
            (4, true, &[16, 16], true),
            (4, true, &[22, 16], false),
            (4, true, &[16, 16, 21], false),
            (5, true, &[16, 16], true),
            (5, false, &[16, 16], false),
        ] {
            let verdict = judged(&mission(commands), requirements, is_landed);
            assert_eq!(verdict.is_flyable, is_flyable, "{requirements} {commands:?}");
            assert_eq!(verdict.texts.len(), usize::from(!is_flyable));
        }
    }

    #[test]
    fn far_away_is_a_warning_and_outside_the_fence_is_not() {
        let mut items = mission(&[16]);
        items[0].latitude_e7 = 20_000;
        let far = judged(&items, 0, true);
        assert_eq!(far.texts, ["First waypoint far away from home: 20000m. Correct mission loaded?"]);
        assert!(far.is_flyable);
        items[0].latitude_e7 = 200_000;
        assert!(judged(&items, 0, true).texts.contains(&"Geofence violation for waypoint 1".to_owned()));
        assert!(!judged(&items, 0, true).is_flyable);
    }
}
