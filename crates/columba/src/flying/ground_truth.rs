//! Ground truth: how the vehicles really fly, told to the judge past the wire. Where nobody but the vehicles knows it,
//! their telemetry stands in for it.

use super::Interval;
use flight_model::State;
use sim_vehicle::{Advance, Observer};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use tokio::sync::watch;

/// By what a flight is judged.
pub struct GroundTruth {
    source: Source,
    /// The interval that was flown last.
    start: Duration,
    step: Duration,
    tracks: Vec<Vec<State>>,
}

enum Source {
    /// The simulated vehicles themselves.
    Observed(Observed),
    /// What the vehicles say: one state for each control period.
    Telemetry,
}

/// The flights of simulated vehicles, as their host reports them.
struct Observed {
    stretches: Receiver<Stretch>,
    /// Not taken yet, by vehicle.
    tracks: Vec<Vec<State>>,
    /// Vehicle time up to which the tracks have been taken.
    taken: Duration,
    /// Vehicle time at time zero of the flight.
    zero: Duration,
    step: Duration,
    /// Lets the vehicles go.
    begins: watch::Sender<bool>,
}

/// A stretch of one vehicle's flight.
struct Stretch {
    vehicle: usize,
    start: Duration,
    track: Vec<State>,
}

impl GroundTruth {
    /// The flights of simulated vehicles, with the observer for their host, and what tells the host that the flight
    /// begins. `step` is the integration step.
    pub fn observed(vehicles: usize, step: Duration) -> (Observer, watch::Receiver<bool>, Self) {
        let (sender, stretches) = channel();
        let observer = move |advance: Advance<'_>| {
            let stretch = Stretch { vehicle: advance.vehicle, start: advance.start, track: advance.track.to_vec() };
            // The receiver is gone once the flight is over: what is flown then is not judged.
            let _ = sender.send(stretch);
        };
        let tracks = vec![Vec::new(); vehicles];
        let (begins, is_begun) = watch::channel(false);
        let observed = Observed { stretches, tracks, taken: Duration::ZERO, zero: Duration::ZERO, step, begins };
        (Arc::new(observer), is_begun, Self::new(Source::Observed(observed)))
    }

    /// Telemetry, where the vehicles are not ours to observe.
    pub fn telemetry() -> Self {
        Self::new(Source::Telemetry)
    }

    fn new(source: Source) -> Self {
        Self { source, start: Duration::ZERO, step: Duration::ZERO, tracks: Vec::new() }
    }

    /// Whether the vehicles themselves tell how they fly.
    pub fn is_observed(&self) -> bool {
        matches!(self.source, Source::Observed(_))
    }

    /// Forgets what was flown before now: this is time zero of the flight. Vehicles that wait for it fly on.
    pub fn start(&mut self) {
        if let Source::Observed(observed) = &mut self.source {
            observed.take();
            observed.zero = observed.taken;
            observed.begins.send_replace(true);
        }
    }

    /// The vehicles have flown on, in flight time `from` to `to`, and are known to be at `states`.
    pub fn advance(&mut self, from: Duration, to: Duration, states: &[State]) {
        match &mut self.source {
            Source::Observed(observed) => {
                self.step = observed.step;
                (self.start, self.tracks) = observed.take();
            }
            Source::Telemetry => {
                (self.start, self.step) = (from, to.saturating_sub(from));
                self.tracks = states.iter().map(|state| vec![*state]).collect();
            }
        }
    }

    /// What was flown in the last advance.
    pub fn interval(&self) -> Interval<'_> {
        Interval { start: self.start, step: self.step, tracks: &self.tracks }
    }
}

impl Observed {
    /// The states after each integration step that all vehicles have flown and that were not taken yet, and the flight
    /// time at which they begin.
    fn take(&mut self) -> (Duration, Vec<Vec<State>>) {
        for stretch in self.stretches.try_iter() {
            debug_assert!(stretch.start >= self.taken);
            if let Some(track) = self.tracks.get_mut(stretch.vehicle) {
                track.extend(stretch.track);
            }
        }
        let steps = self.tracks.iter().map(Vec::len).min().unwrap_or(0);
        let start = self.taken.saturating_sub(self.zero);
        self.taken += self.step * steps as u32;
        (start, self.tracks.iter_mut().map(|track| track.drain(..steps).collect()).collect())
    }
}
