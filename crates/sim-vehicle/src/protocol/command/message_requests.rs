//! Commands about messages: how often one is sent, and one now.

use crate::autopilot::input::{check_finite, integer};
use crate::error::{CommandError, CommandResult, Severity};
use crate::firmware::offers::px4_has;
use crate::firmware::rules::CommandSet;
use crate::firmware::rules::Offer;
use crate::settings::RATE_PER_STEP_MAX;
use crate::telemetry::announce::Component;
use crate::telemetry::streams::Stream;
use mavlink_bridge::dialect::{MESSAGE_INTERVAL_DATA, Message};
use std::time::Duration;

const HEARTBEAT: u32 = 0;
const MESSAGE_INTERVAL: u32 = 244;
/// The slowest rate.
const INTERVAL_MAX: Duration = Duration::from_secs(60);

/// How often a message is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rate {
    Default,
    Never,
    Every(Duration),
}

/// SET_MESSAGE_INTERVAL. Param 1: message id. Param 2: microseconds between two, 0 for the default, -1 for never. For
/// this link only. ArduPlane: param 3 must be 0, and a rate that the loop does not reach is DENIED. PX4: params 3, 4
/// and 7 must be 0, HEARTBEAT's rate is fixed, and any other goes.
pub(crate) fn set_message_interval(
    component: &mut Component,
    params: [f32; 4],
    z: f32,
    link: usize,
) -> Result<(), CommandError> {
    let is_px4 = commands(component) == CommandSet::Px4;
    let (id, rate) = if is_px4 { px4_rate(params, z)? } else { arduplane_rate(component, params)? };
    // A PX4 has another word for what is not there.
    let fails = component.autopilot.rules().unknown_interval_fails;
    let refuse = if fails { CommandError::failed } else { CommandError::denied };
    match commands(component).offer(id) {
        Offer::None => Err(refuse(format!("Message {id} is not available")).quietly()),
        Offer::Silent(_) | Offer::RateAlone => {
            let interval = if let Rate::Every(interval) = rate { Some(interval) } else { None };
            component.links().note_interval(link, id, interval);
            Ok(())
        }
        Offer::Sent(stream) => {
            let interval = match rate {
                Rate::Default => component.peers().default_interval(link, stream),
                Rate::Never => None,
                Rate::Every(interval) => Some(interval),
            };
            let time = component.autopilot.time();
            component.links().set_interval(link, stream, interval, time);
            Ok(())
        }
    }
}

fn arduplane_rate(component: &Component, [id, interval_us, p3, _]: [f32; 4]) -> Result<(u32, Rate), CommandError> {
    check_finite("Interval", &[id, interval_us, p3])?;
    if p3 != 0.0 && commands(component) == CommandSet::ArduPlane {
        return Err(CommandError::denied("Interval: param 3 must be 0"));
    }
    let rate = match integer(interval_us) {
        -1 => Rate::Never,
        0 => Rate::Default,
        ..0 => return Err(CommandError::denied("Interval: below -1")),
        us => {
            let shortest = component.settings.step.div_f64(RATE_PER_STEP_MAX);
            // It is kept in whole milliseconds, at least one.
            let interval = Duration::from_millis(u64::try_from(us / 1000).unwrap_or(1).max(1)).min(INTERVAL_MAX);
            if interval < shortest {
                let rate_hz = 1.0 / interval.as_secs_f64();
                return Err(CommandError::denied(format!("Requested rate {rate_hz:.0} Hz is too fast")));
            }
            Rate::Every(interval)
        }
    };
    Ok((message_id(id), rate))
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
    component.asked_for.push((link, stream));
    Ok(())
}

/// REQUEST_MESSAGE. Param 1: message id; for MESSAGE_INTERVAL param 2 is that of the message that is asked about.
pub(crate) fn request_message(component: &mut Component, [id, p2]: [f32; 2], link: usize) -> Result<(), CommandError> {
    check_finite("Request", &[id])?;
    let personality = commands(component);
    // A PX4 has 16 bits for it.
    let id = if personality == CommandSet::Px4 { message_id(id.round()) & 0xFFFF } else { message_id(id) };
    if id == MESSAGE_INTERVAL {
        return tell_message_interval(component, p2, link);
    }
    let refuse = if personality == CommandSet::Px4 { CommandError::denied } else { CommandError::failed };
    let stream = match personality.offer(id) {
        Offer::Sent(stream) => stream,
        Offer::Silent(what) => {
            component.say(Severity::Info, &format!("There is no {what}"));
            return Ok(());
        }
        Offer::RateAlone | Offer::None => {
            return Err(refuse(format!("Message {id} is not available")).quietly());
        }
    };
    if !component.peers().can_carry(link, stream.message_id()) {
        return Err(refuse("MAVLink 1 does not have this message".to_owned()).quietly());
    }
    if personality == CommandSet::Px4 && !px4_has(&component.autopilot, stream) {
        return Err(CommandError::denied(format!("Message {id} has no content now")).quietly());
    }
    // An ArduPlane acknowledges first, and clients wait for the message after that.
    if personality == CommandSet::Px4 {
        component.send_stream(link, stream);
    } else {
        component.asked_for.push((link, stream));
    }
    Ok(())
}

