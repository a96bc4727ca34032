//! The sum of a problem's objectives as its only one, for optimisers that know no other.

use crate::problem::{Bounds, Candidates, Evaluations, Problem};

/// A problem of one objective: the sum of another's, within the same bounds and constraints.
pub(crate) struct SumOfObjectives<'a> {
    pub problem: &'a mut dyn Problem,
    /// Buffers for the costs of the inner problem, kept from solve to solve.
    pub objectives: &'a mut Vec<f64>,
}

impl Problem for SumOfObjectives<'_> {
    fn bounds(&self) -> &[Bounds] {
        self.problem.bounds()
    }

    fn objectives(&self) -> usize {
        self.problem.objectives().min(1)
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        // NaN, so that an objective which the problem forgets is refused.
        self.objectives.clear();
        self.objectives.resize(candidates.len() * self.problem.objectives(), f64::NAN);
        let ([sum], violation) = evaluations.objectives_and_violation();
        self.problem.evaluate(candidates, &mut Evaluations::new(self.objectives, violation));
        sum.fill(0.0);
        for objective in self.objectives.chunks_exact(candidates.len()) {
            sum.iter_mut().zip(objective).for_each(|(sum, value)| *sum += value);
        }
    }
}
