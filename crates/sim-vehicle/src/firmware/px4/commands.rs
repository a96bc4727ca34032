//! What a PX4 answers to commands where an ArduPlane answers otherwise (`Commander::handle_command`,
//! `navigator_main.cpp`).
//!
//! What it is not able to do now is TEMPORARILY_REJECTED; on the ground and disarmed any mode can be set, and arming is
//! what is refused.

// Clients still speak what the dialect calls superseded, and autopilots answer.
#![allow(deprecated)]

use super::modes::{MODES, SELECTABLE, mode_name};
use super::{params, preflight};
use crate::autopilot::Autopilot;
use crate::autopilot::arming::Cause;
use crate::autopilot::habits::ends_a_flight;
use crate::autopilot::home::Home;
use crate::autopilot::input::{angle_rad, check_finite, integer};
use crate::error::Severity;
use crate::error::{CommandError, CommandResult};
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use crate::protocol::command::request::Command;
use mavlink_bridge::dialect::{MavCmd, MavFrame, MavModeFlag};
use mavlink_bridge::{CommandPosition, LatLonE7};
use nalgebra::Vector2;

/// Param 2 of COMPONENT_ARM_DISARM: by force, to disarm in the air.
const FORCE: f32 = 21196.0;

/// How a COMMAND_INT leaves a position out.
const NO_POSITION: LatLonE7 = LatLonE7 { latitude_e7: i32::MAX, longitude_e7: i32::MAX };

/// The answer of a PX4, if it is not that of an ArduPlane.
pub(in crate::firmware) fn execute(autopilot: &mut Autopilot, command: &Command) -> Option<Result<(), CommandError>> {
    if let Err(refusal) = params::check_command(command) {
        return Some(Err(refusal));
    }
    let [p1, p2, p3, _] = command.params;
    Some(match command.command {
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => arm_or_disarm(autopilot, p1, p2),
        MavCmd::MAV_CMD_DO_SET_MODE => commanded_mode([p1, p2, p3]).and_then(|mode| change_mode(autopilot, mode)),
        MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => go_home(autopilot, Mode::Rtl, "Returning to launch"),
        // Of precision landings what is left without a beacon.
        MavCmd::MAV_CMD_NAV_LAND | MavCmd::MAV_CMD_NAV_LAND_LOCAL => {
            go_home(autopilot, Mode::Land, "Landing at current position")
        }
        MavCmd::MAV_CMD_NAV_TAKEOFF => take_off(autopilot, command),
        MavCmd::MAV_CMD_MISSION_START => start_mission(autopilot, p1),
        MavCmd::MAV_CMD_DO_REPOSITION => reposition(autopilot, command),
        MavCmd::MAV_CMD_DO_ORBIT => orbit(autopilot, command),
        MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => change_altitude(autopilot, p1),
        MavCmd::MAV_CMD_DO_CHANGE_SPEED => change_speed(autopilot, p2),
        MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => change_heading(autopilot, p1, p2),
        MavCmd::MAV_CMD_DO_LAND_START => start_landing(autopilot),
        MavCmd::MAV_CMD_DO_GO_AROUND => {
            // It is accepted whether there is a landing to give up or not.
            let _ = autopilot.go_around(0.0);
            Ok(())
        }
        MavCmd::MAV_CMD_DO_SET_HOME => set_home(autopilot, command),
        MavCmd::MAV_CMD_EXTERNAL_POSITION_ESTIMATE => estimate_position(command),
        // They are all vehicles' own.
        MavCmd::MAV_CMD_DO_SET_STANDARD_MODE
        | MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL
        | MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL
        | MavCmd::MAV_CMD_REQUEST_MESSAGE => return None,
        _ => preflight::execute(autopilot, command),
    })
}

/// Neither of these modes is ever refused.
fn go_home(autopilot: &mut Autopilot, mode: Mode, text: &str) -> Result<(), CommandError> {
    autopilot.say(Severity::Info, text);
    change_mode(autopilot, mode)
}

fn arm_or_disarm(autopilot: &mut Autopilot, p1: f32, p2: f32) -> Result<(), CommandError> {
    check_finite("Arm", &[p1])?;
    match p1.round() as i64 {
        1 if autopilot.flight.is_armed() => Ok(()),
        1 => arm(autopilot, Cause::Command),
        0 if autopilot.flight.is_armed() && autopilot.flight.is_flying() && p2 != FORCE => {
            Err(CommandError::rejected("Disarming denied: not landed"))
        }
        0 => {
            if autopilot.flight.is_armed() {
                autopilot.disarm(Cause::Command);
            }
            Ok(())
        }
        _ => {
            // Its commander answers what it does not know, but not a param of what it does.
            Err(CommandError::unanswered(format!("Unsupported ARM_DISARM param: {p1:.3}")))
        }
    }
}

