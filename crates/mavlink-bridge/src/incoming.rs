//! What a frame asks of its receiver, decoded once: for whom it is, and which of the MAVLink services it belongs to.

use crate::command::{Command, command};
use crate::dialect::DialectMessage;
use crate::mission::{PlanMessage, plan_message};
use crate::parameter::{ParameterRequest, parameter_request};
use crate::points::{PointRequest, point_request};
use crate::{Counters, Frame, FrameError, Header, Message, Target, messages};

/// A frame as a vehicle takes it.
///
/// ```
/// use mavlink_bridge::dialect::{COMMAND_LONG_DATA, MavCmd};
/// use mavlink_bridge::{Counters, Encoder, Message, Request, incoming};
///
/// let arm = COMMAND_LONG_DATA {
///     command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
///     param1: 1.0,
///     target_system: 7,
///     ..COMMAND_LONG_DATA::DEFAULT
/// };
/// let mut datagram = Vec::new();
/// Encoder::new(255, 190).encode(&Message::COMMAND_LONG(arm), &mut datagram);
///
/// let mut counters = Counters::default();
/// let request = incoming(&datagram, &mut counters).next().unwrap();
/// assert_eq!((request.header.system_id, request.target.system_id), (255, 7));
/// let Request::Command(command) = &request.request else { panic!() };
/// assert_eq!(command.mav_cmd(), Some(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Incoming {
    /// The header of the frame: its sender.
    pub header: Header,
    /// The system and component that it is addressed to. A message without a target is for all.
    pub target: Target,
    /// What it asks.
    pub request: Request,
}

/// What a frame asks, by the service that it belongs to.
///
/// Parameters, plans and commands carry their enum values as numbers, which the dialect need not know: an autopilot
/// answers a request that it cannot meet, so that its sender does not wait for a time-out.
// Requests are read one at a time and passed by reference, never stored: no variant needs a box.
#[expect(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// The parameter protocol (<https://mavlink.io/en/services/parameter.html>).
    Parameter(ParameterRequest),
    /// The mission protocol (<https://mavlink.io/en/services/mission.html>): missions, geofences and rally points.
    Plan {
        /// MAV_MISSION_TYPE.
        mission_type: u8,
        /// What is said of that plan.
        message: PlanMessage,
    },
    /// The older protocols of fences and rally points, of ArduPilot's dialect.
    Point(PointRequest),
    /// The command protocol (<https://mavlink.io/en/services/command.html>).
    Command(Command),
    /// Any other message of the dialect.
    Message(Message),
}

impl Incoming {
    /// Decodes a frame.
    ///
    /// # Errors
    /// Why the frame holds no message, where it is not one of those whose enum values may be unknown.
    pub fn decode(frame: &Frame<'_>) -> Result<Self, FrameError> {
        Self::new(frame, frame.message())
    }

    fn new(frame: &Frame<'_>, message: Result<Message, FrameError>) -> Result<Self, FrameError> {
        let (target, request) = if let Some((target, request)) = parameter_request(frame) {
            (target, Request::Parameter(request))
        } else if let Some((target, mission_type, message)) = plan_message(frame) {
            (target, Request::Plan { mission_type, message })
        } else if let Some((target, command)) = command(frame) {
            (target, Request::Command(command))
        } else if let Some((target, request)) = point_request(frame) {
            (target, Request::Point(request))
        } else {
            let message = message?;
            let target = Target {
                system_id: message.target_system_id().unwrap_or(0),
                component_id: message.target_component_id().unwrap_or(0),
            };
            (target, Request::Message(message))
        };
        Ok(Self { header: frame.header, target, request })
    }
}

/// The requests of a datagram, in order. Frames that cannot be decoded are left out; all are counted as by
/// [`messages`].
pub fn incoming<'a>(datagram: &'a [u8], counters: &'a mut Counters) -> impl Iterator<Item = Incoming> + 'a {
    messages(datagram, counters).filter_map(|(frame, message)| Incoming::new(&frame, message).ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Encoder;
    use crate::dialect::{COMMAND_INT_DATA, MISSION_COUNT_DATA, MavCmd, PARAM_SET_DATA, TIMESYNC_DATA};
    use crate::telemetry::ground_heartbeat;

    fn datagram(messages: &[Message]) -> Vec<u8> {
        let mut datagram = Vec::new();
        let mut encoder = Encoder::new(255, 190);
        messages.iter().for_each(|message| encoder.encode(message, &mut datagram));
        datagram
    }

    #[test]
    fn each_service_has_its_kind_and_its_target() {
        let (target_system, target_component) = (7, 2);
        let count = MISSION_COUNT_DATA { count: 3, target_system, target_component, ..MISSION_COUNT_DATA::DEFAULT };
        let timesync = TIMESYNC_DATA { tc1: 0, ts1: 9, target_system, target_component };
        let sent = [
            Message::PARAM_SET(PARAM_SET_DATA { target_system, target_component, ..PARAM_SET_DATA::DEFAULT }),
            Message::MISSION_COUNT(count),
            Message::COMMAND_INT(COMMAND_INT_DATA {
                command: MavCmd::MAV_CMD_DO_REPOSITION,
                target_system,
                target_component,
                ..COMMAND_INT_DATA::DEFAULT
            }),
            Message::TIMESYNC(timesync.clone()),
        ];
        let mut counters = Counters::default();
        let datagram = datagram(&sent);
        let read: Vec<Incoming> = incoming(&datagram, &mut counters).collect();
        assert!(read.iter().all(|read| read.target == Target { system_id: 7, component_id: 2 }));
        assert_eq!(read.iter().map(|read| read.header.sequence).collect::<Vec<_>>(), [0, 1, 2, 3]);
        assert!(matches!(&read[0].request, Request::Parameter(ParameterRequest::Set { .. })));
        assert_eq!(read[1].request, Request::Plan { mission_type: 0, message: PlanMessage::Count(3) });
        let Request::Command(command) = &read[2].request else { panic!() };
        assert_eq!(command.number, 192);
        assert_eq!(read[3].request, Request::Message(Message::TIMESYNC(timesync)));
    }

    #[test]
    fn a_message_without_a_target_is_for_all() {
        let datagram = datagram(&[ground_heartbeat()]);
        let read = incoming(&datagram, &mut Counters::default()).next().unwrap();
        assert_eq!(read.target, Target::default());
        assert_eq!(read.request, Request::Message(ground_heartbeat()));
    }

    #[test]
    fn a_value_that_the_dialect_does_not_know_is_counted_and_hides_no_request_behind_it() {
        let mut bytes = datagram(&[ground_heartbeat()]);
        bytes[10 + 4] = 250; // the type of vehicle
        let end = bytes.len() - 2;
        let crc = crate::frame::checksum(&bytes[1..end], 50).to_le_bytes();
        bytes[end..].copy_from_slice(&crc);
        bytes.extend(datagram(&[ground_heartbeat()]));
        let mut counters = Counters::default();
        assert_eq!(incoming(&bytes, &mut counters).count(), 1);
        assert_eq!((counters.frames, counters.invalid_value), (2, 1));
        let bad = Frame::parse(&bytes).unwrap();
        let expected = FrameError::InvalidValue { enum_type: "MavType", value: 250 };
        assert_eq!(Incoming::decode(&bad), Err(expected));
    }
}
