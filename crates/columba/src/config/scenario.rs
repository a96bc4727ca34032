//! A checked scenario: what flies.

use super::file::{AutopilotTable, Pattern, PatternTable, Preset, ScenarioFile, SetpointDialect};
use super::{Provenance, patterns};
use controller::{ControllerSettings, Expected, FlockSettings, Obstacle};
use flight_model::{Dynamics, Geodetic, Limits, LocalFrame, State, TimeConstants};
use mavlink_bridge::ImpairmentSettings;
use optimizer::{Algorithm, OptimizerSettings};
use sim_vehicle::{ParameterFile, Personality};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

/// A flight as it is to be flown: every value is in its range.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The flight's name.
    pub name: String,
    /// Seed of every random number.
    pub seed: u64,
    /// What the controller's settings started from.
    pub preset: Preset,
    /// Flight time asked for; [`ticks`](Scenario::ticks) says what is flown.
    pub duration: Duration,
    /// T.
    pub control_period: Duration,
    /// Step at which vehicles are integrated and judged.
    pub integration_step: Duration,
    /// The local frame.
    pub frame: LocalFrame,
    /// What the flock is to settle on.
    pub expected: Expected,
    /// Where and how each vehicle starts.
    pub starts: Vec<State>,
    /// The circles.
    pub obstacles: Vec<Obstacle>,
    /// How vehicles fly.
    pub dynamics: Dynamics,
    /// Law, weights and look-ahead.
    pub controller: ControllerSettings,
    /// Who picks the weights, and how.
    pub optimizer: OptimizerSettings,
    /// What vehicles do beside flying.
    pub autopilot: AutopilotTable,
    /// The vehicles' parameters at the start, by name.
    pub parameters: BTreeMap<String, f32>,
    /// Parameter files, over which these lie.
    pub parameter_files: ParameterFile,
    /// The link.
    pub link: Link,
    /// The run's folder.
    pub folder: PathBuf,
    /// Where the settings came from, for what proves wrong only when it is tried.
    pub provenance: Provenance,
}

/// First vehicle's port where others may want to find it.
pub const VEHICLE_PORT: u16 = 14600;
/// Where ground stations listen, and so where vehicles send their telemetry unasked.
pub const GROUND_PORT: u16 = 14550;

/// The link between vehicles and controller.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Address that everything binds to.
    pub host: IpAddr,
    /// First vehicle's port; 0: any free ports.
    pub vehicle_port: Option<u16>,
    /// Vehicles on one port.
    pub vehicles_per_port: usize,
    /// Controller's port; 0: any free one. Each further network of vehicles has the next.
    pub ground_port: Option<u16>,
    /// How setpoints are written in real time.
    pub setpoints: SetpointDialect,
    /// The same each way.
    pub impairment: ImpairmentSettings,
}

/// What the command line changes of a file.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// `--seed`.
    pub seed: Option<u64>,
    /// `--preset`.
    pub preset: Option<Preset>,
    /// `--optimizer`.
    pub algorithm: Option<Algorithm>,
    /// `--duration`, s.
    pub duration_s: Option<f64>,
    /// `--out`.
    pub folder: Option<PathBuf>,
    /// `--vehicle-port`.
    pub vehicle_port: Option<u16>,
    /// `--ground-port`.
    pub ground_port: Option<u16>,
    /// `--loss`, a share.
    pub loss: Option<f64>,
    /// `--count`: replaces the file's vehicles by so many in a pattern.
    pub count: Option<usize>,
    /// `--on-ground`.
    pub on_ground: bool,
    /// `--personality`.
    pub personality: Option<Personality>,
    /// `--pattern`: how they are laid out.
    pub pattern: Option<Pattern>,
    /// `--swarm`: replaces the file's vehicles by those of a swarm file.
    pub swarm: Option<PathBuf>,
    /// `--per-port`.
    pub vehicles_per_port: Option<usize>,
    /// `--param`, each NAME and value; the last of a name counts.
    pub parameters: Vec<(String, f64)>,
    /// `--defaults`: parameter files after those of the file.
    pub parameter_files: Vec<PathBuf>,
}

