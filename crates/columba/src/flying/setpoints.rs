//! A setpoint in the dialect that the scenario asks for in real time.

use crate::config::SetpointDialect;
use flight_model::Setpoint;
use mavlink_bridge::dialect::{Message, Target};
use mavlink_bridge::{guided_commands, local_ned_setpoint};
use std::time::Duration;

/// Bank is left to the autopilot's own limit: ArduPlane takes the lateral acceleration's limit in m/s2 with each
/// heading.
const LATERAL_ACCELERATION_MPS2: f64 = 50.0;

/// The messages that ask a vehicle (its index, and its target on the wire) for a setpoint at a flight time.
pub fn setpoint_messages(
    dialect: SetpointDialect,
    vehicle: usize,
    target: Target,
    setpoint: &Setpoint,
    now: Duration,
) -> Vec<Message> {
    match dialect {
        SetpointDialect::LocalNed => vec![local_ned_setpoint(now, target, setpoint)],
        SetpointDialect::Arduplane => {
            match guided_commands(target, setpoint, setpoint.altitude_m, LATERAL_ACCELERATION_MPS2) {
                Ok(commands) => commands.into(),
                Err(error) => {
                    tracing::warn!(vehicle = vehicle + 1, %error, "setpoint not sent");
                    Vec::new()
                }
            }
        }
    }
}
