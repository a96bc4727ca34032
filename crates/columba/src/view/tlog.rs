//! `columba view FILE.tlog`: telemetry logs, ours and other people's, as recordings for the page.

use super::heard::{Flock, SHOWN};
use flight_model::{State, wrap_pi};
use live_view::{Event, Frame as Shown, Recording, Scene, VehicleNow, Weight};
use mavlink_bridge::Frame;
use std::path::Path;
use std::time::Duration;

/// A recording has at most so many vehicles times frames: beyond that, frames are further apart.
const ROWS_MAX: usize = 300_000;
/// The least time between two frames, s.
const STEP_S: f64 = 0.1;
/// Between two positions that are further apart than this, nobody knows where the vehicle was, s.
const GAP_MAX_S: f64 = 1.5;
/// Two records of one log that are further apart than this are not of one log, microseconds.
const JUMP_MAX_US: u64 = 7 * 24 * 3600 * 1_000_000;
const TIME: usize = 8;
const LOCAL_POSITION_NED: u32 = 32;

/// What was read of a log.
pub struct Log {
    flock: Flock<()>,
    /// What was known of each vehicle, in order of time: positions, and what else is shown.
    samples: Vec<Vec<Sample>>,
    /// The first and the last record, microseconds since the Unix epoch.
    span_us: Option<(u64, u64)>,
    /// Records that were read.
    pub records: u64,
    /// Bytes between them that are no record.
    pub skipped_bytes: u64,
}

/// A vehicle as it said that it was.
struct Sample {
    at_us: u64,
    state: State,
    shown: VehicleNow,
}

impl Log {
    /// Reads a log; what is no record is skipped, and counted.
    pub fn read(bytes: &[u8]) -> Self {
        let mut log =
            Self { flock: Flock::new(false), samples: Vec::new(), span_us: None, records: 0, skipped_bytes: 0 };
        let mut at = 0;
        while let Some(length) = log.length_at(bytes, at) {
            let Some(length) = length else {
                at += 1;
                log.skipped_bytes += 1;
                continue;
            };
            let at_us = time_us(bytes, at);
            let first_us = log.span_us.map_or(at_us, |(first_us, _)| first_us.min(at_us));
            log.span_us = Some((first_us, log.span_us.map_or(at_us, |(_, last_us)| last_us.max(at_us))));
            log.records += 1;
            log.take(&bytes[at + TIME..at + TIME + length], at_us);
            at += TIME + length;
        }
        log
    }

    /// Length of the frame of the record at a place; none at the end, and none within where there is no record.
    #[allow(clippy::option_option)] // the end, no record, a record
    fn length_at(&self, bytes: &[u8], at: usize) -> Option<Option<usize>> {
        let head = bytes.get(at..at + TIME + 3)?;
        let length = Frame::length(head[TIME], head[TIME + 1], head[TIME + 2]);
        let is_near = self.span_us.is_none_or(|(_, last_us)| time_us(bytes, at).abs_diff(last_us) < JUMP_MAX_US);
        Some(length.filter(|length| is_near && at + TIME + length <= bytes.len()))
    }

    fn take(&mut self, frame: &[u8], at_us: u64) {
        let is_version_2 = frame[0] == 0xFD;
        let id = match is_version_2 {
            true => frame.get(7..10).map_or(0, |id| u32::from_le_bytes([id[0], id[1], id[2], 0])),
            false => frame.get(5).map_or(0, |id| u32::from(*id)),
        };
        let system_at = if is_version_2 { 5 } else { 3 };
        let is_local_too =
            id == LOCAL_POSITION_NED && self.flock.has_global(frame.get(system_at).copied().unwrap_or(0));
        if !SHOWN.contains(&id) || is_local_too {
            return;
        }
        let Ok(frame) = Frame::parse(frame) else { return };
        let Ok(message) = frame.message() else { return };
        let (first_us, _) = self.span_us.unwrap_or((at_us, at_us));
        let now = Duration::from_micros(at_us.saturating_sub(first_us));
        let Some(index) = self.flock.hear(&frame.header, &message, (), now) else { return };
        self.samples.resize_with(self.flock.all.len(), Vec::new);
        let Some(state) = self.flock.all[index].state else { return };
        let samples = &mut self.samples[index];
        let mut shown = samples.last().map(|last| last.shown.clone()).unwrap_or_default();
        self.flock.show(index, &mut shown, None);
        let is_position = matches!(id, 32 | 33);
        let has_changed = samples.last().is_none_or(|last| {
            last.shown.mode != shown.mode
                || last.shown.is_armed != shown.is_armed
                || last.shown.follows != shown.follows
        });
        if (is_position || has_changed) && samples.last().is_none_or(|last| last.at_us <= at_us) {
            samples.push(Sample { at_us, state, shown });
        }
    }

