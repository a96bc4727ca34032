//! What a PX4 must hear to go on: setpoints in Offboard, a hand on the sticks in the modes that they fly, a ground
//! station (`failsafe.cpp`, `offboardCheck.cpp`).

use super::proposal::{Action, Cause, Proposal};
use crate::autopilot::event::Events;
use crate::autopilot::situation::Situation;
use crate::autopilot::timer::{Timer, Timers};
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use std::time::Duration;

/// For want of what the vehicle flies as it does.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StreamWatch {
    lost: Option<Cause>,
}

impl StreamWatch {
    /// For want of what it flies as it does, if so.
    pub fn lost(&self) -> Option<Cause> {
        self.lost
    }

    pub fn set_lost(&mut self, lost: Option<Cause>) {
        self.lost = lost;
    }

    /// Whether it is back in Offboard with the next setpoint.
    pub fn ends_with_setpoints(&self) -> bool {
        self.lost == Some(Cause::OffboardStream)
    }

    /// There is no remote control: what COM_OBL_RC_ACT would hand over to a pilot is a return (NAV_RCL_ACT).
    pub fn check_offboard(&self, now: &Situation<'_>, timers: &Timers) -> Option<Proposal> {
        if now.mode() != Mode::Offboard || has_offboard_stream(now, timers) {
            return None;
        }
        let mode = match now.get(Parameter::OffboardLossAction) as u8 {
            4 => Mode::Land,
            5 => Mode::Loiter,
            _ => Mode::Rtl,
        };
        let proposal = Proposal::new(Cause::OffboardStream, Action::Mode(mode));
        Some(proposal.saying(Severity::Critical, "Failsafe activated: no offboard signal"))
    }

    /// In the air a mode of the sticks goes on only while somebody holds them: else it returns (NAV_RCL_ACT).
    pub fn check_sticks(&self, now: &Situation<'_>, are_sticks_held: bool) -> Option<Proposal> {
        let needs_hands = now.mode().is_manual() && now.flight.is_flying() && !now.flight.is_on_ground();
        if !needs_hands || are_sticks_held {
            return None;
        }
        let proposal = Proposal::new(Cause::Sticks, Action::Mode(Mode::Rtl));
        Some(proposal.saying(Severity::Critical, "Failsafe activated: manual control lost"))
    }

    /// First Hold for COM_FAIL_ACT_T, then what NAV_DLL_ACT says.
    pub fn check_ground(&mut self, now: &Situation<'_>, timers: &mut Timers, events: &mut Events) -> Option<Proposal> {
        let mode = match now.get(Parameter::DataLinkLossAction) as u8 {
            1 => Mode::Loiter,
            2 => Mode::Rtl,
            3 => Mode::Land,
            _ => return None,
        };
        let is_heard = is_ground_heard(now, timers);
        if matches!(self.lost, Some(Cause::GroundHold | Cause::GroundLost)) && is_heard {
            // It stays in the mode that it is in.
            self.lost = None;
            events.say(Severity::Info, "GCS connection regained");
            return None;
        }
        if self.lost == Some(Cause::GroundHold) {
            let is_over = timers.is_over(Timer::GroundHold, now.time);
            let proposal = || Proposal::new(Cause::GroundLost, Action::Mode(mode));
            return is_over.then(|| proposal().saying(Severity::Critical, "Failsafe activated: GCS connection lost"));
        }
        if self.lost.is_some() || is_heard || is_excepted(now) {
            return None;
        }
        let delay_s = now.get(Parameter::FailsafeDelay);
        timers.set(Timer::GroundHold, now.time + Duration::try_from_secs_f32(delay_s).unwrap_or_default());
        let text = format!("Failsafe activated: entering Hold for {delay_s} seconds");
        Some(Proposal::new(Cause::GroundHold, Action::Mode(Mode::Loiter)).saying(Severity::Critical, text))
    }
}

/// Whether setpoints have come of late.
pub(crate) fn has_offboard_stream(now: &Situation<'_>, timers: &Timers) -> bool {
    let timeout_s = now.get(Parameter::OffboardTimeout);
    // In lockstep time stands still between setpoints.
    now.is_in_lockstep
        || timers.since(Timer::OffboardStream, now.time).is_some_and(|since| since.as_secs_f32() <= timeout_s)
}

fn is_ground_heard(now: &Situation<'_>, timers: &Timers) -> bool {
    // It waits as long for the first heartbeat.
    let silent = timers.since(Timer::GroundStation, now.time).unwrap_or(now.time);
    silent.as_secs_f32() <= now.get(Parameter::DataLinkTimeout)
}

/// COM_DLL_EXCEPT: bit 0 missions, bit 1 Hold, take-off, returning and Guided Course, bit 2 Offboard. A landing goes on
/// (`Failsafe::isFailsafeIgnored`).
fn is_excepted(now: &Situation<'_>) -> bool {
    let exceptions = now.get(Parameter::DataLinkExceptions) as u8;
    let bit = match now.mode() {
        Mode::Auto => 1,
        Mode::Loiter | Mode::Takeoff | Mode::Rtl | Mode::Course => 2,
        Mode::Offboard => 4,
        Mode::Land => return true,
        _ => 0,
    };
    exceptions & bit != 0
}
