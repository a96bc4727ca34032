//! What differs between autopilots, by name: one const each. What is not here is the same for all of them, and
//! ArduPlane's.

use crate::firmware::stock::Stock;
use crate::firmware::words::Words;
use crate::mode::Mode;
use crate::parameters::renamed::Renamed;
use crate::parameters::table::Parameter;
use crate::telemetry::rates::{LinkUse, TelemetryRates};
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MavAutopilot, MavModeFlag, MavParamType, MavStandardMode};

/// Where the default rate of a stream stands.
pub(crate) type RateOf = fn(&mut TelemetryRates) -> &mut f64;

/// Which streams a link has, and how often they come, Hz.
pub(crate) type StreamRates = &'static [(Stream, f64)];

/// Which answers to commands an autopilot has where ArduPlane's are others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CommandSet {
    ArduPlane,
    Px4,
    Generic,
}

/// What an autopilot makes of position targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TargetSet {
    /// Velocities in the local frame in GUIDED, and of all else the altitude.
    ArduPlane,
    /// A stream of complete targets in Offboard.
    Px4,
    /// Whatever can be flown, in GUIDED.
    Generic,
}

/// A message as an autopilot offers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Offer {
    /// It can be sent, at a rate and when asked for.
    Sent(Stream),
    /// Its rate can be set and it is accepted when asked for, but nothing comes: for want of this.
    Silent(&'static str),
    /// Its rate can be set, and it is refused when asked for.
    RateAlone,
    /// It is not known.
    None,
}

/// The named differences of one autopilot.
#[derive(Debug)]
pub(crate) struct Rules {
    // Who it is.
    /// Its name in scenarios and on the command line.
    pub name: &'static str,
    /// Its name as it tells it itself.
    pub product: &'static str,
    pub autopilot: MavAutopilot,
    /// The version whose names and answers the vehicle has.
    pub version: [u8; 3],

    // Modes.
    /// The number in HEARTBEAT.custom_mode.
    pub custom_mode: fn(Mode) -> u32,
    /// Whether that number has a main and a sub mode in its upper bytes, which SET_MODE gives in one.
    pub custom_mode_has_sub_mode: bool,
    pub mode_name: fn(Mode) -> &'static str,
    /// The flags of HEARTBEAT.
    pub base_mode: fn(Mode, bool) -> MavModeFlag,
    /// The modes that a client can set.
    pub modes: &'static [Mode],
    /// Whether MAVLink's standard modes are known beside its own.
    pub has_standard_modes: bool,
    /// The mode that it starts in where an ArduPlane starts in another; the flag tells whether it is in lockstep.
    pub first_mode: fn(Mode, bool) -> Mode,
    pub mode_after_mission: Mode,
    /// Whether its state is ACTIVE from arming on, and not only in flight.
    pub is_active_once_armed: bool,
    /// Whether a new mode is told before the next heartbeat.
    pub tells_mode_at_once: bool,
    /// Whether AUTO without a mission returns; otherwise it is refused.
    pub returns_without_mission: bool,

    // Commands and setpoints.
    pub commands: CommandSet,
    pub targets: TargetSet,
    /// Whether SET_MODE is acknowledged as if it were DO_SET_MODE.
    pub acknowledges_set_mode: bool,
    /// Whether SET_GPS_GLOBAL_ORIGIN is answered with the origin, which stays.
    pub tells_origin: bool,
    /// Whether a rate of a message that there is not is FAILED; otherwise it is DENIED.
    pub unknown_interval_fails: bool,
    /// Whether DO_SET_HOME is above sea level whatever the frame.
    pub home_is_above_sea: bool,
    /// Whether ArduPilot's own commands and messages are known: DO_SEND_BANNER, BATTERY_RESET, FENCE_POINT.
    pub has_ardupilot_commands: bool,

    // Arming and flying.
    pub words: Words,
    pub fence_forbids_arming: bool,
    /// Whether a fence at a distance of 0 is none.
    pub fence_of_no_distance_is_none: bool,
    /// Whether the altitude of a return is the least one on the way, and where it ends it goes down to another.
    pub climbs_to_return: bool,
    /// What a value of FENCE_ACTION brings about; none: words alone.
    pub fence_action: fn(u8) -> Option<Mode>,
    /// Whether it says unasked what stands against arming.
    pub tells_arming_reason: bool,
    /// Whether a pilot's channels are switches, of the mode (FLTMODE_CH) or with a function (RC1_OPTION and its kin),
    /// and a receiver that fails is a failsafe.
    pub has_switches: bool,
    /// Whether any ground station moves the sticks and is listened for; otherwise the one of MAV_GCS_SYSID.
    pub any_ground_station: bool,
    /// Whether setpoints in Offboard, sticks and the ground station are watched as a PX4 does, TAKEOFF ends in Hold,
    /// and it disarms idle.
    pub watches_streams: bool,

