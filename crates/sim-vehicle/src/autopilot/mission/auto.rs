//! AUTO: one item after the other.

use super::items::{
    CHANGE_ALTITUDE, JUMP, JUMP_TO_TAG, LAND, LOITER_TIME, LOITER_TO_ALTITUDE, LOITER_TURNS, LOITER_UNLIM,
    RETURN_TO_LAUNCH, TAKEOFF, WAYPOINT, has_place, is_flown_to, is_jump,
};
use super::legs::{AltitudeEnd, Leg, is_beyond};
use super::loiter::{Exit, Goal, Loiter, PX4_ALTITUDE_M, Rules};
use super::names;
use crate::autopilot::event::Event;
use crate::autopilot::flight::tuning::TAKEOFF_TOLERANCE_M;
use crate::autopilot::{Autopilot, MISSION_COMPLETE};
use crate::error::{CommandError, Severity};
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use mavlink_bridge::PlanItem;
use nalgebra::Vector2;
use std::f64::consts::TAU;
use std::time::Duration;

/// Most items that are done in one step without any flying between them, more than there are in a mission: jumps may go
/// round for ever.
const ITEMS_AT_ONCE_MAX: usize = 1000;

/// Most jumps of those, as in ArduPilot.
const JUMPS_AT_ONCE_MAX: usize = 64;

/// Least height above home that is climbed to before a mission without a take-off goes on, m.
const LEAST_TAKE_OFF_M: f64 = 10.0;

impl Autopilot {
    /// Goes to an item of the mission, or says why not. Jumps that have been made count still, unless they are reset.
    pub(crate) fn set_current_item(&mut self, seq: u16, resets_jumps: bool) -> Result<(), CommandError> {
        if self.mission.get(seq).is_none() {
            return Err(CommandError::denied(format!("Mission: no item {seq}")));
        }
        if !self.mission.is_flyable() {
            return Err(CommandError::failed("Mission: nothing to fly"));
        }
        let is_flown = self.mode() == Mode::Auto && self.flight.is_armed();
        if self.rules.tells_next_flown_item && !self.leads_anywhere(seq) {
            if is_flown {
                self.session.progress.complete();
                self.end_mission(MISSION_COMPLETE);
            }
            return Err(CommandError::failed(format!("Mission: nothing to fly from item {seq} on")));
        }
        self.session.progress.choose(seq, &self.mission, resets_jumps);
        Ok(())
    }

    /// Whether an item, or one behind it, is flown to, jumps that there is a place for included.
    fn leads_anywhere(&self, first: u16) -> bool {
        let mut at = first.max(self.mission.first());
        // Jumps may go round.
        for _ in 0..=self.mission.len() {
            let Some(item) = self.mission.get(at) else { return false };
            if is_flown_to(item) {
                return true;
            }
            let times = self.session.progress.jumps_made(at);
            let is_made = is_jump(item) && (item.params[1] < 0.0 || times < item.params[1] as u32);
            let tagged = || self.mission.tagged(f64::from(item.params[0]));
            at = match item.command {
                JUMP if is_made => item.params[0] as u16,
                JUMP_TO_TAG => match tagged() {
                    Some(to) if is_made => to,
                    Some(_) => at + 1,
                    None => return false,
                },
                _ => at + 1,
            };
        }
        false
    }

    /// The item that was chosen is told as an ArduPlane tells it: the next one that is flown to.
    pub(crate) fn tell_chosen_item(&mut self) {
        if self.rules.tells_next_flown_item {
            self.session.progress.tell_next_flown(&self.mission);
        }
    }

    /// Another mission that was uploaded begins with an item, or goes on with it.
    pub(crate) fn start_mission_at(&mut self, seq: u16) {
        self.session.progress.start_at(seq, &self.mission);
    }

    /// DO_JUMP_TAG as a command: to the JUMP_TAG of that number.
    pub(crate) fn jump_to_tag(&mut self, tag: f32) -> Result<(), CommandError> {
        if tag <= -1.0 || tag >= 65_536.0 {
            return Err(CommandError::denied("Mission: a tag has 16 bits"));
        }
        match self.mission.tagged(f64::from(tag.trunc())) {
            Some(seq) => {
                self.set_current_item(seq, false)?;
                self.tell_chosen_item();
                Ok(())
            }
            None => Err(CommandError::failed(format!("Mission: no tag {tag}"))),
        }
    }

