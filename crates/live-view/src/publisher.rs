//! Looks at the feed again and again, and publishes what is new.

use crate::feed::FeedReader;
use crate::look::Looker;
use crate::published::Summary;
use crate::scene::{Frame, Scene};
use crate::shared::Shared;
use crate::wire::FINE_MAX;
use std::time::{Duration, Instant};

/// Time between two looks at the feed.
const LOOK: Duration = Duration::from_millis(100);
/// Time between two looks while no page is open: events and least distances go on.
const LOOK_UNSEEN: Duration = Duration::from_millis(500);
/// With many vehicles, one frame of so many has the status.
const STATUS_EVERY: u64 = 5;
/// Frames of the past are kept this far apart.
const HISTORY_STEP: Duration = Duration::from_millis(500);

/// Looks at a feed ten times a second while a page is open, for ever.
pub async fn look_again_and_again(shared: &Shared, feed: &FeedReader) {
    let mut publisher = Publisher::default();
    let mut next = tokio::time::Instant::now();
    let mut pages = shared.pages();
    loop {
        publisher.look(shared, feed, Instant::now());
        shared.announce();
        next += if *pages.borrow_and_update() > 0 { LOOK } else { LOOK_UNSEEN };
        next = next.max(tokio::time::Instant::now());
        tokio::select! {
            () = tokio::time::sleep_until(next) => {}
            // A page that opens is shown the present at once.
            _ = pages.changed() => {}
        }
    }
}

/// What is remembered from look to look.
#[derive(Default)]
struct Publisher {
    looker: Looker,
    scene: Scene,
    /// How many looks there were.
    count: u64,
    /// When a frame was last remembered.
    kept: Option<Instant>,
    before: Option<Frame>,
}

impl Publisher {
    fn look(&mut self, shared: &Shared, feed: &FeedReader, now: Instant) {
        let frame = feed.latest();
        let news = feed.take_news();
        feed.watch(shared.looked_at());
        let is_new_scene = news.scene.is_some() || self.count == 0;
        if let Some(scene) = news.scene {
            self.scene = scene;
        }
        let has_status = frame.vehicles.len() <= FINE_MAX || self.count.is_multiple_of(STATUS_EVERY);
        let look = self.looker.look(&frame, &self.scene, now, has_status);
        self.count += 1;
        let is_kept = has_status && !frame.vehicles.is_empty() && self.is_due(&frame, now);
        if is_kept {
            self.kept = Some(now);
        }

        let mut published = shared.published();
        if is_new_scene {
            published.set_scene(self.count, &self.scene);
        }
        if look.has_new_roster {
            published.set_roster(self.count, &self.looker);
        }
        published.tell(news.events);
        published.tell(look.events);
        news.choices.iter().for_each(|choice| published.choices().push(choice));
        if has_status {
            let least = self.looker.least(&frame);
            let (pages, refused) = (*shared.pages().borrow(), shared.refused());
            published.set_summary(self.count, &Summary { phase: &frame.phase, least, pages, refused });
        }
        // Silence goes on while nothing else does: a frame is sent even if the flight has told nothing new.
        published.set_frame(self.count, look.bytes, is_kept);
        drop(published);
        self.before = Some(frame);
    }

    /// Whether this frame is to be remembered: it tells something new, and some time after the last one.
    fn is_due(&self, frame: &Frame, now: Instant) -> bool {
        self.before.as_ref().is_none_or(|before| before.time_s != frame.time_s)
            && self.kept.is_none_or(|kept| now.saturating_duration_since(kept) >= HISTORY_STEP)
    }
}