/// PX4 checks what it is told from outside even where that is by force.
fn arm(autopilot: &mut Autopilot, cause: Cause) -> Result<(), CommandError> {
    let reason = match autopilot.mode() {
        Mode::Offboard if !autopilot.has_offboard_stream() => Some("No offboard signal"),
        Mode::Auto if !autopilot.mission().is_flyable() => Some("No valid mission available"),
        mode if ends_a_flight(mode) => Some("Mode not armable"),
        mode if mode.is_manual() && !autopilot.are_sticks_held() => Some("No manual control input"),
        _ => None,
    };
    if let Some(reason) = reason {
        return Err(CommandError::rejected(format!("Arming denied: {reason}")));
    }
    autopilot.arm(cause);
    if let Some(altitude_m) =
        autopilot.session.habits.take_takeoff_altitude_m().filter(|_| autopilot.mode() == Mode::Takeoff)
    {
        autopilot.flight.take_off(altitude_m);
    }
    autopilot.begin_idle_timer();
    Ok(())
}

/// Sets a mode that can be flown now; disarmed, any.
pub(in crate::firmware) fn change_mode(autopilot: &mut Autopilot, mode: Mode) -> Result<(), CommandError> {
    // One that was rejected stays it until another one comes.
    if mode == Mode::Auto && autopilot.mission().is_flyable() {
        autopilot.judge_mission_anew();
    }
    let can_run = match mode {
        Mode::Offboard => autopilot.has_offboard_stream(),
        Mode::Auto => autopilot.mission().is_flyable(),
        // Of remote controls there is only what a ground station sends.
        mode if mode.is_manual() => autopilot.are_sticks_held(),
        _ => true,
    };
    if autopilot.flight.is_armed() && !can_run {
        let name = mode_name(mode);
        return Err(CommandError::rejected(format!("Switching to {name} is currently not available")));
    }
    if !ends_a_flight(mode) && mode != Mode::Takeoff {
        autopilot.session.habits.restore_later(mode);
    }
    autopilot.set_mode(mode);
    Ok(())
}

/// x, y: a place to circle afterwards, 0 or none for where it is then. z: m above sea level; not a number:
/// MIS_TAKEOFF_ALT above home.
fn take_off(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let z = command.z;
    let altitude_m = altitude_m(autopilot, z)?;
    let place = place("Takeoff", command)?.filter(|at| at.latitude_e7 != 0 && at.longitude_e7 != 0);
    let place = place.map(|at| autopilot.reference().locate(at));
    // Set already, it takes the new altitude.
    if autopilot.mode() != Mode::Takeoff {
        change_mode(autopilot, Mode::Takeoff)?;
    }
    autopilot.session.habits.set_takeoff_altitude_m(None);
    autopilot.session.habits.set_takeoff_place(place);
    let here_m = autopilot.flight.state().altitude_m;
    if z.is_nan() {
        let usual_m = autopilot.parameters.get(Parameter::TakeoffAltitude);
        autopilot.say(Severity::Info, &format!("Using default takeoff altitude: {usual_m:.1} m"));
        return Ok(());
    }
    if altitude_m <= here_m {
        autopilot.say(Severity::Critical, "Already higher than takeoff altitude");
    } else if autopilot.flight.is_armed() {
        autopilot.flight.take_off(altitude_m);
    } else {
        autopilot.session.habits.set_takeoff_altitude_m(Some(altitude_m));
    }
    Ok(())
}

/// Param 1: the first item, which it begins with. It arms, too.
fn start_mission(autopilot: &mut Autopilot, p1: f32) -> Result<(), CommandError> {
    if !autopilot.mission().is_flyable() {
        return Err(CommandError::denied("Mission start denied! No valid mission"));
    }
    if !(-1.0..f32::from(autopilot.mission().len())).contains(&p1) {
        return Err(CommandError::denied("Mission start denied! No such item"));
    }
    if p1 >= 0.0 {
        autopilot.set_current_mission_item([p1, 1.0])?;
    }
    change_mode(autopilot, Mode::Auto)?;
    if autopilot.flight.is_armed() { Ok(()) } else { arm(autopilot, Cause::MissionStart) }
}

