//! Streams of messages as older ground stations ask for them, and their lists of logs, of which there are none.

// Clients still speak what the dialect calls superseded, and ArduPlane answers.
#![allow(deprecated)]

use crate::telemetry::announce::Component;
use crate::telemetry::streams::{Stream, groups};
use mavlink_bridge::dialect::{LOG_ENTRY_DATA, MavDataStream, Message, REQUEST_DATA_STREAM_DATA};
use std::time::Duration;

/// REQUEST_DATA_STREAM: ArduPlane's groups of messages, for the link that asks. A rate that is too fast is cut.
pub(crate) fn set_data_stream(component: &mut Component, link: usize, data: &REQUEST_DATA_STREAM_DATA) {
    let rate_hz = match data.start_stop {
        0 => 0.0,
        1 => f64::from(data.req_message_rate).min(component.settings.fastest_hz()),
        _ => return,
    };
    let interval = (rate_hz > 0.0).then(|| Duration::from_secs_f64(1.0 / rate_hz));
    for &stream in groups_of(data.req_stream_id).iter().copied().flatten() {
        let time = component.autopilot.time();
        component.links().set_interval(link, stream, interval, time);
    }
}

/// There are no logs on board.
pub(crate) fn answer_log_request(component: &mut Component, link: usize) {
    component.links().send(link, &Message::LOG_ENTRY(LOG_ENTRY_DATA::DEFAULT));
}

/// The groups of messages that a request is for.
fn groups_of(group: MavDataStream) -> &'static [&'static [Stream]] {
    match group {
        MavDataStream::MAV_DATA_STREAM_ALL => &[
            groups::RAW_SENSORS,
            groups::MORE_RAW_SENSORS,
            groups::EXTENDED_STATUS,
            groups::MORE_EXTENDED_STATUS,
            groups::RC_CHANNELS,
            groups::MORE_RC_CHANNELS,
            groups::POSITION,
            groups::EXTRA1,
            groups::MORE_EXTRA1,
            groups::EXTRA2,
            groups::EXTRA3,
            groups::MORE_EXTRA3,
        ],
        MavDataStream::MAV_DATA_STREAM_RAW_SENSORS => &[groups::RAW_SENSORS, groups::MORE_RAW_SENSORS],
        MavDataStream::MAV_DATA_STREAM_EXTENDED_STATUS => &[groups::EXTENDED_STATUS, groups::MORE_EXTENDED_STATUS],
        MavDataStream::MAV_DATA_STREAM_RC_CHANNELS => &[groups::RC_CHANNELS, groups::MORE_RC_CHANNELS],
        MavDataStream::MAV_DATA_STREAM_POSITION => &[groups::POSITION],
        MavDataStream::MAV_DATA_STREAM_EXTRA1 => &[groups::EXTRA1, groups::MORE_EXTRA1],
        MavDataStream::MAV_DATA_STREAM_EXTRA2 => &[groups::EXTRA2],
        MavDataStream::MAV_DATA_STREAM_EXTRA3 => &[groups::EXTRA3, groups::MORE_EXTRA3],
        _ => &[],
    }
}
