//! What the vehicle says of itself.

// Clients still speak what the dialect calls superseded, and autopilots answer.
#![allow(deprecated)]

pub(crate) mod announce;
mod drone_id;
mod extra;
mod navigation;
mod peripherals;
pub(crate) mod rates;
mod sensors;
pub(crate) mod streams;

use crate::autopilot::Autopilot;
use crate::autopilot::failsafe::battery::BatteryLevel;
use crate::autopilot::fence::kinds::{CIRCLE, Kinds, MAX_ALTITUDE, POLYGON};
use crate::autopilot::fence::monitor::FenceReport;
use crate::autopilot::flight::Flight;
use crate::autopilot::plan::PlanKind;
use crate::firmware::offers::px4_streams;
use crate::firmware::rules::{CommandSet, Rules};
use crate::mode::Mode;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use crate::telemetry::streams::Stream;
use crate::world::{GpsSettings, Readings, World};
use flight_model::LocalFrame;
use mavlink_bridge::dialect::{
    FENCE_STATUS_DATA, FenceBreach, HOME_POSITION_DATA, MISSION_CURRENT_DATA, MavLandedState, MavProtocolCapability,
    MavState, MavSysStatusSensor, MavSysStatusSensorExtended, MavType, Message, MissionState, RC_CHANNELS_DATA,
    SYS_STATUS_DATA,
};
use mavlink_bridge::{ArduPilotMessage, LatLonE7, PlanItem, boot_ms, local_position_ned, telemetry};
use std::time::Duration;

/// Everything that the messages are made of, at one moment.
pub(crate) struct Instruments<'a> {
    time: Duration,
    system_id: u8,
    rules: &'static Rules,
    autopilot: &'a Autopilot,
    flight: &'a Flight,
    frame: &'a LocalFrame,
    world: &'a World,
    parameters: &'a Parameters,
    fence: FenceReport,
    /// Whether it is armed, or nothing stands against it.
    is_armable: bool,
    clock_epoch_us: u64,
}

impl<'a> Instruments<'a> {
    pub fn of(autopilot: &'a Autopilot, system_id: u8, clock_epoch_us: u64) -> Self {
        Self {
            time: autopilot.time(),
            system_id,
            rules: autopilot.rules(),
            autopilot,
            flight: &autopilot.flight,
            frame: autopilot.frame(),
            world: &autopilot.world,
            parameters: &autopilot.parameters,
            fence: autopilot.fence_report(),
            is_armable: autopilot.against_arming().is_none(),
            clock_epoch_us,
        }
    }

    /// Vehicle time.
    pub fn time(&self) -> Duration {
        self.time
    }
}

