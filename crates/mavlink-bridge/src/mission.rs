//! The mission protocol on the wire (<https://mavlink.io/en/services/mission.html>): the items of missions, geofences
//! and rally points.
//!
//! Messages are read from the frame itself: an item with a command or a frame that the dialect does not know must be
//! answered with a refusal, or its sender waits for a time-out.

// Clients still use messages that the dialect marks as superseded, and ArduPlane answers.
#![allow(deprecated)]

use crate::coordinates::{AltitudeDatum, LatLonE7};
use crate::dialect::{
    MISSION_ACK_DATA, MISSION_CLEAR_ALL_DATA, MISSION_COUNT_DATA, MISSION_ITEM_DATA, MISSION_ITEM_INT_DATA,
    MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, MISSION_REQUEST_LIST_DATA, MISSION_SET_CURRENT_DATA,
    MISSION_WRITE_PARTIAL_LIST_DATA, MavMissionResult,
};
use crate::{Encoder, Frame, Target};
use mavlink::MessageData;

/// One item of a plan, numbers as on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanItem {
    /// Params 1 to 4.
    pub params: [f32; 4],
    /// Latitude, 1e-7 degrees.
    pub latitude_e7: i32,
    /// Longitude, 1e-7 degrees.
    pub longitude_e7: i32,
    /// Altitude, m, from the datum of the frame.
    pub z_m: f32,
    /// MAV_CMD.
    pub command: u16,
    /// MAV_FRAME.
    pub frame: u8,
    /// 1 to go on with the next item by itself.
    pub autocontinue: u8,
}

/// Which message of a pair is meant: the newer one with integers, or the older one with floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemKind {
    /// MISSION_ITEM_INT, MISSION_REQUEST_INT.
    Int,
    /// MISSION_ITEM, MISSION_REQUEST.
    Float,
}

/// A message of the mission protocol.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanMessage {
    /// MISSION_REQUEST_LIST.
    RequestList,
    /// MISSION_REQUEST_INT or MISSION_REQUEST, with the index of the item.
    Request(u16, ItemKind),
    /// MISSION_COUNT: so many items are to come.
    Count(u16),
    /// MISSION_WRITE_PARTIAL_LIST: the first and the last index to come.
    WritePartial(i16, i16),
    /// MISSION_ITEM_INT or MISSION_ITEM.
    Item {
        /// Its index.
        seq: u16,
        /// What it says.
        item: PlanItem,
        /// 1 for the item that is being flown; 2 to fly there now and 3 to change altitude now, outside any mission.
        current: u8,
        /// Which of the two messages.
        kind: ItemKind,
    },
    /// MISSION_CLEAR_ALL.
    ClearAll,
    /// MISSION_SET_CURRENT.
    SetCurrent(u16),
    /// MISSION_ACK, with its MAV_MISSION_RESULT.
    Ack(u8),
}

impl PlanItem {
    /// Where it is.
    pub fn position(&self) -> LatLonE7 {
        LatLonE7::new(self.latitude_e7, self.longitude_e7)
    }

    /// What its altitude is measured from; none if its frame is not a global one.
    pub fn altitude_datum(&self) -> Option<AltitudeDatum> {
        AltitudeDatum::of_frame(self.frame)
    }
}

impl PlanMessage {
    /// Which pair of messages its sender uses for items, as far as this message shows.
    pub fn item_kind(&self) -> Option<ItemKind> {
        match *self {
            Self::Request(_, kind) | Self::Item { kind, .. } => Some(kind),
            _ => None,
        }
    }
}

/// An item to send.
#[derive(Clone, Copy, Debug)]
pub struct PlanItemMessage<'a> {
    /// MAV_MISSION_TYPE: which plan it is of. Lost in MAVLink 1, which knows only missions.
    pub mission_type: u8,
    /// Its index.
    pub seq: u16,
    /// What it says.
    pub item: &'a PlanItem,
    /// Whether it is flown at present.
    pub is_current: bool,
    /// MISSION_ITEM_INT or MISSION_ITEM.
    pub kind: ItemKind,
    /// To whom.
    pub to: Target,
}

