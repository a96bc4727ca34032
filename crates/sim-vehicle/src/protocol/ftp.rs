//! The file transfer protocol (<https://mavlink.io/en/services/ftp.html>): there are no files.

use crate::telemetry::announce::Component;
use mavlink_bridge::Target;
use mavlink_bridge::dialect::{FILE_TRANSFER_PROTOCOL_DATA, Message};

/// An error to the request, under the next number, so that nobody waits for a time-out.
pub(crate) fn refuse(component: &mut Component, link: usize, to: Target, data: &FILE_TRANSFER_PROTOCOL_DATA) {
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
    component.links().send(link, &Message::FILE_TRANSFER_PROTOCOL(answer));
}
