//! The plans that ground stations upload and read: missions, fences and rally points, by one protocol
//! (<https://mavlink.io/en/services/mission.html>), answered as ArduPilot's MissionItemProtocol does.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

pub(crate) mod file;
mod upload;

pub use file::PlanFileError;
pub(crate) use upload::Uploads;

use crate::autopilot::mission::WAYPOINT;
use crate::autopilot::{fence, mission, rally};
use crate::firmware::Personality;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::settings::SettingsError;
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MISSION_COUNT_DATA, MavMissionResult, MavMissionType, MavSeverity, Message};
use mavlink_bridge::{ItemKind, LatLonE7, PlanItem, PlanItemMessage, PlanMessage, Target};

/// The plans on board, each as it was uploaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plans {
    /// The mission; its first item stands for home.
    pub mission: Vec<PlanItem>,
    /// The fence.
    pub fence: Vec<PlanItem>,
    /// The rally points.
    pub rally: Vec<PlanItem>,
}

impl Plans {
    pub(crate) fn take(&mut self, kind: PlanKind) -> Vec<PlanItem> {
        std::mem::take(self.of(kind))
    }

    fn of(&mut self, kind: PlanKind) -> &mut Vec<PlanItem> {
        match kind {
            PlanKind::Mission => &mut self.mission,
            PlanKind::Fence => &mut self.fence,
            PlanKind::Rally => &mut self.rally,
        }
    }
}

/// What a plan is of. Each is uploaded by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlanKind {
    Mission,
    Fence,
    Rally,
}

impl PlanKind {
    pub const ALL: [Self; 3] = [Self::Mission, Self::Fence, Self::Rally];

    /// The plan of a MAV_MISSION_TYPE.
    fn from_number(mission_type: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.mission_type() as u8 == mission_type)
    }

    pub fn mission_type(self) -> MavMissionType {
        match self {
            Self::Mission => MavMissionType::MAV_MISSION_TYPE_MISSION,
            Self::Fence => MavMissionType::MAV_MISSION_TYPE_FENCE,
            Self::Rally => MavMissionType::MAV_MISSION_TYPE_RALLY,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Mission => "Mission",
            Self::Fence => "Fence",
            Self::Rally => "Rally",
        }
    }

    /// Most items.
    pub fn items_max(self) -> u16 {
        match self {
            Self::Mission => mission::ITEMS_MAX,
            Self::Fence => fence::ITEMS_MAX,
            Self::Rally => rally::POINTS_MAX,
        }
    }

    /// The parameter that counts its items.
    fn total(self) -> Parameter {
        match self {
            Self::Mission => Parameter::MissionTotal,
            Self::Fence => Parameter::FenceTotal,
            Self::Rally => Parameter::RallyTotal,
        }
    }

    /// Whether an item can be one of `count` in this plan; the result code that says why not.
    /// `first` is that of the items of a mission that are flown.
    pub fn check(self, seq: u16, item: &PlanItem, count: u16, first: u16) -> Result<(), MavMissionResult> {
        match self {
            // Home is what it is.
            Self::Mission if seq < first => Ok(()),
            Self::Mission => mission::check(item, first..count),
            Self::Fence => fence::check(item),
            Self::Rally => rally::check(item),
        }
    }
}

impl Vehicle {
    /// The items of a plan.
    pub(crate) fn plan(&self, kind: PlanKind) -> &[PlanItem] {
        match kind {
            PlanKind::Mission => &self.mission.items,
            PlanKind::Fence => self.fence.items(),
            PlanKind::Rally => &self.rally.items,
        }
    }

    /// Takes a plan whose items have been checked one by one, or says why it makes no sense as a whole. `anew` tells that
    /// it is another one, and not the old one with some items changed.
    pub(crate) fn replace_plan(&mut self, kind: PlanKind, items: Vec<PlanItem>, anew: bool) -> Result<(), String> {
        match kind {
            PlanKind::Mission => self.replace_mission(items, anew),
            PlanKind::Fence => self.replace_fence(items)?,
            PlanKind::Rally => self.rally.items = items.iter().map(rally::as_kept).collect(),
        }
        self.plans_changed[kind as usize] = true;
        Ok(())
    }

    fn replace_mission(&mut self, items: Vec<PlanItem>, anew: bool) {
        if self.settings.personality == Personality::Px4 {
            // The same mission again goes on where it is.
            if items == self.mission.items {
                return;
            }
            self.px4_judge_mission(&items);
        }
        self.mission.items = items;
        self.mission_changed(anew);
    }

