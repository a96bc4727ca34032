//! Plans of autopilots, as the mission protocol is overheard: an autopilot tells them, or is told them.

use mavlink_bridge::{Incoming, PlanItem, PlanMessage, Request};
use std::collections::{BTreeMap, HashMap};

/// MAV_MISSION_TYPE of a mission, a fence and rally points are 0, 1 and 2.
pub const KINDS: u8 = 3;
/// A plan of more items than any autopilot keeps is none.
const ITEMS_MAX: u16 = 10_000;

/// Plans by system id.
#[derive(Debug, Default)]
pub struct HeardPlans(HashMap<u8, [Heard; KINDS as usize]>);

/// One plan.
#[derive(Debug, Default)]
struct Heard {
    /// All of it, when it was last heard in full.
    whole: Vec<PlanItem>,
    /// What is being told.
    count: Option<u16>,
    items: BTreeMap<u16, PlanItem>,
    /// How often all of it was heard.
    times: u32,
}

/// How far a plan is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Nobody tells it at present; all of it was heard so often.
    Told(u32),
    /// The item of this index is the first that is missing.
    Misses(u16),
}

impl HeardPlans {
    /// Takes a frame; `is_vehicle` tells which systems are autopilots. Gives the system whose plan is another one now.
    pub fn hear(&mut self, incoming: &Incoming, is_vehicle: impl Fn(u8) -> bool) -> Option<u8> {
        let Request::Plan { mission_type, message } = &incoming.request else { return None };
        let (from, to) = (incoming.header.system_id, incoming.target.system_id);
        // A ground station that uploads tells the plan of the autopilot that it speaks to.
        let (vehicle, is_told) = if is_vehicle(from) { (from, false) } else { (to, true) };
        if !is_vehicle(vehicle) {
            return None;
        }
        let plan = self.0.entry(vehicle).or_default().get_mut(usize::from(*mission_type))?;
        plan.hear(message, is_told).then_some(vehicle)
    }

    /// How far the plan of a kind (MAV_MISSION_TYPE) of a system is told.
    pub fn progress(&self, system_id: u8, kind: u8) -> Progress {
        let Some(plan) = self.0.get(&system_id).and_then(|plans| plans.get(usize::from(kind))) else {
            return Progress::Told(0);
        };
        match plan.count {
            None => Progress::Told(plan.times),
            Some(count) => Progress::Misses((0..count).find(|seq| !plan.items.contains_key(seq)).unwrap_or_default()),
        }
    }

    /// The items of the mission, the fence and the rally points of a system.
    pub fn of(&self, system_id: u8) -> [&[PlanItem]; KINDS as usize] {
        self.0.get(&system_id).map_or([&[]; 3], |plans| [0, 1, 2].map(|kind| plans[kind].whole.as_slice()))
    }
}

impl Heard {
    /// Whether the plan is another one now.
    fn hear(&mut self, message: &PlanMessage, is_told: bool) -> bool {
        match *message {
            PlanMessage::Count(count) if count <= ITEMS_MAX => {
                self.count = Some(count);
                self.items.clear();
                self.complete()
            }
            // 2 and 3: an order of the moment, and no item of a plan.
            PlanMessage::Item { seq, item, current, .. } if seq < ITEMS_MAX && current < 2 => {
                self.items.insert(seq, item);
                self.complete()
            }
            PlanMessage::ClearAll if is_told => {
                let had_one = !self.whole.is_empty();
                *self = Self::default();
                had_one
            }
            _ => false,
        }
    }

    fn complete(&mut self) -> bool {
        if self.count != u16::try_from(self.items.len()).ok() {
            return false;
        }
        let whole: Vec<PlanItem> = std::mem::take(&mut self.items).into_values().collect();
        self.count = None;
        self.times = self.times.saturating_add(1);
        let is_another = whole != self.whole;
        self.whole = whole;
        is_another
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::{MISSION_COUNT_DATA, MavMissionType, Message};
    use mavlink_bridge::{Counters, Encoder, ItemKind, PlanItemMessage, Target, frames};

    const GROUND: u8 = 255;
    const PLANE: u8 = 7;

    fn told(plans: &mut HeardPlans, bytes: &[u8]) -> Option<u8> {
        let frame = frames(bytes, &mut Counters::default()).next().unwrap();
        plans.hear(&Incoming::decode(&frame).unwrap(), |system| system == PLANE)
    }

    fn count(from: u8, to: u8, count: u16, mission_type: MavMissionType) -> Vec<u8> {
        let mut bytes = Vec::new();
        let message = Message::MISSION_COUNT(MISSION_COUNT_DATA {
            target_system: to,
            target_component: 1,
            count,
            mission_type,
            ..MISSION_COUNT_DATA::DEFAULT
        });
        Encoder::new(from, 1).encode(&message, &mut bytes);
        bytes
    }

    fn item(from: u8, to: u8, seq: u16, mission_type: u8) -> Vec<u8> {
        let item = PlanItem { latitude_e7: i32::from(seq) + 1, command: 16, frame: 3, ..PlanItem::default() };
        let to = Target { system_id: to, component_id: 1 };
        let message = PlanItemMessage { mission_type, seq, item: &item, is_current: false, kind: ItemKind::Int, to };
        let mut bytes = Vec::new();
        Encoder::new(from, 1).encode_plan_item(&message, &mut bytes);
        bytes
    }

    #[test]
    fn a_plan_is_known_when_all_of_it_was_heard_either_way() {
        for (from, to) in [(GROUND, PLANE), (PLANE, GROUND)] {
            let mut plans = HeardPlans::default();
            assert_eq!(told(&mut plans, &count(from, to, 2, MavMissionType::MAV_MISSION_TYPE_FENCE)), None);
            // Asked for again, the first item comes twice.
            for _ in 0..2 {
                assert_eq!(told(&mut plans, &item(from, to, 0, 1)), None);
            }
            assert!(plans.of(PLANE)[1].is_empty());
            assert_eq!(told(&mut plans, &item(from, to, 1, 1)), Some(PLANE));
            assert_eq!(plans.of(PLANE).map(<[PlanItem]>::len), [0, 2, 0]);
            assert_eq!(told(&mut plans, &count(from, to, 0, MavMissionType::MAV_MISSION_TYPE_FENCE)), Some(PLANE));
            assert!(plans.of(PLANE)[1].is_empty());
        }
    }

    #[test]
    fn plans_of_nobody_and_of_a_kind_that_is_none_are_nothing() {
        let mut plans = HeardPlans::default();
        assert_eq!(told(&mut plans, &count(GROUND, 9, 0, MavMissionType::MAV_MISSION_TYPE_MISSION)), None);
        assert_eq!(told(&mut plans, &item(PLANE, GROUND, 0, 200)), None);
        assert_eq!(plans.of(9), [&[] as &[PlanItem]; 3]);
    }
}
