//! An autopilot with its links: what it tells of its own accord, and what it tells it from.

use crate::autopilot::Autopilot;
use crate::autopilot::event::Event;
use crate::counters::VehicleCounters;
use crate::error::Severity;
use crate::links::{Links, PeerId};
use crate::settings::VehicleSettings;
use crate::telemetry::Instruments;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MISSION_ITEM_REACHED_DATA, MavResult, MavSeverity, Message};
use mavlink_bridge::{Target, Version};
use std::time::Duration;

/// An autopilot and its links: a component, as MAVLink has it.
#[derive(Debug)]
pub(crate) struct Component {
    /// Who it is: its system id and its rates may change.
    pub settings: VehicleSettings,
    pub autopilot: Autopilot,
    /// By [`links`](Self::links): what is not yet told goes first.
    links: Links,
    /// Commands and frames; the autopilot counts the rest.
    pub counters: VehicleCounters,
    pub host_now: Duration,
    /// Messages that have been asked for and follow their acknowledgement, each with its link.
    pub asked_for: Vec<(usize, Stream)>,
    /// A reset that has been asked for, and follows.
    pub reset_wanted: Option<Kept>,
    under_way: Option<UnderWay>,
}

/// What a reset keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// Nothing.
    Nothing,
    /// Parameters that have been set and plans that have been uploaded.
    Stored,
}

/// A command that takes a while.
#[derive(Debug)]
struct UnderWay {
    peer: PeerId,
    command: u16,
    sender: Target,
    began: Duration,
    /// How often it has been said that it goes on.
    told: u32,
}

/// How long a command takes that takes a while, and how often it is said meanwhile that it goes on.
const UNDER_WAY: Duration = Duration::from_secs(2);
const TOLD_EVERY: Duration = Duration::from_secs(1);

impl Component {
    pub fn new(settings: VehicleSettings, is_in_lockstep: bool) -> Self {
        Self {
            autopilot: Autopilot::new(&settings, is_in_lockstep),
            links: Links::new(&settings),
            settings,
            counters: VehicleCounters::default(),
            host_now: Duration::ZERO,
            asked_for: Vec::new(),
            reset_wanted: None,
            under_way: None,
        }
    }

    /// The links, on which everything that is not yet told has gone out.
    pub fn links(&mut self) -> &mut Links {
        self.tell_events();
        &mut self.links
    }

    /// The links as they are, to be looked at.
    pub fn peers(&self) -> &Links {
        &self.links
    }

    /// Notes that a peer has spoken. Gives its link, and whether it is a new one.
    pub fn hear(&mut self, peer: PeerId, version: Version) -> (usize, bool) {
        self.links.hear(peer, version, self.host_now, self.autopilot.time())
    }

    /// A peer has connected, over a line that tells when it is gone again.
    pub fn connect(&mut self, peer: PeerId) {
        let link = self.links.open(peer, self.host_now, self.autopilot.time());
        self.announce(link);
    }

    /// Becomes another vehicle; only its links, its time and what it has counted are still its own.
    pub fn begin_anew(&mut self, fresh: Self) {
        self.tell_events();
        let (time, counters) = (self.autopilot.time(), self.autopilot.counters());
        self.autopilot = fresh.autopilot;
        self.autopilot.go_on_at(time, counters);
        self.settings = fresh.settings;
        self.links.begin_anew(&fresh.links, time);
        (0..self.links.len()).for_each(|link| self.announce(link));
    }

    /// Takes the host time, and forgets the peers that have been silent for too long.
    pub fn note_host_time(&mut self, now: Duration) {
        self.host_now = self.host_now.max(now);
        self.links.drop_silent(self.host_now);
    }

    /// Tells who and where it is to a new peer, who will be asked again in lockstep.
    pub fn announce(&mut self, link: usize) {
        self.links().begin_batch(Some(link));
        self.send_stream(link, Stream::Heartbeat);
        self.send_stream(link, Stream::LocalPositionNed);
        self.links().end_batch();
    }

    pub fn send_stream(&mut self, link: usize, stream: Stream) {
        self.with_instruments(|links, instruments| links.send_stream(link, stream, instruments));
    }

    /// Sends what has been asked for and is acknowledged now.
    pub fn send_asked_for(&mut self) {
        for (link, stream) in std::mem::take(&mut self.asked_for) {
            self.send_stream(link, stream);
        }
    }

    /// Whether a command that takes a while is under way, after which another one must wait.
    pub fn is_busy(&self) -> bool {
        self.under_way.is_some()
    }

    /// The result of a command follows, once what it has begun is done.
    pub fn conclude_later(&mut self, link: usize, command: u16, sender: Target) {
        let (peer, began) = (self.links.peer(link), self.autopilot.time());
        self.under_way = Some(UnderWay { peer, command, sender, began, told: 0 });
    }

    /// Says that a command goes on, or that it is done.
    pub fn follow_command(&mut self) {
        let Some(mut going) = self.under_way.take() else { return };
        let passed = self.autopilot.time().saturating_sub(going.began);
        let is_done = passed >= UNDER_WAY;
        if is_done || passed >= TOLD_EVERY * (going.told + 1) {
            let result = if is_done { MavResult::MAV_RESULT_ACCEPTED } else { MavResult::MAV_RESULT_IN_PROGRESS };
            if let Some(link) = self.links.of_peer(going.peer) {
                self.links().acknowledge(link, going.command, result, going.sender);
            }
            going.told += 1;
        }
        self.under_way = (!is_done).then_some(going);
    }

    /// Says something to everybody.
    pub fn say(&mut self, severity: Severity, text: &str) {
        self.autopilot.say(severity, text);
    }

    /// Makes messages of what the autopilot has to tell.
    pub fn tell_events(&mut self) {
        if self.autopilot.events().is_empty() {
            return;
        }
        for event in self.autopilot.events().take() {
            match event {
                Event::Text(severity, text) => self.links.say(severity_of(severity), &text),
                Event::ModeChanged => self.send_stream_to_all(Stream::Heartbeat),
                Event::HomeMoved => self.send_stream_to_all(Stream::HomePosition),
                Event::Breached => self.send_stream_to_all(Stream::FenceStatus),
                Event::ItemReached(seq) => {
                    let reached = Message::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq });
                    self.links.send_all(&reached);
                }
            }
        }
    }

    /// Sends what the instruments say, after all that is not yet told.
    pub fn with_instruments(&mut self, send: impl FnOnce(&mut Links, &Instruments<'_>)) {
        self.tell_events();
        self.look(send);
    }

    fn send_stream_to_all(&mut self, stream: Stream) {
        self.look(|links, instruments| {
            (0..links.len()).for_each(|link| links.send_stream(link, stream, instruments));
        });
    }

    fn look(&mut self, send: impl FnOnce(&mut Links, &Instruments<'_>)) {
        let instruments = Instruments::of(&self.autopilot, self.settings.system_id, self.settings.clock_epoch_us);
        send(&mut self.links, &instruments);
    }
}

fn severity_of(severity: Severity) -> MavSeverity {
    match severity {
        Severity::Critical => MavSeverity::MAV_SEVERITY_CRITICAL,
        Severity::Warning => MavSeverity::MAV_SEVERITY_WARNING,
        Severity::Notice => MavSeverity::MAV_SEVERITY_NOTICE,
        Severity::Info => MavSeverity::MAV_SEVERITY_INFO,
    }
}
