//! Algorithm 1 and Eq. 18 of Ruan and Duan: multi-objective social learning pigeon-inspired optimisation (MSLPIO).

use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::factors;
use crate::optimizer::{Front, OptimizeError, Optimizer, SettingsError};
use crate::pareto_flock::{Evolve, ParetoFlock};
use crate::population::{pick, uniform};
use crate::problem::{Bounds, Problem, clamp};
use crate::settings::{self, check_settings};
use crate::stream::Stream;

/// The parameters of Algorithm 1. The defaults are the paper's where it gives one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct MslpioSettings {
    /// M of Eq. 13: pigeons, but for one more per five dimensions. At least 1. The paper: 50.
    pub base_population: usize,
    /// D of Eq. 13, c1 and c2, from 1 to `base_population`. The paper gives 5, which is more than its number of
    /// dimensions: so D is a setting, independent of the problem.
    pub dimension_setting: usize,
    /// Whether each pigeon learns from its own model, which is the paper's social learning. If false, all pigeons
    /// follow one leader that is drawn from the archive at each iteration, as in MPIO: this setting measures the effect
    /// of social learning.
    pub social_learning: bool,
    /// The social coefficient a of c2, at least 0. The paper: 0.5.
    pub social_coefficient: f64,
    /// The map and compass factor R, from 0 to 1: how fast velocities decay. The paper: 0.3.
    pub map_and_compass_factor: f64,
    /// N_max, at most 1000000. The paper: 20.
    pub iterations: usize,
    /// N_removed: pigeons that leave before each iteration, the worst by rank and crowding. At least one pigeon must be
    /// left for the last iteration. The paper: 2.
    pub removed_per_iteration: usize,
    /// The limit of a velocity, and the width of its first draw, as a fraction of each dimension's range; from above 0
    /// to 1. The paper gives none; 0.5 is a measured compromise: below 0.3 a solve stops short of a front at the bounds
    /// (ZDT1, ZDT3), and towards 1 it finds less of a front inside them.
    pub velocity_limit: f64,
    /// The greatest size of the archive A, and so of the front; at least 1. The paper does not bound it, and neither
    /// does the default, 700, which is more than the 651 candidates of a solve. [`crate::archive::Archive`] says which
    /// members leave.
    pub archive_capacity: usize,
}

impl Default for MslpioSettings {
    fn default() -> Self {
        Self {
            base_population: 50,
            dimension_setting: 5,
            social_learning: true,
            social_coefficient: 0.5,
            map_and_compass_factor: 0.3,
            iterations: 20,
            removed_per_iteration: 2,
            velocity_limit: 0.5,
            archive_capacity: 700,
        }
    }
}

impl MslpioSettings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// The first setting that is out of its range, with that range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        check_settings(&[
            settings::count("base_population", self.base_population),
            settings::dimension_setting(self.dimension_setting, self.base_population),
            settings::factor("social_coefficient", self.social_coefficient),
            settings::fraction("map_and_compass_factor", self.map_and_compass_factor),
            settings::iterations("iterations", self.iterations),
            settings::removed_per_iteration(self.removed_per_iteration, self.iterations, self.population()),
            settings::velocity_limit(self.velocity_limit),
            settings::count("archive_capacity", self.archive_capacity),
        ])
    }

    /// N of Eq. 13, the pigeons of the first generation.
    pub fn population(&self) -> usize {
        factors::population(self.base_population, self.dimension_setting)
    }

    /// How many candidates a solve evaluates.
    pub fn evaluations(&self) -> usize {
        settings::evaluations(self.population(), self.removed_per_iteration, self.iterations)
    }

    /// These settings with `generations` of `candidates` each, the first included, and a front of at most one
    /// generation: what makes optimisers comparable. No pigeon is removed.
    pub fn with_budget(self, candidates: usize, generations: usize) -> Self {
        Self {
            base_population: factors::base_population(candidates, self.dimension_setting),
            iterations: generations.saturating_sub(1),
            removed_per_iteration: 0,
            archive_capacity: candidates,
            ..self
        }
    }

    /// c1 of Eq. 18, how strongly a pigeon learns from its model: 1 - ln(D/M).
    pub fn learning_factor(&self) -> f64 {
        factors::learning(self.dimension_setting, self.base_population)
    }

    /// c2 of Eq. 18, how strongly a pigeon is drawn to the centre: a D/M.
    pub fn social_influence_factor(&self) -> f64 {
        factors::social_influence(self.social_coefficient, self.dimension_setting, self.base_population)
    }
}

