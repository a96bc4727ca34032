//! Fifth phase: every vehicle is armed, in the mode in which it follows setpoints, and its position is fresh. The
//! flight's time zero is when this is so. Vehicles that are in the air from the beginning come straight here.

use super::Phase;
use super::fly::Fly;
use crate::station::told::Weight;
use crate::station::{Station, number};
use mavlink_bridge::kind::Launch;
use std::time::Duration;

/// So long it may take.
const PATIENCE: Duration = Duration::from_secs(30);

/// Takes the vehicles over.
pub struct HandOver {
    began: Duration,
}

impl HandOver {
    pub(super) fn new(now: Duration) -> Self {
        Self { began: now }
    }

    pub(super) fn step(self, station: &mut Station, now: Duration) -> Phase {
        if station.stopped().is_some() {
            return Phase::end(None, now);
        }
        station.watch_modes(false, now);
        let mut waiting = Vec::new();
        let ours: Vec<usize> = station.crew().filter(|&index| station.vehicles[index].is_ours()).collect();
        for &index in &ours {
            let vehicle = &station.vehicles[index];
            let Some(driver) = vehicle.driver().cloned() else { continue };
            let (target, seen) = (vehicle.target(), vehicle.seen());
            let state = station.state_now(index, now);
            // Some follow only once a stream of setpoints runs.
            if let Some(state) = state.filter(|_| driver.repeat_every().is_some()) {
                station.steer(index, &station.vehicles[index].orders().setpoint().unwrap_or(state.hold()), now);
            }
            match driver.launch(target, &seen, 0.0) {
                Launch::Flying if state.is_some() => station.vehicles[index].custody_mut().enter(),
                Launch::Send(message) => {
                    station.order(index, "take over", message, now);
                    waiting.push(index);
                }
                _ => waiting.push(index),
            }
        }
        if waiting.is_empty() && !ours.is_empty() {
            return match Fly::new(station, now) {
                Ok(fly) => Phase::Fly(Box::new(fly)),
                Err(error) => {
                    station.told.tell(now.as_secs_f64(), None, Weight::Fault, error);
                    station.stop("the flock cannot fly", false);
                    Phase::end(None, now)
                }
            };
        }
        if now.saturating_sub(self.began) > PATIENCE || ours.is_empty() {
            for index in waiting {
                let vehicle = &station.vehicles[index];
                let answer = vehicle.orders().answer("take over").unwrap_or("no answer");
                let words = vehicle.heard().words_since(self.began);
                let words = words.map(|words| format!(", {words}")).unwrap_or_default();
                let text = format!("could not be taken over: {}, {answer}{words}", vehicle.mode_name());
                station.told.tell(now.as_secs_f64(), Some(number(index)), Weight::Fault, text);
            }
            station.stop("not all could be taken over", false);
            return Phase::end(None, now);
        }
        Phase::HandOver(self)
    }
}
