//! What the looks at the feed and the pages share, all on one thread but for a few counters.

use crate::guard::{Refused, Token};
use crate::published::Published;
use crate::tape::Tape;
use serde::Serialize;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{mpsc, oneshot, watch};

/// Pages at once.
const PAGES_MAX: usize = 32;
/// Words of operators that wait to be heard.
const WORDS_MAX: usize = 64;

/// Words of an operator, who had the token.
#[derive(Debug)]
pub struct Said {
    /// What was said, as "pause" or "drop 3".
    pub text: String,
    /// Who said it: the address of the browser.
    pub from: SocketAddr,
    /// Takes the answer.
    pub answer: oneshot::Sender<Answer>,
}

/// What the operator is answered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// Whether it is done, or being done.
    pub is_done: bool,
    /// In words.
    pub text: String,
}

/// What all pages of one server share.
#[derive(Debug)]
pub struct Shared {
    token: Token,
    port: u16,
    tape: Option<Tape>,
    say: mpsc::Sender<Said>,
    published: Mutex<Published>,
    refused: Mutex<Refused>,
    /// Which vehicle a page looks at.
    looks: Mutex<BTreeMap<SocketAddr, u32>>,
    /// Counts looks.
    news: watch::Sender<u64>,
    /// How many pages are open.
    pages: watch::Sender<usize>,
}

/// The place of one page among those that are open at once.
pub struct Place(Arc<Shared>);

impl Shared {
    /// What pages at a port share, and what their operators say.
    pub fn new(token: Token, port: u16, tape: Option<Tape>) -> (Self, mpsc::Receiver<Said>) {
        let (say, words) = mpsc::channel(WORDS_MAX);
        let shared = Self {
            token,
            port,
            tape,
            say,
            published: Mutex::default(),
            refused: Mutex::default(),
            looks: Mutex::default(),
            news: watch::channel(0).0,
            pages: watch::channel(0).0,
        };
        (shared, words)
    }

    /// What an operator needs.
    pub fn token(&self) -> &Token {
        &self.token
    }

    /// The port of the server.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// What is played back, where the page is no live one.
    pub fn tape(&self) -> Option<&Tape> {
        self.tape.as_ref()
    }

    /// What pages are sent.
    pub fn published(&self) -> MutexGuard<'_, Published> {
        lock(&self.published)
    }

    /// There is something new to send.
    pub fn announce(&self) {
        self.news.send_modify(|count| *count += 1);
    }

    /// Tells when there is something new to send.
    pub fn news(&self) -> watch::Receiver<u64> {
        self.news.subscribe()
    }

    /// How many pages are open, and when that changes.
    pub fn pages(&self) -> watch::Receiver<usize> {
        self.pages.subscribe()
    }

    /// Hands on what an operator says; gives whether anybody will hear it.
    pub fn say(&self, said: Said) -> bool {
        self.say.try_send(said).is_ok()
    }

    /// Counts a request that is refused.
    pub fn refuse(&self, count: impl FnOnce(&mut Refused)) {
        count(&mut lock(&self.refused));
    }

    /// How many requests were refused so far.
    pub fn refused(&self) -> Refused {
        *lock(&self.refused)
    }

    /// A page looks at a vehicle, or at none.
    pub fn look(&self, page: SocketAddr, vehicle: Option<u32>) {
        let mut looks = lock(&self.looks);
        match vehicle {
            Some(number) => looks.insert(page, number),
            None => looks.remove(&page),
        };
    }

    /// The vehicles that pages look at.
    pub fn looked_at<T: FromIterator<u32>>(&self) -> T {
        lock(&self.looks).values().copied().collect()
    }
}

impl Place {
    /// A place, if there is one.
    pub fn take(shared: &Arc<Shared>) -> Option<Self> {
        let is_taken = shared.pages.send_if_modified(|pages| {
            let has_room = *pages < PAGES_MAX;
            *pages += usize::from(has_room);
            has_room
        });
        is_taken.then(|| Self(Arc::clone(shared)))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.pages.send_modify(|pages| *pages -= 1);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
