//! Laws of the wire, for any message and any bytes.

use mavlink_bridge::dialect::{
    ATTITUDE_DATA, COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, DialectMessage, GLOBAL_POSITION_INT_DATA,
    HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavCmd, MavFrame, MavModeFlag, MavResult, MavState, MavType,
    Message, PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA, SYSTEM_TIME_DATA, VFR_HUD_DATA,
};
use mavlink_bridge::{Counters, Encoder, Frame, Incoming, Version, frames, messages};
use proptest::collection::vec;
use proptest::prelude::*;

/// Any `f32` that equals itself.
fn number() -> impl Strategy<Value = f32> {
    let odd = prop::sample::select(vec![0.0, -0.0, f32::INFINITY, f32::MIN_POSITIVE]);
    prop_oneof![1 => -1e6..1e6f32, 1 => odd]
}

fn command() -> impl Strategy<Value = MavCmd> {
    prop::sample::select(vec![
        MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED,
        MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE,
        MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING,
        MavCmd::MAV_CMD_DO_SET_MODE,
        MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL,
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
    ])
}

fn frame_kind() -> impl Strategy<Value = MavFrame> {
    prop::sample::select(vec![
        MavFrame::MAV_FRAME_GLOBAL,
        MavFrame::MAV_FRAME_LOCAL_NED,
        MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
    ])
}

/// Any of the messages that Columba speaks. Boxed: a message is big, and the strategy's value tree holds many.
fn message() -> BoxedStrategy<Message> {
    let numbers = || prop::array::uniform12(number());
    prop_oneof![
        (any::<u32>(), numbers()).prop_map(|(time_boot_ms, [x, y, z, vx, vy, vz, ..])| {
            Message::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA { time_boot_ms, x, y, z, vx, vy, vz })
        }),
        (any::<u32>(), any::<[i32; 4]>(), any::<[i16; 3]>(), any::<u16>()).prop_map(
            |(time_boot_ms, [lat, lon, alt, relative_alt], [vx, vy, vz], hdg)| {
                Message::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
                    time_boot_ms,
                    lat,
                    lon,
                    alt,
                    relative_alt,
                    vx,
                    vy,
                    vz,
                    hdg,
                })
            }
        ),
        (any::<u32>(), numbers()).prop_map(
            |(time_boot_ms, [roll, pitch, yaw, rollspeed, pitchspeed, yawspeed, ..])| {
                Message::ATTITUDE(ATTITUDE_DATA { time_boot_ms, roll, pitch, yaw, rollspeed, pitchspeed, yawspeed })
            }
        ),
        (numbers(), any::<i16>(), any::<u16>()).prop_map(
            |([airspeed, groundspeed, alt, climb, ..], heading, throttle)| {
                Message::VFR_HUD(VFR_HUD_DATA { airspeed, groundspeed, alt, climb, heading, throttle })
            }
        ),
        (any::<u64>(), any::<u32>()).prop_map(|(time_unix_usec, time_boot_ms)| {
            Message::SYSTEM_TIME(SYSTEM_TIME_DATA { time_unix_usec, time_boot_ms })
        }),
        (any::<u32>(), any::<u8>()).prop_map(|(custom_mode, base_mode)| {
            Message::HEARTBEAT(HEARTBEAT_DATA {
                custom_mode,
                mavtype: MavType::MAV_TYPE_FIXED_WING,
                autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
                base_mode: MavModeFlag::from_bits_retain(base_mode),
                system_status: MavState::MAV_STATE_ACTIVE,
                mavlink_version: 3,
            })
        }),
        (numbers(), any::<[i32; 2]>(), command(), frame_kind(), any::<[u8; 4]>()).prop_map(
            |([param1, param2, param3, param4, z, ..], [x, y], command, frame, [system, component, current, auto])| {
                Message::COMMAND_INT(COMMAND_INT_DATA {
                    param1,
                    param2,
                    param3,
                    param4,
                    x,
                    y,
                    z,
                    command,
                    target_system: system,
                    target_component: component,
                    frame,
                    current,
                    autocontinue: auto,
                })
            }
        ),
        (numbers(), command(), any::<[u8; 3]>()).prop_map(
            |([param1, param2, param3, param4, param5, param6, param7, ..], command, [system, component, again])| {
                Message::COMMAND_LONG(COMMAND_LONG_DATA {
                    param1,
                    param2,
                    param3,
                    param4,
                    param5,
                    param6,
                    param7,
                    command,
                    target_system: system,
                    target_component: component,
                    confirmation: again,
                })
            }
        ),
        // Its other fields are extensions, which MAVLink 1 does not carry.
        command().prop_map(|command| {
            Message::COMMAND_ACK(COMMAND_ACK_DATA {
                command,
                result: MavResult::MAV_RESULT_DENIED,
                ..COMMAND_ACK_DATA::DEFAULT
            })
        }),
        (any::<u32>(), numbers(), any::<u16>(), any::<[u8; 2]>(), frame_kind()).prop_map(
            |(
                time_boot_ms,
                [x, y, z, vx, vy, vz, afx, afy, afz, yaw, yaw_rate, _],
                mask,
                [system, component],
                frame,
            )| {
                Message::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
                    time_boot_ms,
                    x,
                    y,
                    z,
                    vx,
                    vy,
                    vz,
                    afx,
                    afy,
                    afz,
                    yaw,
                    yaw_rate,
                    type_mask: PositionTargetTypemask::from_bits_retain(mask),
                    target_system: system,
                    target_component: component,
                    coordinate_frame: frame,
                })
            }
        ),
    ]
    .boxed()
}

