//! One flight to the last bit: seed 1 of `golden.toml` against `golden.txt`.
//!
//! The other tests fly twice and compare; this one compares with what was flown before, on other machines and by older
//! versions. It may change for a change of the law, the look-ahead, the optimiser, a default, the flight model, the
//! rounding of the wire or the stream of random numbers, if that change means to change flights: then the failing test
//! says where the new flight is, and whoever puts it in place of `golden.txt` says why in the commit. It must not
//! change for a change of speed, of structure, of the compiler or of the platform.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

use columba::config;
use columba::flying::{self, Progress};
use std::fmt::Write;
use std::path::Path;

/// Every fourth second, each vehicle's state and setpoint; `{:?}` of a number reads back to the same bits. Then a hash
/// over the bits of all rows.
fn flown() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden.toml");
    let scenario = config::load(Some(&folder), &[]).unwrap();
    let progress = Progress::new(scenario.ticks(), scenario.control_period, true);
    let (_sender, stop) = tokio::sync::watch::channel(false);
    let flight = flying::fly_in_memory(&scenario, &progress, &stop).unwrap();
    let trajectory = &flight.trajectory;
    let mut text = String::from(
        "t_s vehicle x_m y_m altitude_m speed_mps course_rad climb_mps | speed_mps course_rad altitude_m\n",
    );
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for (index, row) in trajectory.rows.iter().enumerate() {
        let (tick, vehicle) = (&trajectory.ticks[index / trajectory.vehicles], index % trajectory.vehicles + 1);
        let (at, to) = (&row.state, &row.setpoint);
        let state = [at.x_m, at.y_m, at.altitude_m, at.speed_mps, at.course_rad, at.climb_mps];
        let setpoint = [to.speed_mps, to.course_rad, to.altitude_m];
        // FNV-1a: short to write, and a golden needs no cryptography.
        for byte in state.iter().chain(&setpoint).flat_map(|value| value.to_bits().to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        if tick.t_s % 4.0 == 0.0 {
            let words = |values: &[f64]| values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(" ");
            writeln!(text, "{:?} {vehicle} {} | {}", tick.t_s, words(&state), words(&setpoint)).unwrap();
        }
    }
    writeln!(text, "all {} rows {hash:016x}", trajectory.rows.len()).unwrap();
    text
}

#[test]
fn seed_1_flies_as_it_always_did() {
    let (flown, golden) = (flown(), include_str!("golden.txt"));
    if flown != golden {
        let new = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden.txt");
        std::fs::write(&new, &flown).unwrap();
        let differ = flown.lines().zip(golden.lines()).find(|(new, old)| new != old);
        panic!("another flight than tests/golden.txt; if that is meant, {} is the new one\n{differ:#?}", new.display());
    }
}
