//! The current generation of an optimiser: positions, and their costs.

use rand::Rng;

use crate::dominance::Costs;
use crate::optimizer::OptimizeError;
use crate::problem::{Bounds, Candidates, Evaluations, Problem};
use crate::stream::Stream;

/// Candidates and their costs, each table column after column. Keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Population {
    len: usize,
    dimensions: usize,
    objectives: usize,
    positions: Vec<f64>,
    costs: Vec<f64>,
    violation: Vec<f64>,
}

impl Population {
    /// Draws `len` positions uniformly from the bounds, dimension after dimension; then replaces the first ones by
    /// seeds.
    pub fn start(
        &mut self,
        len: usize,
        problem: &dyn Problem,
        seeds: &[f64],
        rng: &mut Stream,
    ) -> Result<(), OptimizeError> {
        let bounds = problem.bounds();
        check(bounds, problem.objectives(), seeds)?;
        self.len = len;
        self.dimensions = bounds.len();
        self.objectives = problem.objectives();
        self.positions.clear();
        for bound in bounds {
            self.positions.extend((0..len).map(|_| bound.clamp(bound.lower + uniform(rng.next_u32()) * bound.range())));
        }
        for (candidate, seed) in seeds.chunks_exact(bounds.len()).take(len).enumerate() {
            for (dimension, (bound, &coordinate)) in bounds.iter().zip(seed).enumerate() {
                self.positions[dimension * len + candidate] = bound.clamp(coordinate);
            }
        }
        Ok(())
    }

    /// Evaluates every position. A rejected candidate has infinite costs.
    pub fn evaluate(&mut self, problem: &mut dyn Problem) {
        // NaN, not the values of the last generation: an objective that the problem does not write must not be
        // inherited.
        self.costs.clear();
        self.costs.resize(self.len * self.objectives, f64::NAN);
        self.violation.clear();
        self.violation.resize(self.len, 0.0);
        problem.evaluate(
            &Candidates::new(&self.positions, self.len),
            &mut Evaluations::new(&mut self.costs, &mut self.violation),
        );
        for (candidate, violation) in self.violation.iter_mut().enumerate() {
            let costs = || (0..self.objectives).map(|k| k * self.len + candidate);
            if violation.is_finite() && costs().all(|cost| self.costs[cost].is_finite()) {
                *violation = violation.max(0.0);
            } else {
                *violation = f64::INFINITY;
                costs().for_each(|cost| self.costs[cost] = f64::INFINITY);
            }
        }
    }

    /// Makes room for `len` candidates, so that holding up to so many allocates nothing.
    pub fn reserve(&mut self, len: usize, dimensions: usize, objectives: usize) {
        self.reset(0, dimensions, objectives);
        self.positions.reserve(len * dimensions);
        self.costs.reserve(len * objectives);
        self.violation.reserve(len);
    }

    /// Makes `len` candidates with positions of 0 and no costs yet.
    pub fn reset(&mut self, len: usize, dimensions: usize, objectives: usize) {
        (self.len, self.dimensions, self.objectives) = (len, dimensions, objectives);
        self.costs.clear();
        self.violation.clear();
        self.positions.clear();
        self.positions.resize(len * dimensions, 0.0);
    }

    /// Copies one evaluated population and then another, with their costs.
    pub fn join(&mut self, first: &Self, second: &Self) {
        self.reset(0, first.dimensions, first.objectives);
        self.len = first.len + second.len;
        let join = |to: &mut Vec<f64>, first: &[f64], second: &[f64]| {
            to.extend_from_slice(first);
            to.extend_from_slice(second);
        };
        for dimension in 0..self.dimensions {
            join(&mut self.positions, first.coordinate(dimension), second.coordinate(dimension));
        }
        for objective in 0..self.objectives {
            join(&mut self.costs, first.costs().objective(objective), second.costs().objective(objective));
        }
        join(&mut self.violation, &first.violation, &second.violation);
    }

