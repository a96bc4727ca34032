//! What a PX4 answers to commands where an ArduPlane answers otherwise (`Commander::handle_command`, `navigator_main.cpp`).
//!
//! What it is not able to do now is TEMPORARILY_REJECTED; on the ground and disarmed any mode can be set, and arming is
//! what is refused.

use super::{MODES, SELECTABLE, mode_name, params};
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::protocol::command::{Command, Refusal, angle_rad, check_finite, integer};
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MavCmd, MavFrame, MavModeFlag, MavResult, MavSeverity};
use mavlink_bridge::{CommandPosition, LatLonE7, PlanItem};

/// Param 2 of COMPONENT_ARM_DISARM: by force, to disarm in the air.
const FORCE: f32 = 21196.0;

fn rejected(reason: impl Into<String>) -> Refusal {
    Refusal::new(MavResult::MAV_RESULT_TEMPORARILY_REJECTED, reason)
}

impl Vehicle {
    /// The answer of a PX4; none if it is that of every vehicle.
    pub(in crate::firmware) fn execute_px4(&mut self, command: &Command) -> Option<Result<(), Refusal>> {
        if let Err(refusal) = params::check_command(command) {
            return Some(Err(refusal));
        }
        let [p1, p2, p3, _] = command.params;
        Some(match command.command {
            // They are all vehicles' own.
            MavCmd::MAV_CMD_DO_SET_STANDARD_MODE
            | MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL
            | MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL
            | MavCmd::MAV_CMD_REQUEST_MESSAGE
            | MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN => return None,
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => self.px4_arm_or_disarm(p1, p2),
            MavCmd::MAV_CMD_DO_SET_MODE => commanded_mode([p1, p2, p3]).and_then(|mode| self.px4_change_mode(mode)),
            MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => self.px4_change_mode(Mode::Rtl),
            MavCmd::MAV_CMD_NAV_LAND => self.px4_change_mode(Mode::Land),
            MavCmd::MAV_CMD_NAV_TAKEOFF => self.px4_take_off(command.z),
            MavCmd::MAV_CMD_MISSION_START => self.px4_start_mission(p1),
            MavCmd::MAV_CMD_DO_LAND_START => self.px4_start_landing(),
            MavCmd::MAV_CMD_DO_GO_AROUND => {
                // It is accepted whether there is a landing to give up or not.
                let _ = self.go_around(0.0);
                Ok(())
            }
            MavCmd::MAV_CMD_DO_REPOSITION => self.px4_reposition(command),
            MavCmd::MAV_CMD_DO_ORBIT => self.px4_orbit(command),
            MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => self.px4_change_altitude(p1),
            MavCmd::MAV_CMD_DO_CHANGE_SPEED => self.px4_change_speed(p2),
            MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => self.px4_change_heading(p1, p2),
            MavCmd::MAV_CMD_DO_SET_HOME => self.px4_set_home(command),
            _ => return Some(self.px4_prepare(command)),
        })
    }

    fn px4_arm_or_disarm(&mut self, p1: f32, p2: f32) -> Result<(), Refusal> {
        check_finite("Arm", &[p1])?;
        match p1.round() as i64 {
            1 if self.flight.is_armed() => Ok(()),
            1 => self.px4_arm(),
            0 if self.flight.is_armed() && self.flight.is_flying() && p2 != FORCE => {
                Err(rejected("Disarming denied: not landed"))
            }
            0 => {
                if self.flight.is_armed() {
                    self.disarm();
                }
                Ok(())
            }
            _ => {
                let reason = format!("Unsupported ARM_DISARM param: {p1:.3}");
                Err(Refusal::new(MavResult::MAV_RESULT_UNSUPPORTED, reason))
            }
        }
    }

