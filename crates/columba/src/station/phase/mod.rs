//! The phases of a flight, a file each, in their order: [connect], [preflight], [arm_takeoff], [gather_phase],
//! [handover], [fly], [end].

pub mod arm_takeoff;
pub mod connect;
pub mod end;
pub mod fly;
pub mod gather;
pub mod gather_phase;
pub mod handover;
pub mod limits;
pub mod preflight;

use super::Station;
use std::time::Duration;

/// Where the flight is.
#[allow(clippy::large_enum_variant)] // there is one
pub enum Phase {
    /// Waits for vehicles.
    Connect(connect::Connect),
    /// Waits until they are ready.
    Preflight(preflight::Preflight),
    /// Arms them, and lets them take off.
    TakeOff(arm_takeoff::TakeOff),
    /// Brings them to their starts.
    Gather(gather_phase::GatherPhase),
    /// Brings them into the mode in which they follow setpoints.
    HandOver(handover::HandOver),
    /// The flock flies.
    Fly(Box<fly::Fly>),
    /// Leaves every vehicle as it is to be left.
    End(Box<end::End>),
    /// All is said.
    Over(Option<Box<fly::Fly>>),
}

impl Phase {
    /// The last phase, after a flight or without one.
    pub(super) fn end(fly: Option<Box<fly::Fly>>, now: Duration) -> Self {
        Self::End(Box::new(end::End::new(fly, now)))
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Connect(_) => "connect",
            Self::Preflight(_) => "pre-flight",
            Self::TakeOff(_) => "take-off",
            Self::Gather(_) => "gather",
            Self::HandOver(_) => "hand over",
            Self::Fly(_) => "fly",
            Self::End(_) => "end",
            Self::Over(_) => "over",
        }
    }

    /// Whether nobody is commanded yet.
    pub(super) fn is_before_take_off(&self) -> bool {
        matches!(self, Self::Connect(_) | Self::Preflight(_))
    }

    /// Does what is due; gives the phase that follows, or itself.
    pub(super) fn step(self, station: &mut Station, now: Duration) -> Self {
        match self {
            Self::Connect(phase) => phase.step(station, now),
            Self::Preflight(phase) => phase.step(station, now),
            Self::TakeOff(phase) => phase.step(station, now),
            Self::Gather(phase) => phase.step(station, now),
            Self::HandOver(phase) => phase.step(station, now),
            Self::Fly(phase) => phase.step(station, now),
            Self::End(phase) => phase.step(station, now),
            Self::Over(fly) => Self::Over(fly),
        }
    }
}
