//! The page's server: a thread of its own, which serves the page and publishes what the flight tells.

use crate::connections::Bounded;
use crate::feed::{Feed, FeedReader, feed};
use crate::guard::{Refused, Token};
use crate::http::router;
use crate::publisher::look_again_and_again;
use crate::shared::{Said, Shared};
use crate::tape::Tape;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};

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
        let token = Token::new().map_err(|error| start(error.to_string()))?;
        let (shared, words) = Shared::new(token, address.port(), tape);
        let shared = Arc::new(shared);
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
        format!("{}#{}", self.url_to_watch(), self.shared.token().digits())
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
        self.shared.refused()
    }

    /// How many pages are open.
    pub fn pages(&self) -> usize {
        *self.shared.pages().borrow()
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

/// Looks, and serves, until it is to stop.
async fn run(shared: Arc<Shared>, feed: FeedReader, listener: TcpListener, stopped: oneshot::Receiver<()>) {
    let listener = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => return tracing::error!(%error, "the page cannot be served"),
    };
    let of_server = Arc::clone(&shared);
    let served = tokio::spawn(async move { axum::serve(Bounded::new(listener), router(of_server)).await });
    tokio::select! {
        () = look_again_and_again(&shared, &feed) => {}
        _ = stopped => {}
    }
    shared.published().end();
    shared.announce();
    let mut pages = shared.pages();
    let all_gone = pages.wait_for(|pages| *pages == 0);
    let _ = tokio::time::timeout(GOODBYE, all_gone).await;
    served.abort();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::Sent;
    use crate::scene::{Event, Scene};
    use std::time::Instant;

    /// How many events a page that opens now is told.
    fn told(view: &LiveView) -> usize {
        let messages = view.shared.published().unsent(&mut Sent::default(), None, true);
        let of_text = messages.iter().filter_map(|message| message.to_text().ok());
        of_text.map(|text| text.matches("\"at_s\"").count()).sum()
    }

    #[test]
    fn a_server_that_stands_still_holds_up_no_flight() {
        let view = LiveView::start(&Settings::default()).unwrap();
        let feed = view.feed();
        // The page's thread waits for this lock at its next look, and with it every page, stuck or not.
        let still = view.shared.published();
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
        while told(&view) < 20_000 {
            assert!(Instant::now() < deadline, "the page is told all of it afterwards");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
