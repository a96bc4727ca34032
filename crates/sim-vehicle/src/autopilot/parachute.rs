//! A parachute that commands, missions and failsafes release (`ArduPlane/parachute.cpp`). It stops the engine; the
//! vehicle then glides down, as in ArduPilot's own simulation, which has no canopy unless SIM_PARA_ENABLE says so.

use super::Autopilot;
use super::arming::Cause;
use crate::autopilot::input::integer;
use crate::error::{CommandError, Severity};
use crate::parameters::table::Parameter;

/// Values of param 1 of DO_PARACHUTE, as its low 16 bits.
const DISABLE: u16 = 0;
const ENABLE: u16 = 1;
const RELEASE: u16 = 2;

/// Less above home, m, it is not released by hand once it has flown: ArduPilot's default of CHUTE_ALT_MIN.
const LEAST_M: f64 = 10.0;

impl Autopilot {
    /// DO_PARACHUTE as a command.
    pub(crate) fn command_parachute(&mut self, action: f32) -> Result<(), CommandError> {
        match integer(action) as u16 {
            RELEASE => self.release_parachute_by_hand(),
            action => self.enable_parachute(action),
        }
    }

    /// DO_PARACHUTE in a mission, which releases it at any height.
    pub(crate) fn use_parachute(&mut self, action: f32) {
        match integer(action) as u16 {
            RELEASE => self.release_parachute(),
            action => {
                let _ = self.enable_parachute(action);
            }
        }
    }

    pub(crate) fn is_parachute_enabled(&self) -> bool {
        self.parameters.get(Parameter::ParachuteEnabled) != 0.0
    }

    /// Why it does not let it arm.
    pub(super) fn parachute_forbids_arming(&self) -> Option<String> {
        // SERVO5_FUNCTION and its kin are not read.
        self.is_parachute_enabled().then(|| "Chute has no channel".into())
    }

    fn enable_parachute(&mut self, action: u16) -> Result<(), CommandError> {
        let value = match action {
            DISABLE => 0.0,
            ENABLE => 1.0,
            _ => return Err(CommandError::failed("Parachute: param 1 is 0, 1 or 2")),
        };
        self.set_parameter(Parameter::ParachuteEnabled, value).map_err(|error| CommandError::failed(error.to_string()))
    }

    fn release_parachute_by_hand(&mut self) -> Result<(), CommandError> {
        let height_m = self.flight.estimate().altitude_m - self.flight.home().altitude_m;
        let reason = if self.session.parachute_is_released {
            "Parachute already released"
        } else if !self.is_parachute_enabled() {
            "Parachute not enabled"
        } else if self.flight.is_flying() && height_m < LEAST_M {
            "Parachute: Too low"
        } else {
            self.release_parachute();
            return Ok(());
        };
        Err(CommandError::failed(reason))
    }

    /// Releases it, if it is enabled.
    pub(crate) fn release_parachute(&mut self) {
        if !self.is_parachute_enabled() {
            return self.say(Severity::Warning, "Parachute not enabled");
        }
        let before = std::mem::replace(&mut self.session.parachute_is_released, true);
        self.say(Severity::Critical, if before { "Parachute: Released again" } else { "Parachute: Released" });
        if self.flight.is_armed() {
            self.disarm(Cause::Parachute);
        }
    }
}
