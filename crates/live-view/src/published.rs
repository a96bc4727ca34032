//! What pages are sent, and what each has been sent.

use crate::choice::Choices;
use crate::guard::Refused;
use crate::look::{LeastSoFar, Looker};
use crate::scene::{Event, Scene};
use crate::wire::{BITS_AT, HISTORY};
use axum::body::Bytes;
use axum::extract::ws::Message;
use serde::Serialize;
use std::collections::VecDeque;

/// So many bytes of frames of the past are kept.
const HISTORY_BYTES_MAX: usize = 8 << 20;

/// What pages are sent. Each part bears the count of the look that made it.
#[derive(Debug, Default)]
pub struct Published {
    scene: (u64, Bytes),
    roster: (u64, Bytes),
    summary: (u64, Bytes),
    frame: (u64, Bytes),
    events: Vec<Event>,
    choices: Choices,
    history: VecDeque<Bytes>,
    history_bytes: usize,
    is_over: bool,
}

/// What a page has been sent.
#[derive(Debug, Default)]
pub struct Sent {
    scene: u64,
    roster: u64,
    summary: u64,
    frame: u64,
    choices: u64,
    events: usize,
    has_history: bool,
}

/// What is said of the flight as a whole.
#[derive(Serialize)]
pub struct Summary<'a> {
    pub phase: &'a str,
    pub least: LeastSoFar<'a>,
    pub pages: usize,
    pub refused: Refused,
}

impl Published {
    /// Publishes a scene.
    pub fn set_scene(&mut self, count: u64, scene: &Scene) {
        self.scene = (count, json("scene", scene));
    }

    /// Publishes whose frames follow.
    pub fn set_roster(&mut self, count: u64, looker: &Looker) {
        self.roster = (count, json("roster", looker.roster()));
    }

    /// Publishes a summary, unless the last one said the same.
    pub fn set_summary(&mut self, count: u64, summary: &Summary<'_>) {
        let bytes = json("summary", summary);
        if bytes != self.summary.1 {
            self.summary = (count, bytes);
        }
    }

    /// Publishes a frame; pages that open later are shown those that are to be remembered.
    pub fn set_frame(&mut self, count: u64, frame: Vec<u8>, is_to_be_remembered: bool) {
        if is_to_be_remembered {
            self.remember(frame.clone());
        }
        self.frame = (count, Bytes::from(frame));
    }

    /// Tells more events.
    pub fn tell(&mut self, events: impl IntoIterator<Item = Event>) {
        self.events.extend(events);
    }

    /// What optimisers had to choose from, for pages that look at a vehicle.
    pub fn choices(&mut self) -> &mut Choices {
        &mut self.choices
    }

    /// Nothing follows.
    pub fn end(&mut self) {
        self.is_over = true;
    }

    /// Whether nothing follows.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// What a page has not been sent, from now on counted as sent: of frames only the newest. A page that plays a
    /// recording (`is_live` is false) has scene, roster and frames from there.
    pub fn unsent(&self, sent: &mut Sent, looks_at: Option<u32>, is_live: bool) -> Vec<Message> {
        let mut messages = Vec::new();
        for (known, (count, bytes)) in
            [(&mut sent.scene, &self.scene), (&mut sent.roster, &self.roster), (&mut sent.summary, &self.summary)]
        {
            if known != count && is_live {
                *known = *count;
                messages.push(text(bytes));
            }
        }
        if !std::mem::replace(&mut sent.has_history, true) {
            messages.extend(self.history.iter().cloned().map(Message::Binary));
        }
        if sent.events < self.events.len() {
            messages.push(text(&json("told", &&self.events[sent.events..])));
            sent.events = self.events.len();
        }
        if let Some((count, choices)) = looks_at.and_then(|vehicle| self.choices.after(vehicle, sent.choices)) {
            sent.choices = count;
            messages.push(Message::Text(format!("{{\"choices\":{choices}}}").into()));
        }
        if sent.frame != self.frame.0 && is_live {
            sent.frame = self.frame.0;
            messages.push(Message::Binary(self.frame.1.clone()));
        }
        messages
    }

    fn remember(&mut self, mut frame: Vec<u8>) {
        if let Some(bits) = frame.get_mut(BITS_AT) {
            *bits |= HISTORY;
        }
        self.history_bytes += frame.len();
        self.history.push_back(Bytes::from(frame));
        while self.history_bytes > HISTORY_BYTES_MAX {
            let Some(oldest) = self.history.pop_front() else { break };
            self.history_bytes -= oldest.len();
        }
    }
}

impl Sent {
    /// The page looks at another vehicle: that one's choices are sent from the first that is known.
    pub fn forget_choices(&mut self) {
        self.choices = 0;
    }
}

/// A message of text.
pub fn text(bytes: &Bytes) -> Message {
    Message::Text(String::from_utf8_lossy(bytes).into_owned().into())
}

/// An object of one name.
fn json(name: &str, value: &impl Serialize) -> Bytes {
    let value = serde_json::to_value(value).unwrap_or_default();
    Bytes::from(serde_json::json!({ name: value }).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_sent_each_thing_once_and_a_page_that_opens_later_the_past_too() {
        let mut published = Published::default();
        let mut early = Sent::default();
        for count in 1..=4_u64 {
            published.set_frame(count, vec![count as u8; 12], count % 2 == 0);
            published.tell([Event { at_s: count as f64, ..Event::default() }]);
            let sent = published.unsent(&mut early, None, true);
            assert!(sent.contains(&Message::Binary(vec![count as u8; 12].into())), "the newest frame");
            assert_eq!(sent.len(), 2, "and one event: {sent:?}");
        }
        assert_eq!(published.unsent(&mut early, None, true), []);
        let late = published.unsent(&mut Sent::default(), None, true);
        assert_eq!(late.len(), 4, "two frames of the past, all events, the newest frame: {late:?}");
    }

    #[test]
    fn the_past_is_bounded() {
        let mut published = Published::default();
        for _ in 0..40 {
            published.set_frame(1, vec![0; 1 << 20], true);
        }
        assert_eq!(published.history.len() << 20, HISTORY_BYTES_MAX);
    }
}
