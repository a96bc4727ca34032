//! What COMMAND_LONG and COMMAND_INT make the vehicle do, accepted and refused as ArduPlane does.
//!
//! Where it differs: param 3 of GUIDED_CHANGE_ALTITUDE is the rate of climb that it is documented to be (broken in
//! ArduPlane since 4.6); terrain is as high as home; DO_CHANGE_SPEED counts after GUIDED_CHANGE_SPEED too; and of the params
//! that a command reads, one that is not a finite number is DENIED.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

mod message_requests;
mod preflight;
mod reposition;

use crate::error::Severity;
use crate::firmware::Personality;
use crate::mode::Mode;
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MavCmd, MavFrame, MavModeFlag, MavResult};
use mavlink_bridge::{CommandPosition, LatLonE7};

/// A command, whichever message carried it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Command {
    pub command: MavCmd,
    pub params: [f32; 4],
    /// Params 5 and 6, latitude and longitude.
    pub position: CommandPosition,
    /// Param 7 of COMMAND_LONG, z of COMMAND_INT.
    pub z: f32,
    /// MAV_FRAME.
    pub frame: u8,
}

/// Why a command is not obeyed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub result: MavResult,
    /// For a STATUSTEXT.
    pub reason: Option<String>,
    /// How loud the reason is said.
    pub severity: Severity,
}

/// Altitudes that are no more than that, m either way, can be stored by ArduPilot.
pub(crate) const ALTITUDE_MAX_M: f32 = 83_000.0;

impl Command {
    /// A command as it came; none if the dialect does not know it, or its frame.
    pub fn read(wire: &mavlink_bridge::Command) -> Option<Self> {
        let command = wire.mav_cmd()?;
        let frame = match wire.frame {
            Some(_) => wire.mav_frame()?,
            // A COMMAND_LONG has no frame: ArduPilot reads its altitudes as above home, and home's as above sea level.
            None if command == MavCmd::MAV_CMD_DO_SET_HOME => MavFrame::MAV_FRAME_GLOBAL,
            None => MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
        };
        Some(Self { command, params: wire.params, position: wire.position, z: wire.z, frame: frame as u8 })
    }

    /// DO_SET_MODE, for the SET_MODE message that came before it, which has a PX4's main and sub mode in one number. Modes
    /// are exact in an f32 up to 2^24; beyond that there are none.
    pub fn set_mode(personality: Personality, custom: bool, custom_mode: u32) -> Self {
        let base_mode = if custom { MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.bits() } else { 0 };
        let (main, sub) = match personality {
            Personality::Px4 => (custom_mode >> 16 & 0xFF, custom_mode >> 24),
            Personality::ArduPlane | Personality::Generic => (custom_mode, 0),
        };
        Self {
            command: MavCmd::MAV_CMD_DO_SET_MODE,
            params: [f32::from(base_mode), main as f32, sub as f32, 0.0],
            position: CommandPosition::Long([0.0; 2]),
            z: 0.0,
            frame: MavFrame::MAV_FRAME_GLOBAL as u8,
        }
    }

    /// Latitude and longitude, whichever message carried them. A cast of what is too large takes the bound, which is no
    /// place, and of what is no number, 0.
    pub fn lat_lon(&self) -> LatLonE7 {
        match self.position {
            CommandPosition::Int(position) => position,
            CommandPosition::Long(degrees) => {
                let [latitude_e7, longitude_e7] = degrees.map(|degrees| (f64::from(degrees) * 1e7) as i32);
                LatLonE7 { latitude_e7, longitude_e7 }
            }
        }
    }
}

impl Refusal {
    pub fn new(result: MavResult, reason: impl Into<String>) -> Self {
        Self { result, reason: Some(reason.into()), severity: Severity::Warning }
    }

    /// The same, as no warning: ground stations ask every vehicle whether it has this and that, and read warnings aloud.
    pub fn quietly(self) -> Self {
        Self { severity: Severity::Info, ..self }
    }

    pub fn denied(reason: impl Into<String>) -> Self {
        Self::new(MavResult::MAV_RESULT_DENIED, reason)
    }

    pub fn failed(reason: impl Into<String>) -> Self {
        Self::new(MavResult::MAV_RESULT_FAILED, reason)
    }

