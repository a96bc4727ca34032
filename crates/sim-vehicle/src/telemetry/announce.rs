//! What the vehicle says of its own accord, and what it says it from.

use crate::autopilot::event::Event;
use crate::error::Severity;
use crate::links::Links;
use crate::telemetry::Instruments;
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MISSION_ITEM_REACHED_DATA, MavSeverity, Message};

impl Vehicle {
    /// Says who and where it is to a new peer, who will be asked again in lockstep.
    pub(crate) fn announce(&mut self, link: usize) {
        self.links().begin_batch(Some(link));
        self.send_stream(link, Stream::Heartbeat);
        self.send_stream(link, Stream::LocalPositionNed);
        self.links().end_batch();
    }

    pub(crate) fn send_stream(&mut self, link: usize, stream: Stream) {
        self.with_instruments(|links, instruments| links.send_stream(link, stream, instruments));
    }

    fn send_stream_to_all(&mut self, stream: Stream) {
        self.look(|links, instruments| {
            (0..links.len()).for_each(|link| links.send_stream(link, stream, instruments));
        });
    }

    /// Makes messages of what the autopilot has to tell.
    pub(crate) fn tell_events(&mut self) {
        if self.autopilot.events.is_empty() {
            return;
        }
        for event in self.autopilot.events.take() {
            match event {
                Event::Text(severity, text) => self.raw_links.say(severity_of(severity), &text),
                Event::ModeChanged => self.send_stream_to_all(Stream::Heartbeat),
                Event::HomeMoved => self.send_stream_to_all(Stream::HomePosition),
                Event::Breached => self.send_stream_to_all(Stream::FenceStatus),
                Event::ItemReached(seq) => {
                    let reached = Message::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq });
                    self.raw_links.send_all(&reached);
                }
            }
        }
    }

    /// Sends what the instruments say, after all that is not yet told.
    pub(crate) fn with_instruments(&mut self, send: impl FnOnce(&mut Links, &Instruments<'_>)) {
        self.tell_events();
        self.look(send);
    }

    fn look(&mut self, send: impl FnOnce(&mut Links, &Instruments<'_>)) {
        let is_armable = self.autopilot.against_arming().is_none();
        let instruments = Instruments {
            time: self.autopilot.time,
            system_id: self.autopilot.settings.system_id,
            personality: self.autopilot.settings.personality,
            flight: &self.autopilot.flight,
            frame: &self.autopilot.settings.frame,
            mission: &self.autopilot.mission,
            progress: &self.autopilot.progress,
            failsafe: self.autopilot.is_in_failsafe(),
            world: &self.autopilot.world,
            parameters: &self.autopilot.parameters,
            battery_level: self.autopilot.failsafes.battery.level(),
            fence: self.autopilot.fence.report(&self.autopilot.parameters),
            is_armable,
            channels: &self.autopilot.channels,
            clock_epoch_us: self.autopilot.settings.clock_epoch_us,
        };
        send(&mut self.raw_links, &instruments);
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
