//! Missions: which items are accepted, and how AUTO flies them.

mod auto;
mod items;
mod landing;
mod legs;
mod loiter;

pub(crate) use auto::Progress;
pub(crate) use items::{LAND_START, RETURN_PATH_START, WAYPOINT, check, has_heading};

use mavlink_bridge::PlanItem;

/// Most items, home among them.
pub(crate) const ITEMS_MAX: u16 = 700;

/// The mission on board.
#[derive(Clone, Debug)]
pub(crate) struct Mission {
    pub items: Vec<PlanItem>,
    /// The index of the first item that is flown: 1 where item 0 is home, as ArduPilot has it, whose contents do not count.
    pub first: u16,
    /// Whether the autopilot would fly it: a PX4 takes missions that it does not.
    pub is_feasible: bool,
}

impl Mission {
    /// None, whose items will be flown from an index on: before anything is uploaded or cleared, an ArduPilot counts home.
    pub fn new(first: u16) -> Self {
        Self { items: vec![PlanItem::default(); usize::from(first)], first, is_feasible: true }
    }

    pub fn len(&self) -> u16 {
        u16::try_from(self.items.len()).unwrap_or(u16::MAX)
    }

    /// Whether there is something to fly.
    pub fn is_flyable(&self) -> bool {
        self.len() > self.first && self.is_feasible
    }

    pub fn get(&self, seq: u16) -> Option<&PlanItem> {
        self.items.get(usize::from(seq))
    }

    /// The items that are flown, each with its index.
    pub fn numbered(&self) -> impl Iterator<Item = (u16, &PlanItem)> {
        (0..self.len()).zip(&self.items).skip(usize::from(self.first))
    }
}

#[cfg(test)]
mod tests;
