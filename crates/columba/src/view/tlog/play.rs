//! Logs onto the page's tape, stretch by stretch: the page plays what was read while the rest is being read.

use super::log::{Log, Sample};
use crate::view::craft::place;
use crate::view::heard::free_number;
use flight_model::{State, wrap_pi};
use live_view::{Event, Frame as Shown, Outline, Progress, Recording, Scene, Tape, VehicleNow, Weight};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// A recording has at most so many vehicles times frames: beyond that, frames are further apart.
const ROWS_MAX: usize = 300_000;
/// The least time between two frames, s.
const STEP_S: f64 = 0.1;
/// Between two positions that are further apart than this, nobody knows where the vehicle was, s.
const GAP_MAX_S: f64 = 1.5;
/// So much is read before the page plays, s of flight; then twice as much each time, up to a part of the whole.
const FIRST_STRETCH_S: f64 = 10.0;
const STRETCHES_MIN: f64 = 8.0;

/// Reads logs, each with its name, onto a tape. They share a clock where their times overlap; else each begins at zero.
///
/// # Errors
/// A number of the scene is none.
pub fn play(logs: Vec<(String, Log)>, mut scene: Scene, tape: &Tape) -> Result<(), serde_json::Error> {
    scene.distances_rest_on = "of positions as they were logged, between which it is a straight line".to_owned();
    let mut playback = Playback::new(logs, scene);
    let stretch_max_s = (playback.duration_s / STRETCHES_MIN).max(FIRST_STRETCH_S);
    let (mut until_s, mut stretch_s) = (0.0, FIRST_STRETCH_S);
    while until_s < playback.duration_s || playback.next == 0 {
        until_s = (until_s + stretch_s).min(playback.duration_s);
        stretch_s = (2.0 * stretch_s).min(stretch_max_s);
        playback.read_until(until_s);
        let read = if until_s < playback.duration_s { playback.read() } else { 1.0 };
        tape.wind(&mut playback.recording, Progress { read, duration_s: playback.duration_s })?;
    }
    Ok(())
}

struct Playback {
    logs: Vec<Source>,
    tracks: Vec<Track>,
    recording: Recording,
    duration_s: f64,
    step_s: f64,
    /// The next frame's number.
    next: u32,
    /// In several logs the same number may be that of several vehicles.
    taken: BTreeSet<u32>,
}

/// A log, and its place among others.
struct Source {
    log: Log,
    /// Flight time zero on its clock.
    zero_us: u64,
    /// The vehicles' numbers, by their own in this log.
    numbers: BTreeMap<u32, u32>,
    outlines: Vec<Outline>,
}

impl Source {
    fn seconds(&self, at_us: u64) -> f64 {
        at_us.saturating_sub(self.zero_us) as f64 * 1e-6
    }
}

impl Playback {
    fn new(logs: Vec<(String, Log)>, scene: Scene) -> Self {
        let spans: Vec<(u64, u64)> = logs.iter().map(|(_, log)| log.survey().span_us).collect();
        let first_us = spans.iter().map(|span| span.0).min().unwrap_or(0);
        let overlap = spans.iter().all(|a| spans.iter().all(|b| a.0 <= b.1 && b.0 <= a.1));
        let mut recording = Recording::new(scene);
        let (mut duration_s, mut vehicles, mut sources) = (0.0_f64, 0, Vec::new());
        for ((name, log), span) in logs.into_iter().zip(spans) {
            let zero_us = if overlap { first_us } else { span.0 };
            let source = Source { log, zero_us, numbers: BTreeMap::new(), outlines: Vec::new() };
            duration_s = duration_s.max(source.seconds(span.1));
            let survey = source.log.survey();
            vehicles += survey.autopilots.len();
            let mut warn = |at_s: f64, text: String| {
                recording.tell(Event { at_s, vehicles: Vec::new(), weight: Weight::Warning, text });
            };
            for (at_us, jump_s) in &survey.clock.jumps {
                let text = format!(
                    "{name}: the clock of the log jumps by {jump_s:.0} s here: the time goes on as if it had not"
                );
                warn(source.seconds(*at_us), text);
            }
            if survey.skipped_bytes > 0 {
                warn(0.0, format!("{name}: {} bytes are no MAVLink and were skipped", survey.skipped_bytes));
            }
            sources.push(source);
        }
        let step_s = (duration_s * vehicles as f64 / ROWS_MAX as f64).max(STEP_S);
        let (tracks, taken) = (Vec::new(), BTreeSet::new());
        Self { logs: sources, tracks, recording, duration_s, step_s, next: 0, taken }
    }

