//! Arming and disarming, what stands against it, and what follows on the ground.

use crate::autopilot::Autopilot;
use crate::autopilot::failsafe::battery;
use crate::autopilot::flight::ground::TouchDown;
use crate::autopilot::mission::items::{LAND_START, RETURN_PATH_START};
use crate::autopilot::mission::progress::Progress;
use crate::autopilot::timer::Timer;
use crate::error::{CommandError, Severity};
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use crate::world::GpsSettings;
use std::time::Duration;

/// Param 2 of COMPONENT_ARM_DISARM: whatever stands against it.
const FORCE: f32 = 21196.0;
/// The same, of older ground stations, to arm only.
const FORCE_ARMING: f32 = 2989.0;

/// Bits of ARMING_CHECK (`AP_Arming.h`).
const CHECK_ALL: u32 = 1;
const CHECK_GPS: u32 = 1 << 3;
const CHECK_PARAMETERS: u32 = 1 << 5;
const CHECK_RECEIVER: u32 = 1 << 6;
const CHECK_BATTERY: u32 = 1 << 8;
const CHECK_MISSION: u32 = 1 << 14;

/// What an autopilot is armed or disarmed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    Command,
    MissionStart,
    Landing,
    Parachute,
    /// It was armed and has not flown.
    Idle,
}

impl Autopilot {
    /// Param 1: 1 to arm, 0 to disarm. Param 2: 21196 by force, as ArduPlane: in the air it is disarmed only so.
    pub(crate) fn arm_or_disarm(&mut self, [p1, p2]: [f32; 2]) -> Result<(), CommandError> {
        let is_armed = self.flight.is_armed();
        if p1 == 1.0 {
            if is_armed {
                return Ok(());
            }
            let is_forced = p2 == FORCE || p2 == FORCE_ARMING;
            if let Some(reason) = self.against_arming_now(false).filter(|_| !is_forced) {
                let severity = Severity::Critical;
                return Err(CommandError { severity, ..CommandError::failed(format!("Arm: {reason}")) });
            }
            self.arm_after_checks();
        } else if p1 == 0.0 {
            if is_armed && self.flight.is_flying() && p2 != FORCE {
                return Err(CommandError::failed("Disarm: it is flying"));
            }
            if is_armed {
                self.disarm(Cause::Command);
            }
        } else {
            return Err(CommandError::unsupported());
        }
        Ok(())
    }

    /// The pilot asks for it by the rudder stick.
    pub(super) fn arm_by_rudder(&mut self) {
        match self.against_arming_now(true) {
            Some(reason) => self.say(Severity::Critical, &format!("Arm: {reason}")),
            None => self.arm_after_checks(),
        }
    }

    fn arm_after_checks(&mut self) {
        if self.parameters.get(Parameter::ArmingCheck) == 0.0 {
            self.say(Severity::Warning, "Warning: Arming Checks Disabled");
        }
        self.arm(Cause::Command);
    }

    /// Why it does not arm at this moment: what stands against it anyway, or where the sticks are.
    fn against_arming_now(&self, by_rudder: bool) -> Option<String> {
        let sticks = || self.is_checked(CHECK_RECEIVER).then(|| self.against_sticks(by_rudder)).flatten();
        self.against_arming().or_else(sticks)
    }

    /// ARMING_CHECK says which of the checks are made that may be left out.
    fn is_checked(&self, check: u32) -> bool {
        self.parameters.get(Parameter::ArmingCheck) as u32 & (CHECK_ALL | check) != 0
    }

    /// RUN_PREARM_CHECKS: accepted, and what stands against arming comes in words.
    pub(crate) fn run_prearm_checks(&mut self) -> Result<(), CommandError> {
        if self.flight.is_armed() {
            return Err(CommandError::rejected("PreArm: it is armed"));
        }
        if let Some(reason) = self.against_arming() {
            self.say(Severity::Critical, &format!("PreArm: {reason}"));
        }
        Ok(())
    }

    /// Why the vehicle would not arm now, if so.
    pub(crate) fn against_arming(&self) -> Option<String> {
        let is_checked = |check: u32| self.is_checked(check);
        let lands_by_rtl = self.parameters.get(Parameter::RtlAutoland) != 0.0;
        let is_amiss = |command: u16| {
            is_checked(CHECK_MISSION)
                && !lands_by_rtl
                && self.mission.numbered().any(|(_, item)| item.command == command)
        };
        if self.flight.is_armed() {
            None
        } else if self.mode() == Mode::Rtl {
            Some("RTL mode not armable".into())
        } else if self.mode() == Mode::Auto && !self.mission.is_flyable() && self.rules.returns_without_mission {
            Some("Mode requires mission".into())
        } else if is_amiss(LAND_START) {
            Some("DO_LAND_START set and RTL_AUTOLAND disabled".into())
        } else if is_amiss(RETURN_PATH_START) {
            Some("DO_RETURN_PATH_START set and RTL_AUTOLAND disabled".into())
        } else if is_checked(CHECK_GPS) && !GpsSettings::of(&self.parameters).has_fix() {
            Some("GPS 1: Bad fix".into())
        } else if is_checked(CHECK_RECEIVER) && self.has_failed_receiver() {
            Some("Radio failsafe on".into())
        } else if let Some(reason) = self.parachute_forbids_arming().filter(|_| is_checked(CHECK_PARAMETERS)) {
            Some(reason)
        } else {
            let battery = if is_checked(CHECK_BATTERY) { battery::forbids_arming(&self.situation()) } else { None };
            battery.or_else(|| self.session.fence.forbids_arming(&self.situation()))
        }
    }

