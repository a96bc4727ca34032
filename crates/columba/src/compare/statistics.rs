//! The statistics of a comparison, each a pure function of numbers. An infinite value is one that never came: it is
//! greater than every other and ties with its like.

/// Of the standard normal distribution, so much of it lies within this many deviations on both sides: 95 %.
const Z_95: f64 = 1.959_963_984_540_054;
/// What lies outside a 95 % interval.
const OUTSIDE: f64 = 0.05;

/// An interval, both ends in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// What two samples say of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankTest {
    /// U of the first sample: the pairs in which its value is the greater one, a tie counting one half.
    pub u: f64,
    /// Two-sided, by the normal approximation with corrections for ties and continuity.
    pub p: f64,
    /// The share of pairs in which the first sample's value is the smaller one, a tie counting one half (Vargha and
    /// Delaney's A): 0.5 where neither tends to be smaller.
    pub smaller: f64,
}

/// The 95 % interval of a share by Wilson's score; none of no trials.
pub fn wilson_interval(successes: usize, trials: usize) -> Option<Interval> {
    let (hits, n) = (successes.min(trials) as f64, trials as f64);
    if trials == 0 {
        return None;
    }
    let z2 = Z_95 * Z_95;
    let centre = (hits + 0.5 * z2) / (n + z2);
    let half = Z_95 / (n + z2) * (hits * (n - hits) / n + 0.25 * z2).sqrt();
    // At the ends the formula is exact but for rounding.
    let low = if hits == 0.0 { 0.0 } else { (centre - half).max(0.0) };
    let high = if hits == n { 1.0 } else { (centre + half).min(1.0) };
    Some(Interval { low, high })
}

/// The median; between the two middle values of an even number their mean. None of no values.
pub fn median(values: &[f64]) -> Option<f64> {
    let sorted = sorted(values);
    let upper = *sorted.get(sorted.len() / 2)?;
    if sorted.len() % 2 == 1 {
        return Some(upper);
    }
    let lower = sorted[sorted.len() / 2 - 1];
    // Written so, two infinities of one sign are their own mean.
    Some(if lower == upper { upper } else { 0.5 * (lower + upper) })
}

/// A 95 % interval of the median whatever the distribution: the k-th value from below and from above, with the greatest
/// k for which a fair coin falls on one side fewer than k times of n with a probability of at most 2.5 %. None of fewer
/// than six values, which are too few for any.
pub fn median_interval(values: &[f64]) -> Option<Interval> {
    let sorted = sorted(values);
    let n = sorted.len();
    let mut tail = 0.0;
    let mut k = 0;
    while k < n {
        tail += coin(n, k);
        if tail > 0.5 * OUTSIDE {
            break;
        }
        k += 1;
    }
    let index = k.checked_sub(1)?;
    Some(Interval { low: sorted[index], high: sorted[n - 1 - index] })
}

/// The two-sided Mann-Whitney U test of two samples; none where one is empty.
pub fn mann_whitney(first: &[f64], second: &[f64]) -> Option<RankTest> {
    if first.is_empty() || second.is_empty() {
        return None;
    }
    let mut all: Vec<(f64, bool)> =
        first.iter().map(|&value| (value, true)).chain(second.iter().map(|&value| (value, false))).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (n1, n2, n) = (first.len() as f64, second.len() as f64, all.len() as f64);

    let (mut rank_sum, mut ties, mut below) = (0.0, 0.0, 0.0);
    for equals in all.chunk_by(|a, b| a.0 == b.0) {
        let count = equals.len() as f64;
        let rank = below + 0.5 * (count + 1.0);
        rank_sum += rank * equals.iter().filter(|(_, is_first)| *is_first).count() as f64;
        ties += count * count * count - count;
        below += count;
    }

    let u = rank_sum - 0.5 * n1 * (n1 + 1.0);
    let mean = 0.5 * n1 * n2;
    let deviation = (n1 * n2 / 12.0 * (n + 1.0 - ties / (n * (n - 1.0)))).max(0.0).sqrt();
    // All values are one: nothing speaks for a difference.
    let p = if deviation > 0.0 { two_sided(((u - mean).abs() - 0.5).max(0.0) / deviation) } else { 1.0 };
    Some(RankTest { u, p, smaller: 1.0 - u / (n1 * n2) })
}

