//! Eq. 14 and Eq. 15 of Ruan and Duan: social learning pigeon-inspired optimisation (SL-PIO) of one objective, in two
//! stages.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::factors;
use crate::optimizer::{Front, OptimizeError, Optimizer, SettingsError};
use crate::pareto_flock::{ParetoFlock, mean};
use crate::population::{pick, uniform};
use crate::problem::{Bounds, Problem, clamp};
use crate::settings::{self, check_settings};
use crate::stream::Stream;
use crate::sum::SumOfObjectives;

/// The parameters of Eq. 13-15. The defaults are the paper's where it gives one. It does not give the length of each
/// stage: the default is three quarters and one quarter of 12 iterations, and 651 evaluations as for the other
/// pigeon-inspired optimisers.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlpioSettings {
    /// M of Eq. 13, from 1 to 1000000. The paper: 50.
    pub base_population: usize,
    /// D of Eq. 13, c1 and c2, from 1 to `base_population`; a setting, as in [`crate::MslpioSettings`]. The paper: 5.
    pub dimension_setting: usize,
    /// The social coefficient a of c2, from 0 to 1000. The paper: 0.5.
    pub social_coefficient: f64,
    /// The map and compass factor R, from 0 to 1: how fast velocities decay. The paper: 0.3.
    pub map_and_compass_factor: f64,
    /// Iterations of the map and compass stage (Eq. 14), at most 1000000.
    pub map_and_compass_iterations: usize,
    /// Iterations of the landmark stage (Eq. 15), at most 1000000.
    pub landmark_iterations: usize,
    /// N_removed: pigeons that leave in each iteration of the landmark stage, the worst. At least one must be left for
    /// the last. The paper: 2.
    pub removed_per_iteration: usize,
    /// The limit of a velocity, and the width of its first draw, as a fraction of each dimension's range; from above 0
    /// to 1.
    pub velocity_limit: f64,
}

impl Default for SlpioSettings {
    fn default() -> Self {
        Self {
            base_population: 50,
            dimension_setting: 5,
            social_coefficient: 0.5,
            map_and_compass_factor: 0.3,
            map_and_compass_iterations: 9,
            landmark_iterations: 3,
            removed_per_iteration: 2,
            velocity_limit: 0.5,
        }
    }
}

impl SlpioSettings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// The first setting that is out of its range, with that range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let (iterations, pigeons) = (self.landmark_iterations, self.population());
        check_settings(&[
            settings::count("base_population", self.base_population),
            settings::dimension_setting(self.dimension_setting, self.base_population),
            settings::factor("social_coefficient", self.social_coefficient),
            settings::fraction("map_and_compass_factor", self.map_and_compass_factor),
            settings::iterations("map_and_compass_iterations", self.map_and_compass_iterations),
            settings::iterations("landmark_iterations", iterations),
            settings::removed_per_iteration(self.removed_per_iteration, iterations, pigeons),
            settings::velocity_limit(self.velocity_limit),
        ])
    }

    /// N of Eq. 13, the pigeons until the landmark stage: M + floor(D/5).
    pub fn population(&self) -> usize {
        factors::population(self.base_population, self.dimension_setting)
    }

    /// How many candidates a solve evaluates.
    pub fn evaluations(&self) -> usize {
        let landmark = settings::evaluations(self.population(), self.removed_per_iteration, self.landmark_iterations);
        self.population().saturating_mul(self.map_and_compass_iterations).saturating_add(landmark)
    }

    /// These settings with `generations` of `candidates` each, the first included, and a front of at most one
    /// generation: what makes optimisers comparable. No pigeon is removed, and a quarter of the iterations belong to
    /// the landmark stage.
    pub fn with_budget(self, candidates: usize, generations: usize) -> Self {
        let iterations = generations.saturating_sub(1);
        Self {
            base_population: factors::base_population(candidates, self.dimension_setting),
            map_and_compass_iterations: iterations - iterations / 4,
            landmark_iterations: iterations / 4,
            removed_per_iteration: 0,
            ..self
        }
    }

    /// c1 of Eq. 14, how strongly a pigeon learns from its demonstrator: 1 - ln(D/M).
    pub fn learning_factor(&self) -> f64 {
        factors::learning(self.dimension_setting, self.base_population)
    }

    /// c2 of Eq. 15, how strongly a pigeon is drawn to the centre: a D/M.
    pub fn social_influence_factor(&self) -> f64 {
        factors::social_influence(self.social_coefficient, self.dimension_setting, self.base_population)
    }
}

