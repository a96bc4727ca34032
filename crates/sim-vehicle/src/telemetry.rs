//! What the vehicle says of itself.

use crate::Mode;
use crate::fence::FenceReport;
use crate::flight::Flight;
use crate::mission::{Mission, Progress};
use crate::streams::Stream;
use flight_model::LocalFrame;
use mavlink_bridge::dialect::{
    BATTERY_STATUS_DATA, FENCE_STATUS_DATA, HOME_POSITION_DATA, MISSION_CURRENT_DATA, MavAutopilot, MavBatteryFault,
    MavModeFlag, MavProtocolCapability, MavState, MavSysStatusSensor, MavSysStatusSensorExtended, MavType, Message,
    MissionState, SYS_STATUS_DATA,
};
use mavlink_bridge::{local_position_ned, telemetry};
use std::time::Duration;

/// Everything that the messages are made of, at one moment.
pub(crate) struct Instruments<'a> {
    pub time: Duration,
    pub system_id: u8,
    pub flight: &'a Flight,
    pub mission: &'a Mission,
    pub progress: &'a Progress,
    pub frame: &'a LocalFrame,
    pub failsafe: bool,
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
                MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
                base_mode(self.flight.mode(), self.flight.is_armed()),
                self.flight.mode().number(),
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
            Stream::GlobalPositionInt => telemetry::global_position_int(time, state, self.frame),
            Stream::VfrHud => {
                // There is no engine: throttle is the share of the top speed that is flown.
                let throttle_percent = (100.0 * state.speed_mps / self.flight.limits().speed_max_mps).round() as u16;
                telemetry::vfr_hud(state, origin.altitude_amsl_m + state.altitude_m, throttle_percent)
            }
            Stream::GpsRawInt => telemetry::gps_raw_int(time, state, self.frame),
            Stream::MissionCurrent => self.mission_current(),
            Stream::FenceStatus => self.fence_status(),
            Stream::BatteryStatus => unknown_battery(),
            Stream::ExtendedSysState => telemetry::extended_sys_state(self.flight.is_armed()),
            Stream::AutopilotVersion => {
                telemetry::autopilot_version(ARDUPLANE_VERSION, capabilities(), u64::from(self.system_id))
            }
            Stream::ProtocolVersion => telemetry::protocol_version(),
            Stream::GpsGlobalOrigin => telemetry::gps_global_origin(time, &origin),
            Stream::HomePosition => Message::HOME_POSITION(HOME_POSITION_DATA {
                latitude: (origin.latitude_deg * 1e7).round() as i32,
                longitude: (origin.longitude_deg * 1e7).round() as i32,
                altitude: (origin.altitude_amsl_m * 1e3).round() as i32,
                q: [1.0, 0.0, 0.0, 0.0],
                time_usec: u64::try_from(time.as_micros()).unwrap_or(u64::MAX),
                ..HOME_POSITION_DATA::DEFAULT
            }),
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
        } else if self.flight.is_armed() {
            MavState::MAV_STATE_ACTIVE
        } else {
            MavState::MAV_STATE_STANDBY
        }
    }

    /// Every sensor that a client may wait for is there and healthy, the pre-arm check among them.
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
        Message::SYS_STATUS(SYS_STATUS_DATA {
            onboard_control_sensors_present: sensors | fence(self.fence.is_present),
            onboard_control_sensors_enabled: sensors | fence(self.fence.is_active),
            onboard_control_sensors_health: sensors | fence(self.fence.breached == 0),
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

/// The version whose names and answers the vehicle has.
const ARDUPLANE_VERSION: [u8; 3] = [4, 7, 0];

/// No more than there is: ground stations ask for what they are told of.
#[allow(deprecated)] // older ones know only the first name of the parameters' encoding
fn capabilities() -> MavProtocolCapability {
    MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
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

/// The flags that ArduPlane sets: 217 in GUIDED when armed, 209 in CRUISE.
fn base_mode(mode: Mode, armed: bool) -> MavModeFlag {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED;
    if mode != Mode::Cruise {
        flags |= MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED;
    }
    if armed {
        flags |= MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
    }
    flags
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
            mission: &Mission::default(),
            progress: &Progress::default(),
            flight,
            frame: &VehicleSettings::default().frame,
            failsafe: false,
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
    fn the_heartbeat_is_arduplanes() {
        assert_eq!(base_mode(Mode::Guided, true).bits(), 217);
        assert_eq!(base_mode(Mode::Cruise, true).bits(), 209);
        assert_eq!(base_mode(Mode::Guided, false).bits(), 89);
    }

    #[test]
    fn a_coordinated_turn_banks() {
        let mut flight = Flight::new(&VehicleSettings::default());
        flight.set_course(3.0, 10.0); // one g sideways: 45 degrees of bank
        (0..50).for_each(|_| flight.step());
        let Message::ATTITUDE(attitude) = message(&flight, Stream::Attitude) else { panic!() };
        assert!((attitude.roll - std::f32::consts::FRAC_PI_4).abs() < 1e-5);
        assert!((attitude.yawspeed - 1.0).abs() < 1e-5);
    }
}
