//! Watches the fence: looks at it after each step, tells a breach, proposes what to do about it, and comes back.

use super::Fence;
use super::area::Place;
use super::kinds::{ALL, CIRCLE, Kinds, MAX_ALTITUDE, MIN_ALTITUDE, POLYGON, configured, mode_is_locked, names};
use crate::autopilot::event::{Event, Events};
use crate::autopilot::failsafe::proposal::{Action, Cause, Proposal};
use crate::autopilot::situation::Situation;
use crate::autopilot::timer::{Timer, Timers};
use crate::error::{CommandError, Severity};
use crate::firmware::rules::Rules;
use crate::mode::Mode;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use flight_model::State;
use std::time::Duration;

/// A vehicle that goes on outwards breaches anew so much farther out, m.
const BACKUP_HEIGHT_M: f64 = 20.0;
const BACKUP_RADIUS_M: f64 = 100.0;
/// Time that a change of the mode gives a pilot to come back by himself: no new breach is acted upon.
const MANUAL_RECOVERY: Duration = Duration::from_secs(10);

/// FENCE_AUTOENABLE: when the fence is enabled by itself.
const AFTER_TAKEOFF: f32 = 1.0;
const AFTER_TAKEOFF_BUT_THE_FLOOR: f32 = 2.0;
const WHEN_ARMED: f32 = 3.0;

/// What has happened with the fence since the vehicle was switched on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FenceMonitor {
    enabled: Kinds,
    floor: Floor,
    breached: Kinds,
    backup: Backup,
    /// Breaches so far, and the vehicle time of the last one from inside.
    breaches: u16,
    breached_at: Duration,
    recovery: Option<Recovery>,
    /// Whether TAKEOFF has reached its altitude.
    is_up: bool,
}

/// Whether somebody has switched the least altitude; otherwise it counts once it has been reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Floor {
    #[default]
    ByItself,
    On,
    Off,
}

/// Where what is breached already is breached anew, m.
#[derive(Clone, Copy, Debug, Default)]
struct Backup {
    max_altitude_m: f64,
    min_altitude_m: f64,
    radius_m: f64,
}

/// The mode that a breach has brought about, and the one before.
#[derive(Clone, Copy, Debug)]
struct Recovery {
    mode: Mode,
    before: Mode,
}

/// What telemetry says of a fence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FenceReport {
    pub is_present: bool,
    pub is_enabled: bool,
    /// Whether a breach is acted upon.
    pub is_active: bool,
    pub breached: Kinds,
    pub breaches: u16,
    pub breached_at: Duration,
}

impl FenceMonitor {
    pub fn report(&self, fence: &Fence, parameters: &Parameters) -> FenceReport {
        let is_present = fence.present(parameters) != 0;
        let is_enabled = self.enabled != 0;
        FenceReport {
            is_present,
            is_enabled,
            is_active: is_present && is_enabled && parameters.get(Parameter::FenceAction) != 0.0,
            breached: self.breached,
            breaches: self.breaches,
            breached_at: self.breached_at,
        }
    }

    /// A parameter has been set that says which fences are enabled.
    pub fn reconfigure(&mut self, changed: Parameter, parameters: &Parameters) {
        let by_parameter = parameters.get(Parameter::FenceEnable) != 0.0;
        let was_enabled = self.enabled != 0;
        // A kind that FENCE_TYPE adds to an enabled fence counts at once, however the fence was enabled.
        let is_enabled = if changed == Parameter::FenceType { was_enabled || by_parameter } else { by_parameter };
        self.enabled = if is_enabled { configured(parameters) & !MIN_ALTITUDE } else { 0 };
        self.breached &= self.enabled;
    }

