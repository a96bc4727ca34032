//! What was told of a flight: each event once, with its time and its vehicle.

use serde::Serialize;
use std::collections::HashSet;

/// How much an event weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weight {
    /// Worth knowing.
    Note,
    /// Worth worrying about; the flight is still what it was meant to be.
    Warning,
    /// The flight is not what it was meant to be: the exit status says so.
    Fault,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// When, s since the station started.
    pub at_s: f64,
    /// Flight time, s; none before the flock flies.
    pub flight_s: Option<f64>,
    /// Number of the vehicle in the scenario, if it is about one.
    pub vehicle: Option<u32>,
    /// How much it weighs.
    pub weight: Weight,
    /// In words.
    pub text: String,
}

impl std::fmt::Display for Event {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.flight_s {
            Some(flight_s) => write!(f, "{flight_s:7.1} s  ")?,
            None => write!(f, "{:7}    ", "")?,
        }
        match self.vehicle {
            Some(vehicle) => write!(f, "vehicle {vehicle}: {}", self.text),
            None => f.write_str(&self.text),
        }
    }
}

/// All events, in order.
#[derive(Debug, Default)]
pub struct Told {
    events: Vec<Event>,
    known: HashSet<(Option<u32>, String)>,
    /// Time zero of the flight, s since the station started.
    pub flight_began_s: Option<f64>,
}

impl Told {
    /// Tells something about a vehicle, or about the flock.
    pub fn tell(&mut self, at_s: f64, vehicle: Option<u32>, weight: Weight, text: impl Into<String>) {
        let flight_s = self.flight_began_s.map(|began_s| at_s - began_s);
        self.events.push(Event { at_s, flight_s, vehicle, weight, text: text.into() });
    }

    /// Tells something only the first time that `what` happens to the vehicle.
    pub fn once(&mut self, at_s: f64, vehicle: Option<u32>, what: &str, weight: Weight, text: impl Into<String>) {
        if self.known.insert((vehicle, what.to_owned())) {
            self.tell(at_s, vehicle, weight, text);
        }
    }

    /// What happened to the vehicle may happen again, and is then told again.
    pub fn forget(&mut self, vehicle: Option<u32>, what: &str) {
        self.known.remove(&(vehicle, what.to_owned()));
    }

    /// All events so far.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// The first fault, if there was one.
    pub fn first_fault(&self) -> Option<&Event> {
        self.events.iter().find(|event| event.weight == Weight::Fault)
    }
}
