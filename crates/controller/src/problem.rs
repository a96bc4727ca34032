//! The choice of weights as an optimisation problem: one look-ahead flight for every pigeon of a generation.

use crate::WeightKind;
use crate::lanes::{LANES, Lanes};
use crate::look_ahead::{LookAhead, Outcome, Scene};
use multiversion::multiversion;
use optimizer::{Bounds, Candidates, Evaluations, Problem};

/// The objectives are Eq. 11 and 12, the violation that of the two constraints.
pub struct WeightProblem<'a> {
    pub look_ahead: &'a LookAhead,
    pub scene: Scene<'a>,
    pub kind: WeightKind,
    pub bounds: &'a [Bounds],
}

impl Problem for WeightProblem<'_> {
    fn bounds(&self) -> &[Bounds] {
        self.bounds
    }

    fn objectives(&self) -> usize {
        2
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        let mut start = 0;
        while start < candidates.len() {
            let end = (start + LANES).min(candidates.len());
            let weights = match self.kind {
                WeightKind::Shared => [Lanes::load(&candidates.coordinate(0)[start..end]); 3],
                WeightKind::PerTerm => {
                    [0, 1, 2].map(|term| Lanes::load(&candidates.coordinate(term)[start..end]))
                }
            };
            let outcome = fly(self.look_ahead, &self.scene, &weights);
            outcome.cost_1.store(&mut evaluations.objective(0)[start..end]);
            outcome.cost_2.store(&mut evaluations.objective(1)[start..end]);
            outcome.violation_m.store(&mut evaluations.violation()[start..end]);
            start = end;
        }
    }
}

/// The look-ahead compiled for what vector instructions the machine has: the same operations, so the same bits.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn fly(look_ahead: &LookAhead, scene: &Scene<'_>, weights: &[Lanes; 3]) -> Outcome {
    look_ahead.fly(scene, weights)
}