    /// PX4 checks what it is told from outside even where that is by force.
    fn px4_arm(&mut self) -> Result<(), Refusal> {
        let reason = match self.mode() {
            Mode::Offboard if !self.has_offboard_stream() => Some("No offboard signal"),
            Mode::Auto if !self.mission.is_flyable() => Some("No valid mission available"),
            mode if ends_a_flight(mode) => Some("Mode not armable"),
            mode if mode.is_manual() && !self.are_sticks_held() => Some("No manual control input"),
            _ => None,
        };
        if let Some(reason) = reason {
            return Err(rejected(format!("Arming denied: {reason}")));
        }
        self.arm();
        if let Some(altitude_m) = self.px4.takeoff_altitude_m.take().filter(|_| self.mode() == Mode::Takeoff) {
            self.flight.take_off(altitude_m);
        }
        self.px4.armed_at = self.flight.is_on_ground().then_some(self.time);
        Ok(())
    }

    /// Sets a mode that can be flown now; disarmed, any.
    pub(in crate::firmware) fn px4_change_mode(&mut self, mode: Mode) -> Result<(), Refusal> {
        let can_run = match mode {
            Mode::Offboard => self.has_offboard_stream(),
            Mode::Auto => self.mission.is_flyable(),
            // Of remote controls there is only what a ground station sends.
            mode if mode.is_manual() => self.are_sticks_held(),
            _ => true,
        };
        if self.flight.is_armed() && !can_run {
            let name = mode_name(mode);
            return Err(rejected(format!("{name} is currently not available")));
        }
        if !ends_a_flight(mode) && mode != Mode::Takeoff {
            self.px4.mode_to_restore = Some(mode);
        }
        self.set_mode(mode);
        Ok(())
    }

    /// z: m above sea level; not a number: MIS_TAKEOFF_ALT above home.
    fn px4_take_off(&mut self, z: f32) -> Result<(), Refusal> {
        let altitude_m = self.px4_altitude_m(z)?;
        // Set already, it takes the new altitude.
        if self.mode() != Mode::Takeoff {
            self.px4_change_mode(Mode::Takeoff)?;
        }
        self.px4.takeoff_altitude_m = None;
        let here_m = self.flight.state().altitude_m;
        if z.is_nan() {
            return Ok(());
        }
        if altitude_m <= here_m {
            self.say(MavSeverity::MAV_SEVERITY_CRITICAL, "Already higher than takeoff altitude");
        } else if self.flight.is_armed() {
            self.flight.take_off(altitude_m);
        } else {
            self.px4.takeoff_altitude_m = Some(altitude_m);
        }
        Ok(())
    }

    /// Param 1: the first item, which it begins with. It arms, too.
    fn px4_start_mission(&mut self, p1: f32) -> Result<(), Refusal> {
        if !self.mission.is_flyable() {
            return Err(Refusal::denied("Mission start denied! No valid mission"));
        }
        if !(-1.0..f32::from(self.mission.len())).contains(&p1) {
            return Err(Refusal::denied("Mission start denied! No such item"));
        }
        if p1 >= 0.0 {
            self.set_current_item(integer(p1) as u16, true)?;
        }
        self.px4_change_mode(Mode::Auto)?;
        if self.flight.is_armed() { Ok(()) } else { self.px4_arm() }
    }

    /// DO_LAND_START: the mission, from its landing on.
    fn px4_start_landing(&mut self) -> Result<(), Refusal> {
        let Some(seq) = self.mission_landing() else {
            return Err(Refusal::new(MavResult::MAV_RESULT_CANCELLED, "Planned mission landing not available"));
        };
        self.set_current_item(seq, true)?;
        self.px4_change_mode(Mode::Auto)?;
        if self.flight.is_armed() { Ok(()) } else { self.px4_arm() }
    }

    /// DO_SET_HOME. Param 1: 1 for where it is; else a place above sea level in any frame, all of it given.
    fn px4_set_home(&mut self, command: &Command) -> Result<(), Refusal> {
        if command.params[0] > 0.5 {
            self.set_home_here();
            self.home_is_set = true;
            return Ok(());
        }
        let position = place("Home", command)?;
        if position.is_some_and(|position| position.is_zero()) {
            self.set_home_here();
            self.home_is_set = true;
            return Ok(());
        }
        let Some(position) = position else {
            return Err(Refusal::denied("Home: no place is given"));
        };
        if !command.z.is_finite() {
            return Err(Refusal::denied("Home: no altitude is given"));
        }
        let altitude_m = self.px4_altitude_m(command.z)?;
        self.set_home_at(self.to_local(position), altitude_m);
        self.home_is_set = true;
        Ok(())
    }

