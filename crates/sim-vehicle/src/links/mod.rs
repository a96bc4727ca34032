//! Whom the vehicle talks to: one link for each peer, with its own sequence numbers and telemetry rates, as an
//! autopilot has them for each of its ports.

mod texts;

use crate::settings::VehicleSettings;
use crate::telemetry::Instruments;
use crate::telemetry::rates::TelemetryRates;
use crate::telemetry::streams::{Schedule, Stream, interval_of};
use crate::world::{Noise, Source};
use mavlink_bridge::dialect::{DialectMessage, MavMissionResult, MavResult, Message};
use mavlink_bridge::{ArduPilotMessage, Counters, Encoder, PlanItemMessage, Target, Version, frames};
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::time::Duration;

/// Who a datagram came from or goes to.
pub type PeerId = SocketAddr;

/// A datagram to send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transmit {
    /// To whom.
    pub to: PeerId,
    /// Whole MAVLink frames, at most 1200 bytes.
    pub datagram: Vec<u8>,
}

/// The largest datagram: below what any network splits.
pub(crate) const DATAGRAM_BYTES_MAX: usize = 1200;
/// A peer that says nothing for so long is forgotten (the ground address never is).
pub(crate) const SILENCE_MAX: Duration = Duration::from_secs(120);
/// Most peers at a time; a new one displaces the most silent. Fifty clients of a group of vehicles speak to all of
/// them.
pub(crate) const LINKS_MAX: usize = 64;

#[derive(Debug)]
pub(crate) struct Links {
    settings: VehicleSettings,
    links: Vec<Link>,
    queue: VecDeque<Transmit>,
    frame: Vec<u8>,
    next_due: Duration,
    recording: bool,
    noise: Noise,
    /// Share of the frames that get lost.
    loss: f64,
    /// Frames that might have been lost so far.
    risked: u64,
    /// The number of the last text that did not fit into one message.
    long_texts: u16,
    /// Host time.
    now: Duration,
}

#[derive(Debug)]
struct Link {
    peer: PeerId,
    permanent: bool,
    heard: Duration,
    encoder: Encoder,
    schedule: Schedule,
    /// The datagram that is being filled.
    open: Vec<u8>,
    /// Datagrams to send again while the peer does not answer.
    batch: Vec<Vec<u8>>,
    /// Frames that have come from it, as far as it matters: more than one is no passer-by.
    frames: u8,
    /// Whether it sends and asks for items of plans by the older messages.
    has_old_items: bool,
    /// Until when, host time, it gets telemetry a quarter as often, and how often each stream has been due since.
    slow_until: Duration,
    due_while_slow: [u8; Stream::COUNT],
    /// The rates that were asked for of messages that have one and no content, by their ids.
    noted_intervals: Vec<(u32, Duration)>,
}

impl Links {
    pub fn new(settings: &VehicleSettings) -> Self {
        let mut links = Self {
            settings: settings.clone(),
            links: Vec::new(),
            queue: VecDeque::new(),
            frame: Vec::new(),
            next_due: Duration::MAX,
            recording: false,
            noise: Noise::new(settings.seed, settings.number),
            loss: 0.0,
            risked: 0,
            long_texts: 0,
            now: Duration::ZERO,
        };
        for &ground in settings.ground.iter().chain(&settings.further_grounds) {
            links.add(ground, true, Duration::ZERO, Duration::ZERO);
        }
        links
    }

    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// The earliest vehicle time at which any link wants telemetry.
    pub fn next_due(&self) -> Duration {
        self.next_due
    }

    /// Sends an item of a plan.
    pub fn send_plan_item(&mut self, index: usize, message: &PlanItemMessage<'_>) {
        self.write(index, |encoder, frame| encoder.encode_plan_item(message, frame));
    }

    /// The peer of a link.
    pub fn peer(&self, index: usize) -> PeerId {
        self.links[index].peer
    }

    /// The link of a peer.
    pub fn of_peer(&self, peer: PeerId) -> Option<usize> {
        self.links.iter().position(|link| link.peer == peer)
    }

    /// From now on such a share of what is sent gets lost, 0 to 1.
    pub fn set_loss(&mut self, loss: f64) {
        self.loss = loss;
    }

