//! Whatever comes in: no panic, and no effect unless it is a whole frame with the right checksum.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Client, peer, quiet};
use flight_model::{Setpoint, State};
use mavlink_bridge::{Target, local_ned_setpoint};
use proptest::prelude::*;
use std::time::Duration;

fn undisturbed() -> Vec<State> {
    Client::new(quiet()).fly(3.0)
}

fn setpoint_frame(client: &mut Client) -> Vec<u8> {
    let target = Target { system_id: common::TARGET, component_id: 1 };
    let setpoint = Setpoint { speed_mps: 14.0, course_rad: 2.0, altitude_m: 80.0 };
    client.encode(&local_ned_setpoint(Duration::ZERO, target, &setpoint))
}

proptest! {
    #[test]
    fn random_datagrams_change_nothing(
        datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 1..20),
    ) {
        let mut client = Client::new(quiet());
        for datagram in &datagrams {
            client.vehicle.handle(Duration::ZERO, datagram, peer(9));
        }
        prop_assert_eq!(client.vehicle.poll_transmit(), None);
        prop_assert_eq!(client.fly(3.0), undisturbed());
    }

    #[test]
    fn a_spoiled_frame_changes_nothing_and_is_counted(
        position in 1..1000usize, flip in 1..=255u8, cut in any::<bool>(),
    ) {
        let mut client = Client::new(quiet());
        let mut datagram = setpoint_frame(&mut client);
        let index = position % datagram.len();
        if cut {
            datagram.truncate(index);
        } else {
            datagram[index] ^= flip;
        }
        client.vehicle.handle(Duration::ZERO, &datagram, peer(9));
        let wire = client.vehicle.wire_counters();
        prop_assert_eq!(wire.frames, 0);
        let noticed = wire.bad_checksum + wire.malformed_bytes + wire.unknown_message + wire.incompatible_flags;
        prop_assert!(noticed > 0 || datagram.is_empty());
        prop_assert_eq!(client.fly(3.0), undisturbed());
    }

    /// Frames with the right checksum and random payloads, of every kind that the vehicle listens to.
    #[test]
    fn no_payload_makes_it_panic_or_leave_its_limits(
        frames in prop::collection::vec((0..20usize, prop::collection::vec(any::<u8>(), 60)), 1..40),
    ) {
        // Message id, length of the payload, CRC_EXTRA.
        let kinds: [(u8, usize, u8); 20] = [
            (0, 9, 50), (4, 14, 237), (11, 6, 89), (75, 35, 158), (76, 33, 152), (77, 10, 143), (84, 53, 143),
            (86, 53, 5), (111, 18, 34), (20, 20, 214), (21, 2, 159), (23, 23, 168), (44, 5, 221),
            (73, 38, 38), (39, 38, 254), (51, 5, 196),
            (38, 7, 9), (41, 4, 28), (45, 3, 232), (66, 6, 148),
        ];
        let mut client = Client::new(quiet());
        for (kind, mut payload) in frames {
            let (id, length, extra) = kinds[kind];
            payload.truncate(length);
            // Aim at the vehicle where there is a target, or nothing would come of it.
            match id {
                75 | 76 => payload[30] = 0,
                84 | 86 => payload[50] = 0,
                11 | 23 => payload[4] = 0,
                20 => payload[2] = 0,
                21 | 45 => payload[0] = 0,
                44 | 51 | 41 | 66 => payload[2] = 0,
                38 => payload[4] = 0,
                73 | 39 => payload[32] = 0,
                _ => {}
            }
            let mut frame = vec![0xFD, length as u8, 0, 0, 0, 255, 190, id, 0, 0];
            frame.extend_from_slice(&payload);
            let crc = frame[1..].iter().chain([&extra]).fold(0xFFFFu16, |crc, byte| {
                (0..8).fold(crc ^ u16::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0x8408 } else { crc >> 1 })
            });
            frame.extend_from_slice(&crc.to_le_bytes());
            client.vehicle.handle(client.vehicle.time(), &frame, peer(9));
            prop_assert_eq!(client.vehicle.wire_counters().bad_checksum, 0);
            for state in client.fly(0.1) {
                prop_assert!(state.is_finite());
                prop_assert!((5.0..=15.0).contains(&state.speed_mps));
                prop_assert!((-6.0..=6.0).contains(&state.climb_mps));
            }
        }
        prop_assert!(client.vehicle.wire_counters().frames > 0);
    }
}