    // Missions.
    /// Whether plans are judged and flown as a PX4 does it: the parts of a fence each for itself, a mission that it
    /// takes and does not fly, the ends of loiters.
    pub judges_plans_as_px4: bool,
    /// Whether plans are transferred by a PX4's rules: one transfer at a time, item after item.
    pub transfers_plans_as_px4: bool,
    /// Most items of a mission, home among them; of a fence; most rally points.
    pub plan_items_max: [u16; 3],
    /// The index of the first item that is flown: ArduPlane's item 0 is home.
    pub first_mission_item: u16,
    /// Whether a mission that takes the place of one under way goes on at the same item.
    pub resumes_after_upload: bool,
    /// Whether it takes off by itself where a mission has no take-off.
    pub takes_off_before_mission: bool,
    /// Whether RETURN_TO_LAUNCH stays the current item, which returns again.
    pub return_item_stays_current: bool,
    /// Whether a param of an item that is no number is one left out.
    pub nan_params_are_left_out: bool,
    /// Whether items are kept in a few bytes each, with fewer digits than they came with and without what has no room,
    /// and a loiter of no more than 1 m is one of WP_LOITER_RAD.
    pub keeps_items_in_bytes: bool,
    /// Whether a waypoint without a radius of its own is over where it is passed abeam, however far away.
    pub passes_waypoints: bool,
    /// Whether an acknowledgement of the writer breaks off an upload.
    pub upload_can_be_broken_off: bool,
    /// Whether items are asked for by the older message, and not by it only of those that use it.
    pub asks_by_old_message: bool,
    /// Whether an item that is chosen and not flown to is told as the next one that is.
    pub tells_next_flown_item: bool,
    /// Whether the state of a mission is told as a PX4 does: paused once an item has been reached, active in a take-off
    /// and a landing too, and with checksums of all plans.
    pub tells_mission_as_px4: bool,
    /// MISSION_CURRENT.mission_mode while no mission is flown.
    pub mission_mode_suspended: u8,
    /// Whether MISSION_ITEM_REACHED comes again, once a second, ten times.
    pub repeats_reached: bool,

    // Parameters and telemetry.
    pub has_parameter: fn(Parameter) -> bool,
    /// What it calls a parameter, and of which type it has it.
    pub parameter: fn(Parameter) -> (&'static str, MavParamType),
    /// The parameters of the real one, and of which types these are.
    pub stock: fn() -> Option<&'static Stock>,
    /// What it called parameters before.
    pub renamed_parameters: &'static [Renamed],
    /// What is otherwise before anybody sets it.
    pub initial_parameters: &'static [(Parameter, f32)],
    /// Whether whole numbers stand on the wire by their bytes, and a type is looked at.
    pub bytewise_parameters: bool,
    /// Whether whole numbers are told as floats; they are whole all the same.
    pub tells_whole_numbers_as_floats: bool,
    /// Whether names of parameters are told apart by their case.
    pub parameter_names_have_case: bool,
    /// Whether it has PX4's checksum of all parameters.
    pub has_parameter_hash: bool,
    /// Streams that come unasked beyond those of all.
    pub more_streams: &'static [(Stream, RateOf)],
    /// Whether who speaks MAVLink 1 is answered in it; otherwise in MAVLink 2, as everybody.
    pub answers_in_mavlink_1: bool,
    /// What comes unasked on a link of the autopilot's own simulator, Hz; none: what the settings say.
    pub link_rates: fn(LinkUse) -> Option<StreamRates>,
}

impl Rules {
    /// What names of parameters are told apart by.
    pub fn parameter_key(&self, name: &str) -> String {
        if self.parameter_names_have_case { name.to_owned() } else { name.to_ascii_uppercase() }
    }

    /// MAVLink's standard mode that one of the vehicle's is. Some autopilots have only modes of their own.
    pub fn standard_mode(&self, mode: Mode) -> MavStandardMode {
        match mode {
            _ if !self.has_standard_modes => MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
            Mode::Cruise => MavStandardMode::MAV_STANDARD_MODE_CRUISE,
            Mode::Fbwb => MavStandardMode::MAV_STANDARD_MODE_ALTITUDE_HOLD,
            Mode::Rtl => MavStandardMode::MAV_STANDARD_MODE_SAFE_RECOVERY,
            Mode::Auto => MavStandardMode::MAV_STANDARD_MODE_MISSION,
            Mode::Land => MavStandardMode::MAV_STANDARD_MODE_LAND,
            Mode::Takeoff => MavStandardMode::MAV_STANDARD_MODE_TAKEOFF,
            _ => MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
        }
    }
}
