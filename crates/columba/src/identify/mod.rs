//! System identification: which Eq. 1 a vehicle answers its commands by, from a flight that is recorded.
//!
//! [`recording`] finds commands and responses in a tlog, [`responses`] cuts them into single responses, [`fit`] finds
//! the constants that explain them, [`words`] says what is known and what is not, and writes an airframe file.
//! [`flight`] is a flight that has such responses in it. All of it is sans-I/O.

pub mod fit;
pub mod flight;
pub mod recording;
pub mod responses;
mod simplex;
pub mod words;

use fit::{Altitude, Course, Speed, TurnShare};
use mavlink_bridge::TlogRecord;
use recording::Recording;
use std::collections::BTreeMap;

/// What is known of a vehicle.
#[derive(Clone, Debug)]
pub struct Identified {
    /// MAVLink system id.
    pub system_id: u8,
    /// Whether it is an aircraft with wings.
    pub has_wings: bool,
    /// Its speed loop; why not, otherwise.
    pub speed: Result<Speed, String>,
    /// Its course loop in turns of at most 50 degrees.
    pub course: Result<Course, String>,
    /// The same in harder turns, where Eq. 1 is not expected to hold.
    pub hard_course: Option<Course>,
    /// How hard it turns with its bank; none: bank and turns were not heard together.
    pub turn_share: Option<TurnShare>,
    /// Its altitude loop.
    pub altitude: Result<Altitude, String>,
    /// What else the reader is to know.
    pub notes: Vec<String>,
}

/// Identifies every vehicle that a log has commands for, by system id. Records that are no frames are passed over.
pub fn identify<'a>(records: impl IntoIterator<Item = &'a TlogRecord>) -> Vec<Identified> {
    let recordings: BTreeMap<u8, Recording> = recording::read(records);
    recordings.into_iter().filter(|(_, recording)| recording.is_commanded()).map(|(id, it)| one(id, &it)).collect()
}

fn one(system_id: u8, recording: &Recording) -> Identified {
    let mut notes = Vec::new();
    if let Some(rate_hz) = recording.rate_hz().filter(|rate_hz| *rate_hz < 4.0) {
        notes.push(format!("positions came at {rate_hz:.1} Hz: dead times are known to about half of their distance"));
    }
    let refused = recording.refused;
    if refused > 0 {
        notes.push(format!("{refused} commands were refused and are left out"));
    }
    let course = fit::course(recording, 0.0..50.0, &mut notes);
    let hard_course = fit::course(recording, 50.0..180.0, &mut Vec::new()).ok();
    let turn_share = fit::turn_share(recording);
    let speed = fit::speed(recording, &mut notes);
    let altitude = fit::altitude(recording, &mut notes);
    Identified { system_id, has_wings: recording.has_wings, speed, course, hard_course, turn_share, altitude, notes }
}

#[cfg(test)]
mod tests;
