//! NSGA-II: Deb, Pratap, Agarwal and Meyarivan, "A fast and elitist multiobjective genetic algorithm: NSGA-II", 2002.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::archive::Archive;
use crate::crowding::Crowding;
use crate::dominance::NonDominatedSort;
use crate::optimizer::{Front, FrontBuffer, OptimizeError, Optimizer, SettingsError, check_settings};
use crate::population::{Population, pick, uniform};
use crate::problem::{Bounds, Problem};
use crate::stream::Stream;

/// The parameters of NSGA-II. Rates and distribution indices are those of Deb et al., section IV.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Nsga2Settings {
    /// N, parents as well as offspring of a generation; even, from 2 to 1000000. The default, 50, with 12 generations, is 650
    /// evaluations: as near as pairs come to the 651 of the pigeon-inspired optimisers.
    pub population: usize,
    /// How often offspring are made, at most 1000000; the random first population is not counted.
    pub generations: usize,
    /// p_c, how likely two parents are crossed at all, from 0 to 1. Deb et al.: 0.9.
    pub crossover_probability: f64,
    /// eta_c of the simulated binary crossover, from 0 to 1000: the greater, the more like their parents are children.
    /// Deb et al.: 20.
    pub crossover_index: f64,
    /// How many coordinates of a child mutate on average, at least 0: p_m is this over the number of dimensions, at most 1.
    /// Deb et al.: 1, which is p_m = 1/n.
    pub mutations_per_child: f64,
    /// eta_m of the polynomial mutation, from 0 to 1000: the greater, the smaller are its steps. Deb et al.: 20.
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
    pub fn validate(&self) -> Result<(), SettingsError> {
        let index = |index: f64| (0.0..=1000.0).contains(&index);
        check_settings(&[
            (
                "population",
                self.population as f64,
                "even, from 2 to 1000000",
                (2..=1_000_000).contains(&self.population) && self.population.is_multiple_of(2),
            ),
            ("generations", self.generations as f64, "at most 1000000", self.generations <= 1_000_000),
            (
                "crossover_probability",
                self.crossover_probability,
                "from 0 to 1",
                (0.0..=1.0).contains(&self.crossover_probability),
            ),
            ("crossover_index", self.crossover_index, "from 0 to 1000", index(self.crossover_index)),
            (
                "mutations_per_child",
                self.mutations_per_child,
                "from 0 to 1000000",
                (0.0..=1e6).contains(&self.mutations_per_child),
            ),
            ("mutation_index", self.mutation_index, "from 0 to 1000", index(self.mutation_index)),
        ])
    }

    /// How many candidates a solve evaluates.
    pub fn evaluations(&self) -> usize {
        self.population.saturating_mul(self.generations.saturating_add(1))
    }
}

/// The optimiser. The front returned is the first front of the last population, without duplicates in costs. Constraints are
/// in the sort (section VI); parents meet in tournaments drawn from two permutations of the population, so that each is in two.
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
    by_crowding: Vec<(f64, u32)>,
    survivors: Vec<u32>,
    /// Rank and crowding distance of each parent.
    fitness: Vec<(u32, f64)>,
    tournament: Vec<u32>,
    winners: Vec<u32>,
    draws: Vec<u32>,
    first_front: Archive,
    front: FrontBuffer,
}

