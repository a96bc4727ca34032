//! The feed: what a flight tells the page, without ever waiting for it.
//!
//! The flight's side takes no lock that it would have to wait for: it sends into a channel without an end, which never
//! blocks, and tries the two locks that there are.

use crate::choice::Choice;
use crate::scene::{Event, Frame, Scene};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

/// The flight's end of the page. Clones feed the same page.
#[derive(Clone, Debug)]
pub struct Feed {
    shared: Arc<Shared>,
    news: Sender<Told>,
}

/// The page's end.
#[derive(Debug)]
pub(crate) struct FeedReader {
    shared: Arc<Shared>,
    news: Receiver<Told>,
}

#[derive(Debug, Default)]
struct Shared {
    frame: Mutex<Frame>,
    /// Numbers of the vehicles that pages look at.
    watched: Mutex<Vec<u32>>,
    /// How many events, and how many choices, the page has not taken yet.
    waiting: [AtomicUsize; 2],
}

/// One thing that the flight tells.
#[derive(Debug)]
enum Told {
    Scene(Box<Scene>),
    Event(Event),
    Choice(Box<Choice>),
}

/// What the page has not taken yet.
#[derive(Debug, Default)]
pub(crate) struct News {
    /// A new scene.
    pub scene: Option<Scene>,
    /// New events.
    pub events: Vec<Event>,
    /// New choices.
    pub choices: VecDeque<Choice>,
}

const EVENTS: usize = 0;
const CHOICES: usize = 1;
/// More events than this, and more choices, wait for nobody: the page's thread is far behind. A flight in simulated
/// time makes more choices than anybody sees.
const WAITING_MAX: [usize; 2] = [100_000, 2000];

/// Both ends of a new feed.
pub(crate) fn feed() -> (Feed, FeedReader) {
    let (send, receive) = channel();
    let shared = Arc::new(Shared::default());
    (Feed { shared: Arc::clone(&shared), news: send }, FeedReader { shared, news: receive })
}

impl Feed {
    /// Changes the frame. Never waits: while the page's thread copies the frame, which takes microseconds, nothing is
    /// changed and this gives false. The next change a moment later will do.
    pub fn update(&self, change: impl FnOnce(&mut Frame)) -> bool {
        match self.shared.frame.try_lock() {
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
        self.send(Told::Scene(Box::new(scene)));
    }

    /// Tells an event; none is lost while the page's thread lives.
    pub fn tell(&self, event: Event) {
        if self.has_room(EVENTS) {
            self.send(Told::Event(event));
        }
    }

    /// Tells what an optimiser had to choose from.
    pub fn choose(&self, choice: Choice) {
        if self.has_room(CHOICES) {
            self.send(Told::Choice(Box::new(choice)));
        }
    }

    /// Numbers of the vehicles that pages look at: of these, choices are worth telling. Never waits: in the moment in
    /// which the page's thread changes them, there are none.
    pub fn watched(&self) -> Vec<u32> {
        match self.shared.watched.try_lock() {
            Ok(watched) => watched.clone(),
            Err(TryLockError::Poisoned(watched)) => watched.into_inner().clone(),
            Err(TryLockError::WouldBlock) => Vec::new(),
        }
    }

    fn has_room(&self, kind: usize) -> bool {
        let waiting = &self.shared.waiting[kind];
        let has_room = waiting.fetch_add(1, Ordering::Relaxed) < WAITING_MAX[kind];
        if !has_room {
            waiting.fetch_sub(1, Ordering::Relaxed);
        }
        has_room
    }

    /// A page that is gone is told nothing.
    fn send(&self, told: Told) {
        let _ = self.news.send(told);
    }
}

impl FeedReader {
    /// Sets which vehicles pages look at.
    pub fn watch(&self, numbers: Vec<u32>) {
        *self.shared.watched.lock().unwrap_or_else(PoisonError::into_inner) = numbers;
    }

    /// The frame as it is now.
    pub fn latest(&self) -> Frame {
        self.shared.frame.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What is new since this was last called.
    pub fn take_news(&self) -> News {
        let mut news = News::default();
        for told in self.news.try_iter() {
            match told {
                Told::Scene(scene) => news.scene = Some(*scene),
                Told::Event(event) => news.events.push(event),
                Told::Choice(choice) => news.choices.push_back(*choice),
            }
        }
        self.shared.waiting[EVENTS].fetch_sub(news.events.len(), Ordering::Relaxed);
        self.shared.waiting[CHOICES].fetch_sub(news.choices.len(), Ordering::Relaxed);
        news
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_the_page_holds_the_flight_never_waits() {
        let (feed, reader) = feed();
        assert!(feed.update(|frame| frame.time_s = 1.0));
        reader.watch(vec![7]);
        // The page's thread stands still with all that it could hold: with a lock to wait for, this would not end.
        let held = (reader.shared.frame.lock().unwrap(), reader.shared.watched.lock().unwrap());
        for count in 0..300_000 {
            assert!(!feed.update(|frame| frame.time_s = 2.0), "it returns at once, and changes nothing");
            feed.tell(Event { at_s: f64::from(count), ..Event::default() });
            feed.choose(Choice { at_s: f64::from(count), ..Choice::default() });
            assert!(feed.watched().is_empty());
        }
        feed.scene(Scene { title: "still told".into(), ..Scene::default() });
        drop(held);
        assert_eq!((reader.latest().time_s, feed.watched()), (1.0, vec![7]));
        assert!(feed.update(|frame| frame.time_s = 3.0));
        assert_eq!(reader.latest().time_s, 3.0);
        let news = reader.take_news();
        assert_eq!((news.events.len(), news.choices.len()), (WAITING_MAX[EVENTS], WAITING_MAX[CHOICES]));
        assert_eq!((news.events[5].at_s, news.scene.unwrap().title.as_str()), (5.0, "still told"));
        // What was taken makes room again.
        feed.tell(Event::default());
        assert_eq!(reader.take_news().events.len(), 1);
        drop(reader);
        feed.tell(Event::default());
    }
}
