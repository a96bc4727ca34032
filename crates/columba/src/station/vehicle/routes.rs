//! The ways by which a vehicle is heard, and whether what comes by them is its own.

use super::place;
use mavlink_bridge::dialect::{GLOBAL_POSITION_INT_DATA, Message};
use mavlink_bridge::link::Peer;
use std::collections::BTreeMap;
use std::time::Duration;

/// So many ways to a vehicle are remembered: addresses are easily forged, and each is spoken to.
const ROUTES_MAX: usize = 16;
/// A way by which nothing came for so long is silent.
const SILENT: Duration = Duration::from_millis(1500);

/// A way by which a vehicle is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Route {
    /// Index of the link.
    pub link: usize,
    /// Who is at the other end.
    pub peer: Peer,
}

/// Whether a route leads to the vehicle, or to another autopilot with the same system id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    /// It is the vehicle's: it was there before the take-off, or its positions are the vehicle's.
    Own,
    /// It is new in flight: nothing by it is taken before its positions have shown whose it is.
    New,
    /// Another autopilot's, by its positions: nothing by it is taken.
    Other,
}

#[derive(Clone, Copy, Debug)]
struct RouteState {
    /// When a frame of the vehicle last came by it.
    heard: Duration,
    trust: Trust,
}

/// All ways to one vehicle.
#[derive(Debug, Default)]
pub struct Routes {
    known: BTreeMap<Route, RouteState>,
    /// The last position that was taken for the vehicle's own, the route by which it came, and when.
    last: Option<(GLOBAL_POSITION_INT_DATA, Route, Duration)>,
    is_doubled: bool,
}

impl Routes {
    /// All that are remembered.
    pub fn iter(&self) -> impl Iterator<Item = Route> {
        self.known.keys().copied()
    }

    /// Whether the vehicle is heard by a route.
    pub fn has(&self, route: Route) -> bool {
        self.known.contains_key(&route)
    }

    /// The freshest way to the vehicle.
    pub fn freshest(&self) -> Option<Route> {
        let own = self.known.iter().filter(|(_, state)| state.trust == Trust::Own);
        own.max_by_key(|(_, state)| state.heard).map(|(route, _)| *route)
    }

    /// Whether a route leads to another autopilot with the same system id, by its positions.
    pub fn is_anothers(&self, route: Route) -> bool {
        self.known.get(&route).is_some_and(|state| state.trust == Trust::Other)
    }

    /// Whether two autopilots spoke with this system id before the take-off.
    pub fn is_doubled(&self) -> bool {
        self.is_doubled
    }

    /// Whether a message that came by a route is the vehicle's own. A second autopilot with the same system id that
    /// comes up in flight is none of the vehicle: neither its positions nor its modes count. Before the take-off that
    /// is a fault ([`Self::is_doubled`]).
    pub fn owns(&mut self, message: &Message, route: Route, is_flying: bool, now: Duration) -> bool {
        let speaks = self.known.iter().any(|(other, state)| {
            *other != route && state.trust == Trust::Own && now.saturating_sub(state.heard) < SILENT
        });
        // A vehicle that is heard by no other way has a new address, and is itself.
        let first = if is_flying && speaks { Trust::New } else { Trust::Own };
        self.make_room_for(route);
        let before = self.known.get(&route).map_or(first, |state| state.trust);
        let mut trust = if speaks || before == Trust::Other { before } else { Trust::Own };
        if let Message::GLOBAL_POSITION_INT(data) = message {
            match (self.contradicts_another(data, route, now), is_flying) {
                (true, false) => self.is_doubled = true,
                (true, true) if trust == Trust::New => trust = Trust::Other,
                (false, _) if trust == Trust::New => trust = Trust::Own,
                _ => {}
            }
            if trust == Trust::Own {
                self.last = Some((data.clone(), route, now));
            }
        }
        self.known.insert(route, RouteState { heard: now, trust });
        trust == Trust::Own
    }

    /// One way too many displaces another: before all one that is not known to be the vehicle's, else the one that was
    /// silent longest.
    fn make_room_for(&mut self, route: Route) {
        if self.known.len() < ROUTES_MAX || self.has(route) {
            return;
        }
        let least = self.known.iter().min_by_key(|(_, state)| (state.trust == Trust::Own, state.heard));
        if let Some(least) = least.map(|(route, _)| *route) {
            self.known.remove(&least);
        }
    }

    /// Whether a position by one route contradicts the last one by another: two autopilots speak with one system id
    /// then.
    fn contradicts_another(&self, data: &GLOBAL_POSITION_INT_DATA, route: Route, now: Duration) -> bool {
        let Some((last, other, heard)) = &self.last else { return false };
        let since = now.saturating_sub(*heard);
        if *other == route || since > SILENT {
            return false;
        }
        let since_s = since.as_secs_f64();
        let speed_mps = 0.01 * libm::hypot(f64::from(data.vx), f64::from(data.vy));
        let moved_m = 5.0 + 2.0 * speed_mps * since_s.max(0.5);
        let stamps_s = 1e-3 * f64::from(data.time_boot_ms.abs_diff(last.time_boot_ms));
        place::apart_m(data, last) > moved_m || stamps_s > 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::HEARTBEAT_DATA;

    #[test]
    fn forged_addresses_do_not_displace_the_way_to_it() {
        let beat = Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT);
        let way = |port: u16| Route { link: 0, peer: Peer::Address(([127, 0, 0, 1], port).into()) };
        let mut routes = Routes::default();
        assert!(routes.owns(&beat, way(1), false, Duration::ZERO));
        for port in 1000..5000 {
            let now = Duration::from_millis(u64::from(port));
            routes.owns(&beat, way(1), true, now);
            assert!(!routes.owns(&beat, way(port), true, now), "nobody knows whose that is");
        }
        assert_eq!(routes.iter().count(), ROUTES_MAX);
        assert_eq!(routes.freshest(), Some(way(1)));
    }
}
