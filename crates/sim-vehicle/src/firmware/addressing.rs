//! For whom a message is. An ArduPlane looks at the system alone; a PX4 looks at the component too, and drops in
//! silence what is for another one.

// Clients still send what the dialect calls superseded.
#![allow(deprecated)]

use super::rules::CommandSet;
use mavlink_bridge::dialect::Message;
use mavlink_bridge::{Incoming, Request, Target};

/// MAV_COMP_ID_MISSIONPLANNER, by which plans are addressed to a PX4 as well.
const MISSION_PLANNER: u8 = 190;

/// Which addresses a PX4 obeys, beside those of this very component of this very system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// All systems, all components (`evaluate_target_ok` of `mavlink_receiver.cpp`, and setpoints).
    Broadcast,
    /// This system; all components.
    System,
    /// The same, and the mission planner's component (`CHECK_SYSID_COMPID_MISSION` of `mavlink_mission.cpp`).
    Plan,
    /// All systems, any component.
    AnyComponent,
    /// This system, any component.
    SystemAnyComponent,
}

impl CommandSet {
    /// Whether the autopilot of a system and component obeys a message.
    pub fn hears(self, incoming: &Incoming, system_id: u8, component_id: u8) -> bool {
        let rule = match self {
            CommandSet::Px4 => px4_rule(&incoming.request),
            CommandSet::ArduPlane | CommandSet::Generic => Rule::AnyComponent,
        };
        rule.admits(incoming.target, system_id, component_id)
    }
}

fn px4_rule(request: &Request) -> Rule {
    match request {
        Request::Command(_) => Rule::Broadcast,
        Request::Plan { .. } => Rule::Plan,
        Request::Parameter(_) => Rule::System,
        Request::Message(
            Message::SET_POSITION_TARGET_LOCAL_NED(_)
            | Message::SET_POSITION_TARGET_GLOBAL_INT(_)
            | Message::SET_ATTITUDE_TARGET(_),
        ) => Rule::Broadcast,
        Request::Message(Message::SET_GPS_GLOBAL_ORIGIN(_)) => Rule::SystemAnyComponent,
        Request::Point(_) | Request::Message(_) => Rule::AnyComponent,
    }
}

impl Rule {
    fn admits(self, target: Target, system_id: u8, component_id: u8) -> bool {
        let for_all = matches!(self, Rule::Broadcast | Rule::AnyComponent);
        let system = target.system_id == system_id || for_all && target.system_id == 0;
        let component = match self {
            Rule::AnyComponent | Rule::SystemAnyComponent => true,
            Rule::Plan => [0, component_id, MISSION_PLANNER].contains(&target.component_id),
            Rule::Broadcast | Rule::System => [0, component_id].contains(&target.component_id),
        };
        system && component
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_component_is_not_heard_and_only_some_messages_are_for_all_systems() {
        let admits = |rule: Rule, system_id, component_id| rule.admits(Target { system_id, component_id }, 7, 1);
        for (rule, to_all, to_all_components, to_another_component, to_the_planner) in [
            (Rule::Broadcast, true, true, false, false),
            (Rule::System, false, true, false, false),
            (Rule::Plan, false, true, false, true),
            (Rule::AnyComponent, true, true, true, true),
            (Rule::SystemAnyComponent, false, true, true, true),
        ] {
            assert!(admits(rule, 7, 1) && !admits(rule, 8, 1), "{rule:?}");
            let got = [admits(rule, 0, 0), admits(rule, 7, 0), admits(rule, 7, 55), admits(rule, 7, MISSION_PLANNER)];
            assert_eq!(got, [to_all, to_all_components, to_another_component, to_the_planner], "{rule:?}");
        }
    }
}
