//! Commands that all kinds share.

use crate::Target;
use crate::dialect::{COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, MavFrame, Message};

/// MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, as a command's param has it.
const CUSTOM_MODE: f32 = 1.0;

/// COMMAND_LONG with its seven params (<https://mavlink.io/en/messages/common.html#COMMAND_LONG>).
pub fn command_long(target: Target, command: MavCmd, params: [f32; 7]) -> Message {
    let [param1, param2, param3, param4, param5, param6, param7] = params;
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7,
        command,
        target_system: target.system_id,
        target_component: target.component_id,
        confirmation: 0,
    })
}

/// COMMAND_INT with params 1 to 4, a place in 1e-7 degrees, and an altitude in the frame
/// (<https://mavlink.io/en/messages/common.html#COMMAND_INT>).
pub fn command_int(
    target: Target,
    command: MavCmd,
    frame: MavFrame,
    [param1, param2, param3, param4]: [f32; 4],
    (x, y, z): (i32, i32, f32),
) -> Message {
    Message::COMMAND_INT(COMMAND_INT_DATA {
        param1,
        param2,
        param3,
        param4,
        x,
        y,
        z,
        command,
        target_system: target.system_id,
        target_component: target.component_id,
        frame,
        ..COMMAND_INT_DATA::DEFAULT
    })
}

/// MAV_CMD_DO_SET_MODE of ArduPilot: one number.
pub(super) fn set_mode(target: Target, custom_mode: u32) -> Message {
    let params = [CUSTOM_MODE, custom_mode as f32, 0.0, 0.0, 0.0, 0.0, 0.0];
    command_long(target, MavCmd::MAV_CMD_DO_SET_MODE, params)
}

/// MAV_CMD_DO_SET_MODE of PX4: main and sub mode.
pub(super) fn set_px4_mode(target: Target, custom_mode: u32) -> Message {
    let (main, sub) = (custom_mode >> 16 & 0xFF, custom_mode >> 24);
    let params = [CUSTOM_MODE, main as f32, sub as f32, 0.0, 0.0, 0.0, 0.0];
    command_long(target, MavCmd::MAV_CMD_DO_SET_MODE, params)
}

/// MAV_CMD_DO_CHANGE_ALTITUDE, above mean sea level (param 2: MAV_FRAME_GLOBAL).
pub(super) fn change_altitude(target: Target, altitude_amsl_m: f32) -> Message {
    let params = [altitude_amsl_m, MavFrame::MAV_FRAME_GLOBAL as u32 as f32, 0.0, 0.0, 0.0, 0.0, 0.0];
    command_long(target, MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE, params)
}

/// MAV_CMD_COMPONENT_ARM_DISARM: arms, with all checks.
pub fn arm(target: Target) -> Message {
    command_long(target, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
}

/// MAV_CMD_SET_MESSAGE_INTERVAL.
pub fn set_message_interval(target: Target, message_id: u32, rate_hz: f64) -> Message {
    let interval_us = (1e6 / rate_hz).round() as f32;
    let params = [message_id as f32, interval_us, 0.0, 0.0, 0.0, 0.0, 0.0];
    command_long(target, MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, params)
}

/// MAV_CMD_REQUEST_MESSAGE.
pub fn request_message(target: Target, message_id: u32) -> Message {
    command_long(target, MavCmd::MAV_CMD_REQUEST_MESSAGE, [message_id as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
}
