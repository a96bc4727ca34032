//! NSGA-II: Deb, Pratap, Agarwal and Meyarivan, "A fast and elitist multiobjective genetic algorithm: NSGA-II", 2002.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::archive::Archive;
use crate::crowding::Crowding;
use crate::dominance::NonDominatedSort;
use crate::optimizer::{Front, FrontBuffer, OptimizeError, Optimizer, SettingsError};
use crate::population::{Population, pick, uniform};
use crate::problem::{Bounds, Problem};
use crate::settings::{self, check_settings};
use crate::stream::Stream;
use crate::variation::{Crossover, Mutation};

/// The parameters of NSGA-II. Rates and distribution indices are those of Deb et al., section IV.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Nsga2Settings {
    /// N, parents as well as offspring of a generation; even, from 2 to 1000000. The default, 50, with 12 generations,
    /// is 650 evaluations: as near as pairs come to the 651 of the pigeon-inspired optimisers.
    pub population: usize,
    /// The number of generations of offspring, at most 1000000, without the random first population.
    pub generations: usize,
    /// p_c, the probability that two parents are crossed, from 0 to 1. Deb et al.: 0.9.
    pub crossover_probability: f64,
    /// eta_c of the simulated binary crossover, from 0 to 1000: the greater, the more similar are children to their
    /// parents. Deb et al.: 20.
    pub crossover_index: f64,
    /// How many coordinates of a child mutate on average, at least 0: p_m is this over the number of dimensions, at
    /// most 1. Deb et al.: 1, which is p_m = 1/n.
    pub mutations_per_child: f64,
    /// eta_m of the polynomial mutation, from 0 to 1000: the greater, the smaller the steps. Deb et al.: 20.
    pub mutation_index: f64,
}

impl Default for Nsga2Settings {
    fn default() -> Self {
        Self {
            population: 50,
            generations: 12,
            crossover_probability: 0.9,
            crossover_index: 20.0,
            mutations_per_child: 1.0,
            mutation_index: 20.0,
        }
    }
}

impl Nsga2Settings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// The first setting that is out of its range, with that range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        check_settings(&[
            (
                "population",
                self.population as f64,
                "even, from 2 to 1000000",
                (2..=1_000_000).contains(&self.population) && self.population.is_multiple_of(2),
            ),
            settings::iterations("generations", self.generations),
            settings::fraction("crossover_probability", self.crossover_probability),
            settings::factor("crossover_index", self.crossover_index),
            (
                "mutations_per_child",
                self.mutations_per_child,
                "from 0 to 1000000",
                (0.0..=1e6).contains(&self.mutations_per_child),
            ),
            settings::factor("mutation_index", self.mutation_index),
        ])
    }

    /// How many candidates a solve evaluates.
    pub fn evaluations(&self) -> usize {
        self.population.saturating_mul(self.generations.saturating_add(1))
    }

    /// These settings with `generations` of `candidates` each, the first included, and a front of at most one
    /// generation: what makes optimisers comparable.
    pub fn with_budget(self, candidates: usize, generations: usize) -> Self {
        Self { population: candidates, generations: generations.saturating_sub(1), ..self }
    }
}

/// The optimiser. The front returned is the first front of the last population, without duplicates in costs.
/// Constraints are in the sort (section VI); parents meet in tournaments drawn from two permutations of the population,
/// so that each is in two.
///
/// One difference from Deb et al.: of candidates with equal costs, one has the crowding distance that it would have
/// without the others, and the others have 0. So copies are removed first, and take no place of a full front from their
/// neighbours.
#[derive(Clone, Debug)]
pub struct Nsga2 {
    settings: Nsga2Settings,
    seeds: Vec<f64>,
    parents: Population,
    offspring: Population,
    /// R_t of section III-C: parents and offspring together.
    union: Population,
    sort: NonDominatedSort,
    crowding: Crowding,
    /// A front without copies, and then with them.
    originals: Vec<u32>,
    by_crowding: Vec<(f64, u32)>,
    survivors: Vec<u32>,
    /// Rank and crowding distance of each parent.
    fitness: Vec<(u32, f64)>,
    tournament: Vec<u32>,
    winners: Vec<u32>,
    /// Of each pair whether it is crossed, then whatever is drawn for one coordinate, and for which children.
    crossed: Vec<u32>,
    draws: Vec<u32>,
    chosen: Vec<u32>,
    first_front: Archive,
    front: FrontBuffer,
}