/// The optimiser. Where Algorithm 1 leaves a choice: X_model is drawn for each pigeon uniformly from the archive A,
/// X_center is the mean of the current generation's Pareto front, `rand` is drawn for each pigeon, term and dimension
/// uniformly from [0, 1), the N_removed worst by (rank, crowding, index, the higher being worse) leave before each
/// update, and the front returned is A.
#[derive(Clone, Debug)]
pub struct Mslpio {
    settings: MslpioSettings,
    flock: ParetoFlock,
    x_model: Vec<f64>,
    draws: Vec<u32>,
}

impl Mslpio {
    /// An optimiser with these settings.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: MslpioSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Ok(Self { settings, flock: ParetoFlock::default(), x_model: Vec::new(), draws: Vec::new() })
    }

    /// Its settings.
    pub fn settings(&self) -> &MslpioSettings {
        &self.settings
    }

    /// Algorithm 1, "Pigeon initialization".
    fn initialise(&mut self, problem: &dyn Problem, rng: &mut Stream) -> Result<(), OptimizeError> {
        let pigeons = self.settings.population();
        self.flock.start(pigeons, self.settings.velocity_limit, self.settings.archive_capacity, problem, rng)?;
        self.draws.clear();
        self.draws.reserve(pigeons * (1 + 2 * problem.bounds().len()));
        Ok(())
    }
}

impl Evolve for Mslpio {
    fn flock(&mut self) -> &mut ParetoFlock {
        &mut self.flock
    }

    /// Eq. 18, second and third line, clamped to the limits (Step 2).
    fn fly(&mut self, nc: usize, bounds: &[Bounds], rng: &mut Stream) {
        let pigeons = self.flock.swarm.len();
        let decay = libm::exp(-self.settings.map_and_compass_factor * nc as f64);
        let (c1, c2) = (self.settings.learning_factor(), self.settings.social_influence_factor());
        // All draws of an iteration at once: a model for each pigeon, then for each dimension both factors of each
        // pigeon.
        self.draws.resize(pigeons * (1 + 2 * bounds.len()), 0);
        rng.fill(&mut self.draws[..]);
        let (models, factors) = self.draws.split_at(pigeons);
        let leader = models.first().copied().unwrap_or_default();
        self.x_model.resize(pigeons * bounds.len(), 0.0);
        for (pigeon, &model) in models.iter().enumerate() {
            let model = if self.settings.social_learning { model } else { leader };
            let member = self.flock.archive.member(pick(self.flock.archive.len(), model));
            for (dimension, &coordinate) in member.iter().enumerate() {
                self.x_model[dimension * pigeons + pigeon] = coordinate;
            }
        }
        for (dimension, (bounds, factors)) in bounds.iter().zip(factors.chunks_exact(2 * pigeons)).enumerate() {
            let limit = self.settings.velocity_limit * bounds.range();
            let x_center = self.flock.x_center[dimension];
            let (learning, social) = factors.split_at(pigeons);
            let velocities = &mut self.flock.velocities[dimension * pigeons..][..pigeons];
            let x_model = &self.x_model[dimension * pigeons..][..pigeons];
            let pigeons = self.flock.swarm.coordinate_mut(dimension).iter_mut().zip(velocities);
            for (((x, v), x_model), (&learning, &social)) in pigeons.zip(x_model).zip(learning.iter().zip(social)) {
                *v = *v * decay + uniform(learning) * c1 * (x_model - *x) + uniform(social) * c2 * (x_center - *x);
                *v = clamp(*v, -limit, limit);
                *x = bounds.clamp(*x + *v);
            }
        }
    }
}

