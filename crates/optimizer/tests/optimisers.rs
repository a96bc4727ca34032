//! What every optimiser here promises, asked of each of them.

#![expect(clippy::expect_used, reason = "the helpers of tests are tests")]

mod pointwise;

use optimizer::indicators::{hypervolume, igd_plus, rows};
use optimizer::suites::Suite;
use optimizer::{
    Algorithm, Bounds, Candidates, Evaluations, Front, Mpio, MpioSettings, Nsga2, Nsga2Settings, OptimizeError,
    Optimizer, OptimizerSettings, Problem, Random, RandomSettings, SettingsError, Slpio, SlpioSettings, stream,
};
use pointwise::Pointwise;
use proptest::prelude::*;
use rand::RngExt;

/// Each optimiser with the number of evaluations that it promises and the most objectives that it takes.
fn optimisers() -> Vec<(Box<dyn Optimizer>, usize, usize)> {
    let each = |&algorithm: &Algorithm| {
        let settings = OptimizerSettings { algorithm, ..OptimizerSettings::default() };
        let most = if algorithm == Algorithm::Slpio { 1 } else { usize::MAX };
        (settings.build().expect("in range"), settings.evaluations(), most)
    };
    Algorithm::ALL.iter().map(each).collect()
}

/// The first objective is x, and the others pull against it.
fn trade_off(x: &[f64], costs: &mut [f64]) -> f64 {
    for (k, cost) in costs.iter_mut().enumerate() {
        *cost = x.iter().map(|x| (x - k as f64) * (x - k as f64)).sum();
    }
    0.0
}

/// FNV-1a over the bits of a front.
fn hash(front: &Front<'_>) -> u64 {
    let positions = (0..front.dimensions()).flat_map(|d| front.coordinate(d));
    let words = positions.chain((0..front.objectives()).flat_map(|k| front.objective(k))).map(|value| value.to_bits());
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn a_solve_spends_the_evaluations_that_its_settings_promise() {
    for (mut optimizer, promised, most) in optimisers() {
        let mut problem = Pointwise::new(&[(0.0, 3.0); 3], most.min(2), trade_off);
        optimizer.minimise(&mut problem, &mut stream(1, 1, 1)).expect("solvable");
        assert_eq!(problem.evaluations, promised, "{}", optimizer.name());
        assert!((650..=651).contains(&promised), "{}: {promised}", optimizer.name());
    }
}

#[test]
fn constraints_come_before_costs() {
    for (mut optimizer, _, most) in optimisers() {
        let mut problem = Pointwise::new(&[(0.0, 1.0); 2], most.min(2), |x, costs| {
            trade_off(x, costs);
            (0.5 - x[0]).max(0.0)
        });
        let front = optimizer.minimise(&mut problem, &mut stream(5, 0, 0)).expect("solvable");
        assert!(front.violation().iter().all(|&violation| violation == 0.0));
        assert!(front.coordinate(0).iter().all(|&x| x >= 0.5));
        assert!(front.ideal()[0] < 0.5, "{:?}", front.ideal());
    }
}

#[test]
fn what_is_not_finite_never_enters_the_front() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (mut optimizer, _, most) in optimisers() {
            let mut problem = Pointwise::new(&[(0.0, 1.0); 2], most.min(2), |x, costs| {
                trade_off(x, costs);
                if x[0] < 0.5 {
                    costs[0] = bad;
                }
                if x[1] < 0.5 { bad } else { 0.0 }
            });
            let front = optimizer.minimise(&mut problem, &mut stream(9, 0, 0)).expect("some are finite");
            assert!(front.coordinate(0).iter().chain(front.coordinate(1)).all(|&x| x >= 0.5));
            assert!((0..front.objectives()).flat_map(|k| front.objective(k)).all(|cost| cost.is_finite()));
        }
    }
}