impl Nsga2 {
    /// An optimiser with these settings.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: Nsga2Settings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Ok(Self {
            settings,
            seeds: Vec::new(),
            parents: Population::default(),
            offspring: Population::default(),
            union: Population::default(),
            sort: NonDominatedSort::default(),
            crowding: Crowding::default(),
            originals: Vec::new(),
            by_crowding: Vec::new(),
            survivors: Vec::new(),
            fitness: Vec::new(),
            tournament: Vec::new(),
            winners: Vec::new(),
            crossed: Vec::new(),
            draws: Vec::new(),
            chosen: Vec::new(),
            first_front: Archive::default(),
            front: FrontBuffer::default(),
        })
    }

    /// Its settings.
    pub fn settings(&self) -> &Nsga2Settings {
        &self.settings
    }

    /// Draws P_0 at random, and reserves all buffers.
    fn initialise(&mut self, problem: &dyn Problem, rng: &mut Stream) -> Result<(), OptimizeError> {
        let size = self.settings.population;
        let started = self.parents.start(size, problem, &self.seeds, rng);
        self.seeds.clear();
        started?;
        let (dimensions, objectives) = (self.parents.dimensions(), self.parents.objectives());
        self.offspring.reserve(size, dimensions, objectives);
        self.union.reserve(2 * size, dimensions, objectives);
        self.sort.reserve(2 * size);
        self.crowding.reserve(2 * size);
        self.originals.clear();
        self.originals.reserve(2 * size);
        self.by_crowding.clear();
        self.by_crowding.reserve(2 * size);
        for buffer in [&mut self.survivors, &mut self.winners] {
            buffer.clear();
            buffer.reserve(size);
        }
        self.fitness.clear();
        self.fitness.reserve(size);
        self.tournament.clear();
        self.tournament.reserve(2 * size);
        for buffer in [&mut self.crossed, &mut self.draws, &mut self.chosen] {
            buffer.clear();
            buffer.reserve(size + 1);
        }
        self.first_front.clear(dimensions, objectives, size, size);
        self.front.reserve(self.first_front.capacity(), dimensions, objectives);
        Ok(())
    }

    /// Section III-C: of parents and offspring, the best N by (rank, crowding distance) are the next parents.
    fn survive(&mut self) {
        self.union.join(&self.parents, &self.offspring);
        let costs = self.union.costs();
        self.sort.sort(&costs);
        self.survivors.clear();
        self.fitness.clear();
        for rank in 0..self.sort.fronts() {
            let room = self.settings.population - self.survivors.len();
            if room == 0 {
                break;
            }
            self.originals.clear();
            self.by_crowding.clear();
            for &member in self.sort.front(rank) {
                match self.originals.last() {
                    Some(&original) if costs.equal(original as usize, member as usize) => {
                        self.by_crowding.push((0.0, member));
                    }
                    _ => self.originals.push(member),
                }
            }
            let cost = |i: usize, k| costs.cost(self.originals[i] as usize, k);
            let distances = self.crowding.distances(self.originals.len(), costs.objectives(), cost);
            self.by_crowding.extend(distances.iter().copied().zip(self.originals.iter().copied()));
            if self.by_crowding.len() > room {
                self.by_crowding.select_nth_unstable_by(room - 1, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
                self.by_crowding.truncate(room);
            }
            self.survivors.extend(self.by_crowding.iter().map(|&(_, survivor)| survivor));
            self.fitness.extend(self.by_crowding.iter().map(|&(distance, _)| (rank as u32, distance)));
        }
        self.parents.select(&self.union, &self.survivors);
    }

    /// The crowded-comparison operator of section III-B: the lower rank wins, then the greater distance; then the
    /// first.
    fn select_parents(&mut self, rng: &mut Stream) {
        let size = self.settings.population;
        self.tournament.clear();
        self.tournament.extend((0..size as u32).chain(0..size as u32));
        for permutation in self.tournament.chunks_exact_mut(size) {
            for last in (1..size).rev() {
                permutation.swap(last, pick(last + 1, rng.next_u32()));
            }
        }
        self.winners.clear();
        self.winners.extend(self.tournament.chunks_exact(2).map(|pair| {
            let [a, b] = [0, 1].map(|contestant| self.fitness[pair[contestant] as usize]);
            let second_wins = (b.0 < a.0) | (b.0 == a.0) & (b.1 > a.1);
            pair[usize::from(second_wins)]
        }));
    }

    /// Q_t: every two winners have two children, which are crossed and mutated.
    fn breed(&mut self, bounds: &[Bounds], rng: &mut Stream) {
        let settings = &self.settings;
        let mutation_probability = settings.mutations_per_child / bounds.len() as f64;
        let crossover = Crossover::new(settings.crossover_index);
        let mutation = Mutation::new(settings.mutation_index);
        self.offspring.reset(settings.population, bounds.len(), self.parents.objectives());
        self.crossed.resize(settings.population / 2, 0);
        rng.fill(&mut self.crossed[..]);
        for (dimension, bounds) in bounds.iter().enumerate() {
            let parents = self.parents.coordinate(dimension);
            let children = self.offspring.coordinate_mut(dimension);
            for (child, &winner) in children.iter_mut().zip(&self.winners) {
                *child = parents[winner as usize];
            }
            // Which coordinates change is decided first, without a branch; the changes are drawn only for these. That
            // halves the time.
            self.draws.resize(self.crossed.len(), 0);
            rng.fill(&mut self.draws[..]);
            let is_crossed = |(&pair, &coordinate): (&u32, &u32)| {
                (uniform(pair) < settings.crossover_probability) & (uniform(coordinate) < 0.5)
            };
            choose(&mut self.chosen, self.crossed.iter().zip(&self.draws).map(is_crossed));
            self.draws.resize(2 * self.chosen.len(), 0);
            rng.fill(&mut self.draws[..]);
            for (&pair, draws) in self.chosen.iter().zip(self.draws.chunks_exact(2)) {
                let pair = &mut children[2 * pair as usize..][..2];
                let crossed = crossover.cross([pair[0], pair[1]], *bounds, uniform(draws[0]), uniform(draws[1]) < 0.5);
                pair.copy_from_slice(&crossed);
            }
            self.draws.resize(children.len(), 0);
            rng.fill(&mut self.draws[..]);
            choose(&mut self.chosen, self.draws.iter().map(|&draw| uniform(draw) < mutation_probability));
            self.draws.resize(self.chosen.len(), 0);
            rng.fill(&mut self.draws[..]);
            for (&child, &draw) in self.chosen.iter().zip(&self.draws) {
                let child = &mut children[child as usize];
                *child = mutation.mutate(*child, *bounds, uniform(draw));
            }
        }
    }
}

