//! AUTO: one item after the other.

use super::items::{
    CHANGE_ALTITUDE, CHANGE_SPEED, FENCE_ENABLE, JUMP, JUMP_TO_TAG, LAND, LOITER_TIME, LOITER_TO_ALTITUDE,
    LOITER_TURNS, LOITER_UNLIM, RETURN_TO_LAUNCH, SET_HOME, TAKEOFF, WAYPOINT,
};
use super::legs::{AltitudeEnd, CircleEnd, Leg};
use crate::autopilot::Autopilot;
use crate::autopilot::event::Event;
use crate::autopilot::home::Home;
use crate::autopilot::mission::progress::Progress;
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

/// Least height above home that is climbed to before a mission without a take-off goes on, m.
const LEAST_TAKE_OFF_M: f64 = 10.0;

impl Autopilot {
    /// Goes to an item of the mission, or says why not.
    pub(crate) fn set_current_item(&mut self, seq: u16) -> Result<(), CommandError> {
        if self.mission.get(seq).is_none() {
            return Err(CommandError::denied(format!("Mission: no item {seq}")));
        }
        if !self.mission.is_flyable() {
            return Err(CommandError::failed("Mission: nothing to fly"));
        }
        self.session.progress = Progress::at_item(seq, &self.mission);
        Ok(())
    }

