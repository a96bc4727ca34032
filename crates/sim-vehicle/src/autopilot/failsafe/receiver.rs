//! A pilot's receiver that fails: ArduPlane's throttle failsafe (`radio.cpp`), and what follows at once
//! (FS_SHORT_ACTN) and after FS_LONG_TIMEOUT (FS_LONG_ACTN).

use super::long_action::{long_action, long_text};
use super::proposal::{Action, Cause, Proposal};
use crate::autopilot::event::Events;
use crate::autopilot::manual_control::Pulses;
use crate::autopilot::situation::Situation;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use std::time::Duration;

/// How long nothing may come from the receiver.
const PULSES_MISSED: Duration = Duration::from_secs(1);
/// Ten readings at 50 Hz without a good one, and three good ones: on, and off.
const ON_AFTER: Duration = Duration::from_millis(200);
const OFF_AFTER: Duration = Duration::from_millis(60);

/// THR_FAILSAFE.
const DISABLED: f32 = 0.0;
const ENABLED: f32 = 1.0;
/// FS_SHORT_ACTN.
const BEST_GUESS: f32 = 0.0;
const GLIDE: f32 = 2.0;
const NO_SHORT: f32 = 3.0;
const FBWB: f32 = 4.0;

/// What has become of the receiver.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ReceiverWatch {
    /// Vehicle time of the last good reading.
    last_good: Duration,
    /// Since when readings are bad, and since when they are good again.
    bad_since: Option<Duration>,
    good_since: Option<Duration>,
    /// Whether it has failed: "Throttle failsafe on".
    has_failed: bool,
    stage: Stage,
}

/// Which failsafe acts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Stage {
    #[default]
    None,
    /// With the mode to go back to, if the failsafe has brought about another and nobody has set one since.
    Short(Option<Mode>),
    Long,
}

impl ReceiverWatch {
    /// Whether one of its failsafes acts.
    pub fn acts(&self) -> bool {
        self.stage != Stage::None
    }

    /// Whether it has failed: "Throttle failsafe on".
    pub fn has_failed(&self) -> bool {
        self.has_failed
    }

    pub fn is_long(&self) -> bool {
        self.stage == Stage::Long
    }

    /// Whether what it says counts: it neither fails now nor has it failed.
    pub fn is_well(&self) -> bool {
        !self.has_failed && self.bad_since.is_none()
    }

    /// Takes down what the receiver says in this step.
    pub fn read(&mut self, now: &Situation<'_>, pulses: Pulses, events: &mut Events) {
        let fs_value_us = now.get(Parameter::ThrottleFailsafeValue);
        let throttle_us = f32::from(pulses.throttle_us);
        let is_reversed = now.get(Parameter::ThrottleReversed) != 0.0;
        let is_in_range = if is_reversed { throttle_us < fs_value_us } else { throttle_us > fs_value_us };
        let enabled = now.get(Parameter::ThrottleFailsafe);
        let is_throttle_well = enabled == DISABLED || is_in_range;
        if pulses.have_come && is_throttle_well {
            self.last_good = now.time;
        }
        let is_bad = !is_throttle_well || now.time.saturating_sub(self.last_good) > PULSES_MISSED;
        if is_bad {
            self.good_since = None;
            let since = *self.bad_since.get_or_insert(now.time);
            let is_over = now.time.saturating_sub(since) >= ON_AFTER;
            if is_over && enabled == ENABLED && !std::mem::replace(&mut self.has_failed, true) {
                events.say(Severity::Warning, "Throttle failsafe on");
            }
        } else {
            self.bad_since = None;
            let since = *self.good_since.get_or_insert(now.time);
            let is_over = now.time.saturating_sub(since) >= OFF_AFTER;
            if is_over && std::mem::take(&mut self.has_failed) {
                events.say(Severity::Warning, "Throttle failsafe off");
            }
        }
    }

