//! What the operator says while the flock flies, and how vehicles are brought to do so.

use crate::station::operator::Verb;
use crate::station::told::Weight;
use crate::station::{Station, number};
use mavlink_bridge::kind::AtEnd;
use std::time::Duration;

/// Whether the operator has paused the flight.
#[derive(Debug, Default)]
pub struct Pause {
    is_paused: bool,
    /// It was resumed, and not all vehicles follow yet.
    is_resuming: bool,
}

impl Pause {
    /// Whether the operator has paused it, and not all vehicles follow again.
    pub fn holds(&self) -> bool {
        self.is_paused || self.is_resuming
    }

    /// Whether vehicles are still to be brought back ([`Self::resume`]).
    pub fn is_resuming(&self) -> bool {
        self.is_resuming
    }

    /// Carries out what the operator said.
    pub fn obey(&mut self, station: &mut Station, now: Duration) {
        for verb in station.take_verbs() {
            self.take(station, verb, now);
        }
        for index in station.crew() {
            self.bring(station, index, now);
        }
    }

    fn take(&mut self, station: &mut Station, verb: Verb, now: Duration) {
        let now_s = now.as_secs_f64();
        let crew = station.crew();
        let (Verb::PauseOne(vehicle) | Verb::ResumeOne(vehicle) | Verb::Drop(vehicle, _) | Verb::Take(vehicle)) = verb
        else {
            match verb {
                Verb::Pause if !self.is_paused => {
                    self.is_paused = true;
                    station.told.tell(now_s, None, Weight::Note, "paused by the operator: all hold where they are");
                }
                Verb::Resume if self.is_paused => {
                    *self = Self { is_paused: false, is_resuming: true };
                    crew.for_each(|index| station.vehicles[index].custody_mut().resume_with_all());
                    station.told.tell(now_s, None, Weight::Note, "resumed by the operator");
                }
                _ => {}
            }
            return;
        };
        let Some(index) = vehicle.checked_sub(1).filter(|index| crew.contains(index)) else {
            station.told.tell(now_s, None, Weight::Note, format!("there is no vehicle {vehicle}"));
            return;
        };
        let custody = station.vehicles[index].custody_mut();
        let (weight, text) = match verb {
            Verb::PauseOne(_) => {
                custody.pause();
                (Weight::Note, "paused by the operator: it holds where it is")
            }
            Verb::Drop(_, to) => {
                custody.drop_out(to);
                let text = match to {
                    AtEnd::Return => "dropped by the operator: it returns, and is flown no more",
                    AtEnd::Land => "dropped by the operator: it lands, and is flown no more",
                    _ => "dropped by the operator: it holds where it is, and is flown no more",
                };
                (Weight::Warning, text)
            }
            Verb::Take(_) => {
                custody.take_back();
                (Weight::Note, "taken back by the operator")
            }
            _ if custody.resume() => (Weight::Note, "resumed by the operator"),
            _ => return,
        };
        station.told.tell(now_s, Some(number(index)), weight, text);
    }

    /// Brings a vehicle into the mode in which it is to be.
    fn bring(&self, station: &mut Station, index: usize, now: Duration) {
        let vehicle = &station.vehicles[index];
        let Some(driver) = vehicle.driver() else { return };
        let dropped = vehicle.custody().dropped();
        let is_paused = self.is_paused || vehicle.custody().is_paused();
        let holds = dropped.is_some() || (is_paused && vehicle.is_ours());
        let mode = driver.end_mode(dropped.unwrap_or(AtEnd::Loiter));
        let is_told_otherwise = dropped.is_some() && vehicle.holds() && mode != Some(vehicle.heard().custom_mode);
        if holds && (vehicle.follows() || is_told_otherwise) {
            if let Some(mode) = mode {
                station.order(index, "hold", driver.set_mode(vehicle.target(), mode), now);
                station.vehicles[index].custody_mut().was_told_to_hold(now);
            }
        } else if vehicle.is_ours() && vehicle.custody().is_to_be_brought() && !is_paused && !vehicle.on_ground() {
            if vehicle.follows_for_good() {
                station.vehicles[index].custody_mut().enter();
            } else {
                station.order(index, "take over", driver.take_over(vehicle.target()), now);
            }
        }
    }

    /// Brings all back into the mode in which they follow; whether all are.
    pub fn resume(&mut self, station: &mut Station, now: Duration) -> bool {
        self.is_resuming = false;
        for index in station.crew() {
            let vehicle = &station.vehicles[index];
            let Some(driver) = vehicle.driver().cloned().filter(|_| vehicle.is_ours()) else { continue };
            if vehicle.follows_for_good() {
                continue;
            }
            self.is_resuming = true;
            let take_over = driver.take_over(vehicle.target());
            if let Some(state) = station.state_now(index, now).filter(|_| driver.repeat_every().is_some()) {
                station.steer(index, &state.hold(), now);
            }
            station.order(index, "take over", take_over, now);
        }
        !self.is_resuming
    }
}
