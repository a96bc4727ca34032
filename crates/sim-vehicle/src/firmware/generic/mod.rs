//! No autopilot in particular, for authors of their own controllers: ArduPlane's numbers, commands and parameters, and
//! beside them take-off and landing as commands, MAVLink's standard modes, and position targets of every kind.

use crate::firmware::px4;
use crate::firmware::targets::{PositionTarget, TargetRefused};
use crate::mode::Mode;
use crate::protocol::command::{Command, Refusal, check_finite, integer};
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{
    MavCmd, MavModeFlag, MavSeverity, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};

/// There is none.
pub(super) const VERSION: [u8; 3] = [0, 0, 0];

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

impl Vehicle {
    pub(super) fn execute_generic(&mut self, command: &Command) -> Option<Result<(), Refusal>> {
        let [p1, p2, p3, _] = command.params;
        Some(match command.command {
            MavCmd::MAV_CMD_DO_SET_MODE if p2 == LAND as f32 => self.enter(Mode::Land),
            MavCmd::MAV_CMD_DO_SET_MODE if matches!(integer(p2), PX4_AUTO | PX4_OFFBOARD) => {
                px4::commanded_mode([p1, p2, p3]).and_then(|mode| self.enter_as_px4(mode))
            }
            MavCmd::MAV_CMD_NAV_LAND => self.enter(Mode::Land),
            MavCmd::MAV_CMD_NAV_TAKEOFF => self.generic_take_off(command),
            _ => return None,
        })
    }

    fn enter_as_px4(&mut self, mode: Mode) -> Result<(), Refusal> {
        match mode {
            Mode::Offboard => self.enter(Mode::Guided),
            mode if MODES.contains(&mode) => self.enter(mode),
            mode => Err(Refusal::failed(format!("No mode {}", px4::mode_name(mode)))),
        }
    }

    /// z: the altitude, above what the frame says; not a number, or 0: TKOFF_ALT above home.
    fn generic_take_off(&mut self, command: &Command) -> Result<(), Refusal> {
        if command.z.is_infinite() {
            check_finite("Takeoff", &[command.z])?;
        }
        if !self.flight.is_armed() {
            return Err(Refusal::failed("Takeoff: not armed"));
        }
        let altitude_m = match command.z {
            z if z.is_nan() || z == 0.0 => None,
            z => Some(self.altitude_m("Takeoff", z, command.frame)?),
        };
        self.enter(Mode::Takeoff)?;
        if let Some(altitude_m) = altitude_m {
            self.flight.take_off(altitude_m.max(self.flight.state().altitude_m));
        }
        Ok(())
    }

    pub(super) fn generic_take_local_target(&mut self, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
        let target = PositionTarget::from_local(data, self.flight.state().course_rad);
        self.generic_take_target(target);
    }

    pub(super) fn generic_take_global_target(&mut self, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
        let target = PositionTarget::from_global(
            data,
            |position| self.to_local(position),
            |altitude_m, frame| self.altitude_m("Setpoint", altitude_m, frame).ok(),
        );
        self.generic_take_target(target);
    }

    /// In GUIDED all is flown that asks for a place, a velocity, an altitude or a rate of climb.
    fn generic_take_target(&mut self, target: Result<PositionTarget, TargetRefused>) {
        let reason = match target {
            Ok(_) if self.mode() != Mode::Guided => format!("mode is {}", self.mode()),
            Ok(target) if target.is_flyable() => {
                self.counters.setpoints_accepted += 1;
                self.fly_target(&target);
                self.restart_setpoint_timeout();
                return;
            }
            Ok(target) => format!("mask {:#05x} is not followed", target.mask),
            Err(reason) => reason,
        };
        self.refuse_setpoint(MavSeverity::MAV_SEVERITY_WARNING, &format!("Setpoint refused: {reason}"));
    }
}
