//! The switches of a pilot's transmitter: the mode switch, which is the channel FLTMODE_CH with the positions FLTMODE1
//! to FLTMODE6, and channels with a function of their own, RC1_OPTION to RC16_OPTION.

use super::Autopilot;
use super::manual_control::CHANNELS;
use super::mission::progress::Progress;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use std::time::Duration;

/// Where the second to the sixth position of the mode switch begin, microseconds (`RC_Channel::read_6pos_switch`).
const BOUNDS_US: [u16; 5] = [1231, 1361, 1491, 1621, 1750];
/// Pulses below the first are LOW, above the second HIGH (`RC_Channel::read_3pos_switch`), within the limits of a
/// pulse.
const FUNCTION_BOUNDS_US: [u16; 2] = [1200, 1800];
const PULSE_US: std::ops::Range<u16> = 801..2200;
/// How long a switch must stay where it is before it counts.
const SETTLED_AFTER: Duration = Duration::from_millis(200);
const MODES: [Parameter; 6] = [
    Parameter::FlightMode1,
    Parameter::FlightMode2,
    Parameter::FlightMode3,
    Parameter::FlightMode4,
    Parameter::FlightMode5,
    Parameter::FlightMode6,
];
const FUNCTIONS: [Parameter; CHANNELS] = [
    Parameter::ChannelFunction1,
    Parameter::ChannelFunction2,
    Parameter::ChannelFunction3,
    Parameter::ChannelFunction4,
    Parameter::ChannelFunction5,
    Parameter::ChannelFunction6,
    Parameter::ChannelFunction7,
    Parameter::ChannelFunction8,
    Parameter::ChannelFunction9,
    Parameter::ChannelFunction10,
    Parameter::ChannelFunction11,
    Parameter::ChannelFunction12,
    Parameter::ChannelFunction13,
    Parameter::ChannelFunction14,
    Parameter::ChannelFunction15,
    Parameter::ChannelFunction16,
];

/// Numbers of functions (`RC_Channel::AUX_FUNC`).
const FENCE: u16 = 11;
const MISSION_RESET: u16 = 24;
const DISARM: u16 = 81;
const MODE_SWITCH_RESET: u16 = 96;
const ARM_OR_DISARM: u16 = 153;

/// All switches as they were last seen.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Switches {
    mode: Switch,
    functions: [Switch; CHANNELS],
}

/// One switch. A position is a number from 0 up.
#[derive(Clone, Copy, Debug, Default)]
struct Switch {
    /// None: it has not been looked at.
    settled: Option<usize>,
    /// A new position, and since when.
    moving: Option<(usize, Duration)>,
}

impl Switch {
    /// The position that the switch has settled in anew, if it has; `first` is where it stands before it is looked at.
    fn look(&mut self, position: usize, first: usize, time: Duration) -> Option<usize> {
        let settled = *self.settled.get_or_insert(first);
        if position == settled {
            self.moving = None;
            return None;
        }
        match self.moving {
            Some((towards, since)) if towards == position => {
                if time.saturating_sub(since) < SETTLED_AFTER {
                    return None;
                }
                (self.settled, self.moving) = (Some(position), None);
                Some(position)
            }
            _ => {
                self.moving = Some((position, time));
                None
            }
        }
    }
}

impl Autopilot {
    /// Does what switches say that have moved.
    pub(super) fn follow_switches(&mut self) {
        // Those of a receiver that has failed do not count.
        if !self.rules.has_switches || !self.hears_transmitter() {
            return;
        }
        if let Some(position) = self.mode_switch_position() {
            // At the start it changes nothing, wherever it stands.
            if let Some(position) = self.session.switches.mode.look(position, position, self.time) {
                self.enter_mode_of_switch(position);
            }
        }
        // Channels with a function are at rest where nobody has moved one of late.
        if !self.session.channels.have_moved(self.time) {
            return;
        }
        for (channel, parameter) in FUNCTIONS.into_iter().enumerate() {
            let function = self.parameters.get(parameter) as u16;
            let pulse_us = self.session.channels.position_us(channel, self.time);
            if function == 0 || !PULSE_US.contains(&pulse_us) {
                continue;
            }
            let [low_us, high_us] = FUNCTION_BOUNDS_US;
            let position = usize::from(pulse_us >= low_us) + usize::from(pulse_us > high_us);
            let first = if function == ARM_OR_DISARM { position } else { LOW };
            if let Some(position) = self.session.switches.functions[channel].look(position, first, self.time) {
                if let Some(name) = name_of(function) {
                    self.say(Severity::Info, &format!("RC{}: {name} {}", channel + 1, POSITIONS[position]));
                }
                self.run_function(function, position);
            }
        }
    }

