//! The part of Algorithm 1 that all multi-objective pigeon-inspired optimisers share: everything except the update of a
//! pigeon.

use rand::Rng;

use crate::archive::Archive;
use crate::crowding::Crowding;
use crate::dominance::NonDominatedSort;
use crate::optimizer::{Front, FrontBuffer, OptimizeError};
use crate::population::{Population, remove_rows, uniform};
use crate::problem::{Bounds, Problem};
use crate::stream::Stream;

/// Pigeons with velocities, their Pareto sorting, its centre and the archive A. Keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct ParetoFlock {
    seeds: Vec<f64>,
    pub swarm: Population,
    pub velocities: Vec<f64>,
    pub sort: NonDominatedSort,
    crowding: Crowding,
    pub archive: Archive,
    /// X_center of Eq. 15 over the current generation's Pareto front.
    pub x_center: Vec<f64>,
    by_crowding: Vec<(f64, u32)>,
    /// Who left last, in descending order.
    pub leaving: Vec<u32>,
    front: FrontBuffer,
}

impl ParetoFlock {
    /// Implements [`crate::Optimizer::seed_candidates`].
    pub fn seed(&mut self, positions: &[f64]) {
        self.seeds.clear();
        self.seeds.extend_from_slice(positions);
    }

    /// Algorithm 1, "Pigeon initialization": uniform positions within the bounds and velocities within their limits.
    pub fn start(
        &mut self,
        pigeons: usize,
        velocity_limit: f64,
        archive_capacity: usize,
        problem: &dyn Problem,
        rng: &mut Stream,
    ) -> Result<(), OptimizeError> {
        let started = self.swarm.start(pigeons, problem, &self.seeds, rng);
        self.seeds.clear();
        started?;
        self.velocities.clear();
        for bounds in problem.bounds() {
            let limit = velocity_limit * bounds.range();
            self.velocities.extend((0..pigeons).map(|_| limit * (2.0 * uniform(rng.next_u32()) - 1.0)));
        }
        let (dimensions, objectives) = (self.swarm.dimensions(), self.swarm.objectives());
        self.sort.reserve(pigeons);
        self.crowding.reserve(pigeons);
        self.by_crowding.clear();
        self.by_crowding.reserve(pigeons);
        self.leaving.clear();
        self.leaving.reserve(pigeons);
        self.archive.clear(dimensions, objectives, archive_capacity, pigeons);
        self.front.reserve(self.archive.capacity(), dimensions, objectives);
        Ok(())
    }

    /// Lines 3 to 6: costs, Pareto sorting, X_center of Eq. 15 over the Pareto front, and the Pareto front into A.
    pub fn judge(&mut self, problem: &mut dyn Problem) {
        self.swarm.evaluate(problem);
        self.sort.sort(&self.swarm.costs());
        let pareto_front = self.sort.front(0);
        self.x_center.clear();
        for dimension in 0..self.swarm.dimensions() {
            let coordinate = self.swarm.coordinate(dimension);
            self.x_center.push(mean(pareto_front.iter().map(|&pigeon| coordinate[pigeon as usize])));
        }
        self.archive.offer(&self.swarm.candidates(), &self.swarm.costs(), pareto_front);
    }

    /// The same for the first generation, of which at least one candidate must not be refused.
    pub fn judge_first(&mut self, problem: &mut dyn Problem) -> Result<(), OptimizeError> {
        self.judge(problem);
        if self.archive.is_empty() { Err(OptimizeError::NoFiniteCandidate) } else { Ok(()) }
    }

    /// The first line of Eq. 18: the `removed` worst pigeons leave, by rank, then crowding (Eq. 17), then the highest
    /// index. Only a front of which some leave and some stay needs its crowding known.
    pub fn remove_worst(&mut self, removed: usize) {
        let costs = self.swarm.costs();
        self.leaving.clear();
        for rank in (0..self.sort.fronts()).rev() {
            let front = self.sort.front(rank);
            let wanted = removed - self.leaving.len();
            if front.len() <= wanted {
                self.leaving.extend_from_slice(front);
                continue;
            }
            if wanted > 0 {
                let cost = |i: usize, k| costs.cost(front[i] as usize, k);
                let distances = self.crowding.distances(front.len(), costs.objectives(), cost);
                self.by_crowding.clear();
                self.by_crowding.extend(distances.iter().copied().zip(front.iter().copied()));
                self.by_crowding.select_nth_unstable_by(wanted - 1, |a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
                self.leaving.extend(self.by_crowding[..wanted].iter().map(|&(_, pigeon)| pigeon));
            }
            break;
        }
        self.leaving.sort_unstable_by(|a, b| b.cmp(a));
        remove_rows(&mut self.velocities, self.swarm.len(), &self.leaving);
        self.swarm.remove(&self.leaving);
    }

    /// Algorithm 1, line 11: the archive.
    pub fn front(&mut self) -> Front<'_> {
        self.archive.write(&mut self.front);
        self.front.front()
    }
}

/// Algorithm 1 for an optimiser that has a flock and an update rule.
pub(crate) trait Evolve {
    fn flock(&mut self) -> &mut ParetoFlock;

    /// The update of velocities and positions (Eq. 18, or another) at iteration `nc`, counted from 1.
    fn fly(&mut self, nc: usize, bounds: &[Bounds], rng: &mut Stream);

    /// Lines 3 to 11, after the flock's start.
    fn evolve(
        &mut self,
        iterations: usize,
        removed_per_iteration: usize,
        problem: &mut dyn Problem,
        rng: &mut Stream,
    ) -> Result<Front<'_>, OptimizeError> {
        self.flock().judge_first(problem)?;
        for nc in 1..=iterations {
            self.flock().remove_worst(removed_per_iteration);
            self.fly(nc, problem.bounds(), rng);
            self.flock().judge(problem);
        }
        Ok(self.flock().front())
    }
}

/// The mean of some values that are no further apart than bounds may be; NaN of none.
pub(crate) fn mean(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let count = values.len() as f64;
    let mean = values.clone().sum::<f64>() / count;
    if mean.is_finite() {
        return mean;
    }
    // The sum of the greatest numbers overflows; their differences do not.
    let origin = values.clone().next().unwrap_or(f64::NAN);
    origin + values.map(|value| (value - origin) / count).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::mean;

    #[test]
    fn a_mean_does_not_overflow() {
        assert_eq!(mean([1.0, 2.0, 6.0].into_iter()), 3.0);
        assert_eq!(mean([1.7e308; 9].into_iter()), 1.7e308);
        assert!(mean([].into_iter()).is_nan());
    }
}
