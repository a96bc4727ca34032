//! `columba view FILE.tlog`: telemetry logs, ours and other people's, as recordings for the page.

use super::heard::{Flock, SHOWN, free_number};
use flight_model::{LocalFrame, State, wrap_pi};
use live_view::{Event, Frame as Shown, Outline, Recording, Scene, VehicleNow, Weight};
use mavlink_bridge::Frame;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Duration;

/// A recording has at most so many vehicles times frames: beyond that, frames are further apart.
const ROWS_MAX: usize = 300_000;
/// The least time between two frames, s.
const STEP_S: f64 = 0.1;
/// Between two positions that are further apart than this, nobody knows where the vehicle was, s.
const GAP_MAX_S: f64 = 1.5;
/// Where the time of a record is so far ahead of the one before, or behind, the clock was set meanwhile, microseconds:
/// a computer without a battery for its clock learns the time after it has started.
const AHEAD_MAX_US: u64 = 24 * 3600 * 1_000_000;
const BEHIND_MAX_US: u64 = 2_000_000;
/// So many jumps of a clock are told.
const JUMPS_MAX: usize = 20;
const TIME: usize = 8;
const LOCAL_POSITION_NED: u32 = 32;

/// What was read of a log.
pub struct Log {
    flock: Flock<()>,
    /// What was known of each vehicle, in order of time: positions, and what else is shown.
    samples: Vec<Vec<Sample>>,
    /// The first and the last record, microseconds since the Unix epoch.
    span_us: Option<(u64, u64)>,
    clock: Clock,
    /// Records that were read.
    pub records: u64,
    /// Bytes between them that are no record.
    pub skipped_bytes: u64,
}

/// The clock by which a log was written, without its jumps.
#[derive(Default)]
struct Clock {
    /// Time of the last record as written, and as it is taken.
    last_us: Option<(u64, u64)>,
    /// The first jumps: when, and by how many seconds.
    jumps: Vec<(u64, f64)>,
}

impl Clock {
    /// Whether a record of this time may follow the last one.
    fn goes_on(&self, written_us: u64) -> bool {
        self.last_us.is_some_and(|(last_us, _)| {
            written_us < last_us.saturating_add(AHEAD_MAX_US) && written_us.saturating_add(BEHIND_MAX_US) > last_us
        })
    }

    /// The time of the next record.
    fn at_us(&mut self, written_us: u64) -> u64 {
        let at_us = match self.last_us {
            None => written_us,
            Some((last_us, at_us)) if self.goes_on(written_us) => at_us
                .saturating_add(written_us.saturating_sub(last_us))
                .saturating_sub(last_us.saturating_sub(written_us)),
            Some((last_us, at_us)) => {
                if self.jumps.len() < JUMPS_MAX {
                    self.jumps.push((at_us, (written_us as f64 - last_us as f64) * 1e-6));
                }
                at_us
            }
        };
        self.last_us = Some((written_us, at_us));
        at_us
    }
}

/// A vehicle as it said that it was.
struct Sample {
    at_us: u64,
    state: State,
    shown: VehicleNow,
}