/// The places at which a flag is set.
fn choose(chosen: &mut Vec<u32>, flags: impl ExactSizeIterator<Item = bool>) {
    chosen.resize(flags.len() + 1, 0);
    let mut len = 0;
    for (place, flag) in (0..).zip(flags) {
        chosen[len] = place;
        len += usize::from(flag);
    }
    chosen.truncate(len);
}

impl Optimizer for Nsga2 {
    fn name(&self) -> &'static str {
        "NSGA-II"
    }

    fn seed_candidates(&mut self, positions: &[f64]) {
        self.seeds.clear();
        self.seeds.extend_from_slice(positions);
    }

    fn minimise(&mut self, problem: &mut dyn Problem, rng: &mut Stream) -> Result<Front<'_>, OptimizeError> {
        self.initialise(problem, rng)?;
        self.parents.evaluate(problem);
        // There are no offspring yet: survival only ranks the parents.
        self.survive();
        if !self.parents.costs().violation().iter().any(|violation| violation.is_finite()) {
            return Err(OptimizeError::NoFiniteCandidate);
        }
        for _ in 0..self.settings.generations {
            self.select_parents(rng);
            self.breed(problem.bounds(), rng);
            self.offspring.evaluate(problem);
            self.survive();
        }
        self.sort.sort(&self.parents.costs());
        self.first_front.offer(&self.parents.candidates(), &self.parents.costs(), self.sort.front(0));
        self.first_front.write(&mut self.front);
        Ok(self.front.front())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Plane;

    #[test]
    fn copies_leave_a_full_front_first() {
        let settings = Nsga2Settings { population: 6, ..Nsga2Settings::default() };
        let mut nsga2 = Nsga2::new(settings).expect("in range");
        let mut problem = Plane([Bounds::new(0.0, 9.0); 2]);
        // A front of seven, of which (8.5, 0.5) is the most crowded but for the copy of (4, 4).
        nsga2.seed_candidates(&[0.0, 9.0, 1.0, 8.0, 4.0, 4.0, 4.0, 4.0, 8.0, 1.0, 9.0, 0.0]);
        nsga2.initialise(&problem, &mut crate::stream(1, 0, 0)).expect("solvable");
        nsga2.parents.evaluate(&mut problem);
        nsga2.offspring.reset(6, 2, 2);
        nsga2.offspring.coordinate_mut(0).copy_from_slice(&[8.5, 9.0, 9.0, 9.0, 9.0, 9.0]);
        nsga2.offspring.coordinate_mut(1).copy_from_slice(&[0.5, 9.0, 9.0, 9.0, 9.0, 9.0]);
        nsga2.offspring.evaluate(&mut problem);
        nsga2.survive();
        let mut left = nsga2.parents.coordinate(0).to_vec();
        left.sort_by(f64::total_cmp);
        assert_eq!(left, [0.0, 1.0, 4.0, 8.0, 8.5, 9.0]);
    }

    #[test]
    fn the_best_by_rank_and_crowding_survive() {
        struct Line([Bounds; 1]);
        impl Problem for Line {
            fn bounds(&self) -> &[Bounds] {
                &self.0
            }
            fn objectives(&self) -> usize {
                2
            }
            fn evaluate(
                &mut self,
                candidates: &crate::problem::Candidates<'_>,
                evaluations: &mut crate::problem::Evaluations<'_>,
            ) {
                for (i, x) in candidates.coordinate(0).iter().enumerate() {
                    // Beyond 1 everything is dominated by 1.
                    evaluations.objective(0)[i] = *x;
                    evaluations.objective(1)[i] = if *x <= 1.0 { 1.0 - x } else { *x };
                }
            }
        }
        let settings = Nsga2Settings { population: 4, ..Nsga2Settings::default() };
        let mut nsga2 = Nsga2::new(settings).expect("in range");
        let mut problem = Line([Bounds::new(0.0, 3.0)]);
        nsga2.seed_candidates(&[0.0, 0.5, 0.51, 2.0]);
        nsga2.initialise(&problem, &mut crate::stream(1, 0, 0)).expect("solvable");
        nsga2.parents.evaluate(&mut problem);
        nsga2.offspring.reset(4, 1, 2);
        nsga2.offspring.coordinate_mut(0).copy_from_slice(&[3.0, 1.0, 0.52, 2.5]);
        nsga2.offspring.evaluate(&mut problem);
        nsga2.survive();
        let mut left = nsga2.parents.coordinate(0).to_vec();
        left.sort_by(f64::total_cmp);
        assert_eq!(left, [0.0, 0.5, 0.52, 1.0]);
        assert!(nsga2.fitness.iter().all(|fitness| fitness.0 == 0));
        assert_eq!(nsga2.fitness.iter().filter(|fitness| fitness.1.is_infinite()).count(), 2);
    }
}
