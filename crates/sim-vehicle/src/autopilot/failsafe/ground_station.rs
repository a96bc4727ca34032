//! A ground station that is silent: ArduPlane's failsafe (FS_GCS_ENABL, FS_LONG_ACTN).

use super::long_action::{long_action, long_text};
use super::proposal::{Cause, Proposal};
use crate::autopilot::event::Events;
use crate::autopilot::situation::Situation;
use crate::autopilot::timer::{Timer, Timers};
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;

/// Whether the ground station whose loss counts is lost.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroundStationWatch {
    is_lost: bool,
}

impl GroundStationWatch {
    pub fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Its heartbeat ends the failsafe, and the mode stays.
    pub fn hear(&mut self, now: &Situation<'_>, timers: &mut Timers, events: &mut Events) {
        timers.set(Timer::GroundStation, now.time);
        if std::mem::take(&mut self.is_lost) {
            events.say(Severity::Warning, "GCS Failsafe Cleared");
        }
    }

    /// Nobody waits for the first heartbeat.
    #[inline]
    pub fn check(&mut self, now: &Situation<'_>, timers: &Timers) -> Option<Proposal> {
        const ONLY_IN_AUTO: f32 = 3.0;
        let enabled = now.get(Parameter::GroundFailsafe);
        if enabled == 0.0 || self.is_lost || (enabled == ONLY_IN_AUTO && now.mode() != Mode::Auto) {
            return None;
        }
        let timeout_s = now.get(Parameter::LongFailsafeTimeout);
        if timers.since(Timer::GroundStation, now.time)?.as_secs_f32() <= timeout_s {
            return None;
        }
        self.is_lost = true;
        let value = now.get(Parameter::LongFailsafeAction);
        let action = long_action(value, now.mode());
        let text = long_text("GCS", action, now);
        Some(Proposal::new(Cause::GroundStation, action).saying(Severity::Warning, text))
    }
}
