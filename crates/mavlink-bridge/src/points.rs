//! Points of fences and rally points as ArduPilot's older protocols have them, one point in each message
//! (<https://mavlink.io/en/messages/ardupilotmega.html#FENCE_POINT>, #RALLY_POINT). ArduPilot 4.7 obeys them in its
//! simulator alone; the plans of [`mission`](crate::mission) have taken their place.

use crate::ardupilot::ArduPilotMessage;
use crate::{Frame, Target};

const FENCE_POINT: u32 = 160;
const FENCE_FETCH_POINT: u32 = 161;
const RALLY_POINT: u32 = 175;
const RALLY_FETCH_POINT: u32 = 176;

/// What is said of one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointRequest {
    /// FENCE_POINT: a point of the fence.
    SetFence(FencePoint),
    /// FENCE_FETCH_POINT: the point of an index is asked for.
    FetchFence(u8),
    /// RALLY_POINT: a rally point.
    SetRally(RallyPoint),
    /// RALLY_FETCH_POINT: the point of an index is asked for.
    FetchRally(u8),
}

/// FENCE_POINT. Point 0 is the return point, and the last one is the first corner again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FencePoint {
    /// Index of the point.
    pub index: u8,
    /// How many points there are.
    pub count: u8,
    /// Latitude in degrees, in the single precision of the wire.
    pub latitude_deg: f32,
    /// Longitude in degrees.
    pub longitude_deg: f32,
}

/// RALLY_POINT.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RallyPoint {
    /// Index of the point.
    pub index: u8,
    /// How many points there are.
    pub count: u8,
    /// Latitude in 1e-7 degrees.
    pub latitude_e7: i32,
    /// Longitude in 1e-7 degrees.
    pub longitude_e7: i32,
    /// Altitude in m, above what the flags say.
    pub altitude_m: i16,
    /// Altitude in m at which the circle is left to land.
    pub break_altitude_m: i16,
    /// Heading of a landing, centidegrees.
    pub land_direction_cdeg: u16,
    /// RALLY_FLAGS.
    pub flags: u8,
}

/// The request in a frame and its target; none for another frame.
pub(crate) fn point_request(frame: &Frame<'_>) -> Option<(Target, PointRequest)> {
    let byte = |offset| frame.payload_byte(offset);
    let two = |start| [byte(start), byte(start + 1)];
    let four = |start| [byte(start), byte(start + 1), byte(start + 2), byte(start + 3)];
    Some(match frame.header.message_id {
        FENCE_POINT => {
            let (latitude_deg, longitude_deg) = (f32::from_le_bytes(four(0)), f32::from_le_bytes(four(4)));
            let point = FencePoint { index: byte(10), count: byte(11), latitude_deg, longitude_deg };
            (frame.target_at(8), PointRequest::SetFence(point))
        }
        RALLY_POINT => {
            let point = RallyPoint {
                index: byte(16),
                count: byte(17),
                latitude_e7: i32::from_le_bytes(four(0)),
                longitude_e7: i32::from_le_bytes(four(4)),
                altitude_m: i16::from_le_bytes(two(8)),
                break_altitude_m: i16::from_le_bytes(two(10)),
                land_direction_cdeg: u16::from_le_bytes(two(12)),
                flags: byte(18),
            };
            (frame.target_at(14), PointRequest::SetRally(point))
        }
        FENCE_FETCH_POINT => (frame.target_at(0), PointRequest::FetchFence(byte(2))),
        RALLY_FETCH_POINT => (frame.target_at(0), PointRequest::FetchRally(byte(2))),
        _ => return None,
    })
}

/// FENCE_POINT, the answer to FENCE_FETCH_POINT.
pub fn fence_point(point: &FencePoint, to: Target) -> ArduPilotMessage {
    let place = [point.latitude_deg, point.longitude_deg].into_iter().flat_map(f32::to_le_bytes);
    let rest = [to.system_id, to.component_id, point.index, point.count];
    ArduPilotMessage::new(FENCE_POINT, 12, place.chain(rest))
}

/// RALLY_POINT, the answer to RALLY_FETCH_POINT.
pub fn rally_point(point: &RallyPoint, to: Target) -> ArduPilotMessage {
    let place = [point.latitude_e7, point.longitude_e7].into_iter().flat_map(i32::to_le_bytes);
    let altitudes = [point.altitude_m, point.break_altitude_m].into_iter().flat_map(i16::to_le_bytes);
    let rest = [to.system_id, to.component_id, point.index, point.count, point.flags];
    let fields = place.chain(altitudes).chain(point.land_direction_cdeg.to_le_bytes()).chain(rest);
    ArduPilotMessage::new(RALLY_POINT, 19, fields)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Counters, Encoder, Incoming, Request, incoming};
    use proptest::prelude::*;

    const TO: Target = Target { system_id: 3, component_id: 1 };

    fn read(message: &ArduPilotMessage) -> Incoming {
        let mut datagram = Vec::new();
        Encoder::new(255, 190).encode_ardupilot(message, &mut datagram);
        incoming(&datagram, &mut Counters::default()).next().unwrap()
    }

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
    }

    // Made by pymavlink 2.4.50: MAVLink(None, srcSystem=255, srcComponent=190), fence_fetch_point_encode(3, 1, 4) and
    // rally_fetch_point_encode(3, 1, 5), MAVLink 2.
    #[test]
    fn what_others_write_is_read() {
        for (hex, request) in [(FETCH_FENCE, PointRequest::FetchFence(4)), (FETCH_RALLY, PointRequest::FetchRally(5))] {
            let read = incoming(&bytes(hex), &mut Counters::default()).next().unwrap();
            assert_eq!((read.target, read.request), (TO, Request::Point(request)));
        }
    }

    proptest! {
        #[test]
        fn points_survive_the_wire(
            index: u8, count: u8, latitude_e7: i32, longitude_e7: i32, altitude_m: i16, break_altitude_m: i16,
            land_direction_cdeg: u16, flags: u8, latitude_deg in -90.0..90.0f32, longitude_deg in -180.0..180.0f32,
        ) {
            let rally = RallyPoint {
                index, count, latitude_e7, longitude_e7, altitude_m, break_altitude_m, land_direction_cdeg, flags,
            };
            let request = read(&rally_point(&rally, TO));
            prop_assert_eq!((request.target, request.request), (TO, Request::Point(PointRequest::SetRally(rally))));
            let fence = FencePoint { index, count, latitude_deg, longitude_deg };
            let request = read(&fence_point(&fence, TO));
            prop_assert_eq!((request.target, request.request), (TO, Request::Point(PointRequest::SetFence(fence))));
        }
    }

    const FETCH_FENCE: &str = "fd03000000ffbea10000030104aff2";
    const FETCH_RALLY: &str = "fd03000000ffbeb000000301051f8d";
}
