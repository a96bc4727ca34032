//! The settings of a flock and its decisions: what goes into a tick and what comes out.

use crate::{ControllerSettings, Expected, Obstacle, SideRule};
use flight_model::{Dynamics, RangeError, Ranges, Setpoint};
use optimizer::OptimizerSettings;
use std::time::Duration;

/// Greatest course change that a command over a link asks for, rad.
const COURSE_CHANGE_BEHIND_LINK_RAD: f64 = 1.6;
/// Over a link another side has to be better by this, m.
const SIDE_BEHIND_LINK_M: f64 = 0.5;
/// Vehicles that turn later than this after a command is sent answer late, s.
const ANSWERS_LATE_S: f64 = 0.1;
/// What a change of the commanded velocity costs where vehicles answer late, s (docs/dynamics.md).
const COMMAND_COST_S: f64 = 1.0;

/// What a flock needs to know before its first tick.
///
/// ```
/// use controller::{ControllerSettings, Expected, FlockSettings};
///
/// // The letter of the paper instead of the default readings, with another seed.
/// let expected = Expected { speed_mps: 10.0, course_rad: 0.5, altitude_m: 50.0 };
/// let settings =
///     FlockSettings { controller: ControllerSettings::literal(), seed: 7, ..FlockSettings::new(expected) };
/// assert_eq!(settings.control_period_s, 0.5);
/// ```
#[derive(Clone, Debug)]
pub struct FlockSettings {
    /// The flocking law, its weights and look-ahead.
    pub controller: ControllerSettings,
    /// The optimiser that chooses the weights.
    pub optimizer: OptimizerSettings,
    /// With the vehicle's index and the tick, the key of every random number.
    pub seed: u64,
    /// T, s.
    pub control_period_s: f64,
    /// What the flock is to do.
    pub expected: Expected,
    /// What it is to avoid.
    pub obstacles: Vec<Obstacle>,
    /// How its vehicles fly: one entry for each, or a single one for all.
    pub dynamics: Vec<Dynamics>,
    /// An evasion turns to the other side than the last command only if that is better by this, m: where commands act
    /// late, one that changes its side from tick to tick gets nowhere.
    pub side_m: f64,
}

impl FlockSettings {
    /// The paper's settings in an empty field, T = 0.5 s.
    pub fn new(expected: Expected) -> Self {
        Self {
            controller: ControllerSettings::default(),
            optimizer: OptimizerSettings::default(),
            seed: 1,
            control_period_s: 0.5,
            expected,
            obstacles: Vec::new(),
            dynamics: vec![Dynamics::default()],
            side_m: 0.0,
        }
    }
}

impl FlockSettings {
    /// Every setting that is out of its range, except those of the optimiser. The limits of the vehicles must only be
    /// in order: a real vehicle may allow less than the ranges of a scenario file.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        ranges.within("control_period_s", self.control_period_s, 0.001, 10.0);
        for dynamics in &self.dynamics {
            let limits = dynamics.limits;
            ranges.within("expected.speed_mps", self.expected.speed_mps, limits.speed_min_mps, limits.speed_max_mps);
        }
        ranges.extend(self.controller.law.check());
        ranges.extend(self.controller.weights.check());
        ranges.extend(self.controller.look_ahead.check());
        for Dynamics { time_constants, limits, response } in &self.dynamics {
            ranges.extend(time_constants.check());
            ranges.within("speed_min_mps", limits.speed_min_mps, 0.0, f64::INFINITY);
            ranges.within("speed_max_mps", limits.speed_max_mps, limits.speed_min_mps, f64::INFINITY);
            ranges.within("climb_min_mps", limits.climb_min_mps, f64::NEG_INFINITY, 0.0);
            ranges.within("climb_max_mps", limits.climb_max_mps, 0.0, f64::INFINITY);
            ranges.extend(response.check());
        }
        ranges.errors()
    }

    /// The same for vehicles behind a link that takes so long to them, s: evasions keep their side, and no command asks
    /// for a hard turn at once.
    /// Where it acts the vehicle may be on another course than foreseen, and a gust may have turned its nose; of a
    /// turn of nearly half a circle the short way round is then the wrong one, into what is evaded.
    ///
    /// Where the law leaves the side open and a vehicle answers late, obstacles are passed on the side to which the
    /// last command turns, and changes of the commanded velocity cost something: told to turn left and right from tick
    /// to tick, it would fly straight into what is dead ahead. One that answers at once is turned from where it is: in
    /// gusts its commands say less of where it goes.
    #[must_use]
    pub fn behind_a_link(mut self, delay_s: f64) -> Self {
        self.side_m = SIDE_BEHIND_LINK_M;
        let acts_after_s = |dynamics: &Dynamics| delay_s + dynamics.response.course_dead_time_s;
        let answers_late = self.dynamics.iter().any(|dynamics| acts_after_s(dynamics) > ANSWERS_LATE_S);
        let law = &mut self.controller.law;
        if answers_late && law.side_rule == SideRule::Auto {
            law.side_rule = SideRule::Command;
            law.command_cost_s = law.command_cost_s.max(COMMAND_COST_S);
        }
        for dynamics in &mut self.dynamics {
            let step_max_rad = &mut dynamics.response.course_step_max_rad;
            *step_max_rad = step_max_rad.min(COURSE_CHANGE_BEHIND_LINK_RAD);
        }
        self
    }

    /// How a vehicle flies.
    pub fn dynamics_of(&self, vehicle: usize) -> Dynamics {
        self.dynamics.get(vehicle).or(self.dynamics.first()).copied().unwrap_or_default()
    }

    /// The speed that the fastest of its vehicles reaches, m/s.
    pub fn speed_max_mps(&self) -> f64 {
        self.dynamics.iter().map(|dynamics| dynamics.limits.speed_max_mps).fold(0.0, f64::max)
    }
}

/// Why a flock cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlockError {
    /// A setting of the flock is out of its range.
    #[error("{0}")]
    Setting(RangeError),
    /// There is neither one set of dynamics for all vehicles nor one for each.
    #[error("{given} sets of dynamics for {vehicles} vehicles: one for each is needed, or one for all")]
    Dynamics {
        /// How many there are.
        given: usize,
        /// For how many vehicles.
        vehicles: usize,
    },
    /// A setting of the optimiser is out of its range.
    #[error(transparent)]
    Optimizer(#[from] optimizer::SettingsError),
}

/// The setpoint of one vehicle at one tick, and how it was chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Decision {
    /// The inputs of the three autopilots (Eq. 2).
    pub setpoint: Setpoint,
    /// alpha_f, alpha_o, alpha_nv.
    pub weights: [f64; 3],
    /// Whether the chosen weights keep both constraints over the horizon.
    pub feasible: bool,
    /// How long the optimiser took.
    pub solve: Duration,
}
