//! Transfers of plans as a PX4 has them (`mavlink_mission.cpp`): one with each partner at a time, either way. Who asks
//! for something else meanwhile hears that it is busy; what nobody has begun is not answered.

// Clients still speak what the dialect calls superseded, and PX4 answers.
#![allow(deprecated)]

use super::MissionService;
use super::check::{check, items_max, kind_of, refusal, result_of};
use super::upload::{item_request, read_item};
use crate::autopilot::plan::PlanKind;
use crate::error::Severity;
use crate::firmware::answers::told_plan_item;
use crate::links::PeerId;
use crate::telemetry::announce::Component;
use crate::telemetry::checksum;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MISSION_COUNT_DATA, MavMissionResult as Result, MavMissionType, Message};
use mavlink_bridge::{ItemKind, PlanItem, PlanItemMessage, PlanMessage, Target};
use std::time::Duration;

/// Host time after which an item, or a count that was told, is sent again.
const RETRY: Duration = Duration::from_millis(250);
/// Host time without a word of the partner after which a transfer is given up.
const TIMEOUT: Duration = Duration::from_secs(5);
const ALL: u8 = MavMissionType::MAV_MISSION_TYPE_ALL as u8;

/// One transfer for each address that something came from, be it over: a PX4 remembers its last partner.
#[derive(Debug, Default)]
pub(super) struct Transfers(Vec<Transfer>);

#[derive(Debug)]
struct Transfer {
    peer: PeerId,
    stage: Stage,
    /// Nobody yet: none.
    partner: Option<Target>,
    mission_type: u8,
    /// The item that is waited for, or the next one that is expected to be asked for.
    next: u16,
    count: u16,
    items: Vec<PlanItem>,
    /// The last item that came as the current one.
    current: Option<u16>,
    /// Host times.
    heard: Duration,
    sent: Duration,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Idle,
    /// An upload.
    Receiving,
    /// A download.
    Sending,
}

/// Where a message came from, and of which plan it is.
#[derive(Clone, Copy)]
struct Said {
    link: usize,
    sender: Target,
    mission_type: u8,
}

impl Transfers {
    /// Host time at which one of them wants attention.
    pub fn due(&self) -> Option<Duration> {
        self.0.iter().filter_map(Transfer::due).min()
    }

    /// Takes out the transfer with an address, one that has not begun if there is none.
    fn take(&mut self, peer: PeerId) -> Transfer {
        match self.0.iter().position(|transfer| transfer.peer == peer) {
            Some(index) => self.0.swap_remove(index),
            None => Transfer {
                peer,
                stage: Stage::Idle,
                partner: None,
                mission_type: 0,
                next: 0,
                count: 0,
                items: Vec::new(),
                current: None,
                heard: Duration::ZERO,
                sent: Duration::ZERO,
            },
        }
    }

    /// Whether anybody uploads whose transfer has not been taken out.
    fn is_any_receiving(&self) -> bool {
        self.0.iter().any(|transfer| transfer.stage == Stage::Receiving)
    }
}

impl Transfer {
    fn due(&self) -> Option<Duration> {
        let retries = match self.stage {
            Stage::Idle => return None,
            Stage::Receiving => true,
            Stage::Sending => self.next == 0,
        };
        let lost_at = self.heard + TIMEOUT;
        Some(if retries { lost_at.min(self.sent + RETRY) } else { lost_at })
    }

    fn is_with(&self, said: &Said) -> bool {
        self.partner == Some(said.sender)
    }

    fn end(&mut self) {
        self.stage = Stage::Idle;
        self.items = Vec::new();
    }
}

fn say(component: &mut Component, text: &str) {
    component.autopilot.say(Severity::Critical, text);
}