    /// Takes the plans that were on board before.
    pub(crate) fn restore_plans(&mut self, mut plans: Plans) -> Result<(), SettingsError> {
        for kind in PlanKind::ALL {
            let items = plans.take(kind);
            let personality = self.settings.personality;
            check_items(kind, &items, personality).map_err(|(_, reason)| SettingsError::Plan(reason))?;
            let refused = |reason| SettingsError::Plan(format!("{} refused: {reason}", kind.name()));
            // None kept is none cleared: home stays.
            if !items.is_empty() {
                self.replace_plan(kind, items, true).map_err(refused)?;
            }
        }
        self.plans_changed = Default::default();
        self.plan_totals = PlanKind::ALL.map(|kind| self.parameter_value(kind.total()));
        Ok(())
    }

    /// The plans that have been changed since this was last asked, to be kept.
    pub(crate) fn take_changed_plans(&mut self) -> Vec<PlanKind> {
        let changed = std::mem::take(&mut self.plans_changed);
        PlanKind::ALL.into_iter().filter(|kind| changed[*kind as usize]).collect()
    }

    pub(crate) fn serve_plan(&mut self, link: usize, sender: Target, mission_type: u8, message: PlanMessage) {
        let Some(kind) = PlanKind::from_number(mission_type) else {
            self.serve_other_plans(link, sender, mission_type, message);
            return;
        };
        match message {
            PlanMessage::RequestList => self.send_count(link, sender, kind),
            PlanMessage::Request(seq, item_kind) => self.send_item(link, sender, kind, seq, item_kind),
            PlanMessage::Item { item, current: current @ (2 | 3), .. } if kind == PlanKind::Mission => {
                self.fly_to_item(link, sender, &item, current == 2);
            }
            PlanMessage::SetCurrent(seq) => {
                // It has no acknowledgement of its own. Whoever hears at once of another item than he asked for asks again.
                match self.set_current_item(seq, false) {
                    Ok(()) => self.send_stream(link, Stream::MissionCurrent),
                    Err(refusal) => self.say(MavSeverity::MAV_SEVERITY_WARNING, &refusal.reason.unwrap_or_default()),
                }
            }
            PlanMessage::Count(count) => self.begin_upload(link, sender, kind, count),
            PlanMessage::WritePartial(first, last) => self.begin_partial_upload(link, sender, kind, first, last),
            PlanMessage::Item { seq, item, .. } => self.take_item(link, sender, kind, seq, item),
            PlanMessage::ClearAll => self.clear_plan(link, sender, kind),
            PlanMessage::Ack(result) => self.hear_plan_ack(link, sender, kind, result),
        }
    }

    /// All plans at once (255) can only be cleared, and of any other type there are none.
    fn serve_other_plans(&mut self, link: usize, to: Target, mission_type: u8, message: PlanMessage) {
        const ALL: u8 = MavMissionType::MAV_MISSION_TYPE_ALL as u8;
        let result = match message {
            PlanMessage::ClearAll if mission_type == ALL => {
                let against = PlanKind::ALL.into_iter().find_map(|kind| self.against_clearing(link, to, kind));
                if against.is_none() {
                    PlanKind::ALL.into_iter().for_each(|kind| self.empty_plan(kind));
                }
                against.unwrap_or(MavMissionResult::MAV_MISSION_ACCEPTED)
            }
            // An acknowledgement is not answered.
            PlanMessage::Ack(_) => return,
            _ => MavMissionResult::MAV_MISSION_UNSUPPORTED,
        };
        if result != MavMissionResult::MAV_MISSION_ACCEPTED {
            self.say(MavSeverity::MAV_SEVERITY_WARNING, &refusal("Plan", result));
        }
        self.send_plan_ack(link, to, mission_type, result);
        self.tell_totals();
    }

    /// An item outside a mission, as clients steered before there were commands for it: fly there now, or only climb.
    fn fly_to_item(&mut self, link: usize, sender: Target, item: &PlanItem, there: bool) {
        let kind = PlanKind::Mission;
        if let Err(result) = mission::check(item, 0..0) {
            self.refuse_plan(link, sender, kind, result);
        } else if self.mode() != Mode::Guided {
            self.say(MavSeverity::MAV_SEVERITY_WARNING, &format!("Guided item: mode is {}", self.mode()));
            self.acknowledge_plan(link, sender, kind, MavMissionResult::MAV_MISSION_ERROR);
        } else {
            if there {
                self.flight.reposition(self.place_of(item), self.flight.tuning().loiter_radius_m);
                self.stop_setpoint_timeout();
            }
            self.flight.set_altitude(self.altitude_of(item), f64::INFINITY);
            self.acknowledge_plan(link, sender, kind, MavMissionResult::MAV_MISSION_ACCEPTED);
        }
    }

