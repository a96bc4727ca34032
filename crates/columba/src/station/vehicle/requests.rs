//! What the station asks of a vehicle's telemetry, and whether it comes.

use mavlink_bridge::Target;
use mavlink_bridge::dialect::{MavParamType, Message, PARAM_REQUEST_READ_DATA, PARAM_VALUE_DATA, TIMESYNC_DATA};
use mavlink_bridge::kind::{AutopilotKind, Driver, VehicleLimits, request_message, set_message_interval};
use std::collections::BTreeMap;
use std::time::Duration;

/// Positions are asked for at this rate, Hz.
pub const POSITION_HZ: f64 = 10.0;
/// Positions come well if they come at this share of what was asked.
pub const RATE_SHARE: f64 = 0.95;
/// What does not come is asked for again after this.
const ASK_AGAIN: Duration = Duration::from_millis(1000);
/// A rate is counted over so long, s.
pub const RATE_WINDOW_S: f64 = 1.5;
/// Bytes of one position on the wire, with its frame.
const POSITION_BYTES: f64 = 40.0;
/// Bytes a second of all else that is asked of a vehicle.
const OTHERS_BYTES_PER_S: f64 = 260.0;
/// Share of a slow link that telemetry may take: the rest is for commands, and for what was not foreseen.
const CAPACITY_SHARE: f64 = 0.7;

const HEARTBEAT: u32 = 0;
const SYS_STATUS: u32 = 1;
const ATTITUDE: u32 = 30;
const LOCAL_POSITION_NED: u32 = 32;
const GLOBAL_POSITION_INT: u32 = 33;
const GPS_GLOBAL_ORIGIN: u32 = 49;
const VFR_HUD: u32 = 74;
const AUTOPILOT_VERSION: u32 = 148;
const HOME_POSITION: u32 = 242;
const EXTENDED_SYS_STATE: u32 = 245;
const CURRENT_MODE: u32 = 436;

/// What answers or announces something, and is never silenced: HEARTBEAT, PARAM_VALUE, COMMAND_ACK, TIMESYNC,
/// STATUSTEXT and others of that kind.
const KEPT: [u32; 13] = [HEARTBEAT, 8, 22, 44, 47, 51, 73, 77, 110, 111, 253, AUTOPILOT_VERSION, GLOBAL_POSITION_INT];
/// A message that came so often is a stream.
const STREAM_HEARD: u32 = 5;
/// A stream is silenced so often; an autopilot that goes on does not know how to stop it.
const SILENCE_TRIES: u32 = 3;

/// What is good to have is asked for so often; an autopilot that does not have it has said so.
const STREAM_TRIES: u32 = 3;
/// The version is asked for so often.
const VERSION_TRIES: u32 = 5;
/// The origin is asked for so often.
const ORIGIN_TRIES: u32 = 10;
/// Parameters are asked for so often.
const PARAMETER_TRIES: u32 = 4;

/// The rate of positions that a link carries for each of so many vehicles, Hz.
pub fn position_hz(capacity_bytes_per_s: Option<f64>, vehicles: usize) -> f64 {
    let Some(capacity) = capacity_bytes_per_s else { return POSITION_HZ };
    let each = CAPACITY_SHARE * capacity / vehicles.max(1) as f64 - OTHERS_BYTES_PER_S;
    (each / POSITION_BYTES).clamp(1.0, POSITION_HZ)
}

/// What a link carries for a vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    /// The rate at which positions are to come, Hz.
    pub position_hz: f64,
    /// Whether the link is slow: what is not needed is silenced.
    pub is_slow: bool,
}

/// What is known of a vehicle, and need not be asked for.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Positions come at their rate.
    pub comes: bool,
    /// Its version.
    pub version: bool,
    /// Its home.
    pub home: bool,
    /// Its origin.
    pub origin: bool,
}

/// One kind of message of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Stream {
    /// How often it came since it was last silenced.
    heard: u32,
    /// How often it was silenced.
    silenced: u32,
}

