//! Setpoints that do not come any more: the vehicle loiters. ArduPlane waits for ever.

use super::proposal::{Action, Cause, Proposal};
use crate::autopilot::situation::Situation;
use crate::autopilot::timer::{Timer, Timers};
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use std::time::Duration;

/// Whether the lack of setpoints took the vehicle out of GUIDED, and nobody has set a mode since.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SetpointWatch {
    is_lost: bool,
}

impl SetpointWatch {
    pub fn is_lost(&self) -> bool {
        self.is_lost
    }

    pub fn set_lost(&mut self, is_lost: bool) {
        self.is_lost = is_lost;
    }

    #[inline]
    pub fn check(&mut self, now: &Situation<'_>, timers: &mut Timers) -> Option<Proposal> {
        if timers.is_set(Timer::SetpointTimeout) && !now.flight.is_flying() {
            restart(now, timers);
        }
        if !timers.is_over(Timer::SetpointTimeout, now.time) {
            return None;
        }
        timers.clear(Timer::SetpointTimeout);
        let text = format!("Failsafe: no setpoint for {} s, LOITER", now.get(Parameter::GuidedTimeout));
        let loiter = Proposal::new(Cause::Setpoints, Action::Mode(Mode::Loiter));
        Some(loiter.saying(Severity::Critical, text))
    }
}

/// The time-out runs while the vehicle flies in GUIDED; on the ground nothing is lost yet.
pub(crate) fn restart(now: &Situation<'_>, timers: &mut Timers) {
    let timeout_s = f64::from(now.get(Parameter::GuidedTimeout));
    let runs = timeout_s > 0.0 && now.is_armed() && now.mode() == Mode::Guided;
    match Duration::try_from_secs_f64(timeout_s).ok().filter(|_| runs) {
        Some(timeout) => timers.set(Timer::SetpointTimeout, now.time.saturating_add(timeout)),
        None => timers.clear(Timer::SetpointTimeout),
    }
}