impl Instruments<'_> {
    /// Whether there is anything to say when a stream is due; asked for, it is said anyhow.
    pub fn has(&self, stream: Stream) -> bool {
        match stream {
            _ if self.rules.commands == CommandSet::Px4 => px4_streams(self.autopilot, stream),
            Stream::FenceStatus => self.fence.is_enabled,
            _ => true,
        }
    }

    pub fn message(&self, stream: Stream) -> Message {
        let (time, state) = (self.time, &self.flight.estimate());
        let origin = self.frame.origin();
        match stream {
            Stream::Heartbeat => telemetry::heartbeat(
                MavType::MAV_TYPE_FIXED_WING,
                self.rules.autopilot,
                (self.rules.base_mode)(self.flight.mode(), self.flight.is_armed()),
                (self.rules.custom_mode)(self.flight.mode()),
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
                let throttle_percent = (100.0 * self.throttle()).round() as u16;
                let airspeed_mps = self.readings().airspeed_mps;
                let altitude_m = origin.altitude_amsl_m + state.altitude_m;
                telemetry::vfr_hud(state, airspeed_mps, self.flight.heading_rad(), altitude_m, throttle_percent)
            }
            Stream::GpsRawInt => {
                let settings = GpsSettings::of(self.parameters);
                let measured = self.world.measure_place(&settings, self.flight.state(), time);
                telemetry::gps_raw_int(time, &measured, self.frame, settings.has_fix(), settings.satellites())
            }
            Stream::RawImu => sensors::raw_imu(time, &self.readings(), self.gravity_mps2()),
            Stream::ScaledImu => sensors::scaled_imu(time, &self.readings(), self.gravity_mps2()),
            Stream::ScaledPressure => sensors::scaled_pressure(time, &self.readings()),
            Stream::HighresImu => sensors::highres_imu(time, &self.readings()),
            // Of ArduPilot's own dialect: see ardupilot_message.
            Stream::Wind | Stream::WindCov | Stream::EkfStatusReport => telemetry::wind_cov(
                time,
                &self.world.wind_estimate(),
                f64::from(self.parameters.get(Parameter::WindGusts)),
                origin.altitude_amsl_m + state.altitude_m,
            ),
            Stream::RcChannels => self.rc_channels(),
            Stream::MissionCurrent => self.mission_current(),
            Stream::BatteryStatus => self.battery_status(),
            Stream::FenceStatus => self.fence_status(),
            Stream::ExtendedSysState => telemetry::extended_sys_state(self.landed_state()),
            Stream::AutopilotVersion => {
                let capabilities = capabilities(self.rules);
                telemetry::autopilot_version(self.rules.version, capabilities, u64::from(self.system_id))
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
            Stream::CurrentMode => self.current_mode(),
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
            Stream::Wind => Some(mavlink_bridge::wind(&self.world.wind_estimate())),
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
        let origin_amsl_m = self.frame.origin().altitude_amsl_m;
        self.world.readings(&self.flight.motion(), self.parameters, self.time, origin_amsl_m)
    }

    /// RC_CHANNELS (<https://mavlink.io/en/messages/common.html#RC_CHANNELS>).
    fn rc_channels(&self) -> Message {
        let [
            chan1_raw,
            chan2_raw,
            chan3_raw,
            chan4_raw,
            chan5_raw,
            chan6_raw,
            chan7_raw,
            chan8_raw,
            chan9_raw,
            chan10_raw,
            chan11_raw,
            chan12_raw,
            chan13_raw,
            chan14_raw,
            chan15_raw,
            chan16_raw,
        ] = self.autopilot.session.channels.positions_us(self.time);
        Message::RC_CHANNELS(RC_CHANNELS_DATA {
            time_boot_ms: boot_ms(self.time),
            chan1_raw,
            chan2_raw,
            chan3_raw,
            chan4_raw,
            chan5_raw,
            chan6_raw,
            chan7_raw,
            chan8_raw,
            chan9_raw,
            chan10_raw,
            chan11_raw,
            chan12_raw,
            chan13_raw,
            chan14_raw,
            chan15_raw,
            chan16_raw,
            // Those of the receiver.
            chancount: 8,
            rssi: u8::MAX,
            ..RC_CHANNELS_DATA::DEFAULT
        })
    }

    fn battery_level(&self) -> BatteryLevel {
        self.autopilot.session.failsafes.battery.level()
    }

    fn mission_current(&self) -> Message {
        let (mission, progress) = (self.autopilot.mission(), &self.autopilot.session.progress);
        let as_px4 = self.rules.tells_mission_as_px4;
        let mode = self.flight.mode();
        let is_flown = mode == Mode::Auto || as_px4 && matches!(mode, Mode::Takeoff | Mode::Land);
        let is_paused = progress.reached().is_some() || progress.has_begun() && progress.current() > 0;
        let id = |kind| if as_px4 { checksum(self.autopilot.plan(kind)) } else { 0 };
        let mission_state = if !mission.is_flyable() {
            MissionState::MISSION_STATE_NO_MISSION
        } else if progress.is_complete() {
            MissionState::MISSION_STATE_COMPLETE
        } else if is_flown {
            MissionState::MISSION_STATE_ACTIVE
        } else if as_px4 && is_paused {
            MissionState::MISSION_STATE_PAUSED
        } else {
            MissionState::MISSION_STATE_NOT_STARTED
        };
        // There is no item behind the last one.
        let last = mission.len().saturating_sub(1);
        Message::MISSION_CURRENT(MISSION_CURRENT_DATA {
            seq: progress.told().min(last),
            // Home is not counted. A PX4 tells of none that it has none.
            total: match mission.len().saturating_sub(mission.first()) {
                0 if self.rules.judges_plans_as_px4 => u16::MAX,
                total => total,
            },
            mission_state,
            // An ArduPlane knows only whether it is flown.
            mission_mode: if is_flown { 1 } else { self.rules.mission_mode_suspended },
            mission_id: id(PlanKind::Mission),
            fence_id: id(PlanKind::Fence),
            rally_points_id: id(PlanKind::Rally),
        })
    }

    fn fence_status(&self) -> Message {
        let fence = &self.fence;
        Message::FENCE_STATUS(FENCE_STATUS_DATA {
            breach_time: boot_ms(fence.breached_at),
            breach_count: fence.breaches,
            breach_status: u8::from(fence.breached != 0),
            breach_type: breach_type(fence.breached),
            ..FENCE_STATUS_DATA::DEFAULT
        })
    }

    fn status(&self) -> MavState {
        if self.autopilot.is_in_failsafe() {
            MavState::MAV_STATE_CRITICAL
        } else if self.flight.is_flying() || self.rules.is_active_once_armed && self.flight.is_armed() {
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
        let battery = sensors::Charge::of(self.world.battery(), self.parameters);
        let mut sensors = sensors;
        sensors.set(MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_BATTERY, battery.is_some());
        sensors.set(MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_RC_RECEIVER, self.rules.has_switches);
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
            (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_RC_RECEIVER, self.autopilot.hears_transmitter()),
            (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_DIFFERENTIAL_PRESSURE, pitot_is_whole),
            (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_BATTERY, self.battery_level() == BatteryLevel::Ok),
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
        sensors::battery_status(sensors::Charge::of(self.world.battery(), self.parameters), self.battery_level())
    }
}

/// PX4's checksum of a plan, by which clients know whether theirs is on board (`crc32_for_mission_item`): CRC-32 over
/// its items without the inversions at both ends; 0 of none.
pub(crate) fn checksum(items: &[PlanItem]) -> u32 {
    let mut crc = crc32fast::Hasher::new_with_initial(!0);
    for item in items {
        crc.update(&[item.frame]);
        crc.update(&item.command.to_le_bytes());
        crc.update(&[item.autocontinue]);
        item.params.iter().for_each(|param| crc.update(&param.to_le_bytes()));
        crc.update(&item.latitude_e7.to_le_bytes());
        crc.update(&item.longitude_e7.to_le_bytes());
        crc.update(&item.z_m.to_le_bytes());
    }
    !crc.finalize()
}

/// No more than there is: ground stations ask for what they are told of.
fn capabilities(rules: &Rules) -> MavProtocolCapability {
    let encoding = if rules.bytewise_parameters {
        MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    } else {
        MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    };
    encoding
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MAVLINK2
}

/// Of several breaches, the one that ArduPilot tells.
fn breach_type(breached: Kinds) -> FenceBreach {
    match breached {
        0 => FenceBreach::FENCE_BREACH_NONE,
        kinds if kinds & (CIRCLE | POLYGON) != 0 => FenceBreach::FENCE_BREACH_BOUNDARY,
        kinds if kinds & MAX_ALTITUDE != 0 => FenceBreach::FENCE_BREACH_MAXALT,
        _ => FenceBreach::FENCE_BREACH_MINALT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;
    use mavlink_bridge::dialect::DialectMessage;

    fn autopilot() -> Autopilot {
        Autopilot::new(&VehicleSettings::default(), false)
    }

    #[test]
    fn every_stream_makes_its_own_message() {
        let autopilot = autopilot();
        let instruments = Instruments::of(&autopilot, 1, 7);
        for stream in Stream::ALL {
            let foreign = instruments.ardupilot_message(stream);
            let id = foreign.map_or_else(|| instruments.message(stream).message_id(), |message| message.message_id());
            assert_eq!(id, stream.message_id());
            assert_eq!(Stream::from_message_id(stream.message_id()), Some(stream));
        }
    }

    #[test]
    fn a_coordinated_turn_banks() {
        let mut autopilot = autopilot();
        autopilot.flight.set_course(3.0, 10.0); // one g sideways: 45 degrees of bank
        for _ in 0..50 {
            autopilot.flight.step();
        }
        let message = Instruments::of(&autopilot, 1, 7).message(Stream::Attitude);
        let Message::ATTITUDE(attitude) = message else { panic!() };
        assert!((attitude.roll - std::f32::consts::FRAC_PI_4).abs() < 1e-5);
        assert!((attitude.yawspeed - 1.0).abs() < 1e-5);
    }

    #[test]
    fn of_several_breaches_the_boundary_is_told() {
        use crate::autopilot::fence::kinds::{ALL, MIN_ALTITUDE};
        assert_eq!(breach_type(ALL), FenceBreach::FENCE_BREACH_BOUNDARY);
        assert_eq!(breach_type(MIN_ALTITUDE | MAX_ALTITUDE), FenceBreach::FENCE_BREACH_MAXALT);
        assert_eq!(breach_type(MIN_ALTITUDE), FenceBreach::FENCE_BREACH_MINALT);
    }
}
