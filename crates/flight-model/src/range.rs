//! What settings may be: each check names its setting, and every setting out of its range is found at once.

use std::fmt::{self, Display};

/// A setting out of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeError {
    /// Name of the setting, with its unit.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it may be.
    pub range: Range,
}

/// What a setting may be. NaN is in no range.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// A number with both ends.
    Within(f64, f64),
    /// A number greater than the first and at most the second.
    Above(f64, f64),
    /// A whole number with both ends.
    Whole(usize, usize),
}

/// The settings of one table, checked one after the other.
///
/// ```
/// use flight_model::Ranges;
///
/// let mut ranges = Ranges::default();
/// ranges.within("radius_m", -1.0, 0.0, 10.0);
/// ranges.above("period_s", 0.0, 0.0, 10.0);
/// let told: Vec<String> = ranges.errors().iter().map(ToString::to_string).collect();
/// assert_eq!(told[0], "radius_m = -1: must be a number from 0 to 10");
/// assert_eq!(told[1], "period_s = 0: must be a number greater than 0 and at most 10");
/// ```
#[derive(Clone, Debug, Default)]
pub struct Ranges {
    errors: Vec<RangeError>,
}

impl Ranges {
    /// From `low` to `high`. Where these are other settings and leave nothing between them, it is those that are wrong.
    pub fn within(&mut self, name: &'static str, value: f64, low: f64, high: f64) {
        self.check(name, value, Range::Within(low, high));
    }

    /// Greater than `low` and at most `high`; otherwise as [`within`](Self::within).
    pub fn above(&mut self, name: &'static str, value: f64, low: f64, high: f64) {
        self.check(name, value, Range::Above(low, high));
    }

    /// A whole number from `low` to `high`.
    pub fn whole(&mut self, name: &'static str, value: usize, low: usize, high: usize) {
        self.check(name, value as f64, Range::Whole(low, high));
    }

    /// The settings of a table within this one.
    pub fn extend(&mut self, errors: impl IntoIterator<Item = RangeError>) {
        self.errors.extend(errors);
    }

    fn check(&mut self, name: &'static str, value: f64, range: Range) {
        if range.is_possible() && !range.contains(value) {
            self.errors.push(RangeError { name, value, range });
        }
    }

    /// Every setting out of its range.
    pub fn errors(self) -> Vec<RangeError> {
        self.errors
    }
}

impl Range {
    /// Whether any number is in it.
    pub fn is_possible(&self) -> bool {
        match *self {
            Self::Within(low, high) | Self::Above(low, high) => low <= high,
            Self::Whole(low, high) => low <= high,
        }
    }

    /// Whether a number is in it.
    pub fn contains(&self, value: f64) -> bool {
        match *self {
            Self::Within(low, high) => (low..=high).contains(&value),
            Self::Above(low, high) => value > low && value <= high,
            Self::Whole(low, high) => (low as f64..=high as f64).contains(&value),
        }
    }
}

impl Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Within(low, high) => write!(f, "a number from {low} to {high}"),
            Self::Above(low, high) => write!(f, "a number greater than {low} and at most {high}"),
            Self::Whole(low, high) => write!(f, "a whole number from {low} to {high}"),
        }
    }
}

impl Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: must be {}", self.name, self.value, self.range)
    }
}

impl std::error::Error for RangeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_belong_to_a_range_and_nan_to_none() {
        assert!([1.0, 2.0].iter().all(|end| Range::Within(1.0, 2.0).contains(*end)));
        assert!(!Range::Above(1.0, 2.0).contains(1.0) && Range::Above(1.0, 2.0).contains(2.0));
        for range in [Range::Within(0.0, 1.0), Range::Above(0.0, 1.0), Range::Whole(0, 1)] {
            assert!(!range.contains(f64::NAN) && !range.contains(f64::INFINITY), "{range}");
        }
    }

    #[test]
    fn limits_that_leave_nothing_between_them_are_told_by_their_own_checks() {
        let mut ranges = Ranges::default();
        ranges.within("speed_mps", 3.0, 5.0, 4.0);
        ranges.within("speed_mps", 3.0, f64::NAN, 4.0);
        assert_eq!(ranges.errors(), []);
    }
}