    /// Looks after each integration step whether the current item is done, and begins the next.
    pub(crate) fn follow_mission(&mut self) {
        if self.mode() == Mode::Rtl {
            self.look_for_landing();
        }
        // Whose mission was replaced by nothing flies on where it was led.
        if self.mode() != Mode::Auto || !self.flight.is_armed() || self.mission.is_without_home() {
            return;
        }
        let mut jumps = 0;
        for _ in 0..ITEMS_AT_ONCE_MAX {
            if self.mode() != Mode::Auto {
                return;
            }
            let Some(item) = self.mission.get(self.session.progress.current()).copied() else {
                self.session.progress.complete();
                self.end_mission(MISSION_COMPLETE);
                return;
            };
            if matches!(self.session.progress.leg, Leg::Begin) {
                let seq = self.session.progress.begin_item();
                // Once is enough for what a jump comes back to without any flying.
                let has_jumped = jumps > 0;
                if is_jump(&item) {
                    jumps += 1;
                    if jumps > JUMPS_AT_ONCE_MAX {
                        break;
                    }
                    self.jump_from(seq, &item);
                } else if !is_flown_to(&item) {
                    self.come_to_command(seq, &item, !has_jumped);
                } else {
                    self.begin_item(&item);
                    // What is flown to and needs no flying is reached too.
                    if self.session.progress.current() != seq && !has_jumped {
                        self.tell_reached(seq);
                    }
                }
            } else if self.is_leg_done() {
                if let Some(leg) = self.stay_at_waypoint(&item) {
                    self.session.progress.leg = leg;
                    return;
                }
                if item.command == TAKEOFF {
                    self.session.fence.taken_off(&self.parameters, &mut self.events);
                }
                self.end_leg();
            } else {
                return self.follow_conditions();
            }
        }
        self.session.progress.complete();
        self.end_mission("Mission goes round in a circle");
    }

    /// Says in ArduPlane's words what AUTO has just done.
    fn tell_end_of_leg(&mut self, seq: u16) {
        if !self.rules.words.narrates_missions {
            return;
        }
        let text = match self.session.progress.leg {
            Leg::Place { at, radius_m, .. } => {
                let distance_m = self.flight.distance_m(at);
                let word = if distance_m <= radius_m { "Reached" } else { "Passed" };
                format!("{word} waypoint #{seq} dist {distance_m:.0}m")
            }
            Leg::Circle(loiter) => match loiter.goal {
                Goal::Turned(_) => "Loiter orbits complete".into(),
                Goal::Stayed(_) | Goal::AltitudeAndStayed(..) => "Loiter time complete".into(),
                Goal::Altitude(_) => "Loiter to alt complete".into(),
            },
            Leg::Altitude(..) if self.mission.get(seq).is_some_and(|item| item.command == TAKEOFF) => {
                let altitude_m = self.flight.estimate().altitude_m - self.flight.home().altitude_m;
                format!("Takeoff complete at {altitude_m:.2}m")
            }
            _ => return,
        };
        self.say(Severity::Info, &text);
    }

    pub(super) fn tell_reached(&mut self, seq: u16) {
        self.session.progress.note_reached(seq, self.time);
        self.events.push(Event::ItemReached(seq));
    }

    /// A PX4 tells the item that was reached last once a second, ten times more.
    pub(crate) fn tell_reached_again(&mut self) {
        const WHILE: Duration = Duration::from_secs(10);
        if self.time.subsec_nanos() != 0 || !self.rules.repeats_reached {
            return;
        }
        if let Some((seq, at)) = self.session.progress.reached() {
            let since = self.time.saturating_sub(at);
            if !since.is_zero() && since <= WHILE {
                self.events.push(Event::ItemReached(seq));
            }
        }
    }

    pub(super) fn tell_beginning(&mut self, seq: u16, item: &PlanItem) {
        if let Some(text) = names::beginning(seq, item).filter(|_| self.rules.words.narrates_missions) {
            self.say(Severity::Info, &text);
        }
    }

    fn end_leg(&mut self) {
        let seq = self.session.progress.current();
        match self.session.progress.leg {
            Leg::GoAround(_) => return self.restart_landing(),
            Leg::TakeOffFirst(_) => {
                self.session.progress.leg = Leg::Begin;
                return;
            }
            Leg::Place { at, .. } | Leg::Circle(Loiter { centre: at, .. }) => self.session.progress.set_from(Some(at)),
            _ => self.session.progress.set_from(None),
        }
        // What waits for a condition still is passed over.
        self.session.progress.set_waiting(None);
        self.tell_end_of_leg(seq);
        self.tell_reached(seq);
        if matches!(self.session.progress.leg, Leg::Landing) {
            // A mission ends on the ground, as in ArduPlane.
            self.session.progress.complete();
            self.session.progress.leg = Leg::Forever;
        } else {
            self.session.progress.go_to(seq + 1);
        }
    }

    /// The altitude of an item, m above the origin; without one, which a PX4 takes, that it is at.
    fn flown_altitude_m(&self, item: &PlanItem) -> f64 {
        let altitude_m = self.reference().altitude_of(item);
        if altitude_m.is_nan() { self.flight.estimate().altitude_m } else { altitude_m }
    }

