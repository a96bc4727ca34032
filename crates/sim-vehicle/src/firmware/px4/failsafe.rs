//! What a PX4 does by itself: the failsafes of the offboard stream and of the ground station, Hold after a take-off, and
//! disarming on the ground (`failsafe.cpp`, `Commander.cpp`).

use super::commands::ends_a_flight;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MavSeverity, MavType};
use std::time::Duration;

/// For want of whom the vehicle flies as it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failsafe {
    /// Of setpoints: with the next one it is back in Offboard.
    Offboard,
    /// Of the ground station: it holds until this vehicle time, and then does what NAV_DLL_ACT says.
    GroundHold { until: Duration },
    /// Of the ground station.
    Ground,
    /// Of a hand on the sticks: it stays so until somebody sets a mode.
    Sticks,
}

impl Failsafe {
    pub(super) fn ends_with_setpoints(self) -> bool {
        self == Failsafe::Offboard
    }
}

impl Vehicle {
    /// A heartbeat: of any ground station, and of nobody else.
    pub(crate) fn px4_hear_heartbeat(&mut self, kind: MavType) {
        if kind == MavType::MAV_TYPE_GCS {
            self.px4.ground_heard = Some(self.time);
        }
    }

    pub(in crate::firmware) fn follow_px4(&mut self) {
        self.px4_follow_calibration();
        if !self.flight.is_armed() {
            self.px4.armed_at = None;
            if std::mem::take(&mut self.px4.was_armed) {
                self.restore_mode();
            }
            return;
        }
        self.px4.was_armed = true;
        self.hold_after_take_off();
        self.check_offboard_stream();
        self.check_sticks();
        self.check_data_link();
        self.disarm_idle();
    }

    /// Disarmed, it leaves the modes that it cannot be armed in, and take-off.
    fn restore_mode(&mut self) {
        self.px4.failsafe = None;
        if ends_a_flight(self.mode()) || self.mode() == Mode::Takeoff {
            self.set_mode(self.px4.mode_to_restore.unwrap_or(Mode::Loiter));
        }
    }

    /// Take-off is over when it circles at its altitude.
    fn hold_after_take_off(&mut self) {
        if self.mode() == Mode::Takeoff && self.flight.is_flying() && !self.flight.is_taking_off() {
            let altitude_m = self.flight.state().altitude_m + self.flight.altitude_error_m();
            self.set_mode(Mode::Loiter);
            self.flight.set_altitude(altitude_m, f64::INFINITY);
        }
    }

    /// There is no remote control: what COM_OBL_RC_ACT would hand over to a pilot is a return (NAV_RCL_ACT).
    fn check_offboard_stream(&mut self) {
        if self.mode() != Mode::Offboard || self.has_offboard_stream() {
            return;
        }
        let mode = match self.parameters.get(Parameter::OffboardLossAction) as u8 {
            4 => Mode::Land,
            5 => Mode::Loiter,
            _ => Mode::Rtl,
        };
        self.begin_px4_failsafe(Failsafe::Offboard, mode, "Failsafe activated: no offboard signal");
    }

    /// In the air a mode of the sticks goes on only while somebody holds them: else it returns (NAV_RCL_ACT).
    fn check_sticks(&mut self) {
        if self.mode().is_manual() && self.flight.is_flying() && !self.flight.is_on_ground() && !self.are_sticks_held()
        {
            self.begin_px4_failsafe(Failsafe::Sticks, Mode::Rtl, "Failsafe activated: manual control lost");
        }
    }

    /// First Hold for COM_FAIL_ACT_T, then what NAV_DLL_ACT says.
    fn check_data_link(&mut self) {
        let action = self.parameters.get(Parameter::DataLinkLossAction) as u8;
        let mode = match action {
            1 => Mode::Loiter,
            2 => Mode::Rtl,
            3 => Mode::Land,
            _ => return,
        };
        let is_for_ground = matches!(self.px4.failsafe, Some(Failsafe::GroundHold { .. } | Failsafe::Ground));
        if is_for_ground && self.is_ground_heard() {
            // It stays in the mode that it is in.
            self.px4.failsafe = None;
            self.say(MavSeverity::MAV_SEVERITY_INFO, "GCS connection regained");
            return;
        }
        if let Some(Failsafe::GroundHold { until }) = self.px4.failsafe {
            if self.time >= until {
                self.begin_px4_failsafe(Failsafe::Ground, mode, "Failsafe activated: GCS connection lost");
            }
            return;
        }
        if self.px4.failsafe.is_some() || self.is_ground_heard() || self.is_excepted_from_data_link() {
            return;
        }
        let delay_s = self.parameters.get(Parameter::FailsafeDelay);
        let until = self.time + Duration::try_from_secs_f32(delay_s).unwrap_or_default();
        let text = format!("Failsafe activated: entering Hold for {delay_s} seconds");
        self.begin_px4_failsafe(Failsafe::GroundHold { until }, Mode::Loiter, &text);
    }

    fn is_ground_heard(&self) -> bool {
        let timeout_s = self.parameters.get(Parameter::DataLinkTimeout);
        // It waits as long for the first heartbeat.
        let heard = self.px4.ground_heard.unwrap_or_default();
        self.time.saturating_sub(heard).as_secs_f32() <= timeout_s
    }

    /// COM_DLL_EXCEPT: bit 0 missions, bit 1 Hold, take-off and Guided Course, bit 2 Offboard. Landing and returning go on.
    fn is_excepted_from_data_link(&self) -> bool {
        let exceptions = self.parameters.get(Parameter::DataLinkExceptions) as u8;
        let bit = match self.mode() {
            Mode::Auto => 1,
            Mode::Loiter | Mode::Takeoff | Mode::Course => 2,
            Mode::Offboard => 4,
            Mode::Land | Mode::Rtl => return true,
            _ => 0,
        };
        exceptions & bit != 0
    }

    /// COM_DISARM_PRFLT after it was armed it has not yet flown; below 0: never.
    fn disarm_idle(&mut self) {
        if self.flight.is_flying() {
            self.px4.armed_at = None;
        }
        let delay_s = self.parameters.get(Parameter::PreflightDisarmDelay);
        let Some(armed_at) = self.px4.armed_at.filter(|_| delay_s >= 0.0) else { return };
        let is_idle = self.flight.state().speed_mps == 0.0;
        if is_idle && self.time.saturating_sub(armed_at).as_secs_f32() >= delay_s {
            self.disarm();
            self.px4_announce("Disarmed by auto preflight disarming");
        }
    }

    /// The mode that somebody has set is left, and what was left of it is kept by the failsafe.
    fn begin_px4_failsafe(&mut self, failsafe: Failsafe, mode: Mode, text: &str) {
        self.set_mode(mode);
        self.px4.failsafe = Some(failsafe);
        self.counters.failsafes += 1;
        self.px4_announce(text);
    }
}
