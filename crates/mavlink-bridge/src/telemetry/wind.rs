//! WIND_COV.

// Clients still request messages that the dialect marks as superseded.
#![allow(deprecated)]

use super::down;
use crate::dialect::{Message, WIND_COV_DATA};
use flight_model::Wind;
use std::time::Duration;

/// WIND_COV (<https://mavlink.io/en/messages/common.html#WIND_COV>): the velocity of the air, north-east-down, its
/// spread in m/s, and the altitude in m at which it was measured.
pub fn wind_cov(time_boot: Duration, wind: &Wind, deviation_mps: f64, altitude_amsl_m: f64) -> Message {
    Message::WIND_COV(WIND_COV_DATA {
        time_usec: u64::try_from(time_boot.as_micros()).unwrap_or(u64::MAX),
        wind_x: wind.north_mps as f32,
        wind_y: wind.east_mps as f32,
        wind_z: down(wind.up_mps),
        var_horiz: deviation_mps as f32,
        var_vert: deviation_mps as f32,
        wind_alt: altitude_amsl_m as f32,
        horiz_accuracy: deviation_mps as f32,
        vert_accuracy: deviation_mps as f32,
    })
}
