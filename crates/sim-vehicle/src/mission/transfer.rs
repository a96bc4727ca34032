//! Uploads and downloads. An upload replaces the mission when its last item has come, and not before.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

use super::{ITEMS_MAX, WAYPOINT, check};
use crate::streams::Stream;
use crate::{PeerId, Vehicle};
use mavlink_bridge::dialect::{
    MISSION_ACK_DATA, MISSION_COUNT_DATA, MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, MavMissionResult,
    MavMissionType, MavSeverity, Message,
};
use mavlink_bridge::{ItemKind, PlanItem, PlanMessage, Target, Version};
use std::time::Duration;

/// Host time after which an item is asked for again.
const ASK_AGAIN_AFTER: Duration = Duration::from_millis(400);
/// Host time without any item after which an upload is given up, as ArduPilot does.
const GIVE_UP_AFTER: Duration = Duration::from_secs(8);

/// An upload that is under way, or the one before: its writer may not have heard that it was accepted.
#[derive(Debug)]
pub(crate) struct Upload {
    peer: PeerId,
    sender: Target,
    first: u16,
    items: Vec<PlanItem>,
    /// How many items are to come, and how many there will be on board.
    count: u16,
    total: u16,
    /// Host times.
    heard: Duration,
    ask_at: Duration,
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
    pub fn due(&self) -> Option<Duration> {
        (!self.is_complete()).then_some(self.ask_at)
    }
}

impl Vehicle {
    pub(crate) fn serve_plan(&mut self, link: usize, sender: Target, mission_type: u8, message: PlanMessage) {
        let kind = match mission_type {
            0 => MavMissionType::MAV_MISSION_TYPE_MISSION,
            1 => MavMissionType::MAV_MISSION_TYPE_FENCE,
            2 => MavMissionType::MAV_MISSION_TYPE_RALLY,
            _ => MavMissionType::MAV_MISSION_TYPE_ALL,
        };
        if kind != MavMissionType::MAV_MISSION_TYPE_MISSION {
            self.serve_empty_plan(link, sender, kind, message);
            return;
        }
        match message {
            PlanMessage::RequestList => self.send_count(link, sender, kind, self.mission.len()),
            PlanMessage::Request(seq, item_kind) => self.send_item(link, sender, seq, item_kind),
            PlanMessage::Count(count) => self.begin_upload(link, sender, 0, count, count),
            PlanMessage::WritePartial(first, last) => self.begin_partial_upload(link, sender, first, last),
            PlanMessage::Item(seq, item, current) => self.take_item(link, sender, seq, item, current),
            PlanMessage::ClearAll => self.clear_mission(link, sender),
            PlanMessage::SetCurrent(seq) => {
                if let Err(reason) = self.set_current_item(seq) {
                    self.say(MavSeverity::MAV_SEVERITY_WARNING, &reason);
                }
                // It has no acknowledgement of its own: this tells what has become of it.
                self.send_stream(link, Stream::MissionCurrent);
            }
        }
    }

