//! The station's shell: links, clocks, the terminal and the files around the sans-I/O core.

use super::peers::Peers;
use super::phase::Phase;
use super::record::{self, Recording};
use super::vehicle::routes::Route;
use super::{GROUND, Station, operator, outcome, table};
use crate::flight::Flight;
use crate::flying::Stop;
use crate::view::StationView;
use mavlink_bridge::link::{
    Arrival, Connection, Framer, LinkEvent, Links, Peer, Rejected, Signing, SigningKey, signing_time,
};
use mavlink_bridge::{Counters, Encoder, SequenceTracker};
use serde_json::json;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};
use tokio::sync::mpsc;

/// The core is looked after so often, on the wall clock.
const POLL: Duration = Duration::from_millis(20);
/// The table is drawn so often.
const DRAW: Duration = Duration::from_millis(500);

/// What surrounds the core.
pub struct Surroundings {
    /// The open links.
    pub links: Links,
    /// What they are, in the same order.
    pub connections: Vec<Connection>,
    /// Signs and verifies, where there is a key.
    pub key: Option<SigningKey>,
    /// Vehicle seconds for each second of the wall clock.
    pub speed: f64,
    /// Neither table nor events.
    pub quiet: bool,
    /// The page, where one is asked for.
    pub view: Option<StationView>,
}

/// Flies to the end; everything is in the folder as it flies.
///
/// # Errors
/// When the record cannot be begun.
pub async fn run(mut station: Station, around: Surroundings, folder: &Path, mut stop: Stop) -> anyhow::Result<Flight> {
    let recording = Recording::begin(folder)?;
    let mut shell = Shell::new(around, recording);
    shell.begin(&mut station);
    let mut lines = operator_lines();
    let mut next_poll = tokio::time::Instant::now();
    let mut asked_to_stop = false;
    while !station.is_over() {
        tokio::select! {
            biased;
            event = shell.links.next() => match event {
                Some(event) => shell.take(&mut station, event),
                None => station.stop("all links have ended", false),
            },
            () = tokio::time::sleep_until(next_poll) => {}
            Some(line) = lines.recv() => match line.parse::<operator::Verb>() {
                Ok(verb) => station.operate(verb, "from the terminal"),
                Err(error) => if !line.trim().is_empty() { eprintln!("columba: {error}") },
            },
            Some(said) = next_said(&mut shell.view) => StationView::obey(&mut station, said),
            () = crate::flying::stopped(&mut stop), if !asked_to_stop => {
                asked_to_stop = true;
                station.stop("interrupted", true);
            }
        }
        while let Some(event) = shell.links.try_next() {
            shell.take(&mut station, event);
        }
        station.poll(shell.now(Instant::now()));
        shell.give(&mut station);
        next_poll = tokio::time::Instant::now() + POLL.div_f64(shell.speed.max(1.0));
    }
    Ok(shell.end(station))
}

/// What a peer has sent in part, and the numbers of frames each way.
struct Wire {
    framer: Framer,
    sequence: SequenceTracker,
    encoder: Encoder,
}

impl Wire {
    fn new() -> Self {
        let (framer, sequence) = (Framer::default(), SequenceTracker::default());
        Self { framer, sequence, encoder: Encoder::new(GROUND.0, GROUND.1) }
    }
}

struct Shell {
    links: Links,
    connections: Vec<Connection>,
    signing: Option<Signing>,
    rejected: Vec<Rejected>,
    speed: f64,
    quiet: bool,
    view: Option<StationView>,
    recording: Recording,
    started: Instant,
    started_us: u64,
    peers: Peers<Wire>,
    counters: Vec<Counters>,
    events_told: usize,
    drawn: usize,
    draw_at: Instant,
}

impl Shell {
    fn new(around: Surroundings, recording: Recording) -> Self {
        let Surroundings { links, connections, key, speed, quiet, view } = around;
        let now = unix();
        Self {
            counters: vec![Counters::default(); connections.len()],
            links,
            rejected: vec![Rejected::default(); connections.len()],
            connections,
            signing: key.map(|key| Signing::new(key, signing_time(now))),
            speed,
            quiet,
            view,
            recording,
            started: Instant::now(),
            started_us: now.as_micros() as u64,
            peers: Peers::default(),
            events_told: 0,
            drawn: 0,
            draw_at: Instant::now(),
        }
    }

