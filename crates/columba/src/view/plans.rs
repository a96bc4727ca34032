//! Missions, fences, rally points and homes as lines of the picture.

use flight_model::{Geodetic, LocalFrame};
use live_view::Outline;
use mavlink_bridge::dialect::MavCmd;
use mavlink_bridge::{AltitudeDatum, PlanItem};
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};

/// A circle of a fence has so many corners.
const CIRCLE_CORNERS: usize = 48;
/// Beyond so many corners no further vehicle's plans are drawn: a page takes the whole scene at once.
const CORNERS_MAX: usize = 40_000;

/// Places of a plan in the frame of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Reference<'a> {
    /// The frame.
    pub frame: &'a LocalFrame,
    /// North, east and up of its origin in m, if it is known.
    pub home_m: Option<[f64; 3]>,
}

/// What is known of one vehicle's plans.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plans<'a> {
    /// Items of the mission.
    pub mission: &'a [PlanItem],
    /// Items of the fence.
    pub fence: &'a [PlanItem],
    /// Rally points.
    pub rally: &'a [PlanItem],
}

/// The lines of all vehicles, by the vehicles' numbers.
#[derive(Clone, Debug, Default)]
pub struct Outlines {
    kept: BTreeMap<u32, Vec<Outline>>,
    has_changed: bool,
}

impl Outlines {
    /// Sets the lines of a vehicle.
    pub fn set(&mut self, number: u32, outlines: Vec<Outline>) {
        let known = self.kept.entry(number).or_default();
        if *known != outlines {
            *known = outlines;
            self.has_changed = true;
        }
    }

    /// All lines, if any has changed since this was last asked. A line that several vehicles have is one of all.
    pub fn take_changed(&mut self) -> Option<Vec<Outline>> {
        if !std::mem::take(&mut self.has_changed) {
            return None;
        }
        let mut all: Vec<Outline> = Vec::new();
        let mut known: HashMap<(&str, Vec<[u64; 3]>), usize> = HashMap::new();
        let mut corners = 0;
        for outline in self.kept.values().flatten() {
            let bits = outline.points_m.iter().map(|place_m| place_m.map(f64::to_bits)).collect();
            match known.entry((&outline.kind, bits)) {
                Entry::Occupied(same) => {
                    let same = &mut all[*same.get()];
                    same.vehicle = same.vehicle.filter(|number| Some(*number) == outline.vehicle);
                }
                Entry::Vacant(new) if corners <= CORNERS_MAX => {
                    new.insert(all.len());
                    corners += outline.points_m.len();
                    all.push(outline.clone());
                }
                Entry::Vacant(_) => {}
            }
        }
        Some(all)
    }
}

/// The lines of one vehicle.
pub fn outlines(number: u32, at: Reference<'_>, plans: &Plans<'_>) -> Vec<Outline> {
    let line = |kind: &str, points_m: Vec<[f64; 3]>, is_closed: bool| Outline {
        kind: kind.to_owned(),
        vehicle: Some(number),
        points_m,
        is_closed,
    };
    let mut lines: Vec<Outline> = fence(at, plans.fence).map(|(kind, points_m)| line(kind, points_m, true)).collect();
    let mission = mission(at, plans.mission);
    if !mission.is_empty() {
        lines.push(line("mission", mission, false));
    }
    let rally = plans.rally.iter().filter_map(|item| at.place_m(item));
    lines.extend(rally.map(|place_m| line("rally", vec![place_m], false)));
    lines.extend(at.home_m.map(|home_m| line("home", vec![home_m], false)));
    lines
}

/// The way of a mission: items that are flown to. Jumps are not followed.
fn mission(at: Reference<'_>, items: &[PlanItem]) -> Vec<[f64; 3]> {
    let is_return = |item: &PlanItem| item.command == MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH as u16;
    let is_flown_to = |item: &PlanItem| {
        // MAV_CMD_NAV_*, of which a region of interest and a delay are no places to fly to.
        let others = [MavCmd::MAV_CMD_NAV_DELAY as u16, 80];
        item.command <= MavCmd::MAV_CMD_NAV_LAST as u16 && !others.contains(&item.command)
    };
    let place_m = |item: &PlanItem| if is_return(item) { at.home_m } else { at.place_m(item) };
    items.iter().filter(|item| is_flown_to(item)).filter_map(place_m).collect()
}

/// The areas of a fence: within "fence" vehicles must be, within "keep-out" they must not.
fn fence<'a>(at: Reference<'a>, items: &'a [PlanItem]) -> impl Iterator<Item = (&'static str, Vec<[f64; 3]>)> + 'a {
    let mut rest = items;
    std::iter::from_fn(move || {
        loop {
            let item = rest.first()?;
            let is = |command: MavCmd| item.command == command as u16;
            let is_polygon = is(MavCmd::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION)
                || is(MavCmd::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION);
            let is_circle =
                is(MavCmd::MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION) || is(MavCmd::MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION);
            let keeps_in = is(MavCmd::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION)
                || is(MavCmd::MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION);
            // A polygon's corners each say how many there are.
            let corners = if is_polygon { item.params[0] as usize } else { 1 }.clamp(1, rest.len());
            let (area, after) = rest.split_at(corners);
            rest = after;
            let points_m: Vec<[f64; 3]> = match is_circle {
                true => at.place_m(item).map(|centre_m| circle(centre_m, item.params[0])).unwrap_or_default(),
                false if is_polygon => area.iter().filter_map(|corner| at.place_m(corner)).collect(),
                false => Vec::new(),
            };
            if !points_m.is_empty() {
                let on_ground = |[x_m, y_m, _]: [f64; 3]| [x_m, y_m, 0.0];
                let kind = if keeps_in { "fence" } else { "keep-out" };
                return Some((kind, points_m.into_iter().map(on_ground).collect()));
            }
        }
    })
}

