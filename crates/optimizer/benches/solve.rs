//! What the optimiser itself costs: a solve of problems that cost next to nothing, and the sort inside it.

use divan::Bencher;
use optimizer::crowding::Crowding;
use optimizer::dominance::{Costs, NonDominatedSort};
use optimizer::suites::Suite;
use optimizer::{
    Bounds, Candidates, Evaluations, Mpio, MpioSettings, Mslpio, MslpioSettings, Nsga2, Nsga2Settings, Optimizer,
    Problem, stream,
};
use rand::Rng;

fn main() {
    divan::main();
}

/// Distances to two points in three dimensions: a narrow front, as most problems have.
struct TwoPoints([Bounds; 3]);

/// Nobody dominates anybody: as much work for the archive as there can be.
struct AllEqual {
    bounds: [Bounds; 3],
    objectives: usize,
}

const CUBE: [Bounds; 3] = [Bounds::new(0.0, 3.0); 3];

impl Problem for TwoPoints {
    fn bounds(&self) -> &[Bounds] {
        &self.0
    }
    fn objectives(&self) -> usize {
        2
    }
    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        let [x, y, z] = [0, 1, 2].map(|d| candidates.coordinate(d));
        let ([near, far], _) = evaluations.objectives_and_violation();
        for i in 0..candidates.len() {
            let distance =
                |to: f64| (x[i] - to) * (x[i] - to) + (y[i] - 1.0) * (y[i] - 1.0) + (z[i] - 1.0) * (z[i] - 1.0);
            near[i] = distance(1.0);
            far[i] = distance(2.0);
        }
    }
}

impl Problem for AllEqual {
    fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }
    fn objectives(&self) -> usize {
        self.objectives
    }
    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        let last = self.objectives - 1;
        evaluations.objective(last).fill(0.0);
        for k in 0..last {
            evaluations.objective(k).copy_from_slice(candidates.coordinate(k));
            for (cost, x) in evaluations.objective(last).iter_mut().zip(candidates.coordinate(k)) {
                *cost -= x;
            }
        }
    }
}

fn bench_solve(bencher: Bencher, problem: &mut dyn Problem, archive_capacity: usize) {
    let settings = MslpioSettings { archive_capacity, ..MslpioSettings::default() };
    let Ok(mut mslpio) = Mslpio::new(settings) else { return };
    let mut tick = 0;
    bencher.bench_local(|| {
        tick += 1;
        mslpio.minimise(problem, &mut stream(1, 0, tick)).map(|front| front.len())
    });
}

#[divan::bench(args = [100, 700])]
fn solve_two_points(bencher: Bencher, archive_capacity: usize) {
    bench_solve(bencher, &mut TwoPoints(CUBE), archive_capacity);
}

#[divan::bench(args = [(100, 2), (700, 2), (100, 3), (700, 3)])]
fn solve_all_equal(bencher: Bencher, (archive_capacity, objectives): (usize, usize)) {
    bench_solve(bencher, &mut AllEqual { bounds: CUBE, objectives }, archive_capacity);
}

/// ZDT1 in three dimensions: NSGA-II with 52 x 20 evaluations, the others with their 651.
#[divan::bench(args = ["NSGA-II", "MPIO", "MSLPIO"])]
fn solve_zdt1(bencher: Bencher, name: &str) {
    let settings = Nsga2Settings { population: 52, generations: 19, ..Nsga2Settings::default() };
    let optimizer: Option<Box<dyn Optimizer>> = match name {
        "NSGA-II" => Nsga2::new(settings).ok().map(|optimizer| Box::new(optimizer) as _),
        "MPIO" => Mpio::new(MpioSettings::default()).ok().map(|optimizer| Box::new(optimizer) as _),
        _ => Mslpio::new(MslpioSettings::default()).ok().map(|optimizer| Box::new(optimizer) as _),
    };
    let Some(mut optimizer) = optimizer else { return };
    let (mut problem, mut tick) = (Suite::Zdt1.problem(3, 2), 0);
    bencher.bench_local(|| {
        tick += 1;
        optimizer.minimise(&mut problem, &mut stream(1, 0, tick)).map(|front| front.len())
    });
}

#[divan::bench(args = [(52, 2), (104, 2), (52, 3), (104, 3)])]
fn sort_and_crowding(bencher: Bencher, (points, objectives): (usize, usize)) {
    let mut rng = stream(1, 2, 3);
    let values: Vec<f64> = (0..points * objectives).map(|_| f64::from(rng.next_u32())).collect();
    let violation = vec![0.0; points];
    let costs = Costs::new(&values, &violation);
    let (mut sort, mut crowding) = (NonDominatedSort::default(), Crowding::default());
    bencher.bench_local(|| {
        sort.sort(&costs);
        let mut sum = 0.0;
        for rank in 0..sort.fronts() {
            let front = sort.front(rank);
            sum += crowding.distances(front.len(), objectives, |i, k| costs.objective(k)[front[i] as usize])
                [front.len() / 2];
        }
        sum
    });
}
