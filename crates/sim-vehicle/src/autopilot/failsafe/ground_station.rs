//! A ground station that is silent: ArduPlane's failsafe (FS_GCS_ENABL, FS_LONG_ACTN).

use super::proposal::{Action, Cause, Proposal};
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
        let mode = match action {
            Action::Mode(mode) => mode,
            Action::Glide => Mode::Fbwa,
            Action::Warn | Action::Land => now.mode(),
        };
        let text = if value == PARACHUTE && action == Action::Warn {
            format!("GCS Failsafe On: no parachute, stays in {mode}")
        } else {
            format!("GCS Failsafe On: switched to {mode}")
        };
        Some(Proposal::new(Cause::GroundStation, action).saying(Severity::Warning, text))
    }
}

/// The value of FS_LONG_ACTN that releases a parachute.
const PARACHUTE: f32 = 3.0;

/// What FS_LONG_ACTN brings about in a mode (`Plane::failsafe_long_on_event`): GUIDED and AUTO go on by default, and
/// other modes return. There is no parachute (3), and AUTOLAND (5) is not simulated: RTL, as where it is not possible.
fn long_action(value: f32, mode: Mode) -> Action {
    match value as u8 {
        4 => Action::Mode(Mode::Auto),
        _ if mode == Mode::Rtl => Action::Warn,
        2 => Action::Glide,
        3 => Action::Warn,
        1 | 5 => Action::Mode(Mode::Rtl),
        _ if matches!(mode, Mode::Guided | Mode::Auto) => Action::Warn,
        _ => Action::Mode(Mode::Rtl),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_of_the_long_failsafe_does_what_arduplane_does() {
        const RETURN: Action = Action::Mode(Mode::Rtl);
        const AUTO: Action = Action::Mode(Mode::Auto);
        for (value, guided, loiter, rtl) in [
            (0.0, Action::Warn, RETURN, Action::Warn),
            (1.0, RETURN, RETURN, Action::Warn),
            (2.0, Action::Glide, Action::Glide, Action::Warn),
            (3.0, Action::Warn, Action::Warn, Action::Warn),
            (4.0, AUTO, AUTO, AUTO),
            (5.0, RETURN, RETURN, Action::Warn),
        ] {
            let found = [Mode::Guided, Mode::Loiter, Mode::Rtl].map(|mode| long_action(value, mode));
            assert_eq!(found, [guided, loiter, rtl], "{value}");
        }
    }
}