    /// How many vehicles there are of which it is known where they were.
    pub fn vehicles(&self) -> usize {
        self.samples.iter().filter(|samples| !samples.is_empty()).count()
    }
}

/// Logs as one recording. They share a clock where their times overlap; else each begins at zero.
pub fn recording(logs: &[(&Path, Log)], mut scene: Scene) -> Recording {
    let spans: Vec<(u64, u64)> = logs.iter().map(|(_, log)| log.span_us.unwrap_or((0, 0))).collect();
    let first_us = spans.iter().map(|span| span.0).min().unwrap_or(0);
    let overlap = spans.iter().all(|a| spans.iter().all(|b| a.0 <= b.1 && b.0 <= a.1));
    let zero_us = |log: usize| if overlap { first_us } else { spans[log].0 };
    let ends_s = spans.iter().enumerate().map(|(log, span)| (span.1 - zero_us(log)) as f64 * 1e-6);
    let duration_s = ends_s.fold(0.0, f64::max);
    let vehicles: usize = logs.iter().map(|(_, log)| log.vehicles()).sum();
    let step_s = (duration_s * vehicles as f64 / ROWS_MAX as f64).max(STEP_S);
    scene.distances_rest_on = "of positions as they were logged, between which it is a straight line".to_owned();

    let mut recording = Recording::new(scene);
    let mut tracks = Vec::new();
    for (log, (path, read)) in logs.iter().enumerate() {
        for (index, samples) in read.samples.iter().enumerate().filter(|(_, samples)| !samples.is_empty()) {
            tracks.push(Track { samples, zero_us: zero_us(log), next: 0, number: tracks.len() as u32 + 1, index, log });
        }
        if read.skipped_bytes > 0 {
            let text = format!("{}: {} bytes are no MAVLink and were skipped", path.display(), read.skipped_bytes);
            recording.tell(Event { at_s: 0.0, vehicles: Vec::new(), weight: Weight::Warning, text });
        }
        let began_s = (spans[log].0 - zero_us(log)) as f64 * 1e-6;
        for (at, event) in &read.flock.events {
            let numbered = tracks
                .iter()
                .find(|track| track.log == log && event.vehicles == [crate::flight::vehicle_number(track.index)]);
            let vehicles = numbered.map(|track| vec![track.number]).unwrap_or_default();
            recording.tell(Event { at_s: began_s + at.as_secs_f64(), vehicles, ..event.clone() });
        }
    }
    let mut tick = 0_u32;
    loop {
        let time_s = step_s * f64::from(tick);
        let heard = |at_s: f64| recording.instant(at_s);
        let vehicles = tracks.iter_mut().map(|track| track.at(time_s, heard)).collect();
        recording.push(Shown { time_s, rate: 1.0, vehicles, ..Shown::default() });
        tick += 1;
        if time_s >= duration_s {
            return recording;
        }
    }
}

/// One vehicle, from its first sample to its last.
struct Track<'a> {
    samples: &'a [Sample],
    zero_us: u64,
    /// The first sample that is not before the last time that was asked for.
    next: usize,
    number: u32,
    index: usize,
    log: usize,
}

impl Track<'_> {
    /// The vehicle at a time, which never goes back.
    fn at(&mut self, time_s: f64, instant: impl Fn(f64) -> std::time::Instant) -> VehicleNow {
        let seconds = |sample: &Sample| (sample.at_us.saturating_sub(self.zero_us)) as f64 * 1e-6;
        while self.samples.get(self.next).is_some_and(|sample| seconds(sample) <= time_s) {
            self.next += 1;
        }
        let first = &self.samples[0];
        let Some(before) = self.next.checked_sub(1).map(|index| &self.samples[index]) else {
            // Not heard of yet: it is nowhere, but it has its name.
            let VehicleNow { system_id, kind, mode, .. } = first.shown.clone();
            return VehicleNow { number: self.number, system_id, kind, mode, ..VehicleNow::default() };
        };
        let mut shown = before.shown.clone();
        let mut state = before.state;
        if let Some(after) = self.samples.get(self.next) {
            let span_s = seconds(after) - seconds(before);
            if span_s > 0.0 && span_s <= GAP_MAX_S {
                state = between(&before.state, &after.state, (time_s - seconds(before)) / span_s);
            }
        }
        super::craft::place(&mut shown, self.index, &state);
        shown.number = self.number;
        shown.heard = Some(instant(seconds(before)));
        shown
    }
}

