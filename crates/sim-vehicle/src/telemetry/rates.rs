//! How often a vehicle's messages come unasked.

/// What a link of an autopilot's own simulator is for: each starts with rates of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkUse {
    /// A program that flies the vehicle.
    Companion,
    /// Somebody who looks on and gives orders.
    GroundStation,
}

/// Telemetry rates, Hz; 0 is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TelemetryRates {
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

impl Default for TelemetryRates {
    fn default() -> Self {
        Self {
            heartbeat_hz: 1.0,
            raw_sensors_hz: 1.0,
            sys_status_hz: 1.0,
            system_time_hz: 1.0,
            attitude_hz: 10.0,
            global_position_int_hz: 5.0,
            vfr_hud_hz: 4.0,
            extended_sys_state_hz: 2.0,
            home_position_hz: 0.5,
            local_position_ned_hz: 10.0,
        }
    }
}

impl TelemetryRates {
    /// Nothing unasked.
    pub const OFF: Self = Self {
        heartbeat_hz: 0.0,
        raw_sensors_hz: 0.0,
        sys_status_hz: 0.0,
        system_time_hz: 0.0,
        attitude_hz: 0.0,
        global_position_int_hz: 0.0,
        vfr_hud_hz: 0.0,
        extended_sys_state_hz: 0.0,
        home_position_hz: 0.0,
        local_position_ned_hz: 0.0,
    };

    /// Every rate with its name in settings.
    pub(crate) fn named(&self) -> [(&'static str, f64); 10] {
        [
            ("heartbeat_hz", self.heartbeat_hz),
            ("raw_sensors_hz", self.raw_sensors_hz),
            ("sys_status_hz", self.sys_status_hz),
            ("system_time_hz", self.system_time_hz),
            ("attitude_hz", self.attitude_hz),
            ("global_position_int_hz", self.global_position_int_hz),
            ("vfr_hud_hz", self.vfr_hud_hz),
            ("extended_sys_state_hz", self.extended_sys_state_hz),
            ("home_position_hz", self.home_position_hz),
            ("local_position_ned_hz", self.local_position_ned_hz),
        ]
    }
}
