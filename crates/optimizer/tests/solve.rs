//! MSLPIO on problems whose fronts are known, and what it does with problems that make no sense.

#![expect(clippy::expect_used, reason = "the helpers of tests are tests")]

mod pointwise;

use optimizer::selection::nearest_to_ideal;
use optimizer::{
    Bounds, Candidates, Evaluations, Front, Mslpio, MslpioSettings, OptimizeError, Optimizer, Problem, SettingsError,
    stream,
};
use pointwise::Pointwise;
use proptest::prelude::*;
use rand::RngExt;

fn zdt1(x: &[f64], costs: &mut [f64]) -> f64 {
    let g = 1.0 + 9.0 * x[1..].iter().sum::<f64>() / (x.len() - 1) as f64;
    costs.copy_from_slice(&[x[0], g * (1.0 - (x[0] / g).sqrt())]);
    0.0
}

fn zdt3(x: &[f64], costs: &mut [f64]) -> f64 {
    zdt1(x, costs);
    costs[1] -= x[0] * libm::sin(10.0 * std::f64::consts::PI * x[0]);
    0.0
}

fn mslpio() -> Mslpio {
    Mslpio::new(MslpioSettings::default()).expect("the defaults are in range")
}

/// The area that a front of two objectives dominates below a reference point.
fn hypervolume(mut points: Vec<[f64; 2]>, reference: [f64; 2]) -> f64 {
    points.retain(|point| point[0] < reference[0] && point[1] < reference[1]);
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut area, mut height) = (0.0, reference[1]);
    for [x, y] in points {
        area += (reference[0] - x) * (height - y).max(0.0);
        height = height.min(y);
    }
    area
}

fn points(front: &Front<'_>) -> Vec<[f64; 2]> {
    front.objective(0).iter().zip(front.objective(1)).map(|(&a, &b)| [a, b]).collect()
}

