//! Fourth phase: to the scenario's starts. [`super::gather`] says how.

use super::gather::{Gather, Leg};
use super::{Phase, handover};
use crate::station::Station;
use crate::station::told::Weight;
use crate::station::vehicle::track::slant_m;
use flight_model::State;
use std::time::Duration;

/// Setpoints are made so often.
const PERIOD: Duration = Duration::from_millis(200);
/// So long a gathering may take.
const PATIENCE: Duration = Duration::from_secs(420);

/// Brings all to their starts.
pub struct GatherPhase {
    gather: Gather,
    began: Duration,
    rounds: u32,
    least_m: f64,
}

impl GatherPhase {
    pub(super) fn new(gather: Gather, now: Duration) -> Self {
        Self { gather, began: now, rounds: 1, least_m: f64::INFINITY }
    }

    pub(super) fn step(mut self, station: &mut Station, now: Duration) -> Phase {
        if station.stopped().is_some() {
            return Phase::end(None, now);
        }
        station.watch_modes(false, now);
        let ours: Vec<usize> = station.crew().filter(|&index| station.vehicles[index].is_ours()).collect();
        for index in station.crew().filter(|index| !ours.contains(index)) {
            self.gather.leave(index);
        }
        if ours.is_empty() {
            station.stop("no vehicle is left to fly", false);
            return Phase::end(None, now);
        }
        let states = states(station, &ours, now);
        self.least_m = self.least_m.min(least_distance_m(&states));
        if self.gather.is_complete(&states) {
            let text = format!(
                "gathered in {:.0} s; no two came nearer than {:.1} m, heights counted",
                now.saturating_sub(self.began).as_secs_f64(),
                self.least_m
            );
            station.told.tell(now.as_secs_f64(), None, Weight::Note, text);
            return Phase::HandOver(handover::HandOver::new(now));
        }
        if self.gather.is_past(&states) {
            self.gather.again();
            self.rounds += 1;
            let text = format!("not all were in their lanes in time: round {}", self.rounds);
            station.told.tell(now.as_secs_f64(), None, Weight::Note, text);
        }
        steer(&mut self.gather, station, &ours, now);
        if now.saturating_sub(self.began) > PATIENCE {
            let legs: Vec<String> = ours
                .iter()
                .map(|&index| format!("{} {:?}", index + 1, self.gather.leg(index)).to_lowercase())
                .collect();
            let text = format!("not gathered after {} s: {}", PATIENCE.as_secs(), legs.join(", "));
            station.told.tell(now.as_secs_f64(), None, Weight::Fault, text);
            station.stop("not gathered", false);
            return Phase::end(None, now);
        }
        Phase::Gather(self)
    }

    /// Where a vehicle is on its way.
    pub fn leg(&self, index: usize) -> Leg {
        self.gather.leg(index)
    }
}

/// The states of those that are ours, in the scenario's order.
fn states(station: &Station, ours: &[usize], now: Duration) -> Vec<Option<State>> {
    station.crew().map(|index| ours.contains(&index).then(|| station.state_now(index, now)).flatten()).collect()
}

/// One step of a gathering for the vehicles of these indices.
pub(super) fn steer(gather: &mut Gather, station: &mut Station, ours: &[usize], now: Duration) {
    if !ours.iter().any(|&index| station.vehicles[index].orders().has_rested(now, PERIOD / 2)) {
        return;
    }
    let states = states(station, ours, now);
    let setpoints = gather.step(&states, now.as_secs_f64());
    for (index, setpoint) in setpoints.into_iter().enumerate() {
        if let Some(setpoint) = setpoint {
            station.steer(index, &setpoint, now);
        }
    }
}

fn least_distance_m(states: &[Option<State>]) -> f64 {
    let known: Vec<&State> = states.iter().flatten().collect();
    let mut least_m = f64::INFINITY;
    for (index, a) in known.iter().enumerate() {
        for b in &known[..index] {
            least_m = least_m.min(slant_m(a, b));
        }
    }
    least_m
}