    /// An ArduPlane says unasked what stands against arming, at once and then every half minute.
    pub(crate) fn tell_what_is_against_arming(&mut self) {
        const AGAIN_AFTER: Duration = Duration::from_secs(30);
        // Often enough: nobody looks at it between two heartbeats.
        let is_due = self.time.subsec_nanos() == 0 && self.rules.tells_arming_reason;
        if !is_due || self.flight.is_armed() {
            return;
        }
        let reason = self.against_arming();
        let is_new = reason != self.session.arming_reason;
        if let Some(text) =
            reason.as_ref().filter(|_| is_new || !self.session.timers.is_running(Timer::ArmingReason, self.time))
        {
            self.session.timers.set(Timer::ArmingReason, self.time + AGAIN_AFTER);
            self.say(Severity::Critical, &format!("PreArm: {text}"));
        }
        self.session.arming_reason = reason;
    }

    /// Arms it. On the ground home is where it stands, unless somebody has set another.
    pub(crate) fn arm(&mut self, cause: Cause) {
        if self.flight.is_on_ground() && !self.session.home_is_set {
            self.set_home_here();
        }
        if self.mode() == Mode::Auto {
            self.session.progress.begin(&self.mission);
        }
        self.flight.arm();
        self.tell_fence_of_arming();
        self.restart_setpoint_timeout();
        self.say(Severity::Info, (self.rules.words.armed)(cause));
        if self.mode() == Mode::Auto {
            self.tell_mission_begins();
        }
    }

    pub(crate) fn disarm(&mut self, cause: Cause) {
        self.flight.disarm();
        self.have_disarmed(cause);
    }

    fn have_disarmed(&mut self, cause: Cause) {
        self.tell_fence_of_arming();
        self.stop_setpoint_timeout();
        // In AUTO ArduPlane stays where the mission has come to.
        if self.mode() != Mode::Auto {
            self.session.progress = Progress::at_beginning(&self.mission);
        }
        self.say(Severity::Info, (self.rules.words.disarmed)(cause));
    }

    /// Whether it flies, or has flown since it was switched on.
    pub(crate) fn has_flown(&self) -> bool {
        self.flight.is_flying() || self.session.timers.since(Timer::Flown, self.time).is_some()
    }

    fn tell_fence_of_arming(&mut self) {
        self.session.fence.arming_changed(self.flight.is_armed(), &self.parameters, &mut self.events);
    }

    /// Moves the vehicle on by one integration step, and does what follows from it on the ground.
    pub(crate) fn step_flight(&mut self) {
        self.move_sticks();
        let (was_armed, was_flying) = (self.flight.is_armed(), self.flight.is_flying());
        let touch_down = self.flight.step();
        if let Some([lift_off, landing]) = self.rules.words.contact {
            if self.flight.is_flying() != was_flying {
                self.say(Severity::Info, if was_flying { landing } else { lift_off });
            }
        } else if let Some(TouchDown { sink_mps }) = touch_down {
            self.say(Severity::Info, &format!("SIM Hit ground at {sink_mps:.6} m/s"));
        }
        if was_armed && !self.flight.is_armed() {
            self.have_disarmed(Cause::Landing);
        }
        if self.flight.is_flying() {
            self.session.timers.set(Timer::Flown, self.time);
        } else if self.flight.is_armed() && self.flight.is_on_ground() && self.flight.is_landing() {
            self.disarm_after_landing();
        }
    }

    /// LAND_DISARMDELAY after it has last flown; 0: never.
    fn disarm_after_landing(&mut self) {
        let delay = Duration::from_secs(self.parameters.get(Parameter::DisarmDelay) as u64);
        let since = self.session.timers.since(Timer::Flown, self.time).unwrap_or(self.time);
        if !delay.is_zero() && since >= delay {
            self.disarm(Cause::Landing);
            if let Some(text) = self.rules.words.disarmed_after_landing {
                self.say(Severity::Info, text);
            }
        }
    }
}