impl Log {
    /// Reads a log; what is no record is skipped, and counted. Places are in the frame of another log, where there is
    /// one: those of several are shown together.
    pub fn read(bytes: &[u8], frame: Option<LocalFrame>) -> Self {
        let mut flock = Flock::new(false);
        flock.frame = frame;
        let clock = Clock::default();
        let mut log = Self { flock, samples: Vec::new(), span_us: None, clock, records: 0, skipped_bytes: 0 };
        let mut at = 0;
        while let Some(length) = log.length_at(bytes, at) {
            let Some(length) = length else {
                at += 1;
                log.skipped_bytes += 1;
                continue;
            };
            let at_us = log.clock.at_us(time_us(bytes, at));
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
        let length = length.filter(|length| at + TIME + length <= bytes.len());
        // What is no record has any time: where the time tells nothing, the checksum must.
        let goes_on = self.clock.goes_on(time_us(bytes, at));
        Some(length.filter(|length| goes_on || Frame::parse(&bytes[at + TIME..at + TIME + length]).is_ok()))
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
        let (first_us, _) = self.span_us.unwrap_or((at_us, at_us));
        let now = Duration::from_micros(at_us.saturating_sub(first_us));
        let Some(index) = self.flock.hear_frame(&frame, (), now) else { return };
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

    /// The frame of its places, once one was heard.
    pub fn frame(&self) -> Option<LocalFrame> {
        self.flock.frame
    }

    /// How many vehicles there are of which it is known where they were.
    pub fn vehicles(&self) -> usize {
        self.samples.iter().filter(|samples| !samples.is_empty()).count()
    }
}

/// Logs as one recording. They share a clock where their times overlap; else each begins at zero.
pub fn recording(logs: &mut [(&Path, Log)], mut scene: Scene) -> Recording {
    let spans: Vec<(u64, u64)> = logs.iter().map(|(_, log)| log.span_us.unwrap_or((0, 0))).collect();
    let first_us = spans.iter().map(|span| span.0).min().unwrap_or(0);
    let overlap = spans.iter().all(|a| spans.iter().all(|b| a.0 <= b.1 && b.0 <= a.1));
    let zero_us = |log: usize| if overlap { first_us } else { spans[log].0 };
    let ends_s = spans.iter().enumerate().map(|(log, span)| (span.1 - zero_us(log)) as f64 * 1e-6);
    let duration_s = ends_s.fold(0.0, f64::max);
    let vehicles: usize = logs.iter().map(|(_, log)| log.vehicles()).sum();
    let step_s = (duration_s * vehicles as f64 / ROWS_MAX as f64).max(STEP_S);
    scene.distances_rest_on = "of positions as they were logged, between which it is a straight line".to_owned();

    // In several logs the same number may be that of several vehicles.
    let mut taken: BTreeSet<u32> = BTreeSet::new();
    let mut numbers: Vec<BTreeMap<u32, u32>> = Vec::new();
    for (log, (_, read)) in logs.iter_mut().enumerate() {
        let mut own = BTreeMap::new();
        for one in &read.flock.all {
            let number = free_number(one.number, |number| taken.contains(&number));
            taken.insert(number);
            own.insert(one.number, number);
        }
        let number = |number: u32| own.get(&number).copied();
        let outlines = read.flock.take_outlines().unwrap_or_default();
        scene.outlines.extend(
            outlines.into_iter().map(|outline| Outline { vehicle: outline.vehicle.and_then(number), ..outline }),
        );
        let duration = Duration::from_micros(spans[log].1 - spans[log].0);
        scene.wind = scene.wind.or(read.flock.wind(duration));
        numbers.push(own);
    }
    let number = |log: usize, own: u32| numbers[log].get(&own).copied().unwrap_or(own);
    let mut recording = Recording::new(scene);
    let mut tracks = Vec::new();
    for (log, (path, read)) in logs.iter().enumerate() {
        for (index, samples) in read.samples.iter().enumerate().filter(|(_, samples)| !samples.is_empty()) {
            let number = number(log, read.flock.all[index].number);
            tracks.push(Track { samples, zero_us: zero_us(log), next: 0, number, index });
        }
        for (at_us, jump_s) in &read.clock.jumps {
            let text = format!(
                "{}: the clock of the log jumps by {jump_s:.0} s here: the time goes on as if it had not",
                path.display()
            );
            let at_s = at_us.saturating_sub(zero_us(log)) as f64 * 1e-6;
            recording.tell(Event { at_s, vehicles: Vec::new(), weight: Weight::Warning, text });
        }
        if read.skipped_bytes > 0 {
            let text = format!("{}: {} bytes are no MAVLink and were skipped", path.display(), read.skipped_bytes);
            recording.tell(Event { at_s: 0.0, vehicles: Vec::new(), weight: Weight::Warning, text });
        }
        let began_s = (spans[log].0 - zero_us(log)) as f64 * 1e-6;
        for (at, event) in &read.flock.events {
            let vehicles = event.vehicles.iter().map(|&own| number(log, own)).collect();
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
        log_from(0.0)
    }

    /// The same, so many metres north of there.
    fn log_from(north_m: f64) -> Vec<u8> {
        let origin = Geodetic { latitude_deg: 40.0, longitude_deg: 116.0, altitude_amsl_m: 30.0 };
        let frame = LocalFrame::new(origin);
        let mut log = TlogWriter::new(Vec::new());
        for tick in 0_u32..100 {
            let at_us = 1_700_000_000_000_000 + 100_000 * u64::from(tick);
            for (system, y_m) in [(3, 0.0), (9, 8.0)] {
                let mode = if system == 9 && tick > 40 { 11 } else { 15 };
                let x_m = north_m + f64::from(tick);
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
        let log = Log::read(&bytes, None);
        assert_eq!((log.records, log.vehicles(), log.skipped_bytes), (400, 2, 0));
        let recording =
            recording(&mut [(Path::new("two.tlog"), log)], Scene { separation_m: 10.0, ..Scene::default() });
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
        let log = Log::read(&bytes, None);
        assert!(log.records > 550 && log.skipped_bytes > 300, "{} {}", log.records, log.skipped_bytes);
        let recording = recording(&mut [(Path::new("torn.tlog"), log)], Scene::default());
        assert!(recording.head().unwrap().contains("are no MAVLink and were skipped"));
        let nothing = Log::read(b"this is a text, and no log of telemetry", None);
        assert_eq!((nothing.records, nothing.vehicles()), (0, 0));
    }

    #[test]
    fn a_clock_that_is_set_meanwhile_tears_no_log() {
        let whole = log_of_two();
        let year_us = 365 * 24 * 3600 * 1_000_000_u64;
        for jump_us in [year_us, year_us.wrapping_neg(), 10_000_000_u64.wrapping_neg()] {
            let mut bytes = whole.clone();
            let (mut at, mut record) = (0, 0);
            while at < bytes.len() {
                if record >= 200 {
                    let set_us = time_us(&bytes, at).wrapping_add(jump_us);
                    bytes[at..at + TIME].copy_from_slice(&set_us.to_be_bytes());
                }
                at += TIME + Frame::length(bytes[at + TIME], bytes[at + TIME + 1], bytes[at + TIME + 2]).unwrap();
                record += 1;
            }
            let log = Log::read(&bytes, None);
            assert_eq!((log.records, log.skipped_bytes), (400, 0));
            let (first_us, last_us) = log.span_us.unwrap();
            assert!((9_700_000..10_000_000).contains(&(last_us - first_us)), "{}", last_us - first_us);
            let recording = recording(&mut [(Path::new("set.tlog"), log)], Scene::default());
            assert!(recording.head().unwrap().contains("the clock of the log jumps by"));
        }
    }

    #[test]
    fn several_logs_are_in_one_frame_and_their_vehicles_are_numbered_through() {
        let (here, there) = (log_from(0.0), log_from(300.0));
        let first = Log::read(&here, None);
        let second = Log::read(&there, first.frame());
        let mut logs = [(Path::new("here.tlog"), first), (Path::new("there.tlog"), second)];
        let recording = recording(&mut logs, Scene::default());
        let head: serde_json::Value = serde_json::from_str(&recording.head().unwrap()).unwrap();
        assert_eq!(head["roster"]["numbers"], serde_json::json!([3, 9, 1003, 1009]));
        let frames = recording.frames();
        let length = u32::from_le_bytes(frames[..4].try_into().unwrap()) as usize;
        let places = live_view::wire::places(&frames[4..4 + length]).unwrap().vehicles;
        let apart_m = places[2].unwrap()[0] - places[0].unwrap()[0];
        assert!((apart_m - 300.0).abs() < 0.1, "{apart_m}");
    }
}