/// The mission protocol message in a frame: its target, its MAV_MISSION_TYPE and the message; none for another frame.
pub(crate) fn plan_message(frame: &Frame<'_>) -> Option<(Target, u8, PlanMessage)> {
    let two = |start: usize| [frame.payload_byte(start), frame.payload_byte(start + 1)];
    let number = |start: usize| u16::from_le_bytes(two(start));
    let (target_at, type_at, message) = match frame.header.message_id {
        MISSION_REQUEST_LIST_DATA::ID => (0, 2, PlanMessage::RequestList),
        MISSION_CLEAR_ALL_DATA::ID => (0, 2, PlanMessage::ClearAll),
        MISSION_REQUEST_INT_DATA::ID => (2, 4, PlanMessage::Request(number(0), ItemKind::Int)),
        MISSION_REQUEST_DATA::ID => (2, 4, PlanMessage::Request(number(0), ItemKind::Float)),
        MISSION_COUNT_DATA::ID => (2, 4, PlanMessage::Count(number(0))),
        MISSION_ACK_DATA::ID => (0, 3, PlanMessage::Ack(frame.payload_byte(2))),
        MISSION_WRITE_PARTIAL_LIST_DATA::ID => {
            let index = |start: usize| i16::from_le_bytes(two(start));
            (4, 6, PlanMessage::WritePartial(index(0), index(2)))
        }
        // It has no type: only missions have a current item.
        MISSION_SET_CURRENT_DATA::ID => return Some((frame.target_at(2), 0, PlanMessage::SetCurrent(number(0)))),
        MISSION_ITEM_INT_DATA::ID => (32, 37, item(frame, ItemKind::Int)),
        MISSION_ITEM_DATA::ID => (32, 37, item(frame, ItemKind::Float)),
        _ => return None,
    };
    Some((frame.target_at(target_at), frame.payload_byte(type_at), message))
}

fn item(frame: &Frame<'_>, kind: ItemKind) -> PlanMessage {
    let four = |start: usize| -> [u8; 4] { std::array::from_fn(|index| frame.payload_byte(start + index)) };
    let real = |start: usize| f32::from_le_bytes(four(start));
    let place = |start: usize| match kind {
        ItemKind::Int => i32::from_le_bytes(four(start)),
        // A value that is not finite or too large becomes an invalid latitude or longitude.
        ItemKind::Float if real(start).is_finite() => (f64::from(real(start)) * 1e7).round() as i32,
        ItemKind::Float => i32::MAX,
    };
    let two = |start: usize| u16::from_le_bytes([frame.payload_byte(start), frame.payload_byte(start + 1)]);
    let item = PlanItem {
        params: [real(0), real(4), real(8), real(12)],
        latitude_e7: place(16),
        longitude_e7: place(20),
        z_m: real(24),
        command: two(30),
        frame: frame.payload_byte(34),
        autocontinue: frame.payload_byte(36),
    };
    PlanMessage::Item { seq: two(28), item, current: frame.payload_byte(35), kind }
}

impl Encoder {
    /// Appends a MISSION_ACK for a type of plan by its number, which the dialect need not know
    /// (<https://mavlink.io/en/messages/common.html#MISSION_ACK>). `plan_id` is that of the plan that was uploaded, or
    /// 0.
    pub fn encode_mission_ack(
        &mut self,
        mission_type: u8,
        result: MavMissionResult,
        plan_id: u32,
        target: Target,
        out: &mut Vec<u8>,
    ) {
        let [a, b, c, d] = plan_id.to_le_bytes();
        let fields = [target.system_id, target.component_id, result as u8, mission_type, a, b, c, d];
        self.write_fields(MISSION_ACK_DATA::ID, &fields, 3, out);
    }