    /// From now on the vehicle is this system.
    pub fn set_system_id(&mut self, system_id: u8) {
        self.settings.system_id = system_id;
        for link in &mut self.links {
            link.encoder.system_id = system_id;
        }
    }

    /// Changes the rates of some streams on all links, those to come among them.
    pub fn set_default_rates(&mut self, rates: &TelemetryRates, streams: &[Stream], time: Duration) {
        self.settings.rates = *rates;
        for index in 0..self.links.len() {
            for &stream in streams {
                let interval = self.default_interval(index, stream);
                self.links[index].schedule.set_interval(stream, interval, time);
            }
        }
        self.find_next_due();
    }

    /// Every link is one of another vehicle, as it starts.
    pub fn begin_anew(&mut self, fresh: &Self, time: Duration) {
        self.settings.clone_from(&fresh.settings);
        self.loss = fresh.loss;
        self.set_system_id(fresh.settings.system_id);
        self.restart(time);
    }

    /// Every link has the default rates again.
    pub fn restart(&mut self, time: Duration) {
        for link in &mut self.links {
            link.schedule = default_schedule(&self.settings, link.peer, time);
            link.noted_intervals.clear();
        }
        self.find_next_due();
    }

    /// Notes that a peer has spoken at host time `now`. Gives its link, and whether it is a new one.
    ///
    /// A peer that speaks MAVLink 1 is answered in it, until it says something in MAVLink 2; but not by a PX4.
    pub fn hear(&mut self, peer: PeerId, version: Version, now: Duration, time: Duration) -> (usize, bool) {
        let version = if self.settings.personality.rules().answers_in_mavlink_1 { version } else { Version::V2 };
        if let Some(index) = self.of_peer(peer) {
            let link = &mut self.links[index];
            link.heard = now;
            link.frames = link.frames.saturating_add(1);
            if version == Version::V2 || link.frames == 1 {
                link.encoder.version = version;
            }
            return (index, false);
        }
        if self.links.len() >= LINKS_MAX {
            let learned = self.links.iter().enumerate().filter(|(_, link)| !link.permanent);
            if let Some((index, _)) = learned.min_by_key(|(_, link)| (link.frames > 1, link.heard)) {
                self.links.remove(index);
            }
        }
        let index = self.add(peer, false, now, time);
        self.links[index].encoder.version = version;
        (index, true)
    }

    /// A peer has connected, over a line that tells when it is gone again. Gives its link.
    pub fn open(&mut self, peer: PeerId, now: Duration, time: Duration) -> usize {
        let index = self.add(peer, true, now, time);
        // It has said nothing yet, and so not which version it speaks.
        self.links[index].frames = 0;
        index
    }

    /// A peer that has connected is gone.
    pub fn disconnect(&mut self, peer: PeerId) {
        self.links.retain(|link| link.peer != peer);
        self.find_next_due();
    }

    /// A peer fetches parameters: for a while it gets telemetry a quarter as often, as from an ArduPilot. Two hundred
    /// vehicles at once tell a client more than it can read.
    pub fn slow_down(&mut self, index: usize) {
        const WHILE: Duration = Duration::from_secs(1);
        self.links[index].slow_until = self.now + WHILE;
    }

    /// Notes by which messages a peer sends and asks for items of plans.
    pub fn note_old_items(&mut self, index: usize, has_old_items: bool) {
        self.links[index].has_old_items = has_old_items;
    }

    /// Whether a peer sends and asks for items of plans by the older messages.
    pub fn has_old_items(&self, index: usize) -> bool {
        self.links[index].has_old_items
    }

    /// Takes the host time, and forgets the peers that have been silent for too long.
    pub fn drop_silent(&mut self, now: Duration) {
        self.now = now;
        let is_heard = |link: &Link| link.permanent || now.saturating_sub(link.heard) < SILENCE_MAX;
        if !self.links.iter().all(is_heard) {
            self.links.retain(is_heard);
            self.find_next_due();
        }
    }