    fn begin_item(&mut self, item: &PlanItem) {
        let seq = self.session.progress.current();
        self.tell_beginning(seq, item);
        let [p1, p2, p3, _] = item.params.map(f64::from);
        let at = self.reference().place_of(item, self.flight.here());
        let altitude_m = self.flown_altitude_m(item);
        if self.stands_before(item) {
            let altitude_m = altitude_m.max(self.flight.home().altitude_m + LEAST_TAKE_OFF_M);
            self.flight.take_off(altitude_m);
            self.session.progress.leg = Leg::TakeOffFirst(altitude_m);
            return;
        }
        let usual_m = self.flight.tuning().loiter_radius_m;
        // An ArduPlane takes its usual radius in the place of one of no more than a metre (`Plane::update_loiter`).
        let or_usual = |radius_m: f64| match radius_m {
            radius_m if self.rules.keeps_items_in_bytes && (-1.0..0.0).contains(&radius_m) => -usual_m.abs(),
            radius_m if self.rules.keeps_items_in_bytes && (0.0..=1.0).contains(&radius_m) => usual_m,
            0.0 => usual_m,
            radius_m => radius_m,
        };
        self.session.progress.leg = match item.command {
            WAYPOINT => {
                let from = self.session.progress.from().unwrap_or_else(|| self.flight.here());
                // Who gives a radius of its own has it flown to until it is reached. To a PX4 it is a multicopter's.
                let passes_by = self.loiter_rules() == Rules::ArduPlane;
                let own_radius_m = if passes_by { p2 } else { 0.0 };
                let passes = self.rules.passes_waypoints && own_radius_m <= 0.0;
                let at = if passes_by { beyond(from, at, p3.clamp(0.0, 255.0)) } else { at };
                self.flight.fly_leg(from, at, !passes);
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                let radius_m = if own_radius_m > 0.0 { own_radius_m } else { self.acceptance_radius_m() };
                // Past it already, it comes from where it is.
                let here = self.flight.here();
                let abeam_from = if is_beyond(here, from, at) { here } else { from };
                let abeam_from = passes.then_some(abeam_from);
                Leg::Place { at, radius_m, nearest_m: f64::INFINITY, abeam_from, ends_at_once: !passes_by }
            }
            LOITER_UNLIM => {
                self.flight.circle_at(at, or_usual(p3));
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                Leg::Forever
            }
            LOITER_TURNS => {
                let exit = self.exit_of(seq, true);
                self.circle_until(at, or_usual(p3), altitude_m, Goal::Turned(TAU * p1), exit)
            }
            LOITER_TIME => {
                let (stay, exit) = (Duration::try_from_secs_f64(p1).unwrap_or_default(), self.exit_of(seq, p2 > 0.0));
                self.circle_until(at, or_usual(p3), altitude_m, Goal::Stayed(stay), exit)
            }
            LOITER_TO_ALTITUDE => {
                let exit = self.exit_of(seq, p1 > 0.0);
                self.circle_until(at, or_usual(p2), altitude_m, Goal::Altitude(altitude_m), exit)
            }
            TAKEOFF => {
                // It is reached when it is exceeded.
                let above_m = altitude_m + TAKEOFF_TOLERANCE_M;
                self.flight.take_off(above_m.max(self.flight.state().altitude_m));
                Leg::Altitude(altitude_m, AltitudeEnd::Exceeded)
            }
            CHANGE_ALTITUDE => {
                self.flight.hold_course();
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                let end = match p1 {
                    1.0 => AltitudeEnd::NotBelow,
                    2.0 => AltitudeEnd::NotAbove,
                    _ => AltitudeEnd::Near,
                };
                Leg::Altitude(altitude_m, end)
            }
            LAND => {
                self.flight.land_at(at);
                if self.rules.words.narrates_missions {
                    let height_m = self.flight.state().altitude_m - self.flight.home().altitude_m;
                    self.say(Severity::Info, &format!("Landing approach start at {height_m:.1}m"));
                }
                Leg::Landing
            }
            RETURN_TO_LAUNCH => {
                // To an ArduPlane it stays the current item, which returns again.
                if !self.rules.return_item_stays_current {
                    self.session.progress.set_complete(self.mission.get(seq + 1).is_none());
                    self.tell_reached(seq);
                }
                self.set_mode(Mode::Rtl);
                return;
            }
            // What the upload lets in that means nothing here.
            _ => return self.session.progress.go_to(seq + 1),
        };
    }

