//! A scenario file as it is written: one struct for each table, with the defaults of what it leaves out.

use super::airframe::AirframeKey;
use super::fleet::AirframesTable;
use super::obstacles::{ObstacleTable, ObstaclesTable};
use super::parameters::ParametersTable;
use super::swarm::Place;
use crate::flying::GroundSettings;
use controller::{LawSettings, LookAheadSettings, WeightSettings};
use flight_model::{Dynamics, Limits, RangeError, Response, TimeConstants};
use mavlink_bridge::{ImpairmentSettings, MulticastScope};
use optimizer::OptimizerSettings;
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use sim_vehicle::{PortLayout, TelemetryRates, VehicleSettings};
use std::path::PathBuf;
use std::time::Duration;

/// The whole file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// What the law, the weights and the look-ahead start from.
    #[serde(default)]
    pub preset: Preset,
    /// What is flown, and for how long.
    pub scenario: ScenarioTable,
    /// What the flock is to settle on.
    pub flock: FlockTable,
    /// Starts one by one.
    #[serde(default, rename = "vehicle")]
    pub vehicle: Vec<VehicleTable>,
    /// Or starts by a pattern.
    pub vehicles: Option<PatternTable>,
    /// The circles.
    #[serde(default, rename = "obstacle")]
    pub obstacle: Vec<ObstacleTable>,
    /// Or circles at random.
    pub obstacles: Option<ObstaclesTable>,
    /// The flocking law (Eq. 4-12).
    #[serde(default)]
    pub law: LawSettings,
    /// The weights that the optimiser picks.
    #[serde(default)]
    pub weights: WeightSettings,
    /// The predicted flight on which a choice is judged.
    #[serde(default)]
    pub look_ahead: LookAheadSettings,
    /// Who picks the weights.
    #[serde(default)]
    pub optimizer: OptimizerSettings,
    /// What the dynamics start from; the paper's where absent.
    #[serde(default)]
    pub airframe: Option<AirframeKey>,
    /// Airframes of single vehicles.
    #[serde(default)]
    pub airframes: Vec<AirframesTable>,
    /// How vehicles fly (Eq. 1 and 3).
    #[serde(default)]
    pub dynamics: DynamicsTable,
    /// What they do beside flying.
    #[serde(default)]
    pub autopilot: AutopilotTable,
    /// The vehicles' parameters at the start.
    #[serde(default)]
    pub parameters: ParametersTable,
    /// The link.
    #[serde(default)]
    pub link: LinkTable,
    /// How the ground station waits for vehicles.
    #[serde(default)]
    pub ground: GroundSettings,
    /// Where a run is written.
    #[serde(default)]
    pub output: OutputTable,
}

/// Which reading of the paper the law, the weights and the look-ahead start from; the tables of the file then change
/// it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// What flies best, by the evidence in docs/.
    #[default]
    Default,
    /// The readings of the paper that make it work as described, with its printed values.
    Paper,
    /// The letter of the paper.
    Literal,
}

/// What is flown, and for how long.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioTable {
    /// The flight's name, which names its folder too.
    pub name: String,
    /// T_max, s; the last control period is flown whole.
    pub duration_s: f64,
    /// T, s.
    #[serde(default = "half")]
    pub control_period_s: f64,
    /// Seed of every random number.
    #[serde(default = "one", deserialize_with = "seed")]
    pub seed: u64,
    /// Where on Earth the local frame is.
    #[serde(default)]
    pub origin: OriginTable,
}

fn half() -> f64 {
    0.5
}

fn one() -> u64 {
    1
}

/// A whole number, or one in quotes: TOML's own end at 2^63.
fn seed<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    struct Seed;
    impl Visitor<'_> for Seed {
        type Value = u64;

        fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            formatter.write_str("u64")
        }

        fn visit_u64<E: Error>(self, seed: u64) -> Result<u64, E> {
            Ok(seed)
        }

        fn visit_i64<E: Error>(self, seed: i64) -> Result<u64, E> {
            u64::try_from(seed).map_err(|_| E::invalid_value(Unexpected::Signed(seed), &self))
        }

        fn visit_str<E: Error>(self, seed: &str) -> Result<u64, E> {
            seed.parse().map_err(|_| E::invalid_type(Unexpected::Str(seed), &self))
        }
    }
    deserializer.deserialize_any(Seed)
}