    fn begin(&mut self, station: &mut Station) {
        let summary = outcome::planned(station);
        let field = crate::flying::field(&station.scenario);
        let settings = crate::flying::settings(&station.scenario);
        self.recording.line(record::header_line(&summary, &field, &settings));
        let open: Vec<String> = self
            .connections
            .iter()
            .filter(|connection| self.signing.is_none() && !connection.is_loopback())
            .map(ToString::to_string)
            .collect();
        if !open.is_empty() {
            let text = format!(
                "commands go unsigned beyond this machine, by {}: whoever hears them can send the like (--signing-key \
                 FILE)",
                open.join(", ")
            );
            station.told.tell(0.0, None, super::told::Weight::Warning, text);
        }
    }

    /// Station time of an instant.
    fn now(&self, at: Instant) -> Duration {
        at.saturating_duration_since(self.started).mul_f64(self.speed)
    }

    fn unix_us(&self, at: Instant) -> u64 {
        self.started_us + at.saturating_duration_since(self.started).as_micros() as u64
    }

    fn take(&mut self, station: &mut Station, event: LinkEvent) {
        let name = |link: usize| self.connections.get(link).map(ToString::to_string).unwrap_or_default();
        let now_s = self.now(Instant::now()).as_secs_f64();
        match event {
            LinkEvent::Arrival(arrival) => self.arrive(station, &arrival),
            LinkEvent::Up(link) => tracing::debug!(link = name(link), "up"),
            LinkEvent::Down(link, reason) => {
                let text = format!("{} is down: {reason}; it is tried again", name(link));
                station.told.once(now_s, None, &text.clone(), super::told::Weight::Warning, text);
            }
            LinkEvent::Gone(link, peer) => self.peers.forget(Route { link, peer }),
        }
    }

