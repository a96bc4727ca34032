//! What the operator says: a line on the terminal, or a command by MAVLink.

use mavlink_bridge::dialect::{COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, Message};

/// An operator's verb. Vehicles are numbered as in the scenario, from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    /// All hold where they are.
    Pause,
    /// They fly on.
    Resume,
    /// The flight is over, and ends as it was to end.
    Abort,
    /// This one holds where it is, and is flown no more.
    Drop(usize),
    /// This one is flown again.
    Take(usize),
    /// The table is shown.
    Status,
}

impl std::str::FromStr for Verb {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |text: &str| text.parse().ok().filter(|number: &usize| *number > 0);
        match words[..] {
            ["pause"] => Ok(Self::Pause),
            ["resume"] => Ok(Self::Resume),
            ["abort"] => Ok(Self::Abort),
            ["status"] => Ok(Self::Status),
            ["drop", vehicle] => number(vehicle).map(Self::Drop).ok_or("drop N: N is a vehicle's number".to_owned()),
            ["take", vehicle] => number(vehicle).map(Self::Take).ok_or("take N: N is a vehicle's number".to_owned()),
            _ => Err(format!("\"{}\": must be pause, resume, abort, drop N, take N or status", line.trim())),
        }
    }
}

/// Number of MAV_CMD_USER_1: param 1 is 1 to abort, 2 to drop vehicle param 2, 3 to take it.
const ABORT: f32 = 1.0;
const DROP: f32 = 2.0;
const TAKE: f32 = 3.0;

/// The verb of a command to the station, and the command's number to answer; none if it is none of ours.
///
/// MAV_CMD_DO_PAUSE_CONTINUE (param 1: 0 pause, 1 resume) and MAV_CMD_USER_1.
pub fn commanded(message: &Message) -> Option<(MavCmd, Option<Verb>)> {
    let (command, param1, param2) = match message {
        Message::COMMAND_LONG(COMMAND_LONG_DATA { command, param1, param2, .. }) => (*command, *param1, *param2),
        Message::COMMAND_INT(COMMAND_INT_DATA { command, param1, param2, .. }) => (*command, *param1, *param2),
        _ => return None,
    };
    let vehicle = (1.0..65_536.0).contains(&param2).then_some(param2 as usize);
    let verb = match command {
        MavCmd::MAV_CMD_DO_PAUSE_CONTINUE if param1 == 0.0 => Some(Verb::Pause),
        MavCmd::MAV_CMD_DO_PAUSE_CONTINUE if param1 == 1.0 => Some(Verb::Resume),
        MavCmd::MAV_CMD_USER_1 if param1 == ABORT => Some(Verb::Abort),
        MavCmd::MAV_CMD_USER_1 if param1 == DROP => vehicle.map(Verb::Drop),
        MavCmd::MAV_CMD_USER_1 if param1 == TAKE => vehicle.map(Verb::Take),
        _ => None,
    };
    Some((command, verb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_verbs_or_told_what_verbs_there_are() {
        assert_eq!(" drop 3\n".parse(), Ok(Verb::Drop(3)));
        assert_eq!("resume".parse(), Ok(Verb::Resume));
        for wrong in ["drop", "drop 0", "drop x", "stop", "", "take -1"] {
            assert!(wrong.parse::<Verb>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn commands_are_the_same_verbs() {
        let command = |command, param1, param2| {
            commanded(&Message::COMMAND_LONG(COMMAND_LONG_DATA {
                command,
                param1,
                param2,
                ..COMMAND_LONG_DATA::DEFAULT
            }))
        };
        assert_eq!(command(MavCmd::MAV_CMD_DO_PAUSE_CONTINUE, 0.0, 0.0).unwrap().1, Some(Verb::Pause));
        assert_eq!(command(MavCmd::MAV_CMD_USER_1, 2.0, 4.0).unwrap().1, Some(Verb::Drop(4)));
        assert_eq!(command(MavCmd::MAV_CMD_USER_1, 2.0, f32::NAN).unwrap().1, None);
        assert_eq!(command(MavCmd::MAV_CMD_NAV_LAND, 0.0, 0.0).unwrap().1, None);
    }
}