impl Overrides {
    /// The keys that are changed, each with the flag and the value that change it.
    pub(super) fn flags(&self) -> Vec<(String, String)> {
        fn flag(key: &str, name: &str, value: Option<impl Display>) -> Option<(String, String)> {
            value.map(|value| (key.to_owned(), format!("{name} {value}")))
        }
        let swarm = self.swarm.as_ref().map(|file| file.display());
        let parameters = self
            .parameters
            .iter()
            .rev()
            .map(|(name, value)| Some((format!("parameters.{name}"), format!("--param {name}={value}"))));
        let folder = self.folder.as_ref().map(|folder| folder.display());
        [
            flag("scenario.seed", "--seed", self.seed),
            flag("scenario.duration_s", "--duration", self.duration_s),
            flag("output.folder", "--out", folder),
            flag("link.vehicle_port", "--vehicle-port", self.vehicle_port),
            flag("link.ground_port", "--ground-port", self.ground_port),
            flag("link.vehicles_per_port", "--per-port", self.vehicles_per_port),
            flag("link.loss", "--loss", self.loss),
            flag("vehicles", "--count", self.count),
            flag("vehicles.count", "--count", self.count),
            flag("autopilot.personality", "--personality", self.personality),
            flag("autopilot.on_ground", "--on-ground", self.on_ground.then_some("")),
            flag("vehicles", "--swarm", swarm),
        ]
        .into_iter()
        .chain(parameters)
        .flatten()
        .collect()
    }

    pub(super) fn apply(&self, file: &mut ScenarioFile) {
        let replace = |value: &mut Option<u16>, with: Option<u16>| *value = with.or(*value);
        replace(&mut file.link.vehicle_port, self.vehicle_port);
        replace(&mut file.link.ground_port, self.ground_port);
        file.autopilot.on_ground |= self.on_ground;
        file.autopilot.personality = self.personality.unwrap_or(file.autopilot.personality);
        file.scenario.seed = self.seed.unwrap_or(file.scenario.seed);
        file.scenario.duration_s = self.duration_s.unwrap_or(file.scenario.duration_s);
        file.preset = self.preset.unwrap_or(file.preset);
        file.optimizer.algorithm = self.algorithm.unwrap_or(file.optimizer.algorithm);
        file.link.loss = self.loss.unwrap_or(file.link.loss);
        file.link.vehicles_per_port = self.vehicles_per_port.unwrap_or(file.link.vehicles_per_port);
        file.parameters.values.extend(self.parameters.iter().cloned());
        if self.count.is_some() || self.swarm.is_some() {
            file.vehicle.clear();
            file.vehicles.get_or_insert(PatternTable::DEFAULT);
        }
        let Some(table) = &mut file.vehicles else { return };
        if let Some(swarm) = &self.swarm {
            (table.pattern, table.file, table.count) = (Pattern::File, Some(swarm.clone()), None);
        }
        table.count = self.count.or(table.count);
        if let Some(pattern) = self.pattern {
            (table.pattern, table.file) = (pattern, None);
        }
    }
}

