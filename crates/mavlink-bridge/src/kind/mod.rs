//! The kinds of autopilots that can be flown, and how each is commanded: one file for each kind.
//!
//! A [`Driver`] turns a speed, a course and an altitude into the messages that its autopilot follows, and knows how the
//! autopilot takes off, holds, returns and lands. It is sans-I/O: what it needs to know is in [`Seen`] and
//! [`Situation`]. A kind that is not here is refused by name ([`Driver::for_autopilot`]), and never sent another kind's
//! numbers.

// Autopilots still speak what the dialect calls superseded.
#![allow(deprecated)]

mod arducopter;
mod arduplane;
mod columba;
mod commands;
mod px4_fixed_wing;
mod px4_multicopter;
mod speed_demand;

pub use commands::{arm, command_int, command_long, request_message, set_message_interval};
pub use speed_demand::{SpeedDemand, demand_rate_mps2, gentle_rate_mps2};

use crate::dialect::{MavAutopilot, MavType, Message};
use crate::setpoint::{finite_f32, local_ned_setpoint};
use crate::{SetpointError, Target};
use flight_model::{Dynamics, Geodetic, LocalFrame, Setpoint, State};
use nalgebra::Vector2;
use std::time::Duration;

/// Version of an autopilot's software.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub struct SoftwareVersion {
    /// Major.
    pub major: u8,
    /// Minor.
    pub minor: u8,
    /// Patch.
    pub patch: u8,
}

impl SoftwareVersion {
    /// From AUTOPILOT_VERSION.flight_sw_version (<https://mavlink.io/en/messages/common.html#AUTOPILOT_VERSION>).
    pub fn from_wire(flight_sw_version: u32) -> Self {
        let [major, minor, patch, _] = flight_sw_version.to_be_bytes();
        Self { major, minor, patch }
    }
}

impl std::fmt::Display for SoftwareVersion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// A kind of autopilot that can be flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AutopilotKind {
    /// ArduPilot on a fixed wing, in GUIDED; Columba's vehicles pass for it by default.
    ArduPlane,
    /// ArduPilot on a multicopter, in GUIDED.
    ArduCopter,
    /// PX4 on a multicopter, in OFFBOARD.
    Px4Multicopter,
    /// PX4 on a fixed wing: Guided Course from 1.18 on, Hold and repositioning before.
    Px4FixedWing,
    /// Columba's own vehicles of no autopilot in particular (MAV_AUTOPILOT_GENERIC), in GUIDED.
    Columba,
}

/// An autopilot that cannot be flown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{autopilot} on a {vehicle} cannot be flown: Columba flies ArduPlane, ArduCopter, PX4 multicopters and fixed wings"
)]
pub struct UnflyableKind {
    /// The autopilot's name.
    pub autopilot: String,
    /// The type of vehicle.
    pub vehicle: String,
}

impl AutopilotKind {
    /// The kind that a HEARTBEAT tells.
    ///
    /// # Errors
    /// When it is none that can be flown.
    pub fn identify(autopilot: MavAutopilot, vehicle: MavType) -> Result<Self, UnflyableKind> {
        let is_copter = matches!(
            vehicle,
            MavType::MAV_TYPE_QUADROTOR
                | MavType::MAV_TYPE_HEXAROTOR
                | MavType::MAV_TYPE_OCTOROTOR
                | MavType::MAV_TYPE_TRICOPTER
                | MavType::MAV_TYPE_DECAROTOR
                | MavType::MAV_TYPE_DODECAROTOR
                | MavType::MAV_TYPE_COAXIAL
                | MavType::MAV_TYPE_HELICOPTER
        );
        let is_plane = vehicle == MavType::MAV_TYPE_FIXED_WING;
        match autopilot {
            MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA if is_plane => Ok(Self::ArduPlane),
            MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA if is_copter => Ok(Self::ArduCopter),
            MavAutopilot::MAV_AUTOPILOT_PX4 if is_plane => Ok(Self::Px4FixedWing),
            MavAutopilot::MAV_AUTOPILOT_PX4 if is_copter => Ok(Self::Px4Multicopter),
            MavAutopilot::MAV_AUTOPILOT_GENERIC if is_plane => Ok(Self::Columba),
            _ => Err(UnflyableKind {
                autopilot: plain(&format!("{autopilot:?}"), "MAV_AUTOPILOT_"),
                vehicle: plain(&format!("{vehicle:?}"), "MAV_TYPE_"),
            }),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::ArduPlane => "ArduPlane",
            Self::ArduCopter => "ArduCopter",
            Self::Px4Multicopter => "PX4 multicopter",
            Self::Px4FixedWing => "PX4 fixed wing",
            Self::Columba => "Columba",
        }
    }

