//! What is watched over: setpoints, the ground station, charge, a GPS, an engine, the wind. What is missing is said
//! aloud when that begins and when it ends. A watch only proposes; the [arbiter](super::arbiter) acts.

pub(crate) mod battery;
mod engine;
mod gps;
mod ground_station;
pub(crate) mod proposal;
pub(crate) mod setpoints;
pub(crate) mod streams;
mod wind;

use battery::{BatteryLevel, BatteryWatch};
use engine::EngineWatch;
use gps::GpsWatch;
use ground_station::GroundStationWatch;
use setpoints::SetpointWatch;
use streams::StreamWatch;
use wind::WindWatch;

/// All that is watched over.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Failsafes {
    pub setpoints: SetpointWatch,
    pub ground_station: GroundStationWatch,
    pub battery: BatteryWatch,
    pub gps: GpsWatch,
    pub engine: EngineWatch,
    pub wind: WindWatch,
    pub streams: StreamWatch,
}

impl Failsafes {
    /// Whether any of them acts.
    pub fn is_any(&self) -> bool {
        self.setpoints.is_lost()
            || self.ground_station.is_lost()
            || self.gps.is_lost()
            || self.engine.has_failed()
            || self.battery.level() != BatteryLevel::Ok
            || self.streams.lost().is_some()
    }

    /// Somebody has set a mode: what the lack of a stream has brought about is over.
    pub fn mode_set(&mut self) {
        self.setpoints.set_lost(false);
        self.streams.set_lost(None);
    }
}
