//! Whose a vehicle is: the station flies it, the operator keeps it out, or others have it.

use mavlink_bridge::kind::AtEnd;
use std::time::Duration;

/// An order to hold has reached the vehicle, or never will, after this.
const HOLD_SETTLES: Duration = Duration::from_secs(1);

/// Who has a vehicle.
#[derive(Debug, Default)]
pub struct Custody {
    /// Whether it has been in the mode in which it follows our setpoints, since it was last ours to bring there.
    has_entered: bool,
    /// When it was last told to hold.
    held: Option<Duration>,
    /// Why it is flown no more; it is a neighbour to be avoided then.
    released: Option<String>,
    /// The operator keeps it out, and this is what it does meanwhile.
    dropped: Option<AtEnd>,
    /// The operator has paused it alone.
    is_paused: bool,
    /// The operator has resumed it alone, and it does not follow yet.
    is_resuming: bool,
}

impl Custody {
    /// Whether the station may command it: neither others nor the operator have it.
    pub fn is_ours(&self) -> bool {
        self.released.is_none() && self.dropped.is_none()
    }

    /// Whether it has been in the mode in which it follows our setpoints: to leave that mode is then a pilot's doing.
    pub fn has_entered(&self) -> bool {
        self.has_entered
    }

    /// It is in the mode in which it follows our setpoints.
    pub fn enter(&mut self) {
        (self.has_entered, self.is_resuming) = (true, false);
    }

    /// Whether the station is to bring it into the mode in which it follows our setpoints.
    pub fn is_to_be_brought(&self) -> bool {
        (!self.has_entered || self.is_resuming) && !self.is_paused
    }

    /// It is flown no more, for a reason in words.
    pub fn release(&mut self, why: impl Into<String>) {
        self.released = Some(why.into());
    }

    /// Why it is flown no more, if that is so.
    pub fn released(&self) -> Option<&str> {
        self.released.as_deref()
    }

    /// The operator keeps it out.
    pub fn drop_out(&mut self, to: AtEnd) {
        self.dropped = Some(to);
    }

    /// What it does while the operator keeps it out, if that is so.
    pub fn dropped(&self) -> Option<AtEnd> {
        self.dropped
    }

    /// It is flown again, whoever had it.
    pub fn take_back(&mut self) {
        *self = Self { held: self.held, ..Self::default() };
    }

    /// The operator pauses it alone.
    pub fn pause(&mut self) {
        (self.is_paused, self.is_resuming) = (true, false);
    }

    /// Whether the operator has paused it alone.
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Whether it may hold where it is: it was paused alone, and does not follow again yet.
    pub fn may_hold(&self) -> bool {
        self.is_paused || self.is_resuming
    }

    /// It is paused no more; whether it was, and is to be brought back into the mode in which it follows.
    pub fn resume(&mut self) -> bool {
        let was_paused = std::mem::take(&mut self.is_paused);
        self.is_resuming |= was_paused;
        was_paused
    }

    /// It is paused no more, since all are to be brought back into the mode in which they follow.
    pub fn resume_with_all(&mut self) {
        self.is_paused = false;
    }

    /// It was told to hold.
    pub fn was_told_to_hold(&mut self, now: Duration) {
        self.held = Some(now);
    }

    /// Whether no order to hold is under way that could still change a mode which was heard then.
    pub fn is_settled(&self, mode_heard: Option<Duration>) -> bool {
        match (self.held, mode_heard) {
            (None, _) => true,
            (Some(held), Some(heard)) => heard >= held + HOLD_SETTLES,
            (Some(_), None) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_heard_before_an_order_to_hold_arrived_proves_nothing() {
        let at = |at_s: f64| Some(Duration::from_secs_f64(at_s));
        let mut custody = Custody::default();
        assert!(custody.is_settled(None) && custody.is_settled(at(10.0)));
        custody.was_told_to_hold(Duration::from_secs_f64(10.1));
        assert!(!custody.is_settled(None) && !custody.is_settled(at(10.0)) && !custody.is_settled(at(10.9)));
        assert!(custody.is_settled(at(11.2)));
    }

    #[test]
    fn one_that_others_or_the_operator_have_is_ours_again_when_it_is_taken_back() {
        let mut custody = Custody::default();
        custody.enter();
        custody.release("was brought into RTL by others");
        assert!(!custody.is_ours());
        custody.drop_out(AtEnd::Return);
        assert_eq!((custody.is_ours(), custody.dropped()), (false, Some(AtEnd::Return)));
        custody.take_back();
        assert!(custody.is_ours() && !custody.has_entered());
    }

    #[test]
    fn one_that_was_paused_alone_must_be_brought_back() {
        let mut custody = Custody::default();
        custody.enter();
        assert!(!custody.resume() && !custody.is_to_be_brought() && !custody.may_hold());
        custody.pause();
        assert!(!custody.is_to_be_brought() && custody.may_hold());
        assert!(custody.resume() && custody.is_to_be_brought() && custody.may_hold() && !custody.is_paused());
        assert!(custody.has_entered(), "a pilot who takes it now is seen");
        custody.enter();
        assert!(!custody.is_to_be_brought() && !custody.may_hold());
    }
}
