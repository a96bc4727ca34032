//! What a host and its ports have in common: the clock, who looks on, and what can go wrong.

use crate::parameters::file::ParameterFileError;
use crate::protocol::mission::file::PlanFileError;
use crate::settings::{LockstepSettings, SettingsError};
use flight_model::State;
use mavlink_bridge::LinkError;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Most vehicles of one MAVLink network: system ids from 1 to 250, of which the rest is left to ground stations.
pub const NETWORK_VEHICLES_MAX: usize = 250;

/// Which port, counted from 0, a vehicle of this index has. No port serves two networks, in which system ids are the
/// same.
pub fn port_index(vehicle: usize, vehicles_per_port: usize) -> usize {
    let per_port = vehicles_per_port.max(1);
    let (network, member) = (vehicle / NETWORK_VEHICLES_MAX, vehicle % NETWORK_VEHICLES_MAX);
    network * NETWORK_VEHICLES_MAX.div_ceil(per_port) + member / per_port
}

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

    /// Vehicle seconds for each second of the wall clock; 1 where there is none.
    pub(crate) fn speed(&self) -> f64 {
        match self {
            Clock::RealTime { speed, .. } => *speed,
            Clock::Lockstep(_) => 1.0,
        }
    }
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

/// The time that all vehicles of a host share in real time. Where the machine does not keep up it slips, so that they
/// fall behind the clock together instead of flying in ever longer strides.
#[derive(Debug)]
pub(crate) struct RealTime {
    speed: f64,
    slipped_ns: AtomicU64,
}

/// The longest stretch of the wall clock that is made up for.
pub(crate) const STRIDE_MAX: Duration = Duration::from_millis(250);

impl RealTime {
    pub fn new(speed: f64) -> Self {
        Self { speed, slipped_ns: AtomicU64::new(0) }
    }

    /// Vehicle time to which a vehicle at vehicle time `from` may fly at host time `now`.
    pub fn until(&self, now: Duration, from: Duration) -> Duration {
        let until = now.saturating_sub(self.slipped()).mul_f64(self.speed);
        let furthest = from + STRIDE_MAX.mul_f64(self.speed);
        if until <= furthest {
            return until;
        }
        let late = (until - furthest).div_f64(self.speed);
        self.slipped_ns.fetch_add(u64::try_from(late.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
        furthest
    }

    /// How far vehicle time has fallen behind, in time of the wall clock.
    pub fn slipped(&self) -> Duration {
        Duration::from_nanos(self.slipped_ns.load(Ordering::Relaxed))
    }

    /// Vehicle seconds for each second of the wall clock up to host time `now`.
    pub fn reached(&self, now: Duration) -> f64 {
        let (now_s, slipped_s) = (now.as_secs_f64(), self.slipped().as_secs_f64());
        if now_s > 0.0 { self.speed * (1.0 - slipped_s / now_s).max(0.0) } else { self.speed }
    }
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
    #[error("vehicle {}: {source}", vehicle + 1)]
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
    #[error(
        "vehicles {} and {} share a port and have the same MAV_SYSID, {system_id}: must differ",
        first + 1,
        second + 1
    )]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_filled_one_after_the_other_and_serve_one_network() {
        assert_eq!([0, 1, 999].map(|vehicle| port_index(vehicle, 1)), [0, 1, 999]);
        assert_eq!([0, 99, 100, 249].map(|vehicle| port_index(vehicle, 100)), [0, 0, 1, 2]);
        assert_eq!([250, 349, 350, 500].map(|vehicle| port_index(vehicle, 100)), [3, 3, 4, 6]);
        assert_eq!([249, 250].map(|vehicle| port_index(vehicle, 250)), [0, 1]);
    }

    #[test]
    fn a_host_that_is_late_lets_time_slip_once_for_all() {
        let time = RealTime::new(10.0);
        let [soon, late] = [100, 2000].map(Duration::from_millis);
        assert_eq!((time.until(soon, Duration::ZERO), time.reached(soon)), (Duration::from_secs(1), 10.0));
        for _ in 0..3 {
            assert_eq!(time.until(late, Duration::from_secs(1)), Duration::from_millis(3500));
        }
        assert_eq!(time.slipped(), Duration::from_millis(1650));
        assert!((time.reached(late) - 1.75).abs() < 1e-9);
    }
}
