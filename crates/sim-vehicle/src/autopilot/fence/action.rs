//! What a vehicle does about its fence: looks at it after each step, announces a breach, acts, and comes back.

use super::items::{area, as_kept};
use super::{
    ALL, Floor, Kinds, MANUAL_RECOVERY, MAX_ALTITUDE, MIN_ALTITUDE, OPTION_LOCK_MODE, POLYGON, Place, Recovery,
    configured, has_option, inclusions_are_one, names,
};
use crate::firmware::{Personality, px4_fence_area};
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::protocol::command::{Refusal, check_finite};
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use flight_model::State;
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::MavSeverity;

/// FENCE_AUTOENABLE: when the fence is enabled by itself.
const AFTER_TAKEOFF: f32 = 1.0;
const AFTER_TAKEOFF_BUT_THE_FLOOR: f32 = 2.0;
const WHEN_ARMED: f32 = 3.0;

impl Vehicle {
    /// Another fence, or why it makes no sense: then the old one stays.
    pub(crate) fn replace_fence(&mut self, items: Vec<PlanItem>) -> Result<(), String> {
        if self.settings.personality == Personality::Px4 {
            self.px4_take_fence(&items);
        } else {
            self.fence.area = area(&items, &self.settings.frame)?;
        }
        self.fence.items = items.iter().map(as_kept).collect();
        Ok(())
    }

    /// Of a PX4's fence that part counts which home, and a vehicle in flight, is inside of.
    fn px4_take_fence(&mut self, items: &[PlanItem]) {
        let acts = self.parameters.get(Parameter::FenceAction) != 0.0 && self.flight.is_flying();
        let state = self.flight.estimate();
        let here = acts.then_some((state.x_m, state.y_m));
        let (area, said) = px4_fence_area(items, &self.settings.frame, self.flight.home().at(), here);
        self.fence.area = area;
        for text in said {
            self.say(MavSeverity::MAV_SEVERITY_CRITICAL, text);
        }
    }

    /// A parameter has been set that says which fences are enabled.
    pub(crate) fn reconfigure_fence(&mut self, changed: Parameter) {
        let by_parameter = self.parameters.get(Parameter::FenceEnable) != 0.0;
        let was_enabled = self.fence.enabled != 0;
        // A kind that FENCE_TYPE adds to an enabled fence counts at once, however the fence was enabled.
        let is_enabled = if changed == Parameter::FenceType { was_enabled || by_parameter } else { by_parameter };
        self.fence.enabled = if is_enabled { configured(&self.parameters) & !MIN_ALTITUDE } else { 0 };
        self.fence.breached &= self.fence.enabled;
    }

    /// DO_FENCE_ENABLE. Param 1: 0 off, 1 on, 2 only the least altitude off. Param 2: which kinds, 0 for all.
    pub(crate) fn enable_fence(&mut self, [action, kinds]: [f32; 2]) -> Result<(), Refusal> {
        check_finite("Fence", &[action, kinds])?;
        let kinds = match kinds as Kinds {
            0 => ALL,
            some => some,
        };
        let (on, kinds) = match action as i64 {
            0 => (false, kinds),
            1 if self.fence.present(&self.parameters) & kinds == 0 => {
                return Err(Refusal::failed("Fence: there is none to enable"));
            }
            1 => (true, kinds),
            2 => (false, MIN_ALTITUDE),
            _ => return Err(Refusal::failed("Fence: param 1 must be 0, 1 or 2")),
        };
        if kinds & configured(&self.parameters) & MIN_ALTITUDE != 0 {
            self.fence.floor = if on { Floor::On } else { Floor::Off };
        }
        self.fence.enable(on, kinds, &self.parameters);
        Ok(())
    }

    /// Why the fence does not let it arm, if it does not.
    pub(crate) fn fence_forbids_arming(&self) -> Option<String> {
        if self.settings.personality == Personality::Px4 {
            return None;
        }
        let get = |parameter: Parameter| self.parameters.get(parameter);
        let (fence, state) = (&self.fence, self.flight.estimate());
        let configured = configured(&self.parameters);
        if get(Parameter::FenceEnable) != 0.0 && fence.present(&self.parameters) == 0 {
            return Some("Fences enabled, but none selected".into());
        }
        let by_itself = get(Parameter::FenceAutoEnable);
        if (fence.enabled == 0 && by_itself == 0.0) || configured == 0 {
            return None;
        }
        let mut breached = fence.breached;
        let is_forbidden = || fence.area.forbids((state.x_m, state.y_m), inclusions_are_one(&self.parameters));
        if by_itself == WHEN_ARMED && configured & POLYGON != 0 && is_forbidden() {
            breached |= POLYGON;
        }
        let margin_m = get(Parameter::FenceMargin);
        let height_m = get(Parameter::FenceAltitudeMax) - get(Parameter::FenceAltitudeMin);
        if get(Parameter::FenceRadius) < margin_m {
            Some("Circle FENCE_MARGIN is greater than FENCE_RADIUS".into())
        } else if breached != 0 {
            Some(format!("Vehicle breaching {}", names(breached)))
        } else if height_m < 0.0 {
            Some("FENCE_ALT_MAX < FENCE_ALT_MIN".into())
        } else if height_m <= 2.0 * margin_m {
            Some("FENCE_MARGIN too big".into())
        } else {
            None
        }
    }

