//! A frame in bytes, as the page reads it (`assets/wire.js`).
//!
//! Little-endian. A header of [`HEADER`] bytes, then a column for each quantity, first those of two bytes, then those
//! of one:
//!
//! | offset | type | what |
//! |---|---|---|
//! | 0 | u8 | 1: a frame |
//! | 1 | u8 | bits: [`STATUS`], [`STEERING`], [`FINE`], [`HISTORY`] |
//! | 4 | u32 | n, how many vehicles |
//! | 8 | f64 | flight time, s |
//! | 16 | f64 | flight seconds for each second of the wall clock |
//! | 24, 32, 40 | f64 | x, y and altitude of the columns' zero, m |
//! | 48, 52 | f32 | metres for one unit of x and y, and of altitude |
//! | 56 | u32 | the frame's number |
//! | 60 | u32 | version of the roster that names the vehicles |
//!
//! Columns: x, y, altitude; with `FINE` course (2^-16 turns) and speed (cm/s); with `STATUS` separation (cm), clearance
//! (cm from -32768) and flags; with `STEERING` three weights (thousandths), speed, course and altitude asked for (dm).
//! Then in bytes: without `FINE` course (2^-8 turns) and speed (half m/s); with `STATUS` age (0.1 s) and mode. The
//! greatest number stands for none; x of a vehicle that is nowhere is none.

use crate::alarms::Flags;
use crate::distances::Near;
use crate::scene::{Frame, VehicleNow};
use std::f32::consts::TAU;
use std::time::Instant;

/// Length of the header.
pub const HEADER: usize = 64;
/// Bit: with distances, flags, ages and modes.
pub const STATUS: u8 = 1;
/// Bit: with what the controller chose.
pub const STEERING: u8 = 1 << 1;
/// Bit: course and speed in two bytes each.
pub const FINE: u8 = 1 << 2;
/// Bit: of the past, for trails and charts of a page that comes late.
pub const HISTORY: u8 = 1 << 3;
/// Place of the bits in a frame.
pub const BITS_AT: usize = 1;
/// Beyond so many vehicles a frame has no `FINE` and no `STEERING`: ten thousand at 10 Hz are to fit into 1 MB/s.
pub const FINE_MAX: usize = 1500;

const NONE: u16 = u16::MAX;

/// What a frame says beside the positions.
#[derive(Clone, Copy, Debug)]
pub struct Status<'a> {
    /// What is near to each vehicle.
    pub near: &'a [Near],
    /// Each vehicle's flags.
    pub flags: &'a [Flags],
    /// Each vehicle's mode in the roster.
    pub modes: &'a [u8],
    /// The present, for ages.
    pub now: Instant,
}

