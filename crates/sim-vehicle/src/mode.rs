//! Flight modes, in ArduPlane's numbers.

use std::fmt;

/// A mode that the simulated vehicle flies. The numbers are ArduPlane's custom modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The sticks: bank, climb and speed.
    Manual,
    /// Circles where it was entered.
    Circle,
    /// As MANUAL.
    Stabilize,
    /// As MANUAL: what ArduPlane limits there is limited in all of them.
    Training,
    /// As MANUAL: a stick sets a bank, not a rate.
    Acro,
    /// As FBWA: there is nothing to tune.
    Autotune,
    /// As MANUAL.
    Fbwa,
    /// The sticks: bank, rate of climb and speed; centred, it holds its altitude.
    Fbwb,
    /// As FBWB; centred, it holds its course too.
    Cruise,
    /// Flies to home and circles there.
    Rtl,
    /// Circles where it was entered, at the altitude and speed of that moment.
    Loiter,
    /// Flies the mission.
    Auto,
    /// Takes off, climbs straight on to TKOFF_ALT and circles there.
    Takeoff,
    /// Follows setpoints and the guided commands.
    Guided,
    /// Lands where it was entered. ArduPlane has no such mode; other autopilots do.
    Land,
    /// Holds course, altitude and speed, or those that commands give: PX4's Guided Course.
    Course,
    /// Follows a stream of setpoints: PX4's Offboard.
    Offboard,
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
    /// The modes that ArduPlane has.
    pub(crate) const ARDUPLANE: &[Mode] = &[
        Mode::Manual,
        Mode::Circle,
        Mode::Stabilize,
        Mode::Training,
        Mode::Acro,
        Mode::Fbwa,
        Mode::Fbwb,
        Mode::Cruise,
        Mode::Autotune,
        Mode::Auto,
        Mode::Rtl,
        Mode::Loiter,
        Mode::Takeoff,
        Mode::Guided,
    ];

    /// ArduPlane's number of this mode, as in the custom_mode of HEARTBEAT; of one that it does not have, that of the
    /// nearest.
    pub fn number(self) -> u32 {
        match self {
            Mode::Manual => 0,
            Mode::Circle => 1,
            Mode::Stabilize => 2,
            Mode::Training => 3,
            Mode::Acro => 4,
            Mode::Fbwa => 5,
            Mode::Fbwb => 6,
            Mode::Cruise => 7,
            Mode::Autotune => 8,
            Mode::Auto | Mode::Land => 10,
            Mode::Rtl => 11,
            Mode::Loiter => 12,
            Mode::Takeoff => 13,
            Mode::Guided | Mode::Course | Mode::Offboard => 15,
        }
    }

    /// The mode of an ArduPlane number, or why there is none.
    ///
    /// # Errors
    /// No mode that is simulated has the number.
    pub fn from_number(number: u32) -> Result<Self, NoSuchMode> {
        Self::ARDUPLANE.iter().copied().find(|mode| mode.number() == number).ok_or(NoSuchMode(number))
    }

    /// Whether it follows the sticks.
    pub fn is_manual(self) -> bool {
        self.idles() || self.holds_speed()
    }

    /// Whether the sticks set an airspeed and a rate of climb.
    pub(crate) fn holds_speed(self) -> bool {
        matches!(self, Mode::Fbwb | Mode::Cruise)
    }

    /// Whether a closed throttle idles: the sticks set a bank, and nothing holds the altitude.
    pub(crate) fn idles(self) -> bool {
        matches!(self, Mode::Manual | Mode::Stabilize | Mode::Training | Mode::Acro | Mode::Autotune | Mode::Fbwa)
    }

    /// ArduPlane's name of this mode.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Manual => "MANUAL",
            Mode::Circle => "CIRCLE",
            Mode::Stabilize => "STABILIZE",
            Mode::Training => "TRAINING",
            Mode::Acro => "ACRO",
            Mode::Autotune => "AUTOTUNE",
            Mode::Fbwa => "FBWA",
            Mode::Fbwb => "FBWB",
            Mode::Cruise => "CRUISE",
            Mode::Auto => "AUTO",
            Mode::Rtl => "RTL",
            Mode::Loiter => "LOITER",
            Mode::Takeoff => "TAKEOFF",
            Mode::Guided => "GUIDED",
            Mode::Land => "LAND",
            Mode::Course => "COURSE",
            Mode::Offboard => "OFFBOARD",
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
        for &mode in Mode::ARDUPLANE {
            assert_eq!(Mode::from_number(mode.number()), Ok(mode));
            assert_eq!(ARDUPLANE_MODES[mode.number() as usize], mode.name());
        }
    }

    #[test]
    fn a_refusal_names_the_mode() {
        assert_eq!(Mode::from_number(17).unwrap_err().to_string(), "Mode QSTABILIZE is not simulated");
        assert_eq!(Mode::from_number(u32::MAX).unwrap_err().to_string(), "No such mode 4294967295");
        assert_eq!(Mode::from_number(9).unwrap_err().to_string(), "No such mode 9");
    }
}