    fn add(&mut self, peer: PeerId, permanent: bool, heard: Duration, time: Duration) -> usize {
        let schedule = default_schedule(&self.settings, peer, time);
        self.links.push(Link {
            peer,
            permanent,
            heard,
            encoder: Encoder::new(self.settings.system_id, self.settings.component_id),
            schedule,
            open: Vec::new(),
            batch: Vec::new(),
            frames: 1,
            has_old_items: false,
            slow_until: Duration::ZERO,
            due_while_slow: [0; Stream::COUNT],
            noted_intervals: Vec::new(),
        });
        self.find_next_due();
        self.links.len() - 1
    }

    /// Sends a message, if the peer can be sent it.
    pub fn send(&mut self, index: usize, message: &Message) {
        if self.can_carry(index, message.message_id()) {
            self.write(index, |encoder, frame| encoder.encode(message, frame));
        }
    }

    /// Sends what a stream has to say.
    pub fn send_stream(&mut self, index: usize, stream: Stream, instruments: &Instruments<'_>) {
        match instruments.ardupilot_message(stream) {
            Some(message) => self.send_ardupilot(index, &message),
            None => self.send(index, &instruments.message(stream)),
        }
    }

    /// Sends a message of ArduPilot's dialect.
    pub fn send_ardupilot(&mut self, index: usize, message: &ArduPilotMessage) {
        self.write(index, |encoder, frame| encoder.encode_ardupilot(message, frame));
    }

    pub fn send_all(&mut self, message: &Message) {
        (0..self.links.len()).for_each(|index| self.send(index, message));
    }

    pub fn acknowledge(&mut self, index: usize, command: u16, result: MavResult, target: Target) {
        self.write(index, |encoder, frame| encoder.encode_command_ack(command, result, target, frame));
    }

    pub fn acknowledge_plan(
        &mut self,
        index: usize,
        mission_type: u8,
        result: MavMissionResult,
        plan_id: u32,
        target: Target,
    ) {
        self.write(index, |encoder, frame| encoder.encode_mission_ack(mission_type, result, plan_id, target, frame));
    }

    /// Whether a peer can be sent a message: MAVLink 1 has ids up to 255.
    pub fn can_carry(&self, index: usize, message_id: u32) -> bool {
        self.links[index].encoder.version == Version::V2 || message_id <= 255
    }

    /// Sends what is due on each link.
    pub fn send_due(&mut self, instruments: &Instruments<'_>) {
        for index in 0..self.links.len() {
            for stream in
                self.links[index].schedule.take_due(instruments.time()).filter(|stream| instruments.has(*stream))
            {
                if !self.is_left_out(index, stream) {
                    self.send_stream(index, stream, instruments);
                }
            }
        }
        self.find_next_due();
    }

    /// Whether a stream that is due is left out: three times of four while the peer fetches parameters.
    fn is_left_out(&mut self, index: usize, stream: Stream) -> bool {
        let (now, link) = (self.now, &mut self.links[index]);
        // What is sent again in lockstep must be whole.
        if self.recording || now >= link.slow_until || stream == Stream::Heartbeat {
            return false;
        }
        let due = &mut link.due_while_slow[stream as usize];
        *due = (*due + 1) % 4;
        *due != 0
    }

    /// Sends what is due on each link, and the position last whether it is due or not.
    pub fn send_due_and_position(&mut self, instruments: &Instruments<'_>) {
        for index in 0..self.links.len() {
            for stream in
                self.links[index].schedule.take_due(instruments.time()).filter(|stream| instruments.has(*stream))
            {
                if stream != Stream::LocalPositionNed {
                    self.send_stream(index, stream, instruments);
                }
            }
            self.send_stream(index, Stream::LocalPositionNed, instruments);
        }
        self.find_next_due();
    }

    /// The time between two messages of a stream on one link; none if it is off.
    pub fn interval(&self, index: usize, stream: Stream) -> Option<Duration> {
        self.links[index].schedule.interval(stream)
    }

    /// The same, until somebody asks for another.
    pub fn default_interval(&self, index: usize, stream: Stream) -> Option<Duration> {
        default_interval(&self.settings, self.links[index].peer, stream)
    }

    /// The time between two messages of a stream on one link; none switches it off.
    pub fn set_interval(&mut self, index: usize, stream: Stream, interval: Option<Duration>, time: Duration) {
        self.links[index].schedule.set_interval(stream, interval, time);
        self.find_next_due();
    }

