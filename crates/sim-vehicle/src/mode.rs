//! Flight modes, in ArduPlane's numbers.

use std::fmt;

/// A mode that the simulated vehicle flies. The numbers are ArduPlane's custom modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Holds course, altitude and speed, and takes no setpoints.
    Cruise,
    /// Flies to home (the origin of the local frame) and circles there.
    Rtl,
    /// Circles where it was entered, at the altitude and speed of that moment.
    Loiter,
    /// Flies the mission.
    Auto,
    /// Climbs straight on to TKOFF_ALT and circles there.
    Takeoff,
    /// Follows setpoints and the guided commands.
    Guided,
}

/// Names of ArduPlane's modes by number, so that a refusal can say what was asked.
const ARDUPLANE_MODES: [&str; 26] = [
    "MANUAL",
    "CIRCLE",
    "STABILIZE",
    "TRAINING",
    "ACRO",
    "FBWA",
    "FBWB",
    "CRUISE",
    "AUTOTUNE",
    "",
    "AUTO",
    "RTL",
    "LOITER",
    "TAKEOFF",
    "AVOID_ADSB",
    "GUIDED",
    "INITIALISING",
    "QSTABILIZE",
    "QHOVER",
    "QLOITER",
    "QLAND",
    "QRTL",
    "QAUTOTUNE",
    "QACRO",
    "THERMAL",
    "LOITER_TO_QLAND",
];

impl Mode {
    /// ArduPlane's number of this mode, as in the custom_mode of HEARTBEAT.
    pub fn number(self) -> u32 {
        match self {
            Mode::Cruise => 7,
            Mode::Auto => 10,
            Mode::Rtl => 11,
            Mode::Loiter => 12,
            Mode::Takeoff => 13,
            Mode::Guided => 15,
        }
    }

    /// The mode of an ArduPlane number, or why there is none.
    pub fn from_number(number: u32) -> Result<Self, NoSuchMode> {
        [Mode::Cruise, Mode::Auto, Mode::Rtl, Mode::Loiter, Mode::Takeoff, Mode::Guided]
            .into_iter()
            .find(|mode| mode.number() == number)
            .ok_or(NoSuchMode(number))
    }

    /// ArduPlane's name of this mode.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Cruise => "CRUISE",
            Mode::Auto => "AUTO",
            Mode::Rtl => "RTL",
            Mode::Loiter => "LOITER",
            Mode::Takeoff => "TAKEOFF",
            Mode::Guided => "GUIDED",
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The number of a mode that the simulated vehicle does not fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct NoSuchMode(pub u32);

impl fmt::Display for NoSuchMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = usize::try_from(self.0).ok().and_then(|index| ARDUPLANE_MODES.get(index)).filter(|n| !n.is_empty());
        match name {
            Some(name) => write!(f, "Mode {name} is not simulated"),
            None => write!(f, "No such mode {}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_arduplanes() {
        for (number, name) in
            [(7, "CRUISE"), (10, "AUTO"), (11, "RTL"), (12, "LOITER"), (13, "TAKEOFF"), (15, "GUIDED")]
        {
            let mode = Mode::from_number(number).unwrap();
            assert_eq!((mode.number(), mode.name()), (number, name));
            assert_eq!(ARDUPLANE_MODES[number as usize], name);
        }
    }

    #[test]
    fn a_refusal_names_the_mode() {
        assert_eq!(Mode::from_number(17).unwrap_err().to_string(), "Mode QSTABILIZE is not simulated");
        assert_eq!(Mode::from_number(u32::MAX).unwrap_err().to_string(), "No such mode 4294967295");
        assert_eq!(Mode::from_number(9).unwrap_err().to_string(), "No such mode 9");
    }
}
