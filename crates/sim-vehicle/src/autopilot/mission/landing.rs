//! Landing sequences of a mission: where they start, how RTL and commands get there, and going around.

use super::items::{CHANGE_ALTITUDE, GO_AROUND, LAND, LAND_START, RETURN_PATH_START, WAYPOINT, has_place};
use super::legs::Leg;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::protocol::command::Refusal;
use crate::vehicle::Vehicle;
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::MavSeverity;

/// Height to which a landing that is given up climbs where nothing else is said, m: ArduPlane's.
const GO_AROUND_HEIGHT_M: f64 = 30.0;
/// RTL has come back when it is so near to its circle and to its altitude, m: the latter is ArduPlane's.
const RTL_TOLERANCE_M: f64 = 10.0;

impl Vehicle {
    /// DO_LAND_START as a command: AUTO, from the nearest such item on.
    pub(crate) fn start_landing(&mut self) -> Result<(), Refusal> {
        let Some(seq) = self.nearest_of(LAND_START) else {
            return Err(Refusal::failed("Unable to start landing sequence"));
        };
        self.go_on_in_auto(seq, "Landing sequence start");
        Ok(())
    }

    /// DO_RETURN_PATH_START as a command: AUTO, on the nearest leg after such an item.
    pub(crate) fn start_return_path(&mut self) -> Result<(), Refusal> {
        let Some(seq) = self.nearest_return_leg() else {
            return Err(Refusal::failed("Mission has no return path"));
        };
        self.go_on_in_auto(seq, "Return path started");
        Ok(())
    }

    /// DO_GO_AROUND as a command: gives up the landing. Param 1: m above home to climb to, 0 for what the mission says.
    pub(crate) fn go_around(&mut self, height_m: f32) -> Result<(), Refusal> {
        if self.mode() != Mode::Auto {
            return Err(Refusal::failed(format!("Go around: mode is {}", self.mode())));
        }
        let land = self.mission.get(self.progress.current).copied().filter(|item| item.command == LAND);
        let Some(land) = land.filter(|_| !self.flight.is_on_ground()) else {
            return Err(Refusal::failed("Go around: it is not landing"));
        };
        if !height_m.is_finite() {
            return Err(Refusal::denied("Go around: param 1 is not finite"));
        }
        if let Some(seq) = self.nearest_of(GO_AROUND) {
            self.go_on_in_auto(seq, "Landing abort sequence start");
            return Ok(());
        }
        let wanted_m = [height_m, land.params[0]].into_iter().find(|height_m| *height_m > 0.0);
        let height_m = wanted_m.map_or(GO_AROUND_HEIGHT_M, f64::from);
        let altitude_m = (self.flight.home().altitude_m + height_m).max(self.flight.state().altitude_m);
        self.flight.take_off(altitude_m);
        self.progress.leg = Leg::GoAround(altitude_m);
        self.say(MavSeverity::MAV_SEVERITY_NOTICE, &format!("Landing aborted, climbing to {height_m:.0}m"));
        Ok(())
    }

    /// After a landing that was given up: the climb that follows it in the mission, or the landing sequence, or the
    /// waypoint before it, again.
    pub(super) fn restart_landing(&mut self) {
        let land = self.progress.current;
        let climbs = |item: &&PlanItem| item.command == CHANGE_ALTITUDE && item.params[0] < 2.0;
        let climb = self.mission.get(land + 1).filter(climbs).map(|_| land + 1);
        let before = self.mission.numbered().filter(|(seq, item)| *seq < land && item.command == WAYPOINT).last();
        let before = before.map(|(seq, _)| seq);
        match climb.or_else(|| self.nearest_of(LAND_START)).or(before) {
            Some(seq) => self.go_to(seq),
            None => self.set_mode(Mode::Rtl),
        }
    }

