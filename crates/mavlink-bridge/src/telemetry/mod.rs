//! A vehicle's state as telemetry messages, and back; a file for each kind of message.

mod attitude;
mod autopilot_version;
mod global_position;
mod heartbeat;
mod local_position;
mod system_time;
mod wind;

pub use attitude::{attitude, vfr_hud};
pub use autopilot_version::{autopilot_version, extended_sys_state, protocol_version};
pub use global_position::{global_position_int, gps_global_origin, gps_raw_int};
pub use heartbeat::{ground_heartbeat, heartbeat, is_autopilot};
pub use local_position::{local_position_ned, state_from_local_position, wire_round};
pub(crate) use local_position::{speed_and_course, wire_velocity};
pub use system_time::{boot_ms, system_time};
pub use wind::wind_cov;

use std::f64::consts::TAU;

/// Up in m or m/s as down on the wire; never -0.
pub(crate) fn down(up: f64) -> f32 {
    (0.0 - up) as f32
}

/// Down on the wire as up in m or m/s; never -0.
pub(crate) fn up(down: f32) -> f64 {
    0.0 - f64::from(down)
}

/// Heading in centidegrees, 0 to 35999.
fn heading_cdeg(course_rad: f64) -> u16 {
    let turn = course_rad / TAU;
    let cdeg = ((turn - turn.floor()) * 36_000.0).round() as u16;
    if cdeg >= 36_000 { 0 } else { cdeg }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::wrap_pi;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_heading_is_a_compass_heading(course in -1e3..1e3f64) {
            let heading = heading_cdeg(course);
            prop_assert!(heading < 36_000);
            let error = wrap_pi(f64::from(heading) / 100.0 * std::f64::consts::PI / 180.0 - course);
            prop_assert!(error.abs() < 1e-4);
        }
    }
}