/// On the straight line from one state to another.
fn between(a: &State, b: &State, part: f64) -> State {
    let mix = |from: f64, to: f64| from + part * (to - from);
    State {
        x_m: mix(a.x_m, b.x_m),
        y_m: mix(a.y_m, b.y_m),
        altitude_m: mix(a.altitude_m, b.altitude_m),
        speed_mps: mix(a.speed_mps, b.speed_mps),
        course_rad: a.course_rad + part * wrap_pi(b.course_rad - a.course_rad),
        climb_mps: mix(a.climb_mps, b.climb_mps),
    }
}

/// Microseconds since the Unix epoch, as a record begins.
fn time_us(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..at + TIME).map_or(0, |time| time.iter().fold(0, |all, byte| all << 8 | u64::from(*byte)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::{Geodetic, LocalFrame};
    use mavlink_bridge::dialect::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType, Message};
    use mavlink_bridge::telemetry::global_position_int;
    use mavlink_bridge::{Encoder, TlogWriter};

    fn heartbeat(custom_mode: u32) -> Message {
        Message::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode,
            mavtype: MavType::MAV_TYPE_FIXED_WING,
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        })
    }

    /// Vehicles 3 and 9, of which 9 leaves GUIDED (15) for RTL (11) after four seconds.
    fn log_of_two() -> Vec<u8> {
        let origin = Geodetic { latitude_deg: 40.0, longitude_deg: 116.0, altitude_amsl_m: 30.0 };
        let frame = LocalFrame::new(origin);
        let mut log = TlogWriter::new(Vec::new());
        for tick in 0_u32..100 {
            let at_us = 1_700_000_000_000_000 + 100_000 * u64::from(tick);
            for (system, y_m) in [(3, 0.0), (9, 8.0)] {
                let mode = if system == 9 && tick > 40 { 11 } else { 15 };
                let x_m = 1.0 * f64::from(tick);
                let state = State { x_m, y_m, altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
                let position =
                    global_position_int(Duration::from_millis(100 * u64::from(tick)), &state, 0.0, &frame, 0.0);
                for message in [heartbeat(mode), position] {
                    let mut bytes = Vec::new();
                    Encoder::new(system, 1).encode(&message, &mut bytes);
                    log.write(at_us, &bytes).unwrap();
                }
            }
        }
        log.finish().unwrap()
    }

    #[test]
    fn a_log_is_played_back_with_what_happened_in_it() {
        let bytes = log_of_two();
        let log = Log::read(&bytes);
        assert_eq!((log.records, log.vehicles(), log.skipped_bytes), (400, 2, 0));
        let recording = recording(&[(Path::new("two.tlog"), log)], Scene { separation_m: 10.0, ..Scene::default() });
        let head: serde_json::Value = serde_json::from_str(&recording.head().unwrap()).unwrap();
        assert_eq!(head["roster"]["systems"], serde_json::json!([3, 9]));
        let told = head["told"].to_string();
        assert!(told.contains("left GUIDED to RTL"), "{told}");
        assert!((head["least"]["separation"]["value_m"].as_f64().unwrap() - 8.0).abs() < 0.1, "{head}");
        // Ten seconds at ten frames a second.
        let frames = recording.frames();
        let length = u32::from_le_bytes(frames[..4].try_into().unwrap()) as usize;
        assert_eq!(frames.len() / (length + 4), 100);
    }

    #[test]
    fn what_is_no_mavlink_is_skipped_and_told() {
        let whole = log_of_two();
        let mut bytes = whole[..whole.len() / 2].to_vec();
        bytes.extend_from_slice(&[0xFD; 333]);
        bytes.extend_from_slice(&whole);
        bytes.truncate(bytes.len() - 5);
        let log = Log::read(&bytes);
        assert!(log.records > 550 && log.skipped_bytes > 300, "{} {}", log.records, log.skipped_bytes);
        let recording = recording(&[(Path::new("torn.tlog"), log)], Scene::default());
        assert!(recording.head().unwrap().contains("are no MAVLink and were skipped"));
        let nothing = Log::read(b"this is a text, and no log of telemetry");
        assert_eq!((nothing.records, nothing.vehicles()), (0, 0));
    }
}
