//! The one place where a failsafe or the fence changes the mode.

use super::Autopilot;
use super::failsafe::proposal::{Action, Cause, Proposal};
use super::fence::monitor::altitudes_inside_m;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;

impl Autopilot {
    /// Does what is proposed. The proposals of a step come one after the other, each made in the mode that the one
    /// before has left: so the last one has the last word, as in ArduPlane.
    pub(super) fn act(&mut self, proposal: Proposal) {
        let Proposal { cause, action, text } = proposal;
        if !matches!(cause, Cause::FenceOff | Cause::ReceiverBack) {
            self.counters.failsafes += 1;
        }
        let before = self.mode();
        match action {
            Action::Warn => {}
            // It is told with the next heartbeat, and no fence takes it for a pilot's.
            Action::Mode(mode) if cause == Cause::Setpoints => self.flight.set_mode(mode),
            // Without a mission AUTO returns.
            Action::Mode(Mode::Auto) => {
                let _ = self.enter(Mode::Auto);
            }
            Action::Mode(mode) => self.set_mode(mode),
            Action::Glide => {
                self.set_mode(Mode::Fbwa);
                self.flight.glide();
            }
            Action::Land => self.land_or_return(),
            Action::Parachute => self.release_parachute(),
        }
        match cause {
            Cause::Setpoints => self.session.failsafes.setpoints.set_lost(true),
            Cause::OffboardStream | Cause::GroundHold | Cause::GroundLost | Cause::Sticks => {
                self.session.failsafes.streams.set_lost(Some(cause));
            }
            Cause::Fence => self.come_back(before),
            Cause::ReceiverShort if self.mode() != before => self.session.failsafes.receiver.switched_from(before),
            // Whoever may be stuck at the sticks gives them back.
            Cause::GroundStation | Cause::ReceiverLong => self.session.channels.give_back_all(),
            Cause::Battery | Cause::Gps | Cause::Engine | Cause::FenceOff => {}
            Cause::ReceiverShort | Cause::ReceiverBack => {}
        }
        if let Some((severity, text)) = text {
            self.say(severity, &text);
        }
    }

    fn land_or_return(&mut self) {
        if let Err(error) = self.start_landing() {
            self.say(Severity::Warning, &error.reason.unwrap_or_default());
            self.set_mode(Mode::Rtl);
        }
    }

    /// The way back inside, in the mode that the breach has brought about.
    fn come_back(&mut self, before: Mode) {
        if self.mode() == Mode::Guided {
            self.fly_to_return_point();
        } else {
            let wanted_m = self.flight.aim().altitude_m;
            let altitude_m = self.session.fence.within_altitudes_m(wanted_m, &self.situation());
            if altitude_m != wanted_m {
                self.flight.set_altitude(altitude_m, f64::INFINITY);
            }
        }
        self.session.fence.recover(self.mode(), before);
    }

    /// Circles the return point, or a rally point if FENCE_RET_RALLY says so.
    fn fly_to_return_point(&mut self) {
        let get = |parameter: Parameter| f64::from(self.parameters.get(parameter));
        let (least_m, most_m) = altitudes_inside_m(&self.parameters);
        let home = self.flight.home();
        let above_home_m = |altitude_m: f64| home.altitude_m + altitude_m;
        let rtl_altitude_m = self.flight.tuning().rtl_altitude_m.map(above_home_m);
        let (at, altitude_m) = if get(Parameter::FenceReturnToRally) != 0.0 {
            let rally = self.best_rally();
            (rally.map_or(home.at(), |rally| rally.at), rally.map(|rally| rally.altitude_m).or(rtl_altitude_m))
        } else {
            let altitude_m = match get(Parameter::FenceReturnAltitude) {
                altitude_m if altitude_m > 0.0 => Some(above_home_m(altitude_m)),
                _ if least_m >= most_m => rtl_altitude_m,
                _ => Some(above_home_m(0.5 * (least_m + most_m))),
            };
            (self.fence.way_back().unwrap_or(home.at()), altitude_m)
        };
        self.flight.reposition(at, self.flight.tuning().loiter_radius_m);
        if let Some(altitude_m) = altitude_m {
            self.flight.set_altitude(altitude_m, f64::INFINITY);
        }
        self.stop_setpoint_timeout();
    }
}