/// Probabilities of several tests corrected for their number by Holm's step-down, in the order in which they came.
pub fn holm(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
    let mut corrected = vec![0.0; probabilities.len()];
    let mut least: f64 = 0.0;
    for (done, index) in order.into_iter().enumerate() {
        let tests_left = (probabilities.len() - done) as f64;
        least = least.max((probabilities[index] * tests_left).min(1.0));
        corrected[index] = least;
    }
    corrected
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The probability that a fair coin falls on one side k times of n.
fn coin(n: usize, k: usize) -> f64 {
    let log_factorial = |count: usize| libm::lgamma(count as f64 + 1.0);
    libm::exp(log_factorial(n) - log_factorial(k) - log_factorial(n - k) - n as f64 * std::f64::consts::LN_2)
}

/// The probability that a standard normal lies at least `z` from zero on either side.
fn two_sided(z: f64) -> f64 {
    libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// The references were made with SciPy 1.17.1: `binomtest(k, n).proportion_ci(0.95, 'wilson')`,
/// `quantile_test(x, p=0.5).confidence_interval(0.95)` and `mannwhitneyu(x, y, method='asymptotic',
/// use_continuity=True)`; those of Holm's by hand.
#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NEVER: f64 = f64::INFINITY;

    #[track_caller]
    fn close(ours: f64, reference: f64) {
        assert!((ours - reference).abs() <= 1e-12, "{ours:?} is not {reference:?}");
    }

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        for (successes, trials, low, high) in [
            (0, 1, 0.0, 0.793_450_685_622_762_6),
            (0, 100, 0.0, 0.036_993_498_206_985_68),
            (97, 100, 0.915_480_635_709_472_4, 0.989_745_475_975_961_1),
            (100, 100, 0.963_006_501_793_014_3, 1.0),
            (3, 7, 0.158_219_855_251_469_7, 0.749_541_635_472_342_8),
        ] {
            let interval = wilson_interval(successes, trials).unwrap();
            close(interval.low, low);
            close(interval.high, high);
        }
        assert_eq!(wilson_interval(0, 0), None);
    }

    #[test]
    fn the_median_is_the_middle_and_may_be_never() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[NEVER, 1.0, NEVER]), Some(NEVER));
        assert_eq!(median(&[NEVER, 1.0]), Some(NEVER));
        assert_eq!(median(&[NEVER, NEVER]), Some(NEVER));
    }

    #[test]
    fn the_interval_of_a_median_is_of_order_statistics() {
        for (n, low, high) in [
            (6, 1.0, 6.0),
            (7, 1.0, 7.0),
            (9, 2.0, 8.0),
            (20, 6.0, 15.0),
            (31, 10.0, 22.0),
            (100, 40.0, 61.0),
            (1000, 469.0, 532.0),
        ] {
            let values: Vec<f64> = (1..=n).rev().map(f64::from).collect();
            assert_eq!(median_interval(&values), Some(Interval { low, high }), "{n}");
        }
        assert_eq!(median_interval(&[1.0, 2.0, 3.0, 4.0, 5.0]), None);
        assert_eq!(median_interval(&[]), None);
        let half = [1.0, 2.0, 3.0, NEVER, NEVER, NEVER];
        assert_eq!(median_interval(&half), Some(Interval { low: 1.0, high: NEVER }));
    }

    #[test]
    fn the_rank_test_is_scipys_with_ties_and_with_never() {
        let (a, b) = ([33.5, 36.0, 35.5, 34.0, 41.5, 33.5, 37.0], [36.0, 38.5, NEVER, NEVER, 35.5, 40.0, NEVER, 39.0]);
        let hundred: Vec<f64> = (0..100).map(f64::from).collect();
        let shifted: Vec<f64> = hundred.iter().map(|value| value + 7.25).collect();
        let cases: [(&[f64], &[f64], [f64; 3]); 6] = [
            (&a, &b, [9.0, 0.031_203_587_390_511_416, 0.839_285_714_285_714_3]),
            (&b, &a, [47.0, 0.031_203_587_390_511_416, 0.160_714_285_714_285_73]),
            (&[4.1, 3.9, 4.0], &[2.2, 1.8, 2.5, 2.1], [12.0, 0.051_829_927_217_909_68, 0.0]),
            (&[1.0; 3], &[1.0; 2], [3.0, 1.0, 0.5]),
            (&[NEVER, NEVER, 3.0], &[NEVER, 2.0], [4.0, 0.746_885_633_390_364, 1.0 / 3.0]),
            (&hundred, &shifted, [4278.0, 0.077_916_499_776_463_1, 0.5722]),
        ];
        for (first, second, [u, p, smaller]) in cases {
            let test = mann_whitney(first, second).unwrap();
            assert_eq!(test.u, u);
            close(test.p, p);
            close(test.smaller, smaller);
        }
        assert_eq!(mann_whitney(&[], &[1.0]), None);
        assert_eq!(mann_whitney(&[NEVER; 9], &[NEVER; 9]).unwrap().p, 1.0);
    }

    #[test]
    fn holm_multiplies_by_the_tests_that_are_left_and_never_falls() {
        let corrected = holm(&[0.01, 0.04, 0.03, 0.005]);
        for (ours, reference) in corrected.into_iter().zip([0.03, 0.06, 0.06, 0.02]) {
            close(ours, reference);
        }
        assert_eq!(holm(&[0.7, 0.6]), [1.0, 1.0]);
        assert_eq!(holm(&[0.2]), [0.2]);
        assert!(holm(&[]).is_empty());
    }

    fn sample() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(prop_oneof![4 => (0_u8..20).prop_map(f64::from), 1 => Just(NEVER)], 1..30)
    }

    proptest! {
        #[test]
        fn exchanging_the_samples_exchanges_who_is_smaller(first in sample(), second in sample()) {
            let there = mann_whitney(&first, &second).unwrap();
            let back = mann_whitney(&second, &first).unwrap();
            prop_assert!((there.p - back.p).abs() < 1e-12 && (0.0..=1.0).contains(&there.p));
            prop_assert!((there.smaller + back.smaller - 1.0).abs() < 1e-12);
            let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
            let smaller: f64 = pairs.map(|(a, b)| if a < b { 1.0 } else if a == b { 0.5 } else { 0.0 }).sum();
            prop_assert!((there.smaller * (first.len() * second.len()) as f64 - smaller).abs() < 1e-9);
        }

        #[test]
        fn the_median_lies_in_its_interval(values in sample()) {
            let median = median(&values).unwrap();
            if let Some(Interval { low, high }) = median_interval(&values) {
                prop_assert!(low <= median && median <= high);
            } else {
                prop_assert!(values.len() < 6);
            }
        }
    }
}
