//! Which autopilot a vehicle simulates: how it numbers its modes, what it tells of itself, and which commands and
//! setpoints it takes.
//!
//! Each autopilot is one const of [`Rules`] and its tables, in a folder that reads as a page about it.

mod addressing;
pub(crate) mod answers;
mod arduplane;
mod attitude;
mod generic;
pub(crate) mod offers;
mod px4;
pub(crate) mod rules;
pub(crate) mod stock;
mod targets;
pub(crate) mod words;

use crate::mode::Mode;
use rules::Rules;
use std::fmt;

/// An autopilot is: its documentation, its name in the code, and the folder with its `RULES`.
macro_rules! personalities {
    ($($(#[$attribute:meta])* $personality:ident: $folder:ident;)*) => {
        /// The autopilot that a vehicle simulates.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "lowercase")]
        pub enum Personality {
            $($(#[$attribute])* $personality,)*
        }

        impl Personality {
            /// All of them.
            pub const ALL: [Personality; [$(stringify!($personality)),*].len()] = [$(Personality::$personality),*];

            /// What is its own.
            pub(crate) fn rules(self) -> &'static Rules {
                match self {
                    $(Personality::$personality => &$folder::RULES,)*
                }
            }
        }
    };
}

personalities! {
    /// ArduPlane 4.7.
    #[default]
    ArduPlane: arduplane;
    /// PX4 1.18 of a fixed wing.
    Px4: px4;
    /// None in particular: MAV_AUTOPILOT_GENERIC, MAVLink's standard modes, all guided commands and setpoints.
    Generic: generic;
}

impl Personality {
    /// Whether there is a list of the real one's parameters, for
    /// [`VehicleSettings::stock_parameters`](crate::VehicleSettings::stock_parameters).
    pub fn has_stock_parameters(self) -> bool {
        (self.rules().stock)().is_some()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::Autopilot;
    use crate::settings::VehicleSettings;

    #[test]
    fn names_are_those_of_scenarios() {
        for personality in Personality::ALL {
            assert_eq!(personality.name(), format!("{personality:?}").to_lowercase());
        }
    }

    /// The const of docs/extending.md.
    const FOURTH: Rules = Rules {
        name: "fourth",
        product: "Fourth",
        mode_after_mission: Mode::Loiter,
        fence_forbids_arming: false,
        ..arduplane::RULES
    };

    #[test]
    fn a_further_autopilot_is_one_const() {
        let mut autopilot = Autopilot::with_rules(&FOURTH, &VehicleSettings::default(), false);
        autopilot.end_mission("Mission complete");
        assert_eq!((autopilot.mode(), autopilot.rules().name), (Mode::Loiter, "fourth"));
        let mut plane = Autopilot::new(&VehicleSettings::default(), false);
        plane.end_mission("Mission complete");
        assert_eq!(plane.mode(), Mode::Rtl);
    }
}