    /// Takes note whether a mission can be flown, and says why not.
    pub(crate) fn px4_judge_mission(&mut self, items: &[PlanItem]) {
        let home_m = self.flight.home().altitude_m;
        let verdict = super::check_mission(items, !self.flight.is_flying(), |item| self.altitude_of(item) - home_m);
        self.mission.is_feasible = verdict.is_ok();
        if let Err(reason) = verdict {
            self.say(MavSeverity::MAV_SEVERITY_CRITICAL, &reason);
        }
    }

    /// Whether a message has content: no place to fly to is told on the ground, and sticks that nobody holds.
    pub(crate) fn px4_has(&self, stream: Stream) -> bool {
        match stream {
            Stream::NavControllerOutput | Stream::PositionTargetGlobalInt | Stream::PositionTargetLocalNed => {
                self.flight.is_flying()
            }
            Stream::RcChannels => self.are_sticks_held(),
            // It has one sensor of each.
            Stream::ScaledImu2 | Stream::ScaledImu3 | Stream::ScaledPressure2 => false,
            // For a radio link of its own.
            Stream::HighLatency2 => false,
            _ => true,
        }
    }

    /// Param 1: m/s, or -1. Param 2: 1 to go into Hold. Param 3: radius in m. x, y: a place, or where it is. z: m above sea
    /// level, whatever the frame.
    fn px4_reposition(&mut self, command: &Command) -> Result<(), Refusal> {
        let [speed_mps, change_mode, radius_m, _] = command.params;
        let changes = integer(change_mode) & 1 != 0;
        if !changes && self.mode() != Mode::Loiter {
            return Err(Refusal::denied(format!("Reposition: mode is {}", self.mode_name())));
        }
        let place = place("Reposition", command)?;
        if speed_mps.is_infinite() {
            check_finite("Reposition", &[speed_mps])?;
        }
        let altitude_m = self.px4_altitude_m(command.z)?;
        if place.is_some() || self.mode() != Mode::Course {
            self.set_mode(Mode::Loiter);
            let state = self.flight.state();
            let at = place.map_or((state.x_m, state.y_m), |place| self.to_local(place));
            let radius_m = if radius_m.is_finite() && radius_m != 0.0 {
                f64::from(radius_m)
            } else {
                self.flight.tuning().loiter_radius_m
            };
            self.flight.reposition(at, radius_m);
        }
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        if speed_mps > 0.0 {
            self.px4_set_speed(speed_mps);
        }
        Ok(())
    }

    /// DO_ORBIT, which a fixed wing flies as Hold. Param 1: radius in m, below zero anticlockwise. x, y: a place, or where it is.
    /// z: m above sea level, whatever the frame.
    fn px4_orbit(&mut self, command: &Command) -> Result<(), Refusal> {
        let radius_m = match command.params[0] {
            radius_m if radius_m.is_infinite() => return Err(Refusal::denied("Orbit: radius is not finite")),
            radius_m if radius_m.is_nan() || radius_m == 0.0 => self.flight.tuning().loiter_radius_m,
            radius_m => f64::from(radius_m),
        };
        let place = place("Orbit", command)?;
        let altitude_m = self.px4_altitude_m(command.z)?;
        self.px4_change_mode(Mode::Loiter)?;
        let state = self.flight.state();
        let at = place.map_or((state.x_m, state.y_m), |place| self.to_local(place));
        self.flight.reposition(at, radius_m);
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        Ok(())
    }

    /// Param 1: m above sea level; param 2, a frame, is not read.
    fn px4_change_altitude(&mut self, z: f32) -> Result<(), Refusal> {
        if !matches!(self.mode(), Mode::Loiter | Mode::Course) {
            return Err(rejected(format!("Altitude: mode is {}", self.mode_name())));
        }
        let altitude_m = self.px4_altitude_m(z)?;
        self.flight.set_altitude(altitude_m, f64::INFINITY);
        Ok(())
    }

