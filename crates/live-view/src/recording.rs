//! A flight for the page to play back: the same frames as live, one after another.

use crate::look::{LeastSoFar, Looker, Roster};
use crate::scene::{Event, Frame, Scene};
use serde::Serialize;
use std::time::{Duration, Instant};

/// A flight that was recorded.
#[derive(Clone, Debug)]
pub struct Recording {
    scene: Scene,
    looker: Looker,
    events: Vec<Event>,
    last: Frame,
    began: Instant,
    frames: Vec<u8>,
}

/// What the page knows of a recording beside its frames.
#[derive(Serialize)]
pub struct Head<'a> {
    scene: &'a Scene,
    roster: &'a Roster,
    told: &'a [Event],
    least: LeastSoFar<'a>,
}

impl Recording {
    /// An empty one.
    pub fn new(scene: Scene) -> Self {
        let (looker, last) = (Looker::default(), Frame::default());
        Self { scene, looker, events: Vec::new(), last, began: Instant::now(), frames: Vec::new() }
    }

    /// The instant that stands for a flight time, for [`VehicleNow::heard`](crate::VehicleNow::heard).
    pub fn instant(&self, time_s: f64) -> Instant {
        self.began + Duration::try_from_secs_f64(time_s).unwrap_or_default()
    }

    /// Adds the next moment.
    pub fn push(&mut self, frame: Frame) {
        let look = self.looker.look(&frame, &self.scene, self.instant(frame.time_s), true);
        self.events.extend(look.events);
        self.frames.extend_from_slice(&(look.bytes.len() as u32).to_le_bytes());
        self.frames.extend_from_slice(&look.bytes);
        self.last = frame;
    }

    /// Tells an event.
    pub fn tell(&mut self, event: Event) {
        self.events.push(event);
    }

    /// Changes the scene, as when plans are found further on.
    pub fn set_scene(&mut self, change: impl FnOnce(&mut Scene)) {
        change(&mut self.scene);
    }

    /// What is known of it beside its frames: the scene, the roster, the events, the least distances.
    pub fn head(&mut self) -> Head<'_> {
        self.events.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        let least = self.looker.least(&self.last);
        Head { scene: &self.scene, roster: self.looker.roster(), told: &self.events, least }
    }

    /// Hands out the frames since this was last called.
    pub fn take_frames(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.frames)
    }

    /// The frames: each with its length before it, four bytes, little-endian.
    pub fn frames(&self) -> &[u8] {
        &self.frames
    }
}