/// Hypervolumes of MSLPIO and of random search with as many evaluations, over some seeds.
fn compare_with_random_search(judge: fn(&[f64], &mut [f64]) -> f64, reference: [f64; 2]) -> Vec<(f64, f64)> {
    let mut mslpio = mslpio();
    (0..20)
        .map(|seed| {
            let mut problem = Pointwise::new(&[(0.0, 1.0); 3], 2, judge);
            let front = mslpio.minimise(&mut problem, &mut stream(seed, 0, 0)).expect("solvable");
            let solved = hypervolume(points(&front), reference);
            let mut rng = stream(seed, 1, 0);
            let random = (0..problem.evaluations).map(|_| {
                let mut costs = [0.0; 2];
                judge(&rng.random::<[f64; 3]>(), &mut costs);
                costs
            });
            (solved, hypervolume(random.collect(), reference))
        })
        .collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn zdt1_is_solved_better_than_by_chance() {
    let results = compare_with_random_search(zdt1, [1.1, 1.1]);
    // The whole front dominates 1.21 - 1/3 = 0.8767 of the box.
    let (solved, random): (Vec<f64>, Vec<f64>) = results.iter().copied().unzip();
    assert!(results.iter().all(|(solved, random)| solved > random), "{results:?}");
    println!("ZDT1: MSLPIO {:.4}, random {:.4}", median(solved.clone()), median(random));
    assert!(median(solved) > 0.86, "{results:?}");
}

#[test]
fn zdt3_is_solved_better_than_by_chance() {
    let results = compare_with_random_search(zdt3, [1.1, 1.1]);
    let (solved, random): (Vec<f64>, Vec<f64>) = results.iter().copied().unzip();
    let better = results.iter().filter(|(solved, random)| solved > random).count();
    println!("ZDT3: MSLPIO {:.4}, random {:.4}, better in {better}", median(solved), median(random));
    assert!(better == results.len(), "{results:?}");
    assert!(median(results.iter().map(|result| result.0).collect()) > 1.28, "{results:?}");
}

#[test]
fn a_solve_spends_the_budget_of_the_paper() {
    let mut problem = Pointwise::new(&[(0.0, 3.0); 3], 2, zdt1);
    let mut mslpio = mslpio();
    mslpio.minimise(&mut problem, &mut stream(1, 1, 1)).expect("solvable");
    assert_eq!(mslpio.settings().population(), 51);
    assert_eq!(problem.evaluations, 651);
    assert_eq!(mslpio.settings().evaluations(), 651);
    assert!((mslpio.settings().learning_factor() - 3.302585).abs() < 1e-6);
    assert_eq!(mslpio.settings().social_influence_factor(), 0.05);
}

#[test]
fn constraints_come_before_costs() {
    // The front lies where x < 0.5 is forbidden: only there is the first objective small.
    let mut problem = Pointwise::new(&[(0.0, 1.0), (0.0, 1.0)], 2, |x, costs| {
        costs.copy_from_slice(&[x[0], 1.0 - x[0] + x[1]]);
        (0.5 - x[0]).max(0.0)
    });
    let mut mslpio = mslpio();
    let front = mslpio.minimise(&mut problem, &mut stream(5, 0, 0)).expect("solvable");
    assert!(front.violation().iter().all(|&violation| violation == 0.0));
    assert!(front.coordinate(0).iter().all(|&x| x >= 0.5));
    assert!(front.ideal()[0] < 0.51);
}

#[test]
fn where_nothing_is_feasible_the_least_violation_wins() {
    let mut problem = Pointwise::new(&[(0.0, 1.0)], 2, |x, costs| {
        costs.copy_from_slice(&[x[0], -x[0]]);
        1.0 + (x[0] - 0.25).abs()
    });
    let mut mslpio = mslpio();
    let front = mslpio.minimise(&mut problem, &mut stream(5, 0, 0)).expect("solvable");
    assert_eq!(front.len(), 1);
    assert!((front.position(0, 0) - 0.25).abs() < 0.01);
}

#[test]
fn what_is_not_finite_never_enters_the_front() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut problem = Pointwise::new(&[(0.0, 1.0), (0.0, 1.0)], 2, |x, costs| {
            costs.copy_from_slice(&[if x[0] < 0.5 { bad } else { x[0] }, 1.0 - x[0]]);
            if x[1] < 0.5 { f64::NAN } else { 0.0 }
        });
        let mut mslpio = mslpio();
        let front = mslpio.minimise(&mut problem, &mut stream(9, 0, 0)).expect("some are finite");
        assert!(front.coordinate(0).iter().chain(front.coordinate(1)).all(|&x| x >= 0.5));
        assert!(front.objective(0).iter().all(|cost| cost.is_finite()));
    }
}

#[test]
fn where_nothing_is_finite_there_is_no_front() {
    let mut mslpio = mslpio();
    let mut nan = Pointwise::new(&[(0.0, 1.0)], 2, |_, costs| {
        costs.fill(f64::NAN);
        0.0
    });
    assert_eq!(mslpio.minimise(&mut nan, &mut stream(1, 0, 0)).err(), Some(OptimizeError::NoFiniteCandidate));
    let mut infinite = Pointwise::new(&[(0.0, 1.0)], 2, |_, _| f64::INFINITY);
    assert_eq!(mslpio.minimise(&mut infinite, &mut stream(1, 0, 0)).err(), Some(OptimizeError::NoFiniteCandidate));
    let mut solvable = Pointwise::new(&[(0.0, 1.0), (0.0, 1.0)], 2, zdt1);
    assert!(mslpio.minimise(&mut solvable, &mut stream(1, 0, 0)).is_ok(), "an error leaves nothing behind");
}

#[test]
fn an_objective_that_is_not_written_is_refused() {
    struct Forgetful([Bounds; 1]);
    impl Problem for Forgetful {
        fn bounds(&self) -> &[Bounds] {
            &self.0
        }
        fn objectives(&self) -> usize {
            2
        }
        fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
            evaluations.objective(0).copy_from_slice(candidates.coordinate(0));
        }
    }
    let mut problem = Forgetful([Bounds::new(0.0, 1.0)]);
    assert_eq!(mslpio().minimise(&mut problem, &mut stream(1, 0, 0)).err(), Some(OptimizeError::NoFiniteCandidate));
}