    /// In RTL, RTL_AUTOLAND: 1 lands when it has come back, 2 at once, both by the nearest DO_LAND_START; 4 joins the
    /// nearest leg of a return path.
    pub(super) fn look_for_landing(&mut self) {
        let autoland = self.parameters.get(Parameter::RtlAutoland) as u8;
        if self.progress.has_looked_for_landing || !self.flight.is_armed() || matches!(autoland, 0 | 3) {
            return;
        }
        if autoland == 1 && !self.has_come_back() {
            return;
        }
        let to = if autoland == 4 { self.nearest_return_leg() } else { self.nearest_of(LAND_START) };
        match to {
            Some(seq) => self.go_on_in_auto(seq, "Landing sequence start"),
            None => self.progress.has_looked_for_landing = true,
        }
    }

    fn has_come_back(&self) -> bool {
        let (state, home) = (self.flight.estimate(), self.flight.home());
        let (north, east) = (state.x_m - home.x_m, state.y_m - home.y_m);
        let distance_m = (north * north + east * east).sqrt();
        distance_m <= self.flight.tuning().rtl_radius_m.abs() + RTL_TOLERANCE_M
            && self.flight.altitude_error_m() <= RTL_TOLERANCE_M
    }

    fn go_on_in_auto(&mut self, seq: u16, text: &str) {
        self.say(MavSeverity::MAV_SEVERITY_INFO, text);
        // It has been looked up: it is there.
        if self.set_current_item(seq, false).is_ok() {
            self.set_mode(Mode::Auto);
        }
    }

    /// The first DO_LAND_START; without one, the first landing.
    pub(crate) fn mission_landing(&self) -> Option<u16> {
        let first =
            |command: u16| self.mission.numbered().find(|(_, item)| item.command == command).map(|(seq, _)| seq);
        first(LAND_START).or_else(|| first(LAND))
    }

    /// The nearest item of a kind; one without a place is where the next one with a place is.
    fn nearest_of(&self, command: u16) -> Option<u16> {
        let marks = self.mission.numbered().filter(|(_, item)| item.command == command);
        let placed = marks.filter_map(|(seq, _)| {
            let (_, item) = self.mission.numbered().find(|(at, item)| *at >= seq && is_placed(item))?;
            Some((seq, self.distance_m(self.place_of(item))))
        });
        placed.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(seq, _)| seq)
    }

    /// The end of the leg, from one place to the next after a DO_RETURN_PATH_START and up to a landing, that is nearest.
    fn nearest_return_leg(&self) -> Option<u16> {
        let mut nearest: Option<(u16, f64)> = None;
        let mut from: Option<(f64, f64)> = None;
        let mut is_on_path = false;
        for (seq, item) in self.mission.numbered() {
            match item.command {
                RETURN_PATH_START => (is_on_path, from) = (true, None),
                LAND_START => is_on_path = false,
                _ => {}
            }
            if !is_on_path || !is_placed(item) {
                continue;
            }
            let to = self.place_of(item);
            let distance_m = self.distance_m(nearest_point(from.unwrap_or(to), to, self.here()));
            if item.command != RETURN_PATH_START && nearest.is_none_or(|(_, least_m)| distance_m < least_m) {
                nearest = Some((seq, distance_m));
            }
            from = Some(to);
            is_on_path = item.command != LAND;
        }
        nearest.map(|(seq, _)| seq)
    }

    pub(super) fn distance_m(&self, (x_m, y_m): (f64, f64)) -> f64 {
        let (x0_m, y0_m) = self.here();
        ((x_m - x0_m) * (x_m - x0_m) + (y_m - y0_m) * (y_m - y0_m)).sqrt()
    }
}

fn is_placed(item: &PlanItem) -> bool {
    has_place(item.command) && (item.latitude_e7, item.longitude_e7) != (0, 0)
}

/// The point of a straight leg that is nearest to a place.
fn nearest_point(from: (f64, f64), to: (f64, f64), place: (f64, f64)) -> (f64, f64) {
    let (north, east) = (to.0 - from.0, to.1 - from.1);
    let length_squared = north * north + east * east;
    if length_squared <= 0.0 {
        return from;
    }
    let share = ((place.0 - from.0) * north + (place.1 - from.1) * east) / length_squared;
    let share = share.clamp(0.0, 1.0);
    (from.0 + share * north, from.1 + share * east)
}
