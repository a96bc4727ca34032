//! Conditions of a mission: commands behind one wait for it, while the next place is flown to. Once that is reached,
//! they are passed over (`AP_Mission::update`).

use crate::autopilot::Autopilot;
use mavlink_bridge::PlanItem;
use std::time::Duration;

pub(super) const DELAY: u16 = 112;
pub(super) const DISTANCE: u16 = 114;

/// What is waited for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Condition {
    /// A vehicle time.
    Time(Duration),
    /// To be nearer than so many metres to the place that is flown to.
    Distance(f64),
}

/// Commands that wait.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Waiting {
    /// The item that makes them wait.
    seq: u16,
    condition: Condition,
}

impl Waiting {
    /// The condition of an item, if it is one.
    pub(super) fn of(seq: u16, item: &PlanItem, time: Duration) -> Option<Self> {
        let p1 = item.params[0];
        let condition = match item.command {
            DELAY => Condition::Time(time + Duration::try_from_secs_f32(p1).unwrap_or_default()),
            DISTANCE => Condition::Distance(f64::from(p1)),
            _ => return None,
        };
        Some(Self { seq, condition })
    }
}

impl Autopilot {
    /// Does the commands whose condition has come to hold.
    pub(super) fn follow_conditions(&mut self) {
        while let Some(waiting) = self.session.progress.waiting() {
            let holds = match waiting.condition {
                Condition::Time(until) => self.time > until,
                Condition::Distance(within_m) => {
                    self.session.progress.place().is_some_and(|at| self.flight.distance_m(at) < within_m)
                }
            };
            if !holds {
                return;
            }
            self.session.progress.set_waiting(None);
            self.tell_reached(waiting.seq);
            self.do_from(waiting.seq + 1);
        }
    }

    /// Does the commands from an item on, up to one that is flown to or another condition.
    fn do_from(&mut self, first: u16) {
        let items: Vec<(u16, PlanItem)> =
            self.mission.numbered().filter(|(seq, _)| *seq >= first).map(|(seq, item)| (seq, *item)).collect();
        for (seq, item) in items {
            if super::items::is_flown_to(&item) || super::items::is_jump(&item) {
                return;
            }
            self.tell_beginning(seq, &item);
            if let Some(waiting) = Waiting::of(seq, &item, self.time) {
                return self.session.progress.set_waiting(Some(waiting));
            }
            self.do_command(&item);
            self.tell_done(seq, &item);
        }
    }
}