    /// The part that was read, of all logs together.
    fn read(&self) -> f64 {
        self.logs.iter().map(|source| source.log.read()).sum::<f64>() / self.logs.len().max(1) as f64
    }

    /// Reads on, and records the frames up to a flight time.
    fn read_until(&mut self, until_s: f64) {
        for index in 0..self.logs.len() {
            let frame = self.logs.iter().find_map(|source| source.log.frame());
            let source = &mut self.logs[index];
            source.log.share_frame(frame);
            // To know where a vehicle is, its next position must be known.
            let ahead_us = ((until_s + GAP_MAX_S) * 1e6) as u64;
            let until_us = if until_s < self.duration_s { source.zero_us.saturating_add(ahead_us) } else { u64::MAX };
            if !source.log.is_whole() {
                source.log.read_until(until_us);
            }
            self.enrol(index);
            self.tell(index);
        }
        while self.next == 0 || self.step_s * f64::from(self.next - 1) < until_s {
            let time_s = self.step_s * f64::from(self.next);
            let heard = |at_s: f64| self.recording.instant(at_s);
            let vehicles = self.tracks.iter_mut().map(|track| track.at(time_s, &self.logs, heard)).collect();
            self.recording.push(Shown { time_s, rate: 1.0, vehicles, ..Shown::default() });
            self.next += 1;
        }
    }

    /// Numbers vehicles that are new in a log. New ones come after all others.
    fn enrol(&mut self, index: usize) {
        let source = &mut self.logs[index];
        for (vehicle, (own, samples)) in source.log.vehicles().enumerate() {
            if samples.is_empty() || source.numbers.contains_key(&own) {
                continue;
            }
            let number = free_number(own, |number| self.taken.contains(&number));
            self.taken.insert(number);
            source.numbers.insert(own, number);
            self.tracks.push(Track { log: index, vehicle, next: 0, number });
        }
    }

    /// Tells what vehicles of a log have said, and what they plan.
    fn tell(&mut self, index: usize) {
        let source = &mut self.logs[index];
        let began_s = source.seconds(source.log.survey().span_us.0);
        for (at, event) in source.log.take_events() {
            let vehicles = event.vehicles.iter().map(|own| *source.numbers.get(own).unwrap_or(own)).collect();
            self.recording.tell(Event { at_s: began_s + at.as_secs_f64(), vehicles, ..event });
        }
        if let Some(outlines) = source.log.take_outlines() {
            let number = |own: u32| source.numbers.get(&own).copied();
            let own = |outline: Outline| Outline { vehicle: outline.vehicle.and_then(number), ..outline };
            source.outlines = outlines.into_iter().map(own).collect();
        }
        let (outlines, wind) =
            (self.logs.iter().flat_map(|source| source.outlines.clone()).collect(), self.logs[index].log.wind());
        self.recording.set_scene(|scene| {
            scene.outlines = outlines;
            scene.wind = wind.or(scene.wind);
        });
    }
}

/// One vehicle, from its first sample to its last.
struct Track {
    log: usize,
    vehicle: usize,
    /// The first sample that is not before the last time that was asked for.
    next: usize,
    number: u32,
}

impl Track {
    /// The vehicle at a time, which never goes back.
    fn at(&mut self, time_s: f64, logs: &[Source], instant: impl Fn(f64) -> Instant) -> VehicleNow {
        let source = &logs[self.log];
        let samples = source.log.samples(self.vehicle);
        let seconds = |sample: &Sample| source.seconds(sample.at_us);
        while samples.get(self.next).is_some_and(|sample| seconds(sample) <= time_s) {
            self.next += 1;
        }
        let first = &samples[0];
        let Some(before) = self.next.checked_sub(1).map(|index| &samples[index]) else {
            // Not heard of yet: it is nowhere, but it has its name.
            let VehicleNow { system_id, kind, mode, .. } = first.shown.clone();
            return VehicleNow { number: self.number, system_id, kind, mode, ..VehicleNow::default() };
        };
        let mut shown = before.shown.clone();
        let mut state = before.state;
        if let Some(after) = samples.get(self.next) {
            let span_s = seconds(after) - seconds(before);
            if span_s > 0.0 && span_s <= GAP_MAX_S {
                state = between(&before.state, &after.state, (time_s - seconds(before)) / span_s);
            }
        }
        place(&mut shown, self.vehicle, &state);
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
