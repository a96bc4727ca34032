//! How simulated vehicles really fly, told to the judge behind the wire's back.

use flight_model::State;
use sim_vehicle::{Advance, Observer};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// A stretch of one vehicle's flight.
struct Stretch {
    vehicle: usize,
    start: Duration,
    track: Vec<State>,
}

/// The flights of all vehicles, step by step and side by side.
pub struct Truth {
    stretches: Receiver<Stretch>,
    tracks: Vec<Vec<State>>,
    /// Vehicle time up to which the tracks have been taken.
    taken: Duration,
    step: Duration,
}

/// An observer for the host, and what it observes.
pub fn truth(vehicles: usize, step: Duration) -> (Observer, Truth) {
    let (sender, stretches) = channel();
    let observer = move |advance: Advance<'_>| {
        let stretch = Stretch { vehicle: advance.vehicle, start: advance.start, track: advance.track.to_vec() };
        // The receiver is gone once the flight is over: what is flown then is nobody's concern.
        let _ = sender.send(stretch);
    };
    (Arc::new(observer), Truth { stretches, tracks: vec![Vec::new(); vehicles], taken: Duration::ZERO, step })
}

impl Truth {
    /// Forgets what was flown before now; the flight's time zero is the vehicles' time returned.
    pub fn start(&mut self) -> Duration {
        self.take();
        self.taken
    }

    /// The states after each integration step that all vehicles have flown and that were not taken yet, and the vehicle
    /// time at which they begin.
    pub fn take(&mut self) -> (Duration, Vec<Vec<State>>) {
        for stretch in self.stretches.try_iter() {
            debug_assert!(stretch.start >= self.taken);
            if let Some(track) = self.tracks.get_mut(stretch.vehicle) {
                track.extend(stretch.track);
            }
        }
        let steps = self.tracks.iter().map(Vec::len).min().unwrap_or(0);
        let start = self.taken;
        self.taken += self.step * steps as u32;
        (start, self.tracks.iter_mut().map(|track| track.drain(..steps).collect()).collect())
    }
}
