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

use crate::firmware::Personality;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MavCmd, MavFrame, MavModeFlag, MavResult, MavSeverity};
use mavlink_bridge::{AltitudeDatum, CommandPosition, LatLonE7};

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
    pub severity: MavSeverity,
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
        Self { result, reason: Some(reason.into()), severity: MavSeverity::MAV_SEVERITY_WARNING }
    }

    /// The same, as no warning: ground stations ask every vehicle whether it has this and that, and read warnings aloud.
    pub fn quietly(self) -> Self {
        Self { severity: MavSeverity::MAV_SEVERITY_INFO, ..self }
    }

    pub fn denied(reason: impl Into<String>) -> Self {
        Self::new(MavResult::MAV_RESULT_DENIED, reason)
    }

    pub fn failed(reason: impl Into<String>) -> Self {
        Self::new(MavResult::MAV_RESULT_FAILED, reason)
    }

    pub fn unsupported() -> Self {
        Self { result: MavResult::MAV_RESULT_UNSUPPORTED, reason: None, severity: MavSeverity::MAV_SEVERITY_INFO }
    }
}

/// Params are compared as integers with what follows the point cut off, as ArduPlane does.
pub(crate) fn integer(param: f32) -> i64 {
    param as i64
}

/// A limit of zero means none.
fn limit_or_none(limit: f32) -> f64 {
    if limit == 0.0 { f64::INFINITY } else { f64::from(limit.abs()) }
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
        if let Some(outcome) = self.execute_as_personality(command, link) {
            return outcome;
        }
        let [p1, p2, p3, _] = command.params;
        match command.command {
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => self.arm_or_disarm([p1, p2]),
            MavCmd::MAV_CMD_RUN_PREARM_CHECKS => self.run_prearm_checks(),
            MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION => self.calibrate([p1, p3]),
            MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN => self.reboot(command),
            MavCmd::MAV_CMD_DO_SET_HOME => self.do_set_home(command),
            MavCmd::MAV_CMD_DO_SET_MODE => self.change_mode(p1, p2),
            MavCmd::MAV_CMD_NAV_LOITER_UNLIM => self.enter(Mode::Loiter),
            MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => self.enter(Mode::Rtl),
            MavCmd::MAV_CMD_MISSION_START => self.start_mission([p1, p2]),
            MavCmd::MAV_CMD_DO_LAND_START => self.start_landing(),
            MavCmd::MAV_CMD_DO_RETURN_PATH_START => self.start_return_path(),
            MavCmd::MAV_CMD_DO_GO_AROUND => self.go_around(p1),
            MavCmd::MAV_CMD_DO_SET_MISSION_CURRENT => self.set_current_mission_item([p1, p2], link),
            MavCmd::MAV_CMD_DO_JUMP_TAG => {
                self.jump_to_tag(p1)?;
                self.send_stream(link, Stream::MissionCurrent);
                Ok(())
            }
            MavCmd::MAV_CMD_DO_FENCE_ENABLE => self.enable_fence([p1, p2]),
            // ArduPlane takes it for quadplanes alone.
            MavCmd::MAV_CMD_NAV_TAKEOFF => Err(Refusal::failed("Takeoff: set mode TAKEOFF, or AUTO with NAV_TAKEOFF")),
            MavCmd::MAV_CMD_DO_REPOSITION => self.reposition(command),
            MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED => self.guided_speed([p1, p2, p3]),
            MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE => self.guided_altitude(p3, command.z, command.frame),
            MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => self.guided_heading([p1, p2, p3]),
            MavCmd::MAV_CMD_DO_CHANGE_SPEED => self.change_speed([p1, p2, p3]),
            MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => self.change_altitude([p1, p2]),
            MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => self.tell_message_interval(p1, link),
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => self.set_message_interval(command.params, command.z, link),
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

    /// Obeys a command with a value that the common dialect does not know: either the command itself, or, in a command
    /// that is known here, its frame.
    pub(crate) fn execute_by_number(&mut self, raw: &mavlink_bridge::Command) -> Result<(), Refusal> {
        const GUIDED_CHANGE_ALTITUDE: u16 = MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE as u32 as u16;
        const DO_REPOSITION: u16 = MavCmd::MAV_CMD_DO_REPOSITION as u32 as u16;
        const DO_SEND_BANNER: u16 = 42_428;
        const BATTERY_RESET: u16 = 42_651;
        let [p1, p2, ..] = raw.params;
        match raw.number {
            GUIDED_CHANGE_ALTITUDE => {
                self.check_guided_command("Altitude")?;
                Err(Refusal::denied("Altitude: unknown frame"))
            }
            DO_REPOSITION => Err(Refusal::denied("Reposition: unknown frame")),
            DO_SEND_BANNER if self.settings.personality != Personality::Px4 => {
                self.send_banner();
                Ok(())
            }
            BATTERY_RESET if self.settings.personality != Personality::Px4 => self.reset_battery([p1, p2]),
            number => self.answer_for_device(number, raw.params).unwrap_or(Err(Refusal::unsupported())),
        }
    }

    fn change_mode(&mut self, base_mode: f32, custom_mode: f32) -> Result<(), Refusal> {
        check_finite("Mode", &[base_mode, custom_mode])?;
        let custom_flag = i64::from(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.bits());
        if integer(base_mode) & custom_flag == 0 {
            return Err(Refusal::denied("Mode: only custom modes are known"));
        }
        // A cast of what is negative or too large takes the bound, which is no mode.
        let number = u32::try_from(integer(custom_mode)).unwrap_or(u32::MAX);
        let mode = Mode::from_number(number).map_err(|error| Refusal::failed(error.to_string()))?;
        self.enter(mode)
    }

    /// Sets a mode. AUTO needs a mission: without one an ArduPlane returns.
    pub(crate) fn enter(&mut self, mode: Mode) -> Result<(), Refusal> {
        let has_nothing_to_fly = mode == Mode::Auto && !self.mission.is_flyable();
        if has_nothing_to_fly && self.settings.personality != Personality::ArduPlane {
            return Err(Refusal::failed("Auto: no mission"));
        }
        if let Some(reason) = self.fence_forbids(mode) {
            return Err(Refusal::failed(reason));
        }
        if has_nothing_to_fly {
            self.say(MavSeverity::MAV_SEVERITY_INFO, "Mission complete, changing mode to RTL");
            self.set_mode(Mode::Rtl);
        } else {
            self.set_mode(mode);
        }
        Ok(())
    }

    /// Params 1 and 2: the first and the last item to fly, which ArduPlane does not let choose either.
    fn start_mission(&mut self, first_and_last: [f32; 2]) -> Result<(), Refusal> {
        if first_and_last != [0.0, 0.0] {
            return Err(Refusal::denied("Mission: first and last item must be 0"));
        }
        self.enter(Mode::Auto)
    }

    /// Param 1: the item. Param 2: 1 to begin counting jumps anew. Who asks is told the current item at once.
    fn set_current_mission_item(&mut self, [seq, reset]: [f32; 2], link: usize) -> Result<(), Refusal> {
        check_finite("Mission", &[seq])?;
        self.set_current_item(u16::try_from(integer(seq)).unwrap_or(u16::MAX), reset == 1.0)?;
        self.send_stream(link, Stream::MissionCurrent);
        Ok(())
    }

    fn check_guided_command(&self, name: &str) -> Result<(), Refusal> {
        match self.mode() {
            Mode::Guided => Ok(()),
            other => Err(Refusal::failed(format!("{name}: mode is {other}"))),
        }
    }

    fn check_speed(&self, speed_mps: f32) -> Result<(), Refusal> {
        let (least, most) = (self.parameters.get(Parameter::AirspeedMin), self.parameters.get(Parameter::AirspeedMax));
        if (least..=most).contains(&speed_mps) {
            Ok(())
        } else {
            let range = format!("[{least}, {most}]");
            Err(Refusal::failed(format!("Speed {speed_mps} m/s is outside {range}")))
        }
    }

    /// Param 1: type, only airspeed (0). Param 2: m/s. Param 3: acceleration in m/s2, 0 for at once, its sign ignored.
    fn guided_speed(&mut self, [kind, speed_mps, acceleration_mps2]: [f32; 3]) -> Result<(), Refusal> {
        self.check_guided_command("Speed")?;
        check_finite("Speed", &[kind, speed_mps, acceleration_mps2])?;
        if integer(kind) != 0 {
            return Err(Refusal::denied("Speed: only airspeed can be set"));
        }
        self.check_speed(speed_mps)?;
        self.restart_setpoint_timeout();
        // A repeat is accepted and changes nothing, not even the acceleration.
        if self.flight.speed_target_mps() != f64::from(speed_mps) {
            self.flight.set_speed(f64::from(speed_mps), limit_or_none(acceleration_mps2));
        }
        Ok(())
    }

    /// z: m, above what the frame says. Param 3: rate in m/s, 0 for as fast as it flies.
    fn guided_altitude(&mut self, rate_mps: f32, z: f32, frame: u8) -> Result<(), Refusal> {
        self.check_guided_command("Altitude")?;
        check_finite("Altitude", &[rate_mps])?;
        let altitude_m = self.guided_altitude_m("Altitude", z, frame)?;
        self.flight.slew_altitude(altitude_m, limit_or_none(rate_mps));
        self.restart_setpoint_timeout();
        Ok(())
    }

    /// An altitude of a guided command, in m above the origin.
    pub(crate) fn guided_altitude_m(&self, name: &str, z: f32, frame: u8) -> Result<f64, Refusal> {
        check_finite(name, &[z])?;
        if z == 0.0 || z == -1.0 {
            return Err(Refusal::denied(format!("{name}: {z} m is not accepted")));
        }
        self.altitude_m(name, z, frame)
    }

    /// An altitude that a command gives, in m above the origin: terrain is as high as home.
    pub(crate) fn altitude_m(&self, name: &str, z: f32, frame: u8) -> Result<f64, Refusal> {
        if z.abs() >= ALTITUDE_MAX_M {
            return Err(Refusal::denied(format!("{name}: {z:e} m is no altitude")));
        }
        let datum = AltitudeDatum::of_frame(frame)
            .ok_or_else(|| Refusal::denied(format!("{name}: frame {frame} is not accepted")))?;
        Ok(self.above_origin_m(datum, f64::from(z)))
    }

    /// An altitude above a datum as one above the origin, m: terrain is as high as home.
    pub(crate) fn above_origin_m(&self, datum: AltitudeDatum, altitude_m: f64) -> f64 {
        match datum {
            AltitudeDatum::MeanSeaLevel => altitude_m - self.settings.frame.origin().altitude_amsl_m,
            AltitudeDatum::Home | AltitudeDatum::Terrain => altitude_m + self.flight.home().altitude_m,
        }
    }

    /// Param 1: course over ground (0), heading (1), or neither any more (2). Param 2: degrees. Param 3: greatest lateral
    /// acceleration in m/s2, at least 0.05, and never more than the vehicle's own limit.
    fn guided_heading(&mut self, [kind, course_deg, lateral_mps2]: [f32; 3]) -> Result<(), Refusal> {
        self.check_guided_command("Heading")?;
        check_finite("Heading", &[kind, course_deg, lateral_mps2])?;
        if !(0.0..360.0).contains(&course_deg) {
            return Err(Refusal::denied(format!("Heading {course_deg} is outside [0, 360)")));
        }
        match integer(kind) {
            0 => self.flight.set_course(angle_rad(course_deg), f64::from(lateral_mps2).max(0.05)),
            1 => self.flight.set_heading(angle_rad(course_deg), f64::from(lateral_mps2).max(0.05)),
            2 => self.flight.release_course(),
            other => return Err(Refusal::denied(format!("Heading: type {other} is not accepted"))),
        }
        self.restart_setpoint_timeout();
        Ok(())
    }

    /// Param 1: altitude in m. Param 2: the frame that says above what. While a GUIDED_CHANGE_ALTITUDE is flown it is
    /// accepted and has no effect, as in ArduPlane.
    fn change_altitude(&mut self, [altitude_m, frame]: [f32; 2]) -> Result<(), Refusal> {
        check_finite("Altitude", &[altitude_m, frame])?;
        let number = u8::try_from(integer(frame)).ok().filter(|number| AltitudeDatum::of_frame(*number).is_some());
        let frame = number.ok_or_else(|| Refusal::denied(format!("Altitude: frame {frame} is not accepted")))?;
        let altitude_m = self.altitude_m("Altitude", altitude_m, frame)?;
        if self.mode().is_manual() {
            return Err(Refusal::denied(format!("Altitude: mode is {}", self.mode())));
        }
        if !self.flight.is_altitude_slewed() {
            self.flight.set_altitude(altitude_m, f64::INFINITY);
            self.restart_setpoint_timeout();
        }
        Ok(())
    }

    /// DO_CHANGE_SPEED, in GUIDED and AUTO.
    fn change_speed(&mut self, params: [f32; 3]) -> Result<(), Refusal> {
        if self.mode() != Mode::Auto {
            self.check_guided_command("Speed")?;
        }
        check_finite("Speed", &params[..2])?;
        self.change_speed_as_arduplane(params)
    }

    /// Param 1: airspeed (0), ground speed (1), or others, which an ArduPlane has not. Param 2: m/s, or -2 for
    /// AIRSPEED_CRUISE; a ground speed is the least one that it flies, as far as its airspeed may rise. Param 3: a throttle in
    /// percent, which is accepted where there is no speed, and has no effect on how this flight model flies.
    pub(crate) fn change_speed_as_arduplane(&mut self, [kind, speed_mps, throttle]: [f32; 3]) -> Result<(), Refusal> {
        let refused = match integer(kind) {
            0 if speed_mps == -2.0 => {
                let usual_mps = self.parameters.get(Parameter::AirspeedCruise);
                self.flight.set_speed(f64::from(usual_mps), f64::INFINITY);
                return Ok(());
            }
            0 => match self.check_speed(speed_mps) {
                Ok(()) => {
                    self.flight.set_speed(f64::from(speed_mps), f64::INFINITY);
                    self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("Set airspeed {speed_mps:.0} m/s"));
                    return Ok(());
                }
                Err(refusal) => refusal,
            },
            1 => {
                self.flight.set_least_ground_speed(f64::from(speed_mps));
                self.say(MavSeverity::MAV_SEVERITY_INFO, &format!("Set groundspeed {speed_mps:.0}"));
                return Ok(());
            }
            _ => Refusal::failed("Speed: only air and ground speed can be set"),
        };
        if throttle > 0.0 && throttle <= 100.0 { Ok(()) } else { Err(refused) }
    }
}
