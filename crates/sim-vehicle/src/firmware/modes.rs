//! MAVLink's standard modes (<https://mavlink.io/en/services/standard_modes.html>): which modes there are, which one is
//! flown, and setting one without knowing the autopilot's numbers.

use super::{Personality, generic, px4};
use crate::mode::Mode;
use crate::protocol::command::{Command, Refusal, integer};
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{
    AVAILABLE_MODES_DATA, CURRENT_MODE_DATA, MavCmd, MavModeProperty, MavStandardMode, Message,
};

impl Personality {
    /// The modes that a client can set.
    fn modes(self) -> &'static [Mode] {
        match self {
            Personality::ArduPlane => Mode::ARDUPLANE,
            Personality::Px4 => &px4::SELECTABLE,
            Personality::Generic => &generic::MODES,
        }
    }

    /// ArduPlane has only modes of its own.
    fn standard_mode(self, mode: Mode) -> MavStandardMode {
        match mode {
            _ if self == Personality::ArduPlane => MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
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

impl Vehicle {
    /// DO_SET_STANDARD_MODE, and REQUEST_MESSAGE for AVAILABLE_MODES and CURRENT_MODE.
    pub(crate) fn execute_standard_mode(&mut self, command: &Command, link: usize) -> Option<Result<(), Refusal>> {
        let [p1, p2, ..] = command.params;
        match command.command {
            MavCmd::MAV_CMD_DO_SET_STANDARD_MODE if self.autopilot.settings.personality != Personality::ArduPlane => {
                Some(self.set_standard_mode(p1))
            }
            MavCmd::MAV_CMD_REQUEST_MESSAGE => match u32::try_from(integer(p1)) {
                Ok(AVAILABLE_MODES | CURRENT_MODE) if !self.peers().can_carry(link, AVAILABLE_MODES) => {
                    Some(Err(Refusal::failed("MAVLink 1 does not have this message").quietly()))
                }
                Ok(AVAILABLE_MODES) => Some(self.send_available_modes(link, integer(p2))),
                Ok(CURRENT_MODE) => {
                    let mode = self.current_mode();
                    self.links().send(link, &mode);
                    Some(Ok(()))
                }
                _ => None,
            },
            _ => None,
        }
    }

    fn set_standard_mode(&mut self, number: f32) -> Result<(), Refusal> {
        let personality = self.autopilot.settings.personality;
        let standard = |mode: &Mode| personality.standard_mode(*mode) as i64;
        let asked = number.round() as i64;
        match personality.modes().iter().find(|mode| asked != 0 && standard(mode) == asked) {
            Some(&mode) if personality == Personality::Px4 => self.autopilot.px4_change_mode(mode),
            Some(&mode) => self.autopilot.enter(mode),
            None => Err(Refusal::failed(format!("No standard mode {asked}"))),
        }
    }

    /// One of them, from 1, or all for 0.
    fn send_available_modes(&mut self, link: usize, index: i64) -> Result<(), Refusal> {
        let personality = self.autopilot.settings.personality;
        let modes = personality.modes();
        let asked = match usize::try_from(index) {
            Ok(0) => 1..=modes.len(),
            Ok(one) if one <= modes.len() => one..=one,
            _ => return Err(Refusal::failed(format!("There is no mode of index {index}"))),
        };
        for (index, &mode) in asked.clone().zip(&modes[asked.start() - 1..]) {
            let mut properties = MavModeProperty::empty();
            properties.set(MavModeProperty::MAV_MODE_PROPERTY_AUTO_MODE, !mode.is_manual());
            let available = AVAILABLE_MODES_DATA {
                custom_mode: personality.custom_mode(mode),
                properties,
                number_modes: modes.len() as u8,
                mode_index: index as u8,
                standard_mode: personality.standard_mode(mode),
                mode_name: personality.mode_name(mode).into(),
            };
            self.links().send(link, &Message::AVAILABLE_MODES(available));
        }
        Ok(())
    }

    fn current_mode(&self) -> Message {
        let (personality, mode) = (self.autopilot.settings.personality, self.autopilot.mode());
        // A failsafe stands between the mode that is flown and the one that was meant.
        let meant = if self.autopilot.px4.failsafe == Some(px4::Failsafe::Offboard) { Mode::Offboard } else { mode };
        Message::CURRENT_MODE(CURRENT_MODE_DATA {
            custom_mode: personality.custom_mode(mode),
            intended_custom_mode: personality.custom_mode(meant),
            standard_mode: personality.standard_mode(mode),
        })
    }
}

const AVAILABLE_MODES: u32 = 435;
const CURRENT_MODE: u32 = 436;

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::DialectMessage;

    #[test]
    fn the_ids_are_the_dialects() {
        assert_eq!(Message::AVAILABLE_MODES(AVAILABLE_MODES_DATA::DEFAULT).message_id(), AVAILABLE_MODES);
        assert_eq!(Message::CURRENT_MODE(CURRENT_MODE_DATA::DEFAULT).message_id(), CURRENT_MODE);
    }

    #[test]
    fn the_numbers_and_names_of_modes_are_distinct() {
        for personality in Personality::ALL {
            let modes = personality.modes();
            for (index, mode) in modes.iter().enumerate() {
                for other in &modes[..index] {
                    assert_ne!(personality.custom_mode(*mode), personality.custom_mode(*other));
                    assert_ne!(personality.mode_name(*mode), personality.mode_name(*other));
                }
            }
        }
    }
}
