//! Which autopilot a vehicle simulates: how it numbers its modes, what it says of itself, and which commands and setpoints
//! it takes.
//!
//! Each autopilot is one const of [`Rules`] and its tables, in a folder that reads as a page about it.

pub(crate) mod answers;
mod arduplane;
mod generic;
mod px4;
pub(crate) mod rules;
mod targets;

use crate::mode::Mode;
use rules::Rules;
use std::fmt;

/// The autopilot that a vehicle simulates.
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

    /// What is its own.
    pub(crate) fn rules(self) -> &'static Rules {
        match self {
            Personality::ArduPlane => &arduplane::RULES,
            Personality::Px4 => &px4::RULES,
            Personality::Generic => &generic::RULES,
        }
    }

    /// Its name in scenarios and on the command line.
    pub fn name(self) -> &'static str {
        self.rules().name
    }

    /// The number of a mode in HEARTBEAT.custom_mode.
    pub fn custom_mode(self, mode: Mode) -> u32 {
        (self.rules().custom_mode)(mode)
    }

    /// The autopilot's own name of a mode.
    pub fn mode_name(self, mode: Mode) -> &'static str {
        (self.rules().mode_name)(mode)
    }
}

impl fmt::Display for Personality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
