//! The page's server: a thread of its own, which looks at the feed and sends each browser what is new.

use crate::assets;
use crate::feed::Feed;
use crate::guard::{Refusal, Refused, Token, admit};
use crate::look::{LeastSoFar, Looker};
use crate::recording::Recording;
use crate::scene::{Event, Frame, Scene};
use crate::wire::{BITS_AT, FINE_MAX, HISTORY};
use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{ConnectInfo, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
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
/// The longest word of a page, bytes.
const WORD_MAX: usize = 4096;
/// Pages at once.
const PAGES_MAX: usize = 32;
/// A page that takes nothing for so long is let go.
const SEND_PATIENCE: Duration = Duration::from_secs(10);
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

    /// Serves a page that plays a recording back.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn play(settings: &Settings, recording: Recording) -> Result<Self, ViewError> {
        Self::serve(settings, Some(recording))
    }

    fn serve(settings: &Settings, recording: Option<Recording>) -> Result<Self, ViewError> {
        let start = |reason: String| ViewError::Start(reason);
        let asked = SocketAddr::new(settings.host, settings.port);
        let bind = |source| ViewError::Bind { address: asked, source };
        let listener = TcpListener::bind(asked).map_err(bind)?;
        listener.set_nonblocking(true).map_err(bind)?;
        let address = listener.local_addr().map_err(bind)?;
        let recording = match recording {
            None => None,
            Some(recording) => {
                let head = recording.head().map_err(|error| start(error.to_string()))?;
                Some((head, Bytes::copy_from_slice(recording.frames())))
            }
        };
        let feed = Feed::default();
        let (say, words) = mpsc::channel(64);
        let shared = Arc::new(Shared {
            token: Token::new().map_err(|error| start(error.to_string()))?,
            port: address.port(),
            recording,
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
        let (of_thread, feed_of_thread) = (Arc::clone(&shared), feed.clone());
        let thread = std::thread::Builder::new()
            .name("live-view".to_owned())
            .spawn(move || runtime.block_on(run(of_thread, feed_of_thread, listener, stopped)))
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
struct Shared {
    token: Token,
    port: u16,
    /// Head and frames.
    recording: Option<(String, Bytes)>,
    say: mpsc::Sender<Said>,
    published: Mutex<Published>,
    /// Counts looks.
    news: watch::Sender<u64>,
    /// How many pages are open.
    pages: watch::Sender<usize>,
}

/// What pages are sent.
#[derive(Debug, Default)]
struct Published {
    scene: (u64, Bytes),
    roster: (u64, Bytes),
    summary: (u64, Bytes),
    frame: (u64, Bytes),
    events: Vec<Event>,
    history: VecDeque<Bytes>,
    history_bytes: usize,
    refused: Refused,
    is_over: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Published> {
        self.published.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn refuse(&self, count: impl FnOnce(&mut Refused)) {
        count(&mut self.lock().refused);
    }
}

/// Looks, and serves, until it is to stop.
async fn run(shared: Arc<Shared>, feed: Feed, listener: TcpListener, stopped: oneshot::Receiver<()>) {
    let listener = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => return tracing::error!(%error, "the page cannot be served"),
    };
    let of_server = Arc::clone(&shared);
    let served = tokio::spawn(async move { axum::serve(listener, router(of_server)).await });
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

async fn look_again_and_again(shared: &Shared, feed: &Feed) {
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
fn json(name: &str, value: &impl Serialize) -> Bytes {
    let value = serde_json::to_value(value).unwrap_or_default();
    Bytes::from(serde_json::json!({ name: value }).to_string())
}

fn router(shared: Arc<Shared>) -> axum::extract::connect_info::IntoMakeServiceWithConnectInfo<Router, SocketAddr> {
    let guard = middleware::from_fn_with_state(Arc::clone(&shared), guarded);
    Router::new()
        .route("/live", get(live))
        .route("/recording.json", get(recording_head))
        .route("/recording.bin", get(recording_frames))
        .fallback(get(asset))
        .layer(guard)
        .with_state(shared)
        .into_make_service_with_connect_info()
}

/// Lets requests in, or not, and says to browsers what the page may do: nothing beyond this server.
async fn guarded(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = match admit(request.headers(), shared.port) {
        Ok(()) => next.run(request).await,
        Err(refusal) => {
            tracing::warn!(?refusal, "a request for the page is refused");
            shared.refuse(|refused| match refusal {
                Refusal::Host => refused.host += 1,
                Refusal::Origin => refused.origin += 1,
            });
            (StatusCode::FORBIDDEN, "refused: this page is for its own address only\n").into_response()
        }
    };
    const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
                          connect-src 'self' ws:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    let headers = response.headers_mut();
    let mut set = |name: HeaderName, value| headers.insert(name, HeaderValue::from_static(value));
    set(header::CONTENT_SECURITY_POLICY, POLICY);
    set(header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    set(header::REFERRER_POLICY, "no-referrer");
    set(header::CACHE_CONTROL, "no-store");
    set(HeaderName::from_static("cross-origin-resource-policy"), "same-origin");
    response
}

async fn asset(uri: Uri) -> Response {
    match assets::find(uri.path()) {
        Some(asset) => ([(header::CONTENT_TYPE, asset.content_type)], asset.bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is nothing here\n").into_response(),
    }
}

async fn recording_head(State(shared): State<Arc<Shared>>) -> Response {
    match &shared.recording {
        Some((head, _)) => ([(header::CONTENT_TYPE, "application/json")], head.clone()).into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

async fn recording_frames(State(shared): State<Arc<Shared>>) -> Response {
    match &shared.recording {
        Some((_, frames)) => ([(header::CONTENT_TYPE, "application/octet-stream")], frames.clone()).into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

async fn live(
    upgrade: WebSocketUpgrade,
    ConnectInfo(from): ConnectInfo<SocketAddr>,
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Response {
    if *shared.pages.borrow() >= PAGES_MAX {
        shared.refuse(|refused| refused.full += 1);
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    }
    tracing::debug!(%from, agent = ?headers.get(header::USER_AGENT), "a page opens");
    upgrade.max_message_size(WORD_MAX).max_frame_size(WORD_MAX).on_upgrade(move |socket| async move {
        shared.pages.send_modify(|pages| *pages += 1);
        let end = Page { socket, from, shared: Arc::clone(&shared), sent: Sent::default() }.attend().await;
        shared.pages.send_modify(|pages| *pages -= 1);
        tracing::debug!(%from, end, "a page is gone");
    })
}

/// What a page has been sent.
#[derive(Debug, Default)]
struct Sent {
    scene: u64,
    roster: u64,
    summary: u64,
    frame: u64,
    events: usize,
    has_history: bool,
}

/// A browser.
struct Page {
    socket: WebSocket,
    from: SocketAddr,
    shared: Arc<Shared>,
    sent: Sent,
}

/// What a page says.
#[derive(Deserialize)]
struct Word {
    /// The token of the address.
    token: String,
    /// Words of the operator; without any, the page asks whether its token is right.
    say: Option<String>,
    /// Comes back with the answer.
    #[serde(default)]
    id: u64,
}

impl Page {
    /// Sends what is new and hears what is said, until the page is gone; gives the reason.
    async fn attend(mut self) -> &'static str {
        let mut news = self.shared.news.subscribe();
        news.mark_changed();
        loop {
            tokio::select! {
                changed = news.changed() => {
                    if changed.is_err() {
                        return "the program ends";
                    }
                    if let Err(reason) = self.send_news().await {
                        return reason;
                    }
                }
                heard = self.socket.recv() => match heard {
                    Some(Ok(Message::Text(text))) => {
                        let answer = hear(&self.shared, self.from, text.as_str()).await;
                        if let Err(reason) = self.send(Message::Text(answer.into())).await {
                            return reason;
                        }
                    }
                    Some(Ok(Message::Close(_))) | None => return "closed",
                    Some(Ok(_)) => {}
                    Some(Err(_)) => return "broken, or too long a message",
                },
            }
        }
    }

    /// Sends what the page has not seen: of the frames only the newest.
    async fn send_news(&mut self) -> Result<(), &'static str> {
        let mut messages = Vec::new();
        let is_over = {
            let published = self.shared.lock();
            let text = |bytes: &Bytes| Message::Text(String::from_utf8_lossy(bytes).into_owned().into());
            let sent = &mut self.sent;
            for (known, (version, bytes)) in [
                (&mut sent.scene, &published.scene),
                (&mut sent.roster, &published.roster),
                (&mut sent.summary, &published.summary),
            ] {
                if known != version {
                    *known = *version;
                    messages.push(text(bytes));
                }
            }
            if !std::mem::replace(&mut sent.has_history, true) {
                messages.extend(published.history.iter().cloned().map(Message::Binary));
            }
            if sent.events < published.events.len() {
                messages.push(text(&json("told", &&published.events[sent.events..])));
                sent.events = published.events.len();
            }
            if sent.frame != published.frame.0 {
                sent.frame = published.frame.0;
                messages.push(Message::Binary(published.frame.1.clone()));
            }
            published.is_over
        };
        for message in messages {
            self.send(message).await?;
        }
        if is_over {
            self.send(Message::Text("{\"over\":true}".into())).await?;
            let _ = self.send(Message::Close(None)).await;
            return Err("the program ends");
        }
        Ok(())
    }

    /// Waits until the system has taken a message, and not for ever.
    async fn send(&mut self, message: Message) -> Result<(), &'static str> {
        match tokio::time::timeout(SEND_PATIENCE, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err("broken"),
            Err(_) => Err("it has taken nothing for too long"),
        }
    }
}

/// Hears a word, and gives the answer as JSON.
async fn hear(shared: &Shared, from: SocketAddr, text: &str) -> String {
    let refused = |id: u64, text: &str| {
        let answer = Answer { is_done: false, text: text.to_owned() };
        serde_json::json!({"answer": {"id": id, "is_done": answer.is_done, "text": answer.text}}).to_string()
    };
    let Ok(word) = serde_json::from_str::<Word>(text) else {
        return refused(0, "not understood: must be {\"token\": ..., \"say\": ...}");
    };
    if !shared.token.is(&word.token) {
        shared.refuse(|counts| counts.token += 1);
        tracing::warn!(from = %from, say = ?word.say, "a word without the right token is refused");
        return refused(word.id, "refused: the address has no token, or another program's; open the printed address");
    }
    let Some(say) = word.say else { return serde_json::json!({"may": true}).to_string() };
    let (answer, answered) = oneshot::channel();
    let said = Said { text: say, from, answer };
    if shared.say.try_send(said).is_err() {
        return refused(word.id, "nothing here takes orders");
    }
    match tokio::time::timeout(SEND_PATIENCE, answered).await {
        Ok(Ok(Answer { is_done, text })) => {
            serde_json::json!({"answer": {"id": word.id, "is_done": is_done, "text": text}}).to_string()
        }
        _ => refused(word.id, "not answered: the flight may be over"),
    }
}