    pub fn unsupported() -> Self {
        Self { result: MavResult::MAV_RESULT_UNSUPPORTED, reason: None, severity: Severity::Info }
    }
}

/// Params are compared as integers with what follows the point cut off, as ArduPlane does.
pub(crate) fn integer(param: f32) -> i64 {
    param as i64
}

/// A direction in degrees, in rad.
pub(crate) fn angle_rad(degrees: f32) -> f64 {
    flight_model::wrap_pi(f64::from(degrees).to_radians())
}

pub(crate) fn check_finite(name: &str, values: &[f32]) -> Result<(), Refusal> {
    if values.iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(Refusal::denied(format!("{name}: a parameter is not finite")))
    }
}

impl Vehicle {
    /// Obeys a command that came over a link, or says why not; nothing is changed then.
    pub(crate) fn execute(&mut self, command: &Command, link: usize) -> Result<(), Refusal> {
        let own = self.autopilot.execute_as_personality(command);
        if let Some(outcome) = own.or_else(|| self.execute_standard_mode(command, link)) {
            return outcome;
        }
        let [p1, p2, p3, _] = command.params;
        match command.command {
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => self.autopilot.arm_or_disarm([p1, p2]),
            MavCmd::MAV_CMD_RUN_PREARM_CHECKS => self.autopilot.run_prearm_checks(),
            MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION if self.autopilot.settings.personality != Personality::Px4 => {
                self.autopilot.calibrate([p1, p3])
            }
            MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN => self.reboot(p1),
            MavCmd::MAV_CMD_DO_SET_HOME => self.autopilot.do_set_home(command),
            MavCmd::MAV_CMD_DO_SET_MODE => self.autopilot.change_mode(p1, p2),
            MavCmd::MAV_CMD_NAV_LOITER_UNLIM => self.autopilot.enter(Mode::Loiter),
            MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => self.autopilot.enter(Mode::Rtl),
            MavCmd::MAV_CMD_MISSION_START => self.autopilot.start_mission([p1, p2]),
            MavCmd::MAV_CMD_DO_LAND_START => self.autopilot.start_landing(),
            MavCmd::MAV_CMD_DO_RETURN_PATH_START => self.autopilot.start_return_path(),
            MavCmd::MAV_CMD_DO_GO_AROUND => self.autopilot.go_around(p1),
            MavCmd::MAV_CMD_DO_SET_MISSION_CURRENT => self.autopilot.set_current_mission_item(p1),
            MavCmd::MAV_CMD_DO_JUMP_TAG if self.autopilot.settings.personality != Personality::Px4 => {
                self.autopilot.jump_to_tag(p1)
            }
            MavCmd::MAV_CMD_DO_FENCE_ENABLE => self.autopilot.enable_fence([p1, p2]),
            // ArduPlane takes it for quadplanes alone.
            MavCmd::MAV_CMD_NAV_TAKEOFF => Err(Refusal::failed("Takeoff: set mode TAKEOFF, or AUTO with NAV_TAKEOFF")),
            MavCmd::MAV_CMD_DO_REPOSITION => self.autopilot.reposition(command),
            MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED => self.autopilot.guided_speed([p1, p2, p3]),
            MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE => self.autopilot.guided_altitude(p3, command.z, command.frame),
            MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => self.autopilot.guided_heading([p1, p2, p3]),
            MavCmd::MAV_CMD_DO_CHANGE_SPEED => self.autopilot.change_speed([p1, p2, p3]),
            MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => self.autopilot.change_altitude([p1, p2]),
            MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => self.tell_message_interval(p1, link),
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => self.set_message_interval([p1, p2], link),
            MavCmd::MAV_CMD_REQUEST_MESSAGE => self.request_message([p1, p2], link),
            MavCmd::MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES => {
                self.answer_old_request(p1, Stream::AutopilotVersion, link)
            }
            MavCmd::MAV_CMD_REQUEST_PROTOCOL_VERSION => self.answer_old_request(p1, Stream::ProtocolVersion, link),
            MavCmd::MAV_CMD_GET_HOME_POSITION => {
                self.send_stream(link, Stream::HomePosition);
                Ok(())
            }
            _ => Err(Refusal::unsupported()),
        }
    }
}
