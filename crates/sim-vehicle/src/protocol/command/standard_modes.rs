//! MAVLink's standard modes (<https://mavlink.io/en/services/standard_modes.html>): which modes there are, which one is
//! flown, and setting one without knowing the autopilot's numbers.

use super::request::Command;
use crate::autopilot::input::integer;
use crate::error::CommandError;
use crate::firmware::answers;
use crate::firmware::rules::CommandSet;
use crate::mode::Mode;
use crate::telemetry::announce::Component;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{AVAILABLE_MODES_DATA, MavCmd, MavModeProperty, MavStandardMode, Message};

/// DO_SET_STANDARD_MODE, and REQUEST_MESSAGE for AVAILABLE_MODES and CURRENT_MODE.
pub(crate) fn execute(component: &mut Component, command: &Command, link: usize) -> Option<Result<(), CommandError>> {
    let [p1, p2, ..] = command.params;
    match command.command {
        MavCmd::MAV_CMD_DO_SET_STANDARD_MODE if component.autopilot.rules().has_standard_modes => {
            Some(set_standard_mode(component, p1))
        }
        MavCmd::MAV_CMD_REQUEST_MESSAGE => match u32::try_from(integer(p1)) {
            Ok(AVAILABLE_MODES | CURRENT_MODE) if !component.peers().can_carry(link, AVAILABLE_MODES) => {
                Some(Err(CommandError::failed("MAVLink 1 does not have this message").quietly()))
            }
            Ok(AVAILABLE_MODES) => Some(send_available_modes(component, link, p2)),
            Ok(CURRENT_MODE) => {
                component.send_stream(link, Stream::CurrentMode);
                Some(Ok(()))
            }
            _ => None,
        },
        _ => None,
    }
}

fn set_standard_mode(component: &mut Component, number: f32) -> Result<(), CommandError> {
    let rules = component.autopilot.rules();
    let standard = |mode: &Mode| rules.standard_mode(*mode) as i64;
    let asked = number.round() as i64;
    // A PX4 enters an orbit by this command, and lists none among its modes.
    if rules.commands == CommandSet::Px4 && asked == MavStandardMode::MAV_STANDARD_MODE_ORBIT as i64 {
        return answers::change_mode(&mut component.autopilot, Mode::Circle);
    }
    match rules.modes.iter().find(|mode| asked != 0 && standard(mode) == asked) {
        Some(&mode) => answers::change_mode(&mut component.autopilot, mode),
        None => Err(CommandError::failed(format!("No standard mode {asked}"))),
    }
}

/// One of them, from 1, or all for 0. Where there is none of an index an ArduPlane accepts that and a PX4 denies it.
fn send_available_modes(component: &mut Component, link: usize, index: f32) -> Result<(), CommandError> {
    let rules = component.autopilot.rules();
    let modes = rules.modes;
    let index = if rules.commands == CommandSet::Px4 { index.round() as i64 } else { integer(index) };
    let asked = match usize::try_from(index) {
        Ok(0) => 1..=modes.len(),
        Ok(one) if one <= modes.len() => one..=one,
        _ => {
            let reason = format!("There is no mode of index {index}");
            return match rules.commands {
                CommandSet::ArduPlane => Ok(()),
                CommandSet::Px4 => Err(CommandError::denied(reason)),
                CommandSet::Generic => Err(CommandError::failed(reason)),
            };
        }
    };
    for (index, &mode) in asked.clone().zip(&modes[asked.start() - 1..]) {
        let mut properties = MavModeProperty::empty();
        properties.set(MavModeProperty::MAV_MODE_PROPERTY_AUTO_MODE, !mode.is_manual());
        let available = AVAILABLE_MODES_DATA {
            custom_mode: (rules.custom_mode)(mode),
            properties,
            number_modes: modes.len() as u8,
            mode_index: index as u8,
            standard_mode: rules.standard_mode(mode),
            mode_name: (rules.mode_name)(mode).into(),
        };
        component.links().send(link, &Message::AVAILABLE_MODES(available));
    }
    Ok(())
}

const AVAILABLE_MODES: u32 = 435;
const CURRENT_MODE: u32 = 436;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::Personality;
    use mavlink_bridge::dialect::DialectMessage;

    #[test]
    fn the_ids_are_the_dialects() {
        assert_eq!(Message::AVAILABLE_MODES(AVAILABLE_MODES_DATA::DEFAULT).message_id(), AVAILABLE_MODES);
        assert_eq!(Stream::CurrentMode.message_id(), CURRENT_MODE);
    }

    #[test]
    fn the_numbers_and_names_of_modes_are_distinct() {
        for personality in Personality::ALL {
            let modes = personality.rules().modes;
            for (index, mode) in modes.iter().enumerate() {
                for other in &modes[..index] {
                    assert_ne!(personality.custom_mode(*mode), personality.custom_mode(*other));
                    assert_ne!(personality.mode_name(*mode), personality.mode_name(*other));
                }
            }
        }
    }
}
