//! The median and how sure one can be of it.

/// A median with its distribution-free interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Median {
    /// The median; of an even number, the mean of the two in the middle.
    pub median: f64,
    /// The order statistics that enclose the true median with a probability of at least 95 %, whatever the distribution; none of
    /// fewer than six values.
    pub interval: Option<[f64; 2]>,
}

/// The median of some values, none of them NaN; `None` of no values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<Median> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.get(values.len().checked_sub(1)? / 2)?, values.get(values.len() / 2)?);
    let rank = interval_rank(values.len());
    let interval = rank.checked_sub(1).map(|below| [values[below], values[values.len() - rank]]);
    Some(Median { median: 0.5 * (low + high), interval })
}

/// The greatest k such that the k-th of n values from either end encloses the median with a probability of at least 95 %: fewer
/// than k of n tosses of a coin fall on one side with a probability of at most 2.5 %. 0 if there is none.
fn interval_rank(n: usize) -> usize {
    // The probability of exactly k of n, from that of k - 1; of many tosses, the first are too small for a double, and are 0.
    let mut exactly = libm::exp2(-(n as f64));
    let (mut fewer, mut k) = (0.0, 0);
    while fewer + exactly <= 0.025 && k < n {
        fewer += exactly;
        k += 1;
        exactly *= (n + 1 - k) as f64 / k as f64;
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_the_sign_test() {
        // Tables of the sign test: the ranks of two-sided 95 % intervals.
        for (n, rank) in [(1, 0), (5, 0), (6, 1), (8, 1), (9, 2), (20, 6), (31, 10), (100, 40)] {
            assert_eq!(interval_rank(n), rank, "{n}");
        }
    }

    #[test]
    fn a_median_stands_in_the_middle_of_its_interval() {
        let of = |n: u32| median((1..=n).rev().map(f64::from));
        assert_eq!(of(0), None);
        assert_eq!(of(4), Some(Median { median: 2.5, interval: None }));
        assert_eq!(of(31), Some(Median { median: 16.0, interval: Some([10.0, 22.0]) }));
    }
}