fn version() -> impl Strategy<Value = Version> {
    prop::sample::select(vec![Version::V1, Version::V2])
}

fn encoded(encoder: &mut Encoder, message: &Message) -> Vec<u8> {
    let mut bytes = Vec::new();
    encoder.encode(message, &mut bytes);
    bytes
}

/// Bytes in which no frame can start.
fn garbage() -> impl Strategy<Value = Vec<u8>> {
    vec(0..0xFD_u8, 0..40)
}

/// Whether a frame that nobody sent stands at one of `offsets`: pieces of others pass for one once in 65 536 times.
fn by_chance(datagram: &[u8], mut offsets: std::ops::Range<usize>) -> bool {
    offsets.any(|offset| Frame::parse(&datagram[offset..]).is_ok())
}

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases) }
}

proptest! {
    #![proptest_config(cases(1_000))]

    #[test]
    fn decoding_gives_back_what_was_encoded(
        message in message(), version in version(), system in any::<u8>(), component in any::<u8>()
    ) {
        let mut encoder = Encoder::new(system, component).with_version(version);
        for sequence in 0..3 {
            let bytes = encoded(&mut encoder, &message);
            let frame = Frame::parse(&bytes).unwrap();
            prop_assert_eq!(frame.bytes, &bytes[..]);
            prop_assert_eq!(frame.header.version, version);
            prop_assert_eq!((frame.header.system_id, frame.header.component_id), (system, component));
            prop_assert_eq!((frame.header.sequence, frame.header.message_id), (sequence, message.message_id()));
            prop_assert_eq!(frame.message().unwrap(), message.clone());
        }
    }

    #[test]
    fn a_datagram_gives_all_its_frames_whatever_stands_between(
        parts in vec((message(), version(), garbage()), 0..30), last in garbage()
    ) {
        let mut encoder = Encoder::new(1, 1);
        let mut datagram = Vec::new();
        let mut sent = Vec::new();
        for (message, version, garbage) in &parts {
            encoder.version = *version;
            datagram.extend_from_slice(garbage);
            sent.push(encoded(&mut encoder, message));
            datagram.extend_from_slice(&sent[sent.len() - 1]);
        }
        datagram.extend_from_slice(&last);
        let mut counters = Counters::default();
        let read: Vec<Vec<u8>> = frames(&datagram, &mut counters).map(|frame| frame.bytes.to_vec()).collect();
        let garbage: usize = parts.iter().map(|(_, _, garbage)| garbage.len()).sum::<usize>() + last.len();
        prop_assert_eq!(read, sent);
        prop_assert_eq!(counters.frames, parts.len() as u64);
        prop_assert_eq!(counters.malformed_bytes, garbage as u64);
        prop_assert_eq!(counters.bad_checksum + counters.unknown_message + counters.incompatible_flags, 0);
    }

    #[test]
    fn a_truncated_frame_takes_nothing_with_it(
        before in message(), cut in message(), after in vec(message(), 1..4),
        version in version(), at in any::<prop::sample::Index>()
    ) {
        let mut encoder = Encoder::new(1, 1).with_version(version);
        let mut datagram = encoded(&mut encoder, &before);
        let piece = encoded(&mut encoder, &cut);
        let cut_at = datagram.len();
        datagram.extend_from_slice(&piece[..at.index(piece.len())]);
        let cut_to = datagram.len();
        for message in &after {
            encoder.encode(message, &mut datagram);
        }
        prop_assume!(!by_chance(&datagram, cut_at..cut_to));
        let mut counters = Counters::default();
        let read: Vec<Message> = messages(&datagram, &mut counters).filter_map(|(_, message)| message.ok()).collect();
        prop_assert_eq!(&read[0], &before);
        prop_assert_eq!(&read[1..], &after[..]);
    }

    #[test]
    fn a_flipped_bit_costs_the_frame_and_no_other(
        first in message(), second in message(), version in version(), at in any::<prop::sample::Index>(), bit in 0..8u8
    ) {
        let mut encoder = Encoder::new(1, 1).with_version(version);
        let whole = encoded(&mut encoder, &first);
        let mut broken = whole.clone();
        let index = at.index(broken.len());
        broken[index] ^= 1 << bit;
        let behind = encoded(&mut encoder, &second);
        let datagram = [&broken[..], &behind].concat();
        prop_assume!(!by_chance(&datagram, 0..broken.len()));
        let mut counters = Counters::default();
        let read: Vec<_> = frames(&datagram, &mut counters).map(|frame| frame.bytes.to_vec()).collect();
        prop_assert_eq!(read, vec![behind]);
        // A broken start byte or length leaves no frame to be counted, only bytes; a broken flag says it is another
        // kind.
        let wrong = counters.bad_checksum + counters.unknown_message + counters.incompatible_flags;
        prop_assert!(wrong == 1 || (index <= 1 && counters.malformed_bytes > 0));
    }

    #[test]
    fn random_bytes_do_no_harm(bytes in vec(any::<u8>(), 0..2000)) {
        let mut counters = Counters::default();
        for (frame, message) in messages(&bytes, &mut counters) {
            // One frame in 65 536 passes by chance; then its bytes must stand in the datagram.
            prop_assert!(bytes.windows(frame.bytes.len()).any(|window| window == frame.bytes));
            let _ = (message, Incoming::decode(&frame));
        }
        prop_assert!(counters.malformed_bytes <= bytes.len() as u64);
    }

    // Start bytes, plausible lengths and flags are common here, so that far more gets past the first check.
    #[test]
    fn bytes_that_look_like_frames_do_no_harm(
        bytes in vec(prop_oneof![Just(0xFD_u8), Just(0xFE), 0..12_u8, Just(0), any::<u8>()], 0..2000)
    ) {
        let mut counters = Counters::default();
        let read: usize = messages(&bytes, &mut counters).map(|(frame, _)| frame.bytes.len()).sum();
        prop_assert!(read <= bytes.len());
    }
}

proptest! {
    #![proptest_config(cases(20_000))]

    /// Every message of the dialect, with any payload of any length: behind a right checksum nothing is trusted either.
    #[test]
    fn any_payload_of_any_message_does_no_harm(
        id in 0..500u32, payload in vec(any::<u8>(), 0..255), v1 in any::<bool>(),
    ) {
        let message = Message::parse(
            if v1 { mavlink::MavlinkVersion::V1 } else { mavlink::MavlinkVersion::V2 }, id, &payload,
        );
        if let Ok(message) = message {
            let bytes = encoded(&mut Encoder::new(1, 1), &message);
            prop_assert!(Frame::parse(&bytes).is_ok_and(|frame| frame.header.message_id == id));
        }
    }
}