    /// Whether a place, its altitude in m above the origin, is outside a fence that is enabled.
    pub(crate) fn is_outside_fence(&self, (x_m, y_m): Place, altitude_m: f64) -> bool {
        let home = self.flight.home();
        let state = State { x_m, y_m, altitude_m: altitude_m - home.altitude_m, ..*self.flight.state() };
        self.fence.outside(&state, home.at(), &self.parameters) != 0
    }

    /// It has been armed or disarmed: a fence may be enabled only while it is armed.
    pub(crate) fn arming_changes_fence(&mut self) {
        if self.parameters.get(Parameter::FenceAutoEnable) != WHEN_ARMED {
            return;
        }
        let is_armed = self.flight.is_armed();
        self.fence.floor = Floor::ByItself;
        let kinds = if is_armed { ALL & !MIN_ALTITUDE } else { ALL };
        let changed = self.fence.enable(is_armed, kinds, &self.parameters);
        self.tell_fence(if is_armed { "auto-enabled" } else { "auto-disabled" }, changed);
    }

    /// A take-off is over.
    pub(crate) fn takeoff_changes_fence(&mut self) {
        if matches!(self.parameters.get(Parameter::FenceAutoEnable), AFTER_TAKEOFF | AFTER_TAKEOFF_BUT_THE_FLOOR) {
            self.fence.floor = Floor::ByItself;
            let changed = self.fence.enable(true, ALL, &self.parameters);
            self.tell_fence("auto-enabled", changed);
        }
    }

    /// Why the fence does not allow another mode, if it does not: while the vehicle is on its way back.
    pub(crate) fn fence_forbids(&self, mode: Mode) -> Option<String> {
        let is_locked = self.flight.is_armed()
            && self.fence.enabled != 0
            && self.fence.breached != 0
            && mode != self.mode()
            && self.is_in_fence_recovery()
            && has_option(&self.parameters, OPTION_LOCK_MODE);
        is_locked.then(|| format!("Mode change to {mode} denied, in fence recovery"))
    }

    /// The mode has been changed: a pilot outside the fence has some time to come back.
    pub(crate) fn mode_changes_fence(&mut self) {
        self.fence.recovery = None;
        if self.fence.breached != 0 {
            self.fence.manual_until = self.time + MANUAL_RECOVERY;
            self.say(MavSeverity::MAV_SEVERITY_INFO, "Manual recovery started");
        }
    }

    /// Looks after each integration step where the vehicle is.
    pub(crate) fn check_fence(&mut self) {
        let by_itself = self.parameters.get(Parameter::FenceAutoEnable);
        let configured = configured(&self.parameters);
        let was_up = std::mem::replace(&mut self.fence.is_up, self.flight.has_taken_off());
        if self.fence.is_up && !was_up {
            self.takeoff_changes_fence();
        }
        if self.fence.enabled == 0 && by_itself == 0.0 && configured & MIN_ALTITUDE == 0 {
            self.leave_recovery();
            return;
        }
        let is_armed = self.flight.is_armed();
        let is_down = !is_armed || self.flight.is_landing();
        if is_down {
            self.rest_fence(by_itself);
        }
        let before = self.fence.breached;
        let home = self.flight.home();
        let state = self.flight.estimate();
        let state = State { altitude_m: state.altitude_m - home.altitude_m, ..state };
        let mut fresh = self.fence.look(&state, home.at(), &self.parameters);
        if !is_down {
            self.raise_floor(by_itself, state.altitude_m);
        }
        if fresh != 0 {
            self.fence.breaches = self.fence.breaches.saturating_add(1);
            if before == 0 {
                self.fence.breached_at = self.time;
                self.send_stream_to_all(Stream::FenceStatus);
            }
        }
        if self.time < self.fence.manual_until {
            fresh = 0;
        }
        if self.fence.enabled == 0 {
            self.leave_recovery();
        } else if !is_armed {
            // It is told when it is to be armed.
        } else if fresh != 0 {
            self.tell_fence("breached", fresh);
            if !self.is_in_fence_recovery() {
                self.recover();
            }
        } else if before != 0 && self.fence.breached == 0 {
            self.say(MavSeverity::MAV_SEVERITY_NOTICE, "Fence breach cleared");
        }
    }

    /// FENCE_ACTION.
    fn recover(&mut self) {
        let before = self.mode();
        let is_px4 = self.settings.personality == Personality::Px4;
        let mode = match self.parameters.get(Parameter::FenceAction) as u8 {
            2 if is_px4 => Mode::Loiter,
            3 if is_px4 => Mode::Rtl,
            5 if is_px4 => Mode::Land,
            1 | 8 if !is_px4 => Mode::Rtl,
            6 | 7 if !is_px4 => Mode::Guided,
            // Only told: 0, and what has no meaning for a plane, or a PX4 has for a warning.
            _ => return,
        };
        self.counters.failsafes += 1;
        self.set_mode(mode);
        if mode == Mode::Guided {
            self.fly_to_return_point();
        } else {
            self.return_within_altitudes();
        }
        if before != mode {
            self.fence.recovery = Some(Recovery { mode, before });
        }
    }

