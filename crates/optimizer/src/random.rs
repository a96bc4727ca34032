//! Random search: every candidate is drawn independently. It learns nothing, and so is the control of every comparison;
//! it is also the shortest example of an optimiser, which docs/extending.md walks through.

use rand::Rng;
use serde::{Deserialize, Serialize};

use crate::optimizer::{Front, OptimizeError, Optimizer, SettingsError};
use crate::pareto_flock::ParetoFlock;
use crate::population::uniform;
use crate::problem::Problem;
use crate::settings::{self, check_settings};
use crate::stream::Stream;

/// The parameters of random search. The defaults spend 650 evaluations, as near as can be to the 651 of the others.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RandomSettings {
    /// Candidates of a generation, from 1 to 1000000.
    pub population: usize,
    /// Generations after the first, at most 1000000.
    pub generations: usize,
    /// The greatest size of the archive, and so of the front, from 1 to 1000000. The default holds every candidate of a
    /// solve.
    pub archive_capacity: usize,
}

impl Default for RandomSettings {
    fn default() -> Self {
        Self { population: 50, generations: 12, archive_capacity: 700 }
    }
}

impl RandomSettings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// The first setting that is out of its range, with that range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        check_settings(&[
            settings::count("population", self.population),
            settings::iterations("generations", self.generations),
            settings::count("archive_capacity", self.archive_capacity),
        ])
    }

    /// How many candidates a solve evaluates.
    pub fn evaluations(&self) -> usize {
        self.population.saturating_mul(self.generations.saturating_add(1))
    }

    /// These settings with `generations` of `candidates` each, the first included, and a front of at most one
    /// generation: what makes optimisers comparable.
    pub fn with_budget(self, candidates: usize, generations: usize) -> Self {
        Self { population: candidates, generations: generations.saturating_sub(1), archive_capacity: candidates }
    }
}

/// The optimiser. The front returned is the archive: of all candidates, those that none other dominates.
#[derive(Clone, Debug)]
pub struct Random {
    settings: RandomSettings,
    flock: ParetoFlock,
}

impl Random {
    /// An optimiser with these settings.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: RandomSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Ok(Self { settings, flock: ParetoFlock::default() })
    }

    /// Its settings.
    pub fn settings(&self) -> &RandomSettings {
        &self.settings
    }
}

impl Optimizer for Random {
    fn name(&self) -> &'static str {
        "Random"
    }

    fn seed_candidates(&mut self, positions: &[f64]) {
        self.flock.seed(positions);
    }

    fn minimise(&mut self, problem: &mut dyn Problem, rng: &mut Stream) -> Result<Front<'_>, OptimizeError> {
        // Nobody flies: the velocities, drawn with any limit, are never looked at.
        self.flock.start(self.settings.population, 1.0, self.settings.archive_capacity, problem, rng)?;
        self.flock.judge_first(problem)?;
        for _ in 0..self.settings.generations {
            for (dimension, bounds) in problem.bounds().iter().enumerate() {
                for x in self.flock.swarm.coordinate_mut(dimension) {
                    *x = bounds.clamp(bounds.lower + uniform(rng.next_u32()) * bounds.range());
                }
            }
            self.flock.judge(problem);
        }
        Ok(self.flock.front())
    }
}