/// Writes a frame.
pub fn encode(frame: &Frame, status: Option<Status<'_>>, number: u32, roster: u32) -> Vec<u8> {
    let vehicles = &frame.vehicles;
    let fine = vehicles.len() <= FINE_MAX;
    let steering = fine && status.is_some() && vehicles.iter().any(|one| one.steering.is_some());
    let mut bits = 0;
    for (bit, holds) in [(STATUS, status.is_some()), (STEERING, steering), (FINE, fine)] {
        bits |= if holds { bit } else { 0 };
    }
    let placed = || vehicles.iter().filter(|one| one.is_placed());
    let (x0_m, x1_m) = ends(placed().map(|one| one.x_m));
    let (y0_m, y1_m) = ends(placed().map(|one| one.y_m));
    let (z0_m, z1_m) = ends(placed().map(|one| one.altitude_m));
    // The last number is none's.
    let unit = |span_m: f32| (span_m / f32::from(NONE - 1)).max(0.001);
    let (unit_m, unit_up_m) = (unit((x1_m - x0_m).max(y1_m - y0_m)), unit(z1_m - z0_m));

    let mut out = Vec::with_capacity(HEADER + vehicles.len() * 32);
    out.extend_from_slice(&[1, bits, 0, 0]);
    out.extend_from_slice(&(vehicles.len() as u32).to_le_bytes());
    for value in [frame.time_s, frame.rate, f64::from(x0_m), f64::from(y0_m), f64::from(z0_m)] {
        out.extend_from_slice(&value.to_le_bytes());
    }
    out.extend_from_slice(&unit_m.to_le_bytes());
    out.extend_from_slice(&unit_up_m.to_le_bytes());
    out.extend_from_slice(&number.to_le_bytes());
    out.extend_from_slice(&roster.to_le_bytes());

    let mut wide = |column: &mut dyn FnMut(usize, &VehicleNow) -> u16| {
        for (index, vehicle) in vehicles.iter().enumerate() {
            out.extend_from_slice(&column(index, vehicle).to_le_bytes());
        }
    };
    let place = |value_m: f32, zero_m: f32, unit_m: f32| whole((value_m - zero_m) / unit_m);
    wide(&mut |_, one| if one.is_placed() { place(one.x_m, x0_m, unit_m) } else { NONE });
    wide(&mut |_, one| place(one.y_m, y0_m, unit_m));
    wide(&mut |_, one| place(one.altitude_m, z0_m, unit_up_m));
    if fine {
        wide(&mut |_, one| turns(one.course_rad, 65_536.0));
        wide(&mut |_, one| whole(one.speed_mps * 100.0));
    }
    if let Some(status) = status {
        let cm = |value_m: f32, zero: f32| if value_m.is_finite() { whole(value_m * 100.0 + zero) } else { NONE };
        wide(&mut |index, _| cm(status.near[index].separation_m, 0.0));
        wide(&mut |index, _| cm(status.near[index].clearance_m, 32_768.0));
        wide(&mut |index, _| status.flags[index].0);
    }
    if steering {
        for term in 0..3 {
            wide(&mut |_, one| one.steering.map_or(NONE, |chosen| whole(chosen.weights[term] * 1000.0)));
        }
        wide(&mut |_, one| one.steering.map_or(NONE, |chosen| whole(chosen.speed_mps * 100.0)));
        wide(&mut |_, one| one.steering.map_or(NONE, |chosen| turns(chosen.course_rad, 65_535.0)));
        wide(&mut |_, one| one.steering.map_or(NONE, |chosen| whole(chosen.altitude_m * 10.0 + 10_000.0)));
    }
    if !fine {
        out.extend(vehicles.iter().map(|one| turns(one.course_rad, 256.0) as u8));
        out.extend(vehicles.iter().map(|one| whole(one.speed_mps * 2.0).min(254) as u8));
    }
    if let Some(status) = status {
        out.extend(vehicles.iter().map(|one| match one.heard {
            Some(heard) => (status.now.saturating_duration_since(heard).as_millis() / 100).min(254) as u8,
            None => u8::MAX,
        }));
        out.extend_from_slice(status.modes);
    }
    out
}

/// Where vehicles are in a frame in bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// Flight time, s.
    pub time_s: f64,
    /// North, east and altitude in m, and course in rad, of each vehicle; none where nobody knows.
    pub vehicles: Vec<Option<[f32; 4]>>,
}

/// Reads where vehicles are; none if the bytes are no frame.
pub fn places(bytes: &[u8]) -> Option<Places> {
    let take = |at: usize| bytes.get(at..at + 8).and_then(|bytes| bytes.try_into().ok());
    let double = |at: usize| take(at).map(f64::from_le_bytes);
    let single = |at: usize| bytes.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map(f32::from_le_bytes);
    let count = bytes.get(4..8).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)? as usize;
    if bytes.first() != Some(&1) || bytes.len() < HEADER + count.checked_mul(6)? {
        return None;
    }
    let fine = bytes[BITS_AT] & FINE != 0;
    let (zero_m, unit_m, unit_up_m) = ([double(24)?, double(32)?, double(40)?], single(48)?, single(52)?);
    let column = |column: usize, index: usize| -> Option<f32> {
        let at = HEADER + 2 * (column * count + index);
        bytes.get(at..at + 2).map(|pair| f32::from(u16::from_le_bytes([pair[0], pair[1]])))
    };
    let vehicle = |index: usize| {
        let north = column(0, index).filter(|north| *north < f32::from(NONE))?;
        let course_rad = if fine { column(3, index)? * TAU / 65_536.0 } else { 0.0 };
        Some([
            zero_m[0] as f32 + north * unit_m,
            zero_m[1] as f32 + column(1, index)? * unit_m,
            zero_m[2] as f32 + column(2, index)? * unit_up_m,
            course_rad,
        ])
    };
    Some(Places { time_s: double(8)?, vehicles: (0..count).map(vehicle).collect() })
}

