//! What the vehicle says of itself.

use crate::fence::FenceReport;
use crate::flight::Flight;
use crate::mission::{Mission, Progress};
use crate::streams::Stream;
use crate::{Mode, Personality};
use flight_model::LocalFrame;
use mavlink_bridge::dialect::{
    BATTERY_STATUS_DATA, FENCE_STATUS_DATA, HOME_POSITION_DATA, MISSION_CURRENT_DATA, MavBatteryFault, MavLandedState,
    MavProtocolCapability, MavState, MavSysStatusSensor, MavSysStatusSensorExtended, MavType, Message, MissionState,
    SYS_STATUS_DATA,
};
use mavlink_bridge::{local_position_ned, telemetry};
use std::time::Duration;

/// Everything that the messages are made of, at one moment.
pub(crate) struct Instruments<'a> {
    pub time: Duration,
    pub system_id: u8,
    pub personality: Personality,
    pub flight: &'a Flight,
    pub mission: &'a Mission,
    pub progress: &'a Progress,
    pub frame: &'a LocalFrame,
    pub failsafe: bool,
    /// Whether it is armed, or nothing stands against it.
    pub is_armable: bool,
    pub fence: FenceReport,
    pub clock_epoch_us: u64,
}

impl Instruments<'_> {
    /// Whether there is anything to say when a stream is due; asked for, it is said anyhow.
    pub fn has(&self, stream: Stream) -> bool {
        stream != Stream::FenceStatus || self.fence.is_enabled
    }

    pub fn message(&self, stream: Stream) -> Message {
        let (time, state) = (self.time, self.flight.state());
        let origin = self.frame.origin();
        match stream {
            Stream::Heartbeat => telemetry::heartbeat(
                MavType::MAV_TYPE_FIXED_WING,
                self.personality.autopilot(),
                self.personality.base_mode(self.flight.mode(), self.flight.is_armed()),
                self.personality.custom_mode(self.flight.mode()),
                self.status(),
            ),
            Stream::SysStatus => self.sys_status(),
            Stream::SystemTime => {
                telemetry::system_time(time, Duration::from_micros(self.clock_epoch_us).saturating_add(time))
            }
            Stream::Attitude => {
                // A coordinated turn: the lift's horizontal part is the centripetal force.
                let yaw_rate_radps = self.flight.course_rate_radps();
                let gravity_mps2 = self.flight.limits().gravity_mps2;
                let roll_rad = libm::atan(state.speed_mps * yaw_rate_radps / gravity_mps2);
                telemetry::attitude(time, state, roll_rad, yaw_rate_radps)
            }
            Stream::LocalPositionNed => local_position_ned(time, state),
            Stream::GlobalPositionInt => {
                telemetry::global_position_int(time, state, self.frame, self.flight.home().altitude_m)
            }
            Stream::VfrHud => {
                // Throttle is the share of the top speed that is flown.
                let share = state.speed_mps / self.flight.limits().speed_max_mps;
                let throttle_percent = if self.flight.is_engine_running() { (100.0 * share).round() as u16 } else { 0 };
                telemetry::vfr_hud(state, origin.altitude_amsl_m + state.altitude_m, throttle_percent)
            }
            Stream::GpsRawInt => telemetry::gps_raw_int(time, state, self.frame),
            Stream::MissionCurrent => self.mission_current(),
            Stream::FenceStatus => self.fence_status(),
            Stream::BatteryStatus => unknown_battery(),
            Stream::ExtendedSysState => telemetry::extended_sys_state(self.landed_state()),
            Stream::AutopilotVersion => {
                let capabilities = capabilities() | self.personality.capabilities();
                telemetry::autopilot_version(self.personality.version(), capabilities, u64::from(self.system_id))
            }
            Stream::ProtocolVersion => telemetry::protocol_version(),
            Stream::GpsGlobalOrigin => telemetry::gps_global_origin(time, &origin),
            Stream::HomePosition => self.home_position(),
        }
    }

    fn home_position(&self) -> Message {
        let home = self.flight.home();
        let place = self.frame.to_geodetic(home.x_m, home.y_m, home.altitude_m);
        Message::HOME_POSITION(HOME_POSITION_DATA {
            latitude: (place.latitude_deg * 1e7).round() as i32,
            longitude: (place.longitude_deg * 1e7).round() as i32,
            altitude: (place.altitude_amsl_m * 1e3).round() as i32,
            x: home.x_m as f32,
            y: home.y_m as f32,
            // Down; zero must not become minus zero.
            z: (0.0 - home.altitude_m) as f32,
            q: [1.0, 0.0, 0.0, 0.0],
            time_usec: u64::try_from(self.time.as_micros()).unwrap_or(u64::MAX),
            ..HOME_POSITION_DATA::DEFAULT
        })
    }

    fn landed_state(&self) -> MavLandedState {
        if !self.flight.is_flying() {
            MavLandedState::MAV_LANDED_STATE_ON_GROUND
        } else if self.flight.is_taking_off() {
            MavLandedState::MAV_LANDED_STATE_TAKEOFF
        } else if self.flight.is_landing() {
            MavLandedState::MAV_LANDED_STATE_LANDING
        } else {
            MavLandedState::MAV_LANDED_STATE_IN_AIR
        }
    }

    fn mission_current(&self) -> Message {
        let is_flown = self.flight.mode() == Mode::Auto;
        let mission_state = if !self.mission.is_flyable() {
            MissionState::MISSION_STATE_NO_MISSION
        } else if self.progress.is_complete {
            MissionState::MISSION_STATE_COMPLETE
        } else if is_flown {
            MissionState::MISSION_STATE_ACTIVE
        } else {
            MissionState::MISSION_STATE_NOT_STARTED
        };
        Message::MISSION_CURRENT(MISSION_CURRENT_DATA {
            seq: self.progress.current,
            // Home is not counted.
            total: self.mission.len().saturating_sub(1),
            mission_state,
            mission_mode: if is_flown { 1 } else { 2 },
            ..MISSION_CURRENT_DATA::DEFAULT
        })
    }

    fn fence_status(&self) -> Message {
        let fence = &self.fence;
        Message::FENCE_STATUS(FENCE_STATUS_DATA {
            breach_time: mavlink_bridge::boot_ms(fence.breached_at),
            breach_count: fence.breaches,
            breach_status: u8::from(fence.breached != 0),
            breach_type: fence.breach_type(),
            ..FENCE_STATUS_DATA::DEFAULT
        })
    }

    fn status(&self) -> MavState {
        if self.failsafe {
            MavState::MAV_STATE_CRITICAL
        } else if self.flight.is_flying() {
            MavState::MAV_STATE_ACTIVE
        } else {
            MavState::MAV_STATE_STANDBY
        }
    }

    /// Every sensor that a client may wait for is there and healthy; so is the pre-arm check, unless something stands
    /// against arming.
    fn sys_status(&self) -> Message {
        let sensors = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO
            | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL
            | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_MAG
            | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
            | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_DIFFERENTIAL_PRESSURE
            | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_GPS
            | MavSysStatusSensor::MAV_SYS_STATUS_AHRS
            | MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        // ArduPilot's fence is healthy while it is not breached, there or not: MAVProxy would tell of a breach.
        let fence = |holds: bool| {
            let bit = MavSysStatusSensor::MAV_SYS_STATUS_GEOFENCE;
            if holds { bit } else { MavSysStatusSensor::empty() }
        };
        let mut healthy = sensors | fence(self.fence.breached == 0);
        healthy.set(MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK, self.is_armable);
        Message::SYS_STATUS(SYS_STATUS_DATA {
            onboard_control_sensors_present: sensors | fence(self.fence.is_present),
            onboard_control_sensors_enabled: sensors | fence(self.fence.is_active),
            onboard_control_sensors_health: healthy,
            // No battery is simulated: the values that mean "not known".
            voltage_battery: u16::MAX,
            current_battery: -1,
            battery_remaining: -1,
            // The default of a bitmask is its first flag, not none.
            onboard_control_sensors_present_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_enabled_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_health_extended: MavSysStatusSensorExtended::empty(),
            ..SYS_STATUS_DATA::DEFAULT
        })
    }
}