/// The optimiser. It minimises the sum of a problem's objectives. Its front has one objective, the sum, and one member,
/// the best of all candidates that it evaluated.
///
/// Where the paper leaves a choice: a pigeon's demonstrator is drawn uniformly from those that are better than it now
/// (by violation, then cost), so the best pigeons, which have none, stay where they are, as in the SL-PSO of Cheng and
/// Jin; `rand` is drawn for each pigeon and dimension uniformly from [0, 1); and the N_removed worst pigeons are
/// removed.
#[derive(Clone, Debug)]
pub struct Slpio {
    settings: SlpioSettings,
    /// With one objective, ranks are places in the order of costs, and the archive is the best candidate so far.
    flock: ParetoFlock,
    demonstrators: Vec<u32>,
    x_model: Vec<f64>,
    draws: Vec<u32>,
    /// The costs of the inner problem's objectives.
    objectives: Vec<f64>,
}

/// Stands for no demonstrator: no pigeon is better than this one.
const NOBODY: u32 = u32::MAX;

impl Slpio {
    /// An optimiser with these settings.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: SlpioSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Ok(Self {
            settings,
            flock: ParetoFlock::default(),
            demonstrators: Vec::new(),
            x_model: Vec::new(),
            draws: Vec::new(),
            objectives: Vec::new(),
        })
    }

    /// Its settings.
    pub fn settings(&self) -> &SlpioSettings {
        &self.settings
    }

    fn initialise(&mut self, problem: &dyn Problem, rng: &mut Stream) -> Result<(), OptimizeError> {
        let pigeons = self.settings.population();
        self.flock.start(pigeons, self.settings.velocity_limit, 1, problem, rng)?;
        for buffer in [&mut self.demonstrators, &mut self.draws] {
            buffer.clear();
            buffer.reserve(pigeons);
        }
        self.x_model.clear();
        self.x_model.reserve(pigeons);
        Ok(())
    }

    /// Fig. 1: a better pigeon for each pigeon.
    fn choose_demonstrators(&mut self, rng: &mut Stream) {
        self.demonstrators.clear();
        for &rank in self.flock.sort.ranks() {
            let superior = self.flock.sort.before(rank as usize);
            let bits = rng.next_u32();
            self.demonstrators.push(superior.get(pick(superior.len(), bits)).copied().unwrap_or(NOBODY));
        }
    }

    /// Eq. 14, the map and compass operator, clamped to the limits:
    /// V_i = V_i e^(-R nc) + rand c1 (X_model - X_i), X_i = X_i + V_i.
    fn learn(&mut self, nc: usize, bounds: &[Bounds], rng: &mut Stream) {
        let pigeons = self.flock.swarm.len();
        let decay = libm::exp(-self.settings.map_and_compass_factor * nc as f64);
        let c1 = self.settings.learning_factor();
        self.choose_demonstrators(rng);
        for (dimension, bounds) in bounds.iter().enumerate() {
            self.draw(pigeons, rng);
            let limit = self.settings.velocity_limit * bounds.range();
            let coordinate = self.flock.swarm.coordinate_mut(dimension);
            // Demonstrators move too: a pigeon learns from the previous position of its demonstrator.
            self.x_model.clear();
            self.x_model.extend_from_slice(coordinate);
            let velocities = &mut self.flock.velocities[dimension * pigeons..][..pigeons];
            let pigeons = coordinate.iter_mut().zip(velocities).zip(&self.demonstrators).zip(&self.draws);
            for (((x, v), &demonstrator), &draw) in pigeons {
                let Some(x_model) = self.x_model.get(demonstrator as usize) else { continue };
                *v = clamp(*v * decay + uniform(draw) * c1 * (x_model - *x), -limit, limit);
                *x = bounds.clamp(*x + *v);
            }
        }
    }

    /// Eq. 15, the landmark operator: X_center is the mean of all pigeons, the worst are removed, and the others
    /// approach it, X_i = X_i + rand c2 (X_center - X_i).
    fn approach_center(&mut self, bounds: &[Bounds], rng: &mut Stream) {
        self.flock.x_center.clear();
        for dimension in 0..bounds.len() {
            self.flock.x_center.push(mean(self.flock.swarm.coordinate(dimension).iter().copied()));
        }
        self.flock.remove_worst(self.settings.removed_per_iteration);
        let c2 = self.settings.social_influence_factor();
        for (dimension, bounds) in bounds.iter().enumerate() {
            self.draw(self.flock.swarm.len(), rng);
            let x_center = self.flock.x_center[dimension];
            for (x, &draw) in self.flock.swarm.coordinate_mut(dimension).iter_mut().zip(&self.draws) {
                *x = bounds.clamp(*x + uniform(draw) * c2 * (x_center - *x));
            }
        }
    }

    /// Both stages, one after the other.
    fn solve(&mut self, problem: &mut dyn Problem, rng: &mut Stream) -> Result<(), OptimizeError> {
        self.initialise(problem, rng)?;
        self.flock.judge_first(problem)?;
        for nc in 1..=self.settings.map_and_compass_iterations {
            self.learn(nc, problem.bounds(), rng);
            self.flock.judge(problem);
        }
        for _ in 0..self.settings.landmark_iterations {
            self.approach_center(problem.bounds(), rng);
            self.flock.judge(problem);
        }
        Ok(())
    }

    fn draw(&mut self, count: usize, rng: &mut Stream) {
        self.draws.resize(count, 0);
        rng.fill(&mut self.draws[..]);
    }
}

