//! The problem to optimise, which evaluates a whole generation of candidates in one call.
//!
//! Everything is a structure of arrays. A table of `len` rows is one slice, column after column, each column `len`
//! long, so that coordinate `d` (or objective `k`) of every candidate lies in one contiguous run.

use crate::dominance::Costs;

/// The interval that one coordinate of a candidate is searched in, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least value, finite.
    pub lower: f64,
    /// Greatest value, finite and not below `lower`.
    pub upper: f64,
}

impl Bounds {
    /// The interval from `lower` to `upper`.
    pub const fn new(lower: f64, upper: f64) -> Self {
        Self { lower, upper }
    }

    /// Its length.
    pub fn range(&self) -> f64 {
        self.upper - self.lower
    }

    /// The nearest value inside.
    pub fn clamp(&self, value: f64) -> f64 {
        clamp(value, self.lower, self.upper)
    }

    /// Whether both ends are finite and in order, and no further apart than 1e300, so that an update cannot overflow.
    pub fn is_valid(&self) -> bool {
        self.lower.is_finite() && self.upper.is_finite() && (0.0..=1e300).contains(&self.range())
    }
}

/// The nearest value between two limits; NaN stays NaN. Unlike the standard one it cannot panic.
pub(crate) fn clamp(value: f64, lower: f64, upper: f64) -> f64 {
    if value < lower {
        lower
    } else if value > upper {
        upper
    } else {
        value
    }
}

/// A multi-objective problem: minimise every objective, inside the bounds, without violating the constraints.
///
/// ```
/// use optimizer::{Bounds, Candidates, Evaluations, Problem};
///
/// /// Schaffer's first function: x^2 and (x - 2)^2.
/// struct Schaffer([Bounds; 1]);
///
/// impl Problem for Schaffer {
///     fn bounds(&self) -> &[Bounds] {
///         &self.0
///     }
///     fn objectives(&self) -> usize {
///         2
///     }
///     fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
///         let ([first, second], _no_constraints) = evaluations.objectives_and_violation();
///         for (i, x) in candidates.coordinate(0).iter().enumerate() {
///             first[i] = x * x;
///             second[i] = (x - 2.0) * (x - 2.0);
///         }
///     }
/// }
///
/// let (mut costs, mut violations) = ([0.0; 4], [0.0; 2]);
/// let mut evaluations = Evaluations::new(&mut costs, &mut violations);
/// Schaffer([Bounds::new(-5.0, 5.0)]).evaluate(&Candidates::new(&[1.0, 3.0], 2), &mut evaluations);
/// assert_eq!((evaluations.objective(0)[1], evaluations.objective(1)[1]), (9.0, 1.0));
/// ```
pub trait Problem {
    /// One interval per dimension. It must not change during a solve.
    fn bounds(&self) -> &[Bounds];

    /// The number of objectives, at least one. It must not change during a solve.
    fn objectives(&self) -> usize;

    /// Evaluates every candidate: writes all its objectives, and its constraint violation; see [`Evaluations`].
    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>);
}

/// A whole generation to evaluate.
#[derive(Clone, Copy, Debug)]
pub struct Candidates<'a> {
    positions: &'a [f64],
    len: usize,
}

impl<'a> Candidates<'a> {
    /// `len` candidates from their coordinates, dimension after dimension (`positions[d * len + i]`).
    /// Values after the last full column are ignored.
    pub fn new(positions: &'a [f64], len: usize) -> Self {
        Self { positions, len }
    }

    /// The number of candidates.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is nothing to evaluate. No optimiser here asks for an empty generation.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of coordinates of a candidate.
    pub fn dimensions(&self) -> usize {
        self.positions.len().checked_div(self.len).unwrap_or(0)
    }

    /// Coordinate `dimension` of every candidate. Panics if there is no such dimension, as an index does.
    pub fn coordinate(&self, dimension: usize) -> &'a [f64] {
        &self.positions[dimension * self.len..][..self.len]
    }
}

