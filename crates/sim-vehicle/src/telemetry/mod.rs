//! What the vehicle says of itself.

mod announce;
mod extra;
mod navigation;
mod sensors;
pub(crate) mod streams;

use crate::autopilot::failsafe::BatteryLevel;
use crate::autopilot::fence::FenceReport;
use crate::autopilot::flight::Flight;
use crate::autopilot::manual_control::Channels;
use crate::autopilot::mission::{Mission, Progress};
use crate::firmware::Personality;
use crate::mode::Mode;
use crate::parameters::{Parameter, Parameters};
use crate::telemetry::streams::Stream;
use crate::world::{GpsSettings, Readings, SensorSettings, World, tick};
use flight_model::LocalFrame;
use mavlink_bridge::dialect::{
    FENCE_STATUS_DATA, HOME_POSITION_DATA, MISSION_CURRENT_DATA, MavLandedState, MavProtocolCapability, MavState,
    MavSysStatusSensor, MavSysStatusSensorExtended, MavType, Message, MissionState, SYS_STATUS_DATA,
};
use mavlink_bridge::{ArduPilotMessage, LatLonE7, local_position_ned, telemetry};
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
    pub channels: &'a Channels,
    pub world: &'a World,
    pub parameters: &'a Parameters,
    pub battery_level: BatteryLevel,
    pub fence: FenceReport,
    pub clock_epoch_us: u64,
}

