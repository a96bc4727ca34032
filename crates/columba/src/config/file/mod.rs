//! A scenario file as it is written: one struct for each table, with the defaults of what it leaves out. The larger
//! tables have files of their own.

mod autopilot;
mod dynamics;
mod link;
mod pattern;

pub use autopilot::AutopilotTable;
pub use dynamics::DynamicsTable;
pub use link::{LinkTable, PortsKey, SetpointDialect};
pub use pattern::{Pattern, PatternTable};

use super::airframe::{AirframeKey, AirframesTable};
use super::obstacles::{ObstacleTable, ObstaclesTable};
use super::parameters::ParametersTable;
use crate::flying::GroundSettings;
use controller::{LawSettings, LookAheadSettings, WeightSettings};
use optimizer::OptimizerSettings;
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

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

impl ScenarioFile {
    /// How many vehicles there are, once a swarm file has been read.
    pub fn count(&self) -> usize {
        self.vehicle.len().max(self.vehicles.as_ref().map_or(0, PatternTable::count))
    }
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

/// Where a run is written.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputTable {
    /// The run's folder; `runs/<name>` where absent.
    pub folder: Option<String>,
}