/// DO_LAND_START: the mission, from its landing on.
fn start_landing(autopilot: &mut Autopilot) -> Result<(), CommandError> {
    let Some(seq) = autopilot.mission_landing() else {
        return Err(CommandError::new(CommandResult::Cancelled, "Planned mission landing not available"));
    };
    autopilot.set_current_item(seq, true)?;
    change_mode(autopilot, Mode::Auto)?;
    if autopilot.flight.is_armed() { Ok(()) } else { arm(autopilot, Cause::MissionStart) }
}

/// DO_SET_HOME. Param 1: 1 for where it is; else a place above sea level in any frame, all of it given.
fn set_home(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let position = place("Home", command)?;
    if command.params[0] > 0.5 {
        autopilot.set_home_here();
        autopilot.session.home_is_set = true;
        return Ok(());
    }
    let Some(position) = position else {
        return Err(CommandError::denied("Home: no place is given"));
    };
    if !command.z.is_finite() {
        return Err(CommandError::denied("Home: no altitude is given"));
    }
    let altitude_m = altitude_m(autopilot, command.z)?;
    let position_m = autopilot.reference().locate(position);
    autopilot.set_home(Home { x_m: position_m.x, y_m: position_m.y, altitude_m });
    autopilot.session.home_is_set = true;
    Ok(())
}

/// Param 1: m/s, or -1. Param 2: 1 to go into Hold. Param 3: radius in m. x, y: a place, or where it is. z: m above sea
/// level, whatever the frame.
fn reposition(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let [speed_mps, change_mode, radius_m, _] = command.params;
    let changes = integer(change_mode) & 1 != 0;
    if !changes && autopilot.mode() != Mode::Loiter {
        return Err(CommandError::denied(format!("Reposition: mode is {}", autopilot.mode_name())));
    }
    let place = place("Reposition", command)?;
    let altitude_m = altitude_m(autopilot, command.z)?;
    // Without a place it goes on round the one that it circles.
    let circled = autopilot.flight.circled().filter(|_| autopilot.mode() == Mode::Loiter && place.is_none());
    if place.is_some() || autopilot.mode() != Mode::Course {
        autopilot.set_mode(Mode::Loiter);
    }
    let at = place.map_or(autopilot.flight.state().position_m(), |place| autopilot.reference().locate(place));
    if is_outside_fence(autopilot, at, altitude_m) {
        autopilot.say(Severity::Critical, "Reposition is outside geofence");
        return Ok(());
    }
    if autopilot.mode() == Mode::Loiter {
        let usual_m = autopilot.flight.tuning().loiter_radius_m;
        let wanted_m = if radius_m.is_finite() && radius_m != 0.0 { f64::from(radius_m) } else { usual_m };
        let (at, radius_m) = circled.unwrap_or((at, wanted_m));
        autopilot.flight.reposition(at, radius_m);
    }
    autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
    if speed_mps > 0.0 && speed_mps.is_finite() {
        set_speed(autopilot, speed_mps);
    }
    Ok(())
}

/// DO_ORBIT, which a fixed wing flies as Hold. Param 1: radius in m, below zero anticlockwise. x, y: a place, or where
/// it is. z: m above sea level, whatever the frame.
fn orbit(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    let radius_m = match command.params[0] {
        radius_m if !radius_m.is_finite() || radius_m == 0.0 => autopilot.flight.tuning().loiter_radius_m,
        radius_m => f64::from(radius_m),
    };
    let place = place("Orbit", command)?;
    let altitude_m = altitude_m(autopilot, command.z)?;
    change_mode(autopilot, Mode::Loiter)?;
    let at = place.map_or(autopilot.flight.state().position_m(), |place| autopilot.reference().locate(place));
    if is_outside_fence(autopilot, at, altitude_m) {
        autopilot.say(Severity::Critical, "Orbit is outside geofence");
        return Ok(());
    }
    autopilot.flight.reposition(at, radius_m);
    autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
    Ok(())
}

/// Param 1: m above sea level; param 2, a frame, is not read.
fn change_altitude(autopilot: &mut Autopilot, z: f32) -> Result<(), CommandError> {
    if !matches!(autopilot.mode(), Mode::Loiter | Mode::Course) {
        return Err(CommandError::rejected(format!("Altitude: mode is {}", autopilot.mode_name())));
    }
    let altitude_m = altitude_m(autopilot, z)?;
    if is_outside_fence(autopilot, autopilot.flight.state().position_m(), altitude_m) {
        autopilot.say(Severity::Critical, "Altitude change is outside geofence");
        return Ok(());
    }
    autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
    Ok(())
}