impl MissionService {
    pub(super) fn serve_as_px4(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        mission_type: u8,
        message: PlanMessage,
    ) {
        let peer = component.peers().peer(link);
        let mut transfer = self.transfers.take(peer);
        let said = Said { link, sender, mission_type };
        match message {
            PlanMessage::RequestList => self.begin_sending(component, &said, &mut transfer),
            PlanMessage::Request(seq, kind) => self.send_requested(component, &said, &mut transfer, seq, kind),
            PlanMessage::Count(count) => self.begin_receiving(component, &said, &mut transfer, count),
            PlanMessage::Item { seq, item, current, .. } => {
                self.receive_item(component, &said, &mut transfer, (seq, item), current != 0);
            }
            PlanMessage::Ack(result) => hear_ack(component, &said, &mut transfer, result),
            PlanMessage::ClearAll if transfer.stage != Stage::Idle => say(component, "WPM: IGN CLEAR CMD: Busy"),
            PlanMessage::ClearAll => self.clear_as_px4(component, &said),
            PlanMessage::SetCurrent(_) if transfer.stage != Stage::Idle => {
                say(component, "WPM: IGN WP CURR CMD: Busy");
            }
            PlanMessage::SetCurrent(seq) => match component.autopilot.set_current_item(seq, false) {
                Ok(()) => component.send_stream(link, Stream::MissionCurrent),
                Err(_) => say(component, "WPM: WP CURR CMD: Not in list"),
            },
            // A PX4 does not know it.
            PlanMessage::WritePartial(..) => {}
        }
        self.transfers.0.retain(|other| other.stage != Stage::Idle || component.peers().of_peer(other.peer).is_some());
        self.transfers.0.push(transfer);
    }

    /// Sends again what was not answered, and gives up in the end.
    pub(super) fn check_transfers(&mut self, component: &mut Component) {
        let now = component.host_now;
        for transfer in &mut self.transfers.0 {
            if transfer.due().is_none_or(|due| due > now) {
                continue;
            }
            let link = component.peers().of_peer(transfer.peer);
            let Some(link) = link.filter(|_| now.saturating_sub(transfer.heard) < TIMEOUT) else {
                transfer.end();
                say(component, "Mission sync timeout");
                continue;
            };
            match transfer.stage {
                Stage::Receiving => ask_for_item(component, link, transfer),
                Stage::Sending => tell_count(component, link, transfer),
                Stage::Idle => {}
            }
        }
    }

    /// MISSION_REQUEST_LIST. A transfer whose items have all been sent is over, though nobody has said so.
    fn begin_sending(&mut self, component: &mut Component, said: &Said, transfer: &mut Transfer) {
        let is_sending = transfer.stage == Stage::Sending;
        let is_over = is_sending && transfer.next == transfer.count;
        let is_again = is_sending && transfer.mission_type == said.mission_type && transfer.is_with(said);
        if transfer.stage != Stage::Idle && !is_over && !is_again {
            component.autopilot.say(Severity::Info, "Mission download request ignored, already active");
            return;
        }
        let items = kind_of(said.mission_type).map_or(0, |kind| component.autopilot.plan(kind).len());
        *transfer = Transfer {
            stage: Stage::Sending,
            partner: Some(said.sender),
            mission_type: said.mission_type,
            next: 0,
            count: u16::try_from(items).unwrap_or(u16::MAX),
            items: Vec::new(),
            heard: component.host_now,
            ..*transfer
        };
        tell_count(component, said.link, transfer);
    }

    /// MISSION_REQUEST_INT or MISSION_REQUEST: of the items one after the other, or the last one again.
    fn send_requested(
        &mut self,
        component: &mut Component,
        said: &Said,
        transfer: &mut Transfer,
        seq: u16,
        item_kind: ItemKind,
    ) {
        if !transfer.is_with(said) {
            return say(component, "WPM: REJ. CMD: partner id mismatch");
        }
        match transfer.stage {
            Stage::Idle => return,
            Stage::Receiving => return say(component, "WPM: REJ. CMD: Busy"),
            Stage::Sending if transfer.mission_type != said.mission_type => return,
            Stage::Sending => {}
        }
        transfer.heard = component.host_now;
        let plan = kind_of(said.mission_type);
        let item = plan.and_then(|kind| component.autopilot.plan(kind).get(usize::from(seq)).copied());
        let is_next = seq == transfer.next && transfer.next < transfer.count;
        let Some(item) = item.filter(|_| is_next || seq.checked_add(1) == Some(transfer.next)) else {
            transfer.end();
            self.send_plan_ack(component, said.link, said.sender, said.mission_type, Result::MAV_MISSION_ERROR);
            return say(component, "WPM: REJ. CMD: Req. WP was unexpected");
        };
        transfer.next = seq + 1;
        transfer.sent = component.host_now;
        let by_integers = item_kind == ItemKind::Int;
        let item = plan.map_or(item, |kind| told_plan_item(component.autopilot.rules(), kind, &item, by_integers));
        let is_current = plan == Some(PlanKind::Mission) && seq == component.autopilot.session.progress.told();
        component.links().send_plan_item(
            said.link,
            &PlanItemMessage {
                mission_type: said.mission_type,
                seq,
                item: &item,
                is_current,
                kind: item_kind,
                to: said.sender,
            },
        );
    }

