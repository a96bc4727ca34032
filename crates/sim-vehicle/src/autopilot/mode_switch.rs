//! The mode switch of a pilot's transmitter: the channel FLTMODE_CH, whose six positions are FLTMODE1 to FLTMODE6.

use super::Autopilot;
use super::manual_control::CHANNELS;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use std::time::Duration;

/// Where the second to the sixth position begin, microseconds (`RC_Channel::read_6pos_switch`).
const BOUNDS_US: [u16; 5] = [1231, 1361, 1491, 1621, 1750];
/// How long the switch must stay where it is before it counts.
const SETTLED_AFTER: Duration = Duration::from_millis(200);
const MODES: [Parameter; 6] = [
    Parameter::FlightMode1,
    Parameter::FlightMode2,
    Parameter::FlightMode3,
    Parameter::FlightMode4,
    Parameter::FlightMode5,
    Parameter::FlightMode6,
];

/// The switch as it was last seen. At the start it changes nothing, wherever it stands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ModeSwitch {
    settled: Option<usize>,
    /// A new position, and since when.
    moving: Option<(usize, Duration)>,
}

impl ModeSwitch {
    /// The position that the switch has settled in anew, if it has.
    fn look(&mut self, position: usize, time: Duration) -> Option<usize> {
        let Some(settled) = self.settled else {
            self.settled = Some(position);
            return None;
        };
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
    /// Changes the mode when the switch has moved.
    pub(super) fn follow_mode_switch(&mut self) {
        if !self.rules.has_mode_switch {
            return;
        }
        let channel = self.parameters.get(Parameter::FlightModeChannel) as usize;
        if !(1..=CHANNELS).contains(&channel) {
            return;
        }
        let pulse_us = self.session.channels.position_us(channel - 1, self.time);
        if pulse_us == 0 {
            return;
        }
        let position = BOUNDS_US.iter().filter(|bound| pulse_us >= **bound).count();
        let Some(position) = self.session.mode_switch.look(position, self.time) else { return };
        let number = self.parameters.get(MODES[position]) as u32;
        let outcome = Mode::from_number(number).map_err(|error| error.to_string());
        let outcome = outcome.and_then(|mode| self.enter(mode).map_err(|error| error.reason.unwrap_or_default()));
        if let Err(reason) = outcome {
            self.say(Severity::Warning, &reason);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_switch_counts_once_it_has_settled() {
        let mut switch = ModeSwitch::default();
        let mut at = |position, ms| switch.look(position, Duration::from_millis(ms));
        assert_eq!(at(5, 0), None);
        assert_eq!(at(0, 100), None);
        assert_eq!(at(5, 200), None);
        assert_eq!(at(0, 300), None);
        assert_eq!(at(0, 490), None);
        assert_eq!(at(0, 500), Some(0));
        assert_eq!(at(0, 900), None);
    }
}
