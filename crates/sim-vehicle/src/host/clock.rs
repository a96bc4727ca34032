//! What a host and its ports have in common: the clock, who looks on, and what can go wrong.

use crate::parameters::file::ParameterFileError;
use crate::protocol::mission::file::PlanFileError;
use crate::settings::{LockstepSettings, SettingsError};
use crate::vehicle::Vehicle;
use flight_model::State;
use mavlink_bridge::LinkError;
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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
#[derive(Clone, Copy)]
pub struct Advance<'a> {
    /// Index of the vehicle, in the order in which the host was given them.
    pub vehicle: usize,
    /// Vehicle time at which the stretch begins.
    pub start: Duration,
    /// The integration step.
    pub step: Duration,
    /// The state after each integration step: `track[i]` is at `start + (i + 1) * step`.
    pub track: &'a [State],
    /// The vehicle itself, as it is after the stretch.
    pub craft: &'a Vehicle,
}

/// The time that all vehicles of a host share in real time. Where the machine does not keep up it slips, so that they
/// fall behind the clock together instead of flying in ever longer strides.
#[derive(Debug)]
pub(crate) struct RealTime(Mutex<Rate>);

/// The rate at which vehicle time goes on, and since when.
#[derive(Clone, Copy, Debug)]
struct Rate {
    speed: f64,
    /// Host time at which this rate began.
    since: Duration,
    /// Vehicle time at which it began, and the one at which it would have begun if nothing had ever slipped.
    vehicle: Duration,
    asked: Duration,
    /// How far vehicle time has fallen behind since then, in time of the wall clock.
    slipped: Duration,
}

/// The longest stretch of the wall clock that is made up for.
pub(crate) const STRIDE_MAX: Duration = Duration::from_millis(250);

impl RealTime {
    pub fn new(speed: f64) -> Self {
        let zero = Duration::ZERO;
        Self(Mutex::new(Rate { speed, since: zero, vehicle: zero, asked: zero, slipped: zero }))
    }

    /// Vehicle time to which a vehicle at vehicle time `from` may fly at host time `now`.
    pub fn until(&self, now: Duration, from: Duration) -> Duration {
        let mut rate = self.rate();
        let until = rate.vehicle_time(now);
        let furthest = from + STRIDE_MAX.mul_f64(rate.speed);
        if until <= furthest {
            return until;
        }
        let late = (until - furthest).div_f64(rate.speed);
        rate.slipped += late;
        furthest
    }

    /// Vehicle seconds for each second of the wall clock, now.
    pub fn speed(&self) -> f64 {
        self.rate().speed
    }

    /// From host time `now` on, vehicle time goes on at another rate.
    pub fn set_speed(&self, now: Duration, speed: f64) {
        let mut rate = self.rate();
        let (vehicle, asked) = (rate.vehicle_time(now), rate.asked_time(now));
        *rate = Rate { speed, since: now, vehicle, asked, slipped: Duration::ZERO };
    }

    /// Vehicle seconds for each second of the wall clock up to host time `now`: those that were reached, and those that
    /// were asked for.
    pub fn reached_and_asked(&self, now: Duration) -> (f64, f64) {
        let rate = self.rate();
        if now.is_zero() {
            return (rate.speed, rate.speed);
        }
        let per_second = |time: Duration| time.as_secs_f64() / now.as_secs_f64();
        (per_second(rate.vehicle_time(now)), per_second(rate.asked_time(now)))
    }

    fn rate(&self) -> MutexGuard<'_, Rate> {
        // A vehicle that panicked while it held the lock leaves whole times behind.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Rate {
    fn vehicle_time(&self, now: Duration) -> Duration {
        self.vehicle + now.saturating_sub(self.since).saturating_sub(self.slipped).mul_f64(self.speed)
    }

    fn asked_time(&self, now: Duration) -> Duration {
        self.asked + now.saturating_sub(self.since).mul_f64(self.speed)
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
    /// A TCP port cannot be bound.
    #[error("cannot bind TCP {address}: {}", bind_reason(.source))]
    Tcp {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: io::Error,
    },
    /// An autopilot's port layout has no ports for so many.
    #[error("{vehicles} vehicles: the ports of this layout are enough for {most}")]
    Layout {
        /// How many vehicles there are.
        vehicles: usize,
        /// How many can be.
        most: usize,
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

fn bind_reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::AddrInUse => "the port is busy".to_owned(),
        _ => error.to_string(),
    }
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
        assert_eq!(
            (time.until(soon, Duration::ZERO), time.reached_and_asked(soon)),
            (Duration::from_secs(1), (10.0, 10.0))
        );
        for _ in 0..3 {
            assert_eq!(time.until(late, Duration::from_secs(1)), Duration::from_millis(3500));
        }
        assert_eq!(time.rate().slipped, Duration::from_millis(1650));
        assert!((time.reached_and_asked(late).0 - 1.75).abs() < 1e-9);
    }

    #[test]
    fn another_speed_goes_on_from_where_time_is() {
        let time = RealTime::new(1.0);
        let at = |seconds: u64| Duration::from_secs(seconds);
        time.set_speed(at(2), 5.0);
        assert_eq!(time.until(at(3), at(6)), at(7));
        time.set_speed(at(4), 0.5);
        assert_eq!((time.until(at(6), at(13)), time.speed()), (at(13), 0.5));
        let (reached, asked) = time.reached_and_asked(at(6));
        assert!((reached - 13.0 / 6.0).abs() < 1e-9 && (asked - reached).abs() < 1e-9);
    }
}
