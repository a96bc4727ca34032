//! The page's server: a thread of its own, which looks at the feed and publishes what is new.

use crate::choice::Choices;
use crate::connections::Bounded;
use crate::feed::{Feed, FeedReader, feed};
use crate::guard::{Refused, Token};
use crate::look::{LeastSoFar, Looker};
use crate::scene::{Event, Frame, Scene};
use crate::tape::Tape;
use crate::wire::{BITS_AT, FINE_MAX, HISTORY};
use axum::body::Bytes;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot, watch};

/// Time between two looks at the feed.
const LOOK: Duration = Duration::from_millis(100);
/// Time between two looks while no page is open: events and least distances go on.
const LOOK_UNSEEN: Duration = Duration::from_millis(500);
/// With many vehicles, one frame of so many has the status.
const STATUS_EVERY: u64 = 5;
/// Frames of the past are kept this far apart.
const HISTORY_STEP: Duration = Duration::from_millis(500);
/// So many bytes of them are kept.
const HISTORY_BYTES_MAX: usize = 8 << 20;
/// How long the end of the program is told to pages that are slow.
const GOODBYE: Duration = Duration::from_millis(500);

/// Where the page is.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Address; loopback by default.
    pub host: IpAddr,
    /// Port; 0: any free one.
    pub port: u16,
}

impl Default for Settings {
    fn default() -> Self {
        Self { host: IpAddr::V4(Ipv4Addr::LOCALHOST), port: 0 }
    }
}

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The address cannot be bound.
    #[error("cannot serve the page at {address}: {source}")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: io::Error,
    },
    /// No thread, no runtime or no random numbers.
    #[error("cannot start the page's server: {0}")]
    Start(String),
}

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

/// A running page. It ends when this is dropped.
#[derive(Debug)]
pub struct LiveView {
    address: SocketAddr,
    feed: Feed,
    shared: Arc<Shared>,
    words: Option<mpsc::Receiver<Said>>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl LiveView {
    /// Serves a page about whatever its feed is told.
    ///
    /// # Errors
    /// The address cannot be bound, or the system gives no thread or no random numbers.
    pub fn start(settings: &Settings) -> Result<Self, ViewError> {
        Self::serve(settings, None)
    }

    /// Serves a page that plays a recording back, while it is still being read.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn play(settings: &Settings, tape: Tape) -> Result<Self, ViewError> {
        Self::serve(settings, Some(tape))
    }

    fn serve(settings: &Settings, tape: Option<Tape>) -> Result<Self, ViewError> {
        let start = |reason: String| ViewError::Start(reason);
        let asked = SocketAddr::new(settings.host, settings.port);
        let bind = |source| ViewError::Bind { address: asked, source };
        let listener = TcpListener::bind(asked).map_err(bind)?;
        listener.set_nonblocking(true).map_err(bind)?;
        let address = listener.local_addr().map_err(bind)?;
        let (feed, reader) = feed();
        let (say, words) = mpsc::channel(64);
        let shared = Arc::new(Shared {
            token: Token::new().map_err(|error| start(error.to_string()))?,
            port: address.port(),
            tape,
            say,
            published: Mutex::new(Published::default()),
            news: watch::channel(0).0,
            pages: watch::channel(0).0,
        });
        let (stop, stopped) = oneshot::channel();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| start(error.to_string()))?;
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("live-view".to_owned())
            .spawn(move || runtime.block_on(run(of_thread, reader, listener, stopped)))
            .map_err(|error| start(error.to_string()))?;
        Ok(Self { address, feed, shared, words: Some(words), stop: Some(stop), thread: Some(thread) })
    }

    /// Where the page is, with the token: who opens it may give orders, where orders are taken.
    pub fn url(&self) -> String {
        format!("{}#{}", self.url_to_watch(), self.shared.token.digits())
    }

    /// Where the page is, without the token: who opens it can only watch.
    pub fn url_to_watch(&self) -> String {
        let host = match self.address.ip() {
            ip if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
            ip => ip,
        };
        format!("http://{}/", SocketAddr::new(host, self.address.port()))
    }

    /// Takes what the flight has to tell.
    pub fn feed(&self) -> Feed {
        self.feed.clone()
    }

    /// The operator's words; only the first who asks gets them. Where nobody does, they are refused.
    pub fn take_words(&mut self) -> Option<mpsc::Receiver<Said>> {
        self.words.take()
    }

    /// How many requests were refused so far.
    pub fn refused(&self) -> Refused {
        self.shared.lock().refused
    }

    /// How many pages are open.
    pub fn pages(&self) -> usize {
        *self.shared.pages.borrow()
    }
}

impl Drop for LiveView {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the looks at the feed and the pages share, all on one thread but for a few counters.
#[derive(Debug)]
pub(crate) struct Shared {
    pub token: Token,
    pub port: u16,
    /// What is played back, where the page is no live one.
    pub tape: Option<Tape>,
    pub say: mpsc::Sender<Said>,
    published: Mutex<Published>,
    /// Counts looks.
    pub news: watch::Sender<u64>,
    /// How many pages are open.
    pub pages: watch::Sender<usize>,
}

/// What pages are sent.
#[derive(Debug, Default)]
pub(crate) struct Published {
    /// Each with the count of the look that made it.
    pub scene: (u64, Bytes),
    pub roster: (u64, Bytes),
    pub summary: (u64, Bytes),
    pub frame: (u64, Bytes),
    pub events: Vec<Event>,
    pub choices: Choices,
    pub history: VecDeque<Bytes>,
    history_bytes: usize,
    refused: Refused,
    /// Which vehicle a page looks at.
    looks: BTreeMap<SocketAddr, u32>,
    pub is_over: bool,
}

impl Shared {
    pub fn lock(&self) -> MutexGuard<'_, Published> {
        self.published.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn refuse(&self, count: impl FnOnce(&mut Refused)) {
        count(&mut self.lock().refused);
    }

