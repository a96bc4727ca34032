//! A link that is down is tried again.

use super::event::{Events, LinkEvent, Send};
use std::time::Duration;
use tokio::sync::mpsc;

/// A link that is down is tried again after this.
pub(super) const RETRY: Duration = Duration::from_millis(500);

/// A link is down: says why, once for each reason, and waits until it is to be tried again. What was to be sent
/// meanwhile is out of date then, and thrown away. False when nobody wants the link any more.
pub(super) async fn wait_to_retry(
    link: usize,
    reason: String,
    told: &mut Option<String>,
    taker: &mut mpsc::Receiver<Send>,
    tell: &Events,
) -> bool {
    if told.as_ref() != Some(&reason) {
        if tell.send(LinkEvent::Down(link, reason.clone())).is_err() {
            return false;
        }
        *told = Some(reason);
    }
    let again = tokio::time::sleep(RETRY);
    tokio::pin!(again);
    loop {
        tokio::select! {
            () = &mut again => return true,
            wanted = taker.recv() => if wanted.is_none() { return false },
        }
    }
}