    /// Copies some candidates of an evaluated population, with their costs.
    pub fn select(&mut self, from: &Self, chosen: &[u32]) {
        self.reset(0, from.dimensions, from.objectives);
        self.len = chosen.len();
        let select = |to: &mut Vec<f64>, column: &[f64]| to.extend(chosen.iter().map(|&row| column[row as usize]));
        for dimension in 0..self.dimensions {
            select(&mut self.positions, from.coordinate(dimension));
        }
        for objective in 0..self.objectives {
            select(&mut self.costs, from.costs().objective(objective));
        }
        select(&mut self.violation, &from.violation);
    }

    /// Drops candidates, given in descending order. The costs are invalid until the next evaluation.
    pub fn remove(&mut self, dropped: &[u32]) {
        remove_rows(&mut self.positions, self.len, dropped);
        self.len -= dropped.len();
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    pub fn objectives(&self) -> usize {
        self.objectives
    }

    pub fn coordinate(&self, dimension: usize) -> &[f64] {
        &self.positions[dimension * self.len..][..self.len]
    }

    pub fn coordinate_mut(&mut self, dimension: usize) -> &mut [f64] {
        &mut self.positions[dimension * self.len..][..self.len]
    }

    pub fn candidates(&self) -> Candidates<'_> {
        Candidates::new(&self.positions, self.len)
    }

    pub fn costs(&self) -> Costs<'_> {
        Costs::new(&self.costs, &self.violation)
    }
}

/// 32 random bits as a number in [0, 1). A step of 2^-32 is fine enough, and a draw is half a 64-bit one.
pub(crate) fn uniform(bits: u32) -> f64 {
    f64::from(bits) * (1.0 / 4_294_967_296.0)
}

/// One of `count` by 32 random bits; uneven by less than `count` in 2^32.
pub(crate) fn pick(count: usize, bits: u32) -> usize {
    ((u64::from(bits) * count as u64) >> 32) as usize
}

/// Drops rows, given in descending order, from a table of `rows` kept column after column. The last takes a gap's
/// place.
pub(crate) fn remove_rows(table: &mut Vec<f64>, rows: usize, dropped: &[u32]) {
    let left = rows - dropped.len();
    for (column, start) in (0..table.len()).step_by(rows.max(1)).enumerate() {
        for (last, &gap) in (left..rows).rev().zip(dropped) {
            table[start + gap as usize] = table[start + last];
        }
        table.copy_within(start..start + left, column * left);
    }
    table.truncate(table.len() / rows.max(1) * left);
}

fn check(bounds: &[Bounds], objectives: usize, seeds: &[f64]) -> Result<(), OptimizeError> {
    if bounds.is_empty() {
        return Err(OptimizeError::NoDimensions);
    }
    if objectives == 0 {
        return Err(OptimizeError::NoObjectives);
    }
    if let Some((dimension, &Bounds { lower, upper })) = bounds.iter().enumerate().find(|(_, bound)| !bound.is_valid())
    {
        return Err(OptimizeError::InvalidBounds { dimension, lower, upper });
    }
    if !seeds.len().is_multiple_of(bounds.len()) {
        return Err(OptimizeError::SeedLength { coordinates: seeds.len(), dimensions: bounds.len() });
    }
    if !seeds.iter().all(|coordinate| coordinate.is_finite()) {
        return Err(OptimizeError::SeedNotFinite);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_bits_become_numbers_from_0_up_to_but_not_1() {
        assert_eq!(uniform(0), 0.0);
        assert_eq!(uniform(1 << 31), 0.5);
        assert!(uniform(u32::MAX) < 1.0);
    }

    #[test]
    fn rows_leave_every_column() {
        let table = [0.0, 1.0, 2.0, 3.0, 4.0, 10.0, 11.0, 12.0, 13.0, 14.0];
        let without = |dropped: &[u32]| {
            let mut table = table.to_vec();
            remove_rows(&mut table, 5, dropped);
            table
        };
        assert_eq!(without(&[]), table);
        assert_eq!(without(&[1]), [0.0, 4.0, 2.0, 3.0, 10.0, 14.0, 12.0, 13.0]);
        assert_eq!(without(&[4, 0]), [3.0, 1.0, 2.0, 13.0, 11.0, 12.0]);
        assert_eq!(without(&[4, 3, 2, 1, 0]), []);
    }
}
