//! The fleet as a ground station knows it: the telemetry of each vehicle, gathered into one state. Sans-I/O.

use crate::dialect::{COMMAND_ACK_DATA, LOCAL_POSITION_NED_DATA, MavModeFlag, Message};
use crate::telemetry::{is_autopilot, state_from_local_position};
use crate::{Header, Target};
use flight_model::State;
use std::collections::HashMap;
use std::net::SocketAddr;
use std::time::Duration;

/// How a vehicle is recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Its MAVLink system id.
    pub system_id: u8,
    /// Its address, if that is known beforehand; else the first address that sends with its system id.
    /// Vehicles of several networks may share a system id, and differ by address.
    pub address: Option<SocketAddr>,
}

/// What a ground station knows of one vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct RemoteVehicle {
    /// How it is recognised.
    pub identity: Identity,
    /// Where to send messages for it, once that is known.
    pub address: Option<SocketAddr>,
    /// Its autopilot's system and component id.
    pub target: Target,
    /// Last LOCAL_POSITION_NED: the vehicle's time since boot and its state.
    pub position: Option<Position>,
    /// Whether the last HEARTBEAT said armed.
    pub armed: bool,
    /// custom_mode of the last HEARTBEAT.
    pub custom_mode: Option<u32>,
    /// Host time of the last frame.
    pub last_heard: Option<Duration>,
    /// The last answer to a command.
    pub last_ack: Option<COMMAND_ACK_DATA>,
}

/// Where a vehicle was, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// The vehicle's own time since boot, ms.
    pub time_boot_ms: u32,
    /// Host time at which it was heard.
    pub heard: Duration,
    /// The state.
    pub state: State,
}

/// What a message of the fleet changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FleetEvent {
    /// A position of the vehicle of this index that is not older than the last one.
    Position(usize),
    /// Anything else from the vehicle of this index.
    Other(usize),
    /// Nothing: the sender is not of the fleet.
    None,
}

/// All vehicles, in the order of the scenario.
///
/// ```
/// use flight_model::State;
/// use mavlink_bridge::{Counters, Encoder, Fleet, FleetEvent, Identity, local_position_ned, messages};
/// use std::time::Duration;
///
/// // One vehicle with system id 1, at whatever address it speaks from.
/// let mut fleet = Fleet::new([Identity { system_id: 1, address: None }]);
///
/// let state = State { x_m: 12.0, speed_mps: 9.0, ..State::default() };
/// let mut datagram = Vec::new();
/// Encoder::new(1, 1).encode(&local_position_ned(Duration::from_millis(500), &state), &mut datagram);
/// let from = "127.0.0.1:14600".parse().unwrap();
///
/// for (frame, message) in messages(&datagram, &mut Counters::default()) {
///     let event = fleet.hear(&frame.header, &message.unwrap(), from, Duration::from_secs(3));
///     assert_eq!(event, FleetEvent::Position(0));
/// }
/// let vehicle = &fleet.vehicles()[0];
/// assert_eq!(vehicle.address, Some(from));
/// assert_eq!(vehicle.position.map(|position| position.state), Some(state));
/// ```
#[derive(Clone, Debug)]
pub struct Fleet {
    vehicles: Vec<RemoteVehicle>,
    by_address: HashMap<(SocketAddr, u8), usize>,
    /// Vehicles whose address is yet to be learned, by system id.
    unplaced: HashMap<u8, usize>,
}

impl Fleet {
    /// A fleet of which nothing is heard yet.
    pub fn new(identities: impl IntoIterator<Item = Identity>) -> Self {
        let mut fleet = Self { vehicles: Vec::new(), by_address: HashMap::new(), unplaced: HashMap::new() };
        for (index, identity) in identities.into_iter().enumerate() {
            match identity.address {
                Some(address) => fleet.by_address.insert((address, identity.system_id), index),
                None => fleet.unplaced.insert(identity.system_id, index),
            };
            fleet.vehicles.push(RemoteVehicle {
                identity,
                address: identity.address,
                target: Target { system_id: identity.system_id, component_id: 1 },
                position: None,
                armed: false,
                custom_mode: None,
                last_heard: None,
                last_ack: None,
            });
        }
        fleet
    }

    /// The vehicles.
    pub fn vehicles(&self) -> &[RemoteVehicle] {
        &self.vehicles
    }

    /// Takes a message that came from an address at host time `now`. Positions that are not finite, or older than the
    /// last one, are not taken.
    pub fn hear(&mut self, header: &Header, message: &Message, from: SocketAddr, now: Duration) -> FleetEvent {
        let Some(index) = self.recognise(header.system_id, message, from) else { return FleetEvent::None };
        let vehicle = &mut self.vehicles[index];
        vehicle.last_heard = Some(now);
        match message {
            Message::HEARTBEAT(heartbeat) if is_autopilot(heartbeat) => {
                vehicle.target.component_id = header.component_id;
                vehicle.armed = heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
                vehicle.custom_mode = Some(heartbeat.custom_mode);
                FleetEvent::Other(index)
            }
            Message::COMMAND_ACK(ack) => {
                vehicle.last_ack = Some(ack.clone());
                FleetEvent::Other(index)
            }
            Message::LOCAL_POSITION_NED(position) if vehicle.take_position(position, now) => {
                FleetEvent::Position(index)
            }
            _ => FleetEvent::Other(index),
        }
    }

