//! AUTO: one item after the other.

use super::items::{
    CHANGE_ALTITUDE, CHANGE_SPEED, FENCE_ENABLE, JUMP, JUMP_TO_TAG, LAND, LOITER_TIME, LOITER_TO_ALTITUDE,
    LOITER_TURNS, LOITER_UNLIM, RETURN_TO_LAUNCH, SET_HOME, TAG, TAKEOFF, WAYPOINT, altitude_datum, has_place,
};
use super::legs::{AltitudeEnd, Leg};
use super::loiter::{Exit, Goal, Loiter, PX4_ALTITUDE_M, Rules};
use crate::autopilot::flight::TAKEOFF_TOLERANCE_M;
use crate::firmware::Personality;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::protocol::command::Refusal;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MISSION_ITEM_REACHED_DATA, MavSeverity, Message};
use mavlink_bridge::{AltitudeDatum, PlanItem};
use std::f64::consts::TAU;
use std::time::Duration;

/// Most items that are done in one step without any flying between them, more than there are in a mission: jumps may go
/// round for ever.
const ITEMS_AT_ONCE_MAX: usize = 1000;

/// Least height above home that is climbed to before a mission without a take-off goes on, m.
const LEAST_TAKE_OFF_M: f64 = 10.0;

/// How far AUTO has come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Progress {
    /// The item that is flown, or will be when AUTO is set.
    pub current: u16,
    /// Whether it has been flown, or somebody has chosen it.
    pub has_begun: bool,
    pub is_complete: bool,
    /// Whether RTL has looked for a landing sequence.
    pub has_looked_for_landing: bool,
    /// Times that each jump was made.
    jumps: Vec<(u16, u32)>,
    /// The place of the item before the current one, (north, east) in m: the leg begins there.
    from: Option<(f64, f64)>,
    pub(super) leg: Leg,
}

impl Progress {
    /// The current item as it is told: none, 0, before anything has begun.
    pub fn told(&self) -> u16 {
        if self.has_begun { self.current } else { 0 }
    }
}

impl Vehicle {
    /// AUTO has been set: it goes on with the current item, from its beginning.
    pub(crate) fn begin_mission(&mut self) {
        if self.progress.is_complete || self.progress.current < self.mission.first {
            self.reset_mission();
        }
        self.progress.leg = Leg::Begin;
        self.progress.from = None;
    }

    /// AUTO will begin with the first item.
    pub(crate) fn reset_mission(&mut self) {
        self.progress = Progress { current: self.mission.len().min(self.mission.first), ..Progress::default() };
    }

    /// Another mission begins at its beginning; a changed one goes on where it is, and in an ArduPlane so does another that
    /// takes the place of one under way.
    pub(crate) fn mission_changed(&mut self, whole: bool) {
        let is_under_way = self.progress.has_begun && !self.progress.is_complete;
        let goes_on = self.settings.personality == Personality::ArduPlane
            && is_under_way
            && self.mission.get(self.progress.current).is_some();
        if whole && !goes_on {
            self.reset_mission();
        }
        self.progress.leg = Leg::Begin;
        if self.mode() == Mode::Auto && !self.mission.is_flyable() {
            self.end_mission("Mission cleared");
        }
    }

    /// Goes to an item of the mission, or says why not. Jumps that have been made count still, unless they are reset.
    pub(crate) fn set_current_item(&mut self, seq: u16, reset: bool) -> Result<(), Refusal> {
        if self.mission.get(seq).is_none() {
            return Err(Refusal::denied(format!("Mission: no item {seq}")));
        }
        if !self.mission.is_flyable() {
            return Err(Refusal::failed("Mission: nothing to fly"));
        }
        let jumps = if reset { Vec::new() } else { std::mem::take(&mut self.progress.jumps) };
        self.progress =
            Progress { current: seq.max(self.mission.first), has_begun: true, jumps, ..Progress::default() };
        Ok(())
    }

    /// DO_JUMP_TAG as a command: to the JUMP_TAG of that number.
    pub(crate) fn jump_to_tag(&mut self, tag: f32) -> Result<(), Refusal> {
        if tag >= 65_536.0 {
            return Err(Refusal::denied("Mission: a tag has 16 bits"));
        }
        match self.tagged(f64::from(tag.trunc())) {
            Some(seq) => self.set_current_item(seq, false),
            None => Err(Refusal::failed(format!("Mission: no tag {tag}"))),
        }
    }

