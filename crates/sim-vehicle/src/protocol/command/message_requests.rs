//! Commands about messages: how often one is sent, and one now.

use crate::autopilot::input::{check_finite, integer};
use crate::error::CommandError;
use crate::settings::RATE_PER_STEP_MAX;
use crate::telemetry::announce::Component;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MESSAGE_INTERVAL_DATA, Message};
use std::time::Duration;

const MESSAGE_INTERVAL: u32 = 244;

/// Param 1: message id. Param 2: microseconds between two, 0 for the default, -1 for never. For this link only.
pub(crate) fn set_message_interval(
    component: &mut Component,
    [id, interval_us]: [f32; 2],
    link: usize,
) -> Result<(), CommandError> {
    check_finite("Interval", &[id, interval_us])?;
    // A PX4 has another word for it.
    let refuse =
        if component.autopilot.rules().unknown_interval_fails { CommandError::failed } else { CommandError::denied };
    let stream = known_stream(id).map_err(|reason| refuse(reason).quietly())?;
    let interval = match integer(interval_us) {
        -1 => None,
        0 => stream.default_interval(&component.settings.rates, component.autopilot.rules()),
        us => {
            let shortest = component.settings.step.div_f64(RATE_PER_STEP_MAX);
            let interval = Duration::from_micros(u64::try_from(us).unwrap_or(1)).min(Duration::from_secs(60));
            if interval < shortest {
                let rate_hz = 1.0 / interval.as_secs_f64();
                return Err(CommandError::denied(format!("Requested rate {rate_hz:.0} Hz is too fast")));
            }
            Some(interval)
        }
    };
    let time = component.autopilot.time();
    component.links().set_interval(link, stream, interval, time);
    Ok(())
}

/// Commands of their own for one message each, older than REQUEST_MESSAGE. Param 1: 1 to be sent it.
pub(crate) fn answer_old_request(
    component: &mut Component,
    p1: f32,
    stream: Stream,
    link: usize,
) -> Result<(), CommandError> {
    if p1 != 1.0 {
        return Err(CommandError::failed("Request: param 1 is not 1"));
    }
    component.send_stream(link, stream);
    Ok(())
}

/// REQUEST_MESSAGE. Param 1: message id; for MESSAGE_INTERVAL param 2 is that of the message that is asked about.
pub(crate) fn request_message(component: &mut Component, [id, p2]: [f32; 2], link: usize) -> Result<(), CommandError> {
    check_finite("Request", &[id])?;
    if integer(id) == i64::from(MESSAGE_INTERVAL) {
        return tell_message_interval(component, p2, link);
    }
    let stream = known_stream(id).map_err(|reason| CommandError::failed(reason).quietly())?;
    if !component.peers().can_carry(link, stream.message_id()) {
        return Err(CommandError::failed("MAVLink 1 does not have this message").quietly());
    }
    component.send_stream(link, stream);
    Ok(())
}

/// GET_MESSAGE_INTERVAL. Param 1: message id. It is told what it is of a message that is not there, too: 0.
pub(crate) fn tell_message_interval(component: &mut Component, id: f32, link: usize) -> Result<(), CommandError> {
    check_finite("Interval", &[id])?;
    let stream = known_stream(id);
    let interval_us = match stream {
        Ok(stream) => component.peers().interval(link, stream).map_or(-1, |interval| interval.as_micros() as i32),
        Err(_) => 0,
    };
    let message_id = u16::try_from(integer(id)).unwrap_or(u16::MAX);
    component.links().send(link, &Message::MESSAGE_INTERVAL(MESSAGE_INTERVAL_DATA { interval_us, message_id }));
    stream.map(|_| ()).map_err(|reason| CommandError::failed(reason).quietly())
}

/// The stream of a message id, or why there is none.
fn known_stream(id: f32) -> Result<Stream, String> {
    let number = integer(id);
    let stream = u32::try_from(number).ok().and_then(Stream::from_message_id);
    stream.ok_or_else(|| format!("Message {number} is not available"))
}
