//! Uploads. One replaces its plan when the last item has come and all of them make sense, and not before.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

use super::MissionService;
use super::check::{check, items_max, mission_type, refusal, result_of};
use crate::autopilot::mission::items::has_heading;
use crate::autopilot::plan::PlanKind;
use crate::error::Severity;
use crate::firmware::answers;
use crate::firmware::rules::Rules;
use crate::links::PeerId;
use crate::mode::Mode;
use crate::telemetry::announce::Component;
use mavlink_bridge::dialect::{
    MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, MavMissionResult, MavMissionType, Message,
};
use mavlink_bridge::{PlanItem, Target};
use std::time::Duration;

/// Host time after which an item is asked for again.
const ASK_AGAIN_AFTER: Duration = Duration::from_millis(400);
/// Host time without any item after which an upload is given up, as ArduPilot does.
const GIVE_UP_AFTER: Duration = Duration::from_secs(8);

/// The uploads that are under way, of each plan at most one.
#[derive(Debug, Default)]
pub(crate) struct Uploads([Option<Upload>; PlanKind::ALL.len()]);

/// An upload that is under way, or the one before: its writer may not have heard that it was accepted.
#[derive(Debug)]
struct Upload {
    writer: Writer,
    first: u16,
    items: Vec<PlanItem>,
    /// How many items are to come, and how many there will be on board.
    count: u16,
    total: u16,
    /// Host times.
    heard: Duration,
    ask_at: Duration,
}

/// Who uploads: somebody at an address, which several may share behind a router.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Writer {
    peer: PeerId,
    sender: Target,
}

impl Upload {
    fn is_complete(&self) -> bool {
        self.items.len() >= usize::from(self.count)
    }

    /// The index of the item that is waited for.
    fn next(&self) -> u16 {
        self.first + u16::try_from(self.items.len()).unwrap_or(u16::MAX)
    }

    /// Host time at which something is to be done about it.
    fn due(&self) -> Option<Duration> {
        (!self.is_complete()).then_some(self.ask_at)
    }
}

impl Uploads {
    /// Host time at which one of them wants attention.
    pub fn due(&self) -> Option<Duration> {
        self.0.iter().flatten().filter_map(Upload::due).min()
    }

    fn of(&mut self, kind: PlanKind) -> &mut Option<Upload> {
        &mut self.0[kind as usize]
    }
}

impl MissionService {
    /// Asks again for items that did not come, and in the end no more.
    pub(crate) fn check_uploads(&mut self, component: &mut Component) {
        self.check_transfers(component);
        let now = component.host_now;
        for kind in PlanKind::ALL {
            let Some(upload) =
                self.uploads.of(kind).as_mut().filter(|upload| upload.due().is_some_and(|due| due <= now))
            else {
                continue;
            };
            upload.ask_at = now + ASK_AGAIN_AFTER;
            let is_lost = now.saturating_sub(upload.heard) >= GIVE_UP_AFTER;
            let writer = upload.writer;
            match component.peers().of_peer(writer.peer) {
                Some(link) if !is_lost => self.ask_for_item(component, link, kind),
                link => {
                    *self.uploads.of(kind) = None;
                    component.autopilot.say(Severity::Warning, &format!("{} upload timeout", kind.name()));
                    if let Some(link) = link {
                        let result = MavMissionResult::MAV_MISSION_OPERATION_CANCELLED;
                        self.acknowledge_plan(component, link, writer.sender, kind, result);
                    }
                }
            }
        }
    }

