//! Which autopilot a vehicle passes for: how it numbers its modes, what it says of itself, and which commands and
//! setpoints it takes.
//!
//! What is here is what differs; all else is the same for all of them, and ArduPlane's. Each autopilot is one module,
//! which reads as a page about it.

// Autopilots and ground stations still speak what the dialect calls superseded.
#![allow(deprecated)]

mod addressing;
mod arduplane;
mod generic;
mod modes;
mod offers;
pub(crate) mod px4;
mod targets;

pub(crate) use offers::Offer;
pub(crate) use px4::fence_area as px4_fence_area;

use crate::autopilot::mission;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::protocol::command::{Command, Refusal};
use crate::protocol::mission::PlanKind;
use crate::vehicle::Vehicle;

use mavlink_bridge::dialect::{
    MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, MavAutopilot, MavMissionResult, MavMissionType, MavModeFlag,
    MavParamType, MavProtocolCapability, Message, SET_POSITION_TARGET_GLOBAL_INT_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use mavlink_bridge::{PlanItem, Target};
use std::fmt;

/// The autopilot that a vehicle passes for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Personality {
    /// ArduPlane 4.7.
    #[default]
    ArduPlane,
    /// PX4 1.18 of a fixed wing.
    Px4,
    /// None in particular: MAV_AUTOPILOT_GENERIC, MAVLink's standard modes, all guided commands and setpoints.
    Generic,
}

impl Personality {
    /// All of them.
    pub const ALL: [Personality; 3] = [Personality::ArduPlane, Personality::Px4, Personality::Generic];

    /// Its name in scenarios and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Personality::ArduPlane => "arduplane",
            Personality::Px4 => "px4",
            Personality::Generic => "generic",
        }
    }

    /// Its name as it tells it itself.
    pub(crate) fn product(self) -> &'static str {
        match self {
            Personality::ArduPlane => "ArduPlane",
            Personality::Px4 => "PX4",
            Personality::Generic => "Columba",
        }
    }

    /// The number of a mode in HEARTBEAT.custom_mode.
    pub fn custom_mode(self, mode: Mode) -> u32 {
        match self {
            Personality::ArduPlane => mode.number(),
            Personality::Px4 => px4::custom_mode(mode),
            Personality::Generic => generic::custom_mode(mode),
        }
    }

    /// The autopilot's own name of a mode.
    pub fn mode_name(self, mode: Mode) -> &'static str {
        match self {
            Personality::ArduPlane | Personality::Generic => mode.name(),
            Personality::Px4 => px4::mode_name(mode),
        }
    }

    pub(crate) fn autopilot(self) -> MavAutopilot {
        match self {
            Personality::ArduPlane => MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            Personality::Px4 => MavAutopilot::MAV_AUTOPILOT_PX4,
            Personality::Generic => MavAutopilot::MAV_AUTOPILOT_GENERIC,
        }
    }

    /// The version whose names and answers the vehicle has.
    pub(crate) fn version(self) -> [u8; 3] {
        match self {
            Personality::ArduPlane => arduplane::VERSION,
            Personality::Px4 => px4::VERSION,
            Personality::Generic => generic::VERSION,
        }
    }

    pub(crate) fn base_mode(self, mode: Mode, armed: bool) -> MavModeFlag {
        match self {
            Personality::ArduPlane => arduplane::base_mode(mode, armed),
            Personality::Px4 => px4::base_mode(mode, armed),
            Personality::Generic => generic::base_mode(mode, armed),
        }
    }

    /// How parameters are written, beside what every vehicle can do.
    pub(crate) fn capabilities(self) -> MavProtocolCapability {
        let encoding = match self {
            Personality::ArduPlane | Personality::Generic => {
                MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
            }
            Personality::Px4 => MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE,
        };
        MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT | encoding
    }

    /// The index of the first item of a mission that is flown: ArduPlane's item 0 is home.
    pub(crate) fn first_mission_item(self) -> u16 {
        match self {
            Personality::ArduPlane => 1,
            Personality::Px4 | Personality::Generic => 0,
        }
    }

    /// An item as it is understood: a param that is not a number is one left out, but to ArduPlane.
    pub(crate) fn read_item(self, item: PlanItem) -> PlanItem {
        match self {
            Personality::ArduPlane => item,
            Personality::Px4 | Personality::Generic => {
                let mut params = item.params.map(|param| if param.is_nan() { 0.0 } else { param });
                if mission::has_heading(item.command) {
                    params[3] = item.params[3];
                }
                PlanItem { params, ..item }
            }
        }
    }

    /// Whether an item can be one of `count` of a plan; the result code that says why not. `by_integers`: it came as
    /// MISSION_ITEM_INT.
    pub(crate) fn check_plan_item(
        self,
        kind: PlanKind,
        seq: u16,
        item: &PlanItem,
        count: u16,
        by_integers: bool,
    ) -> Result<(), MavMissionResult> {
        match self {
            Personality::ArduPlane | Personality::Generic => kind.check(seq, item, count, self.first_mission_item()),
            Personality::Px4 => px4::check_item(kind, item, by_integers),
        }
    }

    /// What follows a mission.
    pub(crate) fn mode_after_mission(self) -> Mode {
        match self {
            Personality::ArduPlane | Personality::Generic => Mode::Rtl,
            Personality::Px4 => Mode::Loiter,
        }
    }

    /// How it asks for an item of an upload. ArduPlane still asks by the older message, and some clients (dronekit) answer no
    /// other: a PX4 asks those by it that have used it themselves.
    pub(crate) fn item_request(
        self,
        seq: u16,
        to: Target,
        mission_type: MavMissionType,
        has_old_items: bool,
    ) -> Message {
        let Target { system_id: target_system, component_id: target_component } = to;
        if self == Personality::ArduPlane || has_old_items {
            Message::MISSION_REQUEST(MISSION_REQUEST_DATA { seq, target_system, target_component, mission_type })
        } else {
            Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
                seq,
                target_system,
                target_component,
                mission_type,
            })
        }
    }

    /// Which parameters it has, in the order of their indices.
    pub(crate) fn parameters(self) -> Vec<Parameter> {
        let has = |parameter: &Parameter| match self {
            Personality::ArduPlane | Personality::Generic => !px4::OWN_PARAMETERS.contains(parameter),
            Personality::Px4 => !px4::ABSENT_PARAMETERS.contains(parameter),
        };
        Parameter::ALL.iter().copied().filter(has).collect()
    }

    /// What it calls a parameter, and of which type it has it.
    pub(crate) fn parameter(self, parameter: Parameter) -> (&'static str, MavParamType) {
        match self {
            Personality::ArduPlane => (parameter.name(), parameter.kind()),
            // Clients do not agree on how an unknown autopilot encodes whole numbers: it has none.
            Personality::Generic => (parameter.name(), MavParamType::MAV_PARAM_TYPE_REAL32),
            Personality::Px4 => px4::parameter(parameter),
        }
    }

    /// The mode that it starts in where an ArduPlane starts in another: in lockstep a PX4 follows setpoints from the
    /// beginning.
    pub(crate) fn first_mode(self, mode: Mode, in_lockstep: bool) -> Mode {
        match (self, mode) {
            (Personality::Px4, Mode::Guided) if in_lockstep => Mode::Offboard,
            (Personality::Px4, Mode::Guided | Mode::Manual) => Mode::Loiter,
            _ => mode,
        }
    }
}

