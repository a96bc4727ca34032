//! The plans that ground stations upload and read: missions, fences and rally points, by one protocol
//! (<https://mavlink.io/en/services/mission.html>), answered as ArduPilot's MissionItemProtocol does.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

mod check;
pub(crate) mod file;
mod points;
mod px4;
mod upload;

use crate::autopilot::mission::items::{self, WAYPOINT};
use crate::autopilot::plan::{PlanKind, Plans};
use crate::autopilot::rally;
use crate::error::{PlanError, Severity};
use crate::mode::Mode;
use crate::protocol::parameter;
use crate::settings::SettingsError;
use crate::telemetry::announce::Component;
use crate::telemetry::streams::Stream;
use check::{check_items, mission_type, refusal, result_of, total};
use mavlink_bridge::dialect::{MISSION_COUNT_DATA, MavMissionResult, MavMissionType, Message};
use mavlink_bridge::{ItemKind, LatLonE7, PlanItem, PlanItemMessage, PlanMessage, Target};
use px4::Transfers;
use std::time::Duration;
use upload::Uploads;

/// The uploads that are under way, and what has changed of the plans.
#[derive(Debug, Default)]
pub(crate) struct MissionService {
    uploads: Uploads,
    /// The same of a PX4, which has its own rules of transfers.
    transfers: Transfers,
    /// Whether each plan has been changed since somebody asked.
    changed: [bool; PlanKind::ALL.len()],
    /// How many items each plan was told to have.
    totals: [f32; PlanKind::ALL.len()],
}

impl MissionService {
    /// Takes a plan whose items have been checked one by one, or says why it makes no sense as a whole.
    pub fn replace_plan(
        &mut self,
        component: &mut Component,
        kind: PlanKind,
        items: Vec<PlanItem>,
        anew: bool,
    ) -> Result<(), PlanError> {
        component.autopilot.replace_plan(kind, items, anew)?;
        self.changed[kind as usize] = true;
        Ok(())
    }

    /// Host time at which an upload wants attention.
    pub fn next_due(&self) -> Option<Duration> {
        [self.uploads.due(), self.transfers.due()].into_iter().flatten().min()
    }

    /// Nobody uploads anything.
    pub fn forget_uploads(&mut self) {
        self.uploads = Uploads::default();
        self.transfers = Transfers::default();
    }

    /// The plans are others: nobody uploads anything, and everything is to be kept anew.
    pub fn begin_anew(&mut self) {
        self.forget_uploads();
        self.changed = [true; PlanKind::ALL.len()];
    }

    /// Takes the plans that were on board before.
    pub fn restore(&mut self, component: &mut Component, mut plans: Plans) -> Result<(), SettingsError> {
        for kind in PlanKind::ALL {
            let items = plans.take(kind);
            check_items(component.autopilot.rules(), kind, &items)
                .map_err(|(_, reason)| SettingsError::Plan(reason))?;
            let refused = |reason: PlanError| SettingsError::Plan(format!("{} refused: {reason}", kind.name()));
            // None kept is none cleared: home stays.
            if !items.is_empty() {
                self.replace_plan(component, kind, items, true).map_err(refused)?;
            }
        }
        self.changed = Default::default();
        self.totals = PlanKind::ALL.map(|kind| component.autopilot.parameter_value(total(kind)));
        Ok(())
    }

    /// The plans that have been changed since this was last asked, to be kept.
    pub fn take_changed(&mut self) -> Vec<PlanKind> {
        let changed = std::mem::take(&mut self.changed);
        PlanKind::ALL.into_iter().filter(|kind| changed[*kind as usize]).collect()
    }

    pub fn serve(
        &mut self,
        component: &mut Component,
        link: usize,
        sender: Target,
        mission_type: u8,
        message: PlanMessage,
    ) {
        if component.autopilot.rules().transfers_plans_as_px4 {
            return self.serve_as_px4(component, link, sender, mission_type, message);
        }
        let Some(kind) = check::kind_of(mission_type) else {
            self.serve_other_plans(component, link, sender, mission_type, message);
            return;
        };
        match message {
            PlanMessage::RequestList => self.send_count(component, link, sender, kind),
            PlanMessage::Request(seq, item_kind) => self.send_item(component, link, sender, kind, seq, item_kind),
            PlanMessage::Item { item, current: current @ (2 | 3), .. } if kind == PlanKind::Mission => {
                self.fly_to_item(component, link, sender, &item, current == 2);
            }
            PlanMessage::SetCurrent(seq) => {
                // It has no acknowledgement of its own. Whoever hears at once of another item than he asked for asks
                // again.
                match component.autopilot.set_current_item(seq, false) {
                    Ok(()) => {
                        component.send_stream(link, Stream::MissionCurrent);
                        component.autopilot.tell_chosen_item();
                    }
                    Err(error) => component.autopilot.say(Severity::Warning, &error.reason.unwrap_or_default()),
                }
            }
            PlanMessage::Count(count) => self.begin_upload(component, link, sender, kind, count),
            PlanMessage::WritePartial(first, last) => {
                self.begin_partial_upload(component, link, sender, kind, first, last)
            }
            PlanMessage::Item { seq, item, .. } => self.take_item(component, link, sender, kind, seq, item),
            PlanMessage::ClearAll => self.clear_plan(component, link, sender, kind),
            PlanMessage::Ack(result) => self.hear_plan_ack(component, link, sender, kind, result),
        }
    }

