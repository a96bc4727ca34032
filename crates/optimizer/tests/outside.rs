//! NSGA-II against pymoo's, whose figures stand in `tests/reference` together with how they were made.

#![expect(clippy::expect_used, clippy::panic, reason = "the helpers of tests are tests")]

use std::collections::BTreeMap;

use optimizer::indicators::{hypervolume, igd_plus, rows};
use optimizer::suites::Suite;
use optimizer::{Nsga2, Nsga2Settings, Optimizer, stream};

const PYMOO: &str = include_str!("../../../tests/reference/nsga2-pymoo.csv");

/// What was solved: population, generations, problem and dimensions.
type Task = (usize, usize, String, usize);

/// Hypervolumes and IGD+ of many seeds.
type Figures = [Vec<f64>; 2];

fn pymoo() -> BTreeMap<Task, Figures> {
    let mut figures = BTreeMap::<Task, Figures>::new();
    for line in PYMOO.lines().skip(1) {
        let [problem, dimensions, population, generations, _seed, volume, distance] =
            line.split(',').collect::<Vec<_>>()[..]
        else {
            panic!("not seven columns: {line}");
        };
        let whole = |text: &str| text.parse().expect("a whole number");
        let task = (whole(population), whole(generations), problem.to_owned(), whole(dimensions));
        let of_task = figures.entry(task).or_default();
        for (values, text) in of_task.iter_mut().zip([volume, distance]) {
            values.push(text.parse().expect("a number"));
        }
    }
    figures
}

fn ours((population, generations, problem, dimensions): &Task, seeds: u64) -> Figures {
    let suite = Suite::ALL.into_iter().find(|suite| suite.name().eq_ignore_ascii_case(problem)).expect("known");
    let mut problem = suite.customary(Some(*dimensions));
    let settings = Nsga2Settings { population: *population, generations: generations - 1, ..Nsga2Settings::default() };
    let mut nsga2 = Nsga2::new(settings).expect("in range");
    let (reference, true_front) = (problem.reference_point(), problem.reference_front());
    let mut figures = Figures::default();
    for seed in 1..=seeds {
        let front = rows(&nsga2.minimise(&mut problem, &mut stream(seed, 0, 0)).expect("solvable"));
        figures[0].push(hypervolume(&front, &reference).expect("finite"));
        figures[1].push(igd_plus(&front, &true_front).expect("finite"));
    }
    figures
}

/// The one-sided p of the Mann-Whitney test that `a` tends to be less than `b`: of so many values, by the normal
/// approximation with continuity and tie corrections. Equal values count half to either side.
fn less(a: &[f64], b: &[f64]) -> f64 {
    let (m, n) = (a.len() as f64, b.len() as f64);
    let wins = |x: &f64| b.iter().map(|y| if x > y { 1.0 } else { 0.5 * f64::from(u8::from(x == y)) }).sum::<f64>();
    let u = a.iter().map(wins).sum::<f64>();
    let mut all = [a, b].concat();
    all.sort_by(f64::total_cmp);
    let ties = all.chunk_by(|x, y| x == y).map(|run| run.len() as f64).map(|t| t * t * t - t).sum::<f64>();
    let total = m + n;
    let deviation = (m * n / 12.0 * (total + 1.0 - ties / (total * (total - 1.0)))).sqrt();
    if deviation == 0.0 {
        return 1.0;
    }
    let z = (u - m * n / 2.0 + 0.5) / deviation;
    0.5 * libm::erfc(-z / 2.0_f64.sqrt())
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Of each problem, budget and indicator: the hypothesis that ours is no worse than pymoo's is not rejected at 1 %, all
/// of them together (Holm's correction).
#[test]
fn nsga2_is_no_worse_than_pymoos() {
    let pymoo = pymoo();
    assert_eq!(pymoo.len(), 2 * Suite::ALL.len());
    let mut worse: Vec<(f64, String)> = Vec::new();
    for (task, theirs) in &pymoo {
        assert!(theirs[0].len() >= 31);
        let ours = ours(task, 31);
        let (population, generations, problem, dimensions) = task;
        for (k, name) in ["hypervolume", "IGD+"].into_iter().enumerate() {
            let p = if k == 0 { less(&ours[k], &theirs[k]) } else { less(&theirs[k], &ours[k]) };
            let [ours, theirs] = [&ours[k], &theirs[k]].map(|values| median(values));
            let line = format!(
                "{problem} of {dimensions} variables, {population} x {generations}, {name}: ours {ours:.5}, \
                 pymoo's {theirs:.5}, p {p:.4}"
            );
            println!("{line}");
            worse.push((p, line));
        }
    }
    worse.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (rank, (p, line)) in worse.iter().enumerate() {
        assert!(p * (worse.len() - rank) as f64 >= 0.01, "{line}");
    }
}

#[test]
fn the_rank_test_tells_less_from_more() {
    let (low, high): (Vec<f64>, Vec<f64>) = (0..31).map(|i| (f64::from(i), f64::from(i) + 10.0)).unzip();
    assert!(less(&low, &high) < 1e-3 && less(&high, &low) > 0.99);
    assert_eq!(less(&[1.0; 31], &[1.0; 31]), 1.0);
    // By scipy.stats.mannwhitneyu([1, 2, 2, 3, 5], [2, 4, 4, 6, 7], alternative="less", method="asymptotic").
    assert!((less(&[1.0, 2.0, 2.0, 3.0, 5.0], &[2.0, 4.0, 4.0, 6.0, 7.0]) - 0.068_781_9).abs() < 1e-6);
}