/// Param 2: m/s; not above 0, or no number: FW_AIRSPD_TRIM. Accepted in any mode, and without effect in Offboard.
fn change_speed(autopilot: &mut Autopilot, speed_mps: f32) -> Result<(), CommandError> {
    if autopilot.mode() != Mode::Offboard {
        let trim_mps = autopilot.parameters.get(Parameter::AirspeedCruise);
        set_speed(autopilot, if speed_mps > 0.0 { speed_mps } else { trim_mps });
    }
    Ok(())
}

/// In a local frame the x and y of a COMMAND_INT are centimetres, and so no place for the estimator.
fn estimate_position(command: &Command) -> Result<(), CommandError> {
    const LOCAL: [u8; 8] = [1, 4, 7, 8, 9, 12, 20, 21];
    if matches!(command.position, CommandPosition::Int(_)) && LOCAL.contains(&command.frame) {
        return Err(CommandError::failed("Position: it is in a local frame"));
    }
    Ok(())
}

/// Param 1: 0, course over ground. Param 2: degrees.
fn change_heading(autopilot: &mut Autopilot, kind: f32, course_deg: f32) -> Result<(), CommandError> {
    // It is its navigator's, who listens once it is armed.
    if !autopilot.flight.is_armed() {
        return Err(CommandError::unanswered("Heading: it is disarmed"));
    }
    if autopilot.mode() != Mode::Course {
        return Err(CommandError::denied(format!("Heading: mode is {}", autopilot.mode_name())));
    }
    check_finite("Heading", &[kind, course_deg])?;
    if kind.round() != 0.0 {
        return Err(CommandError::denied("Heading: only a course can be set"));
    }
    autopilot.flight.set_course(angle_rad(course_deg), f64::INFINITY);
    Ok(())
}

fn is_outside_fence(autopilot: &Autopilot, at: Vector2<f64>, altitude_m: f64) -> bool {
    autopilot.session.fence.is_outside(&autopilot.situation(), at, altitude_m)
}

/// Cut to FW_AIRSPD_MIN and FW_AIRSPD_MAX.
fn set_speed(autopilot: &mut Autopilot, speed_mps: f32) {
    let (least, most) =
        (autopilot.parameters.get(Parameter::AirspeedMin), autopilot.parameters.get(Parameter::AirspeedMax));
    autopilot.flight.set_speed(f64::from(speed_mps.clamp(least, most)), f64::INFINITY);
}

/// An altitude above sea level as one above the origin, m; the present one for what is not finite.
fn altitude_m(autopilot: &Autopilot, z: f32) -> Result<f64, CommandError> {
    if !z.is_finite() {
        return Ok(autopilot.flight.state().altitude_m);
    }
    autopilot.altitude_m("Altitude", z, MavFrame::MAV_FRAME_GLOBAL as u8)
}

/// A place that a command may leave out.
fn place(name: &str, command: &Command) -> Result<Option<LatLonE7>, CommandError> {
    let is_given = match command.position {
        CommandPosition::Int(position) => position != NO_POSITION,
        CommandPosition::Long(degrees) => degrees.iter().all(|degrees| degrees.is_finite()),
    };
    let place = is_given.then(|| command.lat_lon());
    if place.is_some_and(|place| !place.is_valid()) {
        return Err(CommandError::denied(format!("{name}: no such place")));
    }
    Ok(place)
}

/// The mode that the flags of MAVLink's older base modes mean.
fn base_mode_of(flags: MavModeFlag) -> Result<Mode, CommandError> {
    if flags.contains(MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED) {
        return Ok(Mode::Auto);
    }
    if !flags.contains(MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED) {
        return Err(CommandError::rejected("Unsupported base mode"));
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
pub(in crate::firmware) fn commanded_mode([base_mode, main, sub]: [f32; 3]) -> Result<Mode, CommandError> {
    let flags = MavModeFlag::from_bits_truncate(integer(base_mode) as u8);
    if !flags.contains(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED) {
        return base_mode_of(flags);
    }
    // AUTO without more is the mission, and the sub mode counts in AUTO alone.
    let (main, sub) = match (integer(main), integer(sub)) {
        (4, 0) => (4, 4),
        // Without a beacon a precision landing is a landing.
        (4, 9) => (4, 6),
        (4, sub) => (4, sub),
        (main, _) => (main, 0),
    };
    let found = MODES
        .into_iter()
        .find(|(mode, m, s, _)| SELECTABLE.contains(mode) && (i64::from(*m), i64::from(*s)) == (main, sub));
    match found {
        Some((mode, ..)) => Ok(mode),
        None if main == 4 => Err(CommandError::rejected("Unsupported auto mode")),
        None => Err(CommandError::rejected("Unsupported main mode")),
    }
}
