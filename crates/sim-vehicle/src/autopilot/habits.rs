//! What a PX4 remembers for what it does with its modes by itself.

use crate::mode::Mode;
use nalgebra::Vector2;

/// What it remembers for that.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Habits {
    was_armed: bool,
    /// The altitude of a take-off that it was told of before it was armed, m above the origin.
    takeoff_altitude_m: Option<f64>,
    /// Where it circles after a take-off, (north, east) in m; none: where it is then.
    takeoff_place: Option<Vector2<f64>>,
    /// The mode that it is in again when a landing has disarmed it: the last one that can be armed in.
    mode_to_restore: Option<Mode>,
    /// How far a return is, if it is returning.
    homing: Option<Homing>,
}

/// A return, to a place of an altitude in m above the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homing {
    pub altitude_m: f64,
    pub stage: Stage,
}

/// Where a return is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stage {
    OnTheWay,
    /// Over its destination, on the way down.
    Descending,
    Over,
}

impl Habits {
    /// Whether it was armed when this was last asked.
    pub fn was_armed(&mut self, is_armed: bool) -> bool {
        std::mem::replace(&mut self.was_armed, is_armed)
    }

    /// The mode that it is in again when a landing has disarmed it.
    pub fn mode_to_restore(&self) -> Mode {
        self.mode_to_restore.unwrap_or(Mode::Loiter)
    }

    pub fn take_takeoff_altitude_m(&mut self) -> Option<f64> {
        self.takeoff_altitude_m.take()
    }

    pub fn set_takeoff_altitude_m(&mut self, altitude_m: Option<f64>) {
        self.takeoff_altitude_m = altitude_m;
    }

    /// Where it circles after a take-off, (north, east) in m.
    pub fn takeoff_place(&self) -> Option<Vector2<f64>> {
        self.takeoff_place
    }

    pub fn set_takeoff_place(&mut self, place: Option<Vector2<f64>>) {
        self.takeoff_place = place;
    }

    /// How far a return is, if it is returning.
    pub fn homing(&self) -> Option<Homing> {
        self.homing
    }

    pub fn set_homing(&mut self, homing: Option<Homing>) {
        self.homing = homing;
    }

    pub fn restore_later(&mut self, mode: Mode) {
        self.mode_to_restore = Some(mode);
    }
}

/// The modes in which it is not armed.
pub(crate) fn ends_a_flight(mode: Mode) -> bool {
    matches!(mode, Mode::Rtl | Mode::Land)
}
