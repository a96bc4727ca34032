//! What an ArduPlane keeps of the items of a mission: each param in the bytes that there are for it
//! (`mavlink_int_to_mission_cmd`, `mission_cmd_to_mavlink_int` and the structs of AP_Mission). The rest comes back as
//! 0.

use crate::autopilot::mission::items::has_place;
use Width::*;
use mavlink_bridge::{AltitudeDatum, PlanItem};

/// The bytes of a number. One that does not fit loses its upper bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Width {
    No,
    U8,
    I8,
    U16,
    I16,
    Real,
    /// A whole number up to 255.
    Most255,
    /// Whether it is above 0: 0 or 1.
    Above0,
    /// Whether it is below 0: -1 or 1.
    Direction,
    /// A size in two bytes, and whether it is below 0.
    Signed,
}

/// A command and the bytes of its params 1 to 4. What is not here has none.
const KEPT: [(u16, [Width; 4]); 45] = [
    (16, [No, Most255, Most255, No]),
    (17, [No, No, Signed, No]),
    (19, [U16, No, Direction, Above0]),
    (21, [U16, No, No, Direction]),
    (22, [U16, No, No, No]),
    (30, [U16, No, No, No]),
    (31, [No, Signed, No, Above0]),
    (92, [U16, No, No, No]),
    (93, [Real, I8, I8, I8]),
    (112, [Real, No, No, No]),
    (114, [Real, No, No, No]),
    (115, [Real, Real, I8, U8]),
    (177, [U16, I16, No, No]),
    (178, [U8, Real, Real, No]),
    (179, [U16, No, No, No]),
    (181, [U8, U8, No, No]),
    (182, [U8, I16, Real, No]),
    (183, [U8, U16, No, No]),
    (184, [U8, U16, I16, Real]),
    (193, [U16, No, No, No]),
    (194, [U16, No, No, No]),
    (195, [U16, No, No, No]),
    (197, [U16, No, No, No]),
    (201, [U16, No, No, No]),
    (202, [U8, U16, U8, U16]),
    (203, [U8, U8, I8, U8]),
    (205, [Real, Real, Real, No]),
    (206, [Real, No, U8, No]),
    (207, [U16, No, No, No]),
    (208, [U16, No, No, No]),
    (210, [U16, No, No, No]),
    (211, [U8, U8, No, No]),
    (212, [U16, No, No, No]),
    (215, [U16, No, No, No]),
    (216, [U16, No, No, No]),
    (217, [U16, Real, Real, Real]),
    (218, [U16, U8, No, No]),
    (222, [U16, Real, Real, Real]),
    (531, [U8, Real, No, No]),
    (532, [U8, Real, No, No]),
    (534, [U8, U8, U8, No]),
    (600, [U16, No, No, No]),
    (601, [U16, I16, No, No]),
    (1000, [I8, I16, I8, I8]),
    (42_600, [U8, U8, Real, Real]),
];

/// The same of those whose params have other forms: turns, an engine, pictures, an attitude.
const TURNS: u16 = 18;
const ENGINE: u16 = 223;
const PICTURES: u16 = 2000;
const ATTITUDE: u16 = 42_703;

/// An item that is checked, as it is flown and as it comes back. The frame of a place is the one of its datum.
pub(in crate::firmware) fn as_kept(item: &PlanItem) -> PlanItem {
    let kept = PlanItem { params: params(item), command: item.command, autocontinue: 1, ..PlanItem::default() };
    if has_place(item.command) {
        let frame = match item.altitude_datum() {
            Some(AltitudeDatum::Home) => 3,
            Some(AltitudeDatum::Terrain) => 10,
            Some(AltitudeDatum::MeanSeaLevel) | None => 0,
        };
        let z_m = (item.z_m * 100.0).trunc() * 0.01;
        return PlanItem { frame, z_m, latitude_e7: item.latitude_e7, longitude_e7: item.longitude_e7, ..kept };
    }
    // What is no place has its own numbers there.
    let [x, y] = [item.latitude_e7, item.longitude_e7];
    let [latitude_e7, longitude_e7, z_m] = match item.command {
        202 => [x & 0xFF, y & 0xFF, item.z_m as i32],
        203 => [x & 0xFF, y & 0xFF, 0],
        // MAV_MOUNT_MODE_MAVLINK_TARGETING.
        205 => [0, 0, 2],
        1000 => [x & 0xFF, 0, item.z_m as i32 & 0xFF],
        ATTITUDE => [i32::from(x as i16), 0, 0],
        _ => [0; 3],
    };
    PlanItem { latitude_e7, longitude_e7, z_m: z_m as f32, ..kept }
}