impl fmt::Display for Personality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Vehicle {
    /// What the personality makes of a command, if it is not ArduPlane's answer.
    pub(crate) fn execute_as_personality(&mut self, command: &Command, link: usize) -> Option<Result<(), Refusal>> {
        match self.settings.personality {
            Personality::ArduPlane => self.execute_arduplane(command),
            Personality::Px4 => self.execute_px4(command),
            Personality::Generic => self.execute_generic(command),
        }
        .or_else(|| self.execute_standard_mode(command, link))
    }

    /// The answer to a command for a device that is not there; none if it is not for one, or the autopilot knows no such
    /// command.
    pub(crate) fn answer_for_device(&self, command: u16, params: [f32; 4]) -> Option<Result<(), Refusal>> {
        match self.settings.personality {
            Personality::ArduPlane => arduplane::devices::answer(command, params),
            Personality::Px4 => px4::answer_by_number(command),
            Personality::Generic => None,
        }
    }

    /// Takes a SET_POSITION_TARGET_LOCAL_NED as the personality does; `false` if that is ArduPlane's way.
    pub(crate) fn take_local_target(&mut self, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> bool {
        match self.settings.personality {
            Personality::ArduPlane => return self.arduplane_take_local_target(data),
            Personality::Px4 => self.px4_take_local_target(data),
            Personality::Generic => self.generic_take_local_target(data),
        }
        true
    }

    /// Takes a SET_POSITION_TARGET_GLOBAL_INT.
    pub(crate) fn take_global_target(&mut self, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
        match self.settings.personality {
            Personality::ArduPlane => self.arduplane_take_global_target(data),
            Personality::Px4 => self.px4_take_global_target(data),
            Personality::Generic => self.generic_take_global_target(data),
        }
    }

    /// What the personality does by itself, looked at after each integration step.
    pub(crate) fn follow_personality(&mut self) {
        match self.settings.personality {
            Personality::ArduPlane | Personality::Generic => {}
            Personality::Px4 => self.follow_px4(),
        }
    }

    /// The present mode, as the autopilot calls it.
    pub(crate) fn mode_name(&self) -> &'static str {
        self.settings.personality.mode_name(self.mode())
    }
}
