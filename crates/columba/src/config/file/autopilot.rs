//! `[autopilot]`: what a simulated vehicle does beside flying.

use flight_model::RangeError;
use serde::{Deserialize, Serialize};
use sim_vehicle::{TelemetryRates, VehicleSettings};
use std::time::Duration;

/// What a simulated vehicle does beside flying.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct AutopilotTable {
    /// Without a setpoint for this long a vehicle in GUIDED loiters; 0: never.
    pub setpoint_timeout_s: f64,
    /// Radius of the circle, m.
    pub loiter_radius_m: f64,
    /// Airspeed of LOITER, RTL and AUTO, m/s; the present one where absent.
    pub cruise_speed_mps: Option<f64>,
    /// Whether vehicles start armed; else they wait at their start until armed.
    pub armed: bool,
    /// Whether vehicles start on the ground, disarmed, instead of in the air.
    pub on_ground: bool,
    /// Which autopilot `columba vehicles` passes for.
    pub personality: sim_vehicle::Personality,
    /// HEARTBEAT.
    pub heartbeat_hz: f64,
    /// RAW_IMU and SCALED_PRESSURE.
    pub raw_sensors_hz: f64,
    /// SYS_STATUS, GPS_RAW_INT and MISSION_CURRENT.
    pub sys_status_hz: f64,
    /// SYSTEM_TIME, WIND, BATTERY_STATUS and EKF_STATUS_REPORT.
    pub system_time_hz: f64,
    /// ATTITUDE.
    pub attitude_hz: f64,
    /// GLOBAL_POSITION_INT.
    pub global_position_int_hz: f64,
    /// VFR_HUD.
    pub vfr_hud_hz: f64,
    /// EXTENDED_SYS_STATE.
    pub extended_sys_state_hz: f64,
    /// HOME_POSITION.
    pub home_position_hz: f64,
    /// LOCAL_POSITION_NED.
    pub local_position_ned_hz: f64,
}

impl Default for AutopilotTable {
    fn default() -> Self {
        let VehicleSettings { rates, setpoint_timeout_s, loiter_radius_m, .. } = VehicleSettings::default();
        Self {
            setpoint_timeout_s,
            loiter_radius_m,
            cruise_speed_mps: None,
            armed: true,
            on_ground: false,
            personality: sim_vehicle::Personality::default(),
            heartbeat_hz: rates.heartbeat_hz,
            raw_sensors_hz: rates.raw_sensors_hz,
            sys_status_hz: rates.sys_status_hz,
            system_time_hz: rates.system_time_hz,
            attitude_hz: rates.attitude_hz,
            global_position_int_hz: rates.global_position_int_hz,
            vfr_hud_hz: rates.vfr_hud_hz,
            extended_sys_state_hz: rates.extended_sys_state_hz,
            home_position_hz: rates.home_position_hz,
            local_position_ned_hz: rates.local_position_ned_hz,
        }
    }
}

impl AutopilotTable {
    /// The rates as a vehicle has them.
    pub fn rates(&self) -> TelemetryRates {
        TelemetryRates {
            heartbeat_hz: self.heartbeat_hz,
            raw_sensors_hz: self.raw_sensors_hz,
            sys_status_hz: self.sys_status_hz,
            system_time_hz: self.system_time_hz,
            attitude_hz: self.attitude_hz,
            global_position_int_hz: self.global_position_int_hz,
            vfr_hud_hz: self.vfr_hud_hz,
            extended_sys_state_hz: self.extended_sys_state_hz,
            home_position_hz: self.home_position_hz,
            local_position_ned_hz: self.local_position_ned_hz,
        }
    }

    /// Every setting that is out of the range that a vehicle gives it, with an integration step in s.
    pub fn check(&self, step_s: f64) -> Vec<RangeError> {
        let settings = VehicleSettings {
            rates: self.rates(),
            setpoint_timeout_s: self.setpoint_timeout_s,
            loiter_radius_m: self.loiter_radius_m,
            // A step that is at fault itself has been told already.
            step: Duration::try_from_secs_f64(step_s).unwrap_or(VehicleSettings::default().step),
            ..VehicleSettings::default()
        };
        settings.check().into_iter().filter(|error| error.name != "step_s").collect()
    }
}
