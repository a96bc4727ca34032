//! What may stand behind a flag: values from text, and why not.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use mavlink_bridge::kind::AtEnd;
use optimizer::Algorithm;
use optimizer::suites::Suite;

/// An optimiser by its key.
pub fn algorithm() -> impl TypedValueParser<Value = Algorithm> {
    let keys = PossibleValuesParser::new(Algorithm::ALL.iter().map(|algorithm| algorithm.key()));
    keys.try_map(|key| {
        Algorithm::ALL.iter().copied().find(|algorithm| algorithm.key() == key).ok_or("no such optimiser")
    })
}

/// How a flight ends, by its name.
pub fn at_end() -> impl TypedValueParser<Value = AtEnd> {
    let names = PossibleValuesParser::new(AtEnd::ALL.map(|(name, _)| name));
    names.try_map(|name| {
        AtEnd::ALL.into_iter().find(|(known, _)| *known == name).map(|(_, end)| end).ok_or("no such end")
    })
}

/// Size of an area, m.
pub fn area(text: &str) -> Result<f64, String> {
    number(text, 100.0, 100_000.0)
}

/// Length of a moving picture, s.
pub fn share_seconds(text: &str) -> Result<f64, String> {
    number(text, 1.0, 60.0)
}

/// A time to wait, s.
pub fn patience(text: &str) -> Result<f64, String> {
    number(text, 1.0, 3600.0)
}

/// A share of the wall clock.
pub fn speed(text: &str) -> Result<f64, String> {
    number(text, 0.01, 100.0)
}

/// A seed.
pub fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("must be a whole number from 0 to {}", u64::MAX))
}

/// A test problem by its name.
pub fn problem(text: &str) -> Result<Suite, String> {
    let named = Suite::ALL.into_iter().find(|suite| suite.name().eq_ignore_ascii_case(text));
    named.ok_or_else(|| "must be one of zdt1, zdt2, zdt3, zdt4, zdt6, dtlz1, dtlz2".to_owned())
}

/// An optimiser that finds fronts, by its key.
pub fn multi_objective(text: &str) -> Result<Algorithm, String> {
    let several = Algorithm::ALL.iter().copied().filter(|&algorithm| algorithm != Algorithm::Slpio);
    let named = several.clone().find(|algorithm| algorithm.key().eq_ignore_ascii_case(text));
    named.ok_or_else(|| {
        let keys: Vec<&str> = several.map(Algorithm::key).collect();
        format!("must be one of {}", keys.join(", "))
    })
}

/// An even number of candidates.
pub fn population(text: &str) -> Result<usize, String> {
    let even = text.parse().ok().filter(|count: &usize| (6..=10_000).contains(count) && count.is_multiple_of(2));
    even.ok_or_else(|| "must be an even number from 6 to 10000".to_owned())
}

/// A number of generations.
pub fn generations(text: &str) -> Result<usize, String> {
    let whole = text.parse().ok().filter(|count| (1..=100_000).contains(count));
    whole.ok_or_else(|| "must be a whole number from 1 to 100000".to_owned())
}

/// A number of variables.
pub fn dimensions(text: &str) -> Result<usize, String> {
    let whole = text.parse().ok().filter(|count| (3..=1000).contains(count));
    whole.ok_or_else(|| "must be a whole number from 3 to 1000".to_owned())
}

/// A number of threads.
pub fn threads(text: &str) -> Result<u16, String> {
    let whole = text.parse().ok().filter(|threads| (1..=1024).contains(threads));
    whole.ok_or_else(|| "must be a whole number from 1 to 1024".to_owned())
}

fn number(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("must be a number from {low} to {high}"))
}
