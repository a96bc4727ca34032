//! What the operator says: a line on the terminal, or a command by MAVLink.

use mavlink_bridge::dialect::{COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, Message};
use mavlink_bridge::kind::AtEnd;

/// All verbs, as the page of `--view` offers them.
pub const VERBS: [&str; 13] = [
    "pause",
    "resume",
    "abort",
    "abort loiter",
    "abort return",
    "abort land",
    "pause N",
    "resume N",
    "drop N",
    "loiter N",
    "return N",
    "land N",
    "take N",
];

/// An operator's verb. Vehicles are numbered as in the scenario, from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    /// All hold where they are.
    Pause,
    /// They fly on.
    Resume,
    /// The flight is over. The vehicles end as they were to end, or as is said here.
    Abort(Option<AtEnd>),
    /// This one holds where it is, and is the flock's still.
    PauseOne(usize),
    /// It flies on.
    ResumeOne(usize),
    /// This one is flown no more: it holds where it is, or returns, or lands.
    Drop(usize, AtEnd),
    /// This one is flown again.
    Take(usize),
    /// The table is shown.
    Status,
}

impl std::fmt::Display for Verb {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name =
            |at_end: &AtEnd| AtEnd::ALL.into_iter().find(|(_, known)| known == at_end).map_or("", |(name, _)| name);
        match self {
            Self::Pause => f.write_str("pause"),
            Self::Resume => f.write_str("resume"),
            Self::PauseOne(vehicle) => write!(f, "pause {vehicle}"),
            Self::ResumeOne(vehicle) => write!(f, "resume {vehicle}"),
            Self::Abort(None) => f.write_str("abort"),
            Self::Abort(Some(at_end)) => write!(f, "abort {}", name(at_end)),
            Self::Drop(vehicle, AtEnd::Loiter) => write!(f, "drop {vehicle}"),
            Self::Drop(vehicle, at_end) => write!(f, "{} {vehicle}", name(at_end)),
            Self::Take(vehicle) => write!(f, "take {vehicle}"),
            Self::Status => f.write_str("status"),
        }
    }
}

impl std::str::FromStr for Verb {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |text: &str| text.parse().ok().filter(|number: &usize| *number > 0);
        match words[..] {
            ["pause"] => Ok(Self::Pause),
            ["resume"] => Ok(Self::Resume),
            ["abort"] => Ok(Self::Abort(None)),
            ["abort", "loiter"] => Ok(Self::Abort(Some(AtEnd::Loiter))),
            ["abort", "return"] => Ok(Self::Abort(Some(AtEnd::Return))),
            ["abort", "land"] => Ok(Self::Abort(Some(AtEnd::Land))),
            ["status"] => Ok(Self::Status),
            [verb @ ("pause" | "resume" | "drop" | "loiter" | "return" | "land" | "take"), vehicle] => {
                let Some(vehicle) = number(vehicle) else { return Err(format!("{verb} N: N is a vehicle's number")) };
                Ok(match verb {
                    "pause" => Self::PauseOne(vehicle),
                    "resume" => Self::ResumeOne(vehicle),
                    "take" => Self::Take(vehicle),
                    "return" => Self::Drop(vehicle, AtEnd::Return),
                    "land" => Self::Drop(vehicle, AtEnd::Land),
                    _ => Self::Drop(vehicle, AtEnd::Loiter),
                })
            }
            _ => Err(format!(
                "\"{}\": must be pause, resume, abort, abort loiter, abort return, abort land, pause N, resume N, \
                 drop N, loiter N, return N, land N, take N or status",
                line.trim()
            )),
        }
    }
}

/// Number of MAV_CMD_USER_1: param 1 is 1 to abort, 2 to drop vehicle param 2, 3 to take it, 4 to pause it and 5 to
/// resume it. Param 3 says how vehicles end: 0 as they were to end, or holding where a vehicle is dropped; 1 loiter, 2
/// return, 3 land.
const ABORT: f32 = 1.0;
const DROP: f32 = 2.0;
const TAKE: f32 = 3.0;
const PAUSE: f32 = 4.0;
const RESUME: f32 = 5.0;

/// The verb of a command to the station, and the command's number to answer; none if it is none of ours.
///
/// MAV_CMD_DO_PAUSE_CONTINUE (param 1: 0 pause, 1 resume) and MAV_CMD_USER_1.
pub fn commanded(message: &Message) -> Option<(MavCmd, Option<Verb>)> {
    let (command, param1, param2, param3) = match message {
        Message::COMMAND_LONG(COMMAND_LONG_DATA { command, param1, param2, param3, .. }) => {
            (*command, *param1, *param2, *param3)
        }
        Message::COMMAND_INT(COMMAND_INT_DATA { command, param1, param2, param3, .. }) => {
            (*command, *param1, *param2, *param3)
        }
        _ => return None,
    };
    let at_end = match param3 {
        1.0 => Some(AtEnd::Loiter),
        2.0 => Some(AtEnd::Return),
        3.0 => Some(AtEnd::Land),
        _ => None,
    };
    let vehicle = (1.0..65_536.0).contains(&param2).then_some(param2 as usize);
    let verb = match command {
        MavCmd::MAV_CMD_DO_PAUSE_CONTINUE if param1 == 0.0 => Some(Verb::Pause),
        MavCmd::MAV_CMD_DO_PAUSE_CONTINUE if param1 == 1.0 => Some(Verb::Resume),
        MavCmd::MAV_CMD_USER_1 if param1 == ABORT => Some(Verb::Abort(at_end)),
        MavCmd::MAV_CMD_USER_1 if param1 == DROP => {
            vehicle.map(|vehicle| Verb::Drop(vehicle, at_end.unwrap_or(AtEnd::Loiter)))
        }
        MavCmd::MAV_CMD_USER_1 if param1 == TAKE => vehicle.map(Verb::Take),
        MavCmd::MAV_CMD_USER_1 if param1 == PAUSE => vehicle.map(Verb::PauseOne),
        MavCmd::MAV_CMD_USER_1 if param1 == RESUME => vehicle.map(Verb::ResumeOne),
        _ => None,
    };
    Some((command, verb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_verbs_or_told_what_verbs_there_are() {
        assert_eq!(" drop 3\n".parse(), Ok(Verb::Drop(3, AtEnd::Loiter)));
        assert_eq!("resume".parse(), Ok(Verb::Resume));
        assert_eq!("land 2".parse(), Ok(Verb::Drop(2, AtEnd::Land)));
        assert_eq!("abort return".parse(), Ok(Verb::Abort(Some(AtEnd::Return))));
        for verb in VERBS {
            let said = verb.replace('N', "1");
            let parsed = said.parse::<Verb>().unwrap();
            assert!(parsed.to_string() == said || said == "loiter 1", "{parsed} is what {said} means");
        }
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
        assert_eq!(command(MavCmd::MAV_CMD_USER_1, 2.0, 4.0).unwrap().1, Some(Verb::Drop(4, AtEnd::Loiter)));
        assert_eq!(command(MavCmd::MAV_CMD_USER_1, 4.0, 2.0).unwrap().1, Some(Verb::PauseOne(2)));
        assert_eq!(command(MavCmd::MAV_CMD_USER_1, 5.0, 2.0).unwrap().1, Some(Verb::ResumeOne(2)));
        assert_eq!(command(MavCmd::MAV_CMD_USER_1, 2.0, f32::NAN).unwrap().1, None);
        assert_eq!(command(MavCmd::MAV_CMD_NAV_LAND, 0.0, 0.0).unwrap().1, None);
    }
}