fn circle([x_m, y_m, z_m]: [f64; 3], radius_m: f32) -> Vec<[f64; 3]> {
    let corner = |index: usize| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * index as f64 / CIRCLE_CORNERS as f64);
        [x_m + f64::from(radius_m) * cos, y_m + f64::from(radius_m) * sin, z_m]
    };
    if radius_m.is_finite() { (0..CIRCLE_CORNERS).map(corner).collect() } else { Vec::new() }
}

impl Reference<'_> {
    /// Where an item is; none if it has no place.
    fn place_m(&self, item: &PlanItem) -> Option<[f64; 3]> {
        let position = item.position();
        if position.is_zero() || !position.is_valid() {
            return None;
        }
        let (x_m, y_m, _) = self.frame.to_local(&position.to_geodetic(0.0));
        let z_m = if item.z_m.is_finite() { f64::from(item.z_m) } else { 0.0 };
        let home_m = self.home_m.map_or(0.0, |[_, _, up_m]| up_m);
        let up_m = match item.altitude_datum() {
            Some(AltitudeDatum::MeanSeaLevel) => z_m - self.frame.origin().altitude_amsl_m,
            // Terrain is as high as home.
            Some(AltitudeDatum::Home | AltitudeDatum::Terrain) => z_m + home_m,
            None => home_m,
        };
        Some([x_m, y_m, up_m])
    }

    /// A place in the frame.
    pub fn local_m(frame: &LocalFrame, place: &Geodetic) -> [f64; 3] {
        let (x_m, y_m, up_m) = frame.to_local(place);
        [x_m, y_m, up_m]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::LatLonE7;

    const ORIGIN: Geodetic = Geodetic { latitude_deg: 47.4, longitude_deg: 8.5, altitude_amsl_m: 488.0 };

    fn item(command: MavCmd, [x_m, y_m, z_m]: [f64; 3], param_1: f32) -> PlanItem {
        let place = LatLonE7::from_geodetic(&LocalFrame::new(ORIGIN).to_geodetic(x_m, y_m, 0.0));
        PlanItem {
            params: [param_1, 0.0, 0.0, 0.0],
            latitude_e7: place.latitude_e7,
            longitude_e7: place.longitude_e7,
            z_m: z_m as f32,
            command: command as u16,
            frame: 3,
            autocontinue: 1,
        }
    }

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
    }

    #[test]
    fn plans_are_lines_in_the_frame_of_the_picture() {
        use MavCmd::*;
        let frame = LocalFrame::new(ORIGIN);
        let at = Reference { frame: &frame, home_m: Some([5.0, 6.0, 2.0]) };
        let no_place = PlanItem { command: MAV_CMD_DO_JUMP as u16, ..PlanItem::default() };
        let above_sea = PlanItem { frame: 0, ..item(MAV_CMD_NAV_WAYPOINT, [100.0, -50.0, 528.0], 0.0) };
        let back = PlanItem { command: MAV_CMD_NAV_RETURN_TO_LAUNCH as u16, ..PlanItem::default() };
        let corner = |x_m, y_m| item(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, [x_m, y_m, 0.0], 3.0);
        let plans = Plans {
            mission: &[item(MAV_CMD_NAV_TAKEOFF, [0.0, 10.0, 30.0], 0.0), no_place, above_sea, back],
            fence: &[
                corner(-100.0, -100.0),
                corner(300.0, 0.0),
                corner(-100.0, 100.0),
                item(MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, [50.0, 0.0, 0.0], 20.0),
            ],
            rally: &[item(MAV_CMD_NAV_RALLY_POINT, [7.0, 7.0, 40.0], 0.0)],
        };
        let lines = outlines(3, at, &plans);
        let kinds: Vec<_> =
            lines.iter().map(|line| (line.kind.as_str(), line.points_m.len(), line.is_closed)).collect();
        let wanted = [
            ("fence", 3, true),
            ("keep-out", 48, true),
            ("mission", 3, false),
            ("rally", 1, false),
            ("home", 1, false),
        ];
        assert_eq!(kinds, wanted);
        assert!(near(lines[0].points_m[1], [300.0, 0.0, 0.0]) && near(lines[1].points_m[0], [70.0, 0.0, 0.0]));
        assert!(near(lines[2].points_m[0], [0.0, 10.0, 32.0]), "above home, which is 2 m above the origin");
        assert!(near(lines[2].points_m[1], [100.0, -50.0, 40.0]) && near(lines[2].points_m[2], [5.0, 6.0, 2.0]));
    }

    #[test]
    fn what_several_vehicles_have_is_one_line_of_all() {
        let line = |kind: &str, vehicle: u32, x_m: f64| Outline {
            kind: kind.to_owned(),
            vehicle: Some(vehicle),
            points_m: vec![[x_m, 0.0, 0.0]],
            is_closed: true,
        };
        let mut all = Outlines::default();
        all.set(1, vec![line("fence", 1, 5.0), line("mission", 1, 1.0)]);
        all.set(2, vec![line("fence", 2, 5.0), line("mission", 2, 2.0)]);
        let taken = all.take_changed().unwrap();
        let whose: Vec<_> = taken.iter().map(|line| (line.kind.as_str(), line.vehicle)).collect();
        assert_eq!(whose, [("fence", None), ("mission", Some(1)), ("mission", Some(2))]);
        all.set(2, vec![line("fence", 2, 5.0), line("mission", 2, 2.0)]);
        assert_eq!(all.take_changed(), None);
    }
}
