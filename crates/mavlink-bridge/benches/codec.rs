//! Cost of the codec for one message: `encode` is message to frame, `decode` is datagram to frame to message.
//! `datagram_of_30` decodes thirty positions in one datagram.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use flight_model::State;
use mavlink_bridge::dialect::{COMMAND_INT_DATA, MavCmd, MavFrame};
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Counters, Encoder, Message, local_position_ned, messages};
use std::time::Duration;

fn main() {
    divan::main();
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    LocalPositionNed,
    CommandInt,
    Heartbeat,
}

const KINDS: [Kind; 3] = [Kind::LocalPositionNed, Kind::CommandInt, Kind::Heartbeat];

fn message(kind: Kind) -> Message {
    let state = State { x_m: 71.3, y_m: -12.9, altitude_m: 50.2, speed_mps: 9.7, course_rad: 0.31, climb_mps: -0.4 };
    match kind {
        Kind::LocalPositionNed => local_position_ned(Duration::from_millis(123_456), &state),
        Kind::CommandInt => Message::COMMAND_INT(COMMAND_INT_DATA {
            param2: 68.75,
            param3: 50.0,
            command: MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING,
            target_system: 7,
            target_component: 1,
            frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
            ..COMMAND_INT_DATA::DEFAULT
        }),
        Kind::Heartbeat => ground_heartbeat(),
    }
}

#[divan::bench(args = KINDS)]
fn encode(bencher: Bencher, kind: Kind) {
    let message = message(kind);
    let mut encoder = Encoder::new(1, 1);
    let mut out = Vec::with_capacity(1024);
    bencher.bench_local(|| {
        out.clear();
        encoder.encode(black_box(&message), &mut out);
        out.len()
    });
}

#[divan::bench(args = KINDS)]
fn decode(bencher: Bencher, kind: Kind) {
    let mut datagram = Vec::new();
    Encoder::new(1, 1).encode(&message(kind), &mut datagram);
    let mut counters = Counters::default();
    bencher
        .bench_local(|| messages(black_box(&datagram), &mut counters).filter(|(_, message)| message.is_ok()).count());
}

#[divan::bench]
fn datagram_of_30(bencher: Bencher) {
    let mut datagram = Vec::new();
    let mut encoder = Encoder::new(1, 1);
    for _ in 0..30 {
        encoder.encode(&message(Kind::LocalPositionNed), &mut datagram);
    }
    let mut counters = Counters::default();
    bencher
        .counter(ItemsCount::new(30_u32))
        .bench_local(|| messages(black_box(&datagram), &mut counters).filter(|(_, message)| message.is_ok()).count());
}