    /// Param 2: m/s; not above 0: FW_AIRSPD_TRIM. Accepted in any mode, and without effect in Offboard.
    fn px4_change_speed(&mut self, speed_mps: f32) -> Result<(), Refusal> {
        check_finite("Speed", &[speed_mps])?;
        if self.mode() != Mode::Offboard {
            let trim_mps = self.parameters.get(Parameter::AirspeedCruise);
            self.px4_set_speed(if speed_mps > 0.0 { speed_mps } else { trim_mps });
        }
        Ok(())
    }

    /// Param 1: 0, course over ground. Param 2: degrees.
    fn px4_change_heading(&mut self, kind: f32, course_deg: f32) -> Result<(), Refusal> {
        if self.mode() != Mode::Course {
            return Err(Refusal::denied(format!("Heading: mode is {}", self.mode_name())));
        }
        check_finite("Heading", &[kind, course_deg])?;
        if kind.round() != 0.0 {
            return Err(Refusal::denied("Heading: only a course can be set"));
        }
        self.flight.set_course(angle_rad(course_deg), f64::INFINITY);
        Ok(())
    }

    /// Cut to FW_AIRSPD_MIN and FW_AIRSPD_MAX.
    fn px4_set_speed(&mut self, speed_mps: f32) {
        let (least, most) = (self.parameters.get(Parameter::AirspeedMin), self.parameters.get(Parameter::AirspeedMax));
        self.flight.set_speed(f64::from(speed_mps.clamp(least, most)), f64::INFINITY);
    }

    /// An altitude above sea level as one above the origin, m; the present one for what is no number.
    fn px4_altitude_m(&self, z: f32) -> Result<f64, Refusal> {
        if z.is_nan() {
            return Ok(self.flight.state().altitude_m);
        }
        self.altitude_m("Altitude", z, MavFrame::MAV_FRAME_GLOBAL as u8)
    }

    /// Says what PX4 says of a mode that it changes to by itself.
    pub(super) fn px4_announce(&mut self, text: &str) {
        self.say(MavSeverity::MAV_SEVERITY_CRITICAL, text);
    }
}

/// A place that a command may leave out.
fn place(name: &str, command: &Command) -> Result<Option<LatLonE7>, Refusal> {
    let is_given = match command.position {
        CommandPosition::Int(position) => position != LatLonE7::new(i32::MAX, i32::MAX),
        CommandPosition::Long(degrees) => degrees.iter().all(|degrees| degrees.is_finite()),
    };
    let place = is_given.then(|| command.lat_lon());
    if place.is_some_and(|place| !place.is_valid()) {
        return Err(Refusal::denied(format!("{name}: no such place")));
    }
    Ok(place)
}

/// The modes in which a PX4 is not armed.
pub(super) fn ends_a_flight(mode: Mode) -> bool {
    matches!(mode, Mode::Rtl | Mode::Land)
}

/// The mode that the flags of MAVLink's older base modes mean.
fn base_mode_of(flags: MavModeFlag) -> Result<Mode, Refusal> {
    if flags.contains(MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED) {
        return Ok(Mode::Auto);
    }
    if !flags.contains(MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED) {
        return Err(rejected("Unsupported base mode"));
    }
    Ok(if flags.contains(MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED) {
        Mode::Cruise
    } else if flags.contains(MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED) {
        Mode::Stabilize
    } else {
        Mode::Manual
    })
}

/// Params of DO_SET_MODE: flags, main mode, sub mode.
pub(in crate::firmware) fn commanded_mode([base_mode, main, sub]: [f32; 3]) -> Result<Mode, Refusal> {
    let flags = MavModeFlag::from_bits_truncate(integer(base_mode) as u8);
    if !flags.contains(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED) {
        return base_mode_of(flags);
    }
    // AUTO without more is the mission, and the sub mode counts in AUTO alone.
    let (main, sub) = match (integer(main), integer(sub)) {
        (4, 0) => (4, 4),
        (4, sub) => (4, sub),
        (main, _) => (main, 0),
    };
    let found = MODES
        .into_iter()
        .find(|(mode, m, s, _)| SELECTABLE.contains(mode) && (i64::from(*m), i64::from(*s)) == (main, sub));
    match found {
        Some((mode, ..)) => Ok(mode),
        None if main == 4 => Err(rejected("Unsupported auto mode")),
        None => Err(rejected("Unsupported main mode")),
    }
}