    /// Whether it is on the ground and the item is a place in the air: a PX4 takes off first, where an ArduPlane waits
    /// for a take-off that does not come.
    fn stands_before(&self, item: &PlanItem) -> bool {
        self.rules.takes_off_before_mission
            && self.flight.is_on_ground()
            && matches!(item.command, WAYPOINT | LOITER_UNLIM | LOITER_TURNS | LOITER_TIME | LOITER_TO_ALTITUDE)
    }

    /// Looks after an integration step whether the current item has all that it wants.
    fn is_leg_done(&mut self) -> bool {
        let (state, is_on_ground, time) = (self.flight.estimate(), self.flight.is_on_ground(), self.time);
        self.session.progress.leg.is_done(&state, is_on_ground, time)
    }

    /// A PX4 at a waypoint that is not at its altitude, or is to stay there for param 1 seconds, circles there.
    fn stay_at_waypoint(&mut self, item: &PlanItem) -> Option<Leg> {
        let Leg::Place { at, .. } = self.session.progress.leg else { return None };
        if self.loiter_rules() != Rules::Px4 || item.command != WAYPOINT {
            return None;
        }
        let altitude_m = self.flown_altitude_m(item);
        let stay = Duration::try_from_secs_f32(item.params[0]).unwrap_or_default();
        let is_there = (self.flight.estimate().altitude_m - altitude_m).abs() <= PX4_ALTITUDE_M && stay.is_zero();
        // One that only climbs there goes on from where it is, one that stays towards what comes next.
        let exit = self.exit_of(self.session.progress.current(), !stay.is_zero());
        let radius_m = self.flight.tuning().loiter_radius_m;
        (!is_there)
            .then(|| self.circle_until(at, radius_m, altitude_m, Goal::AltitudeAndStayed(altitude_m, stay), exit))
    }

    fn circle_until(&mut self, at: Vector2<f64>, radius_m: f64, altitude_m: f64, goal: Goal, exit: Exit) -> Leg {
        let turn = if radius_m < 0.0 { -1.0 } else { 1.0 };
        let radius_m = self.flight.circle_at(at, radius_m);
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        let margin_m = self.acceptance_radius_m();
        let mut loiter = Loiter::new(at, radius_m, turn, goal, exit, self.loiter_rules());
        (loiter.margin_m, loiter.altitude_m) = (margin_m, altitude_m);
        Leg::Circle(loiter)
    }

    /// How near to a place it must come, m. A PX4 counts a fixed wing as there from where it turns to what comes next
    /// (`DirectionalGuidance::switchDistance`: NPFG_SW_DST_MLT 0.32 of NPFG_PERIOD 10 s and NPFG_DAMPING 0.7).
    fn acceptance_radius_m(&self) -> f64 {
        const SWITCH_S: f64 = 0.32 * 10.0 * 0.7;
        let least_m = f64::from(self.parameters.get(Parameter::WaypointRadius));
        match self.loiter_rules() {
            Rules::ArduPlane => least_m,
            Rules::Px4 => least_m.max(SWITCH_S * self.flight.estimate().speed_mps),
        }
    }

    fn loiter_rules(&self) -> Rules {
        if self.rules.judges_plans_as_px4 { Rules::Px4 } else { Rules::ArduPlane }
    }

    /// Where a loiter leads to: an ArduPlane leaves any towards the next place, a PX4 where the item asks for it.
    fn exit_of(&self, seq: u16, is_asked_for: bool) -> Exit {
        if self.loiter_rules() == Rules::Px4 && !is_asked_for {
            return Exit::AtOnce;
        }
        self.next_place(seq).map_or(Exit::AtOnce, Exit::Toward)
    }

    /// The place of the next item that is flown after an item; none where that has no place, and behind the last.
    fn next_place(&self, seq: u16) -> Option<Vector2<f64>> {
        let mut at = seq;
        // Jumps may go round.
        for _ in 0..self.mission.len() {
            at += 1;
            let item = self.mission.get(at)?;
            match item.command {
                JUMP if self.would_jump(at, item) => at = (item.params[0] as u16).saturating_sub(1),
                // Jumps, conditions and commands have higher numbers than what is flown.
                0..95 => {
                    let is_placed = has_place(item.command) && !item.position().is_zero();
                    return is_placed.then(|| self.reference().place_of(item, self.flight.here()));
                }
                _ => {}
            }
        }
        None
    }

    fn would_jump(&self, seq: u16, item: &PlanItem) -> bool {
        let made = self.session.progress.jumps_made(seq);
        item.params[1] < 0.0 || made < item.params[1] as u32
    }
}

/// A place so far behind another one as seen from a third: a waypoint is passed by so much.
fn beyond(from: Vector2<f64>, at: Vector2<f64>, distance_m: f64) -> Vector2<f64> {
    let way = at - from;
    if distance_m <= 0.0 || way.norm() <= 0.0 {
        return at;
    }
    at + way * (distance_m / way.norm())
}