/// GET_MESSAGE_INTERVAL. Param 1: message id. Of a message that is not there an ArduPlane tells 0 and refuses, a PX4
/// tells that it never comes.
pub(crate) fn tell_message_interval(component: &mut Component, id: f32, link: usize) -> Result<(), CommandError> {
    let is_px4 = commands(component) == CommandSet::Px4;
    check_finite("Interval", &[id])?;
    let id = if is_px4 { message_id(id + 0.5) } else { message_id(id) };
    let interval = match commands(component).offer(id) {
        Offer::Sent(stream) => component.peers().interval(link, stream),
        Offer::Silent(_) | Offer::RateAlone => component.peers().noted_interval(link, id),
        Offer::None => None,
    };
    let is_known = is_px4 || commands(component).offer(id) != Offer::None;
    let interval_us = match interval {
        Some(interval) => i32::try_from(interval.as_micros()).unwrap_or(i32::MAX),
        None if is_known => -1,
        None => 0,
    };
    let message_id = u16::try_from(id).unwrap_or(u16::MAX);
    component.links().send(link, &Message::MESSAGE_INTERVAL(MESSAGE_INTERVAL_DATA { interval_us, message_id }));
    if is_known { Ok(()) } else { Err(CommandError::failed(format!("Message {id} is not available")).quietly()) }
}

fn commands(component: &Component) -> CommandSet {
    component.autopilot.rules().commands
}

/// A PX4's own checks: which message, and how often.
fn px4_rate([id, interval_us, p3, p4]: [f32; 4], p7: f32) -> Result<(u32, Rate), CommandError> {
    let failed = |reason: &str| CommandError::new(CommandResult::Failed, reason);
    let id = message_id(id + 0.5);
    if id == HEARTBEAT {
        return Err(failed("Interval: HEARTBEAT's is fixed"));
    }
    for (number, param) in [(3, p3), (4, p4), (7, p7)] {
        if param.is_finite() && (param + 0.5) as i64 != 0 {
            return Err(failed(&format!("Interval: param {number} must be 0")));
        }
    }
    let rate = match interval_us {
        us if us < -0.00001 => Rate::Never,
        us if us.is_infinite() => Rate::Never,
        us if us > 0.00001 => {
            let interval = Duration::try_from_secs_f64(f64::from(us) * 1e-6).unwrap_or(INTERVAL_MAX);
            Rate::Every(interval.max(Duration::from_micros(1)))
        }
        _ => Rate::Default,
    };
    Ok((id, rate))
}

/// A message id as a param has it, with what follows the point cut off. What is below 0 or too large is no message.
fn message_id(param: f32) -> u32 {
    u32::try_from(integer(param)).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_px4_takes_any_rate_but_those_that_it_has_no_room_for() {
        let rate = |params, z| px4_rate(params, z).map_err(|refusal| refusal.result);
        let failed = Err(CommandResult::Failed);
        assert_eq!(rate([105.0, 5_000.0, 0.0, 0.0], 0.0), Ok((105, Rate::Every(Duration::from_millis(5)))));
        assert_eq!(rate([104.6, 1.0, f32::NAN, -0.7], 0.4), Ok((105, Rate::Every(Duration::from_micros(1)))));
        assert_eq!(rate([30.0, -2.5, 0.0, 0.0], 0.0), Ok((30, Rate::Never)));
        assert_eq!(rate([30.0, f32::NAN, 0.0, 0.0], f32::INFINITY), Ok((30, Rate::Default)));
        for params in [[0.4, 1e6, 0.0, 0.0], [30.0, 1e6, 1.0, 0.0], [30.0, 1e6, 0.0, -2.0]] {
            assert_eq!(rate(params, 0.0), failed, "{params:?}");
        }
        assert_eq!(rate([30.0, 1e6, 0.0, 0.0], 1.0), failed);
    }
}
