//! Items of a mission that need no flying: jumps, and commands on the way.

use super::conditions::Waiting;
use super::items::{CHANGE_SPEED, FENCE_ENABLE, JUMP, PARACHUTE, RELAY, SERVO, SET_HOME};
use super::names;
use crate::autopilot::Autopilot;
use crate::autopilot::home::Home;
use crate::error::Severity;
use crate::parameters::table::Parameter;
use mavlink_bridge::PlanItem;

impl Autopilot {
    /// A command has been done.
    pub(super) fn tell_done(&mut self, seq: u16, item: &PlanItem) {
        if names::is_reached(item.command) {
            self.tell_reached(seq);
        }
    }

    /// Makes a jump, or goes on behind it.
    pub(super) fn jump_from(&mut self, seq: u16, item: &PlanItem) {
        let [p1, p2, ..] = item.params.map(f64::from);
        let to = if item.command == JUMP { Some(p1 as u16) } else { self.mission.tagged(p1) };
        let Some(to) = to else {
            // Without its tag the mission is over.
            return self.session.progress.go_to(self.mission.len());
        };
        let made = self.session.progress.jump(seq, to, p2);
        if let Some(made) = made.filter(|_| self.rules.words.narrates_missions) {
            let of = if p2 < 0.0 { "unlimited".to_owned() } else { format!("{p2:.0}") };
            self.say(Severity::Info, &format!("Mission: {seq} Jump {made}/{of}"));
        }
    }

    /// Does a command, or leaves it for when the condition before it holds.
    pub(super) fn come_to_command(&mut self, seq: u16, item: &PlanItem, is_told: bool) {
        let waits = self.session.progress.waiting().is_some();
        self.session.progress.go_to(seq + 1);
        if waits {
            return;
        }
        self.tell_beginning(seq, item);
        if let Some(waiting) = Waiting::of(seq, item, self.time).filter(|_| !self.rules.judges_plans_as_px4) {
            return self.session.progress.set_waiting(Some(waiting));
        }
        self.do_command(item);
        if is_told {
            self.tell_done(seq, item);
        }
    }

    /// Does what an item says that is not flown to. Marks do nothing, nor does what the upload lets in that means
    /// nothing here.
    pub(super) fn do_command(&mut self, item: &PlanItem) {
        match item.command {
            CHANGE_SPEED => {
                let [kind, speed_mps, throttle, _] = item.params;
                self.change_mission_speed([kind, speed_mps, throttle]);
            }
            SET_HOME if item.params[0] == 1.0 => self.set_home_here(),
            SET_HOME => {
                let at = self.reference().place_of(item, self.flight.here());
                self.set_home(Home::new(at, self.reference().altitude_of(item)));
            }
            FENCE_ENABLE => {
                // A fence that is not there is not enabled; the mission goes on.
                let [action, kinds, ..] = item.params;
                let _ = self.enable_fence([action, kinds]);
            }
            SERVO if self.rules.keeps_items_in_bytes => {
                let [servo, pulse_us, ..] = item.params;
                let _ = self.set_servo([servo, pulse_us]);
            }
            PARACHUTE if self.rules.keeps_items_in_bytes => self.use_parachute(item.params[0]),
            RELAY if self.rules.keeps_items_in_bytes => {
                let [relay, state, ..] = item.params;
                let _ = self.set_relay([relay, state]);
            }
            _ => {}
        }
    }

    /// What the autopilot does not take changes nothing, and the mission goes on.
    fn change_mission_speed(&mut self, [kind, speed_mps, throttle]: [f32; 3]) {
        if self.rules.has_ardupilot_commands {
            let _ = self.change_speed_as_arduplane([kind, speed_mps, throttle]);
            return;
        }
        let usual_mps = f64::from(self.parameters.get(Parameter::AirspeedCruise));
        let speed_mps = if speed_mps > 0.0 { f64::from(speed_mps) } else { usual_mps };
        let least = f64::from(self.parameters.get(Parameter::AirspeedMin));
        let most = f64::from(self.parameters.get(Parameter::AirspeedMax));
        self.flight.set_speed(speed_mps.clamp(least, most), f64::INFINITY);
    }
}
