//! Fences: where a vehicle may be, when it has left that, and what follows. The rules are those of ArduPilot's AC_Fence
//! and of ArduPlane's fence.cpp.

pub(crate) mod area;
pub(crate) mod items;
pub(crate) mod kinds;
pub(crate) mod monitor;
mod parts;
mod points;

use crate::error::PlanError;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use area::{Area, Place};
use flight_model::{LocalFrame, State};
use kinds::{ALL, CIRCLE, Kinds, MAX_ALTITUDE, POLYGON, configured, inclusions_are_one};
use mavlink_bridge::PlanItem;

/// The fence on board, as it was uploaded. What has happened with it is the [monitor](monitor::FenceMonitor)'s.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fence {
    items: Vec<PlanItem>,
    area: Area,
    /// FENCE_TOTAL.
    total: u8,
}

impl Fence {
    pub fn items(&self) -> &[PlanItem] {
        &self.items
    }

    /// FENCE_TOTAL: that of the last upload, or what a client has set it to.
    pub fn total(&self) -> u8 {
        self.total
    }

    /// Another fence, or why it makes no sense: then the old one stays.
    pub fn replace(&mut self, items: &[PlanItem], frame: &LocalFrame) -> Result<(), PlanError> {
        self.area = items::area(items, frame)?;
        self.keep(items);
        Ok(())
    }

    /// A PX4's fence, each part of which counts by itself: those that home, and a vehicle that would act on a breach at
    /// once, are inside of. Gives what is said of the others.
    pub fn replace_parts(
        &mut self,
        items: &[PlanItem],
        frame: &LocalFrame,
        home: Place,
        flying: Option<Place>,
    ) -> Vec<&'static str> {
        let (area, said) = parts::area(items, frame, home, flying);
        self.area = area;
        self.keep(items);
        said
    }

    fn keep(&mut self, items: &[PlanItem]) {
        self.items = items.iter().map(items::as_kept).collect();
        self.total = items::total(items);
    }

    /// Where a vehicle that has left it is sent, (north, east) in m.
    pub fn way_back(&self) -> Option<Place> {
        self.area.way_back()
    }

    /// The kinds that are asked for and that there are.
    fn present(&self, parameters: &Parameters) -> Kinds {
        let mut there = if self.area.is_open() { ALL & !POLYGON } else { ALL };
        if parameters.rules().fence_of_no_distance_is_none {
            for (kind, distance) in [(CIRCLE, Parameter::FenceRadius), (MAX_ALTITUDE, Parameter::FenceAltitudeMax)] {
                if parameters.get(distance) == 0.0 {
                    there &= !kind;
                }
            }
        }
        configured(parameters) & there
    }

    /// Whether what was uploaded forbids a place.
    fn forbids(&self, state: &State, parameters: &Parameters) -> bool {
        self.area.forbids(state.position_m(), inclusions_are_one(parameters))
    }
}