    /// MISSION_COUNT.
    fn begin_receiving(&mut self, component: &mut Component, said: &Said, transfer: &mut Transfer, count: u16) {
        let Said { link, sender, mission_type } = *said;
        let refuse = |service: &mut Self, component: &mut Component, result| {
            service.send_plan_ack(component, link, sender, mission_type, result);
        };
        match transfer.stage {
            Stage::Idle => {}
            Stage::Receiving if !transfer.is_with(said) => {
                return refuse(self, component, Result::MAV_MISSION_ERROR);
            }
            // The request for the first item was lost.
            Stage::Receiving if transfer.next == 0 => {
                transfer.heard = component.host_now;
                return ask_for_item(component, link, transfer);
            }
            Stage::Receiving => {
                transfer.heard = component.host_now;
                say(component, "WPM: REJ. CMD: Busy");
                return refuse(self, component, Result::MAV_MISSION_ERROR);
            }
            Stage::Sending => {
                say(component, "WPM: IGN MISSION_COUNT: Busy");
                return refuse(self, component, Result::MAV_MISSION_ERROR);
            }
        }
        if self.transfers.is_any_receiving() {
            return refuse(self, component, Result::MAV_MISSION_ERROR);
        }
        let kind = kind_of(mission_type);
        *transfer = Transfer {
            partner: Some(sender),
            mission_type,
            next: 0,
            count,
            items: Vec::new(),
            current: None,
            heard: component.host_now,
            ..*transfer
        };
        let rules = component.autopilot.rules();
        if count > kind.map_or(0, |kind| items_max(rules, kind)) {
            return refuse(self, component, Result::MAV_MISSION_NO_SPACE);
        }
        if count > 0 {
            transfer.stage = Stage::Receiving;
            return ask_for_item(component, link, transfer);
        }
        if let Some(kind) = kind {
            self.empty_plan(component, kind);
        }
        self.send_plan_ack(component, link, sender, mission_type, Result::MAV_MISSION_ACCEPTED);
        self.tell_totals(component);
    }

