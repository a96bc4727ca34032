//! A GPS that is lost. As ArduPlane, the vehicle reckons on with its airspeed, its heading and the wind that it knew,
//! and so goes astray by what the wind changes and the gusts carry; with a fix it knows again where it is.

use super::proposal::{Action, Cause, Proposal};
use crate::autopilot::event::Events;
use crate::autopilot::situation::Situation;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;

/// Whether the fix is lost in flight.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GpsWatch {
    is_lost: bool,
}

impl GpsWatch {
    pub fn is_lost(&self) -> bool {
        self.is_lost
    }

    #[inline]
    pub fn check(&mut self, now: &Situation<'_>, events: &mut Events) -> Option<Proposal> {
        let is_lost = now.is_armed() && !now.has_fix();
        if std::mem::replace(&mut self.is_lost, is_lost) == is_lost {
            return None;
        }
        if !is_lost {
            events.say(Severity::Critical, "GPS 1: fix again, Dead Reckoning stopped");
            return None;
        }
        events.say(Severity::Critical, "GPS 1: no fix, Dead Reckoning started");
        let returns = now.get(Parameter::DeadReckoningAction) != 0.0;
        Some(Proposal::new(Cause::Gps, if returns { Action::Mode(Mode::Rtl) } else { Action::Warn }))
    }
}
