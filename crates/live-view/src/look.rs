//! One look at the feed after another: frames become bytes, alarms and least distances.

use crate::alarms::{Alarms, Flags};
use crate::distances::{Near, near};
use crate::scene::{Event, Frame, Least, Scene};
use crate::wire::{self, Status};
use serde::{Serialize, Serializer};
use std::sync::Arc;
use std::time::Instant;

/// Who the vehicles are, and the names of modes, for the numbers in frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Roster {
    /// Counts changes.
    pub version: u32,
    /// The vehicles' numbers.
    pub numbers: Vec<u32>,
    /// Their system ids.
    pub systems: Vec<u8>,
    /// What they are.
    #[serde(serialize_with = "names")]
    pub kinds: Vec<Arc<str>>,
    /// Names of modes.
    #[serde(serialize_with = "names")]
    pub modes: Vec<Arc<str>>,
}

fn names<S: Serializer>(names: &[Arc<str>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(names.iter().map(AsRef::<str>::as_ref))
}

/// Number of a mode beyond those that a roster can name.
const MODES_MAX: usize = 250;

/// What is kept from one look to the next.
#[derive(Clone, Debug, Default)]
pub struct Looker {
    alarms: Alarms,
    roster: Roster,
    number: u32,
    near: Vec<Near>,
    flags: Vec<Flags>,
    modes: Vec<u8>,
}

/// What a look gives.
#[derive(Clone, Debug)]
pub struct Look {
    /// The frame in bytes.
    pub bytes: Vec<u8>,
    /// What has happened.
    pub events: Vec<Event>,
    /// Whether the roster changed.
    pub has_new_roster: bool,
}

/// The least distances so far, and on what they rest.
#[derive(Clone, Debug, Serialize)]
pub struct LeastSoFar<'a> {
    /// Between two vehicles.
    pub separation: Option<&'a Least>,
    /// To a circle.
    pub clearance: Option<&'a Least>,
    /// Whether the flight itself measures them, at every step; else they are of the frames that were looked at.
    pub is_of_flight: bool,
}

impl Looker {
    /// Looks at a frame; with its status, which costs more, or without.
    pub fn look(&mut self, frame: &Frame, scene: &Scene, now: Instant, with_status: bool) -> Look {
        let has_new_roster = self.enrol(frame);
        let mut events = Vec::new();
        let with_status = with_status || has_new_roster || self.flags.len() != frame.vehicles.len();
        if with_status {
            self.near = near(&frame.vehicles, &scene.circles);
            (self.flags, events) = self.alarms.look(frame, &self.near, scene, now);
        }
        let status = Status { near: &self.near, flags: &self.flags, modes: &self.modes, now };
        self.number = self.number.wrapping_add(1);
        let bytes = wire::encode(frame, with_status.then_some(status), self.number, self.roster.version);
        Look { bytes, events, has_new_roster }
    }

    /// Who the vehicles are.
    pub fn roster(&self) -> &Roster {
        &self.roster
    }

    /// The least distances so far: the flight's own, where it measures them.
    pub fn least<'a>(&'a self, frame: &'a Frame) -> LeastSoFar<'a> {
        let (separation, clearance) = self.alarms.least();
        let is_of_flight = frame.least_separation.is_some() || frame.least_clearance.is_some();
        if is_of_flight {
            let (separation, clearance) = (frame.least_separation.as_ref(), frame.least_clearance.as_ref());
            return LeastSoFar { separation, clearance, is_of_flight };
        }
        LeastSoFar { separation, clearance, is_of_flight }
    }

    /// Numbers the vehicles' modes, and says whether the roster changed.
    fn enrol(&mut self, frame: &Frame) -> bool {
        let roster = &mut self.roster;
        let same = |index: usize, number: u32, system: u8, kind: &Arc<str>| {
            roster.numbers.get(index) == Some(&number)
                && roster.systems.get(index) == Some(&system)
                && roster.kinds.get(index).is_some_and(|known| Arc::ptr_eq(known, kind) || known == kind)
        };
        let vehicles = &frame.vehicles;
        let is_same = vehicles.len() == roster.numbers.len()
            && vehicles.iter().enumerate().all(|(index, one)| same(index, one.number, one.system_id, &one.kind));
        let mut has_changed = !is_same;
        if !is_same {
            roster.numbers = vehicles.iter().map(|one| one.number).collect();
            roster.systems = vehicles.iter().map(|one| one.system_id).collect();
            roster.kinds = vehicles.iter().map(|one| one.kind.clone()).collect();
        }
        self.modes.clear();
        for vehicle in vehicles {
            // Most vehicles share few modes, and those few names.
            let known = roster.modes.iter().position(|mode| Arc::ptr_eq(mode, &vehicle.mode) || *mode == vehicle.mode);
            let mode = known.unwrap_or_else(|| {
                if roster.modes.len() < MODES_MAX {
                    roster.modes.push(vehicle.mode.clone());
                    has_changed = true;
                    return roster.modes.len() - 1;
                }
                usize::from(u8::MAX)
            });
            self.modes.push(mode.min(usize::from(u8::MAX)) as u8);
        }
        if has_changed {
            roster.version += 1;
        }
        has_changed
    }
}
