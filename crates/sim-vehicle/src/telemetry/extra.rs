//! Messages that clients ask for and no vehicle sends unasked: outputs, the sensors beside the first ones, the
//! simulation's own view, the autopilot's health. Of what there is no device for, they say so where a field can.

// Clients still ask for what the dialect calls superseded.
#![allow(deprecated)]

use super::{Instruments, sensors};
use crate::parameters::table::Parameter;
use crate::telemetry::streams::Stream;
use flight_model::Geodetic;
use mavlink_bridge::dialect::{
    ACTUATOR_OUTPUT_STATUS_DATA, AIRSPEED_DATA, ATTITUDE_TARGET_DATA, AVAILABLE_MODES_MONITOR_DATA,
    AirspeedSensorFlags, AttitudeTargetTypemask, DISTANCE_SENSOR_DATA, ESTIMATOR_STATUS_DATA, EstimatorStatusFlags,
    FLIGHT_INFORMATION_DATA, HIGH_LATENCY2_DATA, HIL_ACTUATOR_CONTROLS_DATA, HilActuatorControlsFlags, HlFailureFlag,
    MAG_CAL_REPORT_DATA, MANUAL_CONTROL_DATA, MISSION_ITEM_REACHED_DATA, MagCalStatus, MavDistanceSensor,
    MavPowerStatus, MavSensorOrientation, MavType, Message, PING_DATA, POWER_STATUS_DATA, RC_CHANNELS_RAW_DATA,
    RELAY_STATUS_DATA, SCALED_IMU2_DATA, SCALED_IMU3_DATA, SCALED_PRESSURE2_DATA, SERVO_OUTPUT_RAW_DATA,
    SIM_STATE_DATA, STORAGE_INFORMATION_DATA, StorageStatus, TERRAIN_REPORT_DATA, TIMESYNC_DATA, VIBRATION_DATA,
};
use mavlink_bridge::{ArduPilotMessage, ardupilot, boot_ms};

/// The middle of an output, microseconds.
const MIDDLE_US: u16 = 1500;
/// The supply of the autopilot's board, mV.
const BOARD_MV: u16 = 5000;

