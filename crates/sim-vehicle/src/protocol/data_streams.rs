//! What ground stations ask when they connect, beside parameters and commands: an answer, or a refusal that they
//! understand, so that none of them waits for a time-out.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

use crate::telemetry::streams::{Stream, groups};
use crate::vehicle::Vehicle;
use mavlink_bridge::Target;
use mavlink_bridge::dialect::{
    FILE_TRANSFER_PROTOCOL_DATA, LOG_ENTRY_DATA, MavDataStream, Message, REQUEST_DATA_STREAM_DATA,
};
use std::time::Duration;

impl Vehicle {
    /// REQUEST_DATA_STREAM: ArduPlane's groups of messages, for the link that asks. A rate that is too fast is cut.
    pub(crate) fn set_data_stream(&mut self, link: usize, data: &REQUEST_DATA_STREAM_DATA) {
        let rate_hz = match data.start_stop {
            0 => 0.0,
            1 => f64::from(data.req_message_rate).min(self.autopilot.settings.fastest_hz()),
            _ => return,
        };
        let interval = (rate_hz > 0.0).then(|| Duration::from_secs_f64(1.0 / rate_hz));
        for &stream in groups_of(data.req_stream_id).iter().copied().flatten() {
            let time = self.autopilot.time;
            self.links().set_interval(link, stream, interval, time);
        }
    }

    /// There are no files (<https://mavlink.io/en/services/ftp.html>): an error to the request, under the next number.
    pub(crate) fn refuse_file_transfer(&mut self, link: usize, to: Target, data: &FILE_TRANSFER_PROTOCOL_DATA) {
        const NAK: u8 = 129;
        const UNKNOWN_COMMAND: u8 = 7;
        let [sequence_low, sequence_high, session, opcode, ..] = data.payload;
        // An answer is not answered.
        if opcode >= 128 {
            return;
        }
        let [low, high] = u16::from_le_bytes([sequence_low, sequence_high]).wrapping_add(1).to_le_bytes();
        let mut payload = [0; 251];
        payload[..6].copy_from_slice(&[low, high, session, NAK, 1, opcode]);
        payload[12] = UNKNOWN_COMMAND;
        let Target { system_id: target_system, component_id: target_component } = to;
        let answer = FILE_TRANSFER_PROTOCOL_DATA { target_network: 0, target_system, target_component, payload };
        self.links().send(link, &Message::FILE_TRANSFER_PROTOCOL(answer));
    }

    /// There are no logs on board.
    pub(crate) fn answer_log_request(&mut self, link: usize) {
        self.links().send(link, &Message::LOG_ENTRY(LOG_ENTRY_DATA::DEFAULT));
    }
}

/// The groups of messages that a request is for.
fn groups_of(group: MavDataStream) -> &'static [&'static [Stream]] {
    match group {
        MavDataStream::MAV_DATA_STREAM_ALL => groups::ALL,
        MavDataStream::MAV_DATA_STREAM_RAW_SENSORS => &[groups::RAW_SENSORS],
        MavDataStream::MAV_DATA_STREAM_EXTENDED_STATUS => &[groups::EXTENDED_STATUS],
        MavDataStream::MAV_DATA_STREAM_RC_CHANNELS => &[groups::RC_CHANNELS],
        MavDataStream::MAV_DATA_STREAM_POSITION => &[groups::POSITION],
        MavDataStream::MAV_DATA_STREAM_EXTRA1 => &[groups::EXTRA1],
        MavDataStream::MAV_DATA_STREAM_EXTRA2 => &[groups::EXTRA2],
        MavDataStream::MAV_DATA_STREAM_EXTRA3 => &[groups::EXTRA3],
        _ => &[],
    }
}