#[test]
fn what_makes_no_sense_is_refused_and_leaves_nothing_behind() {
    for (mut optimizer, _, most) in optimisers() {
        let objectives = most.min(2);
        let mut refused = |bounds: &[(f64, f64)], objectives, seeds: &[f64], cost: f64| {
            let mut problem = Pointwise::new(bounds, objectives, |_, costs| {
                costs.fill(cost);
                0.0
            });
            optimizer.seed_candidates(seeds);
            let error = optimizer.minimise(&mut problem, &mut stream(1, 0, 0)).err();
            let mut solvable = Pointwise::new(&[(0.0, 1.0); 2], most.min(2), trade_off);
            assert!(optimizer.minimise(&mut solvable, &mut stream(1, 0, 0)).is_ok());
            error
        };
        assert_eq!(refused(&[], objectives, &[], 0.0), Some(OptimizeError::NoDimensions));
        assert_eq!(refused(&[(0.0, 1.0)], 0, &[], 0.0), Some(OptimizeError::NoObjectives));
        let reversed = OptimizeError::InvalidBounds { dimension: 1, lower: 1.0, upper: 0.0 };
        assert_eq!(refused(&[(0.0, 1.0), (1.0, 0.0)], objectives, &[], 0.0), Some(reversed));
        let length = OptimizeError::SeedLength { coordinates: 3, dimensions: 2 };
        assert_eq!(refused(&[(0.0, 1.0); 2], objectives, &[0.5; 3], 0.0), Some(length));
        assert_eq!(refused(&[(0.0, 1.0)], objectives, &[f64::NAN], 0.0), Some(OptimizeError::SeedNotFinite));
        assert_eq!(refused(&[(0.0, 1.0)], objectives, &[], f64::NAN), Some(OptimizeError::NoFiniteCandidate));
    }
}

#[test]
fn the_single_objective_optimiser_minimises_the_sum_of_several() {
    let mut slpio = Slpio::new(SlpioSettings::default()).expect("in range");
    // (x - 0.2)^2 + (x - 0.8)^2 + x has its least value at x = 0.25.
    let mut several = Pointwise::new(&[(0.0, 1.0)], 3, |x, costs| {
        costs.copy_from_slice(&[(x[0] - 0.2) * (x[0] - 0.2), (x[0] - 0.8) * (x[0] - 0.8), x[0]]);
        0.0
    });
    let front = slpio.minimise(&mut several, &mut stream(1, 0, 0)).expect("solvable");
    assert_eq!((front.len(), front.objectives()), (1, 1));
    assert!((front.position(0, 0) - 0.25).abs() < 1e-3);
    let mut forgetful = Pointwise::new(&[(0.0, 1.0)], 2, |x, costs| {
        costs.copy_from_slice(&[x[0], f64::NAN]);
        0.0
    });
    let refused = slpio.minimise(&mut forgetful, &mut stream(1, 0, 0)).err();
    assert_eq!(refused, Some(OptimizeError::NoFiniteCandidate));
}

#[test]
fn seeds_start_the_next_solve_and_only_that() {
    for (mut optimizer, _, most) in optimisers() {
        let is_seed = |x: &[f64]| x == [0.25, 0.75];
        let mut seen = 0;
        let mut problem = Pointwise::new(&[(0.0, 1.0); 2], most.min(2), |x, costs| {
            seen += usize::from(is_seed(x));
            costs.fill(if is_seed(x) { -1.0 } else { x[0] });
            0.0
        });
        optimizer.seed_candidates(&[0.25, 0.75, 9.0, -9.0]);
        let front = optimizer.minimise(&mut problem, &mut stream(1, 0, 0)).expect("solvable");
        assert_eq!((front.len(), front.position(0, 0), front.position(0, 1)), (1, 0.25, 0.75));
        assert!(problem.kept_bounds);
        let front = optimizer.minimise(&mut problem, &mut stream(1, 0, 1)).expect("solvable");
        assert!(front.objective(0)[0] >= 0.0);
        drop(problem);
        assert!(seen >= 1, "the seed was never judged");
    }
}

