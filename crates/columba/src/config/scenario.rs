//! A checked scenario: what flies.

use super::file::{AutopilotTable, Preset, ScenarioFile, SetpointDialect};
use super::{Provenance, patterns};
use crate::flying::GroundSettings;
use controller::{ControllerSettings, Expected, FlockSettings, Obstacle};
use flight_model::{Airframe, Dynamics, Geodetic, LocalFrame, PlantSettings, State};
use mavlink_bridge::{ImpairmentSettings, MulticastScope};
use optimizer::OptimizerSettings;
use sim_vehicle::{ParameterFile, PortLayout};
use std::collections::BTreeMap;
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
    /// How vehicles fly by Eq. 1: what the controller reckons with.
    pub dynamics: Dynamics,
    /// How simulated vehicles fly otherwise than by Eq. 1.
    pub plant: Option<PlantSettings>,
    /// The airframe of each vehicle that has one of its own; empty where none has.
    pub airframes: Vec<Option<Airframe>>,
    /// Law, weights and look-ahead.
    pub controller: ControllerSettings,
    /// Who picks the weights, and how.
    pub optimizer: OptimizerSettings,
    /// What vehicles do beside flying.
    pub autopilot: AutopilotTable,
    /// Parameter files widen the limits of the dynamics: they are of the vehicle that is to be flown, and not the
    /// paper's.
    pub files_shape_limits: bool,
    /// The vehicles' parameters at the start, by name.
    pub parameters: BTreeMap<String, f32>,
    /// Whether clients find all parameters of the real autopilot.
    pub stock_parameters: bool,
    /// Parameter files, which these override.
    pub parameter_files: ParameterFile,
    /// The link.
    pub link: Link,
    /// How the ground station waits for vehicles.
    pub ground: GroundSettings,
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
    /// Which ports vehicles have.
    pub layout: PortLayout,
    /// Whether they are members of a multicast group too.
    pub multicast: Option<MulticastScope>,
    /// How setpoints are written in real time.
    pub setpoints: SetpointDialect,
    /// The same each way.
    pub impairment: ImpairmentSettings,
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
        // A path need not be text.
        let folder = provenance.raw("output.folder").map(PathBuf::from);
        let folder = folder.or_else(|| file.output.folder.clone().map(PathBuf::from));
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
            dynamics: file.dynamics.dynamics(),
            plant: provenance.airframe(&file).and_then(Result::ok).and_then(|airframe| airframe.plant),
            airframes: super::fleet::airframes(&file, &provenance).unwrap_or_default(),
            controller: ControllerSettings { law: file.law, weights: file.weights, look_ahead: file.look_ahead },
            optimizer: file.optimizer,
            autopilot: file.autopilot,
            files_shape_limits: file.airframe.as_ref().is_some_and(|airframe| !airframe.is_paper()),
            // Vehicles with an autopilot's ports stand in for its simulator.
            stock_parameters: file.parameters.stock.unwrap_or(file.link.layout() != PortLayout::Columba)
                && file.autopilot.personality.has_stock_parameters(),
            parameter_files: file.parameters.read,
            parameters: file.parameters.values.into_iter().map(|(name, value)| (name, value as f32)).collect(),
            link: Link {
                host: file.link.host.parse().unwrap_or(IpAddr::from([127, 0, 0, 1])),
                vehicle_port: file.link.vehicle_port,
                vehicles_per_port: file.link.vehicles_per_port,
                ground_port: file.link.ground_port,
                layout: file.link.layout(),
                multicast: file.link.multicast(),
                setpoints: file.link.setpoints,
                impairment: file.link.impairment(),
            },
            ground: file.ground,
            folder: folder.unwrap_or_else(|| default_folder(&file.scenario.name)),
            provenance,
            name: file.scenario.name,
        }
    }

    /// Control periods of the flight; the last one is flown whole.
    pub fn ticks(&self) -> u64 {
        let (duration, period) = (self.duration.as_millis(), self.control_period.as_millis().max(1));
        u64::try_from(duration.div_ceil(period)).unwrap_or(u64::MAX)
    }

    /// The airframe of a vehicle that has one of its own.
    pub fn airframe_of(&self, index: usize) -> Option<&Airframe> {
        self.airframes.get(index).and_then(Option::as_ref)
    }

    /// How a vehicle flies by Eq. 1: what the controller reckons with.
    pub fn dynamics_of(&self, index: usize) -> Dynamics {
        self.airframe_of(index).map_or(self.dynamics, |own| own.dynamics)
    }

    /// The same where it is told speeds over ground: one with a plant finds the airspeed itself, and what its speed
    /// loop settles on is the speed asked for.
    pub fn dynamics_over_ground_of(&self, index: usize) -> Dynamics {
        let mut dynamics = self.dynamics_of(index);
        if self.plant_of(index).is_some() {
            dynamics.response.speed_gain = 1.0;
        }
        dynamics
    }

    /// How a simulated vehicle flies otherwise than by Eq. 1.
    pub fn plant_of(&self, index: usize) -> Option<PlantSettings> {
        self.airframe_of(index).map_or(self.plant, |own| own.plant)
    }

    /// The flock that flies it.
    pub fn flock_settings(&self) -> FlockSettings {
        self.flock_settings_with(|index| self.dynamics_of(index))
    }

    /// The same where its vehicles are told speeds over ground.
    pub fn flock_settings_over_ground(&self) -> FlockSettings {
        self.flock_settings_with(|index| self.dynamics_over_ground_of(index))
    }

    /// One set of dynamics for all, or one for each vehicle where some have their own.
    fn flock_settings_with(&self, dynamics_of: impl Fn(usize) -> Dynamics) -> FlockSettings {
        let count = if self.airframes.is_empty() { 1 } else { self.starts.len() };
        FlockSettings {
            controller: self.controller.clone(),
            optimizer: self.optimizer,
            seed: self.seed,
            control_period_s: self.control_period.as_secs_f64(),
            expected: self.expected,
            obstacles: self.obstacles.clone(),
            dynamics: (0..count).map(dynamics_of).collect(),
            side_m: 0.0,
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
    // An airframe of its own starts as it cruises.
    let cruise_speed_mps = file.airframe.as_ref().and(file.autopilot.cruise_speed_mps);
    match &file.vehicles {
        Some(pattern) => {
            let like = state(
                0.0,
                0.0,
                pattern.altitude_m.unwrap_or(expected.altitude_m),
                pattern.speed_mps.or(cruise_speed_mps).unwrap_or(expected.speed_mps),
                pattern.course_deg.unwrap_or(expected.course_rad.to_degrees()),
            );
            patterns::starts(pattern, &like, file.scenario.seed)
        }
        None => file.vehicle.iter().map(|v| state(v.x_m, v.y_m, v.altitude_m, v.speed_mps, v.course_deg)).collect(),
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