    pub(super) fn begin_upload(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
        count: u16,
    ) {
        if self.is_uploaded_by_another(component, link, sender, kind) {
            self.refuse_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_DENIED);
            return;
        }
        // Whoever begins anew has given up what he began before.
        *self.uploads.of(kind) = None;
        let most = items_max(component.autopilot.rules(), kind);
        if count > most {
            let text = format!("Only {most} items are supported");
            component.autopilot.say(Severity::Warning, &text);
            self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_NO_SPACE);
        } else if count == 0 {
            if kind == PlanKind::Mission {
                component.autopilot.say(Severity::Info, "Flight plan received");
            }
            self.accept_empty_plan(component, link, sender, kind);
        } else {
            self.ask_for_items(component, link, sender, kind, 0..count, count);
        }
    }

    /// Items from `first` to `last` are to be replaced; the one behind the end is added.
    pub(super) fn begin_partial_upload(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
        first: i16,
        last: i16,
    ) {
        let on_board = u16::try_from(component.autopilot.plan(kind).len()).unwrap_or(u16::MAX);
        let most = items_max(component.autopilot.rules(), kind);
        let range = u16::try_from(first).ok().zip(u16::try_from(last).ok());
        let range = range.filter(|(first, last)| first <= last && *last <= on_board && *last < most);
        // Not even who uploads himself may write a part meanwhile.
        if self.uploads.of(kind).as_ref().is_some_and(|upload| !upload.is_complete()) {
            self.refuse_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_DENIED);
        } else if let Some((first, last)) = range {
            self.ask_for_items(component, link, sender, kind, first..last + 1, on_board.max(last + 1));
        } else {
            component.autopilot.say(Severity::Warning, "Flight plan update rejected");
            self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ERROR);
        }
    }

    pub(super) fn take_item(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
        seq: u16,
        item: PlanItem,
    ) {
        let item = read_item(component.autopilot.rules(), item);
        let (now, writer) = (component.host_now, Writer { peer: component.peers().peer(link), sender });
        let Some(upload) = self.uploads.of(kind) else {
            self.refuse_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ERROR);
            return;
        };
        let (next, total, is_complete) = (upload.next(), upload.total, upload.is_complete());
        if upload.writer != writer {
            let nobody =
                if is_complete { MavMissionResult::MAV_MISSION_ERROR } else { MavMissionResult::MAV_MISSION_DENIED };
            self.refuse_plan(component, link, sender, kind, nobody);
        } else if is_complete && seq.checked_add(1) == Some(next) {
            // The last item again: the acknowledgement was lost.
            self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ACCEPTED);
        } else if is_complete {
            self.refuse_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ERROR);
        } else if seq > next {
            // As in ArduPilot, the upload goes on with the item that was asked for.
            self.refuse_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
        } else if seq == next {
            let by_integers = !component.peers().has_old_items(link);
            let rules = component.autopilot.rules();
            if let Err(error) = check(rules, kind, (seq, &item), total, by_integers) {
                let result = result_of(error);
                *self.uploads.of(kind) = None;
                let text = format!("{}, item {seq} ({})", refusal(kind.name(), result), item.command);
                component.autopilot.say(Severity::Warning, &text);
                self.acknowledge_plan(component, link, sender, kind, result);
                return;
            }
            upload.items.push(answers::kept_plan_item(rules, kind, &item));
            (upload.heard, upload.ask_at) = (now, now + ASK_AGAIN_AFTER);
            if upload.is_complete() {
                self.end_upload(component, link, sender, kind);
            } else {
                self.ask_for_item(component, link, kind);
            }
        }
        // An item that has come before is a repeat of somebody who did not hear the next request.
    }

    pub(super) fn clear_plan(&mut self, component: &mut Component, link: usize, sender: Target, kind: PlanKind) {
        match self.against_clearing(component, link, sender, kind) {
            Some(result) => self.refuse_plan(component, link, sender, kind, result),
            None => {
                self.accept_empty_plan(component, link, sender, kind);
                if kind == PlanKind::Mission {
                    component.autopilot.have_cleared_mission();
                }
            }
        }
    }

    /// Why a plan may not be cleared, if so: another one uploads it, or it is a mission that is flown.
    pub(super) fn against_clearing(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
    ) -> Option<MavMissionResult> {
        if self.is_uploaded_by_another(component, link, sender, kind) {
            Some(MavMissionResult::MAV_MISSION_DENIED)
        } else if kind == PlanKind::Mission
            && component.autopilot.mode() == Mode::Auto
            && component.autopilot.flight.is_armed()
        {
            component.autopilot.say(Severity::Warning, "Mission: it is flown");
            Some(MavMissionResult::MAV_MISSION_ERROR)
        } else {
            None
        }
    }

    fn accept_empty_plan(&mut self, component: &mut Component, link: usize, sender: Target, kind: PlanKind) {
        self.empty_plan(component, kind);
        self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ACCEPTED);
    }

    pub(super) fn empty_plan(&mut self, component: &mut Component, kind: PlanKind) {
        *self.uploads.of(kind) = None;
        // Nothing makes sense as a whole.
        let _ = self.replace_plan(component, kind, Vec::new(), true);
    }

    /// Who uploads may break it off. It is not answered: who goes on to another upload would take that for its answer.
    /// An ArduPilot passes it over, and gives the upload up in the end.
    pub(super) fn hear_plan_ack(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
        result: u8,
    ) {
        // What is not supported is the message by which an item was asked for.
        let is_broken_off = result != MavMissionResult::MAV_MISSION_ACCEPTED as u8
            && result != MavMissionResult::MAV_MISSION_UNSUPPORTED as u8
            && component.autopilot.rules().upload_can_be_broken_off;
        let is_under_way = self.uploads.of(kind).as_ref().is_some_and(|upload| !upload.is_complete());
        if is_broken_off && is_under_way && !self.is_uploaded_by_another(component, link, sender, kind) {
            *self.uploads.of(kind) = None;
        }
        if is_under_way && result == MavMissionResult::MAV_MISSION_UNSUPPORTED as u8 {
            let has_old_items = component.peers().has_old_items(link);
            component.links().note_old_items(link, !has_old_items);
        }
    }

    pub(super) fn is_uploaded_by_another(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
    ) -> bool {
        let writer = Writer { peer: component.peers().peer(link), sender };
        self.uploads.of(kind).as_ref().is_some_and(|upload| !upload.is_complete() && upload.writer != writer)
    }

    fn ask_for_items(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        kind: PlanKind,
        range: std::ops::Range<u16>,
        total: u16,
    ) {
        let writer = Writer { peer: component.peers().peer(link), sender };
        let (heard, ask_at) = (component.host_now, component.host_now + ASK_AGAIN_AFTER);
        let (first, count) = (range.start, range.end - range.start);
        *self.uploads.of(kind) = Some(Upload { writer, first, items: Vec::new(), count, total, heard, ask_at });
        self.ask_for_item(component, link, kind);
    }

    fn ask_for_item(&mut self, component: &mut Component, link: usize, kind: PlanKind) {
        let Some(upload) = self.uploads.of(kind) else { return };
        let (seq, to) = (upload.next(), upload.writer.sender);
        let has_old_items = component.peers().has_old_items(link);
        let by_old_message = component.autopilot.rules().asks_by_old_message || has_old_items;
        let request = item_request(seq, to, mission_type(kind), by_old_message);
        component.links().send(link, &request);
    }

    /// The last item has come.
    fn end_upload(&mut self, component: &mut Component, link: usize, sender: Target, kind: PlanKind) {
        let Some(upload) = self.uploads.of(kind) else { return };
        let (first, total, new) = (usize::from(upload.first), upload.total, upload.items.clone());
        let anew = upload.count == total;
        let mut items = if anew { Vec::new() } else { component.autopilot.plan(kind).to_vec() };
        items.resize(usize::from(total), PlanItem::default());
        for (kept, new) in items.iter_mut().skip(first).zip(new) {
            *kept = new;
        }
        // An ArduPlane that has no home on board puts it before the first item that comes, in whose place the second
        // one then comes: a single item is flown (`AP_Mission::add_cmd`).
        if kind == PlanKind::Mission && total == 1 && component.autopilot.mission().is_without_home() {
            items.insert(0, PlanItem::default());
        }
        match self.replace_plan(component, kind, items, anew) {
            Ok(()) => {
                if kind == PlanKind::Mission {
                    component.autopilot.say(Severity::Info, "Flight plan received");
                }
                self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ACCEPTED);
            }
            Err(error) => {
                *self.uploads.of(kind) = None;
                component.say(Severity::Warning, &error.to_string());
                self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ERROR);
            }
        }
    }
}

/// An item as it is understood: of some autopilots, a param that is not a number is one left out.
pub(super) fn read_item(rules: &Rules, item: PlanItem) -> PlanItem {
    if !rules.nan_params_are_left_out {
        return item;
    }
    let mut params = item.params.map(|param| if param.is_nan() { 0.0 } else { param });
    if has_heading(item.command) {
        params[3] = item.params[3];
    }
    PlanItem { params, ..item }
}

/// How an item of an upload is asked for. ArduPlane still asks by the older message, and some clients (dronekit) answer
/// no other: a PX4 asks those by it that have used it themselves.
pub(super) fn item_request(seq: u16, to: Target, mission_type: MavMissionType, by_old_message: bool) -> Message {
    let Target { system_id: target_system, component_id: target_component } = to;
    if by_old_message {
        Message::MISSION_REQUEST(MISSION_REQUEST_DATA { seq, target_system, target_component, mission_type })
    } else {
        Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA { seq, target_system, target_component, mission_type })
    }
}
