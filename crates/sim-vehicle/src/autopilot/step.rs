//! One integration step, and all that is looked at after it, in its order.

use super::Autopilot;
use flight_model::State;
use std::time::Duration;

impl Autopilot {
    /// One integration step, which ends at `time`, and all that is looked at after it. The state is appended to
    /// `track`.
    pub fn step(&mut self, time: Duration, track: &mut Vec<State>) {
        self.live();
        self.forget_attitude();
        self.step_flight();
        self.time = time;
        track.push(*self.flight.state());
        self.watch_receiver();
        self.check_failsafes();
        self.check_fence();
        self.follow_mission();
        self.tell_reached_again();
        self.follow_calibration();
        self.follow_streams();
        self.follow_switches();
        self.tell_what_is_against_arming();
    }

    /// The world goes on by a step, before the vehicle does.
    fn live(&mut self) {
        let (state, in_air) = (*self.flight.state(), self.flight.in_air());
        let (wind, known) = self.world.blow(&self.parameters, self.time, self.step, &state, &in_air);
        self.flight.feel(wind, known);
        let power = if self.flight.is_idle() { 0.0 } else { self.flight.power_share() };
        let engine_works = self.world.drain(&self.parameters, self.step, power, self.flight.power_needed());
        self.flight.set_engine(engine_works);
    }

    fn check_failsafes(&mut self) {
        // A proposal changes how things stand: the watches after it look anew.
        let mut next = 0;
        loop {
            let (now, session, events) = self.split();
            match session.failsafes.check(&mut next, &now, &mut session.timers, events) {
                Some(proposal) => self.act(proposal),
                None => return,
            }
        }
    }

    fn check_fence(&mut self) {
        let (now, session, events) = self.split();
        if let Some(proposal) = session.fence.check(&now, &session.timers, events) {
            self.act(proposal);
        }
    }

    /// What a PX4 watches over, and does by itself.
    fn follow_streams(&mut self) {
        if !self.rules.watches_streams || !self.follow_arming() {
            return;
        }
        self.hold_after_take_off();
        self.follow_return();
        let (now, session, _) = self.split();
        if let Some(proposal) = session.failsafes.streams.check_offboard(&now, &session.timers) {
            self.act(proposal);
        }
        let (now, session, _) = self.split();
        let are_sticks_held = session.channels.are_held(now.time);
        if let Some(proposal) = session.failsafes.streams.check_sticks(&now, are_sticks_held) {
            self.act(proposal);
        }
        let (now, session, events) = self.split();
        if let Some(proposal) = session.failsafes.streams.check_ground(&now, &mut session.timers, events) {
            self.act(proposal);
        }
        self.disarm_idle();
    }
}
