//! ATTITUDE and VFR_HUD.

// Clients still request messages that the dialect marks as superseded.
#![allow(deprecated)]

use super::heading_cdeg;
use crate::boot_ms;
use crate::dialect::{ATTITUDE_DATA, Message, VFR_HUD_DATA};
use flight_model::{State, wrap_pi};
use std::time::Duration;

/// ATTITUDE with the nose along the way through the air, of which `air` is the state: airspeed and heading
/// (<https://mavlink.io/en/messages/common.html#ATTITUDE>).
pub fn attitude(time_boot: Duration, air: &State, roll_rad: f64, yaw_rate_radps: f64) -> Message {
    Message::ATTITUDE(ATTITUDE_DATA {
        time_boot_ms: boot_ms(time_boot),
        roll: roll_rad as f32,
        pitch: libm::atan2(air.climb_mps, air.speed_mps) as f32,
        yaw: wrap_pi(air.course_rad) as f32,
        rollspeed: 0.0,
        pitchspeed: 0.0,
        yawspeed: yaw_rate_radps as f32,
    })
}

/// VFR_HUD (<https://mavlink.io/en/messages/common.html#VFR_HUD>): speed over ground, airspeed as it is measured, where
/// the nose points.
pub fn vfr_hud(
    state: &State,
    airspeed_mps: f64,
    heading_rad: f64,
    altitude_amsl_m: f64,
    throttle_percent: u16,
) -> Message {
    Message::VFR_HUD(VFR_HUD_DATA {
        airspeed: airspeed_mps as f32,
        groundspeed: state.speed_mps as f32,
        alt: altitude_amsl_m as f32,
        climb: state.climb_mps as f32,
        heading: (heading_cdeg(heading_rad) / 100) as i16,
        throttle: throttle_percent,
    })
}