/// The local origin, WGS-84.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OriginTable {
    /// WGS-84 latitude, degrees.
    pub latitude_deg: f64,
    /// WGS-84 longitude, degrees.
    pub longitude_deg: f64,
    /// Altitude above mean sea level, m.
    pub altitude_amsl_m: f64,
}

impl Default for OriginTable {
    fn default() -> Self {
        Self { latitude_deg: 39.98, longitude_deg: 116.34, altitude_amsl_m: 50.0 }
    }
}

/// What the flock is to settle on.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FlockTable {
    /// V_e, m/s.
    pub expected_speed_mps: f64,
    /// Degrees from north towards east.
    #[serde(default)]
    pub expected_course_deg: f64,
    /// h_e, m above the origin.
    pub expected_altitude_m: f64,
}

/// One vehicle's start, in the air.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleTable {
    /// North of the origin, m.
    pub x_m: f64,
    /// East of the origin, m.
    pub y_m: f64,
    /// Above the origin, m.
    pub altitude_m: f64,
    /// Horizontal speed, m/s.
    pub speed_mps: f64,
    /// Degrees from north towards east.
    #[serde(default)]
    pub course_deg: f64,
    /// Its own airframe; that of all where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub airframe: Option<AirframeKey>,
}

/// Many vehicles' starts.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PatternTable {
    /// How many; as many as the file has where absent.
    pub count: Option<usize>,
    /// How they are laid out.
    #[serde(default)]
    pub pattern: Pattern,
    /// The file of [`Pattern::File`].
    pub file: Option<PathBuf>,
    /// What is in it, once it has been read.
    #[serde(skip)]
    pub places: Vec<Place>,
    /// Between neighbours, m.
    #[serde(default = "twelve")]
    pub spacing_m: f64,
    /// Northing of the pattern's front, m.
    #[serde(default)]
    pub x_m: f64,
    /// Easting of the pattern's middle, m.
    #[serde(default)]
    pub y_m: f64,
    /// Above the origin, m; the expected one where absent.
    pub altitude_m: Option<f64>,
    /// Horizontal speed, m/s; the expected one where absent.
    pub speed_mps: Option<f64>,
    /// Degrees from north towards east; the expected one where absent.
    pub course_deg: Option<f64>,
    /// Each altitude differs from that by up to so much, at random by the seed, m.
    #[serde(default)]
    pub altitude_spread_m: f64,
    /// The same of speeds, m/s.
    #[serde(default)]
    pub speed_spread_mps: f64,
    /// The same of courses, degrees.
    #[serde(default)]
    pub course_spread_deg: f64,
}

fn twelve() -> f64 {
    PatternTable::DEFAULT.spacing_m
}

impl ScenarioFile {
    /// How many vehicles there are, once a swarm file has been read.
    pub fn count(&self) -> usize {
        self.vehicle.len().max(self.vehicles.as_ref().map_or(0, PatternTable::count))
    }
}

impl PatternTable {
    /// How many, once a swarm file has been read.
    pub fn count(&self) -> usize {
        self.count.unwrap_or(self.places.len())
    }

    /// One vehicle at the origin.
    pub const DEFAULT: Self = Self {
        count: Some(1),
        pattern: Pattern::Grid,
        file: None,
        places: Vec::new(),
        spacing_m: 12.0,
        x_m: 0.0,
        y_m: 0.0,
        altitude_m: None,
        speed_mps: None,
        course_deg: None,
        altitude_spread_m: 0.0,
        speed_spread_mps: 0.0,
        course_spread_deg: 0.0,
    };
}

