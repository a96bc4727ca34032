//! What the station asks of each vehicle's telemetry, and whether it comes.

use super::vehicle::Vehicle;
use mavlink_bridge::dialect::Message;
use mavlink_bridge::dialect::{PARAM_REQUEST_READ_DATA, TIMESYNC_DATA};
use mavlink_bridge::kind::{AutopilotKind, request_message, set_message_interval};
use std::time::Duration;

/// Positions are asked for at this rate, Hz.
pub const POSITION_HZ: f64 = 10.0;
/// Positions come well if they come at this share of what was asked.
pub const RATE_SHARE: f64 = 0.95;
/// What does not come is asked for again after this.
const ASK_AGAIN: Duration = Duration::from_millis(1000);
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

/// One kind of message of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stream {
    /// How often it came since it was last silenced.
    pub heard: u32,
    /// How often it was silenced.
    pub silenced: u32,
}

/// The rate of positions that a link carries for each of so many vehicles, Hz.
pub fn position_hz(capacity_bytes_per_s: Option<f64>, vehicles: usize) -> f64 {
    let Some(capacity) = capacity_bytes_per_s else { return POSITION_HZ };
    let each = CAPACITY_SHARE * capacity / vehicles.max(1) as f64 - OTHERS_BYTES_PER_S;
    (each / POSITION_BYTES).clamp(1.0, POSITION_HZ)
}

/// What is to be asked of a vehicle now: nothing while positions come at their rate and all is known.
pub fn ask(vehicle: &mut Vehicle, position_hz: f64, is_slow: bool, now: Duration) -> Vec<Message> {
    let now_s = now.as_secs_f64();
    let Some(kind) = vehicle.driver().map(|driver| driver.kind()) else { return Vec::new() };
    let (asked, times) = vehicle.asked.map_or((None, 0), |(at, times)| (Some(at), times));
    if asked.is_some_and(|asked| now.saturating_sub(asked) < ASK_AGAIN) {
        return Vec::new();
    }
    let target = vehicle.target;
    let mut wanted = Vec::new();
    let rate = vehicle.track.rate_hz(now_s, 1.5);
    let comes = rate.is_some_and(|rate| rate >= RATE_SHARE * position_hz)
        && vehicle.age_s(now_s).is_some_and(|age_s| age_s < 1.0);
    if !comes {
        wanted.push(set_message_interval(target, GLOBAL_POSITION_INT, position_hz));
    }
    // What is good to have is asked for three times; an autopilot that does not have it has said so.
    if times < 3 {
        wanted.extend(streams(kind).into_iter().map(|(id, hz)| set_message_interval(target, id, hz)));
        // Headings tell the wind and the turns between positions; on a slow line positions are worth more.
        if !is_slow && !kind.hovers() {
            wanted.push(set_message_interval(target, ATTITUDE, position_hz));
        }
    }
    if is_slow {
        wanted.extend(silence(vehicle, kind));
    }
    if vehicle.version.is_none() && times < 5 {
        wanted.push(request_message(target, AUTOPILOT_VERSION));
    }
    if vehicle.home.is_none() {
        wanted.push(request_message(target, HOME_POSITION));
    }
    if vehicle.origin.is_none() && times < 10 {
        wanted.push(request_message(target, GPS_GLOBAL_ORIGIN));
    }
    wanted.extend(parameters(vehicle, times));
    if !wanted.is_empty() {
        vehicle.asked = Some((now, times + 1));
    }
    wanted
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

/// Silences the streams that come and are not needed, for a link that is slow.
fn silence(vehicle: &mut Vehicle, kind: AutopilotKind) -> Vec<Message> {
    let needed = streams(kind);
    let target = vehicle.target;
    let mut silenced = Vec::new();
    for (&id, stream) in &mut vehicle.streams {
        let is_needed = KEPT.contains(&id) || needed.iter().any(|(stream, _)| *stream == id);
        if !is_needed && stream.heard >= STREAM_HEARD && stream.silenced < SILENCE_TRIES {
            *stream = Stream { heard: 0, silenced: stream.silenced + 1 };
            silenced.push(set_message_interval(target, id, -1e6));
        }
    }
    silenced
}

/// Reads the parameters that limit the vehicle, a few times; what does not come it does not have.
fn parameters(vehicle: &mut Vehicle, times: u32) -> Vec<Message> {
    const TRIES: u32 = 4;
    let Some(driver) = vehicle.driver().cloned() else { return Vec::new() };
    for &name in driver.limit_parameters() {
        vehicle.parameters.entry(name.to_owned()).or_default();
    }
    let missing: Vec<String> =
        vehicle.parameters.iter().filter(|(_, value)| value.is_none()).map(|(name, _)| name.clone()).collect();
    let limits = driver.limits(&|name| vehicle.parameters.get(name).copied().flatten());
    let knows_enough = limits.speed_max_mps.is_some() && limits.bank_max_rad.is_some() && times >= 2;
    if missing.is_empty() || knows_enough || times >= TRIES {
        vehicle.limits = Some(limits);
        return Vec::new();
    }
    let read = |name: String| {
        Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            param_index: -1,
            target_system: vehicle.target.system_id,
            target_component: vehicle.target.component_id,
            param_id: name.as_str().into(),
        })
    };
    missing.into_iter().map(read).collect()
}

/// TIMESYNC with our time: the answer gives the delay of the link.
pub fn time_request(vehicle: &Vehicle, now: Duration) -> Message {
    Message::TIMESYNC(TIMESYNC_DATA {
        tc1: 0,
        ts1: now.as_nanos() as i64,
        target_system: vehicle.target.system_id,
        target_component: vehicle.target.component_id,
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
        let mut vehicle = Vehicle::new(1, 1);
        let mut sent = 0;
        for _ in 0..100 {
            for id in [HEARTBEAT, ATTITUDE, GLOBAL_POSITION_INT, EXTENDED_SYS_STATE] {
                vehicle.streams.entry(id).or_default().heard += 1;
            }
            let silenced = silence(&mut vehicle, AutopilotKind::ArduPlane);
            assert!(silenced.iter().all(|message| *message == set_message_interval(vehicle.target, ATTITUDE, -1e6)));
            sent += silenced.len() as u32;
        }
        assert_eq!(sent, SILENCE_TRIES);
        let Message::COMMAND_LONG(command) = set_message_interval(vehicle.target, ATTITUDE, -1e6) else { panic!() };
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
