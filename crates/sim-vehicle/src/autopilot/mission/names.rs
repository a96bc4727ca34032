//! How an ArduPilot tells of its items as it begins them (`AP_Mission::start_command`).

use super::items::{JUMP, JUMP_TO_TAG, TAG};
use mavlink_bridge::PlanItem;

/// What is said when an item begins; nothing of a jump, which is told when it is made.
pub(super) fn beginning(seq: u16, item: &PlanItem) -> Option<String> {
    let name = name(item.command)?;
    Some(match item.command {
        JUMP | JUMP_TO_TAG => return None,
        TAG => format!("Mission: {seq} {name} {}", item.params[0] as u16),
        _ => format!("Mission: {seq} {name}"),
    })
}

/// Whether an ArduPilot tells of an item that is no place that it is reached, too: not of those that its library of
/// missions does by itself (`AP_Mission::verify_command`).
pub(super) fn is_reached(command: u16) -> bool {
    const OF_THE_LIBRARY: [u16; 23] = [
        181, 182, 183, 184, 202, 203, 206, 208, 211, 215, 216, 217, 218, 531, 532, 534, 600, 1000, 2000, 2001, 2500,
        2501, 42_600,
    ];
    !OF_THE_LIBRARY.contains(&command)
}

/// `AP_Mission::Mission_Command::type`, of those that this vehicle takes.
fn name(command: u16) -> Option<&'static str> {
    Some(match command {
        16 => "WP",
        17 => "LoitUnlim",
        18 => "LoitTurns",
        19 => "LoitTime",
        20 => "RTL",
        21 => "Land",
        22 => "Takeoff",
        30 => "ContinueAndChangeAlt",
        31 => "LoitAltitude",
        92 => "GuidedEnable",
        93 => "Delay",
        112 => "CondDelay",
        114 => "CondDist",
        115 => "CondYaw",
        177 => "Jump",
        178 => "ChangeSpeed",
        179 => "SetHome",
        181 => "SetRelay",
        182 => "RepeatRelay",
        183 => "SetServo",
        184 => "RepeatServo",
        188 => "ReturnPathStart",
        189 => "LandStart",
        191 => "Go Around",
        193 => "PauseContinue",
        195 => "SetROILocation",
        197 => "SetROINone",
        201 => "SetROI",
        202 => "DigiCamCfg",
        203 => "DigiCamCtrl",
        205 => "MountControl",
        206 => "SetCamTrigDst",
        207 => "FenceEnable",
        208 => "Parachute",
        210 => "InvertedFlight",
        211 => "Gripper",
        212 => "AutoTuneEnable",
        215 => "SetRepeatDist",
        216 => "Sprayer",
        217 => "Scripting",
        218 => "AuxFunction",
        222 => "GuidedLimits",
        223 => "EngineControl",
        531 => "SetCameraZoom",
        532 => "SetCameraFocus",
        534 => "SetCameraSource",
        600 => "Tag",
        601 => "JumpToTag",
        1000 => "GimbalPitchYaw",
        2000 => "ImageStartCapture",
        2001 => "ImageStopCapture",
        2500 => "VideoStartCapture",
        2501 => "VideoStopCapture",
        3000 => "VTOLTransition",
        42_600 => "Winch",
        42_703 => "NavAttitudeTime",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_told_in_ardupilots_words() {
        let item = |command: u16, p1: f32| PlanItem { command, params: [p1, 0.0, 0.0, 0.0], ..PlanItem::default() };
        assert_eq!(beginning(3, &item(178, 0.0)).as_deref(), Some("Mission: 3 ChangeSpeed"));
        assert_eq!(beginning(4, &item(600, 7.0)).as_deref(), Some("Mission: 4 Tag 7"));
        assert_eq!((beginning(5, &item(177, 1.0)), beginning(5, &item(9999, 1.0))), (None, None));
    }
}