impl Instruments<'_> {
    /// A message that is sent when it is asked for; none if the stream is another one.
    pub(super) fn extra(&self, stream: Stream) -> Option<Message> {
        Some(match stream {
            Stream::Ping => {
                Message::PING(PING_DATA { time_usec: self.micros(), seq: 0, target_system: 0, target_component: 0 })
            }
            Stream::Timesync => Message::TIMESYNC(TIMESYNC_DATA {
                tc1: 0,
                ts1: i64::try_from(self.time.as_nanos()).unwrap_or(i64::MAX),
                ..TIMESYNC_DATA::DEFAULT
            }),
            Stream::RcChannelsRaw => self.rc_channels_raw(),
            Stream::ManualControl => self.manual_control(),
            Stream::ServoOutputRaw => self.servo_output_raw(),
            Stream::ActuatorOutputStatus => self.actuator_output_status(),
            Stream::HilActuatorControls => Message::HIL_ACTUATOR_CONTROLS(HIL_ACTUATOR_CONTROLS_DATA {
                time_usec: self.micros(),
                controls: std::array::from_fn(|output| if output == THROTTLE { self.throttle() as f32 } else { 0.0 }),
                mode: (self.rules.base_mode)(self.flight.mode(), self.flight.is_armed()),
                // The default of a bitmask is its first flag, not none.
                flags: HilActuatorControlsFlags::empty(),
            }),
            Stream::AttitudeTarget => self.attitude_target(),
            Stream::ScaledImu2 => self.scaled_imu_2(),
            Stream::ScaledImu3 => self.scaled_imu_3(),
            Stream::ScaledPressure2 => self.scaled_pressure_2(),
            Stream::SimState => self.sim_state(),
            Stream::HilStateQuaternion => self.hil_state_quaternion(),
            Stream::AutopilotStateForGimbalDevice => self.state_for_gimbal(),
            Stream::PowerStatus => Message::POWER_STATUS(POWER_STATUS_DATA {
                Vcc: BOARD_MV,
                Vservo: 0,
                flags: MavPowerStatus::MAV_POWER_STATUS_BRICK_VALID,
            }),
            Stream::DistanceSensor => self.distance_sensor(),
            Stream::TerrainReport => self.terrain_report(),
            Stream::MagCalReport => Message::MAG_CAL_REPORT(MAG_CAL_REPORT_DATA {
                cal_status: MagCalStatus::MAG_CAL_NOT_STARTED,
                diag_x: 1.0,
                diag_y: 1.0,
                diag_z: 1.0,
                scale_factor: 1.0,
                ..MAG_CAL_REPORT_DATA::DEFAULT
            }),
            Stream::EstimatorStatus => self.estimator_status(),
            Stream::HighLatency2 => self.high_latency_2(),
            Stream::Vibration => {
                Message::VIBRATION(VIBRATION_DATA { time_usec: self.micros(), ..VIBRATION_DATA::DEFAULT })
            }
            Stream::StorageInformation => Message::STORAGE_INFORMATION(STORAGE_INFORMATION_DATA {
                time_boot_ms: boot_ms(self.time),
                storage_id: 1,
                status: StorageStatus::STORAGE_STATUS_EMPTY,
                ..STORAGE_INFORMATION_DATA::DEFAULT
            }),
            Stream::FlightInformation => Message::FLIGHT_INFORMATION(FLIGHT_INFORMATION_DATA {
                time_boot_ms: boot_ms(self.time),
                ..FLIGHT_INFORMATION_DATA::DEFAULT
            }),
            Stream::MissionItemReached => self.mission_item_reached(),
            // The modes are always the same.
            Stream::AvailableModesMonitor => Message::AVAILABLE_MODES_MONITOR(AVAILABLE_MODES_MONITOR_DATA { seq: 0 }),
            Stream::DroneIdBasic => self.drone_id_basic(),
            Stream::DroneIdLocation => self.drone_id_location(),
            Stream::DroneIdSystem => self.drone_id_system(),
            Stream::Airspeed => self.airspeed(),
            Stream::RelayStatus => Message::RELAY_STATUS(RELAY_STATUS_DATA {
                time_boot_ms: boot_ms(self.time),
                on: u16::from(self.autopilot.session.outputs.relay()),
                present: 1,
            }),
            _ => return None,
        })
    }

    /// The same in ArduPilot's own dialect.
    pub(super) fn extra_of_ardupilot(&self, stream: Stream) -> Option<ArduPilotMessage> {
        // Every stream that is due comes by here: nothing is computed before the stream is known to be one of these.
        let place_e7 = || <[i32; 2]>::from(e7(&self.place()));
        Some(match stream {
            Stream::Meminfo => ardupilot::meminfo(),
            Stream::Ahrs => ardupilot::ahrs(),
            Stream::Ahrs2 => ardupilot::ahrs2(self.attitude_rad(), self.place().altitude_amsl_m, place_e7()),
            Stream::SimulatedState => {
                let readings = self.readings();
                ardupilot::simstate(self.attitude_rad(), readings.force_mps2, readings.rates_radps, place_e7())
            }
            Stream::Hwstatus => ardupilot::hwstatus(BOARD_MV),
            Stream::EscTelemetry => {
                let battery = self.world.battery();
                ardupilot::esc_telemetry(battery.voltage_v(), battery.current_a(), battery.consumed_mah())
            }
            Stream::AoaSsa => ardupilot::aoa_ssa(self.time, [0.0, 0.0]),
            _ => return None,
        })
    }

    pub(super) fn micros(&self) -> u64 {
        u64::try_from(self.time.as_micros()).unwrap_or(u64::MAX)
    }

    /// Where it thinks it is.
    pub(super) fn place(&self) -> Geodetic {
        let state = self.flight.estimate();
        self.frame.to_geodetic(state.x_m, state.y_m, state.altitude_m)
    }

    /// The share of the top speed that is flown, or the throttle that somebody else has set, 0 to 1; VFR_HUD has it in
    /// percent.
    pub(super) fn throttle(&self) -> f64 {
        if self.flight.is_idle() {
            return 0.0;
        }
        let share = || self.flight.equivalent_airspeed_mps() / self.flight.limits().speed_max_mps;
        let set = self.flight.attitude().and_then(|attitude| attitude.throttle);
        set.unwrap_or_else(share).clamp(0.0, 1.0)
    }

    /// The outputs as pulses, microseconds: there are no surfaces, and the throttle is VFR_HUD's.
    fn outputs_us(&self) -> [u16; 4] {
        [MIDDLE_US, MIDDLE_US, 1000 + (1000.0 * self.throttle()).round() as u16, MIDDLE_US]
    }

    fn servo_output_raw(&self) -> Message {
        let [servo1_raw, servo2_raw, servo3_raw, servo4_raw] = self.outputs_us();
        let [
            servo5_raw,
            servo6_raw,
            servo7_raw,
            servo8_raw,
            servo9_raw,
            servo10_raw,
            servo11_raw,
            servo12_raw,
            rest @ ..,
        ] = self.autopilot.session.outputs.servos_us();
        let [servo13_raw, servo14_raw, servo15_raw, servo16_raw] = rest;
        Message::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA {
            // A field of 32 bits.
            time_usec: self.micros() as u32,
            servo1_raw,
            servo2_raw,
            servo3_raw,
            servo4_raw,
            servo5_raw,
            servo6_raw,
            servo7_raw,
            servo8_raw,
            servo9_raw,
            servo10_raw,
            servo11_raw,
            servo12_raw,
            servo13_raw,
            servo14_raw,
            servo15_raw,
            servo16_raw,
            port: 0,
        })
    }

    fn actuator_output_status(&self) -> Message {
        let mut actuator = [0.0; 32];
        actuator[THROTTLE] = self.throttle() as f32;
        Message::ACTUATOR_OUTPUT_STATUS(ACTUATOR_OUTPUT_STATUS_DATA {
            time_usec: self.micros(),
            active: 0b1111,
            actuator,
        })
    }

    fn rc_channels_raw(&self) -> Message {
        let [chan1_raw, chan2_raw, chan3_raw, chan4_raw, chan5_raw, chan6_raw, chan7_raw, chan8_raw, ..] =
            self.autopilot.session.channels.positions_us(self.time);
        Message::RC_CHANNELS_RAW(RC_CHANNELS_RAW_DATA {
            time_boot_ms: boot_ms(self.time),
            chan1_raw,
            chan2_raw,
            chan3_raw,
            chan4_raw,
            chan5_raw,
            chan6_raw,
            chan7_raw,
            chan8_raw,
            port: 0,
            rssi: u8::MAX,
        })
    }

    fn manual_control(&self) -> Message {
        let [roll, pitch, throttle, yaw, ..] = self.autopilot.session.channels.positions_us(self.time);
        let share = |pulse_us: u16| ((i32::from(pulse_us) - i32::from(MIDDLE_US)) * 2).clamp(-1000, 1000) as i16;
        Message::MANUAL_CONTROL(MANUAL_CONTROL_DATA {
            x: share(pitch),
            y: share(roll),
            z: (i32::from(throttle) - 1000).clamp(0, 1000) as i16,
            r: share(yaw),
            target: self.system_id,
            ..MANUAL_CONTROL_DATA::DEFAULT
        })
    }

    /// What it steers for: the bank of the turn that it flies, level, on the course that it steers for, or what
    /// somebody else has set of them.
    fn attitude_target(&self) -> Message {
        let aim = self.flight.aim();
        let [roll_rad, set_rad] = self.flight.roll_and_pitch_rad();
        let is_pitched = self.flight.attitude().is_some_and(|attitude| attitude.pitch.is_some());
        let pitch_rad = if is_pitched { set_rad } else { 0.0 };
        Message::ATTITUDE_TARGET(ATTITUDE_TARGET_DATA {
            time_boot_ms: boot_ms(self.time),
            q: super::navigation::quaternion([roll_rad, pitch_rad, aim.course_rad]),
            body_yaw_rate: self.flight.turn_rate_radps() as f32,
            thrust: self.throttle() as f32,
            type_mask: AttitudeTargetTypemask::empty(),
            ..ATTITUDE_TARGET_DATA::DEFAULT
        })
    }

    /// The second of two sensors that measure alike.
    fn scaled_imu_2(&self) -> Message {
        let one = sensors::Scaled::of(&self.readings(), self.gravity_mps2());
        let ([xacc, yacc, zacc], [xgyro, ygyro, zgyro], [xmag, ymag, zmag]) = (one.force, one.rates, one.field);
        let (time_boot_ms, temperature) = (boot_ms(self.time), one.temperature);
        Message::SCALED_IMU2(SCALED_IMU2_DATA {
            time_boot_ms,
            xacc,
            yacc,
            zacc,
            xgyro,
            ygyro,
            zgyro,
            xmag,
            ymag,
            zmag,
            temperature,
        })
    }

    /// There is a third compass, and no third of the others.
    fn scaled_imu_3(&self) -> Message {
        let one = sensors::Scaled::of(&self.readings(), self.gravity_mps2());
        let [xmag, ymag, zmag] = one.field;
        Message::SCALED_IMU3(SCALED_IMU3_DATA {
            time_boot_ms: boot_ms(self.time),
            xmag,
            ymag,
            zmag,
            ..SCALED_IMU3_DATA::DEFAULT
        })
    }

    fn scaled_pressure_2(&self) -> Message {
        let readings = self.readings();
        Message::SCALED_PRESSURE2(SCALED_PRESSURE2_DATA {
            time_boot_ms: boot_ms(self.time),
            press_abs: (readings.pressure_pa / 100.0) as f32,
            temperature: (1e2 * readings.temperature_c).round() as i16,
            ..SCALED_PRESSURE2_DATA::DEFAULT
        })
    }

    /// The item that was reached last; 65535 before there is any.
    fn mission_item_reached(&self) -> Message {
        let seq = self.autopilot.session.progress.reached().map_or(u16::MAX, |(seq, _)| seq);
        Message::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq })
    }

    fn airspeed(&self) -> Message {
        let readings = self.readings();
        let works = self.parameters.get(Parameter::PitotFail) == 0.0;
        Message::AIRSPEED(AIRSPEED_DATA {
            airspeed: readings.airspeed_mps as f32,
            raw_press: (readings.dynamic_pressure_pa / 100.0) as f32,
            temperature: (1e2 * readings.temperature_c).round() as i16,
            id: 0,
            flags: if works {
                AirspeedSensorFlags::AIRSPEED_SENSOR_USING
            } else {
                AirspeedSensorFlags::AIRSPEED_SENSOR_UNHEALTHY
            },
        })
    }

    /// The truth, not the estimate.
    fn sim_state(&self) -> Message {
        let (state, readings) = (self.flight.state(), self.readings());
        let [roll, pitch, yaw] = self.attitude_rad().map(|angle_rad| angle_rad as f32);
        let [q1, q2, q3, q4] = self.quaternion();
        let ([xacc, yacc, zacc], [xgyro, ygyro, zgyro]) =
            (readings.force_mps2.map(|value| value as f32), readings.rates_radps.map(|value| value as f32));
        let place = self.frame.to_geodetic(state.x_m, state.y_m, state.altitude_m);
        let (sin, cos) = libm::sincos(state.course_rad);
        let (lat_int, lon_int) = e7(&place);
        Message::SIM_STATE(SIM_STATE_DATA {
            q1,
            q2,
            q3,
            q4,
            roll,
            pitch,
            yaw,
            xacc,
            yacc,
            zacc,
            xgyro,
            ygyro,
            zgyro,
            lat: place.latitude_deg as f32,
            lon: place.longitude_deg as f32,
            alt: place.altitude_amsl_m as f32,
            vn: (state.speed_mps * cos) as f32,
            ve: (state.speed_mps * sin) as f32,
            vd: (0.0 - state.climb_mps) as f32,
            lat_int,
            lon_int,
            ..SIM_STATE_DATA::DEFAULT
        })
    }

    /// Above the ground, which is level with home, as far as it reaches, cm.
    fn distance_sensor(&self) -> Message {
        const REACH_CM: f64 = 5000.0;
        let height_m = self.flight.state().altitude_m - self.flight.home().altitude_m;
        let height_cm = (100.0 * height_m).round().max(0.0);
        Message::DISTANCE_SENSOR(DISTANCE_SENSOR_DATA {
            time_boot_ms: boot_ms(self.time),
            min_distance: 20,
            max_distance: REACH_CM as u16,
            current_distance: height_cm.min(REACH_CM) as u16,
            mavtype: MavDistanceSensor::MAV_DISTANCE_SENSOR_LASER,
            orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
            covariance: u8::MAX,
            // 1: nothing within reach.
            signal_quality: if height_cm > REACH_CM { 1 } else { 100 },
            ..DISTANCE_SENSOR_DATA::DEFAULT
        })
    }

    fn terrain_report(&self) -> Message {
        let (lat, lon) = e7(&self.place());
        self.terrain_report_at(lat, lon)
    }

    /// TERRAIN_REPORT of a place (1e-7 deg): the ground is level with home, and nothing is loaded.
    pub(crate) fn terrain_report_at(&self, lat: i32, lon: i32) -> Message {
        let home_m = self.flight.home().altitude_m;
        Message::TERRAIN_REPORT(TERRAIN_REPORT_DATA {
            lat,
            lon,
            terrain_height: (self.frame.origin().altitude_amsl_m + home_m) as f32,
            current_height: (self.flight.estimate().altitude_m - home_m) as f32,
            ..TERRAIN_REPORT_DATA::DEFAULT
        })
    }

    fn estimator_status(&self) -> Message {
        let (horizontal_m, vertical_m) = if self.has_fix() { (0.5, 0.5) } else { (f32::MAX, 0.5) };
        Message::ESTIMATOR_STATUS(ESTIMATOR_STATUS_DATA {
            time_usec: self.micros(),
            pos_horiz_accuracy: horizontal_m,
            pos_vert_accuracy: vertical_m,
            // EKF_STATUS_FLAGS has the same bits.
            flags: EstimatorStatusFlags::from_bits_truncate(self.estimator_flags()),
            ..ESTIMATOR_STATUS_DATA::DEFAULT
        })
    }

    /// HIGH_LATENCY2 (<https://mavlink.io/en/messages/common.html#HIGH_LATENCY2>): everything in a few bytes. Angles
    /// are in two degrees, speeds in 0.2 m/s, climbs in 0.1 m/s, distances in 10 m.
    fn high_latency_2(&self) -> Message {
        let (state, aim, place) = (self.flight.estimate(), self.flight.aim(), self.place());
        let (latitude, longitude) = e7(&place);
        let half_degrees = |angle_rad: f64| (angle_rad.to_degrees().rem_euclid(360.0) / 2.0) as u8;
        let fifths = |speed_mps: f64| (5.0 * speed_mps).round() as u8;
        let target_m = aim.place.map_or(0.0, |place_m| (place_m - state.position_m()).norm());
        let wind = self.world.wind_estimate();
        let battery = sensors::Charge::of(self.world.battery(), self.parameters);
        let mut failures = HlFailureFlag::empty();
        failures.set(HlFailureFlag::HL_FAILURE_FLAG_GPS, !self.has_fix());
        failures.set(HlFailureFlag::HL_FAILURE_FLAG_ENGINE, self.flight.is_armed() && !self.flight.is_engine_running());
        failures.set(HlFailureFlag::HL_FAILURE_FLAG_GEOFENCE, self.fence.breached != 0);
        let custom_mode = (self.rules.custom_mode)(self.flight.mode());
        Message::HIGH_LATENCY2(HIGH_LATENCY2_DATA {
            timestamp: boot_ms(self.time),
            latitude,
            longitude,
            // A PX4 has its main and its sub mode in the upper half.
            custom_mode: if custom_mode > 0xFFFF { (custom_mode >> 16) as u16 } else { custom_mode as u16 },
            altitude: place.altitude_amsl_m.round() as i16,
            target_altitude: (self.frame.origin().altitude_amsl_m + aim.altitude_m).round() as i16,
            target_distance: (target_m / 10.0).round() as u16,
            wp_num: self.autopilot.session.progress.told(),
            failure_flags: failures,
            mavtype: MavType::MAV_TYPE_FIXED_WING,
            autopilot: self.rules.autopilot,
            heading: half_degrees(self.flight.heading_rad()),
            target_heading: half_degrees(aim.course_rad),
            throttle: (100.0 * self.throttle()).round() as u8,
            airspeed: fifths(self.flight.equivalent_airspeed_mps()),
            airspeed_sp: fifths(aim.airspeed_mps),
            groundspeed: fifths(state.speed_mps),
            windspeed: fifths(wind.speed_mps()),
            wind_heading: half_degrees(wind.direction_rad()),
            temperature_air: self.readings().temperature_c.round() as i8,
            climb_rate: (10.0 * state.climb_mps).round() as i8,
            battery: battery.map_or(-1, |battery| battery.percent()),
            custom0: (self.rules.base_mode)(self.flight.mode(), self.flight.is_armed()).bits() as i8,
            ..HIGH_LATENCY2_DATA::DEFAULT
        })
    }
}

/// The output of the throttle, from 0.
const THROTTLE: usize = 2;

/// Latitude and longitude in 1e-7 degrees.
fn e7(place: &Geodetic) -> (i32, i32) {
    ((place.latitude_deg * 1e7).round() as i32, (place.longitude_deg * 1e7).round() as i32)
}
