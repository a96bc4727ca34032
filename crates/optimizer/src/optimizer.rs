//! The interface of every optimiser, and the front that a solve returns.

use crate::problem::Problem;
use crate::stream::Stream;

/// A multi-objective optimiser. It keeps its buffers between solves: make one per thread and use it again.
pub trait Optimizer: Send {
    /// Its name in reports.
    fn name(&self) -> &'static str;

    /// Candidates that the next solve starts from: the coordinates of one candidate after another. They replace as many
    /// of the random candidates of the first generation, and are clamped to the bounds; candidates beyond the
    /// population are left out. They count for one solve, whether it succeeds or not.
    fn seed_candidates(&mut self, positions: &[f64]);

    /// Minimises every objective of a problem. The front stays readable until the next call.
    ///
    /// A candidate with an objective or a violation that is not finite is rejected, as if its violation were infinite:
    /// it never enters the front.
    ///
    /// # Errors
    /// The problem or the seeds are not valid, or every candidate of the first generation is rejected.
    fn minimise(&mut self, problem: &mut dyn Problem, rng: &mut Stream) -> Result<Front<'_>, OptimizeError>;
}

/// Why a problem cannot be optimised.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OptimizeError {
    /// Nothing to search.
    #[error("the problem has no dimensions")]
    NoDimensions,
    /// Nothing to minimise.
    #[error("the problem has no objectives")]
    NoObjectives,
    /// An interval is empty, or an end or its length is not finite.
    #[error("dimension {dimension} cannot be searched from {lower} to {upper}")]
    InvalidBounds {
        /// Which one, counted from 0.
        dimension: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// The seeds do not divide into candidates.
    #[error("{coordinates} seed coordinates do not make whole candidates of {dimensions}")]
    SeedLength {
        /// How many were given.
        coordinates: usize,
        /// The problem's dimensions.
        dimensions: usize,
    },
    /// A seed is NaN or infinite.
    #[error("a seed coordinate is not a finite number")]
    SeedNotFinite,
    /// No candidate of the first generation has finite objectives and a finite violation.
    #[error("no candidate of the first generation has finite objectives and a finite violation")]
    NoFiniteCandidate,
}

/// A setting out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{setting} is {value}, which must be {range}")]
pub struct SettingsError {
    /// The field's name.
    pub setting: &'static str,
    /// What it was set to.
    pub value: f64,
    /// What it may be.
    pub range: &'static str,
}

/// The candidates that no other candidate dominates, in lexicographic order of their costs. All have the same
/// constraint violation: 0 if a feasible candidate was found. An index out of range panics, as a slice's index does.
#[derive(Clone, Copy, Debug)]
pub struct Front<'a> {
    buffer: &'a FrontBuffer,
}

impl<'a> Front<'a> {
    /// The number of members; an optimiser's front has at least one.
    pub fn len(&self) -> usize {
        self.buffer.violation.len()
    }

    /// Whether there are no members.
    pub fn is_empty(&self) -> bool {
        self.buffer.violation.is_empty()
    }

    /// The number of dimensions.
    pub fn dimensions(&self) -> usize {
        self.buffer.dimensions
    }

    /// The number of objectives.
    pub fn objectives(&self) -> usize {
        self.buffer.ideal.len()
    }

    /// Coordinate `dimension` of one member.
    pub fn position(&self, member: usize, dimension: usize) -> f64 {
        self.coordinate(dimension)[member]
    }

    /// Coordinate `dimension` of every member.
    pub fn coordinate(&self, dimension: usize) -> &'a [f64] {
        &self.buffer.positions[dimension * self.len()..][..self.len()]
    }

    /// Objective `objective` of every member.
    pub fn objective(&self, objective: usize) -> &'a [f64] {
        &self.buffer.objectives[objective * self.len()..][..self.len()]
    }

    /// The total constraint violation of every member.
    pub fn violation(&self) -> &'a [f64] {
        &self.buffer.violation
    }

    /// The least value of each objective in the front.
    pub fn ideal(&self) -> &'a [f64] {
        &self.buffer.ideal
    }

    /// The greatest value of each objective in the front.
    pub fn nadir(&self) -> &'a [f64] {
        &self.buffer.nadir
    }
}

/// The columns that a [`Front`] reads.
#[derive(Clone, Debug, Default)]
pub struct FrontBuffer {
    dimensions: usize,
    positions: Vec<f64>,
    objectives: Vec<f64>,
    violation: Vec<f64>,
    ideal: Vec<f64>,
    nadir: Vec<f64>,
}

impl FrontBuffer {
    /// Makes room for `members`, so that filling it with up to so many allocates nothing.
    pub fn reserve(&mut self, members: usize, dimensions: usize, objectives: usize) {
        self.fill(0, dimensions, objectives, |_, _| 0.0, |_, _| 0.0, |_| 0.0);
        self.positions.reserve(members * dimensions);
        self.objectives.reserve(members * objectives);
        self.violation.reserve(members);
    }

    /// Takes over `members` of a front: `position(i, d)`, `cost(i, k)` and `violation(i)` of each.
    pub fn fill(
        &mut self,
        members: usize,
        dimensions: usize,
        objectives: usize,
        position: impl Fn(usize, usize) -> f64,
        cost: impl Fn(usize, usize) -> f64,
        violation: impl Fn(usize) -> f64,
    ) {
        self.dimensions = dimensions;
        self.positions.clear();
        for dimension in 0..dimensions {
            self.positions.extend((0..members).map(|member| position(member, dimension)));
        }
        self.objectives.clear();
        self.ideal.clear();
        self.nadir.clear();
        for objective in 0..objectives {
            let costs = (0..members).map(|member| cost(member, objective));
            self.ideal.push(costs.clone().fold(f64::INFINITY, f64::min));
            self.nadir.push(costs.clone().fold(f64::NEG_INFINITY, f64::max));
            self.objectives.extend(costs);
        }
        self.violation.clear();
        self.violation.extend((0..members).map(violation));
    }

    /// What it holds.
    pub fn front(&self) -> Front<'_> {
        Front { buffer: self }
    }
}