/// What was asked of one vehicle, and what came.
#[derive(Debug, Default)]
pub struct Requests {
    /// When something was last asked for, and how often.
    asked: Option<(Duration, u32)>,
    /// What comes, by message id.
    streams: BTreeMap<u32, Stream>,
    /// Parameters that were asked for; none: it does not have it, or has not told it.
    parameters: BTreeMap<String, Option<f64>>,
    limits: Option<VehicleLimits>,
}

impl Requests {
    /// Limits that the vehicle's parameters set, once these are read.
    pub fn limits(&self) -> Option<VehicleLimits> {
        self.limits
    }

    /// How often something was asked for.
    pub fn times(&self) -> u32 {
        self.asked.map_or(0, |(_, times)| times)
    }

    /// Takes note of a message that came.
    pub fn count(&mut self, message_id: u32) {
        self.streams.entry(message_id).or_default().heard += 1;
    }

    /// Takes the value of a parameter. A PX4 sends integers as their bits.
    pub fn hear(&mut self, data: &PARAM_VALUE_DATA, is_px4: bool) {
        let Ok(name) = data.param_id.to_str() else { return };
        let value = match data.param_type {
            MavParamType::MAV_PARAM_TYPE_INT32 if is_px4 => f64::from(data.param_value.to_bits() as i32),
            _ => f64::from(data.param_value),
        };
        if let Some(known) = self.parameters.get_mut(name) {
            *known = Some(value);
        }
    }

    /// What is to be asked for now: nothing while positions come at their rate and all is known.
    pub fn ask(
        &mut self,
        target: Target,
        driver: &Driver,
        known: Known,
        carried: Carried,
        now: Duration,
    ) -> Vec<Message> {
        if self.asked.is_some_and(|(asked, _)| now.saturating_sub(asked) < ASK_AGAIN) {
            return Vec::new();
        }
        let (kind, times) = (driver.kind(), self.times());
        let mut wanted = Vec::new();
        if !known.comes {
            wanted.push(set_message_interval(target, GLOBAL_POSITION_INT, carried.position_hz));
        }
        if times < STREAM_TRIES {
            wanted.extend(streams(kind).into_iter().map(|(id, hz)| set_message_interval(target, id, hz)));
            // Headings tell the wind and the turns between positions; on a slow line positions are worth more.
            if !carried.is_slow && !kind.hovers() {
                wanted.push(set_message_interval(target, ATTITUDE, carried.position_hz));
            }
        }
        if carried.is_slow {
            wanted.extend(self.silence(target, kind));
        }
        if !known.version && times < VERSION_TRIES {
            wanted.push(request_message(target, AUTOPILOT_VERSION));
        }
        if !known.home {
            wanted.push(request_message(target, HOME_POSITION));
        }
        if !known.origin && times < ORIGIN_TRIES {
            wanted.push(request_message(target, GPS_GLOBAL_ORIGIN));
        }
        wanted.extend(self.read_parameters(target, driver));
        if !wanted.is_empty() {
            self.asked = Some((now, times + 1));
        }
        wanted
    }

    /// Silences the streams that come and are not needed.
    fn silence(&mut self, target: Target, kind: AutopilotKind) -> Vec<Message> {
        let needed = streams(kind);
        let mut silenced = Vec::new();
        for (&id, stream) in &mut self.streams {
            let is_needed = KEPT.contains(&id) || needed.iter().any(|(stream, _)| *stream == id);
            if !is_needed && stream.heard >= STREAM_HEARD && stream.silenced < SILENCE_TRIES {
                *stream = Stream { heard: 0, silenced: stream.silenced + 1 };
                silenced.push(set_message_interval(target, id, -1e6));
            }
        }
        silenced
    }

