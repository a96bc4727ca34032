//! A recording while it is being read: one thread adds what it has read, and pages play what is there.

use crate::recording::{Head, Recording};
use axum::body::Bytes;
use serde::Serialize;
use std::sync::Arc;
use tokio::sync::watch;

/// So many bytes of frames go to a page in one message.
const PART_BYTES: usize = 256 << 10;

/// What was read of a recording so far. Clones are of the same.
#[derive(Clone, Debug)]
pub struct Tape(Arc<watch::Sender<Wound>>);

/// What pages are sent.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wound {
    /// The scene, the roster, the events and how much was read, as JSON; none at first.
    pub head: Option<Bytes>,
    /// Frames, each with its length before it, many in a part.
    pub parts: Vec<Bytes>,
}

/// How much of a recording was read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// The part, 0 to 1; 1 is all.
    pub read: f64,
    /// How long the whole is, s of flight time.
    pub duration_s: f64,
}

#[derive(Serialize)]
struct Message<'a> {
    recording: Known<'a>,
}

#[derive(Serialize)]
struct Known<'a> {
    #[serde(flatten)]
    head: Head<'a>,
    #[serde(flatten)]
    progress: Progress,
}

impl Default for Tape {
    fn default() -> Self {
        Self(Arc::new(watch::channel(Wound::default()).0))
    }
}

impl Tape {
    /// Adds the frames that a recording has gathered since, with what is known by now.
    ///
    /// # Errors
    /// A number of the scene is none.
    pub fn wind(&self, recording: &mut Recording, progress: Progress) -> Result<(), serde_json::Error> {
        let known = Known { head: recording.head(), progress };
        let head = Bytes::from(serde_json::to_vec(&Message { recording: known })?);
        let frames = Bytes::from(recording.take_frames());
        self.0.send_modify(|wound| {
            wound.head = Some(head);
            wound.parts.extend(parts(&frames));
        });
        Ok(())
    }

    /// What is known by now, as pages are told it: JSON; none at first.
    pub fn head(&self) -> Option<String> {
        self.0.borrow().head.as_ref().map(|head| String::from_utf8_lossy(head).into_owned())
    }

    /// The frames by now: each with its length before it, four bytes, little-endian.
    pub fn frames(&self) -> Vec<u8> {
        self.0.borrow().parts.concat()
    }

    pub(crate) fn subscribe(&self) -> watch::Receiver<Wound> {
        self.0.subscribe()
    }
}

/// Frames in parts of some [`PART_BYTES`]; no frame is torn.
fn parts(frames: &Bytes) -> Vec<Bytes> {
    let (mut parts, mut from, mut at) = (Vec::new(), 0, 0);
    while let Some(length) = frames.get(at..at + 4) {
        at += 4 + u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
        if at - from >= PART_BYTES || at >= frames.len() {
            parts.push(frames.slice(from..at.min(frames.len())));
            from = at;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Frame, Scene, VehicleNow};

    #[test]
    fn parts_hold_all_frames_in_order_and_whole() {
        let (tape, mut recording) = (Tape::default(), Recording::new(Scene::default()));
        let mut all = Vec::new();
        for stretch in 0..3 {
            for frame in 0..300 {
                let vehicles = vec![VehicleNow { x_m: 1.0, y_m: 2.0, ..VehicleNow::default() }; 100];
                let time_s = f64::from(300 * stretch + frame);
                recording.push(Frame { time_s, vehicles, ..Frame::default() });
            }
            let progress = Progress { read: f64::from(stretch + 1) / 3.0, duration_s: 900.0 };
            tape.wind(&mut recording, progress).unwrap();
            all.push(tape.subscribe().borrow().parts.len());
        }
        let wound = tape.subscribe().borrow().clone();
        assert!(all[0] >= 2 && all[2] == wound.parts.len(), "{all:?}");
        let mut times = Vec::new();
        for part in &wound.parts {
            assert!(part.len() < 2 * PART_BYTES);
            let mut at = 0;
            while at < part.len() {
                let length = u32::from_le_bytes(part[at..at + 4].try_into().unwrap()) as usize;
                times.push(crate::wire::places(&part[at + 4..at + 4 + length]).unwrap().time_s);
                at += 4 + length;
            }
            assert_eq!(at, part.len());
        }
        assert_eq!(times, (0..900).map(f64::from).collect::<Vec<_>>());
        let head: serde_json::Value = serde_json::from_slice(&wound.head.unwrap()).unwrap();
        assert_eq!(head["recording"]["read"], 1.0);
        assert_eq!(head["recording"]["roster"]["numbers"].as_array().unwrap().len(), 100);
    }
}