impl Optimizer for Mslpio {
    fn name(&self) -> &'static str {
        "MSLPIO"
    }

    fn seed_candidates(&mut self, positions: &[f64]) {
        self.flock.seed(positions);
    }

    fn minimise(&mut self, problem: &mut dyn Problem, rng: &mut Stream) -> Result<Front<'_>, OptimizeError> {
        self.initialise(problem, rng)?;
        self.evolve(self.settings.iterations, self.settings.removed_per_iteration, problem, rng)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Plane;
    use crate::stream::stream;

    #[test]
    fn an_update_is_eq_18_pigeon_by_pigeon() {
        let mut problem = Plane([Bounds::new(-1.0, 1.0), Bounds::new(0.0, 10.0)]);
        let settings = MslpioSettings { social_coefficient: 8.0, ..MslpioSettings::default() };
        let mut mslpio = Mslpio::new(settings).expect("in range");
        mslpio.initialise(&problem, &mut stream(1, 2, 3)).expect("solvable");
        mslpio.flock.judge(&mut problem);
        mslpio.flock.remove_worst(2);
        let pigeons = mslpio.flock.swarm.len();
        assert_eq!(pigeons, 49);

        let before = mslpio.clone();
        let mut draws = vec![0_u32; pigeons * 5];
        stream(7, 8, 9).fill(&mut draws[..]);
        mslpio.fly(3, problem.bounds(), &mut stream(7, 8, 9));

        let rand = |draw: u32| f64::from(draw) / 4_294_967_296.0;
        for i in 0..pigeons {
            let model = before.flock.archive.member((rand(draws[i]) * before.flock.archive.len() as f64) as usize);
            for (d, bounds) in problem.bounds().iter().enumerate() {
                let (x, v) = (before.flock.swarm.coordinate(d)[i], before.flock.velocities[d * pigeons + i]);
                let [r1, r2] = [0, 1].map(|term| rand(draws[pigeons * (1 + 2 * d + term) + i]));
                let (c1, c2) = (1.0 - libm::log(5.0 / 50.0), 8.0 * 5.0 / 50.0);
                let limit = 0.5 * (bounds.upper - bounds.lower);
                let pull = r1 * c1 * (model[d] - x) + r2 * c2 * (before.flock.x_center[d] - x);
                let v = (v * libm::exp(-0.3 * 3.0) + pull).clamp(-limit, limit);
                let x = (x + v).clamp(bounds.lower, bounds.upper);
                assert!((mslpio.flock.velocities[d * pigeons + i] - v).abs() < 1e-12);
                assert!((mslpio.flock.swarm.coordinate(d)[i] - x).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn without_social_learning_all_learn_from_one_leader() {
        let mut problem = Plane([Bounds::new(-1.0, 1.0), Bounds::new(0.0, 10.0)]);
        for social_learning in [true, false] {
            let settings = MslpioSettings { social_learning, ..MslpioSettings::default() };
            let mut mslpio = Mslpio::new(settings).expect("in range");
            mslpio.initialise(&problem, &mut stream(1, 2, 3)).expect("solvable");
            mslpio.flock.judge(&mut problem);
            assert!(mslpio.flock.archive.len() > 1, "one model is as good as another");
            mslpio.fly(1, problem.bounds(), &mut stream(7, 8, 9));
            let models = &mslpio.x_model[..51];
            assert_eq!(models.iter().all(|model| *model == models[0]), !social_learning);
        }
    }

    #[test]
    fn the_centre_is_the_mean_of_the_pareto_front_and_the_worst_leave() {
        let mut problem = Plane([Bounds::new(-1.0, 1.0), Bounds::new(0.0, 10.0)]);
        let mut mslpio = Mslpio::new(MslpioSettings::default()).expect("in range");
        mslpio.initialise(&problem, &mut stream(4, 5, 6)).expect("solvable");
        mslpio.flock.judge(&mut problem);
        let front: Vec<usize> = (0..51).filter(|&i| mslpio.flock.sort.ranks()[i] == 0).collect();
        for d in 0..2 {
            let mean = front.iter().map(|&i| mslpio.flock.swarm.coordinate(d)[i]).sum::<f64>() / front.len() as f64;
            assert!((mslpio.flock.x_center[d] - mean).abs() < 1e-12);
        }
        let ranks = mslpio.flock.sort.ranks().to_vec();
        let mut sorted = ranks.clone();
        sorted.sort_unstable();
        mslpio.flock.remove_worst(2);
        assert_eq!((mslpio.flock.swarm.len(), mslpio.flock.leaving.len()), (49, 2));
        assert!(mslpio.flock.leaving.iter().all(|&pigeon| ranks[pigeon as usize] >= sorted[49]));
    }
}
