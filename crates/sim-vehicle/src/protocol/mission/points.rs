//! Fences and rally points by ArduPilot's older protocols, point by point: FENCE_POINT and RALLY_POINT.

use super::MissionService;
use super::check::total;
use crate::autopilot::plan::PlanKind;
use crate::autopilot::rally::points::RallyPointError;
use crate::error::Severity;
use crate::telemetry::announce::Component;
use mavlink_bridge::points::{fence_point, rally_point};
use mavlink_bridge::{FencePoint, PointRequest, RallyPoint, Target};

impl MissionService {
    pub fn serve_point(&mut self, component: &mut Component, link: usize, sender: Target, request: &PointRequest) {
        if !component.autopilot.rules().has_ardupilot_commands {
            return;
        }
        match request {
            PointRequest::SetFence(point) => self.set_fence_point(component, point),
            PointRequest::FetchFence(index) => send_fence_point(component, link, sender, *index),
            PointRequest::SetRally(point) => self.set_rally_point(component, point),
            PointRequest::FetchRally(index) => send_rally_point(component, link, sender, *index),
        }
    }

    /// Whoever sets FENCE_TOTAL or RALLY_TOTAL has changed that plan.
    pub fn note_totals(&mut self, component: &Component) {
        for kind in [PlanKind::Fence, PlanKind::Rally] {
            let now = component.autopilot.parameter_value(total(kind));
            if std::mem::replace(&mut self.totals[kind as usize], now) != now {
                self.changed[kind as usize] = true;
            }
        }
    }

    fn set_fence_point(&mut self, component: &mut Component, point: &FencePoint) {
        let (fence, _, frame) = component.autopilot.points();
        match fence.set_point(point, frame) {
            Ok(corners) => {
                self.changed[PlanKind::Fence as usize] = true;
                if let Some(count) = corners {
                    component.say(Severity::Warning, &format!("AC_Fence: invalid polygon vertex count {count}"));
                }
            }
            Err(refused) => component.say(Severity::Warning, &refused.to_string()),
        }
    }

    fn set_rally_point(&mut self, component: &mut Component, point: &RallyPoint) {
        let (_, rally, _) = component.autopilot.points();
        match rally.set_point(point) {
            Ok(()) => self.changed[PlanKind::Rally as usize] = true,
            Err(RallyPointError::Position) => {}
            Err(refused) => component.say(Severity::Warning, &refused.to_string()),
        }
    }
}

fn send_fence_point(component: &mut Component, link: usize, to: Target, index: u8) {
    let (fence, ..) = component.autopilot.points();
    let point = fence.point(index);
    let is_missing = index == 0 && !fence.has_return_point();
    match point {
        Ok(point) => {
            if is_missing {
                component.say(Severity::Warning, "Failed to get return point");
            }
            component.links().send_ardupilot(link, &fence_point(&point, to));
        }
        Err(refused) => component.say(Severity::Warning, &refused.to_string()),
    }
}

fn send_rally_point(component: &mut Component, link: usize, to: Target, index: u8) {
    let (_, rally, _) = component.autopilot.points();
    match rally.point(index) {
        Ok(point) => component.links().send_ardupilot(link, &rally_point(&point, to)),
        Err(refused) => component.say(Severity::Warning, &refused.to_string()),
    }
}
