//! Missions: which items are accepted, and how AUTO flies them.

mod auto;
mod commands;
mod conditions;
pub(crate) mod feasibility;
pub(crate) mod items;
mod landing;
mod legs;
mod loiter;
mod names;
pub(crate) mod progress;

use mavlink_bridge::PlanItem;

/// The mission on board.
#[derive(Clone, Debug)]
pub(crate) struct Mission {
    items: Vec<PlanItem>,
    first: u16,
    /// Whether the autopilot would fly it: a PX4 takes missions that it does not.
    is_feasible: bool,
}

impl Mission {
    /// None, whose items will be flown from an index on: before anything is uploaded or cleared, an ArduPilot counts
    /// home.
    pub fn new(first: u16) -> Self {
        Self { items: vec![PlanItem::default(); usize::from(first)], first, is_feasible: true }
    }

    pub fn items(&self) -> &[PlanItem] {
        &self.items
    }

    /// The index of the first item that is flown: 1 where item 0 is home, as ArduPilot has it, whose contents do not
    /// count.
    pub fn first(&self) -> u16 {
        self.first
    }

    pub fn replace(&mut self, items: Vec<PlanItem>, is_feasible: bool) {
        self.items = items;
        self.is_feasible = is_feasible;
    }

    /// Sets whether the autopilot would fly it.
    pub fn set_feasible(&mut self, is_feasible: bool) {
        self.is_feasible = is_feasible;
    }

    pub fn len(&self) -> u16 {
        u16::try_from(self.items.len()).unwrap_or(u16::MAX)
    }

    /// Whether item 0 is home and not even that is on board.
    pub fn is_without_home(&self) -> bool {
        self.first > 0 && self.items.is_empty()
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

    /// The JUMP_TAG of a number.
    pub fn tagged(&self, tag: f64) -> Option<u16> {
        let is_it = |item: &PlanItem| item.command == items::TAG && f64::from(item.params[0]) == tag;
        self.numbered().find(|(_, item)| is_it(item)).map(|(seq, _)| seq)
    }
}

#[cfg(test)]
mod tests;
