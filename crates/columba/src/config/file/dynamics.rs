//! `[dynamics]`: the constants of Eq. 1 and 3.

use crate::config::airframe::or_infinite;
use flight_model::{Dynamics, Limits, Response, TimeConstants};
use serde::{Deserialize, Serialize};

/// Eq. 1 and 3.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct DynamicsTable {
    /// tau_v of Eq. 1, s.
    pub speed_time_constant_s: f64,
    /// tau_chi of Eq. 1, s.
    pub course_time_constant_s: f64,
    /// tau_a of Eq. 1, s.
    pub altitude_time_constant_a_s: f64,
    /// tau_b of Eq. 1, s.
    pub altitude_time_constant_b_s: f64,
    /// Least speed, m/s.
    pub speed_min_mps: f64,
    /// Greatest speed, m/s.
    pub speed_max_mps: f64,
    /// Fastest descent, m/s, negative.
    pub climb_min_mps: f64,
    /// Fastest climb, m/s.
    pub climb_max_mps: f64,
    /// n_max: the greatest lateral acceleration, in g.
    pub lateral_overload_max: f64,
    /// g, m/s2.
    pub gravity_mps2: f64,
    /// Ground speed that the speed loop settles on, as a share of its setpoint.
    pub speed_gain: f64,
    /// A new speed setpoint acts after this, s.
    pub speed_dead_time_s: f64,
    /// A new course setpoint acts after this, s.
    pub course_dead_time_s: f64,
    /// A new altitude setpoint acts after this, s.
    pub altitude_dead_time_s: f64,
    /// Speed at which tau_chi is as above; it grows in proportion to speed. 0: it is the same at every speed.
    pub course_reference_speed_mps: f64,
    /// Fastest change of speed, m/s2. 0: no limit.
    pub acceleration_max_mps2: f64,
    /// Turns are Eq. 1 up to this course error, degrees: the controller asks for no more at once.
    pub course_step_max_deg: f64,
    /// Lateral acceleration in a steady turn, as a share of that of a coordinated turn.
    pub turn_share: f64,
    /// Step of the integration, s, at which flights are judged too.
    pub integration_step_s: f64,
}

impl Default for DynamicsTable {
    fn default() -> Self {
        let Dynamics { time_constants, limits, response } = Dynamics::default();
        Self {
            speed_time_constant_s: time_constants.speed_s,
            course_time_constant_s: time_constants.course_s,
            altitude_time_constant_a_s: time_constants.altitude_a_s,
            altitude_time_constant_b_s: time_constants.altitude_b_s,
            speed_min_mps: limits.speed_min_mps,
            speed_max_mps: limits.speed_max_mps,
            climb_min_mps: limits.climb_min_mps,
            climb_max_mps: limits.climb_max_mps,
            lateral_overload_max: limits.lateral_overload_max,
            gravity_mps2: limits.gravity_mps2,
            speed_gain: response.speed_gain,
            speed_dead_time_s: response.speed_dead_time_s,
            course_dead_time_s: response.course_dead_time_s,
            altitude_dead_time_s: response.altitude_dead_time_s,
            course_reference_speed_mps: response.course_reference_speed_mps.unwrap_or(0.0),
            acceleration_max_mps2: 0.0,
            course_step_max_deg: response.course_step_max_rad.to_degrees(),
            turn_share: response.turn_share,
            integration_step_s: 0.01,
        }
    }
}

impl DynamicsTable {
    /// As the flight model has it.
    pub fn dynamics(&self) -> Dynamics {
        Dynamics {
            time_constants: TimeConstants {
                speed_s: self.speed_time_constant_s,
                course_s: self.course_time_constant_s,
                altitude_a_s: self.altitude_time_constant_a_s,
                altitude_b_s: self.altitude_time_constant_b_s,
            },
            limits: Limits {
                speed_min_mps: self.speed_min_mps,
                speed_max_mps: self.speed_max_mps,
                climb_min_mps: self.climb_min_mps,
                climb_max_mps: self.climb_max_mps,
                lateral_overload_max: self.lateral_overload_max,
                gravity_mps2: self.gravity_mps2,
            },
            response: Response {
                speed_gain: self.speed_gain,
                speed_dead_time_s: self.speed_dead_time_s,
                course_dead_time_s: self.course_dead_time_s,
                altitude_dead_time_s: self.altitude_dead_time_s,
                course_reference_speed_mps: Some(self.course_reference_speed_mps).filter(|speed_mps| *speed_mps != 0.0),
                acceleration_max_mps2: or_infinite(self.acceleration_max_mps2),
                course_step_max_rad: self.course_step_max_deg.to_radians(),
                turn_share: self.turn_share,
            },
        }
    }
}