impl Scenario {
    /// From a file whose settings are all in range.
    pub(super) fn new(file: ScenarioFile, provenance: Provenance) -> Self {
        let expected = Expected {
            speed_mps: file.flock.expected_speed_mps,
            course_rad: flight_model::wrap_pi(file.flock.expected_course_deg.to_radians()),
            altitude_m: file.flock.expected_altitude_m,
        };
        let origin = file.scenario.origin;
        let folder = file.output.folder.clone().map_or_else(|| default_folder(&file.scenario.name), PathBuf::from);
        Self {
            starts: starts(&file, &expected),
            obstacles: file
                .obstacle
                .iter()
                .map(|circle| Obstacle { x_m: circle.x_m, y_m: circle.y_m, radius_m: circle.radius_m })
                .collect(),
            seed: file.scenario.seed,
            preset: file.preset,
            duration: whole_ms(file.scenario.duration_s),
            control_period: whole_ms(file.scenario.control_period_s),
            integration_step: whole_ms(file.dynamics.integration_step_s),
            frame: LocalFrame::new(Geodetic {
                latitude_deg: origin.latitude_deg,
                longitude_deg: origin.longitude_deg,
                altitude_amsl_m: origin.altitude_amsl_m,
            }),
            expected,
            dynamics: dynamics(&file),
            controller: ControllerSettings { law: file.law, weights: file.weights, look_ahead: file.look_ahead },
            optimizer: file.optimizer,
            autopilot: file.autopilot,
            parameter_files: file.parameters.read,
            parameters: file.parameters.values.into_iter().map(|(name, value)| (name, value as f32)).collect(),
            link: Link {
                host: file.link.host.parse().unwrap_or(IpAddr::from([127, 0, 0, 1])),
                vehicle_port: file.link.vehicle_port,
                vehicles_per_port: file.link.vehicles_per_port,
                ground_port: file.link.ground_port,
                setpoints: file.link.setpoints,
                impairment: ImpairmentSettings {
                    loss: file.link.loss,
                    duplication: file.link.duplication,
                    reordering: file.link.reordering,
                    delay_ms: file.link.delay_ms,
                    jitter_ms: file.link.jitter_ms,
                },
            },
            folder,
            provenance,
            name: file.scenario.name,
        }
    }

    /// Control periods of the flight; the last one is flown whole.
    pub fn ticks(&self) -> u64 {
        let (duration, period) = (self.duration.as_millis(), self.control_period.as_millis().max(1));
        u64::try_from(duration.div_ceil(period)).unwrap_or(u64::MAX)
    }

    /// The flock that flies it.
    pub fn flock_settings(&self) -> FlockSettings {
        FlockSettings {
            controller: self.controller.clone(),
            optimizer: self.optimizer,
            seed: self.seed,
            control_period_s: self.control_period.as_secs_f64(),
            expected: self.expected,
            obstacles: self.obstacles.clone(),
            dynamics: self.dynamics,
        }
    }
}

fn starts(file: &ScenarioFile, expected: &Expected) -> Vec<State> {
    let state = |x_m: f64, y_m: f64, altitude_m: f64, speed_mps: f64, course_deg: f64| State {
        x_m,
        y_m,
        altitude_m,
        speed_mps,
        course_rad: flight_model::wrap_pi(course_deg.to_radians()),
        climb_mps: 0.0,
    };
    match &file.vehicles {
        Some(pattern) => {
            let like = state(
                0.0,
                0.0,
                pattern.altitude_m.unwrap_or(expected.altitude_m),
                pattern.speed_mps.unwrap_or(expected.speed_mps),
                pattern.course_deg.unwrap_or(expected.course_rad.to_degrees()),
            );
            patterns::starts(pattern, &like, file.scenario.seed)
        }
        None => file.vehicle.iter().map(|v| state(v.x_m, v.y_m, v.altitude_m, v.speed_mps, v.course_deg)).collect(),
    }
}

fn dynamics(file: &ScenarioFile) -> Dynamics {
    let table = &file.dynamics;
    Dynamics {
        time_constants: TimeConstants {
            speed_s: table.speed_time_constant_s,
            course_s: table.course_time_constant_s,
            altitude_a_s: table.altitude_time_constant_a_s,
            altitude_b_s: table.altitude_time_constant_b_s,
        },
        limits: Limits {
            speed_min_mps: table.speed_min_mps,
            speed_max_mps: table.speed_max_mps,
            climb_min_mps: table.climb_min_mps,
            climb_max_mps: table.climb_max_mps,
            lateral_overload_max: table.lateral_overload_max,
            gravity_mps2: table.gravity_mps2,
        },
    }
}

fn whole_ms(seconds: f64) -> Duration {
    Duration::from_millis((seconds * 1e3).round() as u64)
}

/// `runs/<name>`.
fn default_folder(name: &str) -> PathBuf {
    PathBuf::from("runs").join(file_name(name))
}

/// A name that a file can have, whatever a scenario's name holds.
pub fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' };
    name.trim().chars().map(safe).collect()
}