    fn tagged(&self, tag: f64) -> Option<u16> {
        let is_it = |item: &PlanItem| item.command == TAG && f64::from(item.params[0]) == tag;
        self.mission.numbered().find(|(_, item)| is_it(item)).map(|(seq, _)| seq)
    }

    /// Looks after each integration step whether the current item is done, and begins the next.
    pub(crate) fn follow_mission(&mut self) {
        if self.mode() == Mode::Rtl {
            self.look_for_landing();
        }
        if self.mode() != Mode::Auto || !self.flight.is_armed() {
            return;
        }
        let mut has_jumped = false;
        for _ in 0..ITEMS_AT_ONCE_MAX {
            if self.mode() != Mode::Auto {
                return;
            }
            let Some(item) = self.mission.get(self.progress.current).copied() else {
                self.progress.is_complete = true;
                self.end_mission("Mission complete");
                return;
            };
            if matches!(self.progress.leg, Leg::Begin) {
                let seq = self.progress.current;
                self.progress.has_begun = true;
                self.begin_item(&item);
                // What needs no flying is reached too.
                let is_done = self.progress.current != seq;
                let is_jump = matches!(item.command, JUMP | JUMP_TO_TAG);
                has_jumped |= is_jump;
                // Once is enough for what a jump comes back to without any flying.
                if is_done && !is_jump && !has_jumped {
                    self.tell_reached(seq);
                }
            } else if self.is_leg_done() {
                if let Some(leg) = self.stay_at_waypoint(&item) {
                    self.progress.leg = leg;
                    return;
                }
                if item.command == TAKEOFF {
                    self.takeoff_changes_fence();
                }
                self.end_leg();
            } else {
                return;
            }
        }
        self.progress.is_complete = true;
        self.end_mission("Mission goes round in a circle");
    }

