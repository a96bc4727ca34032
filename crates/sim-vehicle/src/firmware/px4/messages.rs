//! Which messages a PX4 sends at a rate, and which of them it sends when it is asked (`mavlink_messages.cpp`).

use super::super::rules::Offer;
use crate::autopilot::Autopilot;
use crate::telemetry::streams::Stream;

/// The messages that have a rate. One without content (no such sensor, no such device) has a rate all the same.
const STREAMS: [u16; 78] = [
    1, 2, 4, 24, 25, 26, 29, 30, 31, 32, 33, 36, 49, 62, 65, 69, 74, 76, 83, 85, 87, 93, 105, 106, 111, 112, 115, 116,
    124, 129, 132, 137, 141, 143, 147, 148, 149, 192, 225, 230, 231, 235, 241, 242, 245, 246, 250, 251, 253, 254, 261,
    263, 264, 265, 280, 281, 283, 284, 285, 286, 296, 330, 331, 339, 350, 360, 375, 395, 397, 435, 436, 441, 10_001,
    10_002, 12_900, 12_901, 12_904, 12_918,
];
/// HEARTBEAT, whose rate is fixed; PROTOCOL_VERSION; HYGROMETER_SENSOR.
const MORE: [u16; 3] = [0, 300, 12_920];

/// A message as a PX4 offers it: it is sent when asked for only where there is something to say.
pub(in crate::firmware) fn offer(message_id: u32) -> Offer {
    let is_known = u16::try_from(message_id).is_ok_and(|id| STREAMS.contains(&id) || MORE.contains(&id));
    match Stream::from_message_id(message_id) {
        Some(stream) if is_known => Offer::Sent(stream),
        _ if is_known => Offer::RateAlone,
        _ => Offer::None,
    }
}

/// Whether a message that is due is sent: what it steers for is told on the ground too, though not when it is asked
/// for; a wind is known in the air alone. MISSION_CURRENT is the mission protocol's, which nobody can ask for; the
/// others that nobody can ask for are other autopilots'.
pub(in crate::firmware) fn streams(autopilot: &Autopilot, stream: Stream) -> bool {
    match stream {
        Stream::WindCov => autopilot.flight.is_flying(),
        Stream::MissionCurrent => true,
        other if offer(other.message_id()) == Offer::None => false,
        other => has(autopilot, other),
    }
}

/// Whether a message has content: no place to fly to is told before it has flown, and sticks that nobody holds.
pub(in crate::firmware) fn has(autopilot: &Autopilot, stream: Stream) -> bool {
    match stream {
        Stream::NavControllerOutput => autopilot.flight.is_flying(),
        Stream::PositionTargetGlobalInt => autopilot.has_flown(),
        Stream::RcChannels => autopilot.are_sticks_held(),
        // It has one sensor of each.
        Stream::ScaledImu2 | Stream::ScaledImu3 | Stream::ScaledPressure2 => false,
        // For a radio link of its own.
        Stream::HighLatency2 => false,
        _ => true,
    }
}