impl Nsga2 {
    /// An optimiser with these settings.
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
            by_crowding: Vec::new(),
            survivors: Vec::new(),
            fitness: Vec::new(),
            tournament: Vec::new(),
            winners: Vec::new(),
            draws: Vec::new(),
            first_front: Archive::default(),
            front: FrontBuffer::default(),
        })
    }

    /// Its settings.
    pub fn settings(&self) -> &Nsga2Settings {
        &self.settings
    }

    /// P_0 at random, and room for everything.
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
        self.draws.clear();
        self.draws.reserve(draws(size, dimensions));
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
            let front = self.sort.front(rank);
            let distances =
                self.crowding.distances(front.len(), costs.objectives(), |i, k| costs.cost(front[i] as usize, k));
            self.by_crowding.clear();
            self.by_crowding.extend(distances.iter().copied().zip(front.iter().copied()));
            if front.len() > room {
                self.by_crowding.select_nth_unstable_by(room - 1, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
                self.by_crowding.truncate(room);
            }
            self.survivors.extend(self.by_crowding.iter().map(|&(_, survivor)| survivor));
            self.fitness.extend(self.by_crowding.iter().map(|&(distance, _)| (rank as u32, distance)));
        }
        self.parents.select(&self.union, &self.survivors);
    }

    /// The crowded-comparison operator of section III-B: the lower rank wins, then the greater distance; then the first.
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
            if b.0 < a.0 || b.0 == a.0 && b.1 > a.1 { pair[1] } else { pair[0] }
        }));
    }

    /// Q_t: every two winners have two children, which are crossed and mutated.
    fn breed(&mut self, bounds: &[Bounds], rng: &mut Stream) {
        let settings = &self.settings;
        let pairs = settings.population / 2;
        let mutation_probability = settings.mutations_per_child / bounds.len() as f64;
        let crossover = Crossover { index: settings.crossover_index };
        let mutation = Mutation { index: settings.mutation_index };
        self.offspring.reset(settings.population, bounds.len(), self.parents.objectives());
        self.draws.resize(draws(settings.population, bounds.len()), 0);
        rng.fill(&mut self.draws[..]);
        let (crossed, draws) = self.draws.split_at(pairs);
        for ((dimension, bounds), draws) in bounds.iter().enumerate().zip(draws.chunks_exact(7 * pairs)) {
            let parents = self.parents.coordinate(dimension);
            let children = self.offspring.coordinate_mut(dimension).chunks_exact_mut(2);
            let pairs = self.winners.chunks_exact(2).zip(children).zip(crossed).zip(draws.chunks_exact(7));
            for (((winners, children), &crossed), draws) in pairs {
                let mut pair = [parents[winners[0] as usize], parents[winners[1] as usize]];
                let draws: [f64; 7] = std::array::from_fn(|draw| uniform(draws[draw]));
                if uniform(crossed) < settings.crossover_probability && draws[0] < 0.5 {
                    pair = crossover.cross(pair, *bounds, draws[1], draws[2] < 0.5);
                }
                for (child, draws) in pair.iter_mut().zip(draws[3..].chunks_exact(2)) {
                    if draws[0] < mutation_probability {
                        *child = mutation.mutate(*child, *bounds, draws[1]);
                    }
                }
                children.copy_from_slice(&pair);
            }
        }
    }
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
        // Nobody yet beside the parents: survival only ranks them.
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

/// Random numbers for a generation: for each pair whether it is crossed, and 7 for each dimension of it: whether this one is
/// crossed, how far, and which child is which; and for each child whether it mutates, and how far.
fn draws(population: usize, dimensions: usize) -> usize {
    population / 2 * (1 + 7 * dimensions)
}

/// Simulated binary crossover within bounds (Deb and Agrawal 1995; bounded as in Deb's own NSGA-II): with the parents
/// y1 < y2 and u uniform in [0, 1), the children are
///
/// c1 = ((y1 + y2) - b1 (y2 - y1)) / 2 and c2 = ((y1 + y2) + b2 (y2 - y1)) / 2,
///
/// where b = (u a)^(1 / (eta + 1)) if u <= 1 / a, else (1 / (2 - u a))^(1 / (eta + 1)); a = 2 - B^-(eta + 1); and
/// B = 1 + 2 (y1 - lower) / (y2 - y1) for the first child, 1 + 2 (upper - y2) / (y2 - y1) for the second.
struct Crossover {
    index: f64,
}

impl Crossover {
    /// The two children's values, in either order. Parents as good as equal have children equal to them.
    fn cross(&self, parents: [f64; 2], bounds: Bounds, u: f64, swapped: bool) -> [f64; 2] {
        let (low, high) = if parents[0] < parents[1] { (parents[0], parents[1]) } else { (parents[1], parents[0]) };
        let gap = high - low;
        if gap.is_nan() || gap <= 1e-14 * bounds.range() {
            return parents;
        }
        // Half sums: their whole might overflow.
        let middle = 0.5 * low + 0.5 * high;
        let first = bounds.clamp(middle - 0.5 * self.spread((low - bounds.lower) / gap, u) * gap);
        let second = bounds.clamp(middle + 0.5 * self.spread((bounds.upper - high) / gap, u) * gap);
        if swapped { [second, first] } else { [first, second] }
    }

    /// b for a child whose parent is `room` gaps away from the bound.
    fn spread(&self, room: f64, u: f64) -> f64 {
        let alpha = 2.0 - power(1.0 / (1.0 + 2.0 * room), self.index + 1.0);
        let base = if u <= 1.0 / alpha { u * alpha } else { 1.0 / (2.0 - u * alpha) };
        root(base, self.index + 1.0)
    }
}

/// Polynomial mutation within bounds (Deb and Goyal 1996; bounded as in Deb's own NSGA-II): y moves by d (upper - lower),
///
/// d = (2 u + (1 - 2 u) (1 - d1)^(eta + 1))^(1 / (eta + 1)) - 1 if u <= 0.5,
/// else 1 - (2 (1 - u) + (2 u - 1) (1 - d2)^(eta + 1))^(1 / (eta + 1)),
///
/// where d1 and d2 are how far y is from the lower and from the upper bound, as fractions of the range.
struct Mutation {
    index: f64,
}

