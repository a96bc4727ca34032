//! What is kept for each peer, for so many peers of a link and no more: addresses of datagrams are easily forged.

use super::vehicle::routes::Route;
use std::collections::HashMap;

/// So many peers of one link are remembered: more than one for each system id.
pub const PEERS_MAX: usize = 1024;

/// A value for each peer. One peer too many of a link displaces that peer of the same link that was silent longest.
#[derive(Debug)]
pub struct Peers<T> {
    known: HashMap<Route, Known<T>>,
    turn: u64,
}

#[derive(Debug)]
struct Known<T> {
    /// The turn at which it was last asked for.
    turn: u64,
    value: T,
}

impl<T> Default for Peers<T> {
    fn default() -> Self {
        Self { known: HashMap::new(), turn: 0 }
    }
}

impl<T> Peers<T> {
    /// What is kept for a peer, which is not silent now; `new` makes it for one that is not remembered.
    pub fn of(&mut self, route: Route, new: impl FnOnce() -> T) -> &mut T {
        self.turn += 1;
        let turn = self.turn;
        if !self.known.contains_key(&route) {
            self.make_room(route.link);
        }
        let known = self.known.entry(route).or_insert_with(|| Known { turn, value: new() });
        known.turn = turn;
        &mut known.value
    }

    /// Forgets a peer that is gone.
    pub fn forget(&mut self, route: Route) {
        self.known.remove(&route);
    }

    /// All peers that are remembered, in no order.
    pub fn iter(&self) -> impl Iterator<Item = (Route, &T)> {
        self.known.iter().map(|(route, known)| (*route, &known.value))
    }

    fn make_room(&mut self, link: usize) {
        let of_link = || self.known.iter().filter(|(route, _)| route.link == link);
        if of_link().count() < PEERS_MAX {
            return;
        }
        if let Some(silent) = of_link().min_by_key(|(_, known)| known.turn).map(|(route, _)| *route) {
            self.known.remove(&silent);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::link::Peer;
    use std::net::{Ipv4Addr, SocketAddr};

    fn route(link: usize, port: u16) -> Route {
        Route { link, peer: Peer::Address(SocketAddr::from((Ipv4Addr::LOCALHOST, port))) }
    }

    #[test]
    fn forged_addresses_displace_only_the_silent_ones_of_their_link() {
        let mut peers: Peers<u32> = Peers::default();
        *peers.of(route(0, 1), || 0) = 7;
        *peers.of(route(1, 1), || 0) = 8;
        *peers.of(route(1, 2), || 0) = 9;
        for port in 1000..60_000 {
            peers.of(route(1, port), || 0);
            peers.of(route(1, 2), || 0);
        }
        assert_eq!(peers.iter().filter(|(route, _)| route.link == 1).count(), PEERS_MAX);
        assert_eq!(*peers.of(route(0, 1), || 0), 7, "another link");
        assert_eq!(*peers.of(route(1, 2), || 0), 9, "one that goes on to speak");
        assert_eq!(*peers.of(route(1, 1), || 0), 0, "the one that was silent");
    }

    #[test]
    fn one_that_is_gone_is_forgotten() {
        let mut peers: Peers<u32> = Peers::default();
        *peers.of(route(0, 1), || 0) = 7;
        peers.forget(route(0, 1));
        assert_eq!(peers.iter().count(), 0);
    }
}
