//! What a host and its ports have in common: the clock, who looks on, and what can go wrong.

use crate::{LockstepSettings, ParameterFileError, PlanFileError, SettingsError};
use flight_model::State;
use mavlink_bridge::LinkError;
use std::sync::Arc;
use std::time::Duration;

/// What moves the vehicles' time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    /// The controller's setpoints, by their stamps.
    Lockstep(LockstepSettings),
    /// The wall clock, times `speed`.
    RealTime {
        /// Vehicle seconds for each second, more than 0.
        speed: f64,
        /// Wall time between two advances.
        tick: Duration,
    },
}

impl Clock {
    /// The wall clock as it is, looked at every 10 ms.
    pub const WALL: Clock = Clock::RealTime { speed: 1.0, tick: Duration::from_millis(10) };
}

/// A stretch of one vehicle's flight, as it was flown.
#[derive(Clone, Copy, Debug)]
pub struct Advance<'a> {
    /// Index of the vehicle, in the order in which the host was given them.
    pub vehicle: usize,
    /// Vehicle time at which the stretch begins.
    pub start: Duration,
    /// The integration step.
    pub step: Duration,
    /// The state after each integration step: `track[i]` is at `start + (i + 1) * step`.
    pub track: &'a [State],
}

/// Called for every stretch that a vehicle flies, from the task of its port. It should not block.
pub type Observer = Arc<dyn Fn(Advance<'_>) + Send + Sync>;

/// Why a host does not start, or stops.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// A port cannot be bound; the message names it.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A vehicle's settings are out of range.
    #[error("vehicle {vehicle}: {source}")]
    Vehicle {
        /// Index of the vehicle.
        vehicle: usize,
        /// What is wrong.
        source: SettingsError,
    },
    /// A vehicle's file of parameters cannot be read.
    #[error(transparent)]
    ParameterFile(#[from] ParameterFileError),
    /// A vehicle's file of a plan cannot be read.
    #[error(transparent)]
    PlanFile(#[from] PlanFileError),
    /// The ports needed go beyond 65535.
    #[error("{count} ports from {base_port} up go beyond 65535")]
    TooManyPorts {
        /// The first port.
        base_port: u16,
        /// How many are needed.
        count: usize,
    },
    /// Two vehicles on one port have the same system id.
    #[error("vehicles {first} and {second} share a port and system id {system_id}")]
    DuplicateSystemId {
        /// Index of one vehicle.
        first: usize,
        /// Index of the other.
        second: usize,
        /// The system id of both.
        system_id: u8,
    },
    /// A setting of the host itself is out of range.
    #[error("{name} = {value} is outside {range}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The allowed values.
        range: &'static str,
    },
}