    /// MISSION_ITEM_INT or MISSION_ITEM.
    fn receive_item(
        &mut self,
        component: &mut Component,
        said: &Said,
        transfer: &mut Transfer,
        (seq, item): (u16, PlanItem),
        is_current: bool,
    ) {
        let Said { link, sender, mission_type } = *said;
        if !transfer.is_with(said) {
            return say(component, "REJ. MIS ITEM: partner id mismatch");
        }
        if transfer.mission_type != mission_type {
            // It is told of the plan that is transferred.
            return self.send_plan_ack(component, link, sender, transfer.mission_type, Result::MAV_MISSION_ERROR);
        }
        match transfer.stage {
            // The last item again: the acknowledgement was lost.
            Stage::Idle if seq.checked_add(1) == Some(transfer.next) => {
                return self.send_plan_ack(component, link, sender, mission_type, Result::MAV_MISSION_ACCEPTED);
            }
            Stage::Idle => {
                say(component, "IGN MISSION_ITEM: No transfer");
                return self.send_plan_ack(component, link, sender, mission_type, Result::MAV_MISSION_ERROR);
            }
            Stage::Sending => {
                say(component, "IGN MISSION_ITEM: Busy");
                return self.send_plan_ack(component, link, sender, mission_type, Result::MAV_MISSION_ERROR);
            }
            Stage::Receiving => transfer.heard = component.host_now,
        }
        // Another item than the one that was asked for is passed over. Uploads are of plans that there are.
        let Some(kind) = kind_of(mission_type).filter(|_| seq == transfer.next) else { return };
        let rules = component.autopilot.rules();
        let item = read_item(rules, item);
        let by_integers = !component.peers().has_old_items(link);
        if let Err(error) = check(rules, kind, (seq, &item), transfer.count, by_integers) {
            let result = result_of(error);
            transfer.end();
            if result != Result::MAV_MISSION_ERROR {
                say(component, "IGN MISSION_ITEM: Invalid item");
            }
            say(component, &format!("{}, item {seq} ({})", refusal(kind.name(), result), item.command));
            return self.send_plan_ack(component, link, sender, mission_type, result);
        }
        transfer.items.push(item);
        transfer.next = seq + 1;
        if is_current {
            transfer.current = Some(seq);
        }
        if transfer.next < transfer.count {
            return ask_for_item(component, link, transfer);
        }
        let (items, current) = (std::mem::take(&mut transfer.items), transfer.current);
        transfer.end();
        // The same plan again changes nothing.
        let accepted = if items == component.autopilot.plan(kind) {
            Ok(())
        } else {
            let before = component.autopilot.session.progress.current();
            let accepted = self.replace_plan(component, kind, items, true);
            if accepted.is_ok() && kind == PlanKind::Mission {
                component.autopilot.start_mission_at(current.unwrap_or(before));
            }
            accepted
        };
        let result = accepted.map_or(Result::MAV_MISSION_ERROR, |()| Result::MAV_MISSION_ACCEPTED);
        let plan_id = if result == Result::MAV_MISSION_ACCEPTED { checksum(component.autopilot.plan(kind)) } else { 0 };
        component.links().acknowledge_plan(link, mission_type, result, plan_id, sender);
        self.tell_totals(component);
    }

    /// MISSION_CLEAR_ALL; of a plan that there is not it is accepted.
    fn clear_as_px4(&mut self, component: &mut Component, said: &Said) {
        for kind in PlanKind::ALL {
            if said.mission_type == ALL || kind_of(said.mission_type) == Some(kind) {
                self.empty_plan(component, kind);
            }
        }
        self.send_plan_ack(component, said.link, said.sender, said.mission_type, Result::MAV_MISSION_ACCEPTED);
        self.tell_totals(component);
    }
}

/// MISSION_ACK: ends a download, cancels an upload, or says that the other message is not supported.
fn hear_ack(component: &mut Component, said: &Said, transfer: &mut Transfer, result: u8) {
    if !transfer.is_with(said) {
        return say(component, "REJ. WP CMD: partner id mismatch");
    }
    match transfer.stage {
        Stage::Sending if transfer.mission_type == said.mission_type => transfer.end(),
        Stage::Receiving if result == Result::MAV_MISSION_UNSUPPORTED as u8 => {
            let has_old_items = component.peers().has_old_items(said.link);
            component.links().note_old_items(said.link, !has_old_items);
            ask_for_item(component, said.link, transfer);
        }
        Stage::Receiving if result == Result::MAV_MISSION_OPERATION_CANCELLED as u8 => transfer.end(),
        _ => {}
    }
}

fn ask_for_item(component: &mut Component, link: usize, transfer: &mut Transfer) {
    let Some((to, kind)) = transfer.partner.zip(kind_of(transfer.mission_type)) else { return };
    transfer.sent = component.host_now;
    let by_old_message = component.peers().has_old_items(link);
    let request = item_request(transfer.next, to, super::mission_type(kind), by_old_message);
    component.links().send(link, &request);
}

/// How many items there are, of a plan that there is not: none.
fn tell_count(component: &mut Component, link: usize, transfer: &mut Transfer) {
    let Some(Target { system_id: target_system, component_id: target_component }) = transfer.partner else { return };
    let kind = kind_of(transfer.mission_type);
    let mission_type = match kind {
        Some(kind) => super::mission_type(kind),
        None if transfer.mission_type == ALL => MavMissionType::MAV_MISSION_TYPE_ALL,
        None => return,
    };
    transfer.sent = component.host_now;
    let count = MISSION_COUNT_DATA {
        count: transfer.count,
        target_system,
        target_component,
        mission_type,
        opaque_id: kind.map_or(0, |kind| checksum(component.autopilot.plan(kind))),
    };
    component.links().send(link, &Message::MISSION_COUNT(count));
}