    /// Whether it can stand still in the air.
    pub fn hovers(self) -> bool {
        matches!(self, Self::ArduCopter | Self::Px4Multicopter)
    }
}

fn plain(name: &str, prefix: &str) -> String {
    name.strip_prefix(prefix).unwrap_or(name).replace('_', " ").to_lowercase()
}

/// What is seen of a vehicle that is to take off or to be taken over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Whether its motors may run.
    pub armed: bool,
    /// HEARTBEAT.custom_mode.
    pub custom_mode: u32,
    /// Whether it stands on the ground.
    pub on_ground: bool,
    /// Above its home, m.
    pub height_m: f64,
    /// Climb, m/s.
    pub climb_mps: f64,
}

/// The next thing that a take-off needs.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // a message lives for a moment, and one at a time
pub enum Launch {
    /// This command, until what is seen says that it was followed.
    Send(Message),
    /// Nothing but time.
    Wait,
    /// Nothing any more: it flies, and follows setpoints.
    Flying,
}

/// What vehicles do when the flight is over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AtEnd {
    /// Circle, or hover, where they are.
    #[default]
    Loiter,
    /// Return to where they started.
    Return,
    /// Land.
    Land,
    /// Fly on with the last setpoint.
    Continue,
}

impl AtEnd {
    /// All of them, with the names of the command line.
    pub const ALL: [(&'static str, AtEnd); 4] =
        [("loiter", Self::Loiter), ("return", Self::Return), ("land", Self::Land), ("continue", Self::Continue)];
}

/// What a setpoint needs to know of its vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Where it is now, in the scenario's frame.
    pub state: State,
    /// The scenario's frame: its origin's altitude is above mean sea level.
    pub frame: &'a LocalFrame,
    /// Altitude of the vehicle's own local origin above mean sea level, m; none before it is known.
    pub local_origin_amsl_m: Option<f64>,
    /// The model by which the setpoint was chosen, with what the vehicle itself allows.
    pub dynamics: &'a Dynamics,
    /// Airspeed as the autopilot counts it, less the speed over ground, m/s: wind along the way and thin air. Slowly
    /// varying.
    pub airspeed_excess_mps: f64,
    /// The airspeed that the autopilot asks of itself at present, by what it was told, m/s ([`SpeedDemand`]).
    pub speed_demand_mps: Option<f64>,
    /// With which velocity its position moves, less the velocity that it tells and holds (north, east), m/s.
    pub drift_mps: Vector2<f64>,
    /// Time on the ground's clock.
    pub now: Duration,
}

/// Limits that a vehicle's own parameters set; none where nothing is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct VehicleLimits {
    /// Least speed, m/s.
    pub speed_min_mps: Option<f64>,
    /// Greatest speed, m/s.
    pub speed_max_mps: Option<f64>,
    /// Whether these are airspeeds.
    pub speeds_are_air: bool,
    /// Greatest bank, rad.
    pub bank_max_rad: Option<f64>,
    /// Greatest climb, m/s.
    pub climb_max_mps: Option<f64>,
    /// Greatest descent, m/s, positive.
    pub sink_max_mps: Option<f64>,
    /// Height to which a take-off climbs by itself, m.
    pub takeoff_height_m: Option<f64>,
}

/// A parameter's value by its name.
pub type Parameters<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// How one vehicle's autopilot is commanded.
#[derive(Clone, Debug)]
pub struct Driver {
    kind: AutopilotKind,
    version: Option<SoftwareVersion>,
}

impl Driver {
    /// The driver of a kind; the version matters to a PX4 fixed wing.
    pub fn new(kind: AutopilotKind, version: Option<SoftwareVersion>) -> Self {
        Self { kind, version }
    }

    /// The driver of the autopilot that a HEARTBEAT tells.
    ///
    /// # Errors
    /// When it is of no kind that can be flown.
    pub fn for_autopilot(
        autopilot: MavAutopilot,
        vehicle: MavType,
        version: Option<SoftwareVersion>,
    ) -> Result<Self, UnflyableKind> {
        Ok(Self::new(AutopilotKind::identify(autopilot, vehicle)?, version))
    }

    /// The kind.
    pub fn kind(&self) -> AutopilotKind {
        self.kind
    }

