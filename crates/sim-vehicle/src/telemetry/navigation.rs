//! Attitude and place in the forms that some clients ask for, and what the vehicle steers for.

use super::Instruments;
use crate::mode::Mode;
use flight_model::State;
use mavlink_bridge::dialect::{
    ALTITUDE_DATA, ATTITUDE_QUATERNION_DATA, CURRENT_MODE_DATA, MavEstimatorType, MavFrame, Message,
    NAV_CONTROLLER_OUTPUT_DATA, ODOMETRY_DATA, POSITION_TARGET_GLOBAL_INT_DATA, POSITION_TARGET_LOCAL_NED_DATA,
    PositionTargetTypemask as Mask,
};
use mavlink_bridge::{LatLonE7, boot_ms};

impl Instruments<'_> {
    /// Roll, pitch and yaw of ATTITUDE, rad.
    pub(super) fn attitude_rad(&self) -> [f64; 3] {
        let air = self.flight.in_air();
        [self.flight.roll_rad(), libm::atan2(air.climb_mps, air.speed_mps), air.course_rad]
    }

    /// The rotation from north-east-down to the body, w first.
    pub(super) fn quaternion(&self) -> [f32; 4] {
        quaternion(self.attitude_rad())
    }

    /// ATTITUDE_QUATERNION (<https://mavlink.io/en/messages/common.html#ATTITUDE_QUATERNION>).
    pub(super) fn attitude_quaternion(&self) -> Message {
        let [q1, q2, q3, q4] = self.quaternion();
        Message::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms: boot_ms(self.time),
            q1,
            q2,
            q3,
            q4,
            yawspeed: self.flight.turn_rate_radps() as f32,
            ..ATTITUDE_QUATERNION_DATA::DEFAULT
        })
    }

    /// ALTITUDE (<https://mavlink.io/en/messages/common.html#ALTITUDE>): the ground is level with home.
    pub(super) fn altitude(&self) -> Message {
        let altitude_m = self.flight.estimate().altitude_m;
        let amsl_m = self.frame.origin().altitude_amsl_m;
        let relative_m = (altitude_m - self.flight.home().altitude_m) as f32;
        Message::ALTITUDE(ALTITUDE_DATA {
            time_usec: u64::try_from(self.time.as_micros()).unwrap_or(u64::MAX),
            altitude_monotonic: (amsl_m + altitude_m) as f32,
            altitude_amsl: (amsl_m + altitude_m) as f32,
            altitude_local: altitude_m as f32,
            altitude_relative: relative_m,
            altitude_terrain: (amsl_m + self.flight.home().altitude_m) as f32,
            bottom_clearance: relative_m,
        })
    }

    /// CURRENT_MODE (<https://mavlink.io/en/messages/common.html#CURRENT_MODE>): a failsafe stands between the mode
    /// that is flown and the one that was meant.
    pub(super) fn current_mode(&self) -> Message {
        let mode = self.flight.mode();
        let comes_back = self.autopilot.session.failsafes.streams.ends_with_setpoints();
        let meant = if comes_back { Mode::Offboard } else { mode };
        Message::CURRENT_MODE(CURRENT_MODE_DATA {
            custom_mode: (self.rules.custom_mode)(mode),
            intended_custom_mode: (self.rules.custom_mode)(meant),
            standard_mode: self.rules.standard_mode(mode),
        })
    }

    /// ODOMETRY (<https://mavlink.io/en/messages/common.html#ODOMETRY>): the place of LOCAL_POSITION_NED, the velocity
    /// as the body has it, no covariances.
    pub(super) fn odometry(&self) -> Message {
        let state = self.flight.estimate();
        let [vx, vy, vz] = self.to_body(&state);
        let mut odometry = ODOMETRY_DATA {
            time_usec: u64::try_from(self.time.as_micros()).unwrap_or(u64::MAX),
            x: state.x_m as f32,
            y: state.y_m as f32,
            z: (0.0 - state.altitude_m) as f32,
            q: self.quaternion(),
            vx,
            vy,
            vz,
            yawspeed: self.flight.turn_rate_radps() as f32,
            frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
            child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
            estimator_type: MavEstimatorType::MAV_ESTIMATOR_TYPE_AUTOPILOT,
            ..ODOMETRY_DATA::DEFAULT
        };
        // Not known.
        odometry.pose_covariance[0] = f32::NAN;
        odometry.velocity_covariance[0] = f32::NAN;
        Message::ODOMETRY(odometry)
    }

    /// A velocity over ground as the body has it: forward, right, down, m/s.
    fn to_body(&self, state: &State) -> [f32; 3] {
        let velocity_mps = state.velocity_mps();
        let (north, east) = (velocity_mps.x, velocity_mps.y);
        let down = -state.climb_mps;
        let [(sr, cr), (sp, cp), (sy, cy)] = self.attitude_rad().map(libm::sincos);
        let (ahead, right) = (cy * north + sy * east, cy * east - sy * north);
        let (forward, below) = (cp * ahead - sp * down, sp * ahead + cp * down);
        [forward, cr * right + sr * below, cr * below - sr * right].map(|speed_mps| speed_mps as f32)
    }

    /// NAV_CONTROLLER_OUTPUT (<https://mavlink.io/en/messages/common.html#NAV_CONTROLLER_OUTPUT>): no line is flown
    /// between two waypoints, so there is no distance from it.
    pub(super) fn nav_controller_output(&self) -> Message {
        let (aim, state) = (self.flight.aim(), self.flight.estimate());
        let [roll_rad, pitch_rad, _] = self.attitude_rad();
        let degrees = |angle_rad: f64| angle_rad.to_degrees().round() as i16;
        let (bearing_rad, distance_m) = match aim.place {
            Some(place) => {
                let way = place - state.position_m();
                (libm::atan2(way.y, way.x), way.norm())
            }
            None => (aim.course_rad, 0.0),
        };
        Message::NAV_CONTROLLER_OUTPUT(NAV_CONTROLLER_OUTPUT_DATA {
            nav_roll: roll_rad.to_degrees() as f32,
            nav_pitch: pitch_rad.to_degrees() as f32,
            nav_bearing: degrees(flight_model::wrap_pi(aim.course_rad)),
            target_bearing: degrees(bearing_rad),
            wp_dist: distance_m.round() as u16,
            alt_error: (aim.altitude_m - state.altitude_m) as f32,
            aspd_error: (aim.airspeed_mps - self.flight.equivalent_airspeed_mps()) as f32,
            xtrack_error: 0.0,
        })
    }

    /// POSITION_TARGET_GLOBAL_INT (<https://mavlink.io/en/messages/common.html#POSITION_TARGET_GLOBAL_INT>): the place
    /// that is flown to or circled, above sea level; the present one while there is none.
    pub(super) fn position_target_global_int(&self) -> Message {
        let (aim, state) = (self.flight.aim(), self.flight.estimate());
        let target = aim.place.unwrap_or(state.position_m());
        let place = self.frame.to_geodetic(target.x, target.y, aim.altitude_m);
        let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&place);
        Message::POSITION_TARGET_GLOBAL_INT(POSITION_TARGET_GLOBAL_INT_DATA {
            time_boot_ms: boot_ms(self.time),
            lat_int: latitude_e7,
            lon_int: longitude_e7,
            alt: place.altitude_amsl_m as f32,
            coordinate_frame: MavFrame::MAV_FRAME_GLOBAL,
            type_mask: Mask::from_bits_retain(PLACE_ALONE),
            ..POSITION_TARGET_GLOBAL_INT_DATA::DEFAULT
        })
    }

    /// POSITION_TARGET_LOCAL_NED (<https://mavlink.io/en/messages/common.html#POSITION_TARGET_LOCAL_NED>): the velocity
    /// that is steered for, and the altitude.
    pub(super) fn position_target_local_ned(&self) -> Message {
        let aim = self.flight.aim();
        let (sin, cos) = libm::sincos(aim.course_rad);
        Message::POSITION_TARGET_LOCAL_NED(POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: boot_ms(self.time),
            z: (0.0 - aim.altitude_m) as f32,
            vx: (aim.airspeed_mps * cos) as f32,
            vy: (aim.airspeed_mps * sin) as f32,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            type_mask: Mask::from_bits_retain(VELOCITY_AND_ALTITUDE),
            ..POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        })
    }
}

/// The rotation of roll, pitch and yaw, rad, w first.
pub(super) fn quaternion(attitude_rad: [f64; 3]) -> [f32; 4] {
    let [(sr, cr), (sp, cp), (sy, cy)] = attitude_rad.map(|angle_rad| libm::sincos(0.5 * angle_rad));
    [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
        .map(|part| part as f32)
}

/// All is left out but the place, in the bits that ArduPlane sets.
const PLACE_ALONE: u16 = 0xFDF8;
/// All is left out but vx, vy and z.
const VELOCITY_AND_ALTITUDE: u16 = 0x0DE3;