impl Optimizer for Slpio {
    fn name(&self) -> &'static str {
        "SL-PIO"
    }

    fn seed_candidates(&mut self, positions: &[f64]) {
        self.flock.seed(positions);
    }

    fn minimise(&mut self, problem: &mut dyn Problem, rng: &mut Stream) -> Result<Front<'_>, OptimizeError> {
        // Moved out for the time of the solve: the flock changes beside it.
        let mut objectives = std::mem::take(&mut self.objectives);
        let solved = self.solve(&mut SumOfObjectives { problem, objectives: &mut objectives }, rng);
        self.objectives = objectives;
        solved?;
        Ok(self.flock.front())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::{Candidates, Evaluations};
    use crate::stream::stream;

    struct Bowl([Bounds; 2]);

    impl Problem for Bowl {
        fn bounds(&self) -> &[Bounds] {
            &self.0
        }

        fn objectives(&self) -> usize {
            1
        }

        fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
            let (x, y) = (candidates.coordinate(0), candidates.coordinate(1));
            for i in 0..candidates.len() {
                evaluations.objective(0)[i] = x[i] * x[i] + y[i] * y[i];
            }
        }
    }

    fn started() -> (Slpio, Bowl) {
        let mut problem = Bowl([Bounds::new(-1.0, 2.0), Bounds::new(-5.0, 10.0)]);
        let mut slpio = Slpio::new(SlpioSettings::default()).expect("in range");
        slpio.initialise(&problem, &mut stream(1, 2, 3)).expect("solvable");
        slpio.flock.judge(&mut problem);
        (slpio, problem)
    }

    #[test]
    fn the_map_and_compass_operator_is_eq_14_with_a_superior_demonstrator() {
        let (mut slpio, problem) = started();
        let before = slpio.clone();
        slpio.learn(2, problem.bounds(), &mut stream(7, 8, 9));
        let costs = before.flock.swarm.costs();
        let mut rng = stream(7, 8, 9);
        let _demonstrators: Vec<u32> = (0..51).map(|_| rng.next_u32()).collect();
        let mut still = 0;
        for (d, bounds) in problem.bounds().iter().enumerate() {
            for i in 0..51 {
                let rand = f64::from(rng.next_u32()) / 4_294_967_296.0;
                let (x, v) = (before.flock.swarm.coordinate(d)[i], before.flock.velocities[d * 51 + i]);
                let now = slpio.flock.swarm.coordinate(d)[i];
                if slpio.demonstrators[i] == NOBODY {
                    assert!(costs.objective(0).iter().all(|&cost| cost >= costs.objective(0)[i]));
                    assert_eq!(now, x);
                    still += 1;
                    continue;
                }
                let model = slpio.demonstrators[i] as usize;
                assert!(costs.objective(0)[model] < costs.objective(0)[i]);
                let c1 = 1.0 - libm::log(0.1);
                let limit = 0.5 * (bounds.upper - bounds.lower);
                let pull = rand * c1 * (before.flock.swarm.coordinate(d)[model] - x);
                let v = (v * libm::exp(-0.3 * 2.0) + pull).clamp(-limit, limit);
                assert!((now - (x + v).clamp(bounds.lower, bounds.upper)).abs() < 1e-12);
            }
        }
        assert_eq!(still, 2, "one pigeon is the best, in two dimensions");
    }

    #[test]
    fn the_landmark_operator_is_eq_15() {
        let (mut slpio, problem) = started();
        let before = slpio.clone();
        slpio.approach_center(problem.bounds(), &mut stream(7, 8, 9));
        assert_eq!(slpio.flock.swarm.len(), 49);
        let worst = before.flock.sort.before(before.flock.sort.fronts() - 2);
        assert!(slpio.flock.leaving.iter().all(|pigeon| !worst.contains(pigeon)));
        let mut left = before.clone();
        left.flock.remove_worst(2);
        let mut rng = stream(7, 8, 9);
        for d in 0..2 {
            let all = before.flock.swarm.coordinate(d);
            let center = all.iter().sum::<f64>() / 51.0;
            for (x, now) in left.flock.swarm.coordinate(d).iter().zip(slpio.flock.swarm.coordinate(d)) {
                let rand = f64::from(rng.next_u32()) / 4_294_967_296.0;
                assert!((now - (x + rand * 0.05 * (center - x))).abs() < 1e-12);
            }
        }
    }
}