#[test]
fn problems_that_make_no_sense_are_refused() {
    let refused = |bounds: &[(f64, f64)], objectives| {
        let mut problem = Pointwise::new(bounds, objectives, |_, _| 0.0);
        mslpio().minimise(&mut problem, &mut stream(1, 0, 0)).err()
    };
    assert_eq!(refused(&[], 2), Some(OptimizeError::NoDimensions));
    assert_eq!(refused(&[(0.0, 1.0)], 0), Some(OptimizeError::NoObjectives));
    let reversed = refused(&[(0.0, 1.0), (1.0, 0.0)], 2);
    assert_eq!(reversed, Some(OptimizeError::InvalidBounds { dimension: 1, lower: 1.0, upper: 0.0 }));
}

#[test]
fn seeds_start_the_next_solve_and_only_that() {
    let is_seed = |x: &[f64]| x == [0.25, 0.75];
    let mut mslpio = mslpio();
    let mut seen = 0;
    let mut problem = Pointwise::new(&[(0.0, 1.0), (0.0, 1.0)], 2, |x, costs| {
        seen += usize::from(is_seed(x));
        costs.fill(if is_seed(x) { -1.0 } else { x[0] });
        0.0
    });
    mslpio.seed_candidates(&[0.25, 0.75, 9.0, -9.0]);
    let front = mslpio.minimise(&mut problem, &mut stream(1, 0, 0)).expect("solvable");
    assert_eq!((front.len(), front.position(0, 0), front.position(0, 1)), (1, 0.25, 0.75));
    assert!(problem.kept_bounds);
    let front = mslpio.minimise(&mut problem, &mut stream(1, 0, 1)).expect("solvable");
    assert!(front.objective(0)[0] >= 0.0);
    drop(problem);
    assert_eq!(seen, 1);
}

#[test]
fn seeds_that_make_no_sense_are_refused_once() {
    let mut problem = Pointwise::new(&[(0.0, 1.0), (0.0, 1.0)], 2, zdt1);
    let mut mslpio = mslpio();
    mslpio.seed_candidates(&[0.5; 3]);
    let length = OptimizeError::SeedLength { coordinates: 3, dimensions: 2 };
    assert_eq!(mslpio.minimise(&mut problem, &mut stream(1, 0, 0)).err(), Some(length));
    mslpio.seed_candidates(&[0.5, f64::NAN]);
    assert_eq!(mslpio.minimise(&mut problem, &mut stream(1, 0, 0)).err(), Some(OptimizeError::SeedNotFinite));
    mslpio.seed_candidates(&[0.5; 2 * 1000]);
    assert!(mslpio.minimise(&mut problem, &mut stream(1, 0, 0)).is_ok());
    assert!(mslpio.minimise(&mut problem, &mut stream(1, 0, 0)).is_ok());
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    type Change = fn(&mut MslpioSettings);
    let changes: [(&str, Change); 10] = [
        ("base_population", |s| s.base_population = 0),
        ("base_population", |s| s.base_population = usize::MAX),
        ("dimension_setting", |s| s.dimension_setting = 0),
        ("dimension_setting", |s| s.dimension_setting = 51),
        ("social_coefficient", |s| s.social_coefficient = f64::NAN),
        ("map_and_compass_factor", |s| s.map_and_compass_factor = 1.5),
        ("iterations", |s| (s.iterations, s.removed_per_iteration) = (usize::MAX, 0)),
        ("removed_per_iteration", |s| s.removed_per_iteration = 3),
        ("velocity_limit", |s| s.velocity_limit = 0.0),
        ("archive_capacity", |s| s.archive_capacity = 0),
    ];
    for (name, change) in changes {
        let mut settings = MslpioSettings::default();
        change(&mut settings);
        assert_eq!(settings.validate().map_err(|SettingsError { setting, .. }| setting), Err(name));
        assert!(Mslpio::new(settings).is_err());
    }
}