    /// Fences and rally points are not simulated: their plans are empty.
    fn serve_empty_plan(&mut self, link: usize, to: Target, kind: MavMissionType, message: PlanMessage) {
        let every = kind == MavMissionType::MAV_MISSION_TYPE_ALL;
        match message {
            PlanMessage::RequestList if !every => self.send_count(link, to, kind, 0),
            PlanMessage::ClearAll if every => self.clear_mission(link, to),
            PlanMessage::ClearAll => self.acknowledge_plan(link, to, kind, MavMissionResult::MAV_MISSION_ACCEPTED),
            PlanMessage::Request(..) => {
                self.acknowledge_plan(link, to, kind, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
            }
            _ => {
                self.say(MavSeverity::MAV_SEVERITY_WARNING, "Fences and rally points are not simulated");
                self.acknowledge_plan(link, to, kind, MavMissionResult::MAV_MISSION_UNSUPPORTED);
            }
        }
    }

    /// Host time at which an upload wants attention.
    pub(crate) fn upload_due(&self) -> Option<Duration> {
        self.upload.as_ref().and_then(Upload::due)
    }

    /// Asks again for an item that did not come, and in the end no more.
    pub(crate) fn check_upload(&mut self) {
        let now = self.host_now;
        let Some(upload) = self.upload.as_mut().filter(|upload| upload.due().is_some_and(|due| due <= now)) else {
            return;
        };
        upload.ask_at = now + ASK_AGAIN_AFTER;
        let link = self.links.of_peer(upload.peer);
        match link {
            Some(link) if now.saturating_sub(upload.heard) < GIVE_UP_AFTER => self.ask_for_item(link),
            Some(link) => self.end_upload(link, MavMissionResult::MAV_MISSION_OPERATION_CANCELLED),
            None => self.upload = None,
        }
    }

    fn begin_partial_upload(&mut self, link: usize, sender: Target, first: i16, last: i16) {
        let total = self.mission.len();
        let range = u16::try_from(first).ok().zip(u16::try_from(last).ok());
        match range.filter(|(first, last)| first <= last && *last < total) {
            Some((first, last)) => self.begin_upload(link, sender, first, last - first + 1, total),
            None => self.refuse_mission(link, sender, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE),
        }
    }

    fn begin_upload(&mut self, link: usize, sender: Target, first: u16, count: u16, total: u16) {
        let peer = self.links.peer(link);
        if self.upload.as_ref().is_some_and(|upload| !upload.is_complete() && upload.peer != peer) {
            self.refuse_mission(link, sender, MavMissionResult::MAV_MISSION_DENIED);
        } else if total > ITEMS_MAX {
            self.refuse_mission(link, sender, MavMissionResult::MAV_MISSION_NO_SPACE);
        } else if count == 0 {
            self.clear_mission(link, sender);
        } else {
            let (heard, ask_at) = (self.host_now, self.host_now + ASK_AGAIN_AFTER);
            self.upload = Some(Upload { peer, sender, first, items: Vec::new(), count, total, heard, ask_at });
            self.ask_for_item(link);
        }
    }

    fn take_item(&mut self, link: usize, sender: Target, seq: u16, item: PlanItem, current: u8) {
        let peer = self.links.peer(link);
        let now = self.host_now;
        // 2 and 3 once meant "fly there now" and "climb there now", without an upload.
        let Some(upload) = self.upload.as_mut().filter(|upload| current < 2 && upload.peer == peer) else {
            self.refuse_mission(link, sender, MavMissionResult::MAV_MISSION_ERROR);
            return;
        };
        let next = upload.next();
        if upload.is_complete() && seq < next {
            // The acknowledgement was lost.
            self.acknowledge_mission(link, sender, MavMissionResult::MAV_MISSION_ACCEPTED);
        } else if seq > next || upload.is_complete() {
            self.end_upload(link, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
        } else if seq == next {
            // Home is what it is.
            if let Err(result) = if seq == 0 { Ok(()) } else { check(&item, upload.total) } {
                self.end_upload(link, result);
                return;
            }
            upload.items.push(item);
            (upload.heard, upload.ask_at) = (now, now + ASK_AGAIN_AFTER);
            if upload.is_complete() { self.take_mission(link) } else { self.ask_for_item(link) }
        }
        // An item that has come before is a repeat of somebody who did not hear the next request.
    }

    fn take_mission(&mut self, link: usize) {
        let Some(upload) = &self.upload else { return };
        let (first, sender) = (usize::from(upload.first), upload.sender);
        if upload.count == upload.total {
            self.mission.items.clone_from(&upload.items);
        } else {
            for (kept, new) in self.mission.items.iter_mut().skip(first).zip(&upload.items) {
                *kept = *new;
            }
        }
        let whole = upload.count == upload.total;
        self.mission_changed(whole);
        self.acknowledge_mission(link, sender, MavMissionResult::MAV_MISSION_ACCEPTED);
    }

    fn clear_mission(&mut self, link: usize, sender: Target) {
        self.mission.items.clear();
        self.upload = None;
        self.mission_changed(true);
        self.acknowledge_mission(link, sender, MavMissionResult::MAV_MISSION_ACCEPTED);
    }

    /// Nothing of it is kept.
    fn end_upload(&mut self, link: usize, result: MavMissionResult) {
        if let Some(upload) = self.upload.take() {
            self.refuse_mission(link, upload.sender, result);
        }
    }

    fn ask_for_item(&mut self, link: usize) {
        let Some(upload) = &self.upload else { return };
        let Target { system_id: target_system, component_id: target_component } = upload.sender;
        let (seq, mission_type) = (upload.next(), MavMissionType::MAV_MISSION_TYPE_MISSION);
        let request = match self.links.version(link) {
            Version::V1 => {
                Message::MISSION_REQUEST(MISSION_REQUEST_DATA { seq, target_system, target_component, mission_type })
            }
            Version::V2 => Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
                seq,
                target_system,
                target_component,
                mission_type,
            }),
        };
        self.links.send(link, &request);
    }

    fn send_item(&mut self, link: usize, to: Target, seq: u16, kind: ItemKind) {
        let Some(mut item) = self.mission.get(seq).copied() else {
            self.refuse_mission(link, to, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
            return;
        };
        if seq == 0 {
            let home = self.flight.home();
            let home = self.settings.frame.to_geodetic(home.x_m, home.y_m, home.altitude_m);
            item = PlanItem {
                latitude_e7: (home.latitude_deg * 1e7).round() as i32,
                longitude_e7: (home.longitude_deg * 1e7).round() as i32,
                z_m: home.altitude_amsl_m as f32,
                command: WAYPOINT,
                autocontinue: 1,
                ..PlanItem::default()
            };
        }
        let is_current = seq == self.progress.current;
        self.links.send_plan_item(link, seq, &item, is_current, kind, to);
    }

    fn send_count(&mut self, link: usize, to: Target, mission_type: MavMissionType, count: u16) {
        let Target { system_id: target_system, component_id: target_component } = to;
        let count =
            MISSION_COUNT_DATA { count, target_system, target_component, mission_type, ..MISSION_COUNT_DATA::DEFAULT };
        self.links.send(link, &Message::MISSION_COUNT(count));
    }

    fn refuse_mission(&mut self, link: usize, to: Target, result: MavMissionResult) {
        let text = format!("{result:?}").to_lowercase().replace("mav_mission_", "Mission refused: ").replace('_', " ");
        self.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
        self.acknowledge_mission(link, to, result);
    }

    fn acknowledge_mission(&mut self, link: usize, to: Target, result: MavMissionResult) {
        self.acknowledge_plan(link, to, MavMissionType::MAV_MISSION_TYPE_MISSION, result);
    }

    fn acknowledge_plan(&mut self, link: usize, to: Target, mission_type: MavMissionType, result: MavMissionResult) {
        let Target { system_id: target_system, component_id: target_component } = to;
        let ack = MISSION_ACK_DATA {
            target_system,
            target_component,
            mavtype: result,
            mission_type,
            ..MISSION_ACK_DATA::DEFAULT
        };
        self.links.send(link, &Message::MISSION_ACK(ack));
    }
}