    /// DO_JUMP_TAG as a command: to the JUMP_TAG of that number.
    pub(crate) fn jump_to_tag(&mut self, tag: f32) -> Result<(), CommandError> {
        match self.mission.tagged(f64::from(tag)) {
            Some(seq) => self.set_current_item(seq),
            None => Err(CommandError::failed(format!("Mission: no tag {tag}"))),
        }
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
            let Some(item) = self.mission.get(self.session.progress.current()).copied() else {
                self.session.progress.complete();
                self.end_mission("Mission complete");
                return;
            };
            if matches!(self.session.progress.leg, Leg::Begin) {
                let seq = self.session.progress.begin_item();
                self.begin_item(&item);
                // What needs no flying is reached too.
                let is_done = self.session.progress.current() != seq;
                let is_jump = matches!(item.command, JUMP | JUMP_TO_TAG);
                has_jumped |= is_jump;
                // Once is enough for what a jump comes back to without any flying.
                if is_done && !is_jump && !has_jumped {
                    self.tell_reached(seq);
                }
            } else if self.is_leg_done() {
                if item.command == TAKEOFF {
                    self.session.fence.taken_off(&self.parameters, &mut self.events);
                }
                self.end_leg();
            } else {
                return;
            }
        }
        self.session.progress.complete();
        self.end_mission("Mission goes round in a circle");
    }

    /// Says in ArduPlane's words what AUTO has just done.
    fn tell_end_of_leg(&mut self, seq: u16) {
        let text = match self.session.progress.leg {
            Leg::Place { at, .. } => format!("Reached waypoint #{seq} dist {:.0}m", self.flight.distance_m(at)),
            Leg::Circle { until: CircleEnd::Turned(_), .. } => "Loiter orbits complete".into(),
            Leg::Circle { until: CircleEnd::Stayed(_), .. } => "Loiter time complete".into(),
            Leg::Circle { until: CircleEnd::Altitude(_), .. } => "Loiter to alt complete".into(),
            Leg::Altitude(..) if self.mission.get(seq).is_some_and(|item| item.command == TAKEOFF) => {
                let altitude_m = self.flight.estimate().altitude_m - self.flight.home().altitude_m;
                format!("Takeoff complete at {altitude_m:.2}m")
            }
            _ => return,
        };
        self.say(Severity::Info, &text);
    }

    fn tell_reached(&mut self, seq: u16) {
        self.events.push(Event::ItemReached(seq));
    }

    fn end_leg(&mut self) {
        let seq = self.session.progress.current();
        match self.session.progress.leg {
            Leg::GoAround(_) => return self.restart_landing(),
            Leg::TakeOffFirst(_) => {
                self.session.progress.leg = Leg::Begin;
                return;
            }
            Leg::Place { at, .. } | Leg::Circle { at, .. } => self.session.progress.set_from(Some(at)),
            _ => self.session.progress.set_from(None),
        }
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

    fn begin_item(&mut self, item: &PlanItem) {
        let seq = self.session.progress.current();
        if let Some(name) = flown_name(item.command) {
            self.say(Severity::Info, &format!("Mission: {seq} {name}"));
        }
        let [p1, p2, p3, _] = item.params.map(f64::from);
        let at = self.reference().place_of(item, self.flight.here());
        let altitude_m = self.reference().altitude_of(item);
        if self.stands_before(item) {
            let altitude_m = altitude_m.max(self.flight.home().altitude_m + LEAST_TAKE_OFF_M);
            self.flight.take_off(altitude_m);
            self.session.progress.leg = Leg::TakeOffFirst(altitude_m);
            return;
        }
        let or_usual = |radius_m: f64| if radius_m == 0.0 { self.flight.tuning().loiter_radius_m } else { radius_m };
        self.session.progress.leg = match item.command {
            WAYPOINT => {
                let from = self.session.progress.from().unwrap_or_else(|| self.flight.here());
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
            LOITER_TURNS => self.circle_until(at, or_usual(p3), altitude_m, CircleEnd::Turned(TAU * p1)),
            LOITER_TIME => {
                let stay = Duration::try_from_secs_f64(p1).unwrap_or(Duration::MAX);
                self.circle_until(at, or_usual(p3), altitude_m, CircleEnd::Stayed(stay))
            }
            LOITER_TO_ALTITUDE => self.circle_until(at, or_usual(p2), altitude_m, CircleEnd::Altitude(altitude_m)),
            TAKEOFF => {
                self.flight.take_off(altitude_m.max(self.flight.state().altitude_m));
                Leg::Altitude(altitude_m, AltitudeEnd::NotBelow)
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
                self.say(Severity::Info, &format!("Landing approach start at {height_m:.1}m"));
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
            CHANGE_SPEED => {
                self.change_mission_speed(p2);
                return self.session.progress.go_to(seq + 1);
            }
            SET_HOME => {
                if p1 == 1.0 {
                    self.set_home_here();
                } else {
                    self.set_home(Home::new(at, altitude_m));
                }
                return self.session.progress.go_to(seq + 1);
            }
            FENCE_ENABLE => {
                // A fence that is not there is not enabled; the mission goes on.
                let [action, kinds, ..] = item.params;
                let _ = self.enable_fence([action, kinds]);
                return self.session.progress.go_to(seq + 1);
            }
            JUMP => return self.session.progress.jump(seq, p1 as u16, p2),
            JUMP_TO_TAG => {
                return match self.mission.tagged(p1) {
                    Some(to) => self.session.progress.jump(seq, to, p2),
                    None => self.session.progress.go_to(seq + 1),
                };
            }
            // Marks, and what the upload lets in that means nothing here.
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

    fn circle_until(&mut self, at: Vector2<f64>, radius_m: f64, altitude_m: f64, until: CircleEnd) -> Leg {
        let radius_m = self.flight.circle_at(at, radius_m);
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        Leg::Circle { at, radius_m, until, flown: None }
    }

    /// -2: the usual speed; -1: no other.
    fn change_mission_speed(&mut self, speed_mps: f64) {
        let speed_mps = match speed_mps {
            -1.0 => return,
            -2.0 => f64::from(self.parameters.get(Parameter::AirspeedCruise)),
            speed_mps => speed_mps,
        };
        let least = f64::from(self.parameters.get(Parameter::AirspeedMin));
        let most = f64::from(self.parameters.get(Parameter::AirspeedMax));
        self.flight.set_speed(speed_mps.clamp(least, most), f64::INFINITY);
    }
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
