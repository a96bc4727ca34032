//! Multi-objective pigeon-inspired optimisation (MPIO), to which Ruan and Duan compare MSLPIO: after Qiu and Duan, "A
//! multi-objective pigeon-inspired optimization approach to UAV distributed flocking among obstacles", 2020.
//!
//! Ruan and Duan describe MPIO by reference only. Reading 15 of docs/reading.md is: the map and compass operator and
//! the landmark operator in one update, a global leader from the archive, no social factor. The update is
//!
//! N^nc = N^(nc-1) - N_removed,
//! V_i^nc = V_i^(nc-1) e^(-R nc) + rand tr (1 - w) (X_gbest - X_i^(nc-1)) + rand tr w (X_center^(nc-1) - X_i^(nc-1)),
//! X_i^nc = X_i^(nc-1) + V_i^nc, where w = log(nc) / log(N_max).
//!
//! That is Eq. 18 with two differences. One leader for the whole flock, drawn from the archive at each iteration, in
//! place of a model for each pigeon: this is what social learning is compared to. And a transition factor tr with a
//! weight w that goes from the first operator to the second, from 0 at the first iteration to 1 at the last, in place
//! of c1 and c2. **The equation is our reading**: the weight, tr, and the way the leader is drawn have not been checked
//! against Qiu and Duan, whose text we did not have. Everything else (sorting, archive, centre, removal, limits) is as
//! in [`crate::Mslpio`].

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::optimizer::{Front, OptimizeError, Optimizer, SettingsError};
use crate::pareto_flock::{Evolve, ParetoFlock};
use crate::population::{pick, uniform};
use crate::problem::{Bounds, Problem, clamp};
use crate::settings::{self, check_settings};
use crate::stream::Stream;

/// The parameters of MPIO. What it shares with MSLPIO is set as there, so that both spend the same 651 evaluations.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct MpioSettings {
    /// N, the pigeons of the first generation, from 1 to 1000000.
    pub population: usize,
    /// The map and compass factor R, from 0 to 1: how fast velocities decay.
    pub map_and_compass_factor: f64,
    /// tr, how strongly a pigeon is drawn to the leader and to the centre, from 0 to 1000. The default, 3, is ours:
    /// near MSLPIO's c1, and of 0.5 to 4 among the best on ZDT1, 3 and 6; with 1 the flock stops well short of a front.
    pub transition_factor: f64,
    /// N_max, at most 1000000.
    pub iterations: usize,
    /// N_removed: pigeons that leave before each iteration, the worst by rank and crowding. At least one pigeon must be
    /// left for the last iteration.
    pub removed_per_iteration: usize,
    /// The limit of a velocity, and the width of its first draw, as a fraction of each dimension's range; from above 0
    /// to 1.
    pub velocity_limit: f64,
    /// The greatest size of the archive, and so of the front, from 1 to 1000000. The default holds every candidate of a
    /// solve.
    pub archive_capacity: usize,
}

impl Default for MpioSettings {
    fn default() -> Self {
        Self {
            population: 51,
            map_and_compass_factor: 0.3,
            transition_factor: 3.0,
            iterations: 20,
            removed_per_iteration: 2,
            velocity_limit: 0.5,
            archive_capacity: 700,
        }
    }
}

impl MpioSettings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// The first setting that is out of its range, with that range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        check_settings(&[
            settings::count("population", self.population),
            settings::fraction("map_and_compass_factor", self.map_and_compass_factor),
            settings::factor("transition_factor", self.transition_factor),
            settings::iterations("iterations", self.iterations),
            settings::removed_per_iteration(self.removed_per_iteration, self.iterations, self.population),
            settings::velocity_limit(self.velocity_limit),
            settings::count("archive_capacity", self.archive_capacity),
        ])
    }

    /// How many candidates a solve evaluates.
    pub fn evaluations(&self) -> usize {
        settings::evaluations(self.population, self.removed_per_iteration, self.iterations)
    }

    /// These settings with `generations` of `candidates` each, the first included, and a front of at most one
    /// generation: what makes optimisers comparable. No pigeon is removed.
    pub fn with_budget(self, candidates: usize, generations: usize) -> Self {
        let iterations = generations.saturating_sub(1);
        Self { population: candidates, iterations, removed_per_iteration: 0, archive_capacity: candidates, ..self }
    }

    /// w of iteration `nc`, counted from 1: how much of the update is the landmark operator's.
    fn landmark_weight(&self, nc: usize) -> f64 {
        // The only iteration there is is the first.
        if self.iterations > 1 { libm::log(nc as f64) / libm::log(self.iterations as f64) } else { 0.0 }
    }
}

/// The optimiser. The leader is drawn uniformly from the archive, `rand` for each pigeon, term and dimension from [0,
/// 1).
#[derive(Clone, Debug)]
pub struct Mpio {
    settings: MpioSettings,
    flock: ParetoFlock,
    draws: Vec<u32>,
}