    /// Reads the parameters that limit the vehicle, a few times; what does not come it does not have.
    fn read_parameters(&mut self, target: Target, driver: &Driver) -> Vec<Message> {
        let times = self.times();
        for &name in driver.limit_parameters() {
            self.parameters.entry(name.to_owned()).or_default();
        }
        let limits = driver.limits(&|name| self.parameters.get(name).copied().flatten());
        let missing: Vec<&String> =
            self.parameters.iter().filter(|(_, value)| value.is_none()).map(|(name, _)| name).collect();
        let knows_enough = limits.speed_max_mps.is_some() && limits.bank_max_rad.is_some() && times >= 2;
        if missing.is_empty() || knows_enough || times >= PARAMETER_TRIES {
            self.limits = Some(limits);
            return Vec::new();
        }
        let read = |name: &String| {
            Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
                param_index: -1,
                target_system: target.system_id,
                target_component: target.component_id,
                param_id: name.as_str().into(),
            })
        };
        missing.into_iter().map(read).collect()
    }
}

/// The streams that are good to have of a kind, beside positions, and their rates, Hz.
fn streams(kind: AutopilotKind) -> Vec<(u32, f64)> {
    let mut streams = vec![(EXTENDED_SYS_STATE, 2.0), (SYS_STATUS, 1.0)];
    match kind {
        AutopilotKind::ArduPlane => streams.extend([(HEARTBEAT, 4.0), (VFR_HUD, 4.0)]),
        AutopilotKind::ArduCopter => streams.extend([(HEARTBEAT, 4.0)]),
        AutopilotKind::Px4FixedWing => streams.extend([(VFR_HUD, 4.0), (CURRENT_MODE, 4.0)]),
        AutopilotKind::Px4Multicopter => streams.extend([(LOCAL_POSITION_NED, 4.0), (CURRENT_MODE, 4.0)]),
        AutopilotKind::Columba => streams.extend([(LOCAL_POSITION_NED, 4.0)]),
    }
    streams
}

/// TIMESYNC with our time: the answer gives the delay of the link.
pub fn time_request(target: Target, now: Duration) -> Message {
    Message::TIMESYNC(TIMESYNC_DATA {
        tc1: 0,
        ts1: now.as_nanos() as i64,
        target_system: target.system_id,
        target_component: target.component_id,
    })
}

/// The round trip that an answer tells; none if it answers no question of ours.
pub fn round_trip(data: &TIMESYNC_DATA, now: Duration) -> Option<Duration> {
    if data.tc1 == 0 {
        return None;
    }
    let sent = Duration::from_nanos(u64::try_from(data.ts1).ok()?);
    now.checked_sub(sent).filter(|trip| *trip < Duration::from_secs(5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_slow_line_what_comes_and_is_not_needed_is_silenced_a_few_times() {
        let target = Target { system_id: 1, component_id: 1 };
        let mut requests = Requests::default();
        let mut sent = 0;
        for _ in 0..100 {
            for id in [HEARTBEAT, ATTITUDE, GLOBAL_POSITION_INT, EXTENDED_SYS_STATE] {
                requests.count(id);
            }
            let silenced = requests.silence(target, AutopilotKind::ArduPlane);
            assert!(silenced.iter().all(|message| *message == set_message_interval(target, ATTITUDE, -1e6)));
            sent += silenced.len() as u32;
        }
        assert_eq!(sent, SILENCE_TRIES);
        let Message::COMMAND_LONG(command) = set_message_interval(target, ATTITUDE, -1e6) else { panic!() };
        assert_eq!(command.param2, -1.0);
    }

    #[test]
    fn a_slow_line_gets_the_rate_that_it_carries() {
        assert_eq!(position_hz(None, 50), POSITION_HZ);
        assert_eq!(position_hz(Some(5760.0), 2), POSITION_HZ);
        let five = position_hz(Some(5760.0), 8);
        assert!((2.0..8.0).contains(&five), "{five}");
        assert_eq!(position_hz(Some(960.0), 4), 1.0);
    }
}