    /// Remembers the rate that was asked for of a message that has no content; none for never.
    pub fn note_interval(&mut self, index: usize, message_id: u32, interval: Option<Duration>) {
        let noted = &mut self.links[index].noted_intervals;
        noted.retain(|(id, _)| *id != message_id);
        noted.extend(interval.map(|interval| (message_id, interval)));
    }

    /// The rate that was asked for of a message that has no content.
    pub fn noted_interval(&self, index: usize, message_id: u32) -> Option<Duration> {
        self.links[index].noted_intervals.iter().find(|(id, _)| *id == message_id).map(|(_, interval)| *interval)
    }

    /// From here to [`end_batch`](Self::end_batch), what is sent is kept to be sent again. What a link kept before is
    /// forgotten if `only` is this link or none.
    pub fn begin_batch(&mut self, only: Option<usize>) {
        self.close_all();
        self.recording = true;
        for (index, link) in self.links.iter_mut().enumerate() {
            if only.is_none_or(|only| only == index) {
                link.batch.clear();
            }
        }
    }

    pub fn end_batch(&mut self) {
        self.close_all();
        self.recording = false;
    }

    /// Sends every link's batch again, byte by byte the same.
    pub fn resend_batch(&mut self) {
        self.close_all();
        for link in &self.links {
            self.queue.extend(link.batch.iter().map(|datagram| Transmit { to: link.peer, datagram: datagram.clone() }));
        }
    }

    /// The next datagram to send.
    pub fn poll(&mut self) -> Option<Transmit> {
        if self.queue.is_empty() {
            self.close_all();
        }
        while let Some(transmit) = self.queue.pop_front() {
            if self.loss == 0.0 {
                return Some(transmit);
            }
            let datagram = self.through_the_radio(&transmit.datagram);
            if !datagram.is_empty() {
                return Some(Transmit { datagram, ..transmit });
            }
        }
        None
    }

    /// What is left of a datagram: each frame for itself may be lost, and what is sent again has a new chance.
    fn through_the_radio(&mut self, datagram: &[u8]) -> Vec<u8> {
        let mut left = Vec::with_capacity(datagram.len());
        for frame in frames(datagram, &mut Counters::default()) {
            self.risked += 1;
            if !self.noise.happens(Source::Radio, self.risked, self.loss) {
                left.extend_from_slice(frame.bytes);
            }
        }
        left
    }

    fn write(&mut self, index: usize, encode: impl FnOnce(&mut Encoder, &mut Vec<u8>)) {
        self.frame.clear();
        encode(&mut self.links[index].encoder, &mut self.frame);
        if self.links[index].open.len() + self.frame.len() > DATAGRAM_BYTES_MAX {
            self.close(index);
        }
        self.links[index].open.extend_from_slice(&self.frame);
    }

    fn close(&mut self, index: usize) {
        let link = &mut self.links[index];
        if link.open.is_empty() {
            return;
        }
        let datagram = std::mem::take(&mut link.open);
        if self.recording {
            link.batch.push(datagram.clone());
        }
        self.queue.push_back(Transmit { to: link.peer, datagram });
    }

    fn close_all(&mut self) {
        (0..self.links.len()).for_each(|index| self.close(index));
    }

    fn find_next_due(&mut self) {
        self.next_due = self.links.iter().map(|link| link.schedule.next()).min().unwrap_or(Duration::MAX);
    }
}

/// The time between two messages of a stream on the link of a peer, until somebody asks for another.
fn default_interval(settings: &VehicleSettings, peer: PeerId, stream: Stream) -> Option<Duration> {
    let rules = settings.personality.rules();
    let known = settings.link_uses.iter().find(|(address, _)| *address == peer).map(|(_, link_use)| *link_use);
    match known.or(settings.other_link_use).and_then(rules.link_rates) {
        Some(rates) => rates.iter().find(|(known, _)| *known == stream).and_then(|(_, rate_hz)| interval_of(*rate_hz)),
        None => stream.default_interval(&settings.rates, rules),
    }
}

fn default_schedule(settings: &VehicleSettings, peer: PeerId, time: Duration) -> Schedule {
    Schedule::new(|stream| default_interval(settings, peer, stream), time)
}

#[cfg(test)]
mod tests;
