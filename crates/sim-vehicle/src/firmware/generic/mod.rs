//! No autopilot in particular, for authors of their own controllers: ArduPlane's numbers, commands and parameters, and
//! beside them take-off and landing as commands, MAVLink's standard modes, and position targets of every kind.

use super::rules::{CommandSet, Rules, TargetSet};
use super::targets::{PositionTarget, TargetError, fly_target};
use super::{arduplane, px4};
use crate::autopilot::Autopilot;
use crate::autopilot::input::{check_finite, integer};
use crate::error::CommandError;
use crate::error::Severity;
use crate::mode::Mode;
use crate::protocol::command::request::Command;
use mavlink_bridge::dialect::{
    MavAutopilot, MavCmd, MavModeFlag, MavParamType, SET_POSITION_TARGET_GLOBAL_INT_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};

/// No autopilot in particular.
pub(super) const RULES: Rules = Rules {
    name: "generic",
    product: "Columba",
    autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
    version: [0, 0, 0],

    custom_mode,
    base_mode,
    modes: &MODES,
    has_standard_modes: true,
    returns_without_mission: false,

    commands: CommandSet::Generic,
    targets: TargetSet::Generic,
    acknowledges_set_mode: true,
    tells_origin: true,

    tells_arming_reason: false,

    first_mission_item: 0,
    resumes_after_upload: false,
    takes_off_before_mission: true,
    return_item_stays_current: false,
    nan_params_are_left_out: true,
    upload_can_be_broken_off: true,
    asks_by_old_message: false,
    mission_mode_suspended: 2,

    // Clients do not agree on how an unknown autopilot encodes whole numbers: it has none.
    parameter: |parameter| (parameter.name(), MavParamType::MAV_PARAM_TYPE_REAL32),
    tells_whole_numbers_as_floats: true,
    more_streams: &[],
    ..arduplane::RULES
};

/// ArduCopter's number of LAND, which ArduPlane leaves free.
const LAND: u32 = 9;

/// Where ArduPlane has ACRO and FBWB, PX4 has the modes that fly by themselves and Offboard. MAVSDK takes any unknown
/// autopilot for a PX4.
const PX4_AUTO: i64 = 4;
const PX4_OFFBOARD: i64 = 6;

/// The modes that a client can set.
pub(super) const MODES: [Mode; 11] = [
    Mode::Manual,
    Mode::Circle,
    Mode::Stabilize,
    Mode::Fbwa,
    Mode::Cruise,
    Mode::Land,
    Mode::Auto,
    Mode::Rtl,
    Mode::Loiter,
    Mode::Takeoff,
    Mode::Guided,
];

/// ArduPlane's numbers, and one of LAND.
pub(super) fn custom_mode(mode: Mode) -> u32 {
    if mode == Mode::Land { LAND } else { mode.number() }
}

/// The flags of HEARTBEAT as MAVLink describes them: nobody looks up the custom modes of an unknown autopilot.
pub(super) fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED;
    flags.set(MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED, mode.is_manual());
    flags.set(MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED, !mode.is_manual());
    flags.set(MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED, !mode.is_manual() && mode != Mode::Guided);
    flags.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, armed);
    flags
}

pub(super) fn execute(autopilot: &mut Autopilot, command: &Command) -> Option<Result<(), CommandError>> {
    let [p1, p2, p3, _] = command.params;
    Some(match command.command {
        MavCmd::MAV_CMD_DO_SET_MODE if p2 == LAND as f32 => autopilot.enter(Mode::Land),
        MavCmd::MAV_CMD_DO_SET_MODE if matches!(integer(p2), PX4_AUTO | PX4_OFFBOARD) => {
            px4::commands::commanded_mode([p1, p2, p3]).and_then(|mode| enter_as_px4(autopilot, mode))
        }
        MavCmd::MAV_CMD_NAV_LAND => autopilot.enter(Mode::Land),
        MavCmd::MAV_CMD_NAV_TAKEOFF => take_off(autopilot, command),
        _ => return None,
    })
}

fn enter_as_px4(autopilot: &mut Autopilot, mode: Mode) -> Result<(), CommandError> {
    match mode {
        Mode::Offboard => autopilot.enter(Mode::Guided),
        mode if MODES.contains(&mode) => autopilot.enter(mode),
        mode => Err(CommandError::failed(format!("No mode {}", px4::modes::mode_name(mode)))),
    }
}

/// z: the altitude, above what the frame says; not a number, or 0: TKOFF_ALT above home.
fn take_off(autopilot: &mut Autopilot, command: &Command) -> Result<(), CommandError> {
    if command.z.is_infinite() {
        check_finite("Takeoff", &[command.z])?;
    }
    if !autopilot.flight.is_armed() {
        return Err(CommandError::failed("Takeoff: not armed"));
    }
    let altitude_m = match command.z {
        z if z.is_nan() || z == 0.0 => None,
        z => Some(autopilot.altitude_m("Takeoff", z, command.frame)?),
    };
    autopilot.enter(Mode::Takeoff)?;
    if let Some(altitude_m) = altitude_m {
        autopilot.flight.take_off(altitude_m.max(autopilot.flight.state().altitude_m));
    }
    Ok(())
}

pub(super) fn take_local(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
    let target = PositionTarget::from_local(data, autopilot.flight.state().course_rad);
    take_target(autopilot, target);
}

pub(super) fn take_global(autopilot: &mut Autopilot, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
    let target = PositionTarget::from_global(
        data,
        |position| autopilot.reference().locate(position),
        |altitude_m, frame| autopilot.altitude_m("Setpoint", altitude_m, frame).ok(),
    );
    take_target(autopilot, target);
}

/// In GUIDED all is flown that asks for a place, a velocity, an altitude or a rate of climb.
fn take_target(autopilot: &mut Autopilot, target: Result<PositionTarget, TargetError>) {
    let reason = match target {
        Ok(_) if autopilot.mode() != Mode::Guided => format!("mode is {}", autopilot.mode()),
        Ok(target) if target.is_flyable() => {
            autopilot.count_setpoint();
            fly_target(autopilot, &target);
            autopilot.restart_setpoint_timeout();
            return;
        }
        Ok(target) => format!("mask {:#05x} is not followed", target.mask),
        Err(error) => error.to_string(),
    };
    autopilot.refuse_setpoint(Severity::Warning, &format!("Setpoint refused: {reason}"));
}