fn params(item: &PlanItem) -> [f32; 4] {
    let [p1, p2, p3, p4] = item.params;
    match item.command {
        TURNS => turns([p1, p2, p3, p4]),
        ENGINE => {
            let allows_disarmed = (p4 as i64 & 1) as f32;
            [Above0.keep(p1), Above0.keep(p2), U16.keep(p3 * 100.0) * 0.01, allows_disarmed]
        }
        PICTURES => [U8.keep(p1), p2, U16.keep(p3), U16.keep(p4)],
        2001 => [U16.keep(p1), 0.0, 0.0, 0.0],
        2500 | 2501 | 3000 => [U8.keep(p1), 0.0, 0.0, 0.0],
        ATTITUDE => {
            let within =
                |angle: f32, least: f32, most: f32| if (least..=most).contains(&angle) { angle.trunc() } else { 0.0 };
            [
                p1.clamp(0.0, 65_535.0).trunc(),
                within(p2, -180.0, 180.0),
                within(p3, -90.0, 90.0),
                within(p4, -180.0, 360.0),
            ]
        }
        command => {
            let widths = KEPT.iter().find(|(known, _)| *known == command).map_or([No; 4], |(_, widths)| *widths);
            std::array::from_fn(|index| widths[index].keep(item.params[index]))
        }
    }
}

/// NAV_LOITER_TURNS in two bytes: up to 255 turns, whole ones from one on, else in parts of 256; the radius in whole
/// metres up to 255, else in tens of them.
fn turns([turns, _, radius_m, tangent]: [f32; 4]) -> [f32; 4] {
    let turns = if turns > 0.0 && turns < 1.0 { (turns * 256.0).trunc() / 256.0 } else { turns.min(255.0).trunc() };
    let size_m = radius_m.abs();
    let size_m = if size_m <= 255.0 { size_m.trunc() } else { (size_m * 0.1).trunc().min(255.0) * 10.0 };
    [turns, 0.0, size_m.copysign(radius_m), Above0.keep(tangent)]
}

impl Width {
    fn keep(self, param: f32) -> f32 {
        let whole = param as i64;
        match self {
            No => 0.0,
            U8 => f32::from(whole as u8),
            I8 => f32::from(whole as i8),
            U16 => f32::from(whole as u16),
            I16 => f32::from(whole as i16),
            Real => param,
            Most255 => f32::from((whole as u16).min(255)),
            Above0 => f32::from(param > 0.0),
            Direction => {
                if param < 0.0 {
                    -1.0
                } else {
                    1.0
                }
            }
            Signed => f32::from(param.abs() as i64 as u16).copysign(param),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(command: u16, params: [f32; 4]) -> [f32; 4] {
        as_kept(&PlanItem { command, params, ..PlanItem::default() }).params
    }

    #[test]
    fn the_table_is_in_order() {
        assert!(KEPT.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn numbers_lose_what_there_are_no_bytes_for() {
        for (command, params, expected) in [
            (16, [5.0, 2.9, 300.0, f32::NAN], [0.0, 2.0, 255.0, 0.0]),
            (16, [0.0, -1.0, 0.0, 0.0], [0.0, 255.0, 0.0, 0.0]),
            (17, [1.0, 2.0, -80.5, f32::NAN], [0.0, 0.0, -80.0, 0.0]),
            (18, [0.5, 0.0, -1234.5, 2.0], [0.5, 0.0, -1230.0, 1.0]),
            (19, [30.9, 1.0, -50.0, 0.0], [30.0, 0.0, -1.0, 0.0]),
            (21, [40.0, 0.0, 0.0, f32::NAN], [40.0, 0.0, 0.0, 1.0]),
            (31, [1.0, 70.7, 0.0, 1.0], [0.0, 70.0, 0.0, 1.0]),
            (177, [2.9, -1.0, 7.0, 7.0], [2.0, -1.0, 0.0, 0.0]),
            (178, [257.0, 12.5, 60.5, 9.0], [1.0, 12.5, 60.5, 0.0]),
            (207, [1.0, 4.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]),
            (20, [1.0; 4], [0.0; 4]),
        ] {
            assert_eq!(kept(command, params), expected, "{command}");
        }
    }

    #[test]
    fn a_place_is_kept_in_centimetres_and_in_the_frame_of_its_datum() {
        let at =
            PlanItem { command: 16, frame: 6, z_m: 50.019, latitude_e7: 7, longitude_e7: -7, ..PlanItem::default() };
        let kept = as_kept(&at);
        assert_eq!((kept.frame, kept.latitude_e7, kept.longitude_e7, kept.autocontinue), (3, 7, -7, 1));
        assert!((kept.z_m - 50.01).abs() < 1e-4);
        assert_eq!(as_kept(&PlanItem { frame: 2, ..at }).frame, 0);
        let delay = as_kept(&PlanItem { command: 112, params: [7.5, 1.0, 1.0, 1.0], ..at });
        assert_eq!((delay.frame, delay.z_m, delay.latitude_e7, delay.params), (0, 0.0, 0, [7.5, 0.0, 0.0, 0.0]));
        assert_eq!(as_kept(&delay), delay);
    }
}
