//! Airframes: what `[dynamics]` and the vehicles' cruise start from. One by its name, a file of one's own, or a table
//! in the scenario.

use super::locate::line_at;
use flight_model::{Airframe, Limits, PlantSettings, RangeError, Response, TimeConstants};
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
    speed_gain: Option<f64>,
    speed_dead_time_s: Option<f64>,
    course_dead_time_s: Option<f64>,
    altitude_dead_time_s: Option<f64>,
    course_reference_speed_mps: Option<f64>,
    acceleration_max_mps2: Option<f64>,
    course_step_max_deg: Option<f64>,
    turn_share: Option<f64>,
    /// What a simulated vehicle flies; where left out, the plant of the base, unless a constant of Eq. 1 is given.
    flies: Option<Flies>,
    plant: Option<PlantTable>,
}

/// One of `[[airframes]]`.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AirframesTable {
    /// Numbers of vehicles from one: `"2-4, 7"`.
    pub vehicles: String,
    /// Theirs.
    pub airframe: AirframeKey,
}

/// What a simulated vehicle of an airframe flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
enum Flies {
    #[serde(rename = "plant")]
    Plant,
    #[serde(rename = "equation-1")]
    Equation1,
}

/// `[airframe.plant]`: what differs from the plant of the base.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlantTable {
    air_temperature_offset_k: Option<f64>,
    speed_loop_dead_time_s: Option<f64>,
    acceleration_max_mps2: Option<f64>,
    deceleration_max_mps2: Option<f64>,
    push_s: Option<f64>,
    push_frequency_radps: Option<f64>,
    push_damping: Option<f64>,
    speed_frequency_radps: Option<f64>,
    speed_damping: Option<f64>,
    speed_standing_error_mps: Option<f64>,
    course_loop_dead_time_s: Option<f64>,
    bank_per_error: Option<f64>,
    bank_frequency_radps: Option<f64>,
    bank_damping: Option<f64>,
    bank_rate_max_radps: Option<f64>,
    lift_frequency_radps: Option<f64>,
    lift_damping: Option<f64>,
    turn_share_first: Option<f64>,
    turn_share_settled: Option<f64>,
    slip_frequency_radps: Option<f64>,
    slip_damping: Option<f64>,
    altitude_loop_dead_time_s: Option<f64>,
    altitude_smoothing_s: Option<f64>,
    altitude_frequency_radps: Option<f64>,
    altitude_damping: Option<f64>,
    pitch_dead_time_s: Option<f64>,
    pitch_per_speed_error: Option<f64>,
    pitch_per_acceleration: Option<f64>,
    pitch_washout_s: Option<f64>,
    pitch_load_max_mps2: Option<f64>,
    pitch_frequency_radps: Option<f64>,
    pitch_damping: Option<f64>,
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
/// That of PX4's simulator, whatever the vehicle passes for.
const PX4_PLANE: &str = "px4-plane";
/// Their names, as messages list them.
const NAMES: &str = "\"paper\", \"plane\", \"px4-plane\"";

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
        let mut airframe =
            named(base, personality).ok_or_else(|| format!("airframe.base = {base:?}: must be {NAMES}"))?;
        let TimeConstants { speed_s, course_s, altitude_a_s, altitude_b_s } = &mut airframe.dynamics.time_constants;
        let Limits { speed_min_mps, speed_max_mps, climb_min_mps, climb_max_mps, lateral_overload_max, gravity_mps2 } =
            &mut airframe.dynamics.limits;
        let Response { speed_gain, speed_dead_time_s, course_dead_time_s, altitude_dead_time_s, turn_share, .. } =
            &mut airframe.dynamics.response;
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
            (speed_gain, self.speed_gain),
            (speed_dead_time_s, self.speed_dead_time_s),
            (course_dead_time_s, self.course_dead_time_s),
            (altitude_dead_time_s, self.altitude_dead_time_s),
            (turn_share, self.turn_share),
        ] {
            *value = own.unwrap_or(*value);
        }
        if let Some(speed_mps) = self.course_reference_speed_mps {
            airframe.dynamics.response.course_reference_speed_mps = (speed_mps != 0.0).then_some(speed_mps);
        }
        let response = &mut airframe.dynamics.response;
        response.acceleration_max_mps2 = self.acceleration_max_mps2.map_or(response.acceleration_max_mps2, or_infinite);
        response.course_step_max_rad =
            self.course_step_max_deg.map_or(response.course_step_max_rad, |step_deg| step_deg.to_radians());
        airframe.plant = self.plant(base, airframe.plant)?;
        Ok(airframe)
    }

    /// The plant that is flown, from that of the base; none: Eq. 1.
    fn plant(&self, base: &str, of_base: Option<PlantSettings>) -> Result<Option<PlantSettings>, String> {
        let own = self.plant.as_ref();
        let flies = self.flies.unwrap_or_else(|| {
            let is_plant = own.is_some() || of_base.is_some() && !self.has_constants_of_equation_1();
            if is_plant { Flies::Plant } else { Flies::Equation1 }
        });
        if flies == Flies::Equation1 {
            return match own {
                Some(_) => {
                    Err("airframe.flies = \"equation-1\": must be left out where there is [airframe.plant]".into())
                }
                None => Ok(None),
            };
        }
        let Some(mut plant) = of_base else {
            return Err(format!("airframe.base = {base:?} has no plant: must be \"{PLANE}\" or \"{PX4_PLANE}\""));
        };
        if let Some(table) = own {
            table.change(&mut plant);
        }
        let told = |error: &RangeError| format!("airframe.plant.{error}");
        let faults: Vec<String> = plant.check().iter().map(told).collect();
        if faults.is_empty() { Ok(Some(plant)) } else { Err(faults.join("\n")) }
    }

    fn has_constants_of_equation_1(&self) -> bool {
        [
            self.speed_time_constant_s,
            self.course_time_constant_s,
            self.altitude_time_constant_a_s,
            self.altitude_time_constant_b_s,
            self.speed_gain,
            self.speed_dead_time_s,
            self.course_dead_time_s,
            self.altitude_dead_time_s,
            self.course_reference_speed_mps,
        ]
        .iter()
        .any(Option::is_some)
    }
}

