//! The connection of one browser: what it is sent, and what it says.

use crate::connections::Peer;
use crate::published::{Sent, text};
use crate::shared::{Answer, Place, Said, Shared};
use crate::tape::Wound;
use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{ConnectInfo, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// The longest word of a page, bytes.
const WORD_MAX: usize = 4096;
/// A page is asked so often whether it is there: of a recording that was sent there is nothing more to send.
const ASK_EVERY: Duration = Duration::from_secs(10);
/// A page that takes nothing for so long is let go.
const SEND_PATIENCE: Duration = Duration::from_secs(10);

/// Opens the connection of a page.
pub async fn live(
    upgrade: WebSocketUpgrade,
    ConnectInfo(Peer(from)): ConnectInfo<Peer>,
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Response {
    let Some(place) = Place::take(&shared) else {
        shared.refuse(|refused| refused.full += 1);
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    };
    tracing::debug!(%from, agent = ?headers.get(header::USER_AGENT), "a page opens");
    upgrade.max_message_size(WORD_MAX).max_frame_size(WORD_MAX).on_upgrade(move |socket| async move {
        let page = Page { socket, from, shared: Arc::clone(&shared), sent: Sent::default(), parts: 0, looks_at: None };
        let end = page.attend().await;
        shared.look(from, None);
        drop(place);
        tracing::debug!(%from, end, "a page is gone");
    })
}

/// A browser.
struct Page {
    socket: WebSocket,
    from: SocketAddr,
    shared: Arc<Shared>,
    sent: Sent,
    /// How many parts of a recording it has been sent.
    parts: usize,
    /// Number of the vehicle whose choices it is sent.
    looks_at: Option<u32>,
}

/// What a page says: the words of an operator, with the token; or, which anybody may say, which vehicle it looks at.
#[derive(Deserialize)]
struct Word {
    /// The token of the address.
    token: Option<String>,
    /// Words of the operator; with a token alone, the page asks whether that is right.
    say: Option<String>,
    /// Comes back with the answer.
    #[serde(default)]
    id: u64,
    /// The number of the vehicle that it looks at, if any.
    look: Option<u32>,
}

impl Page {
    /// Sends what is new and hears what is said, until the page is gone; gives the reason.
    async fn attend(mut self) -> &'static str {
        let mut news = self.shared.news();
        news.mark_changed();
        let tape = self.shared.tape().cloned().unwrap_or_default();
        let mut wound = tape.subscribe();
        wound.mark_changed();
        loop {
            tokio::select! {
                _ = wound.changed() => {
                    if let Err(reason) = self.send_recording(&mut wound).await {
                        return reason;
                    }
                }
                () = tokio::time::sleep(ASK_EVERY) => {
                    if let Err(reason) = self.send(Message::Ping(Bytes::new())).await {
                        return reason;
                    }
                }
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
                        let answer = self.hear(text.as_str()).await;
                        if let Some(answer) = answer
                            && let Err(reason) = self.send(Message::Text(answer.into())).await
                        {
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

    /// Sends what was read of a recording since.
    async fn send_recording(&mut self, wound: &mut watch::Receiver<Wound>) -> Result<(), &'static str> {
        let (head, parts) = {
            let wound = wound.borrow_and_update();
            let Some(head) = &wound.head else { return Ok(()) };
            (text(head), wound.parts[self.parts..].to_vec())
        };
        self.send(head).await?;
        for part in parts {
            self.send(Message::Binary(part)).await?;
            self.parts += 1;
        }
        Ok(())
    }

    /// Sends what the page has not seen: of the frames only the newest.
    async fn send_news(&mut self) -> Result<(), &'static str> {
        let is_live = self.shared.tape().is_none();
        let (messages, is_over) = {
            let published = self.shared.published();
            (published.unsent(&mut self.sent, self.looks_at, is_live), published.is_over())
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

    /// Hears a word, and gives the answer as JSON, if it has one.
    async fn hear(&mut self, text: &str) -> Option<String> {
        let Ok(word) = serde_json::from_str::<Word>(text) else {
            return Some(refusal(0, "not understood: must be {\"token\": ..., \"say\": ...}"));
        };
        if word.token.is_none() && word.say.is_none() {
            self.look_at(word.look);
            return None;
        }
        let shared = &self.shared;
        if !shared.token().is(word.token.as_deref().unwrap_or_default()) {
            shared.refuse(|counts| counts.token += 1);
            tracing::warn!(from = %self.from, say = ?word.say, "a word without the right token is refused");
            let text = "refused: the address has no token, or another program's; open the printed address";
            return Some(refusal(word.id, text));
        }
        let Some(say) = word.say else { return Some(serde_json::json!({"may": true}).to_string()) };
        let (answer, answered) = oneshot::channel();
        if !shared.say(Said { text: say, from: self.from, answer }) {
            return Some(refusal(word.id, "nothing here takes orders"));
        }
        Some(match tokio::time::timeout(SEND_PATIENCE, answered).await {
            Ok(Ok(answer)) => answered_json(word.id, &answer),
            _ => refusal(word.id, "not answered: the flight may be over"),
        })
    }

    /// It is sent the choices of another vehicle, from the first that is known.
    fn look_at(&mut self, vehicle: Option<u32>) {
        self.looks_at = vehicle;
        self.sent.forget_choices();
        self.shared.look(self.from, vehicle);
    }
}

fn answered_json(id: u64, Answer { is_done, text }: &Answer) -> String {
    serde_json::json!({"answer": {"id": id, "is_done": is_done, "text": text}}).to_string()
}

fn refusal(id: u64, text: &str) -> String {
    answered_json(id, &Answer { is_done: false, text: text.to_owned() })
}
