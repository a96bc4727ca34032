//! What is watched over: setpoints, the ground station, charge, a GPS, an engine, the wind. What is missing is said
//! aloud when that begins and when it ends. A watch only proposes; the [arbiter](super::arbiter) acts.

pub(crate) mod battery;
mod engine;
mod gps;
mod ground_station;
mod long_action;
pub(crate) mod proposal;
pub(crate) mod receiver;
pub(crate) mod setpoints;
pub(crate) mod streams;
mod wind;

use super::event::Events;
use super::situation::Situation;
use super::timer::Timers;
use battery::{BatteryLevel, BatteryWatch};
use engine::EngineWatch;
use gps::GpsWatch;
use ground_station::GroundStationWatch;
use proposal::Proposal;
use receiver::ReceiverWatch;
use setpoints::SetpointWatch;
use streams::StreamWatch;
use wind::WindWatch;

/// All that is watched over.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Failsafes {
    pub setpoints: SetpointWatch,
    pub ground_station: GroundStationWatch,
    pub receiver: ReceiverWatch,
    pub battery: BatteryWatch,
    pub gps: GpsWatch,
    pub engine: EngineWatch,
    pub wind: WindWatch,
    pub streams: StreamWatch,
}

impl Failsafes {
    /// Looks at each of them from the one of a number on, up to the first that proposes something; `next` is then the
    /// one after it. None when all have been looked at.
    pub fn check(
        &mut self,
        next: &mut u8,
        now: &Situation<'_>,
        timers: &mut Timers,
        events: &mut Events,
    ) -> Option<Proposal> {
        while *next < 5 {
            *next += 1;
            let proposal = match *next {
                1 => self.setpoints.check(now, timers),
                // Of the two long ones the first acts.
                2 if self.receiver.is_long() => None,
                2 => self.ground_station.check(now, timers),
                3 => self.battery.check(now, timers, events),
                4 => self.gps.check(now, events),
                _ => self.engine.check(now, events),
            };
            if proposal.is_some() {
                return proposal;
            }
        }
        self.wind.check(now, events);
        None
    }

    /// Whether any of them acts.
    pub fn is_any(&self) -> bool {
        self.setpoints.is_lost()
            || self.ground_station.is_lost()
            || self.receiver.acts()
            || self.gps.is_lost()
            || self.engine.has_failed()
            || self.battery.level() != BatteryLevel::Ok
            || self.streams.lost().is_some()
    }

    /// Somebody has set a mode: what the lack of a stream has brought about is over.
    pub fn mode_set(&mut self) {
        self.setpoints.set_lost(false);
        self.receiver.mode_set();
        self.streams.set_lost(None);
    }
}
