//! A flock as the tick loop of `columba run` flies it.

use super::choices;
use super::craft::place;
use crate::flight::vehicle_number;
use crate::judge::{Least, Verdict};
use controller::{Decision, Flock};
use flight_model::State;
use live_view::{Feed, Steering, VehicleNow};
use std::time::Duration;

/// Shows a flock on the page, tick by tick.
#[derive(Clone, Debug)]
pub struct FlockView {
    feed: Feed,
    /// Whether the vehicles themselves are watched as they fly, so that ticks need not say where they are.
    vehicles_are_watched: bool,
}

impl FlockView {
    /// A flock that is shown by `feed`.
    pub fn new(feed: Feed, vehicles_are_watched: bool) -> Self {
        Self { feed, vehicles_are_watched }
    }

    /// A tick: what the controller saw and decided at a flight time, and how the flight was judged until then.
    pub fn tick(&self, now: Duration, states: &[State], decisions: &[Decision], verdict: impl FnOnce() -> Verdict) {
        self.feed.update(|frame| {
            frame.phase = "fly".to_owned();
            if now.is_zero() {
                frame.zero_s += frame.time_s;
            }
            if now.is_zero() || !self.vehicles_are_watched {
                frame.time_s = now.as_secs_f64();
            }
            frame.vehicles.resize(states.len(), VehicleNow::default());
            for (index, (shown, decision)) in frame.vehicles.iter_mut().zip(decisions).enumerate() {
                if !self.vehicles_are_watched {
                    place(shown, index, &states[index]);
                }
                shown.steering = Some(steering(decision));
            }
            let verdict = verdict();
            frame.least_separation = verdict.separation.map(|least| shown_least(least, |pair| pair.to_vec()));
            frame.least_clearance = verdict.clearance.map(|least| shown_least(least, |one| vec![one]));
        });
    }

    /// Of which vehicles the next tick is to tell what there was to choose from.
    pub fn watched(&self, vehicles: usize) -> Vec<usize> {
        choices::watched(&self.feed, vehicles)
    }

    /// What the watched vehicles had to choose from at the tick of a flight time.
    pub fn chosen(&self, now: Duration, flock: &Flock) {
        flock.insights().for_each(|(index, insight)| choices::tell(&self.feed, index, insight, now.as_secs_f64()));
    }
}

/// What the controller chose.
pub fn steering(decision: &Decision) -> Steering {
    Steering {
        weights: decision.weights.map(|weight| weight as f32),
        speed_mps: decision.setpoint.speed_mps as f32,
        course_rad: decision.setpoint.course_rad as f32,
        altitude_m: decision.setpoint.altitude_m as f32,
    }
}

/// A least distance of the judge, with the numbers of the vehicles.
pub fn shown_least<W: Copy>(least: Least<W>, whose: impl Fn(W) -> Vec<usize>) -> live_view::Least {
    let vehicles = whose(least.whose).into_iter().map(vehicle_number).collect();
    live_view::Least { value_m: least.value_m, at_s: least.at_s, vehicles }
}
