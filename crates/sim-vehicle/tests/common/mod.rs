//! A client of one vehicle, in memory.
#![allow(dead_code)]

use mavlink_bridge::dialect::{
    COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, LOCAL_POSITION_NED_DATA, MavCmd, MavFrame, MavParamType,
    MavResult, Message, PARAM_SET_DATA,
};
use mavlink_bridge::{Counters, Encoder, Frame, FrameError, PlanItem, frames};
use sim_vehicle::{PeerId, TelemetryRates, Vehicle, VehicleSettings};
use std::time::Duration;

pub const TARGET: u8 = 7;

pub fn peer(port: u16) -> PeerId {
    PeerId::from(([127, 0, 0, 1], port))
}

/// A vehicle without telemetry of its own accord.
pub fn quiet() -> VehicleSettings {
    VehicleSettings { system_id: TARGET, rates: TelemetryRates::OFF, ground: None, ..VehicleSettings::default() }
}

/// An item of a plan, above home, at a place in m from it.
pub fn item(command: MavCmd, params: [f32; 4], north_m: f64, east_m: f64, z_m: f32) -> PlanItem {
    let place = quiet().frame.to_geodetic(north_m, east_m, f64::from(z_m));
    PlanItem {
        params,
        latitude_e7: (place.latitude_deg * 1e7).round() as i32,
        longitude_e7: (place.longitude_deg * 1e7).round() as i32,
        z_m,
        command: command as u32 as u16,
        frame: 3,
        autocontinue: 1,
    }
}

pub struct Client {
    pub vehicle: Vehicle,
    pub encoder: Encoder,
    pub address: PeerId,
}

impl Client {
    pub fn new(settings: VehicleSettings) -> Self {
        Self { vehicle: Vehicle::new(settings).unwrap(), encoder: Encoder::new(255, 190), address: peer(40_000) }
    }

    pub fn encode(&mut self, message: &Message) -> Vec<u8> {
        let mut datagram = Vec::new();
        self.encoder.encode(message, &mut datagram);
        datagram
    }

    /// Sends a message and gives what comes back to this client.
    pub fn ask(&mut self, message: &Message) -> Vec<Message> {
        let datagram = self.encode(message);
        self.vehicle.handle(self.vehicle.time(), &datagram, self.address);
        self.collect()
    }

    pub fn collect(&mut self) -> Vec<Message> {
        let mut received = Vec::new();
        while let Some(transmit) = self.vehicle.poll_transmit() {
            if transmit.to == self.address {
                received.extend(decode(&transmit.datagram));
            }
        }
        received
    }

    /// COMMAND_INT, and the result in its acknowledgement.
    pub fn command_int(&mut self, command: MavCmd, params: [f32; 3], z: f32, frame: MavFrame) -> Option<MavResult> {
        let [param1, param2, param3] = params;
        let data = COMMAND_INT_DATA {
            param1,
            param2,
            param3,
            z,
            command,
            frame,
            target_system: TARGET,
            ..COMMAND_INT_DATA::DEFAULT
        };
        acknowledgement(&self.ask(&Message::COMMAND_INT(data))).map(|ack| {
            assert_eq!((ack.command, ack.target_system, ack.target_component), (command, 255, 190));
            ack.result
        })
    }

    /// COMMAND_LONG, and the result in its acknowledgement.
    pub fn command_long(&mut self, command: MavCmd, params: [f32; 3]) -> Option<MavResult> {
        acknowledgement(&self.ask(&long(TARGET, command, params))).map(|ack| ack.result)
    }

    pub fn fly(&mut self, seconds: f64) -> Vec<flight_model::State> {
        let mut track = Vec::new();
        self.vehicle.advance(self.vehicle.time() + Duration::from_secs_f64(seconds), &mut track);
        track
    }
}

pub fn long(target_system: u8, command: MavCmd, [param1, param2, param3]: [f32; 3]) -> Message {
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        command,
        target_system,
        ..COMMAND_LONG_DATA::DEFAULT
    })
}

pub fn set_parameter(name: &str, value: f32) -> Message {
    Message::PARAM_SET(PARAM_SET_DATA {
        param_value: value,
        target_system: TARGET,
        target_component: 1,
        param_id: name.into(),
        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
    })
}

pub fn decode(datagram: &[u8]) -> Vec<Message> {
    let mut counters = Counters::default();
    let read = |frame: Frame<'_>| match frame.message() {
        // Of ArduPilot's own dialect.
        Err(FrameError::UnknownMessage(_)) => None,
        message => Some(message.unwrap()),
    };
    let messages = frames(datagram, &mut counters).filter_map(read).collect();
    assert_eq!((counters.bad_checksum, counters.malformed_bytes, counters.unknown_message), (0, 0, 0));
    messages
}

/// The name of the command that a datagram of one frame holds, if the dialect knows it.
pub fn decode_command(datagram: &[u8]) -> Option<String> {
    let mut counters = Counters::default();
    match frames(datagram, &mut counters).next()?.message().ok()? {
        Message::COMMAND_LONG(data) => Some(format!("{:?}", data.command)),
        Message::COMMAND_INT(data) => Some(format!("{:?}", data.command)),
        _ => None,
    }
}

pub fn acknowledgement(messages: &[Message]) -> Option<COMMAND_ACK_DATA> {
    let mut acks = messages.iter().filter_map(|message| match message {
        Message::COMMAND_ACK(ack) => Some(ack.clone()),
        _ => None,
    });
    let ack = acks.next();
    assert!(acks.next().is_none(), "one acknowledgement for one command");
    ack
}

/// What was said, each text whole.
pub fn texts(messages: &[Message]) -> Vec<String> {
    let mut texts: Vec<String> = Vec::new();
    for message in messages {
        let Message::STATUSTEXT(text) = message else { continue };
        let words = text.text.to_str().unwrap_or_default();
        match texts.last_mut().filter(|_| text.chunk_seq > 0) {
            Some(begun) => begun.push_str(words),
            None => texts.push(words.to_owned()),
        }
    }
    texts
}

pub fn positions(messages: &[Message]) -> Vec<LOCAL_POSITION_NED_DATA> {
    messages
        .iter()
        .filter_map(|message| match message {
            Message::LOCAL_POSITION_NED(position) => Some(position.clone()),
            _ => None,
        })
        .collect()
}

/// A MAVLink 2 frame with a payload of our own (checksum: CRC-16/MCRF4XX).
pub fn by_hand(id: u8, crc_extra: u8, payload: &[u8]) -> Vec<u8> {
    let mut frame = vec![0xFD, payload.len() as u8, 0, 0, 0, 255, 190, id, 0, 0];
    frame.extend_from_slice(payload);
    let crc = frame[1..].iter().chain([&crc_extra]).fold(0xFFFFu16, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0x8408 } else { crc >> 1 })
    });
    frame.extend_from_slice(&crc.to_le_bytes());
    frame
}