/// Pins every bit of one solve of each: it changes only on purpose, and never with the platform.
#[test]
fn golden_solves() {
    let hashes: Vec<(&str, usize, u64)> = optimisers()
        .iter_mut()
        .map(|(optimizer, _, most)| {
            let mut problem = Pointwise::new(&[(-0.5, 1.5), (-1.0, 2.0), (0.0, 3.0)], 2.min(*most), trade_off);
            let name = optimizer.name();
            let front = optimizer.minimise(&mut problem, &mut stream(1, 2, 3)).expect("solvable");
            let first = (name, front.len(), hash(&front));
            let other = hash(&optimizer.minimise(&mut problem, &mut stream(1, 2, 4)).expect("solvable"));
            assert_ne!(first.2, other);
            let again = hash(&optimizer.minimise(&mut problem, &mut stream(1, 2, 3)).expect("solvable"));
            assert_eq!(first.2, again, "{name} remembers");
            first
        })
        .collect();
    let golden: [(&str, usize, u64); 5] = [
        ("MSLPIO", 48, 0x6d62_b442_0d05_cff6),
        ("MPIO", 145, 0xb319_5bd1_97c0_fea9),
        ("NSGA-II", 50, 0x5266_8c60_b6bb_6f4a),
        ("SL-PIO", 1, 0x337b_49a0_6838_0ef3),
        ("Random", 18, 0x836e_9b06_cea4_9956),
    ];
    assert_eq!(hashes, golden, "{hashes:#x?}");
}

#[test]
fn a_second_solve_allocates_nothing() {
    struct Sums {
        bounds: [Bounds; 4],
        objectives: usize,
    }
    impl Problem for Sums {
        fn bounds(&self) -> &[Bounds] {
            &self.bounds
        }
        fn objectives(&self) -> usize {
            self.objectives
        }
        fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
            for k in 0..self.objectives {
                let (x, y) = (candidates.coordinate(k), candidates.coordinate(3));
                for (i, cost) in evaluations.objective(k).iter_mut().enumerate() {
                    *cost = x[i] + (y[i] - k as f64) * (y[i] - k as f64);
                }
            }
            for (violation, z) in evaluations.violation().iter_mut().zip(candidates.coordinate(2)) {
                *violation = (0.2 - z).max(0.0);
            }
        }
    }
    for (mut optimizer, _, most) in optimisers() {
        let mut problem = Sums { bounds: [Bounds::new(0.0, 1.0); 4], objectives: most.min(3) };
        let mut solve = |tick| {
            optimizer.seed_candidates(&[0.5, 0.25, 0.125, 0.0]);
            optimizer.minimise(&mut problem, &mut stream(1, 2, tick)).expect("solvable").len()
        };
        assert!(allocation_counter::measure(|| drop(solve(0).to_string())).count_total > 1, "nothing was counted");
        for tick in 1..10 {
            let later = allocation_counter::measure(|| assert!(solve(tick) > 0));
            assert_eq!(later.count_total, 0, "tick {tick}");
        }
    }
}

/// The median over some seeds of how much of the box below a reference a front dominates, and of its IGD+.
fn medians(optimizer: &mut dyn Optimizer, suite: Suite, reference: &[f64]) -> (f64, f64) {
    let mut problem = suite.problem(3, reference.len());
    let true_front = problem.pareto_front(if reference.len() == 2 { 500 } else { 20 });
    let mut figures: Vec<(f64, f64)> = (0..15)
        .map(|seed| {
            let points = rows(&optimizer.minimise(&mut problem, &mut stream(seed, 0, 0)).expect("solvable"));
            let volume = hypervolume(&points, reference).expect("finite");
            (volume, igd_plus(&points, &true_front).expect("finite"))
        })
        .collect();
    figures.sort_by(|a, b| a.0.total_cmp(&b.0));
    let volume = figures[7].0;
    figures.sort_by(|a, b| a.1.total_cmp(&b.1));
    (volume, figures[7].1)
}

