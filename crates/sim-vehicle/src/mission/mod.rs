//! Missions: which items are accepted, and how AUTO flies them.

mod auto;
mod items;
mod landing;

pub(crate) use auto::Progress;
pub(crate) use items::{LAND_START, RETURN_PATH_START, WAYPOINT, check};

use mavlink_bridge::PlanItem;

/// Most items, home among them.
pub(crate) const ITEMS_MAX: u16 = 700;

/// The mission on board. Item 0 is home, as ArduPilot has it: its contents do not count.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mission {
    pub items: Vec<PlanItem>,
}

impl Mission {
    pub fn len(&self) -> u16 {
        u16::try_from(self.items.len()).unwrap_or(u16::MAX)
    }

    /// Whether there is something to fly.
    pub fn is_flyable(&self) -> bool {
        self.items.len() > 1
    }

    pub fn get(&self, seq: u16) -> Option<&PlanItem> {
        self.items.get(usize::from(seq))
    }

    /// The items after home, each with its index.
    pub fn numbered(&self) -> impl Iterator<Item = (u16, &PlanItem)> {
        (0..self.len()).zip(&self.items).skip(1)
    }
}
