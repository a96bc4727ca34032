//! What an autopilot has to tell: the vehicle makes messages of it.

use crate::error::Severity;

/// Something that others are told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Event {
    /// Words for everybody.
    Text(Severity, String),
    /// The mode has changed, in a way that is told at once.
    ModeChanged,
    /// An item of the mission has been reached.
    ItemReached(u16),
    /// There is another home.
    HomeMoved,
    /// The fence has been breached from inside.
    Breached,
}

/// What has happened and is not yet told, in its order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Events(Vec<Event>);

impl Events {
    pub fn push(&mut self, event: Event) {
        self.0.push(event);
    }

    pub fn say(&mut self, severity: Severity, text: impl Into<String>) {
        self.push(Event::Text(severity, text.into()));
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Takes all of them.
    pub fn take(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.0)
    }
}