#[test]
fn zdt1_is_solved_better_than_by_chance() {
    let figures = |optimizer: &mut dyn Optimizer| medians(optimizer, Suite::Zdt1, &[1.1, 1.1]);
    let (chance, by_chance) = figures(&mut Random::new(RandomSettings::default()).expect("in range"));
    for (optimizer, _, _) in optimisers().iter_mut().filter(|optimiser| optimiser.2 > 1) {
        let (volume, distance) = figures(optimizer.as_mut());
        println!("{}: hypervolume {volume:.4}, by chance {chance:.4}; IGD+ {distance:.4}", optimizer.name());
        assert!(optimizer.name() == "Random" || volume > chance && distance < by_chance, "{}", optimizer.name());
    }
}

/// The experiment of Deb et al., section IV: 25,000 evaluations of 30 (ZDT1-3) or 10 (ZDT4, 6) variables.
#[test]
fn nsga2_converges_where_its_paper_does() {
    let settings = Nsga2Settings { population: 100, generations: 249, ..Nsga2Settings::default() };
    let mut nsga2 = Nsga2::new(settings).expect("in range");
    for (suite, dimensions, limit) in [
        (Suite::Zdt1, 30, 0.02),
        (Suite::Zdt2, 30, 0.02),
        (Suite::Zdt3, 30, 0.02),
        (Suite::Zdt4, 10, 0.6),
        (Suite::Zdt6, 10, 0.05),
    ] {
        let mut problem = suite.problem(dimensions, 2);
        let points = rows(&nsga2.minimise(&mut problem, &mut stream(1, 0, 0)).expect("solvable"));
        let distance = igd_plus(&points, &problem.pareto_front(500)).expect("finite");
        println!("NSGA-II {} after 25000 evaluations: IGD+ {distance:.4}", suite.name());
        assert!(distance < limit, "{}: {distance}", suite.name());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn bounds_are_kept_and_the_front_is_non_dominated(
        bounds in prop::collection::vec((-1e3..1e3f64, prop_oneof![Just(0.0), 1e-9..1e6f64]), 1..6),
        objectives in 1usize..5,
        seed in any::<u64>(),
    ) {
        let bounds: Vec<(f64, f64)> = bounds.into_iter().map(|(lower, range)| (lower, lower + range)).collect();
        for (mut optimizer, promised, most) in optimisers() {
            let objectives = objectives.min(most);
            let mut problem = Pointwise::new(&bounds, objectives, |x, costs| {
                for (k, cost) in costs.iter_mut().enumerate() {
                    *cost = x.iter().enumerate().map(|(d, x)| (x - (k * d) as f64).abs()).sum();
                }
                (1.0 - x[0]).max(0.0)
            });
            let front = optimizer.minimise(&mut problem, &mut stream(seed, 0, 0)).expect("solvable");
            prop_assert!(problem.kept_bounds);
            prop_assert_eq!(problem.evaluations, promised);
            prop_assert!(!front.is_empty());
            for a in 0..front.len() {
                prop_assert_eq!(front.violation()[a], front.violation()[0]);
                for b in (0..front.len()).filter(|&b| b != a) {
                    prop_assert!((0..objectives).any(|k| front.objective(k)[a] < front.objective(k)[b]));
                }
            }
        }
    }

    /// Bounds near the greatest numbers overflow nowhere.
    #[test]
    fn extreme_bounds_are_kept(
        lower in prop_oneof![Just(-1.7e308), Just(1.6e308), Just(-5e299)], seed in any::<u64>(),
    ) {
        for (mut optimizer, _, most) in optimisers() {
            let mut problem = Pointwise::new(&[(lower, lower + 9e299); 2], most.min(2), |x, costs| {
                costs.copy_from_slice(&[x[0], -x[1]][..costs.len()]);
                0.0
            });
            let front = optimizer.minimise(&mut problem, &mut stream(seed, 0, 0)).expect("solvable");
            prop_assert!(!front.is_empty());
            prop_assert!(problem.kept_bounds);
        }
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let name = |result: Result<(), SettingsError>| result.err().map(|error| error.setting);
    let mpio = MpioSettings::default();
    assert_eq!(name(MpioSettings { population: 0, ..mpio }.validate()), Some("population"));
    assert_eq!(name(MpioSettings { map_and_compass_factor: -0.1, ..mpio }.validate()), Some("map_and_compass_factor"));
    assert_eq!(name(MpioSettings { transition_factor: f64::NAN, ..mpio }.validate()), Some("transition_factor"));
    assert_eq!(name(MpioSettings { removed_per_iteration: 3, ..mpio }.validate()), Some("removed_per_iteration"));
    assert_eq!(name(MpioSettings { velocity_limit: 1.1, ..mpio }.validate()), Some("velocity_limit"));
    assert_eq!(name(MpioSettings { archive_capacity: 0, ..mpio }.validate()), Some("archive_capacity"));
    let many = MpioSettings { iterations: usize::MAX, removed_per_iteration: 0, ..mpio };
    assert_eq!(name(many.validate()), Some("iterations"));

    let nsga2 = Nsga2Settings::default();
    assert_eq!(name(Nsga2Settings { population: 51, ..nsga2 }.validate()), Some("population"));
    assert_eq!(name(Nsga2Settings { population: 0, ..nsga2 }.validate()), Some("population"));
    assert_eq!(name(Nsga2Settings { generations: usize::MAX, ..nsga2 }.validate()), Some("generations"));
    assert_eq!(name(Nsga2Settings { crossover_probability: 1.5, ..nsga2 }.validate()), Some("crossover_probability"));
    assert_eq!(name(Nsga2Settings { crossover_index: -1.0, ..nsga2 }.validate()), Some("crossover_index"));
    assert_eq!(name(Nsga2Settings { mutations_per_child: f64::NAN, ..nsga2 }.validate()), Some("mutations_per_child"));
    assert_eq!(name(Nsga2Settings { mutation_index: f64::INFINITY, ..nsga2 }.validate()), Some("mutation_index"));

    let slpio = SlpioSettings::default();
    assert_eq!(name(SlpioSettings { base_population: 0, ..slpio }.validate()), Some("base_population"));
    assert_eq!(name(SlpioSettings { dimension_setting: 51, ..slpio }.validate()), Some("dimension_setting"));
    assert_eq!(name(SlpioSettings { social_coefficient: -1.0, ..slpio }.validate()), Some("social_coefficient"));
    assert_eq!(name(SlpioSettings { removed_per_iteration: 17, ..slpio }.validate()), Some("removed_per_iteration"));
    assert_eq!(name(SlpioSettings { velocity_limit: 0.0, ..slpio }.validate()), Some("velocity_limit"));
    let many = SlpioSettings { map_and_compass_iterations: usize::MAX, ..slpio };
    assert_eq!(name(many.validate()), Some("map_and_compass_iterations"));
    assert!(Mpio::new(mpio).is_ok() && Nsga2::new(nsga2).is_ok() && Slpio::new(slpio).is_ok());
}

#[test]
fn sl_pio_finds_the_bottom_of_a_bowl_better_than_chance() {
    let settings = SlpioSettings::default();
    let mut slpio = Slpio::new(settings).expect("in range");
    let (mut solved, mut random) = (Vec::new(), Vec::new());
    for seed in 0..31 {
        let mut bowl = Pointwise::new(&[(-1.0, 3.0); 3], 1, trade_off);
        let front = slpio.minimise(&mut bowl, &mut stream(seed, 0, 0)).expect("solvable");
        assert_eq!(front.len(), 1);
        solved.push(front.objective(0)[0]);
        let mut rng = stream(seed, 1, 0);
        let points = (0..settings.evaluations()).map(|_| rng.random::<[f64; 3]>().map(|x| 4.0 * x - 1.0));
        random.push(points.map(|x| x.iter().map(|x| x * x).sum()).fold(f64::INFINITY, f64::min));
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[15]
    };
    let (solved, random) = (median(&mut solved), median(&mut random));
    println!("bowl: SL-PIO {solved:.4}, random {random:.4}");
    assert!(solved < random, "{solved} {random}");
}
