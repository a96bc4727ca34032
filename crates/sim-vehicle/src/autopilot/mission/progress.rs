//! How far AUTO has come.

use super::Mission;
use super::conditions::Waiting;
use super::items::is_flown_to;
use super::legs::Leg;
use super::loiter::Loiter;
use nalgebra::Vector2;
use std::time::Duration;

/// How far AUTO has come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Progress {
    /// The item that is flown, or will be when AUTO is set.
    current: u16,
    /// Whether it has been flown, or somebody has chosen it.
    has_begun: bool,
    /// What is told in its place until it is flown: the item that was chosen, or the next one that has a place.
    told_as: Option<u16>,
    is_complete: bool,
    /// Whether RTL has looked for a landing sequence.
    has_looked_for_landing: bool,
    /// Times that each jump was made.
    jumps: Vec<(u16, u32)>,
    /// The place of the item before the current one, (north, east) in m: the leg begins there.
    from: Option<Vector2<f64>>,
    pub(super) leg: Leg,
    /// The item that was reached last, and when.
    reached: Option<(u16, Duration)>,
    /// Commands that wait for a condition.
    waiting: Option<Waiting>,
}

impl Progress {
    /// The first item of a mission comes next.
    pub fn at_beginning(mission: &Mission) -> Self {
        Self { current: mission.len().min(mission.first()), ..Self::default() }
    }

    /// An item of a mission that somebody has chosen comes next. Jumps that have been made count still, unless they
    /// are reset, home is chosen, or the mission is over.
    pub fn choose(&mut self, seq: u16, mission: &Mission, resets_jumps: bool) {
        let begins_anew = resets_jumps || seq < mission.first() || self.is_complete;
        let jumps = if begins_anew { Vec::new() } else { std::mem::take(&mut self.jumps) };
        let current = seq.max(mission.first());
        *self = Self { current, has_begun: true, told_as: Some(current), jumps, ..Self::default() };
    }

    /// Another mission begins with an item, or with its last one.
    pub fn start_at(&mut self, seq: u16, mission: &Mission) {
        let current = seq.min(mission.len().saturating_sub(1));
        *self = Self { current, told_as: Some(current), ..Self::at_beginning(mission) };
    }

    pub(super) fn note_reached(&mut self, seq: u16, time: Duration) {
        self.reached = Some((seq, time));
    }

    /// The item that was reached last, and when.
    pub fn reached(&self) -> Option<(u16, Duration)> {
        self.reached
    }

    /// How often a jump has been made.
    pub(super) fn jumps_made(&self, seq: u16) -> u32 {
        self.jumps.iter().find(|(jump, _)| *jump == seq).map_or(0, |(_, made)| *made)
    }

    pub fn current(&self) -> u16 {
        self.current
    }

    pub fn has_begun(&self) -> bool {
        self.has_begun
    }

    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The current item as it is told: none, 0, before anything has begun.
    pub fn told(&self) -> u16 {
        self.told_as.unwrap_or(if self.has_begun { self.current } else { 0 })
    }

    /// An item that was chosen and is not flown to is passed over: the next one that is flown to is told.
    pub fn tell_next_flown(&mut self, mission: &Mission) {
        let chosen = usize::from(self.current);
        let next = mission.numbered().skip_while(|(seq, _)| *seq < self.current).find(|(_, item)| is_flown_to(item));
        if let Some((seq, _)) = next.filter(|_| self.told_as.is_some() && chosen < mission.items().len()) {
            self.told_as = Some(seq);
        }
    }

    /// AUTO has been set: it goes on with the current item, from its beginning.
    pub fn begin(&mut self, mission: &Mission) {
        if self.is_complete || self.current < mission.first() {
            *self = Self::at_beginning(mission);
        }
        self.leg = Leg::Begin;
        self.from = None;
    }

    /// The mission is another one (`whole`), or a changed one, with which AUTO goes on where it is. So it does with
    /// another that takes the place of one under way, where the autopilot `resumes`.
    pub fn mission_changed(&mut self, mission: &Mission, whole: bool, resumes: bool) {
        let is_under_way = self.has_begun && !self.is_complete;
        let goes_on = resumes && is_under_way && mission.get(self.current).is_some();
        if whole && !goes_on {
            *self = Self::at_beginning(mission);
        }
        self.leg = Leg::Begin;
    }

    /// Begins with the current item.
    pub(super) fn begin_item(&mut self) -> u16 {
        self.has_begun = true;
        self.told_as = None;
        self.current
    }

    pub(super) fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Sets whether the mission is over when an item ends that comes back for ever.
    pub(super) fn set_complete(&mut self, is_complete: bool) {
        self.is_complete = is_complete;
    }

    pub(super) fn go_to(&mut self, seq: u16) {
        self.told_as = None;
        self.current = seq;
        self.leg = Leg::Begin;
    }

    pub(super) fn waiting(&self) -> Option<Waiting> {
        self.waiting
    }

    pub(super) fn set_waiting(&mut self, waiting: Option<Waiting>) {
        self.waiting = waiting;
    }

    /// The place that is flown to or circled, (north, east) in m, if the item has one.
    pub(super) fn place(&self) -> Option<Vector2<f64>> {
        match self.leg {
            Leg::Place { at, .. } | Leg::Circle(Loiter { centre: at, .. }) => Some(at),
            _ => None,
        }
    }

    /// From an item to another, so many times; a negative number is for ever. Gives how often it has been made, if it
    /// is made again. A jump that has been made as often as it should counts from the beginning when it is come to
    /// again.
    pub(super) fn jump(&mut self, from: u16, to: u16, times: f64) -> Option<u32> {
        let index = self.jumps.iter().position(|(jump, _)| *jump == from).unwrap_or_else(|| {
            self.jumps.push((from, 0));
            self.jumps.len() - 1
        });
        let made = &mut self.jumps[index].1;
        let again = times < 0.0 || f64::from(*made) < times;
        *made = if again { *made + 1 } else { 0 };
        let made = *made;
        self.go_to(if again { to } else { from + 1 });
        again.then_some(made)
    }

    /// Where the leg to the current item begins, (north, east) in m.
    pub(super) fn from(&self) -> Option<Vector2<f64>> {
        self.from
    }

    pub(super) fn set_from(&mut self, from: Option<Vector2<f64>>) {
        self.from = from;
    }

    /// RTL begins: it looks for a landing sequence once.
    pub fn look_for_landing_again(&mut self) {
        self.has_looked_for_landing = false;
    }

    pub(super) fn has_looked_for_landing(&self) -> bool {
        self.has_looked_for_landing
    }

    pub(super) fn found_no_landing(&mut self) {
        self.has_looked_for_landing = true;
    }
}
