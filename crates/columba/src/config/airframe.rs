//! Airframes: what `[dynamics]` and the vehicles' cruise start from. One by its name, a file of one's own, or a table
//! in the scenario.

use super::locate::line_at;
use flight_model::{Airframe, Limits, TimeConstants};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use sim_vehicle::Personality;
use std::fmt;
use std::path::Path;

/// What a scenario says of its airframe.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum AirframeKey {
    /// The name of one, or the path of a file with a table `[airframe]`.
    Name(String),
    /// One of its own.
    Table(Box<AirframeTable>),
}

/// `[airframe]`: what differs from another one.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct AirframeTable {
    /// The name of the other; `plane` where left out.
    base: Option<String>,
    cruise_speed_mps: Option<f64>,
    loiter_radius_m: Option<f64>,
    speed_time_constant_s: Option<f64>,
    course_time_constant_s: Option<f64>,
    altitude_time_constant_a_s: Option<f64>,
    altitude_time_constant_b_s: Option<f64>,
    speed_min_mps: Option<f64>,
    speed_max_mps: Option<f64>,
    climb_min_mps: Option<f64>,
    climb_max_mps: Option<f64>,
    lateral_overload_max: Option<f64>,
    gravity_mps2: Option<f64>,
}

/// A file of one's own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AirframeFile {
    airframe: AirframeTable,
}

/// The paper's UAV.
const PAPER: &str = "paper";
/// The plane that an autopilot's simulator flies by default.
pub const PLANE: &str = "plane";

impl AirframeKey {
    /// How messages call it.
    pub fn name(&self) -> &str {
        match self {
            Self::Name(name) => name,
            Self::Table(_) => "[airframe]",
        }
    }

    /// Whether it is the paper's.
    pub fn is_paper(&self) -> bool {
        matches!(self, Self::Name(name) if name == PAPER)
    }

    /// The airframe of an autopilot; paths are relative to a folder. What is wrong otherwise.
    pub fn resolve(&self, folder: &Path, personality: Personality) -> Result<Airframe, String> {
        match self {
            Self::Table(table) => table.resolve(personality),
            Self::Name(name) => match named(name, personality) {
                Some(airframe) => Ok(airframe),
                None => read(&folder.join(name), name)?.resolve(personality),
            },
        }
    }
}

impl AirframeTable {
    fn resolve(&self, personality: Personality) -> Result<Airframe, String> {
        let base = self.base.as_deref().unwrap_or(PLANE);
        let mut airframe = named(base, personality)
            .ok_or_else(|| format!("airframe.base = {base:?}: must be \"{PAPER}\" or \"{PLANE}\""))?;
        let TimeConstants { speed_s, course_s, altitude_a_s, altitude_b_s } = &mut airframe.dynamics.time_constants;
        let Limits { speed_min_mps, speed_max_mps, climb_min_mps, climb_max_mps, lateral_overload_max, gravity_mps2 } =
            &mut airframe.dynamics.limits;
        for (value, own) in [
            (&mut airframe.cruise_speed_mps, self.cruise_speed_mps),
            (&mut airframe.loiter_radius_m, self.loiter_radius_m),
            (speed_s, self.speed_time_constant_s),
            (course_s, self.course_time_constant_s),
            (altitude_a_s, self.altitude_time_constant_a_s),
            (altitude_b_s, self.altitude_time_constant_b_s),
            (speed_min_mps, self.speed_min_mps),
            (speed_max_mps, self.speed_max_mps),
            (climb_min_mps, self.climb_min_mps),
            (climb_max_mps, self.climb_max_mps),
            (lateral_overload_max, self.lateral_overload_max),
            (gravity_mps2, self.gravity_mps2),
        ] {
            *value = own.unwrap_or(*value);
        }
        Ok(airframe)
    }
}

fn named(name: &str, personality: Personality) -> Option<Airframe> {
    match (name, personality) {
        (PAPER, _) => Some(Airframe::paper()),
        (PLANE, Personality::Px4) => Some(Airframe::px4_plane()),
        (PLANE, _) => Some(Airframe::plane()),
        _ => None,
    }
}

fn read(path: &Path, name: &str) -> Result<AirframeTable, String> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        let what =
            if error.kind() == std::io::ErrorKind::NotFound { "file not found".to_owned() } else { error.to_string() };
        format!("airframe {name:?}: {what}: must be \"{PAPER}\", \"{PLANE}\" or a file with a table [airframe]")
    })?;
    toml_edit::de::from_str::<AirframeFile>(&text).map(|file| file.airframe).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(&text, span.start));
        format!("{}:{line}: {}", path.display(), error.message())
    })
}

/// What an airframe sets of a scenario, as TOML.
pub fn toml(airframe: &Airframe) -> String {
    let TimeConstants { speed_s, course_s, altitude_a_s, altitude_b_s } = airframe.dynamics.time_constants;
    let Limits { speed_min_mps, speed_max_mps, climb_min_mps, climb_max_mps, lateral_overload_max, gravity_mps2 } =
        airframe.dynamics.limits;
    let dynamics = [
        ("speed_time_constant_s", speed_s),
        ("course_time_constant_s", course_s),
        ("altitude_time_constant_a_s", altitude_a_s),
        ("altitude_time_constant_b_s", altitude_b_s),
        ("speed_min_mps", speed_min_mps),
        ("speed_max_mps", speed_max_mps),
        ("climb_min_mps", climb_min_mps),
        ("climb_max_mps", climb_max_mps),
        ("lateral_overload_max", lateral_overload_max),
        ("gravity_mps2", gravity_mps2),
    ];
    let autopilot = [("cruise_speed_mps", airframe.cruise_speed_mps), ("loiter_radius_m", airframe.loiter_radius_m)];
    let lines = |table: &str, values: &[(&str, f64)]| {
        let lines: String = values.iter().map(|(key, value)| format!("{key} = {value:?}\n")).collect();
        format!("[{table}]\n{lines}")
    };
    lines("dynamics", &dynamics) + &lines("autopilot", &autopilot)
}

impl<'de> Deserialize<'de> for AirframeKey {
    /// By hand: of an untagged value nobody would tell which key is wrong.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Key;

        impl<'de> Visitor<'de> for Key {
            type Value = AirframeKey;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("string or table")
            }

            fn visit_str<E>(self, name: &str) -> Result<AirframeKey, E> {
                Ok(AirframeKey::Name(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AirframeKey, A::Error> {
                AirframeTable::deserialize(MapAccessDeserializer::new(map))
                    .map(|table| AirframeKey::Table(Box::new(table)))
            }
        }

        deserializer.deserialize_any(Key)
    }
}
