//! What FS_LONG_ACTN brings about (`Plane::failsafe_long_on_event`), for a ground station that is silent and for a
//! receiver that fails.

use super::proposal::Action;
use crate::autopilot::situation::Situation;
use crate::mode::Mode;
use crate::parameters::table::Parameter;

/// What FS_LONG_ACTN brings about in a mode: GUIDED and AUTO go on by default, and other modes return. AUTOLAND (5) is
/// not simulated: RTL, as where it is not possible. A parachute (3) that is not enabled is not released.
pub(super) fn long_action(value: f32, mode: Mode) -> Action {
    match value as u8 {
        4 => Action::Mode(Mode::Auto),
        _ if mode == Mode::Rtl => Action::Warn,
        2 => Action::Glide,
        3 => Action::Parachute,
        1 | 5 => Action::Mode(Mode::Rtl),
        _ if matches!(mode, Mode::Guided | Mode::Auto) => Action::Warn,
        _ => Action::Mode(Mode::Rtl),
    }
}

/// What is said of it; `what` is "GCS" or "RC Long".
pub(super) fn long_text(what: &str, action: Action, now: &Situation<'_>) -> String {
    let mode = action.mode_after(now.mode());
    match action {
        Action::Parachute if now.get(Parameter::ParachuteEnabled) == 0.0 => {
            format!("{what} Failsafe On: no parachute, stays in {mode}")
        }
        Action::Parachute => format!("{what} Failsafe On: parachute, stays in {mode}"),
        _ => format!("{what} Failsafe On: switched to {mode}"),
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
            (3.0, Action::Parachute, Action::Parachute, Action::Warn),
            (4.0, AUTO, AUTO, AUTO),
            (5.0, RETURN, RETURN, Action::Warn),
        ] {
            let found = [Mode::Guided, Mode::Loiter, Mode::Rtl].map(|mode| long_action(value, mode));
            assert_eq!(found, [guided, loiter, rtl], "{value}");
        }
    }
}
