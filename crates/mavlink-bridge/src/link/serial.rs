//! Serial lines: radios and cables. A port that goes away, as a USB cable does, is opened again when it is back.

use super::event::{Arrival, Events, LinkEvent, Peer, Send};
use super::retry::wait_to_retry;
use serial2_tokio::SerialPort;
use std::time::Instant;
use tokio::sync::mpsc;

/// Keeps a serial port open.
pub(super) async fn run(link: usize, device: String, baud: u32, mut taker: mpsc::Receiver<Send>, tell: Events) {
    let mut told = None;
    loop {
        let reason = match SerialPort::open(&device, baud) {
            Ok(port) => {
                told = None;
                let _ = tell.send(LinkEvent::Up(link));
                match exchange(link, &port, &mut taker, &tell).await {
                    Some(reason) => reason,
                    None => return,
                }
            }
            Err(error) => error.to_string(),
        };
        if !wait_to_retry(link, reason, &mut told, &mut taker, &tell).await {
            return;
        }
    }
}

/// Reads and writes until the port fails, and says why; none when nobody wants it any more.
async fn exchange(link: usize, port: &SerialPort, taker: &mut mpsc::Receiver<Send>, tell: &Events) -> Option<String> {
    let reading = async {
        let mut buffer = vec![0; 4096];
        loop {
            match port.read(&mut buffer).await {
                Ok(0) => return Some("the port is closed".to_owned()),
                Ok(length) => {
                    let bytes = buffer[..length].to_vec();
                    let arrival = Arrival { link, peer: Peer::Only, at: Instant::now(), bytes, is_stream: true };
                    if tell.send(LinkEvent::Arrival(arrival)).is_err() {
                        return None;
                    }
                }
                Err(error) => return Some(error.to_string()),
            }
        }
    };
    let writing = async {
        while let Some((_, bytes)) = taker.recv().await {
            if let Err(error) = port.write_all(&bytes).await {
                return Some(error.to_string());
            }
        }
        None
    };
    tokio::select! {
        ended = reading => ended,
        ended = writing => ended,
    }
}