/// Where a problem writes the objectives and violations of a generation.
///
/// Violations are 0 at first: 0 is feasible, a greater violation is worse, and a negative one counts as 0. Objectives
/// are NaN at first: a candidate with an objective or a violation that is not finite is *rejected*, as if its violation
/// were infinite.
#[derive(Debug)]
pub struct Evaluations<'a> {
    objectives: &'a mut [f64],
    violation: &'a mut [f64],
}

impl<'a> Evaluations<'a> {
    /// Room for as many candidates as `violation` is long; `objectives` holds one column after another.
    pub fn new(objectives: &'a mut [f64], violation: &'a mut [f64]) -> Self {
        Self { objectives, violation }
    }

    /// The number of candidates.
    pub fn len(&self) -> usize {
        self.violation.len()
    }

    /// Whether there are no candidates.
    pub fn is_empty(&self) -> bool {
        self.violation.is_empty()
    }

    /// Objective `objective` of every candidate. Panics if there is no such objective, as an index does.
    pub fn objective(&mut self, objective: usize) -> &mut [f64] {
        let len = self.len();
        &mut self.objectives[objective * len..][..len]
    }

    /// The total constraint violation of every candidate.
    pub fn violation(&mut self) -> &mut [f64] {
        self.violation
    }

    /// The first `K` objectives and the violation at once, to be written in one pass:
    /// `let ([speed, spacing], violation) = evaluations.objectives_and_violation();`.
    /// A `K` beyond the problem's number of objectives yields empty slices for those that are not there.
    pub fn objectives_and_violation<const K: usize>(&mut self) -> ([&mut [f64]; K], &mut [f64]) {
        let mut columns = self.objectives.chunks_exact_mut(self.violation.len().max(1));
        (std::array::from_fn(|_| columns.next().unwrap_or_default()), self.violation)
    }

    /// What has been written so far.
    pub fn costs(&self) -> Costs<'_> {
        Costs::new(self.objectives, self.violation)
    }
}

/// What the optimisers' own tests solve: each coordinate is an objective.
#[cfg(test)]
pub(crate) struct Plane(pub [Bounds; 2]);

#[cfg(test)]
impl Problem for Plane {
    fn bounds(&self) -> &[Bounds] {
        &self.0
    }

    fn objectives(&self) -> usize {
        2
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        evaluations.objective(0).copy_from_slice(candidates.coordinate(0));
        evaluations.objective(1).copy_from_slice(candidates.coordinate(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_read_by_coordinate() {
        let candidates = Candidates::new(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3);
        assert_eq!((candidates.len(), candidates.dimensions()), (3, 2));
        assert_eq!(candidates.coordinate(1), [4.0, 5.0, 6.0]);
        assert_eq!(Candidates::new(&[], 0).dimensions(), 0);
    }

    #[test]
    fn evaluations_are_written_column_by_column_or_all_at_once() {
        let (mut objectives, mut violation) = ([f64::NAN; 4], [0.0; 2]);
        let mut evaluations = Evaluations::new(&mut objectives, &mut violation);
        evaluations.objective(1).copy_from_slice(&[3.0, 4.0]);
        let ([first, second], violations) = evaluations.objectives_and_violation();
        first.copy_from_slice(&[1.0, 2.0]);
        assert_eq!(second, [3.0, 4.0]);
        violations[1] = 5.0;
        let ([_, _, missing], _) = evaluations.objectives_and_violation();
        assert!(missing.is_empty());
        assert_eq!(objectives, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(violation, [0.0, 5.0]);
    }

    #[test]
    fn bounds_know_when_they_make_sense() {
        assert!(Bounds::new(0.0, 0.0).is_valid());
        assert!(!Bounds::new(1.0, 0.0).is_valid());
        assert!(!Bounds::new(f64::NAN, 0.0).is_valid());
        assert!(!Bounds::new(0.0, f64::INFINITY).is_valid());
        assert!(!Bounds::new(-f64::MAX, f64::MAX).is_valid());
        assert!(!Bounds::new(0.0, 1e301).is_valid());
        assert_eq!(Bounds::new(-1.0, 2.0).clamp(7.0), 2.0);
    }
}