    fn send_count(&mut self, link: usize, to: Target, kind: PlanKind) {
        let Target { system_id: target_system, component_id: target_component } = to;
        let count = u16::try_from(self.plan(kind).len()).unwrap_or(u16::MAX);
        let mission_type = kind.mission_type();
        let count =
            MISSION_COUNT_DATA { count, target_system, target_component, mission_type, ..MISSION_COUNT_DATA::DEFAULT };
        self.links.send(link, &Message::MISSION_COUNT(count));
    }

    fn send_item(&mut self, link: usize, to: Target, kind: PlanKind, seq: u16, item_kind: ItemKind) {
        let is_home = kind == PlanKind::Mission && seq < self.mission.first;
        let item = if is_home { Some(self.home_item()) } else { self.plan(kind).get(usize::from(seq)).copied() };
        let Some(item) = item else {
            // ArduPilot tells how many there are.
            if item_kind == ItemKind::Int {
                self.send_count(link, to, kind);
            }
            self.refuse_plan(link, to, kind, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
            return;
        };
        let is_current = kind == PlanKind::Mission && !is_home && seq == self.progress.told();
        let mission_type = kind.mission_type() as u8;
        self.links
            .send_plan_item(link, &PlanItemMessage { mission_type, seq, item: &item, is_current, kind: item_kind, to });
    }

    /// Item 0 of a mission is home, whatever was uploaded for it.
    fn home_item(&self) -> PlanItem {
        let home = self.flight.home();
        let home = self.settings.frame.to_geodetic(home.x_m, home.y_m, home.altitude_m);
        let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&home);
        PlanItem {
            latitude_e7,
            longitude_e7,
            z_m: home.altitude_amsl_m as f32,
            command: WAYPOINT,
            autocontinue: 1,
            ..PlanItem::default()
        }
    }

    /// Says why, and acknowledges it.
    fn refuse_plan(&mut self, link: usize, to: Target, kind: PlanKind, result: MavMissionResult) {
        self.say(MavSeverity::MAV_SEVERITY_WARNING, &refusal(kind.name(), result));
        self.acknowledge_plan(link, to, kind, result);
    }

    fn acknowledge_plan(&mut self, link: usize, to: Target, kind: PlanKind, result: MavMissionResult) {
        self.send_plan_ack(link, to, kind.mission_type() as u8, result);
        self.tell_totals();
    }

    /// Everybody is told how many items there are, where that has changed.
    fn tell_totals(&mut self) {
        let now = PlanKind::ALL.map(|kind| self.parameter_value(kind.total()));
        let before = std::mem::replace(&mut self.plan_totals, now);
        for (kind, _) in PlanKind::ALL.into_iter().zip(before.into_iter().zip(now)).filter(|(_, (was, is))| was != is) {
            self.tell_parameter(kind.total());
        }
    }

    fn send_plan_ack(&mut self, link: usize, to: Target, mission_type: u8, result: MavMissionResult) {
        self.links.acknowledge_plan(link, mission_type, result, to);
    }
}

/// Whether items can be a plan; the index of the one that cannot, of the first too many or of their end, and why.
fn check_items(kind: PlanKind, items: &[PlanItem], personality: Personality) -> Result<(), (usize, String)> {
    let count = u16::try_from(items.len()).unwrap_or(u16::MAX);
    if count > kind.items_max() {
        let most = kind.items_max();
        return Err((usize::from(most), format!("{} refused: more than {most} items", kind.name())));
    }
    for (seq, item) in (0..count).zip(items) {
        // By which message it came is not known any more.
        let check = |by_integers| personality.check_plan_item(kind, seq, item, count, by_integers);
        check(true)
            .or_else(|result| check(false).map_err(|_| result))
            .map_err(|result| (usize::from(seq), format!("{}: item {seq}", refusal(kind.name(), result))))?;
    }
    if kind == PlanKind::Fence && personality != Personality::Px4 {
        fence::check_whole(items).map_err(|reason| (items.len(), format!("Fence refused: {reason}")))?;
    }
    Ok(())
}

/// A result code in words.
fn refusal(name: &str, result: MavMissionResult) -> String {
    let words = format!("{result:?}").to_lowercase().replace("mav_mission_", "").replace('_', " ");
    format!("{name} refused: {words}")
}
