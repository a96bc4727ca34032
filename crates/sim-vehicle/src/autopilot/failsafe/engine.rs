//! An engine that fails: the vehicle glides down, led by its mode still.

use super::proposal::{Action, Cause, Proposal};
use crate::autopilot::event::Events;
use crate::autopilot::situation::Situation;
use crate::error::Severity;

/// Whether the engine has failed in flight.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EngineWatch {
    has_failed: bool,
}

impl EngineWatch {
    pub fn has_failed(&self) -> bool {
        self.has_failed
    }

    #[inline]
    pub fn check(&mut self, now: &Situation<'_>, events: &mut Events) -> Option<Proposal> {
        let has_failed = now.is_armed() && !now.flight.is_engine_running();
        if std::mem::replace(&mut self.has_failed, has_failed) == has_failed {
            return None;
        }
        if has_failed {
            let glide = Proposal::new(Cause::Engine, Action::Warn);
            return Some(glide.saying(Severity::Critical, "Engine failed, gliding"));
        }
        if now.is_armed() {
            events.say(Severity::Critical, "Engine runs again");
        }
        None
    }
}
