//! The ranges of the settings of optimisers.

use crate::optimizer::SettingsError;

/// The greatest population, archive or number of iterations.
const MOST: usize = 1_000_000;

/// A setting by its name, its value, what it may be, and whether it is.
pub(crate) type Check = (&'static str, f64, &'static str, bool);

/// The first setting that is out of its range.
pub(crate) fn check_settings(checks: &[Check]) -> Result<(), SettingsError> {
    match checks.iter().find(|&&(.., valid)| !valid) {
        Some(&(setting, value, range, _)) => Err(SettingsError { setting, value, range }),
        None => Ok(()),
    }
}

/// A number of candidates.
pub(crate) fn count(setting: &'static str, count: usize) -> Check {
    (setting, count as f64, "from 1 to 1000000", (1..=MOST).contains(&count))
}

/// A number of iterations.
pub(crate) fn iterations(setting: &'static str, iterations: usize) -> Check {
    (setting, iterations as f64, "at most 1000000", iterations <= MOST)
}

/// A probability, or a factor that is like one.
pub(crate) fn fraction(setting: &'static str, fraction: f64) -> Check {
    (setting, fraction, "from 0 to 1", (0.0..=1.0).contains(&fraction))
}

/// A factor or a distribution index.
pub(crate) fn factor(setting: &'static str, factor: f64) -> Check {
    (setting, factor, "from 0 to 1000", (0.0..=1000.0).contains(&factor))
}

/// D of Eq. 13, beside its M.
pub(crate) fn dimension_setting(dimension_setting: usize, base_population: usize) -> Check {
    let valid = (1..=base_population).contains(&dimension_setting);
    ("dimension_setting", dimension_setting as f64, "from 1 to base_population", valid)
}

/// N_removed, of so many pigeons in so many iterations.
pub(crate) fn removed_per_iteration(removed: usize, iterations: usize, pigeons: usize) -> Check {
    let valid = iterations.saturating_mul(removed) < pigeons;
    ("removed_per_iteration", removed as f64, "such that a pigeon is left for the last iteration", valid)
}

/// The limit of a velocity, as a fraction of each dimension's range.
pub(crate) fn velocity_limit(limit: f64) -> Check {
    ("velocity_limit", limit, "above 0 and at most 1", limit > 0.0 && limit <= 1.0)
}

/// How many candidates are evaluated at first and in each of so many iterations, before which some leave.
pub(crate) fn evaluations(pigeons: usize, removed: usize, iterations: usize) -> usize {
    let left = |nc: usize| pigeons.saturating_sub(nc.saturating_mul(removed));
    (0..=iterations).fold(0, |evaluations, nc| evaluations.saturating_add(left(nc)))
}
