//! Asks an autopilot for its plans, as the mission protocol has it for a ground station that reads them
//! (<https://mavlink.io/en/services/mission.html#download_mission>). What is answered is heard like any other message.

use super::heard_plans::{HeardPlans, KINDS, Progress};
use mavlink_bridge::dialect::{
    MISSION_ACK_DATA, MISSION_REQUEST_INT_DATA, MISSION_REQUEST_LIST_DATA, MavMissionResult, MavMissionType, Message,
};
use mavlink_bridge::{Target, kind::request_message};
use std::time::Duration;

/// What is not answered is asked for again after this.
const PATIENCE: Duration = Duration::from_secs(1);
/// So often: links lose much, and an autopilot need not know of fences or rally points.
const TRIES: u32 = 10;
const HOME_POSITION: u32 = 242;
const TYPES: [MavMissionType; KINDS as usize] = [
    MavMissionType::MAV_MISSION_TYPE_MISSION,
    MavMissionType::MAV_MISSION_TYPE_FENCE,
    MavMissionType::MAV_MISSION_TYPE_RALLY,
];

/// How far the reading of one autopilot's plans is.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlanReader {
    /// The plan that is being read; beyond the last kind all is done.
    kind: u8,
    /// How often that plan had been heard before.
    before: u32,
    /// What was asked for, and when, and how often.
    asked: Option<(Option<u16>, Duration, u32)>,
}

impl PlanReader {
    /// What to say to an autopilot now, of which the home is known or not.
    pub fn ask(&mut self, target: Target, plans: &HeardPlans, knows_home: bool, now: Duration) -> Vec<Message> {
        let Some(&mission_type) = TYPES.get(usize::from(self.kind)) else { return Vec::new() };
        let progress = plans.progress(target.system_id, self.kind);
        let wanted = match progress {
            Progress::Told(times) if times > self.before => {
                self.next(target, plans);
                return vec![Message::MISSION_ACK(MISSION_ACK_DATA {
                    target_system: target.system_id,
                    target_component: target.component_id,
                    mavtype: MavMissionResult::MAV_MISSION_ACCEPTED,
                    mission_type,
                    ..MISSION_ACK_DATA::DEFAULT
                })];
            }
            Progress::Told(_) => None,
            Progress::Misses(seq) => Some(seq),
        };
        let tries = match self.asked {
            Some((asked, at, _)) if asked == wanted && now.saturating_sub(at) < PATIENCE => return Vec::new(),
            Some((asked, _, tries)) if asked == wanted => tries + 1,
            _ => 1,
        };
        if tries > TRIES {
            self.next(target, plans);
            return Vec::new();
        }
        self.asked = Some((wanted, now, tries));
        let (target_system, target_component) = (target.system_id, target.component_id);
        let mut messages = Vec::new();
        if !knows_home && wanted.is_none() {
            messages.push(request_message(target, HOME_POSITION));
        }
        messages.push(match wanted {
            None => Message::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
                target_system,
                target_component,
                mission_type,
            }),
            Some(seq) => Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
                seq,
                target_system,
                target_component,
                mission_type,
            }),
        });
        messages
    }

    fn next(&mut self, target: Target, plans: &HeardPlans) {
        self.kind += 1;
        self.asked = None;
        self.before = match plans.progress(target.system_id, self.kind) {
            Progress::Told(times) => times,
            Progress::Misses(_) => 0,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: Target = Target { system_id: 7, component_id: 1 };

    #[test]
    fn an_autopilot_that_does_not_answer_is_asked_a_few_times_for_each_plan() {
        let (mut reader, plans) = (PlanReader::default(), HeardPlans::default());
        let mut said = Vec::new();
        for tenth in 0..1000 {
            said.extend(reader.ask(TARGET, &plans, tenth > 0, Duration::from_millis(100 * tenth)));
        }
        let lists: Vec<_> = said
            .iter()
            .filter_map(|message| match message {
                Message::MISSION_REQUEST_LIST(data) => Some(data.mission_type as u8),
                _ => None,
            })
            .collect();
        let wanted: Vec<u8> = (0..KINDS).flat_map(|kind| [kind; TRIES as usize]).collect();
        assert_eq!(lists, wanted);
        assert_eq!(said.len(), wanted.len() + 1, "and for its home, until that is known");
    }
}
