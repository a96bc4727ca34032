//! Parameters on the wire (<https://mavlink.io/en/services/parameter.html>), as ArduPilot has them: the value is always
//! a `f32`, whatever type the parameter is of.
//!
//! Requests are read from the frame itself: ArduPilot ignores the type that a writer gives, so a type that the dialect
//! does not know must not hide the request. PX4 reads the type, and encodes integers by their bytes.

use crate::dialect::{
    MavParamError, MavParamType, Message, PARAM_ERROR_DATA, PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA,
    PARAM_SET_DATA, PARAM_VALUE_DATA,
};
use crate::{Frame, Target};
use mavlink::MessageData;

/// The longest name of a parameter, bytes.
pub const PARAMETER_NAME_MAX: usize = 16;

/// A request of the parameter protocol.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterRequest {
    /// PARAM_REQUEST_LIST: all of them.
    List,
    /// PARAM_REQUEST_READ with an index of the list.
    ReadIndex(i16),
    /// PARAM_REQUEST_READ with a name, the index being -1.
    ReadName(String),
    /// PARAM_SET.
    Set {
        /// Name of the parameter.
        name: String,
        /// The new value, in the bits that it came in.
        value: f32,
        /// The writer's MAV_PARAM_TYPE, in the dialect or not.
        kind: u8,
    },
}

/// The parameter request in a frame and its target; none for another frame.
pub(crate) fn parameter_request(frame: &Frame<'_>) -> Option<(Target, ParameterRequest)> {
    let four = |start: usize| std::array::from_fn(|index| frame.payload_byte(start + index));
    match frame.header.message_id {
        PARAM_REQUEST_LIST_DATA::ID => Some((frame.target_at(0), ParameterRequest::List)),
        PARAM_REQUEST_READ_DATA::ID => {
            let index = i16::from_le_bytes([frame.payload_byte(0), frame.payload_byte(1)]);
            let request = if index == -1 {
                ParameterRequest::ReadName(name(frame, 4))
            } else {
                ParameterRequest::ReadIndex(index)
            };
            Some((frame.target_at(2), request))
        }
        PARAM_SET_DATA::ID => {
            let value = f32::from_le_bytes(four(0));
            Some((
                frame.target_at(4),
                ParameterRequest::Set { name: name(frame, 6), value, kind: frame.payload_byte(22) },
            ))
        }
        _ => None,
    }
}

/// PARAM_VALUE (<https://mavlink.io/en/messages/common.html#PARAM_VALUE>). Without an index it says 65535, as ArduPilot
/// does when it was not asked by index.
pub fn parameter_value(name: &str, kind: MavParamType, value: f32, count: u16, index: Option<u16>) -> Message {
    Message::PARAM_VALUE(PARAM_VALUE_DATA {
        param_value: value,
        param_count: count,
        param_index: index.unwrap_or(u16::MAX),
        param_id: name.into(),
        param_type: kind,
    })
}

/// PARAM_ERROR (<https://mavlink.io/en/messages/common.html#PARAM_ERROR>): why a request was not met. Clients older
/// than the message pass over it.
pub fn parameter_error(name: &str, index: i16, error: MavParamError, to: Target) -> Message {
    Message::PARAM_ERROR(PARAM_ERROR_DATA {
        param_index: index,
        target_system: to.system_id,
        target_component: to.component_id,
        param_id: name.into(),
        error,
    })
}

/// A name ends at its first zero. What cannot be printed becomes a question mark, which is in no parameter's name.
fn name(frame: &Frame<'_>, start: usize) -> String {
    (start..start + PARAMETER_NAME_MAX)
        .map(|offset| frame.payload_byte(offset))
        .take_while(|&byte| byte != 0)
        .map(|byte| if byte.is_ascii_graphic() { char::from(byte) } else { '?' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Counters, Encoder, Version, frames};
    use proptest::prelude::*;

    fn journey(message: &Message, version: Version) -> Option<(Target, ParameterRequest)> {
        let mut bytes = Vec::new();
        Encoder::new(255, 190).with_version(version).encode(message, &mut bytes);
        let frame = frames(&bytes, &mut Counters::default()).next().unwrap();
        parameter_request(&frame)
    }

    proptest! {
        #[test]
        fn requests_survive_the_wire(
            name in "[A-Z][A-Z0-9_]{0,15}", value in any::<f32>(),
            index in 0..i16::MAX, system in any::<u8>(), v1 in any::<bool>(),
        ) {
            let version = if v1 { Version::V1 } else { Version::V2 };
            let target = Target { system_id: system, component_id: 1 };
            let set = Message::PARAM_SET(PARAM_SET_DATA {
                param_value: value,
                target_system: system,
                target_component: 1,
                param_id: name.as_str().into(),
                param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            });
            let Some((to, ParameterRequest::Set { name: read, value: v, kind: 9 })) = journey(&set, version) else {
                panic!()
            };
            prop_assert_eq!((to, read, v.to_bits()), (target, name.clone(), value.to_bits()));

            let mut read = PARAM_REQUEST_READ_DATA {
                param_index: -1,
                target_system: system,
                target_component: 1,
                param_id: name.as_str().into(),
            };
            let by_name = journey(&Message::PARAM_REQUEST_READ(read.clone()), version);
            prop_assert_eq!(by_name, Some((target, ParameterRequest::ReadName(name))));
            read.param_index = index;
            let by_index = journey(&Message::PARAM_REQUEST_READ(read), version);
            prop_assert_eq!(by_index, Some((target, ParameterRequest::ReadIndex(index))));

            let list = PARAM_REQUEST_LIST_DATA { target_system: system, target_component: 1 };
            let list = journey(&Message::PARAM_REQUEST_LIST(list), version);
            prop_assert_eq!(list, Some((target, ParameterRequest::List)));
        }
    }

    #[test]
    fn a_type_that_nobody_knows_does_not_hide_a_write() {
        let set = PARAM_SET_DATA { param_value: 2.0, param_id: "A\nB".into(), ..PARAM_SET_DATA::DEFAULT };
        let mut bytes = Vec::new();
        Encoder::new(255, 190).encode(&Message::PARAM_SET(set), &mut bytes);
        let end = bytes.len() - 2;
        bytes[10 + 22] = 200;
        let crc = crate::frame::checksum(&bytes[1..end], PARAM_SET_DATA::EXTRA_CRC).to_le_bytes();
        bytes[end..].copy_from_slice(&crc);
        let frame = frames(&bytes, &mut Counters::default()).next().unwrap();
        assert!(frame.message().is_err());
        let expected = ParameterRequest::Set { name: "A?B".to_owned(), value: 2.0, kind: 200 };
        assert_eq!(parameter_request(&frame), Some((Target::default(), expected)));
    }
}