    /// DO_FENCE_ENABLE. The action: 0 off, 1 on, 2 only the least altitude off. Which kinds, 0 for all.
    pub fn switch(
        &mut self,
        action: i64,
        kinds: Kinds,
        fence: &Fence,
        parameters: &Parameters,
    ) -> Result<(), CommandError> {
        let kinds = if kinds == 0 { ALL } else { kinds };
        let (on, kinds) = match action {
            0 => (false, kinds),
            1 if fence.present(parameters) & kinds == 0 => {
                return Err(CommandError::failed("Fence: there is none to enable"));
            }
            1 => (true, kinds),
            2 => (false, MIN_ALTITUDE),
            _ => return Err(CommandError::failed("Fence: param 1 must be 0, 1 or 2")),
        };
        if kinds & configured(parameters) & MIN_ALTITUDE != 0 {
            self.floor = if on { Floor::On } else { Floor::Off };
        }
        self.enable(on, kinds, parameters);
        Ok(())
    }

    /// Why the fence does not let the vehicle arm, if it does not.
    pub fn forbids_arming(&self, now: &Situation<'_>) -> Option<String> {
        if !now.rules.fence_forbids_arming {
            return None;
        }
        let configured = configured(now.parameters);
        if now.get(Parameter::FenceEnable) != 0.0 && now.fence.present(now.parameters) == 0 {
            return Some("Fences enabled, but none selected".into());
        }
        let by_itself = now.get(Parameter::FenceAutoEnable);
        if (self.enabled == 0 && by_itself == 0.0) || configured == 0 {
            return None;
        }
        let mut breached = self.breached;
        let is_forbidden = || now.fence.forbids(&now.flight.estimate(), now.parameters);
        if by_itself == WHEN_ARMED && configured & POLYGON != 0 && is_forbidden() {
            breached |= POLYGON;
        }
        let margin_m = now.get(Parameter::FenceMargin);
        let height_m = now.get(Parameter::FenceAltitudeMax) - now.get(Parameter::FenceAltitudeMin);
        if now.get(Parameter::FenceRadius) < margin_m {
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
    pub fn is_outside(&self, now: &Situation<'_>, place: Place, altitude_m: f64) -> bool {
        let home = now.flight.home();
        let altitude_m = altitude_m - home.altitude_m;
        let state = State { x_m: place.x, y_m: place.y, altitude_m, ..*now.flight.state() };
        self.outside(&state, home.at(), now.fence, now.parameters) != 0
    }

    /// The vehicle has been armed or disarmed: a fence may be enabled only while it is armed.
    pub fn arming_changed(&mut self, is_armed: bool, parameters: &Parameters, events: &mut Events) {
        if parameters.get(Parameter::FenceAutoEnable) != WHEN_ARMED {
            return;
        }
        self.floor = Floor::ByItself;
        let kinds = if is_armed { ALL & !MIN_ALTITUDE } else { ALL };
        let changed = self.enable(is_armed, kinds, parameters);
        tell(if is_armed { "auto-enabled" } else { "auto-disabled" }, changed, events);
    }

    /// A take-off is over.
    pub fn taken_off(&mut self, parameters: &Parameters, events: &mut Events) {
        let by_itself = parameters.get(Parameter::FenceAutoEnable);
        if matches!(by_itself, AFTER_TAKEOFF | AFTER_TAKEOFF_BUT_THE_FLOOR) {
            self.floor = Floor::ByItself;
            let changed = self.enable(true, ALL, parameters);
            tell("auto-enabled", changed, events);
        }
    }

    /// Why the fence does not allow another mode, if it does not: while the vehicle is on its way back.
    pub fn forbids_mode(&self, mode: Mode, now: &Situation<'_>) -> Option<String> {
        let is_locked = now.is_armed()
            && self.enabled != 0
            && self.breached != 0
            && mode != now.mode()
            && self.is_in_recovery(now.mode())
            && mode_is_locked(now.parameters);
        is_locked.then(|| format!("Mode change to {mode} denied, in fence recovery"))
    }

    /// The mode has been changed: a pilot outside the fence has some time to come back.
    pub fn mode_changed(&mut self, rules: &Rules, time: Duration, timers: &mut Timers, events: &mut Events) {
        self.recovery = None;
        if self.breached != 0 && rules.words.breach.is_none() {
            timers.set(Timer::ManualRecovery, time + MANUAL_RECOVERY);
            events.say(Severity::Info, "Manual recovery started");
        }
    }

    /// A breach has brought about a mode, in the place of the one before.
    pub fn recover(&mut self, mode: Mode, before: Mode) {
        if before != mode {
            self.recovery = Some(Recovery { mode, before });
        }
    }

    /// An altitude, m above the origin, within the altitudes that count: who returned at the altitude of the breach
    /// would stay outside for ever.
    pub fn within_altitudes_m(&self, wanted_m: f64, now: &Situation<'_>) -> f64 {
        let (least_m, most_m) = altitudes_inside_m(now.parameters);
        let home_m = now.flight.home().altitude_m;
        let counts = |kind: Kinds| self.enabled & now.fence.present(now.parameters) & kind != 0;
        let mut altitude_m = wanted_m;
        if counts(MAX_ALTITUDE) {
            altitude_m = altitude_m.min(home_m + most_m);
        }
        if counts(MIN_ALTITUDE) {
            altitude_m = altitude_m.max(home_m + least_m);
        }
        altitude_m
    }

    /// Looks after each integration step where the vehicle is.
    pub fn check(&mut self, now: &Situation<'_>, timers: &Timers, events: &mut Events) -> Option<Proposal> {
        let by_itself = now.get(Parameter::FenceAutoEnable);
        let configured = configured(now.parameters);
        let was_up = std::mem::replace(&mut self.is_up, now.flight.has_taken_off());
        if self.is_up && !was_up {
            self.taken_off(now.parameters, events);
        }
        if self.enabled == 0 && by_itself == 0.0 && configured & MIN_ALTITUDE == 0 {
            return self.leave_recovery(now.mode());
        }
        let is_armed = now.is_armed();
        let is_down = !is_armed || now.flight.is_landing();
        if is_down {
            self.rest(by_itself, now.parameters, events);
        }
        let before = self.breached;
        let home = now.flight.home();
        let state = now.flight.estimate();
        let state = State { altitude_m: state.altitude_m - home.altitude_m, ..state };
        let mut fresh = self.look(&state, home.at(), now.fence, now.parameters);
        if !is_down {
            self.raise_floor(by_itself, state.altitude_m, now.parameters, events);
        }
        if fresh != 0 {
            self.breaches = self.breaches.saturating_add(1);
            if before == 0 {
                self.breached_at = now.time;
                events.push(Event::Breached);
            }
        }
        if timers.is_running(Timer::ManualRecovery, now.time) {
            fresh = 0;
        }
        if self.enabled == 0 {
            return self.leave_recovery(now.mode());
        }
        if !is_armed {
            // It is told when it is to be armed.
            return None;
        }
        if fresh != 0 {
            tell_breach(fresh, now, events);
            if !self.is_in_recovery(now.mode()) {
                let mode = (now.rules.fence_action)(now.get(Parameter::FenceAction) as u8);
                let proposal = mode.map(|mode| Proposal::new(Cause::Fence, Action::Mode(mode)));
                return match now.rules.words.failsafe {
                    Some(text) => proposal.map(|proposal| proposal.saying(Severity::Critical, text)),
                    None => proposal,
                };
            }
        } else if before != 0 && self.breached == 0 && now.rules.words.breach.is_none() {
            events.say(Severity::Notice, "Fence breach cleared");
        }
        None
    }

    /// Whether the present mode is the one that a breach has brought about.
    fn is_in_recovery(&self, mode: Mode) -> bool {
        self.recovery.is_some_and(|recovery| recovery.mode == mode)
    }

    /// Somebody has switched the fence off: who was on the way to the return point goes on as before.
    fn leave_recovery(&mut self, mode: Mode) -> Option<Proposal> {
        self.breached = 0;
        let is_recovering = self.is_in_recovery(mode);
        let recovery = self.recovery.take().filter(|_| is_recovering)?;
        let goes_on = recovery.mode == Mode::Guided;
        goes_on.then(|| Proposal::new(Cause::FenceOff, Action::Mode(recovery.before)))
    }

    /// On the ground and on the way down to it the least altitude does not count, and with FENCE_AUTOENABLE 1 nothing
    /// does.
    fn rest(&mut self, by_itself: f32, parameters: &Parameters, events: &mut Events) {
        let mut kinds = if by_itself == AFTER_TAKEOFF { ALL } else { MIN_ALTITUDE };
        if self.floor == Floor::On {
            kinds &= !MIN_ALTITUDE;
        }
        let changed = self.enable(false, kinds, parameters);
        tell("auto-disabled", changed, events);
    }

    /// The least altitude counts from when the vehicle has been above it.
    fn raise_floor(&mut self, by_itself: f32, altitude_m: f64, parameters: &Parameters, events: &mut Events) {
        let may = parameters.get(Parameter::FenceEnable) != 0.0 || by_itself > AFTER_TAKEOFF;
        let is_off = self.enabled & MIN_ALTITUDE == 0 && self.floor != Floor::Off;
        let least_m = parameters.get(Parameter::FenceAltitudeMin) + parameters.get(Parameter::FenceMargin);
        let is_asked_for = configured(parameters) & MIN_ALTITUDE != 0;
        if may && is_off && is_asked_for && altitude_m >= f64::from(least_m) {
            self.enable(true, MIN_ALTITUDE, parameters);
            events.say(Severity::Notice, "Min Alt fence enabled (auto enable)");
        }
    }

    /// The kinds that were switched on or off.
    fn enable(&mut self, on: bool, kinds: Kinds, parameters: &Parameters) -> Kinds {
        let before = self.enabled;
        let kinds = kinds & configured(parameters);
        self.enabled = if on { before | kinds } else { before & !kinds };
        let changed = before ^ self.enabled;
        if !on {
            self.breached &= !changed;
        }
        changed
    }

    /// Looks where the vehicle is, with its altitude above home. Gives the kinds that it has breached just now, or
    /// anew.
    fn look(&mut self, state: &State, home: Place, fence: &Fence, parameters: &Parameters) -> Kinds {
        let outside = self.outside(state, home, fence, parameters);
        let mut fresh = outside & !self.breached;
        let (altitude_m, distance_m) = (state.altitude_m, distance_m(state, home));
        let backup = &mut self.backup;
        let beyond = [
            (MAX_ALTITUDE, altitude_m >= backup.max_altitude_m),
            (MIN_ALTITUDE, altitude_m <= backup.min_altitude_m),
            (CIRCLE, distance_m >= backup.radius_m),
        ];
        fresh |= outside & beyond.into_iter().filter(|(_, is_beyond)| *is_beyond).map(|(kind, _)| kind).sum::<Kinds>();
        if fresh & MAX_ALTITUDE != 0 {
            backup.max_altitude_m = altitude_m + BACKUP_HEIGHT_M;
        }
        if fresh & MIN_ALTITUDE != 0 {
            backup.min_altitude_m = altitude_m - BACKUP_HEIGHT_M;
        }
        if fresh & CIRCLE != 0 {
            backup.radius_m = distance_m + BACKUP_RADIUS_M;
        }
        self.breached = outside;
        fresh
    }

    /// The enabled kinds that a place is outside of, its altitude above home.
    fn outside(&self, state: &State, home: Place, fence: &Fence, parameters: &Parameters) -> Kinds {
        let watched = self.enabled & fence.present(parameters);
        let get = |parameter: Parameter| f64::from(parameters.get(parameter));
        let mut outside = 0;
        let mut add = |kind: Kinds, is_outside: &dyn Fn() -> bool| {
            if watched & kind != 0 && is_outside() {
                outside |= kind;
            }
        };
        add(MAX_ALTITUDE, &|| state.altitude_m >= get(Parameter::FenceAltitudeMax));
        add(MIN_ALTITUDE, &|| state.altitude_m <= get(Parameter::FenceAltitudeMin));
        add(CIRCLE, &|| distance_m(state, home) >= get(Parameter::FenceRadius));
        add(POLYGON, &|| fence.forbids(state, parameters));
        outside
    }
}

/// The least and the greatest altitude that keep the margin, m above home.
pub(crate) fn altitudes_inside_m(parameters: &Parameters) -> (f64, f64) {
    let get = |parameter: Parameter| f64::from(parameters.get(parameter));
    let margin_m = get(Parameter::FenceMargin);
    (get(Parameter::FenceAltitudeMin) + margin_m, get(Parameter::FenceAltitudeMax) - margin_m)
}

fn distance_m(state: &State, place: Place) -> f64 {
    (state.position_m() - place).norm()
}

/// A PX4 says what is breached only if something is to follow, be it words.
fn tell_breach(kinds: Kinds, now: &Situation<'_>, events: &mut Events) {
    let Some(words) = &now.rules.words.breach else { return tell("breached", kinds, events) };
    let is_told = now.get(Parameter::FenceAction) != 0.0;
    for (_, text) in words.iter().filter(|(kind, _)| is_told && kinds & kind != 0) {
        events.say(Severity::Critical, *text);
    }
}

fn tell(what: &str, kinds: Kinds, events: &mut Events) {
    if kinds != 0 {
        events.say(Severity::Notice, format!("{} {what}", names(kinds)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;

    fn at(x_m: f64, altitude_m: f64) -> State {
        State { x_m, altitude_m, ..State::default() }
    }

    #[test]
    fn a_breach_is_fresh_once_and_again_farther_out() {
        let mut parameters = Parameters::new(&VehicleSettings::default());
        parameters.set(Parameter::FenceType, f32::from(CIRCLE | MAX_ALTITUDE)).unwrap();
        let mut monitor = FenceMonitor { enabled: CIRCLE | MAX_ALTITUDE, ..FenceMonitor::default() };
        let mut seen = |x_m, altitude_m| {
            let fresh = monitor.look(&at(x_m, altitude_m), Place::zeros(), &Fence::default(), &parameters);
            (fresh, monitor.breached)
        };
        assert_eq!(seen(299.0, 50.0), (0, 0));
        assert_eq!(seen(300.0, 50.0), (CIRCLE, CIRCLE));
        assert_eq!(seen(390.0, 50.0), (0, CIRCLE));
        assert_eq!(seen(401.0, 100.0), (CIRCLE | MAX_ALTITUDE, CIRCLE | MAX_ALTITUDE));
        assert_eq!(seen(0.0, 110.0), (0, MAX_ALTITUDE));
        assert_eq!(seen(0.0, 50.0), (0, 0));
        assert_eq!(seen(300.0, 50.0), (CIRCLE, CIRCLE));
    }

    #[test]
    fn what_is_not_there_or_not_enabled_is_not_breached() {
        let mut parameters = Parameters::new(&VehicleSettings::default());
        let (fence, mut monitor) = (Fence::default(), FenceMonitor { enabled: ALL, ..FenceMonitor::default() });
        // FENCE_TYPE is POLYGON at first, and there is none.
        assert_eq!(monitor.look(&at(1e6, 1e4), Place::zeros(), &fence, &parameters), 0);
        assert!(!monitor.report(&fence, &parameters).is_present);
        parameters.set(Parameter::FenceType, f32::from(ALL)).unwrap();
        monitor.enabled = MIN_ALTITUDE;
        assert_eq!(monitor.look(&at(1e6, -20.0), Place::zeros(), &fence, &parameters), MIN_ALTITUDE);
        assert_eq!(monitor.report(&fence, &parameters).breached, MIN_ALTITUDE);
        assert_eq!(monitor.enable(false, ALL, &parameters), MIN_ALTITUDE);
        assert_eq!(monitor.breached, 0);
    }
}
