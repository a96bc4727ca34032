//! A solve allocates only the first time.

use optimizer::selection::nearest_to_ideal;
use optimizer::{Bounds, Candidates, Evaluations, Mslpio, MslpioSettings, Optimizer, Problem, stream};

/// Three objectives, of which a constraint splits the search space.
struct Corners([Bounds; 4]);

impl Problem for Corners {
    fn bounds(&self) -> &[Bounds] {
        &self.0
    }

    fn objectives(&self) -> usize {
        3
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        let [x, y, z, w] = [0, 1, 2, 3].map(|d| candidates.coordinate(d));
        let ([a, b, c], violation) = evaluations.objectives_and_violation();
        for i in 0..candidates.len() {
            a[i] = x[i] * x[i] + y[i];
            b[i] = (1.0 - x[i]) + z[i] * z[i];
            c[i] = (1.0 - y[i]) + (w[i] - x[i]) * (w[i] - x[i]);
            violation[i] = (0.2 - z[i]).max(0.0);
        }
    }
}

#[test]
fn a_second_solve_allocates_nothing() {
    for archive_capacity in [10, 100, 700] {
        let settings = MslpioSettings { archive_capacity, ..MslpioSettings::default() };
        let mut mslpio = Mslpio::new(settings).expect("in range");
        let mut problem = Corners([Bounds::new(0.0, 1.0); 4]);
        let seed = [0.5, 0.25, 0.125, 0.0];
        let mut sizes = Vec::with_capacity(10);
        let mut solve = |tick| {
            mslpio.seed_candidates(&seed);
            let front = mslpio.minimise(&mut problem, &mut stream(1, 2, tick)).expect("solvable");
            sizes.push((front.len(), nearest_to_ideal(&front)));
        };
        let first = allocation_counter::measure(|| solve(0));
        assert!(first.count_total > 0, "nothing was counted");
        for tick in 1..10 {
            let later = allocation_counter::measure(|| solve(tick));
            assert_eq!(later.count_total, 0, "tick {tick}");
        }
        assert!(sizes.windows(2).any(|pair| pair[0] != pair[1]), "every solve was the same");
    }
}
