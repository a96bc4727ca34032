//! Fences: where a vehicle may be, when it has left that, and what follows. The rules are those of ArduPilot's AC_Fence
//! and of ArduPlane's fence.cpp.

mod action;
mod area;
mod items;

pub(crate) use area::{Area, Place, Shape};
pub(crate) use items::{check, check_whole};

use crate::mode::Mode;
use crate::parameters::{Parameter, Parameters};
use flight_model::State;
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::FenceBreach;
use std::time::Duration;

/// Most items of a fence: a polygon of as many corners as one can have. ArduPilot's larger boards keep 84.
pub(crate) const ITEMS_MAX: u16 = 255;

/// A set of kinds of fences, in the bits of FENCE_TYPE.
pub(crate) type Kinds = u8;
const MAX_ALTITUDE: Kinds = 1;
/// Round home.
const CIRCLE: Kinds = 2;
/// What is uploaded: polygons and circles.
const POLYGON: Kinds = 4;
const MIN_ALTITUDE: Kinds = 8;
const ALL: Kinds = 15;

/// A vehicle that goes on outwards breaches anew so much farther out, m.
const BACKUP_HEIGHT_M: f64 = 20.0;
const BACKUP_RADIUS_M: f64 = 100.0;
/// Time that a change of the mode gives a pilot to come back by himself: no new breach is acted upon.
const MANUAL_RECOVERY: Duration = Duration::from_secs(10);

/// The fence of one vehicle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fence {
    items: Vec<PlanItem>,
    area: Area,
    enabled: Kinds,
    floor: Floor,
    breached: Kinds,
    backup: Backup,
    /// Breaches so far, and the vehicle time of the last one from inside.
    breaches: u16,
    breached_at: Duration,
    recovery: Option<Recovery>,
    manual_until: Duration,
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

impl FenceReport {
    /// Of several breaches, the one that ArduPilot tells.
    pub fn breach_type(&self) -> FenceBreach {
        match self.breached {
            0 => FenceBreach::FENCE_BREACH_NONE,
            kinds if kinds & (CIRCLE | POLYGON) != 0 => FenceBreach::FENCE_BREACH_BOUNDARY,
            kinds if kinds & MAX_ALTITUDE != 0 => FenceBreach::FENCE_BREACH_MAXALT,
            _ => FenceBreach::FENCE_BREACH_MINALT,
        }
    }
}

/// The kinds of fences in words, as in "Max Alt and Polygon fences".
fn names(kinds: Kinds) -> String {
    const NAMES: [(Kinds, &str); 4] =
        [(MAX_ALTITUDE, "Max Alt"), (CIRCLE, "Circle"), (POLYGON, "Polygon"), (MIN_ALTITUDE, "Min Alt")];
    let named: Vec<&str> = NAMES.into_iter().filter(|(kind, _)| kinds & kind != 0).map(|(_, name)| name).collect();
    match named.as_slice() {
        [] => "fence".into(),
        [one] => format!("{one} fence"),
        [most @ .., last] => format!("{} and {last} fences", most.join(", ")),
    }
}

/// The kinds that FENCE_TYPE asks for.
fn configured(parameters: &Parameters) -> Kinds {
    parameters.get(Parameter::FenceType) as Kinds
}

impl Fence {
    pub fn items(&self) -> &[PlanItem] {
        &self.items
    }

    /// FENCE_TOTAL.
    pub fn total(&self) -> usize {
        items::total(&self.items)
    }

    pub fn report(&self, parameters: &Parameters) -> FenceReport {
        let is_present = self.present(parameters) != 0;
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

    /// The autopilot starts anew: it knows its fence and nothing of what has happened with it.
    pub fn forget_breaches(&mut self) {
        *self =
            Self { items: std::mem::take(&mut self.items), area: std::mem::take(&mut self.area), ..Self::default() };
    }

    /// The kinds that are asked for and that there are.
    fn present(&self, parameters: &Parameters) -> Kinds {
        let there = if self.area.is_open() { ALL & !POLYGON } else { ALL };
        configured(parameters) & there
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

    /// Looks where the vehicle is, with its altitude above home. Gives the kinds that it has breached just now, or anew.
    fn look(&mut self, state: &State, home: Place, parameters: &Parameters) -> Kinds {
        let outside = self.outside(state, home, parameters);
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
    fn outside(&self, state: &State, home: Place, parameters: &Parameters) -> Kinds {
        let watched = self.enabled & self.present(parameters);
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
        add(POLYGON, &|| self.area.forbids((state.x_m, state.y_m), inclusions_are_one(parameters)));
        outside
    }
}

fn distance_m(state: &State, (x_m, y_m): Place) -> f64 {
    let (north_m, east_m) = (state.x_m - x_m, state.y_m - y_m);
    (north_m * north_m + east_m * east_m).sqrt()
}

const OPTION_LOCK_MODE: u16 = 1;
const OPTION_UNION: u16 = 2;

fn has_option(parameters: &Parameters, option: u16) -> bool {
    parameters.get(Parameter::FenceOptions) as u16 & option != 0
}

fn inclusions_are_one(parameters: &Parameters) -> bool {
    has_option(parameters, OPTION_UNION)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;

    fn at(x_m: f64, altitude_m: f64) -> State {
        State { x_m, altitude_m, ..State::default() }
    }

    #[test]
    fn kinds_are_named_as_arduplane_names_them() {
        for (kinds, name) in [
            (POLYGON, "Polygon fence"),
            (MAX_ALTITUDE | POLYGON, "Max Alt and Polygon fences"),
            (ALL, "Max Alt, Circle, Polygon and Min Alt fences"),
        ] {
            assert_eq!(names(kinds), name);
        }
    }

    #[test]
    fn a_breach_is_fresh_once_and_again_farther_out() {
        let mut parameters = Parameters::new(&VehicleSettings::default());
        parameters.set(Parameter::FenceType, f32::from(CIRCLE | MAX_ALTITUDE)).unwrap();
        let mut fence = Fence { enabled: CIRCLE | MAX_ALTITUDE, ..Fence::default() };
        let mut seen = |x_m, altitude_m| {
            let fresh = fence.look(&at(x_m, altitude_m), (0.0, 0.0), &parameters);
            (fresh, fence.breached)
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
        let mut fence = Fence { enabled: ALL, ..Fence::default() };
        // FENCE_TYPE is POLYGON at first, and there is none.
        assert_eq!(fence.look(&at(1e6, 1e4), (0.0, 0.0), &parameters), 0);
        assert!(!fence.report(&parameters).is_present);
        parameters.set(Parameter::FenceType, f32::from(ALL)).unwrap();
        fence.enabled = MIN_ALTITUDE;
        assert_eq!(fence.look(&at(1e6, -20.0), (0.0, 0.0), &parameters), MIN_ALTITUDE);
        assert_eq!(fence.report(&parameters).breach_type(), FenceBreach::FENCE_BREACH_MINALT);
        assert_eq!(fence.enable(false, ALL, &parameters), MIN_ALTITUDE);
        assert_eq!(fence.breached, 0);
    }
}