    /// A page looks at a vehicle, or at none.
    pub fn look(&self, page: SocketAddr, vehicle: Option<u32>) {
        let mut published = self.lock();
        match vehicle {
            Some(number) => published.looks.insert(page, number),
            None => published.looks.remove(&page),
        };
    }
}

/// Looks, and serves, until it is to stop.
async fn run(shared: Arc<Shared>, feed: FeedReader, listener: TcpListener, stopped: oneshot::Receiver<()>) {
    let listener = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => return tracing::error!(%error, "the page cannot be served"),
    };
    let of_server = Arc::clone(&shared);
    let served = tokio::spawn(async move { axum::serve(Bounded::new(listener), crate::http::router(of_server)).await });
    tokio::select! {
        () = look_again_and_again(&shared, &feed) => {}
        _ = stopped => {}
    }
    shared.lock().is_over = true;
    shared.news.send_modify(|count| *count += 1);
    let all_gone = async { shared.pages.subscribe().wait_for(|pages| *pages == 0).await.is_ok() };
    let _ = tokio::time::timeout(GOODBYE, all_gone).await;
    served.abort();
}

async fn look_again_and_again(shared: &Shared, feed: &FeedReader) {
    let mut looker = Looker::default();
    let mut scene = Scene::default();
    let mut kept: Option<Instant> = None;
    let mut before: Option<Frame> = None;
    let mut next = tokio::time::Instant::now();
    for count in 0_u64.. {
        let frame = feed.latest();
        let news = feed.take_news();
        let now = Instant::now();
        let is_new_scene = news.scene.is_some();
        scene = news.scene.unwrap_or(scene);
        let has_status = frame.vehicles.len() <= FINE_MAX || count.is_multiple_of(STATUS_EVERY);
        let look = looker.look(&frame, &scene, now, has_status);
        {
            let mut published = shared.lock();
            let published = &mut *published;
            if is_new_scene || count == 0 {
                published.scene = (count + 1, json("scene", &scene));
            }
            if look.has_new_roster {
                published.roster = (count + 1, json("roster", looker.roster()));
            }
            published.events.extend(news.events);
            published.events.extend(look.events);
            news.choices.iter().for_each(|choice| published.choices.push(choice));
            feed.watch(published.looks.values().copied().collect());
            if has_status {
                let summary = Summary {
                    phase: &frame.phase,
                    least: looker.least(&frame),
                    pages: *shared.pages.borrow(),
                    refused: published.refused,
                };
                let bytes = json("summary", &summary);
                if bytes != published.summary.1 {
                    published.summary = (count + 1, bytes);
                }
            }
            // Silence goes on while nothing else does: a frame is sent even if the flight has told nothing new.
            let has_moved = before.as_ref().is_none_or(|before| before.time_s != frame.time_s);
            let is_due = kept.is_none_or(|kept| now.saturating_duration_since(kept) >= HISTORY_STEP);
            if has_status && is_due && has_moved && !frame.vehicles.is_empty() {
                kept = Some(now);
                published.remember(&look.bytes);
            }
            published.frame = (count + 1, Bytes::from(look.bytes));
            before = Some(frame);
        }
        shared.news.send_replace(count + 1);
        next += if *shared.pages.borrow() > 0 { LOOK } else { LOOK_UNSEEN };
        next = next.max(tokio::time::Instant::now());
        let mut pages = shared.pages.subscribe();
        tokio::select! {
            () = tokio::time::sleep_until(next) => {}
            // A page that opens is shown the present at once.
            _ = pages.changed() => {}
        }
    }
}

impl Published {
    fn remember(&mut self, frame: &[u8]) {
        let mut bytes = frame.to_vec();
        if let Some(bits) = bytes.get_mut(BITS_AT) {
            *bits |= HISTORY;
        }
        self.history_bytes += bytes.len();
        self.history.push_back(Bytes::from(bytes));
        while self.history_bytes > HISTORY_BYTES_MAX {
            let Some(oldest) = self.history.pop_front() else { break };
            self.history_bytes -= oldest.len();
        }
    }
}

/// What is said of the flight as a whole.
#[derive(Serialize)]
struct Summary<'a> {
    phase: &'a str,
    least: LeastSoFar<'a>,
    pages: usize,
    refused: Refused,
}

/// An object of one name, for a page.
pub(crate) fn json(name: &str, value: &impl Serialize) -> Bytes {
    let value = serde_json::to_value(value).unwrap_or_default();
    Bytes::from(serde_json::json!({ name: value }).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_that_stands_still_holds_up_no_flight() {
        let view = LiveView::start(&Settings::default()).unwrap();
        let feed = view.feed();
        // The page's thread waits for this lock at its next look, and with it every page, stuck or not.
        let still = view.shared.lock();
        let scene = |tick: u32| Scene { title: format!("tick {tick}"), ..Scene::default() };
        let mut done = 0;
        for tick in 0..20_000 {
            done += u32::from(feed.update(|frame| frame.time_s = f64::from(tick)));
            feed.tell(Event { at_s: f64::from(tick), ..Event::default() });
            feed.scene(scene(tick));
            let _ = feed.watched();
        }
        assert!(done > 19_000, "only while a frame is copied is one left out: {done}");
        drop(still);
        let deadline = Instant::now() + Duration::from_secs(30);
        while view.shared.lock().events.len() < 20_000 {
            assert!(Instant::now() < deadline, "the page is told all of it afterwards");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