    /// Who returns at the altitude of the breach would stay outside for ever: the way back is within the altitudes that
    /// count.
    fn return_within_altitudes(&mut self) {
        let (least_m, most_m) = self.altitudes_inside_m();
        let home_m = self.flight.home().altitude_m;
        let counts = |kind: Kinds| self.fence.enabled & kind != 0;
        let wanted_m = self.flight.aim().altitude_m;
        let mut altitude_m = wanted_m;
        if counts(MAX_ALTITUDE) {
            altitude_m = altitude_m.min(home_m + most_m);
        }
        if counts(MIN_ALTITUDE) {
            altitude_m = altitude_m.max(home_m + least_m);
        }
        if altitude_m != wanted_m {
            self.flight.set_altitude(altitude_m, f64::INFINITY);
        }
    }

    /// Circles the return point, or a rally point if FENCE_RET_RALLY says so.
    fn fly_to_return_point(&mut self) {
        let get = |parameter: Parameter| f64::from(self.parameters.get(parameter));
        let (least_m, most_m) = self.altitudes_inside_m();
        let home = self.flight.home();
        let above_home_m = |altitude_m: f64| home.altitude_m + altitude_m;
        let rtl_altitude_m = self.flight.tuning().rtl_altitude_m.map(above_home_m);
        let (at, altitude_m) = if get(Parameter::FenceReturnToRally) != 0.0 {
            let rally = self.best_rally();
            (rally.map_or(home.at(), |rally| rally.at), rally.map(|rally| rally.altitude_m).or(rtl_altitude_m))
        } else {
            let altitude_m = match get(Parameter::FenceReturnAltitude) {
                altitude_m if altitude_m > 0.0 => Some(above_home_m(altitude_m)),
                _ if least_m >= most_m => rtl_altitude_m,
                _ => Some(above_home_m(0.5 * (least_m + most_m))),
            };
            (self.fence.area.way_back().unwrap_or(home.at()), altitude_m)
        };
        self.flight.reposition(at, self.flight.tuning().loiter_radius_m);
        if let Some(altitude_m) = altitude_m {
            self.flight.set_altitude(altitude_m, f64::INFINITY);
        }
        self.stop_setpoint_timeout();
    }

    /// The least and the greatest altitude that keep the margin, m above home.
    fn altitudes_inside_m(&self) -> (f64, f64) {
        let get = |parameter: Parameter| f64::from(self.parameters.get(parameter));
        let margin_m = get(Parameter::FenceMargin);
        (get(Parameter::FenceAltitudeMin) + margin_m, get(Parameter::FenceAltitudeMax) - margin_m)
    }

    /// Whether the present mode is the one that a breach has brought about.
    fn is_in_fence_recovery(&self) -> bool {
        self.fence.recovery.is_some_and(|recovery| recovery.mode == self.mode())
    }

    /// Somebody has switched the fence off: who was on the way to the return point goes on as before.
    fn leave_recovery(&mut self) {
        self.fence.breached = 0;
        let is_recovering = self.is_in_fence_recovery();
        let Some(recovery) = self.fence.recovery.take().filter(|_| is_recovering) else { return };
        if recovery.mode == Mode::Guided {
            self.set_mode(recovery.before);
        }
    }

    /// On the ground and on the way down to it the least altitude does not count, and with FENCE_AUTOENABLE 1 nothing does.
    fn rest_fence(&mut self, by_itself: f32) {
        let mut kinds = if by_itself == AFTER_TAKEOFF { ALL } else { MIN_ALTITUDE };
        if self.fence.floor == Floor::On {
            kinds &= !MIN_ALTITUDE;
        }
        let changed = self.fence.enable(false, kinds, &self.parameters);
        self.tell_fence("auto-disabled", changed);
    }

    /// The least altitude counts from when the vehicle has been above it.
    fn raise_floor(&mut self, by_itself: f32, altitude_m: f64) {
        let may = self.parameters.get(Parameter::FenceEnable) != 0.0 || by_itself > AFTER_TAKEOFF;
        let is_off = self.fence.enabled & MIN_ALTITUDE == 0 && self.fence.floor != Floor::Off;
        let least_m = self.parameters.get(Parameter::FenceAltitudeMin) + self.parameters.get(Parameter::FenceMargin);
        let is_asked_for = configured(&self.parameters) & MIN_ALTITUDE != 0;
        if may && is_off && is_asked_for && altitude_m >= f64::from(least_m) {
            self.fence.enable(true, MIN_ALTITUDE, &self.parameters);
            self.say(MavSeverity::MAV_SEVERITY_NOTICE, "Min Alt fence enabled (auto enable)");
        }
    }

    fn tell_fence(&mut self, what: &str, kinds: Kinds) {
        if kinds != 0 {
            self.say(MavSeverity::MAV_SEVERITY_NOTICE, &format!("{} {what}", names(kinds)));
        }
    }
}