impl Instruments<'_> {
    /// Whether there is anything to say when a stream is due; asked for, it is said anyhow.
    pub fn has(&self, stream: Stream) -> bool {
        stream != Stream::FenceStatus || self.fence.is_enabled
    }

    pub fn message(&self, stream: Stream) -> Message {
        let (time, state) = (self.time, &self.flight.estimate());
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
                let flight = self.flight;
                telemetry::attitude(time, &flight.in_air(), flight.roll_rad(), flight.turn_rate_radps())
            }
            Stream::LocalPositionNed => local_position_ned(time, state),
            Stream::GlobalPositionInt => {
                let home_altitude_m = self.flight.home().altitude_m;
                telemetry::global_position_int(time, state, self.flight.heading_rad(), self.frame, home_altitude_m)
            }
            Stream::VfrHud => {
                // Throttle is the share of the top speed that is flown.
                let top_mps = self.flight.limits().speed_max_mps;
                let share = if self.flight.is_engine_running() { self.flight.airspeed_mps() / top_mps } else { 0.0 };
                let throttle_percent = (100.0 * share).round() as u16;
                let airspeed_mps = self.readings().airspeed_mps;
                let altitude_m = origin.altitude_amsl_m + state.altitude_m;
                telemetry::vfr_hud(state, airspeed_mps, self.flight.heading_rad(), altitude_m, throttle_percent)
            }
            Stream::GpsRawInt => {
                let settings = GpsSettings::of(self.parameters);
                let measured = self.world.gps.measure(&settings, self.flight.state(), &self.world.noise, tick(time));
                telemetry::gps_raw_int(time, &measured, self.frame, settings.has_fix(), settings.satellites())
            }
            Stream::RawImu => sensors::raw_imu(time, &self.readings(), self.gravity_mps2()),
            Stream::ScaledImu => sensors::scaled_imu(time, &self.readings(), self.gravity_mps2()),
            Stream::ScaledPressure => sensors::scaled_pressure(time, &self.readings()),
            Stream::HighresImu => sensors::highres_imu(time, &self.readings()),
            // Of ArduPilot's own dialect: see ardupilot_message.
            Stream::Wind | Stream::WindCov | Stream::EkfStatusReport => telemetry::wind_cov(
                time,
                &self.world.weather.estimate(),
                f64::from(self.parameters.get(Parameter::WindGusts)),
                origin.altitude_amsl_m + state.altitude_m,
            ),
            Stream::RcChannels => self.channels.message(time),
            Stream::MissionCurrent => self.mission_current(),
            Stream::BatteryStatus => self.battery_status(),
            Stream::FenceStatus => self.fence_status(),
            Stream::ExtendedSysState => telemetry::extended_sys_state(self.landed_state()),
            Stream::AutopilotVersion => {
                let capabilities = capabilities() | self.personality.capabilities();
                telemetry::autopilot_version(self.personality.version(), capabilities, u64::from(self.system_id))
            }
            Stream::ProtocolVersion => telemetry::protocol_version(),
            Stream::GpsGlobalOrigin => telemetry::gps_global_origin(time, &origin),
            Stream::HomePosition => self.home_position(),
            Stream::AttitudeQuaternion => self.attitude_quaternion(),
            Stream::NavControllerOutput => self.nav_controller_output(),
            Stream::PositionTargetLocalNed => self.position_target_local_ned(),
            Stream::PositionTargetGlobalInt => self.position_target_global_int(),
            Stream::Altitude => self.altitude(),
            Stream::Odometry => self.odometry(),
            // What is only asked for; every stream is here or there.
            other => self.extra(other).unwrap_or_else(telemetry::protocol_version),
        }
    }

    fn home_position(&self) -> Message {
        let home = self.flight.home();
        let place = self.frame.to_geodetic(home.x_m, home.y_m, home.altitude_m);
        let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&place);
        Message::HOME_POSITION(HOME_POSITION_DATA {
            latitude: latitude_e7,
            longitude: longitude_e7,
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

    /// What a stream says in a message of ArduPilot's own dialect; none if it is of the common one.
    pub fn ardupilot_message(&self, stream: Stream) -> Option<ArduPilotMessage> {
        match stream {
            Stream::Wind => Some(mavlink_bridge::wind(&self.world.weather.estimate())),
            Stream::EkfStatusReport => Some(mavlink_bridge::ekf_status_report(self.estimator_flags())),
            other => self.extra_of_ardupilot(other),
        }
    }

    /// EKF_STATUS_FLAGS: ArduPlane's 831 with a GPS. Reckoning on without one, the place is not absolute any more.
    fn estimator_flags(&self) -> u16 {
        const ALL: u16 = 831;
        const ABSOLUTE_PLACE: u16 = 16 + 512;
        if self.has_fix() { ALL } else { ALL & !ABSOLUTE_PLACE }
    }

    fn has_fix(&self) -> bool {
        GpsSettings::of(self.parameters).has_fix()
    }

    fn gravity_mps2(&self) -> f64 {
        self.flight.limits().gravity_mps2
    }

    fn readings(&self) -> Readings {
        Readings::take(
            self.flight,
            &SensorSettings::of(self.parameters),
            &self.world.noise,
            tick(self.time),
            self.world.barometer_drift_m,
            self.frame.origin().altitude_amsl_m,
        )
    }

    fn mission_current(&self) -> Message {
        let is_flown = self.flight.mode() == Mode::Auto;
        let mission_state = if !self.mission.is_flyable() {
            MissionState::MISSION_STATE_NO_MISSION
        } else if self.progress.is_complete {
            MissionState::MISSION_STATE_COMPLETE
        } else if is_flown {
            MissionState::MISSION_STATE_ACTIVE
        } else if self.personality == Personality::Px4 && self.progress.has_begun {
            MissionState::MISSION_STATE_PAUSED
        } else {
            MissionState::MISSION_STATE_NOT_STARTED
        };
        // There is no item behind the last one.
        let last = self.mission.len().saturating_sub(1);
        Message::MISSION_CURRENT(MISSION_CURRENT_DATA {
            seq: self.progress.told().min(last),
            // Home is not counted.
            total: self.mission.len().saturating_sub(self.mission.first),
            mission_state,
            // An ArduPlane knows only whether it is flown.
            mission_mode: match (is_flown, self.personality) {
                (true, _) => 1,
                (false, Personality::ArduPlane) => 0,
                (false, _) => 2,
            },
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
        let battery = sensors::Charge::of(&self.world.battery, self.parameters);
        let mut sensors = sensors;
        sensors.set(MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_BATTERY, battery.is_some());
        // ArduPilot's fence is healthy while it is not breached, there or not: MAVProxy would tell of a breach.
        let fence = |holds: bool| {
            let bit = MavSysStatusSensor::MAV_SYS_STATUS_GEOFENCE;
            if holds { bit } else { MavSysStatusSensor::empty() }
        };
        let mut health = sensors | fence(self.fence.breached == 0);
        let pitot_is_whole = self.parameters.get(Parameter::PitotFail) == 0.0;
        for (sensor, is_well) in [
            (MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK, self.is_armable),
            (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_GPS, self.has_fix()),
            (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_DIFFERENTIAL_PRESSURE, pitot_is_whole),
            (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_BATTERY, self.battery_level == BatteryLevel::Ok),
        ] {
            health &= if is_well { health } else { !sensor };
        }
        Message::SYS_STATUS(SYS_STATUS_DATA {
            onboard_control_sensors_present: sensors | fence(self.fence.is_present),
            onboard_control_sensors_enabled: sensors | fence(self.fence.is_active),
            onboard_control_sensors_health: health,
            // The values that mean "not known", without a monitor.
            voltage_battery: battery.map_or(u16::MAX, |battery| battery.millivolts()),
            current_battery: battery.map_or(-1, |battery| battery.centiamperes()),
            battery_remaining: battery.map_or(-1, |battery| battery.percent()),
            // The default of a bitmask is its first flag, not none.
            onboard_control_sensors_present_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_enabled_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_health_extended: MavSysStatusSensorExtended::empty(),
            ..SYS_STATUS_DATA::DEFAULT
        })
    }

    fn battery_status(&self) -> Message {
        sensors::battery_status(sensors::Charge::of(&self.world.battery, self.parameters), self.battery_level)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;
    use mavlink_bridge::dialect::DialectMessage;

    fn look<T>(flight: &Flight, at: impl FnOnce(&Instruments<'_>) -> T) -> T {
        let parameters = Parameters::new(&VehicleSettings::default());
        let instruments = Instruments {
            time: Duration::ZERO,
            world: &World::new(&VehicleSettings::default(), &parameters),
            parameters: &parameters,
            battery_level: BatteryLevel::Ok,
            system_id: 1,
            personality: Personality::default(),
            mission: &Mission::new(1),
            progress: &Progress::default(),
            flight,
            frame: &VehicleSettings::default().frame,
            failsafe: false,
            is_armable: true,
            channels: &Channels::default(),
            fence: FenceReport::default(),
            clock_epoch_us: 7,
        };
        at(&instruments)
    }

    fn message(flight: &Flight, stream: Stream) -> Message {
        look(flight, |instruments| instruments.message(stream))
    }

    #[test]
    fn every_stream_makes_its_own_message() {
        let flight = Flight::new(&VehicleSettings::default());
        for stream in Stream::ALL {
            let foreign = look(&flight, |instruments| instruments.ardupilot_message(stream));
            let id = foreign.map_or_else(|| message(&flight, stream).message_id(), |message| message.message_id());
            assert_eq!(id, stream.message_id());
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
