//! `columba view --link`: any autopilots that speak on a link, without flying anything.

use super::heard::Flock;
use super::read_plans::PlanReader;
use crate::flying::{Stop, stopped};
use crate::station::peers::Peers;
use crate::station::vehicle::requests::{Carried, POSITION_HZ};
use crate::station::vehicle::routes::Route;
use live_view::{Feed, Scene, VehicleNow, Wind};
use mavlink_bridge::dialect::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType, Message};
use mavlink_bridge::link::{Arrival, Framer, LinkEvent, Links};
use mavlink_bridge::{Counters, Encoder};
use std::time::{Duration, Instant};

/// The listener is no ground station: an autopilot whose own ground station (255) is lost must notice that.
const LISTENER: (u8, u8) = (254, 190);
/// An autopilot that tells no position for so long is asked for it.
const ASK_AFTER: Duration = Duration::from_secs(2);
/// A listener does not know how fast its links are.
const CARRIED: Carried = Carried { position_hz: POSITION_HZ, is_slow: false };
/// Frames are shown so often.
const SHOW: Duration = Duration::from_millis(50);
/// A wind that differs by less is the same.
const WIND_STEP_MPS: f64 = 0.5;
const WIND_STEP_DEG: f64 = 10.0;
const BEAT: Duration = Duration::from_secs(1);

/// What a listener says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asks {
    /// Nothing at all.
    Nothing,
    /// Heartbeats, which some links need before anybody answers, and requests for positions that do not come by
    /// themselves.
    Positions,
    /// That, and requests for plans.
    Plans,
}

/// Shows what is heard until it is stopped, or all links have ended.
pub async fn listen(feed: Feed, mut links: Links, calls: Vec<Route>, asks: Asks, scene: Scene, mut stop: Stop) {
    feed.scene(scene.clone());
    let mut listener = Listener {
        feed,
        scene,
        flock: Flock::new(true),
        peers: Peers::default(),
        counters: Counters::default(),
        readers: Vec::new(),
        started: Instant::now(),
        beat: None,
    };
    for route in calls {
        listener.peers.of(route, Wire::new).is_spoken_to = true;
    }
    let mut next = tokio::time::Instant::now();
    loop {
        tokio::select! {
            biased;
            () = stopped(&mut stop) => return,
            event = links.next() => match event {
                Some(LinkEvent::Arrival(arrival)) => listener.arrive(&arrival),
                Some(LinkEvent::Down(_, reason)) => tracing::warn!("a link is down: {reason}; it is tried again"),
                Some(_) => {}
                None => return,
            },
            () = tokio::time::sleep_until(next) => {
                next = tokio::time::Instant::now() + SHOW;
                listener.show();
                if asks != Asks::Nothing {
                    listener.speak(&mut links, asks == Asks::Plans);
                }
            }
        }
    }
}

struct Listener {
    feed: Feed,
    scene: Scene,
    flock: Flock<Route>,
    peers: Peers<Wire>,
    counters: Counters,
    /// Of the plans of each autopilot.
    readers: Vec<PlanReader>,
    started: Instant,
    beat: Option<Instant>,
}

/// What a peer has sent in part, the numbers of frames to the peer, and whether the peer gets heartbeats.
struct Wire {
    framer: Framer,
    encoder: Encoder,
    is_spoken_to: bool,
}

impl Wire {
    fn new() -> Self {
        Self { framer: Framer::default(), encoder: Encoder::new(LISTENER.0, LISTENER.1), is_spoken_to: false }
    }
}

