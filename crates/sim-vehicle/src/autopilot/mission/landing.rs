//! Landing sequences of a mission: where they start, how RTL and commands get there, and going around.

use super::items::{CHANGE_ALTITUDE, GO_AROUND, LAND, LAND_START, RETURN_PATH_START, WAYPOINT, has_place};
use super::legs::Leg;
use crate::autopilot::Autopilot;
use crate::error::{CommandError, Severity};
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use mavlink_bridge::PlanItem;
use nalgebra::Vector2;

/// Height to which a landing that is given up climbs where nothing else is said, m: ArduPlane's.
const GO_AROUND_HEIGHT_M: f64 = 30.0;
/// RTL has come back when it is so near to its circle and to its altitude, m: the latter is ArduPlane's.
const RTL_TOLERANCE_M: f64 = 10.0;

impl Autopilot {
    /// DO_LAND_START as a command: AUTO, from the nearest such item on.
    pub(crate) fn start_landing(&mut self) -> Result<(), CommandError> {
        let Some(seq) = self.nearest_of(LAND_START) else {
            return Err(CommandError::failed("Unable to start landing sequence"));
        };
        self.go_on_in_auto(seq, "Landing sequence start");
        Ok(())
    }

    /// DO_RETURN_PATH_START as a command: AUTO, on the nearest leg after such an item.
    pub(crate) fn start_return_path(&mut self) -> Result<(), CommandError> {
        let Some(seq) = self.nearest_return_leg() else {
            return Err(CommandError::failed("Mission has no return path"));
        };
        self.go_on_in_auto(seq, "Return path started");
        Ok(())
    }

    /// DO_GO_AROUND as a command: gives up the landing. Param 1: m above home to climb to, 0 for what the mission says.
    pub(crate) fn go_around(&mut self, height_m: f32) -> Result<(), CommandError> {
        if self.mode() != Mode::Auto {
            return Err(CommandError::failed(format!("Go around: mode is {}", self.mode())));
        }
        let land = self.mission.get(self.session.progress.current()).copied().filter(|item| item.command == LAND);
        let Some(land) = land.filter(|_| !self.flight.is_on_ground()) else {
            return Err(CommandError::failed("Go around: it is not landing"));
        };
        if !height_m.is_finite() {
            return Err(CommandError::denied("Go around: param 1 is not finite"));
        }
        if let Some(seq) = self.nearest_of(GO_AROUND) {
            self.go_on_in_auto(seq, "Landing abort sequence start");
            return Ok(());
        }
        let wanted_m = [height_m, land.params[0]].into_iter().find(|height_m| *height_m > 0.0);
        let height_m = wanted_m.map_or(GO_AROUND_HEIGHT_M, f64::from);
        let altitude_m = (self.flight.home().altitude_m + height_m).max(self.flight.state().altitude_m);
        self.flight.take_off(altitude_m);
        self.session.progress.leg = Leg::GoAround(altitude_m);
        self.say(Severity::Notice, &format!("Landing aborted, climbing to {height_m:.0}m"));
        Ok(())
    }

    /// After a landing that was given up: the climb that follows it in the mission, or the landing sequence, or the
    /// waypoint before it, again.
    pub(super) fn restart_landing(&mut self) {
        let land = self.session.progress.current();
        let climbs = |item: &&PlanItem| item.command == CHANGE_ALTITUDE && item.params[0] < 2.0;
        let climb = self.mission.get(land + 1).filter(climbs).map(|_| land + 1);
        let before = self.mission.numbered().filter(|(seq, item)| *seq < land && item.command == WAYPOINT).last();
        let before = before.map(|(seq, _)| seq);
        match climb.or_else(|| self.nearest_of(LAND_START)).or(before) {
            Some(seq) => self.session.progress.go_to(seq),
            None => self.set_mode(Mode::Rtl),
        }
    }

    /// In RTL, RTL_AUTOLAND: 1 lands when it has come back, 2 at once, both by the nearest DO_LAND_START; 4 joins the
    /// nearest leg of a return path.
    pub(super) fn look_for_landing(&mut self) {
        let autoland = self.parameters.get(Parameter::RtlAutoland) as u8;
        if self.session.progress.has_looked_for_landing() || !self.flight.is_armed() || matches!(autoland, 0 | 3) {
            return;
        }
        if autoland == 1 && !self.has_come_back() {
            return;
        }
        let to = if autoland == 4 { self.nearest_return_leg() } else { self.nearest_of(LAND_START) };
        match to {
            Some(seq) => self.go_on_in_auto(seq, "Landing sequence start"),
            None => self.session.progress.found_no_landing(),
        }
    }

    fn has_come_back(&self) -> bool {
        let (state, home) = (self.flight.estimate(), self.flight.home());
        let distance_m = (state.position_m() - home.at()).norm();
        distance_m <= self.flight.tuning().rtl_radius_m.abs() + RTL_TOLERANCE_M
            && self.flight.altitude_error_m() <= RTL_TOLERANCE_M
    }

    fn go_on_in_auto(&mut self, seq: u16, text: &str) {
        self.say(Severity::Info, text);
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
            Some((seq, self.flight.distance_m(self.reference().place_of(item, self.flight.here()))))
        });
        placed.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(seq, _)| seq)
    }

    /// The end of the leg, from one place to the next after a DO_RETURN_PATH_START and up to a landing, that is
    /// nearest.
    fn nearest_return_leg(&self) -> Option<u16> {
        let mut nearest: Option<(u16, f64)> = None;
        let mut from: Option<Vector2<f64>> = None;
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
            let to = self.reference().place_of(item, self.flight.here());
            let distance_m = self.flight.distance_m(nearest_point(from.unwrap_or(to), to, self.flight.here()));
            if item.command != RETURN_PATH_START && nearest.is_none_or(|(_, least_m)| distance_m < least_m) {
                nearest = Some((seq, distance_m));
            }
            from = Some(to);
            is_on_path = item.command != LAND;
        }
        nearest.map(|(seq, _)| seq)
    }
}

fn is_placed(item: &PlanItem) -> bool {
    has_place(item.command) && (item.latitude_e7, item.longitude_e7) != (0, 0)
}

/// The point of a straight leg that is nearest to a place.
fn nearest_point(from: Vector2<f64>, to: Vector2<f64>, place: Vector2<f64>) -> Vector2<f64> {
    let leg = to - from;
    let length_squared = leg.norm_squared();
    if length_squared <= 0.0 {
        return from;
    }
    let share = (place - from).dot(&leg) / length_squared;
    let share = share.clamp(0.0, 1.0);
    from + leg * share
}
