//! What a PX4 does with its modes by itself (`Commander.cpp`): Hold after a take-off, another mode after a landing,
//! disarming where it is armed and does not fly.

use super::Autopilot;
use super::arming::Cause;
use super::habits::{Homing, Stage, ends_a_flight};
use super::timer::Timer;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;

impl Autopilot {
    /// It is armed: on the ground it is given some time to take off.
    pub(crate) fn begin_idle_timer(&mut self) {
        let timers = &mut self.session.timers;
        if self.flight.is_on_ground() {
            timers.set(Timer::ArmedIdle, self.time)
        } else {
            timers.clear(Timer::ArmedIdle)
        }
    }

    /// Whether it is armed. Disarmed, it leaves the modes that it cannot be armed in, and take-off.
    pub(super) fn follow_arming(&mut self) -> bool {
        let is_armed = self.flight.is_armed();
        let was_armed = self.session.habits.was_armed(is_armed);
        if is_armed {
            return true;
        }
        self.session.timers.clear(Timer::ArmedIdle);
        if was_armed {
            self.session.failsafes.streams.set_lost(None);
            if ends_a_flight(self.mode()) || self.mode() == Mode::Takeoff {
                self.set_mode(self.session.habits.mode_to_restore());
            }
        }
        false
    }

    /// The mode has changed, to a return or another: no lower than RTL_RETURN_ALT above its destination, and no lower
    /// than it is.
    pub(super) fn begin_return(&mut self) {
        let returns = self.rules.climbs_to_return && self.mode() == Mode::Rtl;
        let destination_m = || self.best_rally().map_or(self.flight.home().altitude_m, |rally| rally.altitude_m);
        let homing = returns.then(|| Homing { altitude_m: destination_m(), stage: Stage::OnTheWay });
        if let Some(Homing { altitude_m, .. }) = homing {
            let least_m = altitude_m + f64::from(self.parameters.get(Parameter::RtlAltitude));
            self.flight.set_altitude(least_m.max(self.flight.estimate().altitude_m), f64::INFINITY);
        }
        self.session.habits.set_homing(homing);
    }

    /// Where a return ends, it goes down to RTL_DESCEND_ALT, circles and says so.
    pub(super) fn follow_return(&mut self) {
        let Some(mut homing) = self.session.habits.homing() else { return };
        let Some((at, radius_m)) = self.flight.circled() else { return };
        let near_m = f64::from(self.parameters.get(Parameter::WaypointRadius));
        match homing.stage {
            Stage::OnTheWay if self.flight.distance_m(at) <= radius_m.abs() + near_m => {
                let down_m = homing.altitude_m + f64::from(self.parameters.get(Parameter::ReturnDescentAltitude));
                self.flight.set_altitude(down_m.min(self.flight.target_altitude_m()), f64::INFINITY);
                homing.stage = Stage::Descending;
            }
            Stage::Descending if self.flight.altitude_error_m() <= near_m => {
                if let Some(text) = self.rules.words.returned {
                    self.say(Severity::Info, text);
                }
                homing.stage = Stage::Over;
            }
            Stage::OnTheWay | Stage::Descending | Stage::Over => return,
        }
        self.session.habits.set_homing(Some(homing));
    }

    /// Take-off is over when it circles at its altitude, round the place that came with it.
    pub(super) fn hold_after_take_off(&mut self) {
        if self.mode() != Mode::Takeoff || !self.flight.is_flying() || self.flight.is_taking_off() {
            return;
        }
        let altitude_m = self.flight.target_altitude_m();
        let radius_m = self.flight.tuning().loiter_radius_m;
        let place = self.session.habits.takeoff_place();
        if let Some(place) = place {
            if self.flight.circled().is_none_or(|(at, _)| at != place) {
                self.flight.reposition(place, radius_m);
            }
            let margin_m = f64::from(self.parameters.get(Parameter::WaypointRadius));
            if self.flight.distance_m(place) >= radius_m.abs() + margin_m {
                return;
            }
        }
        self.session.habits.set_takeoff_place(None);
        self.set_mode(Mode::Loiter);
        if let Some(place) = place {
            self.flight.reposition(place, radius_m);
        }
        self.flight.set_altitude(altitude_m, f64::INFINITY);
    }

    /// COM_DISARM_PRFLT after it was armed it has not yet flown; below 0: never.
    pub(super) fn disarm_idle(&mut self) {
        if self.flight.is_flying() {
            self.session.timers.clear(Timer::ArmedIdle);
        }
        let delay_s = self.parameters.get(Parameter::PreflightDisarmDelay);
        let since = self.session.timers.since(Timer::ArmedIdle, self.time).filter(|_| delay_s >= 0.0);
        let is_idle = self.flight.state().speed_mps == 0.0;
        if is_idle && since.is_some_and(|since| since.as_secs_f32() >= delay_s) {
            self.disarm(Cause::Idle);
        }
    }
}