/// No more than there is: ground stations ask for what they are told of.
fn capabilities() -> MavProtocolCapability {
    MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MAVLINK2
}

/// No battery is simulated: the values that mean "not known".
fn unknown_battery() -> Message {
    Message::BATTERY_STATUS(BATTERY_STATUS_DATA {
        current_consumed: -1,
        energy_consumed: -1,
        temperature: i16::MAX,
        voltages: [u16::MAX; 10],
        current_battery: -1,
        battery_remaining: -1,
        // The default of a bitmask is its first flag, not none.
        fault_bitmask: MavBatteryFault::empty(),
        ..BATTERY_STATUS_DATA::DEFAULT
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VehicleSettings;
    use mavlink_bridge::dialect::DialectMessage;

    fn message(flight: &Flight, stream: Stream) -> Message {
        let instruments = Instruments {
            time: Duration::ZERO,
            system_id: 1,
            personality: Personality::default(),
            mission: &Mission::default(),
            progress: &Progress::default(),
            flight,
            frame: &VehicleSettings::default().frame,
            failsafe: false,
            is_armable: true,
            fence: FenceReport::default(),
            clock_epoch_us: 7,
        };
        instruments.message(stream)
    }

    #[test]
    fn every_stream_makes_its_own_message() {
        let flight = Flight::new(&VehicleSettings::default());
        for stream in Stream::ALL {
            assert_eq!(message(&flight, stream).message_id(), stream.message_id());
            assert_eq!(Stream::from_message_id(stream.message_id()), Some(stream));
        }
    }

    #[test]
    fn a_coordinated_turn_banks() {
        let mut flight = Flight::new(&VehicleSettings::default());
        flight.set_course(3.0, 10.0); // one g sideways: 45 degrees of bank
        for _ in 0..50 {
            flight.step();
        }
        let Message::ATTITUDE(attitude) = message(&flight, Stream::Attitude) else { panic!() };
        assert!((attitude.roll - std::f32::consts::FRAC_PI_4).abs() < 1e-5);
        assert!((attitude.yawspeed - 1.0).abs() < 1e-5);
    }
}