    /// Does what a function does in a position, 0 to 2; `false` if there is no such function.
    pub(crate) fn run_function(&mut self, function: u16, position: usize) -> bool {
        let is_high = position == HIGH;
        match function {
            FENCE => drop(self.enable_fence([f32::from(is_high), 0.0])),
            MISSION_RESET if is_high => self.session.progress = Progress::at_beginning(&self.mission),
            DISARM if is_high => self.say_refusal([0.0, 0.0]),
            ARM_OR_DISARM if position != MIDDLE => self.say_refusal([f32::from(is_high), 0.0]),
            MODE_SWITCH_RESET => self.reset_mode_switch(),
            MISSION_RESET | DISARM | ARM_OR_DISARM => {}
            other => match mode_of(other) {
                Some(mode) if is_high => self.enter_or_say(mode),
                Some(mode) if mode == self.mode() => self.reset_mode_switch(),
                Some(_) => {}
                None if WITHOUT_EFFECT.contains(&function) => {}
                None => return false,
            },
        }
        true
    }

    fn mode_switch_position(&self) -> Option<usize> {
        let number = self.parameters.get(Parameter::FlightModeChannel) as usize;
        let channel = number.checked_sub(1).filter(|channel| *channel < CHANNELS)?;
        let pulse_us = self.session.channels.position_us(channel, self.time);
        (pulse_us > 0).then(|| BOUNDS_US.iter().filter(|bound| pulse_us >= **bound).count())
    }

    /// Goes to the mode in which the mode switch stands.
    fn reset_mode_switch(&mut self) {
        if let Some(position) = self.mode_switch_position() {
            self.enter_mode_of_switch(position);
        }
    }

    fn enter_mode_of_switch(&mut self, position: usize) {
        match Mode::from_number(self.parameters.get(MODES[position]) as u32) {
            Ok(mode) => self.enter_or_say(mode),
            Err(error) => self.say(Severity::Warning, &error.to_string()),
        }
    }

    fn enter_or_say(&mut self, mode: Mode) {
        if let Some(reason) = self.enter(mode).err().and_then(|refusal| refusal.reason) {
            self.say(Severity::Warning, &reason);
        }
    }

    /// Arms or disarms, and says why not.
    fn say_refusal(&mut self, params: [f32; 2]) {
        if let Some(reason) = self.arm_or_disarm(params).err().and_then(|refusal| refusal.reason) {
            self.say(Severity::Critical, &reason);
        }
    }
}

/// Functions that an ArduPlane knows and that change nothing here: devices, tests, and modes that are not simulated.
const WITHOUT_EFFECT: [u16; 82] = [
    9, 15, 19, 22, 27, 28, 29, 30, 31, 34, 35, 36, 38, 39, 40, 43, 46, 52, 58, 62, 64, 65, 66, 67, 78, 79, 80, 82, 84,
    85, 86, 87, 88, 89, 90, 91, 95, 98, 100, 101, 102, 103, 104, 105, 106, 107, 108, 110, 111, 112, 113, 154, 155, 156,
    157, 158, 160, 162, 163, 164, 165, 170, 171, 172, 173, 176, 177, 179, 180, 181, 183, 184, 208, 209, 210, 212, 213,
    214, 215, 216, 217, 218,
];

const LOW: usize = 0;
const MIDDLE: usize = 1;
const HIGH: usize = 2;
const POSITIONS: [&str; 3] = ["LOW", "MIDDLE", "HIGH"];

/// The mode that a function is for.
fn mode_of(function: u16) -> Option<Mode> {
    Some(match function {
        4 => Mode::Rtl,
        16 => Mode::Auto,
        51 => Mode::Manual,
        55 => Mode::Guided,
        56 => Mode::Loiter,
        72 => Mode::Circle,
        77 => Mode::Takeoff,
        92 => Mode::Fbwa,
        150 => Mode::Cruise,
        _ => return None,
    })
}

/// What ArduPilot calls a function where it tells of its switch.
fn name_of(function: u16) -> Option<&'static str> {
    match function {
        FENCE => Some("Fence"),
        MISSION_RESET => Some("MissionReset"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_switch_counts_once_it_has_settled() {
        let mut switch = Switch::default();
        let mut at = |position, ms| switch.look(position, 5, Duration::from_millis(ms));
        assert_eq!(at(5, 0), None);
        assert_eq!(at(0, 100), None);
        assert_eq!(at(5, 200), None);
        assert_eq!(at(0, 300), None);
        assert_eq!(at(0, 490), None);
        assert_eq!(at(0, 500), Some(0));
        assert_eq!(at(0, 900), None);
    }
}