#[test]
fn the_last_pigeon_may_fly_alone() {
    let settings = MslpioSettings { removed_per_iteration: 5, iterations: 10, ..MslpioSettings::default() };
    let mut problem = Pointwise::new(&[(0.0, 1.0); 3], 2, zdt1);
    let mut mslpio = Mslpio::new(settings).expect("in range");
    assert!(mslpio.minimise(&mut problem, &mut stream(1, 0, 0)).is_ok());
    assert_eq!(problem.evaluations, (0..=10).map(|nc| 51 - 5 * nc).sum::<usize>());
}

fn bits(front: &Front<'_>) -> Vec<u64> {
    let columns =
        (0..front.dimensions()).map(|d| front.coordinate(d)).chain((0..front.objectives()).map(|k| front.objective(k)));
    columns.flatten().map(|value| value.to_bits()).collect()
}

#[test]
fn the_same_stream_gives_the_same_bits() {
    let mut problem = Pointwise::new(&[(0.0, 1.0); 3], 2, zdt3);
    let (mut used, mut fresh) = (mslpio(), mslpio());
    let first = bits(&used.minimise(&mut problem, &mut stream(1, 2, 3)).expect("solvable"));
    let other = bits(&used.minimise(&mut problem, &mut stream(1, 2, 4)).expect("solvable"));
    assert_ne!(first, other);
    assert_eq!(first, bits(&used.minimise(&mut problem, &mut stream(1, 2, 3)).expect("solvable")));
    assert_eq!(first, bits(&fresh.minimise(&mut problem, &mut stream(1, 2, 3)).expect("solvable")));
}

/// Pins every bit of one solve: it changes only on purpose, and never with the platform.
#[test]
fn golden_solve() {
    let mut problem = Pointwise::new(&[(0.0, 1.0); 3], 2, zdt1);
    let mut mslpio = mslpio();
    let front = mslpio.minimise(&mut problem, &mut stream(1, 2, 3)).expect("solvable");
    // FNV-1a over words.
    let hash =
        bits(&front).iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, word| (hash ^ word).wrapping_mul(0x0100_0000_01b3));
    assert_eq!((front.len(), hash), (372, 0x4903_b36a_8c8f_f5f3), "{hash:#x}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn bounds_are_kept_and_the_front_is_non_dominated(
        bounds in prop::collection::vec((-1e3..1e3f64, prop_oneof![Just(0.0), 1e-9..1e6f64]), 1..7),
        objectives in 1usize..5,
        seed in any::<u64>(),
        archive_capacity in 1usize..100,
    ) {
        let bounds: Vec<(f64, f64)> = bounds.into_iter().map(|(lower, range)| (lower, lower + range)).collect();
        let mut problem = Pointwise::new(&bounds, objectives, |x, costs| {
            for (k, cost) in costs.iter_mut().enumerate() {
                *cost = x.iter().enumerate().map(|(d, x)| (x - (k * d) as f64).abs()).sum();
            }
            (1.0 - x[0]).max(0.0)
        });
        let settings = MslpioSettings { archive_capacity, ..MslpioSettings::default() };
        let mut mslpio = Mslpio::new(settings).expect("in range");
        let front = mslpio.minimise(&mut problem, &mut stream(seed, 0, 0)).expect("solvable");
        prop_assert!(problem.kept_bounds);
        prop_assert!(!front.is_empty());
        prop_assert!(nearest_to_ideal(&front) < front.len());
        for a in 0..front.len() {
            prop_assert_eq!(front.violation()[a], front.violation()[0]);
            for b in (0..front.len()).filter(|&b| b != a) {
                prop_assert!((0..objectives).any(|k| front.objective(k)[a] < front.objective(k)[b]));
            }
        }
    }
}