    /// What is to be done about it, if anything; `ground_is_lost`: the ground station's failsafe acts already.
    pub fn check(&mut self, now: &Situation<'_>, ground_is_lost: bool, events: &mut Events) -> Option<Proposal> {
        let short = now.get(Parameter::ShortFailsafeAction);
        match self.stage {
            Stage::None if self.has_failed && short != NO_SHORT && !now.flight.is_landing() => {
                self.stage = Stage::Short(None);
                return Some(short_proposal(short, now.mode()));
            }
            Stage::Short(back) if !self.has_failed || short == NO_SHORT => {
                self.stage = Stage::None;
                events.say(Severity::Warning, "RC Short Failsafe Cleared");
                let text = |mode: Mode| format!("Flight mode {mode} restored");
                return back.map(|mode| {
                    Proposal::new(Cause::ReceiverBack, Action::Mode(mode)).saying(Severity::Info, text(mode))
                });
            }
            Stage::Long if !self.has_failed => {
                self.stage = Stage::None;
                events.say(Severity::Warning, "RC Long Failsafe Cleared");
            }
            _ => {}
        }
        let is_long = self.has_failed && !self.is_long() && !ground_is_lost && !now.flight.is_landing();
        let missing_s = now.time.saturating_sub(self.last_good).as_secs_f32();
        // A take-off goes on; the failsafe waits for its end.
        if !is_long || missing_s <= now.get(Parameter::LongFailsafeTimeout) || is_taking_off(now) {
            return None;
        }
        self.stage = Stage::Long;
        let value = now.get(Parameter::LongFailsafeAction);
        let action = long_action(value, now.mode());
        let text = long_text("RC Long", action, now);
        Some(Proposal::new(Cause::ReceiverLong, action).saying(Severity::Warning, text))
    }

    /// The short failsafe has brought about another mode than this.
    pub fn switched_from(&mut self, mode: Mode) {
        self.stage = Stage::Short(Some(mode));
    }

    /// Somebody has set a mode, which stays.
    pub fn mode_set(&mut self) {
        if matches!(self.stage, Stage::Short(_)) {
            self.stage = Stage::Short(None);
        }
    }
}

fn is_taking_off(now: &Situation<'_>) -> bool {
    now.mode() == Mode::Takeoff && now.flight.is_flying() && !now.flight.has_taken_off()
}

/// What FS_SHORT_ACTN brings about in a mode (`Plane::rc_failsafe_short_on_event`).
fn short_proposal(value: f32, mode: Mode) -> Proposal {
    let action = match mode {
        Mode::Circle | Mode::Takeoff | Mode::Rtl => Action::Warn,
        Mode::Auto | Mode::Guided | Mode::Loiter if value == BEST_GUESS => Action::Warn,
        _ if value == GLIDE => Action::Glide,
        _ if value == FBWB => Action::Mode(Mode::Fbwb),
        _ => Action::Mode(Mode::Circle),
    };
    let after = action.mode_after(mode);
    let text = if after == mode {
        "RC Short Failsafe On".to_owned()
    } else {
        format!("RC Short Failsafe: switched to {after}")
    };
    Proposal::new(Cause::ReceiverShort, action).saying(Severity::Warning, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_of_the_short_failsafe_does_what_arduplane_does() {
        const CIRCLE: Action = Action::Mode(Mode::Circle);
        for (value, manual, guided, rtl) in [
            (0.0, CIRCLE, Action::Warn, Action::Warn),
            (1.0, CIRCLE, CIRCLE, Action::Warn),
            (2.0, Action::Glide, Action::Glide, Action::Warn),
            (4.0, Action::Mode(Mode::Fbwb), Action::Mode(Mode::Fbwb), Action::Warn),
        ] {
            let found = [Mode::Manual, Mode::Guided, Mode::Rtl].map(|mode| short_proposal(value, mode).action);
            assert_eq!(found, [manual, guided, rtl], "{value}");
        }
        let said = |mode| short_proposal(1.0, mode).text.unwrap().1;
        assert_eq!(said(Mode::Fbwa), "RC Short Failsafe: switched to CIRCLE");
        assert_eq!(said(Mode::Rtl), "RC Short Failsafe On");
    }
}