    /// Says in ArduPlane's words what AUTO has just done.
    fn tell_end_of_leg(&mut self, seq: u16) {
        let text = match self.progress.leg {
            Leg::Place { at, .. } => format!("Reached waypoint #{seq} dist {:.0}m", self.distance_m(at)),
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
        self.say(MavSeverity::MAV_SEVERITY_INFO, &text);
    }

    fn tell_reached(&mut self, seq: u16) {
        self.links.send_all(&Message::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq }));
    }

    fn end_mission(&mut self, text: &str) {
        let personality = self.settings.personality;
        let mode = personality.mode_after_mission();
        self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("{text}, changing mode to {}", personality.mode_name(mode)));
        self.set_mode(mode);
    }

    fn end_leg(&mut self) {
        let seq = self.progress.current;
        match self.progress.leg {
            Leg::GoAround(_) => return self.restart_landing(),
            Leg::TakeOffFirst(_) => {
                self.progress.leg = Leg::Begin;
                return;
            }
            Leg::Place { at, .. } | Leg::Circle(Loiter { centre: at, .. }) => self.progress.from = Some(at),
            _ => self.progress.from = None,
        }
        self.tell_end_of_leg(seq);
        self.tell_reached(seq);
        if matches!(self.progress.leg, Leg::Landing) {
            // A mission ends on the ground, as in ArduPlane.
            self.progress.is_complete = true;
            self.progress.leg = Leg::Forever;
        } else {
            self.go_to(seq + 1);
        }
    }

    pub(super) fn go_to(&mut self, seq: u16) {
        self.progress.current = seq;
        self.progress.leg = Leg::Begin;
    }

    fn begin_item(&mut self, item: &PlanItem) {
        let seq = self.progress.current;
        if let Some(name) = flown_name(item.command) {
            self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("Mission: {seq} {name}"));
        }
        let [p1, p2, p3, _] = item.params.map(f64::from);
        let at = self.place_of(item);
        let altitude_m = self.altitude_of(item);
        if self.stands_before(item) {
            let altitude_m = altitude_m.max(self.flight.home().altitude_m + LEAST_TAKE_OFF_M);
            self.flight.take_off(altitude_m);
            self.progress.leg = Leg::TakeOffFirst(altitude_m);
            return;
        }
        let or_usual = |radius_m: f64| if radius_m == 0.0 { self.flight.tuning().loiter_radius_m } else { radius_m };
        self.progress.leg = match item.command {
            WAYPOINT => {
                let from = self.progress.from.unwrap_or_else(|| self.here());
                let at = if self.rules() == Rules::ArduPlane { beyond(from, at, p3.clamp(0.0, 255.0)) } else { at };
                self.flight.fly_leg(from, at);
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                let radius_m = if p2 > 0.0 { p2 } else { f64::from(self.parameters.get(Parameter::WaypointRadius)) };
                Leg::Place { at, radius_m, nearest_m: f64::INFINITY }
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
                let height_m = self.flight.state().altitude_m - self.flight.home().altitude_m;
                self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("Landing approach start at {height_m:.1}m"));
                Leg::Landing
            }
            RETURN_TO_LAUNCH => {
                // To an ArduPlane it stays the current item, which returns again.
                if self.settings.personality != Personality::ArduPlane {
                    self.progress.is_complete = self.mission.get(seq + 1).is_none();
                    self.tell_reached(seq);
                }
                self.set_mode(Mode::Rtl);
                return;
            }
            CHANGE_SPEED => {
                let [kind, speed_mps, throttle, _] = item.params;
                self.change_mission_speed([kind, speed_mps, throttle]);
                return self.go_to(seq + 1);
            }
            SET_HOME => {
                if p1 == 1.0 {
                    self.set_home_here();
                } else {
                    self.set_home_at(at, altitude_m);
                }
                return self.go_to(seq + 1);
            }
            FENCE_ENABLE => {
                // A fence that is not there is not enabled; the mission goes on.
                let [action, kinds, ..] = item.params;
                let _ = self.enable_fence([action, kinds]);
                return self.go_to(seq + 1);
            }
            JUMP => return self.jump(seq, p1 as u16, p2),
            JUMP_TO_TAG => {
                return match self.tagged(p1) {
                    Some(to) => self.jump(seq, to, p2),
                    None => self.go_to(seq + 1),
                };
            }
            // Marks, and what the upload lets in that means nothing here.
            _ => return self.go_to(seq + 1),
        };
    }

    /// A PX4 at a waypoint that is not at its altitude, or is to stay there for param 1 seconds, circles there.
    fn stay_at_waypoint(&mut self, item: &PlanItem) -> Option<Leg> {
        let Leg::Place { at, .. } = self.progress.leg else { return None };
        if self.rules() != Rules::Px4 || item.command != WAYPOINT {
            return None;
        }
        let altitude_m = self.altitude_of(item);
        let stay = Duration::try_from_secs_f32(item.params[0]).unwrap_or_default();
        let is_there = (self.flight.estimate().altitude_m - altitude_m).abs() <= PX4_ALTITUDE_M && stay.is_zero();
        let exit = self.exit_of(self.progress.current, true);
        let radius_m = self.flight.tuning().loiter_radius_m;
        (!is_there)
            .then(|| self.circle_until(at, radius_m, altitude_m, Goal::AltitudeAndStayed(altitude_m, stay), exit))
    }

    /// Whether it is on the ground and the item is a place in the air: a PX4 takes off first, where an ArduPlane waits for a
    /// take-off that does not come.
    fn stands_before(&self, item: &PlanItem) -> bool {
        self.settings.personality != Personality::ArduPlane
            && self.flight.is_on_ground()
            && matches!(item.command, WAYPOINT | LOITER_UNLIM | LOITER_TURNS | LOITER_TIME | LOITER_TO_ALTITUDE)
    }

    /// Where it is, (north, east) in m.
    pub(super) fn here(&self) -> (f64, f64) {
        let state = self.flight.estimate();
        (state.x_m, state.y_m)
    }

    fn circle_until(&mut self, at: (f64, f64), radius_m: f64, altitude_m: f64, goal: Goal, exit: Exit) -> Leg {
        let turn = if radius_m < 0.0 { -1.0 } else { 1.0 };
        let radius_m = self.flight.circle_at(at, radius_m);
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        let margin_m = f64::from(self.parameters.get(Parameter::WaypointRadius));
        let mut loiter = Loiter::new(at, radius_m, turn, goal, exit, self.rules());
        (loiter.margin_m, loiter.altitude_m) = (margin_m, altitude_m);
        Leg::Circle(loiter)
    }

    fn rules(&self) -> Rules {
        if self.settings.personality == Personality::Px4 { Rules::Px4 } else { Rules::ArduPlane }
    }

    /// Where a loiter leads to: an ArduPlane leaves any towards the next place, a PX4 where the item asks for it.
    fn exit_of(&self, seq: u16, is_asked_for: bool) -> Exit {
        if self.rules() == Rules::Px4 && !is_asked_for {
            return Exit::AtOnce;
        }
        self.next_place(seq).map_or(Exit::AtOnce, Exit::Toward)
    }

    /// The place of the next item that is flown after an item; none where that has no place, and behind the last.
    fn next_place(&self, seq: u16) -> Option<(f64, f64)> {
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
                    return is_placed.then(|| self.place_of(item));
                }
                _ => {}
            }
        }
        None
    }

    fn would_jump(&self, seq: u16, item: &PlanItem) -> bool {
        let made = self.progress.jumps.iter().find(|(jump, _)| *jump == seq).map_or(0, |(_, made)| *made);
        item.params[1] < 0.0 || made < item.params[1] as u32
    }

    /// What the autopilot does not take changes nothing, and the mission goes on.
    fn change_mission_speed(&mut self, [kind, speed_mps, throttle]: [f32; 3]) {
        if self.settings.personality == Personality::ArduPlane {
            let _ = self.change_speed_as_arduplane([kind, speed_mps, throttle]);
            return;
        }
        let usual = f64::from(self.parameters.get(Parameter::AirspeedCruise));
        let speed_mps = if speed_mps > 0.0 { f64::from(speed_mps) } else { usual };
        let least = f64::from(self.parameters.get(Parameter::AirspeedMin));
        let most = f64::from(self.parameters.get(Parameter::AirspeedMax));
        self.flight.set_speed(speed_mps.clamp(least, most), f64::INFINITY);
    }

    /// From an item to another, so many times; a negative number is for ever.
    fn jump(&mut self, from: u16, to: u16, times: f64) {
        let index = self.progress.jumps.iter().position(|(jump, _)| *jump == from).unwrap_or_else(|| {
            self.progress.jumps.push((from, 0));
            self.progress.jumps.len() - 1
        });
        let made = &mut self.progress.jumps[index].1;
        let again = times < 0.0 || f64::from(*made) < times;
        *made += u32::from(again);
        self.go_to(if again { to } else { from + 1 });
    }

    /// Where an item is, (north, east) in m; without a place, here.
    pub(crate) fn place_of(&self, item: &PlanItem) -> (f64, f64) {
        let position = item.position();
        if position.is_zero() { self.here() } else { self.to_local(position) }
    }

    /// Its altitude, m above the origin: terrain is as high as home.
    pub(crate) fn altitude_of(&self, item: &PlanItem) -> f64 {
        self.above_origin_m(altitude_datum(item).unwrap_or(AltitudeDatum::Home), f64::from(item.z_m))
    }
}

/// A place so far behind another one as seen from a third: a waypoint is passed by so much.
fn beyond(from: (f64, f64), at: (f64, f64), distance_m: f64) -> (f64, f64) {
    let (north, east) = (at.0 - from.0, at.1 - from.1);
    let length_m = (north * north + east * east).sqrt();
    if distance_m <= 0.0 || length_m <= 0.0 {
        return at;
    }
    (at.0 + distance_m * north / length_m, at.1 + distance_m * east / length_m)
}

/// ArduPilot's short name of an item that is flown (`AP_Mission::Mission_Command::type`).
fn flown_name(command: u16) -> Option<&'static str> {
    Some(match command {
        WAYPOINT => "WP",
        RETURN_TO_LAUNCH => "RTL",
        LOITER_UNLIM => "LoitUnlim",
        LOITER_TIME => "LoitTime",
        LOITER_TURNS => "LoitTurns",
        LOITER_TO_ALTITUDE => "LoitAltitude",
        TAKEOFF => "Takeoff",
        LAND => "Land",
        CHANGE_ALTITUDE => "ContinueAndChangeAlt",
        _ => return None,
    })
}