    /// All plans at once (255) can only be cleared, and of any other type there are none.
    fn serve_other_plans(
        &mut self,
        component: &mut Component,
        link: usize,
        to: Target,
        mission_type: u8,
        message: PlanMessage,
    ) {
        const ALL: u8 = MavMissionType::MAV_MISSION_TYPE_ALL as u8;
        let result = match message {
            PlanMessage::ClearAll if mission_type == ALL => {
                let against =
                    PlanKind::ALL.into_iter().find_map(|kind| self.against_clearing(component, link, to, kind));
                if against.is_none() {
                    PlanKind::ALL.into_iter().for_each(|kind| self.empty_plan(component, kind));
                }
                against.unwrap_or(MavMissionResult::MAV_MISSION_ACCEPTED)
            }
            // An acknowledgement is not answered.
            PlanMessage::Ack(_) => return,
            _ => MavMissionResult::MAV_MISSION_UNSUPPORTED,
        };
        if result != MavMissionResult::MAV_MISSION_ACCEPTED {
            component.autopilot.say(Severity::Warning, &refusal("Plan", result));
        }
        self.send_plan_ack(component, link, to, mission_type, result);
        self.tell_totals(component);
    }

    /// An item outside a mission, as clients steered before there were commands for it: fly there now, or only climb.
    fn fly_to_item(&mut self, component: &mut Component, link: usize, sender: Target, item: &PlanItem, there: bool) {
        let kind = PlanKind::Mission;
        if let Err(error) = items::check(item, 0..0) {
            self.refuse_plan(component, link, sender, kind, result_of(error));
        } else if component.autopilot.mode() != Mode::Guided {
            component.autopilot.say(Severity::Warning, &format!("Guided item: mode is {}", component.autopilot.mode()));
            self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ERROR);
        } else {
            if there {
                let place = component.autopilot.reference().place_of(item, component.autopilot.flight.here());
                component.autopilot.flight.reposition(place, component.autopilot.flight.tuning().loiter_radius_m);
                component.autopilot.stop_setpoint_timeout();
            }
            let altitude_m = component.autopilot.reference().altitude_of(item);
            component.autopilot.flight.set_altitude(altitude_m, f64::INFINITY);
            self.acknowledge_plan(component, link, sender, kind, MavMissionResult::MAV_MISSION_ACCEPTED);
        }
    }

    fn send_count(&mut self, component: &mut Component, link: usize, to: Target, kind: PlanKind) {
        let Target { system_id: target_system, component_id: target_component } = to;
        let count = u16::try_from(component.autopilot.plan(kind).len()).unwrap_or(u16::MAX);
        let mission_type = check::mission_type(kind);
        let count =
            MISSION_COUNT_DATA { count, target_system, target_component, mission_type, ..MISSION_COUNT_DATA::DEFAULT };
        component.links().send(link, &Message::MISSION_COUNT(count));
    }

    fn send_item(
        &mut self,
        component: &mut Component,
        link: usize,
        to: Target,
        kind: PlanKind,
        seq: u16,
        item_kind: ItemKind,
    ) {
        let is_home = kind == PlanKind::Mission && seq < component.autopilot.mission().first();
        let item = if is_home {
            Some(self.home_item(component))
        } else {
            component.autopilot.plan(kind).get(usize::from(seq)).copied()
        };
        // A rally point that nobody has written is none.
        let is_there = |item: &PlanItem| kind != PlanKind::Rally || rally::is_there(item);
        let Some(item) = item.filter(is_there) else {
            // ArduPilot tells how many there are.
            if item_kind == ItemKind::Int {
                self.send_count(component, link, to, kind);
            }
            self.refuse_plan(component, link, to, kind, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
            return;
        };
        let is_current = kind == PlanKind::Mission && !is_home && seq == component.autopilot.session.progress.told();
        let mission_type = check::mission_type(kind) as u8;
        component
            .links()
            .send_plan_item(link, &PlanItemMessage { mission_type, seq, item: &item, is_current, kind: item_kind, to });
    }

    /// Item 0 of a mission is home, whatever was uploaded for it.
    fn home_item(&self, component: &Component) -> PlanItem {
        let home = component.autopilot.flight.home();
        let home = component.autopilot.frame().to_geodetic(home.x_m, home.y_m, home.altitude_m);
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
    fn refuse_plan(
        &mut self,
        component: &mut Component,
        link: usize,
        to: Target,
        kind: PlanKind,
        result: MavMissionResult,
    ) {
        component.autopilot.say(Severity::Warning, &refusal(kind.name(), result));
        self.acknowledge_plan(component, link, to, kind, result);
    }

    fn acknowledge_plan(
        &mut self,
        component: &mut Component,
        link: usize,
        to: Target,
        kind: PlanKind,
        result: MavMissionResult,
    ) {
        self.send_plan_ack(component, link, to, mission_type(kind) as u8, result);
        self.tell_totals(component);
    }

    /// Everybody is told how many items there are, where that has changed.
    fn tell_totals(&mut self, component: &mut Component) {
        let now = PlanKind::ALL.map(|kind| component.autopilot.parameter_value(total(kind)));
        let before = std::mem::replace(&mut self.totals, now);
        for (kind, _) in PlanKind::ALL.into_iter().zip(before.into_iter().zip(now)).filter(|(_, (was, is))| was != is) {
            parameter::tell(component, total(kind));
        }
    }

    fn send_plan_ack(
        &mut self,
        component: &mut Component,
        link: usize,
        to: Target,
        mission_type: u8,
        result: MavMissionResult,
    ) {
        component.links().acknowledge_plan(link, mission_type, result, 0, to);
    }
}
