//! One log: what is a record in it, and what its records say of vehicles.

use super::clock::Clock;
use crate::station::vehicle::place;
use crate::view::heard::{Flock, SHOWN};
use flight_model::{LocalFrame, State};
use live_view::{Event, Outline, VehicleNow, Wind};
use mavlink_bridge::dialect::Message;
use mavlink_bridge::{Frame, is_autopilot};
use std::collections::BTreeSet;
use std::time::Duration;

const TIME: usize = 8;
const HEARTBEAT: u32 = 0;
const LOCAL_POSITION_NED: u32 = 32;
/// Messages with a position: LOCAL_POSITION_NED, GLOBAL_POSITION_INT.
const POSITIONS: [u32; 2] = [LOCAL_POSITION_NED, 33];

/// A telemetry log, which is read from its beginning to its end.
pub struct Log {
    bytes: Vec<u8>,
    /// Where the next record is.
    at: usize,
    clock: Clock,
    flock: Flock<()>,
    samples: Vec<Vec<Sample>>,
    survey: Survey,
    is_whole: bool,
}

/// A vehicle as it said that it was.
pub struct Sample {
    pub at_us: u64,
    pub state: State,
    pub shown: VehicleNow,
}

/// What a log holds, before anything but its heartbeats is read.
#[derive(Clone, Default)]
pub struct Survey {
    /// The first and the last record, microseconds since the Unix epoch.
    pub span_us: (u64, u64),
    /// Records.
    pub records: u64,
    /// Bytes between them that are no record.
    pub skipped_bytes: u64,
    /// Its clock, with the jumps.
    pub clock: Clock,
    /// System ids of autopilots.
    pub autopilots: BTreeSet<u8>,
    has_positions: bool,
}

/// Why a file cannot be played.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotALog {
    /// PX4's own format.
    #[error(
        "is a ULog, as PX4 writes on board: must be a telemetry log (tlog), as ground stations write (QGroundControl, \
         MAVProxy, Mission Planner, Columba)"
    )]
    ULog,
    /// ArduPilot's own format.
    #[error(
        "is a dataflash log, as ArduPilot writes on board: must be a telemetry log (tlog), as ground stations write \
         (MAVProxy, Mission Planner, QGroundControl, Columba)"
    )]
    Dataflash,
    /// MAVLink without the times of records.
    #[error("is MAVLink without times (as MAVProxy's .tlog.raw): must be a telemetry log (tlog), which has them")]
    Raw,
    /// No record of MAVLink.
    #[error("must be a telemetry log (tlog): it has no records of MAVLink")]
    Nothing,
    /// Records of others.
    #[error("must be a telemetry log (tlog) of at least one autopilot: no heartbeat of one is in its {0} records")]
    NoAutopilot(u64),
    /// Nobody knows where its vehicles were.
    #[error(
        "must tell where vehicles are: none of its {0} records is a GLOBAL_POSITION_INT with a fix or a \
         LOCAL_POSITION_NED"
    )]
    NoPositions(u64),
}

impl Log {
    /// Looks through a log, which takes some 0.1 s for 100 MB.
    ///
    /// # Errors
    /// It is none, or nothing of it can be shown.
    pub fn open(bytes: Vec<u8>) -> Result<Self, NotALog> {
        // A record begins with its time, which is no frame. Without times nothing is a record, whatever looks like one.
        if Frame::parse(&bytes).is_ok() {
            return Err(NotALog::Raw);
        }
        let survey = Survey::of(&bytes);
        match &survey {
            Survey { records: 0, .. } => return Err(what_is(&bytes)),
            Survey { records, autopilots, .. } if autopilots.is_empty() => return Err(NotALog::NoAutopilot(*records)),
            Survey { records, has_positions: false, .. } => return Err(NotALog::NoPositions(*records)),
            Survey { .. } => {}
        }
        let (flock, clock) = (Flock::new(false), Clock::default());
        Ok(Self { bytes, at: 0, clock, flock, samples: Vec::new(), survey, is_whole: false })
    }

    /// What it holds.
    pub fn survey(&self) -> &Survey {
        &self.survey
    }

    /// Reads on, up to the first record after a time.
    pub fn read_until(&mut self, until_us: u64) {
        let bytes = std::mem::take(&mut self.bytes);
        self.is_whole = loop {
            let Some(length) = length_at(&bytes, self.at, &self.clock) else { break true };
            let Some(length) = length else {
                self.at += 1;
                continue;
            };
            let at_us = self.clock.at_us(time_us(&bytes, self.at));
            self.take(&bytes[self.at + TIME..self.at + TIME + length], at_us);
            self.at += TIME + length;
            if at_us > until_us {
                break false;
            }
        };
        self.bytes = bytes;
    }

    /// Whether all of it was read.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// The part that was read, 0 to 1.
    pub fn read(&self) -> f64 {
        if self.is_whole { 1.0 } else { self.at as f64 / self.bytes.len() as f64 }
    }

    /// The frame of its places, once one was heard.
    pub fn frame(&self) -> Option<LocalFrame> {
        self.flock.frame
    }

    /// Sets the frame of its places, if none was heard: those of several logs are shown together.
    pub fn share_frame(&mut self, frame: Option<LocalFrame>) {
        self.flock.frame = self.flock.frame.or(frame);
    }