    fn arrive(&mut self, station: &mut Station, arrival: &Arrival) {
        let route = Route { link: arrival.link, peer: arrival.peer };
        let (now, at_us) = (self.now(arrival.at), self.unix_us(arrival.at));
        let signed_at = signing_time(unix());
        let Wire { framer, sequence, .. } = self.peers.of(route, Wire::new);
        let (Some(counters), Some(rejected)) =
            (self.counters.get_mut(arrival.link), self.rejected.get_mut(arrival.link))
        else {
            return;
        };
        let (recording, mut signing) = (&self.recording, self.signing.as_mut());
        let mut lost = Counters::default();
        let take = |found: mavlink_bridge::link::Found<'_>| {
            let frame = found.frame();
            if let Some(signing) = signing.as_deref_mut()
                && let Err(rejection) = signing.verify(&frame, signed_at)
            {
                rejected.count(rejection);
                return;
            }
            recording.frame(at_us, frame.bytes);
            station.count(&frame, sequence, &mut lost);
            if matches!(found, mavlink_bridge::link::Found::Verified(_)) {
                station.hear(&frame, route, now);
            }
        };
        if arrival.is_stream {
            framer.push(&arrival.bytes, counters, take);
        } else {
            framer.push_datagram(&arrival.bytes, counters, take);
        }
        *counters += lost;
    }

    /// Sends, writes and shows what the core has.
    fn give(&mut self, station: &mut Station) {
        let now = Instant::now();
        let at_us = self.unix_us(now);
        for outgoing in station.take_outgoing() {
            let encoder = &mut self.peers.of(outgoing.route, Wire::new).encoder;
            let (link, peer) = (outgoing.route.link, outgoing.route.peer);
            let mut datagram = Vec::new();
            for message in &outgoing.messages {
                let mut frame = Vec::new();
                encoder.encode(message, &mut frame);
                if let Some(signing) = &mut self.signing {
                    let mut signed = Vec::new();
                    signing.sign(link as u8, &frame, signing_time(unix()), &mut signed);
                    frame = signed;
                }
                self.recording.frame(at_us, &frame);
                datagram.extend_from_slice(&frame);
            }
            if let Some(counters) = self.counters.get_mut(link) {
                counters.datagrams_sent += 1;
                counters.bytes_sent += datagram.len() as u64;
            }
            self.links.send(link, peer, datagram);
        }
        if let Some(trouble) = self.recording.take_trouble() {
            let now_s = self.now(now).as_secs_f64();
            station.told.tell(now_s, None, super::told::Weight::Fault, trouble);
        }
        for line in station.take_journal() {
            self.recording.line(line);
        }
        let events = station.told.events();
        if self.events_told < events.len() && !self.quiet {
            self.erase();
            for event in &events[self.events_told..] {
                eprintln!("{event}");
            }
        }
        for event in &events[self.events_told..] {
            self.recording.line(record::event_line(event));
        }
        self.events_told = events.len();
        let station_now = self.now(now);
        if let Some(view) = &mut self.view {
            view.show(station, station_now, now, self.speed);
            station.watch(view.watched(station));
        }
        if !self.quiet && std::io::stderr().is_terminal() && now >= self.draw_at {
            self.draw_at = now + DRAW;
            self.erase();
            let recent_m = match station.phase() {
                Phase::Fly(fly) => fly.recent_m(),
                _ => [f64::INFINITY; 2],
            };
            let lines = table::lines(station, recent_m, self.now(now));
            self.drawn = lines.len();
            lines.iter().for_each(|line| eprintln!("{line}"));
        }
    }

    /// Takes the table off the terminal.
    fn erase(&mut self) {
        if self.drawn > 0 {
            let _ = write!(std::io::stderr(), "\x1b[{}A\x1b[J", self.drawn);
            self.drawn = 0;
        }
    }

    fn end(mut self, mut station: Station) -> Flight {
        let refused = self.view.as_ref().and_then(StationView::refused);
        if let Some(text) = refused {
            let now_s = self.now(Instant::now()).as_secs_f64();
            station.told.tell(now_s, None, super::told::Weight::Note, text);
        }
        self.give(&mut station);
        self.erase();
        let wall = self.started.elapsed();
        for (link, counters) in self.counters.iter_mut().enumerate() {
            *counters += self.links.socket_counters(link);
        }
        let total: Counters = self.counters.iter().copied().sum();
        let mut links = serde_json::to_value(total).unwrap_or_default();
        let is_signed = self.signing.is_some();
        let each: Vec<serde_json::Value> = self
            .connections
            .iter()
            .enumerate()
            .map(|(link, connection)| {
                json!({
                    "link": connection.to_string(),
                    "counters": self.counters.get(link),
                    "overflows": self.links.overflows(link),
                    "signed": is_signed,
                    "rejected": self.rejected.get(link).filter(|_| is_signed),
                })
            })
            .collect();
        let rejected = self.rejected.iter().fold(Rejected::default(), |all, one| Rejected {
            unsigned: all.unsigned + one.unsigned,
            forged: all.forged + one.forged,
            replayed: all.replayed + one.replayed,
        });
        if let Some(object) = links.as_object_mut() {
            object.insert("links".to_owned(), json!(each));
            object.insert("rejected".to_owned(), json!(rejected));
        }
        let flight = outcome::flight(station, wall, links);
        self.recording.line(record::end_line());
        self.recording.end();
        flight
    }
}

/// What is said on the page next; without a page, nothing ever.
async fn next_said(view: &mut Option<StationView>) -> Option<live_view::Said> {
    match view {
        Some(view) => view.next_said().await,
        None => std::future::pending().await,
    }
}

fn unix() -> Duration {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default()
}

/// What the operator types, line by line. Nothing where the program is in the background of a terminal: to read there
/// would stop it.
fn operator_lines() -> mpsc::UnboundedReceiver<String> {
    let (tell, lines) = mpsc::unbounded_channel();
    if !std::io::stdin().is_terminal() || is_in_foreground() {
        let reader = std::thread::Builder::new().name("operator".to_owned());
        // It ends with the program, or with its input.
        let _ = reader.spawn(move || {
            for line in std::io::stdin().lines().map_while(Result::ok) {
                if tell.send(line).is_err() {
                    return;
                }
            }
        });
    }
    lines
}

/// Whether the terminal listens to this program (`/proc/self/stat`, fields 5 and 8); where that cannot be known, yes.
fn is_in_foreground() -> bool {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    match (fields.get(2), fields.get(5)) {
        (Some(group), Some(foreground)) => group == foreground,
        _ => true,
    }
}

/// Whom a link speaks to before anybody was heard.
pub fn calls(link: usize, connection: &Connection) -> Option<Route> {
    let is_single = matches!(connection, Connection::UdpOut(_) | Connection::TcpOut(_) | Connection::Serial { .. });
    is_single.then_some(Route { link, peer: Peer::Only })
}