    /// Appends an item of a plan as MISSION_ITEM_INT or MISSION_ITEM.
    pub fn encode_plan_item(&mut self, message: &PlanItemMessage<'_>, out: &mut Vec<u8>) {
        let PlanItemMessage { mission_type, seq, item, is_current, kind, to } = *message;
        let place = |e7: i32| match kind {
            ItemKind::Int => e7.to_le_bytes(),
            ItemKind::Float => ((f64::from(e7) * 1e-7) as f32).to_le_bytes(),
        };
        let mut fields = [0; 38];
        let words = item.params.map(f32::to_le_bytes);
        let places = [item.latitude_e7, item.longitude_e7].map(place);
        let words = words.iter().chain(&places).flatten().copied();
        let rest = item.z_m.to_le_bytes().into_iter().chain(seq.to_le_bytes()).chain(item.command.to_le_bytes());
        let tail = [to.system_id, to.component_id, item.frame, u8::from(is_current), item.autocontinue, mission_type];
        for (field, byte) in fields.iter_mut().zip(words.chain(rest).chain(tail)) {
            *field = byte;
        }
        let id = match kind {
            ItemKind::Int => MISSION_ITEM_INT_DATA::ID,
            ItemKind::Float => MISSION_ITEM_DATA::ID,
        };
        self.write_fields(id, &fields, 37, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::Message;
    use crate::{Counters, Version, frames};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn items_survive_the_wire_and_are_what_the_dialect_reads(
            seq in any::<u16>(), params in prop::array::uniform4(-1e3..1e3f32), z_m in -1e4..1e4f32,
            v1 in any::<bool>(), mission_type in 0..3u8, current in any::<bool>(),
            latitude_e7 in -900_000_000..900_000_000i32, longitude_e7 in -1_800_000_000..1_800_000_000i32,
        ) {
            let item = PlanItem { params, latitude_e7, longitude_e7, z_m, command: 16, frame: 3, autocontinue: 1 };
            let to = Target { system_id: 7, component_id: 1 };
            let version = if v1 { Version::V1 } else { Version::V2 };
            for kind in [ItemKind::Int, ItemKind::Float] {
                let mut bytes = Vec::new();
                let message = PlanItemMessage { mission_type, seq, item: &item, is_current: current, kind, to };
                Encoder::new(255, 190).with_version(version).encode_plan_item(&message, &mut bytes);
                let frame = frames(&bytes, &mut Counters::default()).next().unwrap();
                let (target, read_type, message) = plan_message(&frame).unwrap();
                let read_kind = message.item_kind();
                let PlanMessage::Item { seq: read_seq, item: read, current: read_current, .. } = message else {
                    panic!()
                };
                prop_assert_eq!(read_kind, Some(kind));
                prop_assert_eq!(read_type, if v1 { 0 } else { mission_type });
                prop_assert_eq!((target, read_seq, read_current == 1), (to, seq, current));
                // A float of degrees is good for about a metre.
                let far = if kind == ItemKind::Int { 0 } else { 100 };
                prop_assert!(read.latitude_e7.abs_diff(latitude_e7) <= far);
                prop_assert!(read.longitude_e7.abs_diff(longitude_e7) <= far);
                prop_assert_eq!(PlanItem { latitude_e7, longitude_e7, ..read }, item);
                match frame.message().unwrap() {
                    Message::MISSION_ITEM_INT(data) => {
                        prop_assert_eq!((data.seq, data.x, data.z), (seq, latitude_e7, z_m))
                    }
                    Message::MISSION_ITEM(data) => {
                        prop_assert_eq!((data.seq, data.param2, data.z), (seq, params[1], z_m))
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }

    #[test]
    fn a_place_that_is_no_number_is_none_on_earth() {
        let data = MISSION_ITEM_DATA { x: f32::NAN, y: 1e30, ..MISSION_ITEM_DATA::DEFAULT };
        let mut bytes = Vec::new();
        Encoder::new(255, 190).encode(&Message::MISSION_ITEM(data), &mut bytes);
        let frame = frames(&bytes, &mut Counters::default()).next().unwrap();
        let Some((_, _, PlanMessage::Item { item, .. })) = plan_message(&frame) else { panic!() };
        assert!(!item.position().is_latitude_valid() && !item.position().is_longitude_valid());
    }
}