    /// Its vehicles so far: each one's own number, and what was known of it, in order of time.
    pub fn vehicles(&self) -> impl Iterator<Item = (u32, &[Sample])> {
        self.flock.all.iter().zip(&self.samples).map(|(one, samples)| (one.number, samples.as_slice()))
    }

    /// What was known of one of them.
    pub fn samples(&self, vehicle: usize) -> &[Sample] {
        self.samples.get(vehicle).map_or(&[], Vec::as_slice)
    }

    /// What vehicles said in words since this was last called: when, counted from the log's first record.
    pub fn take_events(&mut self) -> Vec<(Duration, Event)> {
        std::mem::take(&mut self.flock.events)
    }

    /// Its plans, if they have changed since this was last called.
    pub fn take_outlines(&mut self) -> Option<Vec<Outline>> {
        self.flock.take_outlines()
    }

    /// The wind at the end of what was read.
    pub fn wind(&self) -> Option<Wind> {
        self.flock.wind(self.since(self.clock.now_us().unwrap_or(0)))
    }

    /// Time since its first record.
    fn since(&self, at_us: u64) -> Duration {
        Duration::from_micros(at_us.saturating_sub(self.survey.span_us.0))
    }

    fn take(&mut self, frame: &[u8], at_us: u64) {
        let Some((id, system)) = id_and_system(frame) else { return };
        let is_local_too = id == LOCAL_POSITION_NED && self.flock.has_global(system);
        if !SHOWN.contains(&id) || is_local_too {
            return;
        }
        let Ok(frame) = Frame::parse(frame) else { return };
        let Some(index) = self.flock.hear_frame(&frame, (), self.since(at_us)) else { return };
        self.samples.resize_with(self.flock.all.len(), Vec::new);
        let Some(state) = self.flock.all[index].state else { return };
        let samples = &mut self.samples[index];
        let mut shown = samples.last().map(|last| last.shown.clone()).unwrap_or_default();
        self.flock.show(index, &mut shown, None);
        let has_changed = samples.last().is_none_or(|last| {
            last.shown.mode != shown.mode
                || last.shown.is_armed != shown.is_armed
                || last.shown.follows != shown.follows
        });
        if (POSITIONS.contains(&id) || has_changed) && samples.last().is_none_or(|last| last.at_us <= at_us) {
            samples.push(Sample { at_us, state, shown });
        }
    }
}

impl Survey {
    /// Looks through a log.
    fn of(bytes: &[u8]) -> Self {
        let (mut survey, mut at) = (Self::default(), 0);
        while let Some(length) = length_at(bytes, at, &survey.clock) {
            let Some(length) = length else {
                at += 1;
                survey.skipped_bytes += 1;
                continue;
            };
            let at_us = survey.clock.at_us(time_us(bytes, at));
            let (first_us, last_us) = if survey.records == 0 { (at_us, at_us) } else { survey.span_us };
            survey.span_us = (first_us.min(at_us), last_us.max(at_us));
            survey.records += 1;
            survey.look(&bytes[at + TIME..at + TIME + length]);
            at += TIME + length;
        }
        survey
    }

    fn look(&mut self, frame: &[u8]) {
        let Some((id, system)) = id_and_system(frame) else { return };
        if !self.has_positions && POSITIONS.contains(&id) {
            self.has_positions = match Frame::parse(frame).and_then(|frame| frame.message()) {
                Ok(Message::GLOBAL_POSITION_INT(position)) => place::is_known(&position),
                Ok(_) => true,
                Err(_) => false,
            };
        }
        if id == HEARTBEAT
            && !self.autopilots.contains(&system)
            && let Ok(Message::HEARTBEAT(heartbeat)) = Frame::parse(frame).and_then(|frame| frame.message())
            && is_autopilot(&heartbeat)
        {
            self.autopilots.insert(system);
        }
    }
}

/// Message id and system id of a frame.
fn id_and_system(frame: &[u8]) -> Option<(u32, u8)> {
    match frame {
        [0xFD, _, _, _, _, system, _, a, b, c, ..] => Some((u32::from_le_bytes([*a, *b, *c, 0]), *system)),
        [0xFE, _, _, system, _, id, ..] => Some((u32::from(*id), *system)),
        _ => None,
    }
}

/// Length of the frame of the record at a place; none at the end, and none within where there is no record.
#[allow(clippy::option_option)] // the end, no record, a record
fn length_at(bytes: &[u8], at: usize, clock: &Clock) -> Option<Option<usize>> {
    let head = bytes.get(at..at + TIME + 3)?;
    let length = Frame::length(head[TIME], head[TIME + 1], head[TIME + 2]);
    let length = length.filter(|length| at + TIME + length <= bytes.len());
    // What is no record has any time: where the time tells nothing, the checksum must.
    let goes_on = clock.goes_on(time_us(bytes, at));
    Some(length.filter(|length| goes_on || Frame::parse(&bytes[at + TIME..at + TIME + length]).is_ok()))
}

/// Microseconds since the Unix epoch, as a record begins.
pub fn time_us(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..at + TIME).map_or(0, |time| time.iter().fold(0, |all, byte| all << 8 | u64::from(*byte)))
}

/// What a file without records is.
fn what_is(bytes: &[u8]) -> NotALog {
    match bytes {
        [b'U', b'L', b'o', b'g', 0x01, 0x12, 0x35, ..] => NotALog::ULog,
        [0xA3, 0x95, 128, ..] => NotALog::Dataflash,
        _ => NotALog::Nothing,
    }
}