    /// The autopilot's own name of a mode.
    pub fn mode_name(&self, custom_mode: u32) -> String {
        let name = match self.kind {
            AutopilotKind::ArduPlane | AutopilotKind::Columba => arduplane::mode_name(custom_mode),
            AutopilotKind::ArduCopter => arducopter::mode_name(custom_mode),
            AutopilotKind::Px4Multicopter | AutopilotKind::Px4FixedWing => px4_multicopter::mode_name(custom_mode),
        };
        name.map_or_else(|| format!("mode {custom_mode}"), str::to_owned)
    }

    /// Whether the autopilot follows setpoints in a mode.
    pub fn follows_setpoints(&self, custom_mode: u32) -> bool {
        custom_mode == self.flying_mode()
    }

    /// HEARTBEAT.custom_mode of the mode in which it follows setpoints.
    pub fn flying_mode(&self) -> u32 {
        match self.kind {
            AutopilotKind::ArduPlane | AutopilotKind::Columba => arduplane::GUIDED,
            AutopilotKind::ArduCopter => arducopter::GUIDED,
            AutopilotKind::Px4Multicopter => px4_multicopter::OFFBOARD,
            AutopilotKind::Px4FixedWing => px4_fixed_wing::flying_mode(self.version),
        }
    }

    /// The command that brings it into the mode in which it follows setpoints.
    pub fn take_over(&self, target: Target) -> Message {
        self.set_mode(target, self.flying_mode())
    }

    /// The command for a mode, by HEARTBEAT.custom_mode.
    pub fn set_mode(&self, target: Target, custom_mode: u32) -> Message {
        match self.kind {
            AutopilotKind::Px4Multicopter | AutopilotKind::Px4FixedWing => commands::set_px4_mode(target, custom_mode),
            _ => commands::set_mode(target, custom_mode),
        }
    }

    /// What a take-off to `height_m` above home needs next; also of a vehicle that is in the air already.
    pub fn launch(&self, target: Target, seen: &Seen, height_m: f64) -> Launch {
        match self.kind {
            AutopilotKind::ArduPlane => arduplane::launch(target, seen, height_m),
            AutopilotKind::ArduCopter => arducopter::launch(target, seen, height_m),
            AutopilotKind::Px4Multicopter => px4_multicopter::launch(target, seen),
            AutopilotKind::Px4FixedWing => px4_fixed_wing::launch(target, seen, height_m, self.version),
            AutopilotKind::Columba => columba::launch(target, seen, height_m),
        }
    }

    /// Whether it changes into the mode in which it holds by itself when its take-off is over.
    pub fn holds_after_take_off(&self) -> bool {
        match self.kind {
            AutopilotKind::ArduPlane | AutopilotKind::ArduCopter => false,
            AutopilotKind::Px4Multicopter | AutopilotKind::Px4FixedWing | AutopilotKind::Columba => true,
        }
    }

    /// How often a setpoint must be sent though it has not changed; none where the autopilot keeps the last one.
    pub fn repeat_every(&self) -> Option<Duration> {
        match self.kind {
            AutopilotKind::ArduPlane | AutopilotKind::Columba => None,
            AutopilotKind::ArduCopter | AutopilotKind::Px4Multicopter => Some(Duration::from_millis(100)),
            AutopilotKind::Px4FixedWing => px4_fixed_wing::repeat_every(self.version),
        }
    }

    /// Whether each setpoint is answered, so that one without an answer was lost.
    pub fn acknowledges_setpoints(&self) -> bool {
        matches!(self.kind, AutopilotKind::ArduPlane | AutopilotKind::Px4FixedWing)
    }

    /// The messages that ask for a setpoint.
    ///
    /// # Errors
    /// When a number is not finite, or what the encoding needs to know is not known yet.
    pub fn setpoint(
        &self,
        target: Target,
        setpoint: &Setpoint,
        situation: &Situation<'_>,
    ) -> Result<Vec<Message>, SetpointError> {
        if !setpoint.is_finite() || !situation.state.is_finite() {
            return Err(SetpointError::NotFinite);
        }
        match self.kind {
            AutopilotKind::ArduPlane => arduplane::setpoint(target, setpoint, situation),
            AutopilotKind::ArduCopter => arducopter::setpoint(target, setpoint, situation),
            AutopilotKind::Px4Multicopter => px4_multicopter::setpoint(target, setpoint, situation),
            AutopilotKind::Px4FixedWing => px4_fixed_wing::setpoint(target, setpoint, situation, self.version),
            AutopilotKind::Columba => local_ned(target, setpoint, situation),
        }
    }