impl Mpio {
    /// An optimiser with these settings.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: MpioSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Ok(Self { settings, flock: ParetoFlock::default(), draws: Vec::new() })
    }

    /// Its settings.
    pub fn settings(&self) -> &MpioSettings {
        &self.settings
    }

    fn initialise(&mut self, problem: &dyn Problem, rng: &mut Stream) -> Result<(), OptimizeError> {
        let pigeons = self.settings.population;
        self.flock.start(pigeons, self.settings.velocity_limit, self.settings.archive_capacity, problem, rng)?;
        self.draws.clear();
        self.draws.reserve(2 * pigeons);
        Ok(())
    }
}

impl Evolve for Mpio {
    fn flock(&mut self) -> &mut ParetoFlock {
        &mut self.flock
    }

    /// Velocities and positions by the module's equation, clamped to their limits.
    fn fly(&mut self, nc: usize, bounds: &[Bounds], rng: &mut Stream) {
        let pigeons = self.flock.swarm.len();
        let decay = libm::exp(-self.settings.map_and_compass_factor * nc as f64);
        let weight = self.settings.landmark_weight(nc);
        let to_leader = self.settings.transition_factor * (1.0 - weight);
        let to_center = self.settings.transition_factor * weight;
        let leader = self.flock.archive.member(pick(self.flock.archive.len(), rng.next_u32()));
        for (dimension, bounds) in bounds.iter().enumerate() {
            self.draws.resize(2 * pigeons, 0);
            rng.fill(&mut self.draws[..]);
            let limit = self.settings.velocity_limit * bounds.range();
            let (x_gbest, x_center) = (leader[dimension], self.flock.x_center[dimension]);
            let (map, landmark) = self.draws.split_at(pigeons);
            let velocities = &mut self.flock.velocities[dimension * pigeons..][..pigeons];
            let pigeons = self.flock.swarm.coordinate_mut(dimension).iter_mut().zip(velocities);
            for ((x, v), (&map, &landmark)) in pigeons.zip(map.iter().zip(landmark)) {
                *v = *v * decay
                    + uniform(map) * to_leader * (x_gbest - *x)
                    + uniform(landmark) * to_center * (x_center - *x);
                *v = clamp(*v, -limit, limit);
                *x = bounds.clamp(*x + *v);
            }
        }
    }
}

impl Optimizer for Mpio {
    fn name(&self) -> &'static str {
        "MPIO"
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
    fn the_weight_goes_from_the_leader_to_the_centre() {
        let settings = MpioSettings::default();
        assert_eq!((settings.landmark_weight(1), settings.landmark_weight(20)), (0.0, 1.0));
        assert!((settings.landmark_weight(5) - 0.537_243_57).abs() < 1e-8);
        assert_eq!(MpioSettings { iterations: 1, ..settings }.landmark_weight(1), 0.0);
    }

    #[test]
    fn an_update_is_the_equation_pigeon_by_pigeon() {
        let mut problem = Plane([Bounds::new(-1.0, 1.0), Bounds::new(0.0, 10.0)]);
        let mut mpio = Mpio::new(MpioSettings { transition_factor: 0.7, ..MpioSettings::default() }).expect("in range");
        mpio.initialise(&problem, &mut stream(1, 2, 3)).expect("solvable");
        mpio.flock.judge(&mut problem);
        mpio.flock.remove_worst(2);
        let before = mpio.clone();
        mpio.fly(4, problem.bounds(), &mut stream(7, 8, 9));

        let mut rng = stream(7, 8, 9);
        let mut rand = || f64::from(rng.next_u32()) / 4_294_967_296.0;
        let leader = before.flock.archive.member((rand() * before.flock.archive.len() as f64) as usize);
        let w = libm::log(4.0) / libm::log(20.0);
        for (d, bounds) in problem.bounds().iter().enumerate() {
            let draws: Vec<f64> = (0..2 * 49).map(|_| rand()).collect();
            for i in 0..49 {
                let (x, v) = (before.flock.swarm.coordinate(d)[i], before.flock.velocities[d * 49 + i]);
                let pull = draws[i] * 0.7 * (1.0 - w) * (leader[d] - x);
                let pull = pull + draws[49 + i] * 0.7 * w * (before.flock.x_center[d] - x);
                let limit = 0.5 * (bounds.upper - bounds.lower);
                let v = (v * libm::exp(-0.3 * 4.0) + pull).clamp(-limit, limit);
                assert!((mpio.flock.velocities[d * 49 + i] - v).abs() < 1e-12);
                let x = (x + v).clamp(bounds.lower, bounds.upper);
                assert!((mpio.flock.swarm.coordinate(d)[i] - x).abs() < 1e-12);
            }
        }
    }
}