    /// A system id without a known address is claimed by the first autopilot that speaks with it; a ground station that
    /// happens to share the id is not a vehicle.
    fn recognise(&mut self, system_id: u8, message: &Message, from: SocketAddr) -> Option<usize> {
        if let Some(&index) = self.by_address.get(&(from, system_id)) {
            return Some(index);
        }
        let claims = match message {
            Message::HEARTBEAT(heartbeat) => is_autopilot(heartbeat),
            Message::LOCAL_POSITION_NED(_) => true,
            _ => false,
        };
        let index = *self.unplaced.get(&system_id).filter(|_| claims)?;
        self.unplaced.remove(&system_id);
        self.by_address.insert((from, system_id), index);
        self.vehicles[index].address = Some(from);
        Some(index)
    }
}

impl RemoteVehicle {
    fn take_position(&mut self, data: &LOCAL_POSITION_NED_DATA, now: Duration) -> bool {
        let state = state_from_local_position(data);
        // Half of the clock's range apart, the order of two times is that of their difference, wrapped or not.
        let is_older =
            self.position.is_some_and(|last| data.time_boot_ms.wrapping_sub(last.time_boot_ms) > u32::MAX / 2);
        if is_older || !state.is_finite() {
            return false;
        }
        self.position = Some(Position { time_boot_ms: data.time_boot_ms, heard: now, state });
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::{ground_heartbeat, local_position_ned};
    use crate::{Counters, Encoder, messages};

    const HERE: ([u8; 4], u16) = ([127, 0, 0, 1], 14600);
    const THERE: ([u8; 4], u16) = ([127, 0, 0, 1], 14601);

    fn hear(fleet: &mut Fleet, system_id: u8, message: &Message, from: ([u8; 4], u16)) -> FleetEvent {
        let mut datagram = Vec::new();
        Encoder::new(system_id, 1).encode(message, &mut datagram);
        let mut counters = Counters::default();
        let (frame, read) = messages(&datagram, &mut counters).next().expect("one frame");
        fleet.hear(&frame.header, &read.expect("readable"), from.into(), Duration::from_secs(1))
    }

    fn position(time_ms: u64, x_m: f64) -> Message {
        local_position_ned(Duration::from_millis(time_ms), &State { x_m, speed_mps: 10.0, ..State::default() })
    }

    fn identity(system_id: u8, address: Option<([u8; 4], u16)>) -> Identity {
        Identity { system_id, address: address.map(Into::into) }
    }

    #[test]
    fn an_unknown_address_is_learned_once() {
        let mut fleet = Fleet::new([identity(1, None)]);
        assert_eq!(hear(&mut fleet, 1, &ground_heartbeat(), THERE), FleetEvent::None, "a ground station is no vehicle");
        assert_eq!(hear(&mut fleet, 1, &position(100, 1.0), HERE), FleetEvent::Position(0));
        assert_eq!(
            hear(&mut fleet, 1, &position(200, 9.0), THERE),
            FleetEvent::None,
            "another vehicle with the same id"
        );
        assert_eq!(fleet.vehicles()[0].address, Some(HERE.into()));
    }

    #[test]
    fn networks_share_system_ids_and_differ_by_address() {
        let mut fleet = Fleet::new([identity(1, Some(HERE)), identity(1, Some(THERE))]);
        assert_eq!(hear(&mut fleet, 1, &position(100, 1.0), THERE), FleetEvent::Position(1));
        assert_eq!(hear(&mut fleet, 1, &position(100, 2.0), HERE), FleetEvent::Position(0));
        assert_eq!(hear(&mut fleet, 2, &position(100, 2.0), HERE), FleetEvent::None);
    }

    #[test]
    fn older_and_impossible_positions_are_not_taken() {
        let mut fleet = Fleet::new([identity(1, None)]);
        assert_eq!(hear(&mut fleet, 1, &position(500, 5.0), HERE), FleetEvent::Position(0));
        assert_eq!(hear(&mut fleet, 1, &position(400, 4.0), HERE), FleetEvent::Other(0));
        assert_eq!(hear(&mut fleet, 1, &position(600, f64::NAN), HERE), FleetEvent::Other(0));
        assert_eq!(fleet.vehicles()[0].position.map(|position| position.state.x_m), Some(5.0));
        assert_eq!(hear(&mut fleet, 1, &position(500, 5.0), HERE), FleetEvent::Position(0), "said again");
    }
}
