//! A problem of a test, given by what it says of one candidate.

use optimizer::{Bounds, Candidates, Evaluations, Problem};

/// Any problem that judges one candidate at a time.
pub struct Pointwise<F> {
    bounds: Vec<Bounds>,
    objectives: usize,
    /// Position to objectives and violation.
    judge: F,
    /// How many candidates were judged.
    pub evaluations: usize,
    /// Whether all of them were within bounds.
    pub kept_bounds: bool,
}

impl<F: FnMut(&[f64], &mut [f64]) -> f64> Pointwise<F> {
    pub fn new(bounds: &[(f64, f64)], objectives: usize, judge: F) -> Self {
        let bounds = bounds.iter().map(|&(lower, upper)| Bounds::new(lower, upper)).collect();
        Self { bounds, objectives, judge, evaluations: 0, kept_bounds: true }
    }
}

impl<F: FnMut(&[f64], &mut [f64]) -> f64> Problem for Pointwise<F> {
    fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        assert_eq!(candidates.len(), evaluations.len());
        assert_eq!(candidates.dimensions(), self.bounds.len());
        self.evaluations += candidates.len();
        let mut costs = vec![0.0; self.objectives];
        for i in 0..candidates.len() {
            let position: Vec<f64> = (0..candidates.dimensions()).map(|d| candidates.coordinate(d)[i]).collect();
            self.kept_bounds &=
                position.iter().zip(&self.bounds).all(|(x, bounds)| (bounds.lower..=bounds.upper).contains(x));
            evaluations.violation()[i] = (self.judge)(&position, &mut costs);
            for (k, cost) in costs.iter().enumerate() {
                evaluations.objective(k)[i] = *cost;
            }
        }
    }
}