impl PlantTable {
    fn change(&self, plant: &mut PlantSettings) {
        let PlantSettings { speed, course, altitude, pitch, air_temperature_offset_k } = plant;
        for (value, own) in [
            (air_temperature_offset_k, self.air_temperature_offset_k),
            (&mut speed.dead_time_s, self.speed_loop_dead_time_s),
            (&mut speed.acceleration_max_mps2, self.acceleration_max_mps2),
            (&mut speed.deceleration_max_mps2, self.deceleration_max_mps2),
            (&mut speed.push_s, self.push_s),
            (&mut speed.push_frequency_radps, self.push_frequency_radps),
            (&mut speed.push_damping, self.push_damping),
            (&mut speed.frequency_radps, self.speed_frequency_radps),
            (&mut speed.damping, self.speed_damping),
            (&mut speed.standing_error_mps, self.speed_standing_error_mps),
            (&mut course.dead_time_s, self.course_loop_dead_time_s),
            (&mut course.bank_per_error, self.bank_per_error),
            (&mut course.bank_frequency_radps, self.bank_frequency_radps),
            (&mut course.bank_damping, self.bank_damping),
            (&mut course.bank_rate_max_radps, self.bank_rate_max_radps),
            (&mut course.lift_frequency_radps, self.lift_frequency_radps),
            (&mut course.lift_damping, self.lift_damping),
            (&mut course.turn_share_first, self.turn_share_first),
            (&mut course.turn_share_settled, self.turn_share_settled),
            (&mut course.slip_frequency_radps, self.slip_frequency_radps),
            (&mut course.slip_damping, self.slip_damping),
            (&mut altitude.dead_time_s, self.altitude_loop_dead_time_s),
            (&mut altitude.smoothing_s, self.altitude_smoothing_s),
            (&mut altitude.frequency_radps, self.altitude_frequency_radps),
            (&mut altitude.damping, self.altitude_damping),
            (&mut pitch.dead_time_s, self.pitch_dead_time_s),
            (&mut pitch.per_speed_error, self.pitch_per_speed_error),
            (&mut pitch.per_acceleration, self.pitch_per_acceleration),
            (&mut pitch.washout_s, self.pitch_washout_s),
            (&mut pitch.load_max_mps2, self.pitch_load_max_mps2),
            (&mut pitch.frequency_radps, self.pitch_frequency_radps),
            (&mut pitch.damping, self.pitch_damping),
        ] {
            *value = own.unwrap_or(*value);
        }
    }
}

fn named(name: &str, personality: Personality) -> Option<Airframe> {
    match (name, personality) {
        (PAPER, _) => Some(Airframe::paper()),
        (PLANE, Personality::Px4) | (PX4_PLANE, _) => Some(Airframe::px4_plane()),
        (PLANE, _) => Some(Airframe::plane()),
        _ => None,
    }
}

fn read(path: &Path, name: &str) -> Result<AirframeTable, String> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        let what =
            if error.kind() == std::io::ErrorKind::NotFound { "file not found".to_owned() } else { error.to_string() };
        format!("airframe {name:?}: {what}: must be {NAMES} or a file with a table [airframe]")
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
    let Response {
        speed_gain,
        speed_dead_time_s,
        course_dead_time_s,
        altitude_dead_time_s,
        course_reference_speed_mps,
        acceleration_max_mps2,
        course_step_max_rad,
        turn_share,
    } = airframe.dynamics.response;
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
        ("speed_gain", speed_gain),
        ("speed_dead_time_s", speed_dead_time_s),
        ("course_dead_time_s", course_dead_time_s),
        ("altitude_dead_time_s", altitude_dead_time_s),
        ("course_reference_speed_mps", course_reference_speed_mps.unwrap_or(0.0)),
        ("acceleration_max_mps2", Some(acceleration_max_mps2).filter(|limit| limit.is_finite()).unwrap_or(0.0)),
        ("course_step_max_deg", course_step_max_rad.to_degrees()),
        ("turn_share", turn_share),
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

/// A limit as files have it: 0 is none.
pub fn or_infinite(limit: f64) -> f64 {
    if limit == 0.0 { f64::INFINITY } else { limit }
}