/// How the starts of many vehicles are laid out; their centre is at (x_m, y_m), their front along the course.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Abreast, square to the course.
    Line,
    /// Rows abreast, as square as the count allows.
    #[default]
    Grid,
    /// A V open to the rear.
    Wedge,
    /// Anywhere in a square as large as the grid's, no two nearer than half the spacing; by the scenario's seed.
    Random,
    /// As a file says, in the form of ArduPilot's swarminit.txt.
    #[value(skip)]
    File,
}

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
            },
        }
    }
}

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

/// The MAVLink link between vehicles and controller.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LinkTable {
    /// Address that everything binds to.
    pub host: String,
    /// First vehicle's port; the others follow. 0: any free ports. Where absent: 14600, or any free ports for a run in
    /// lockstep, which nobody else needs to find.
    pub vehicle_port: Option<u16>,
    /// Vehicles on one port, 1 to 250; frames find theirs by the target system.
    pub vehicles_per_port: usize,
    /// Controller's port, to which vehicles send their telemetry. Where absent: 14550, or any free port for a run.
    pub ground_port: Option<u16>,
    /// Which ports vehicles have.
    pub ports: PortsKey,
    /// With an autopilot's ports, the instance of the first vehicle.
    pub instance: u16,
    /// Whether vehicles are members of ArduPilot's multicast group too.
    pub multicast: bool,
    /// How setpoints are written in real time.
    pub setpoints: SetpointDialect,
    /// Share of datagrams that are lost, each way.
    pub loss: f64,
    /// Share that arrives twice.
    pub duplication: f64,
    /// Share that is overtaken by the next.
    pub reordering: f64,
    /// Delay of every datagram, ms, each way.
    pub delay_ms: f64,
    /// What is added to it at random, up to, ms.
    pub jitter_ms: f64,
}

/// Which ports `columba vehicles` opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum PortsKey {
    /// UDP 14600 and up, as `vehicle_port` and `vehicles_per_port` say.
    #[default]
    Columba,
    /// Those of ArduPilot's SITL: TCP 5760 + 10 i, telemetry to UDP 14550 + 10 i.
    ArduPilot,
    /// Those of PX4's SITL: UDP 14580 + i to 14540 + i, and 18570 + i to 14550.
    Px4,
}

impl LinkTable {
    /// The ports as a host has them.
    pub fn layout(&self) -> PortLayout {
        match self.ports {
            PortsKey::Columba => PortLayout::Columba,
            PortsKey::ArduPilot => PortLayout::ArduPilot { instance: self.instance },
            PortsKey::Px4 => PortLayout::Px4 { instance: self.instance },
        }
    }

    /// How far multicast reaches, if there is any: no further than the other ports.
    pub fn multicast(&self) -> Option<MulticastScope> {
        let is_local = self.host.parse().is_ok_and(|host: std::net::IpAddr| host.is_loopback());
        self.multicast.then_some(if is_local { MulticastScope::Host } else { MulticastScope::Network })
    }
}

/// How setpoints are written in real time; a lockstep run always uses the stamped local-ned form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SetpointDialect {
    /// COMMAND_INT GUIDED_CHANGE_SPEED, _ALTITUDE and _HEADING, as ArduPlane takes them.
    #[default]
    Arduplane,
    /// SET_POSITION_TARGET_LOCAL_NED with velocity and altitude.
    LocalNed,
}

impl LinkTable {
    /// What spoils the link, the same each way.
    pub fn impairment(&self) -> ImpairmentSettings {
        ImpairmentSettings {
            loss: self.loss,
            duplication: self.duplication,
            reordering: self.reordering,
            delay_ms: self.delay_ms,
            jitter_ms: self.jitter_ms,
        }
    }
}

impl Default for LinkTable {
    fn default() -> Self {
        Self {
            host: "127.0.0.1".to_owned(),
            vehicle_port: None,
            vehicles_per_port: 1,
            ground_port: None,
            ports: PortsKey::default(),
            instance: 0,
            multicast: false,
            setpoints: SetpointDialect::default(),
            loss: 0.0,
            duplication: 0.0,
            reordering: 0.0,
            delay_ms: 0.0,
            jitter_ms: 0.0,
        }
    }
}

/// Where a run is written.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputTable {
    /// The run's folder; `runs/<name>` where absent.
    pub folder: Option<String>,
}