impl Mutation {
    fn mutate(&self, value: f64, bounds: Bounds, u: f64) -> f64 {
        let range = bounds.range();
        if range <= 0.0 {
            return value;
        }
        let exponent = self.index + 1.0;
        let step = if u <= 0.5 {
            let to_lower = power(1.0 - (value - bounds.lower) / range, exponent);
            root(2.0 * u + (1.0 - 2.0 * u) * to_lower, exponent) - 1.0
        } else {
            let to_upper = power(1.0 - (bounds.upper - value) / range, exponent);
            1.0 - root(2.0 * (1.0 - u) + (2.0 * u - 1.0) * to_upper, exponent)
        };
        bounds.clamp(value + step * range)
    }
}

/// A power of a base that is not negative; by multiplication alone where the exponent is whole, as it commonly is: that is
/// several times faster than `libm::pow`, and its bits are the same on every platform too.
fn power(base: f64, exponent: f64) -> f64 {
    if exponent != exponent.trunc() {
        return libm::pow(base, exponent);
    }
    // At most 1001, by validation.
    let (mut left, mut square, mut power) = (exponent as u32, base, 1.0);
    while left > 0 {
        if left % 2 == 1 {
            power *= square;
        }
        square *= square;
        left /= 2;
    }
    power
}

/// A root of a number that is not negative, by logarithm: near enough for a draw, and faster than `libm::pow`.
fn root(radicand: f64, degree: f64) -> f64 {
    libm::exp(libm::log(radicand) / degree)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Bounds = Bounds::new(0.0, 1.0);

    #[test]
    fn crossing_keeps_the_mean_far_from_the_bounds_and_never_leaves_them() {
        let crossover = Crossover { index: 20.0 };
        for u in [0.0, 0.1, 0.49, 0.51, 0.9, 0.999] {
            let wide = Bounds::new(-1e9, 1e9);
            let [a, b] = crossover.cross([4.0, 1.0], wide, u, false);
            assert!((a + b - 5.0).abs() < 1e-9, "{u}: {a} {b}");
            // Unbounded, the spread is the textbook's: (2u)^(1/21), or (1 / (2 (1 - u)))^(1/21).
            let spread = if u <= 0.5 { 2.0 * u } else { 1.0 / (2.0 * (1.0 - u)) };
            assert!((b - a - 3.0 * libm::pow(spread, 1.0 / 21.0)).abs() < 1e-6, "{u}: {a} {b}");
            let swapped = crossover.cross([4.0, 1.0], wide, u, true);
            assert_eq!(swapped, [b, a]);
            let [a, b] = Crossover { index: 0.0 }.cross([0.01, 0.9], UNIT, u, false);
            assert!((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b), "{u}: {a} {b}");
        }
        assert_eq!(crossover.cross([0.3, 0.3], UNIT, 0.7, false), [0.3, 0.3]);
    }

    #[test]
    fn mutation_moves_down_below_one_half_and_reaches_the_bounds() {
        let mutation = Mutation { index: 20.0 };
        assert!(mutation.mutate(0.5, UNIT, 0.0).abs() < 1e-6);
        assert!((mutation.mutate(0.5, UNIT, 0.5) - 0.5).abs() < 1e-12);
        assert!(mutation.mutate(0.5, UNIT, 0.2) < 0.5);
        assert!(mutation.mutate(0.5, UNIT, 0.8) > 0.5);
        assert!((mutation.mutate(0.5, UNIT, 1.0 - 1e-16) - 1.0).abs() < 1e-6);
        // By hand: u = 0.25, d1 = 1, so d = 0.5^(1/21) - 1.
        assert!((mutation.mutate(1.0, UNIT, 0.25) - 0.967_532_4).abs() < 1e-6);
        assert_eq!(mutation.mutate(2.0, Bounds::new(2.0, 2.0), 0.1), 2.0);
    }

    #[test]
    fn a_root_is_what_libm_says() {
        for radicand in [0.0, 1e-9, 0.2, 1.0, 7.0, 4e9] {
            for degree in [1.0, 16.0, 21.0, 1001.0] {
                let (ours, reference) = (root(radicand, degree), libm::pow(radicand, 1.0 / degree));
                assert!((ours - reference).abs() <= 1e-14 * reference, "{radicand}^(1/{degree})");
            }
        }
    }

    #[test]
    fn a_power_is_what_libm_says() {
        for base in [0.0, 1e-300, 0.2, 0.999, 1.0] {
            for exponent in [1.0, 2.0, 16.0, 21.0, 20.5, 1001.0] {
                let (ours, reference) = (power(base, exponent), libm::pow(base, exponent));
                assert!((ours - reference).abs() <= 1e-12 * reference, "{base}^{exponent}");
            }
        }
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