/// Least and greatest.
fn ends(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let (low, high) =
        values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// The nearest whole number that is not none's; beyond the range, its ends.
fn whole(value: f32) -> u16 {
    (value.round() as u16).min(NONE - 1)
}

/// An angle in parts of a turn, wrapped.
fn turns(angle_rad: f32, parts: f32) -> u16 {
    let share = (angle_rad / TAU).rem_euclid(1.0);
    let whole = (share * parts).round();
    if whole >= parts { 0 } else { whole as u16 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distances::near;
    use crate::scene::Steering;

    fn column(bytes: &[u8], index: usize, vehicles: usize) -> Vec<u16> {
        let from = HEADER + 2 * vehicles * index;
        bytes[from..from + 2 * vehicles].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
    }

    #[test]
    fn places_come_within_a_unit_and_nowhere_is_said() {
        let vehicle = |x_m: f32, y_m: f32| VehicleNow { x_m, y_m, altitude_m: 50.0, ..VehicleNow::default() };
        let mut vehicles = vec![vehicle(-100.0, 20.0), vehicle(1900.0, 900.0), vehicle(f32::NAN, 0.0)];
        vehicles[1].course_rad = -std::f32::consts::FRAC_PI_2;
        vehicles[1].steering = Some(Steering { weights: [1.5, 0.25, 9.0], ..Steering::default() });
        let frame = Frame { time_s: 12.5, vehicles, ..Frame::default() };
        let near = near(&frame.vehicles, &[]);
        let status = Status { near: &near, flags: &[Flags::default(); 3], modes: &[0, 1, 2], now: Instant::now() };
        let bytes = encode(&frame, Some(status), 7, 3);
        assert_eq!(bytes.len(), HEADER + 3 * (2 * (5 + 3 + 6) + 2));
        assert_eq!(bytes[1], STATUS | STEERING | FINE);
        let unit_m = f32::from_le_bytes([bytes[48], bytes[49], bytes[50], bytes[51]]);
        assert!(unit_m < 0.031);
        assert_eq!(column(&bytes, 0, 3), [0, NONE - 1, NONE]);
        let y = column(&bytes, 1, 3);
        assert!((f32::from(y[1]) * unit_m - 880.0).abs() <= unit_m);
        assert_eq!(column(&bytes, 3, 3)[1], 49_152, "west is three quarters of a turn");
        assert_eq!(column(&bytes, 8, 3), [NONE, 1500, NONE]);
        assert_eq!(&bytes[bytes.len() - 3..], [0, 1, 2]);
        let read = places(&bytes).unwrap();
        assert_eq!((read.time_s, read.vehicles[2]), (12.5, None));
        let [x_m, y_m, altitude_m, course_rad] = read.vehicles[1].unwrap();
        assert!((x_m - 1900.0).abs() < 0.04 && (y_m - 900.0).abs() < 0.04 && (altitude_m - 50.0).abs() < 0.01);
        assert!((course_rad - 0.75 * TAU).abs() < 1e-3);
        assert_eq!(places(&bytes[..70]), None);
    }

    #[test]
    fn ten_thousand_at_ten_hertz_fit_into_a_megabyte_a_second() {
        let vehicles = vec![VehicleNow { x_m: 0.0, y_m: 0.0, ..VehicleNow::default() }; 10_000];
        let near = near(&vehicles[..1], &[]).repeat(10_000);
        let frame = Frame { vehicles, ..Frame::default() };
        let (flags, modes) = (vec![Flags::default(); 10_000], vec![0; 10_000]);
        let status = Status { near: &near, flags: &flags, modes: &modes, now: Instant::now() };
        let with = encode(&frame, Some(status), 0, 0).len();
        let without = encode(&frame, None, 0, 0).len();
        // Two frames of ten have the status.
        assert!(2 * with + 8 * without < 1_000_000, "{with} {without}");
    }
}