    /// The mode that does what is asked at the end, by HEARTBEAT.custom_mode; none where it is to fly on.
    pub fn end_mode(&self, at_end: AtEnd) -> Option<u32> {
        let [loiter, home, land] = match self.kind {
            AutopilotKind::ArduPlane => arduplane::END_MODES,
            AutopilotKind::ArduCopter => arducopter::END_MODES,
            AutopilotKind::Px4Multicopter | AutopilotKind::Px4FixedWing => px4_multicopter::END_MODES,
            AutopilotKind::Columba => columba::END_MODES,
        };
        match at_end {
            AtEnd::Loiter => Some(loiter),
            AtEnd::Return => Some(home),
            AtEnd::Land => Some(land),
            AtEnd::Continue => None,
        }
    }

    /// The command that brings a plane that circles to another altitude above mean sea level, m; none for those that
    /// hover, which stand still where they are.
    pub fn circle_at(&self, target: Target, altitude_amsl_m: f64) -> Option<Message> {
        let is_flyable = altitude_amsl_m.is_finite() && !self.kind.hovers();
        is_flyable.then(|| commands::change_altitude(target, altitude_amsl_m as f32))
    }

    /// What the end mode does not do though it was asked for, in words.
    pub fn end_note(&self, at_end: AtEnd) -> Option<&'static str> {
        match (self.kind, at_end) {
            (AutopilotKind::ArduPlane, AtEnd::Land) => Some(arduplane::LAND_NOTE),
            _ => None,
        }
    }

    /// Names of the parameters that [`limits`](Self::limits) reads.
    pub fn limit_parameters(&self) -> &'static [&'static str] {
        match self.kind {
            AutopilotKind::ArduPlane | AutopilotKind::Columba => &arduplane::LIMIT_PARAMETERS,
            AutopilotKind::ArduCopter => &arducopter::LIMIT_PARAMETERS,
            AutopilotKind::Px4Multicopter => &px4_multicopter::LIMIT_PARAMETERS,
            AutopilotKind::Px4FixedWing => &px4_fixed_wing::LIMIT_PARAMETERS,
        }
    }

    /// The limits that the vehicle's parameters set.
    pub fn limits(&self, parameters: Parameters<'_>) -> VehicleLimits {
        match self.kind {
            AutopilotKind::ArduPlane | AutopilotKind::Columba => arduplane::limits(parameters),
            AutopilotKind::ArduCopter => arducopter::limits(parameters),
            AutopilotKind::Px4Multicopter => px4_multicopter::limits(parameters),
            AutopilotKind::Px4FixedWing => px4_fixed_wing::limits(parameters),
        }
    }
}

/// An altitude of the scenario's frame, above mean sea level, m.
fn amsl_m(altitude_m: f64, situation: &Situation<'_>) -> f64 {
    situation.frame.origin().altitude_amsl_m + altitude_m
}

/// SET_POSITION_TARGET_LOCAL_NED with velocity and altitude (mask 0xDE3), in the vehicle's own frame: for the kinds
/// that follow one message for speed, course and altitude.
fn local_ned(target: Target, setpoint: &Setpoint, situation: &Situation<'_>) -> Result<Vec<Message>, SetpointError> {
    let altitude_m = local_m(setpoint.altitude_m, situation)?;
    finite_f32(setpoint.speed_mps)?;
    finite_f32(altitude_m)?;
    Ok(vec![local_ned_setpoint(situation.now, target, &Setpoint { altitude_m, ..*setpoint })])
}

/// An altitude of the scenario's frame above the vehicle's own local origin, m.
fn local_m(altitude_m: f64, situation: &Situation<'_>) -> Result<f64, SetpointError> {
    let origin_m = situation.local_origin_amsl_m.ok_or(SetpointError::OriginUnknown)?;
    Ok(amsl_m(altitude_m, situation) - origin_m)
}

/// The speed to ask an autopilot for that counts airspeed, m/s.
fn airspeed_mps(setpoint: &Setpoint, situation: &Situation<'_>) -> f64 {
    setpoint.speed_mps + situation.airspeed_excess_mps
}

/// A point ahead along a course.
fn ahead(situation: &Situation<'_>, course_rad: f64, distance_m: f64) -> Geodetic {
    let (sin, cos) = libm::sincos(course_rad);
    let State { x_m, y_m, .. } = situation.state;
    situation.frame.to_geodetic(x_m + distance_m * cos, y_m + distance_m * sin, 0.0)
}

#[cfg(test)]
mod tests;
