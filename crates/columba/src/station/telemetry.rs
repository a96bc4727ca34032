//! Heartbeats, questions for the time, and requests for telemetry: what the station says in every phase.

use super::told::Weight;
use super::vehicle::requests::{self, Carried, time_request};
use super::vehicle::routes::Route;
use super::{Outgoing, Station};
use mavlink_bridge::telemetry::ground_heartbeat;
use std::collections::BTreeSet;
use std::time::Duration;

/// The station's heartbeat, and its question for the time.
const BEAT: Duration = Duration::from_secs(1);

impl Station {
    /// Says what is due.
    pub(super) fn keep_house(&mut self, now: Duration) {
        if self.beat.is_none_or(|beat| now.saturating_sub(beat) >= BEAT) {
            self.beat = Some(now);
            self.beat_on_all_routes(now);
        }
        for index in 0..self.vehicles.len() {
            self.ask(index, now);
        }
    }

    fn beat_on_all_routes(&mut self, now: Duration) {
        let mut routes: BTreeSet<Route> = self.settings.calls.iter().copied().collect();
        routes.extend(self.vehicles.iter().flat_map(|vehicle| vehicle.routes().iter()));
        for route in routes {
            let mut messages = vec![ground_heartbeat()];
            let here = self.vehicles.iter().filter(|vehicle| vehicle.routes().has(route));
            messages.extend(here.map(|vehicle| time_request(vehicle.target(), now)));
            self.outbox.push(Outgoing { route, messages });
        }
    }

    fn ask(&mut self, index: usize, now: Duration) {
        let Some(route) = self.vehicles[index].routes().freshest() else { return };
        let carried = self.carried(route);
        let messages = self.vehicles[index].ask(carried, now);
        if messages.is_empty() {
            return;
        }
        if carried.is_slow {
            let text = "its link is slow: streams that are not needed are silenced";
            self.tell_once(index, "silenced", Weight::Note, text, now);
        }
        if carried.position_hz < requests::POSITION_HZ {
            let text = format!("positions at {:.1} Hz: that is what its link carries", carried.position_hz);
            self.tell_once(index, "slow link", Weight::Note, text, now);
        }
        self.outbox.push(Outgoing { route, messages });
    }

    /// The rate at which positions of a vehicle are to come, Hz.
    pub fn position_hz(&self, index: usize) -> f64 {
        let route = self.vehicles.get(index).and_then(|vehicle| vehicle.routes().freshest());
        route.map_or(requests::POSITION_HZ, |route| self.carried(route).position_hz)
    }

    /// What a route carries for each of the vehicles that are heard by it.
    fn carried(&self, route: Route) -> Carried {
        let capacity = self.settings.capacities.get(route.link).copied().flatten();
        let sharing = self.vehicles.iter().filter(|vehicle| vehicle.routes().has(route)).count();
        Carried { position_hz: requests::position_hz(capacity, sharing), is_slow: capacity.is_some() }
    }
}