impl Listener {
    fn arrive(&mut self, arrival: &Arrival) {
        let route = Route { link: arrival.link, peer: arrival.peer };
        let now = arrival.at.saturating_duration_since(self.started);
        let Self { flock, peers, counters, .. } = self;
        let mut heard = false;
        let take = |found: mavlink_bridge::link::Found<'_>| {
            heard |= flock.hear_frame(&found.frame(), route, now).is_some();
        };
        let Wire { framer, is_spoken_to, .. } = peers.of(route, Wire::new);
        if arrival.is_stream {
            framer.push(&arrival.bytes, counters, take);
        } else {
            framer.push_datagram(&arrival.bytes, counters, take);
        }
        *is_spoken_to |= heard;
    }

    /// Plans and wind, if they are others than they were.
    fn show_scene(&mut self, now: Duration) {
        let outlines = self.flock.take_outlines();
        let wind = self.flock.wind(now);
        let differs = |a: &Wind, b: &Wind| {
            let turned_deg = ((a.from_deg - b.from_deg + 180.0).rem_euclid(360.0) - 180.0).abs();
            (a.speed_mps - b.speed_mps).abs() > WIND_STEP_MPS
                || (turned_deg > WIND_STEP_DEG && a.speed_mps > WIND_STEP_MPS)
        };
        let has_turned = match (&wind, &self.scene.wind) {
            (Some(wind), Some(shown)) => differs(wind, shown),
            (wind, shown) => wind.is_some() != shown.is_some(),
        };
        if outlines.is_none() && !has_turned {
            return;
        }
        if let Some(outlines) = outlines {
            self.scene.outlines = outlines;
        }
        if has_turned {
            self.scene.wind = wind;
        }
        self.feed.scene(self.scene.clone());
    }

    fn show(&mut self) {
        let now = self.started.elapsed();
        self.show_scene(now);
        for (at, event) in self.flock.events.drain(..) {
            self.feed.tell(live_view::Event { at_s: at.as_secs_f64(), ..event });
        }
        let (flock, started) = (&self.flock, self.started);
        self.feed.update(|frame| {
            frame.time_s = now.as_secs_f64();
            frame.rate = 1.0;
            frame.phase = if flock.all.is_empty() { "nobody is heard" } else { "" }.to_owned();
            frame.vehicles.resize(flock.all.len(), VehicleNow::default());
            for (index, shown) in frame.vehicles.iter_mut().enumerate() {
                // A link is as old as the position that it brought last.
                let last = flock.all[index].placed.unwrap_or(flock.all[index].last);
                flock.show(index, shown, Some(started + last));
                // The picture is of now: a position that is a while old is moved on, up to when it is stale.
                let age_s = now.saturating_sub(last).as_secs_f32().min(live_view::alarms::STALE_S);
                shown.x_m += libm::cosf(shown.course_rad) * shown.speed_mps * age_s;
                shown.y_m += libm::sinf(shown.course_rad) * shown.speed_mps * age_s;
            }
        });
    }

    fn speak(&mut self, links: &mut Links, asks_for_plans: bool) {
        let now = self.started.elapsed();
        let beats = self.beat.is_none_or(|beat| beat.elapsed() >= BEAT);
        let mut outgoing: Vec<(Route, Vec<Message>)> = Vec::new();
        if beats {
            self.beat = Some(Instant::now());
            let spoken_to = self.peers.iter().filter(|(_, wire)| wire.is_spoken_to);
            outgoing.extend(spoken_to.map(|(route, _)| (route, vec![heartbeat()])));
        }
        for one in &mut self.flock.all {
            let since = now.saturating_sub(one.placed.or(one.vehicle.heard().first_heartbeat).unwrap_or(now));
            if since > ASK_AFTER {
                outgoing.push((one.way, one.vehicle.ask(CARRIED, now)));
            }
        }
        if asks_for_plans {
            self.readers.resize(self.flock.all.len(), PlanReader::default());
            for (one, reader) in self.flock.all.iter().zip(&mut self.readers) {
                // Where its places are is known once it has told one.
                if one.placed.is_some() {
                    let knows_home = one.vehicle.heard().home.is_some();
                    let asked = reader.ask(one.vehicle.target(), &self.flock.plans, knows_home, now);
                    outgoing.push((one.way, asked));
                }
            }
        }
        for (route, messages) in outgoing.into_iter().filter(|(_, messages)| !messages.is_empty()) {
            let encoder = &mut self.peers.of(route, Wire::new).encoder;
            let mut datagram = Vec::new();
            messages.iter().for_each(|message| encoder.encode(message, &mut datagram));
            links.send(route.link, route.peer, datagram);
        }
    }
}

fn heartbeat() -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_GCS,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}
