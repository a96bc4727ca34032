//! What the vehicle says of its own accord, and what it says it from.

use crate::links::Links;
use crate::telemetry::Instruments;
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::MavSeverity;

impl Vehicle {
    /// Says who and where it is to a new peer, who will be asked again in lockstep.
    pub(crate) fn announce(&mut self, link: usize) {
        self.links.begin_batch(Some(link));
        self.send_stream(link, Stream::Heartbeat);
        self.send_stream(link, Stream::LocalPositionNed);
        self.links.end_batch();
    }

    pub(crate) fn send_stream(&mut self, link: usize, stream: Stream) {
        self.with_instruments(|links, instruments| links.send_stream(link, stream, instruments));
    }

    pub(crate) fn send_stream_to_all(&mut self, stream: Stream) {
        self.with_instruments(|links, instruments| {
            (0..links.len()).for_each(|link| links.send_stream(link, stream, instruments));
        });
    }

    pub(crate) fn say(&mut self, severity: MavSeverity, text: &str) {
        self.links.say(severity, text);
    }

    pub(crate) fn with_instruments(&mut self, send: impl FnOnce(&mut Links, &Instruments<'_>)) {
        let is_armable = self.against_arming().is_none();
        let instruments = Instruments {
            time: self.time,
            system_id: self.settings.system_id,
            personality: self.settings.personality,
            flight: &self.flight,
            frame: &self.settings.frame,
            mission: &self.mission,
            progress: &self.progress,
            failsafe: self.is_in_failsafe(),
            world: &self.world,
            parameters: &self.parameters,
            battery_level: self.failsafes.battery.level(),
            fence: self.fence.report(&self.parameters),
            is_armable,
            channels: &self.channels,
            clock_epoch_us: self.settings.clock_epoch_us,
        };
        send(&mut self.links, &instruments);
    }
}
