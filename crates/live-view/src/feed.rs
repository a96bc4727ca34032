//! The feed: what a flight tells the page, without ever waiting for it.

use crate::choice::Choice;
use crate::scene::{Event, Frame, Scene};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// The flight's end of the page. Clones feed the same page.
#[derive(Clone, Debug, Default)]
pub struct Feed(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    frame: Mutex<Frame>,
    /// The scene, the events and the choices that the page has not taken yet. Short work on both sides.
    news: Mutex<News>,
    /// Numbers of the vehicles that pages look at.
    watched: Mutex<Vec<u32>>,
}

/// What the page has not taken yet.
#[derive(Debug, Default)]
pub struct News {
    /// A new scene.
    pub scene: Option<Scene>,
    /// New events.
    pub events: Vec<Event>,
    /// New choices.
    pub choices: VecDeque<Choice>,
}

/// More events than this wait for nobody: the page's thread is gone.
const EVENTS_MAX: usize = 100_000;
/// Of the choices that wait, the newest: a flight in simulated time makes more than anybody sees.
const CHOICES_MAX: usize = 1000;

impl Feed {
    /// Changes the frame. Never waits: while the page's thread copies the frame, which takes microseconds, nothing is
    /// changed and this gives false. The next change a moment later will do.
    pub fn update(&self, change: impl FnOnce(&mut Frame)) -> bool {
        match self.0.frame.try_lock() {
            Ok(mut frame) => {
                change(&mut frame);
                true
            }
            Err(TryLockError::Poisoned(frame)) => {
                change(&mut frame.into_inner());
                true
            }
            Err(TryLockError::WouldBlock) => false,
        }
    }

    /// Sets the scene.
    pub fn scene(&self, scene: Scene) {
        self.lock_news().scene = Some(scene);
    }

    /// Tells an event; none is lost.
    pub fn tell(&self, event: Event) {
        let mut news = self.lock_news();
        if news.events.len() < EVENTS_MAX {
            news.events.push(event);
        }
    }

    /// Tells what an optimiser had to choose from.
    pub fn choose(&self, choice: Choice) {
        let mut news = self.lock_news();
        if news.choices.len() >= CHOICES_MAX {
            news.choices.pop_front();
        }
        news.choices.push_back(choice);
    }

    /// Numbers of the vehicles that pages look at: of these, choices are worth telling.
    pub fn watched(&self) -> Vec<u32> {
        self.0.watched.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Sets which vehicles pages look at.
    pub(crate) fn watch(&self, numbers: Vec<u32>) {
        *self.0.watched.lock().unwrap_or_else(PoisonError::into_inner) = numbers;
    }

    /// The frame as it is now.
    pub fn latest(&self) -> Frame {
        self.0.frame.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What is new since this was last called.
    pub fn take_news(&self) -> News {
        std::mem::take(&mut *self.lock_news())
    }

    fn lock_news(&self) -> MutexGuard<'_, News> {
        self.0.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_never_makes_the_flight_wait() {
        let feed = Feed::default();
        assert!(feed.update(|frame| frame.time_s = 1.0));
        let reading = feed.0.frame.lock().unwrap();
        assert!(!feed.update(|frame| frame.time_s = 2.0), "it returns at once, and changes nothing");
        drop(reading);
        assert_eq!(feed.latest().time_s, 1.0);
        assert!(feed.update(|frame| frame.time_s = 3.0));
        assert_eq!(feed.latest().time_s, 3.0);
    }
}
