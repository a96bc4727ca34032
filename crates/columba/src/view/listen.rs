//! `columba view --link`: any autopilots that speak on a link, without flying anything.

use super::heard::Flock;
use crate::flying::{Stop, stopped};
use crate::station::peers::Peers;
use crate::station::telemetry;
use crate::station::vehicle::Route;
use live_view::{Feed, Scene, VehicleNow};
use mavlink_bridge::dialect::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType, Message};
use mavlink_bridge::link::{Arrival, Framer, LinkEvent, Links};
use mavlink_bridge::{Counters, Encoder};
use std::time::{Duration, Instant};

/// The listener is no ground station: an autopilot whose own ground station (255) is lost must notice that.
const LISTENER: (u8, u8) = (254, 190);
/// An autopilot that tells no position for so long is asked for it.
const ASK_AFTER: Duration = Duration::from_secs(2);
/// Frames are shown so often.
const SHOW: Duration = Duration::from_millis(50);
const BEAT: Duration = Duration::from_secs(1);

/// Shows what is heard until it is stopped, or all links have ended. `speaks` lets it send heartbeats, which some links
/// need before anybody answers, and ask for positions that do not come by themselves.
pub async fn listen(feed: Feed, mut links: Links, calls: Vec<Route>, speaks: bool, scene: Scene, mut stop: Stop) {
    feed.scene(scene);
    let mut listener = Listener {
        feed,
        flock: Flock::new(true),
        peers: Peers::default(),
        counters: Counters::default(),
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
                if speaks {
                    listener.speak(&mut links);
                }
            }
        }
    }
}

struct Listener {
    feed: Feed,
    flock: Flock<Route>,
    peers: Peers<Wire>,
    counters: Counters,
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
            let frame = found.frame();
            if let Ok(message) = frame.message() {
                heard |= flock.hear(&frame.header, &message, route, now).is_some();
            }
        };
        let Wire { framer, is_spoken_to, .. } = peers.of(route, Wire::new);
        if arrival.is_stream {
            framer.push(&arrival.bytes, counters, take);
        } else {
            framer.push_datagram(&arrival.bytes, counters, take);
        }
        *is_spoken_to |= heard;
    }

    fn show(&mut self) {
        let now = self.started.elapsed();
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

    fn speak(&mut self, links: &mut Links) {
        let now = self.started.elapsed();
        let beats = self.beat.is_none_or(|beat| beat.elapsed() >= BEAT);
        let mut outgoing: Vec<(Route, Vec<Message>)> = Vec::new();
        if beats {
            self.beat = Some(Instant::now());
            let spoken_to = self.peers.iter().filter(|(_, wire)| wire.is_spoken_to);
            outgoing.extend(spoken_to.map(|(route, _)| (route, vec![heartbeat()])));
        }
        for one in &mut self.flock.all {
            let since = now.saturating_sub(one.placed.or(one.vehicle.first_heartbeat).unwrap_or(now));
            if since > ASK_AFTER {
                outgoing.push((one.way, telemetry::ask(&mut one.vehicle, telemetry::POSITION_HZ, false, now)));
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
