//! Eq. 13, the size of the population, and the factors c1 and c2 that follow from the same D and M.

/// N = M + floor(D/5), the pigeons of a flock.
pub(crate) fn population(base_population: usize, dimension_setting: usize) -> usize {
    base_population.saturating_add(dimension_setting / 5)
}

/// The M that makes a flock of so many pigeons.
pub(crate) fn base_population(population: usize, dimension_setting: usize) -> usize {
    population.saturating_sub(dimension_setting / 5)
}

/// c1 = 1 - ln(D/M), how strongly a pigeon learns.
pub(crate) fn learning(dimension_setting: usize, base_population: usize) -> f64 {
    1.0 - libm::log(dimension_setting as f64 / base_population as f64)
}

/// c2 = a D/M, how strongly a pigeon is drawn to the centre.
pub(crate) fn social_influence(social_coefficient: f64, dimension_setting: usize, base_population: usize) -> f64 {
    social_coefficient * (dimension_setting as f64 / base_population as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_numbers() {
        assert_eq!((population(50, 5), base_population(51, 5)), (51, 50));
        assert!((learning(5, 50) - 3.302_585_093).abs() < 1e-9);
        assert!((social_influence(0.5, 5, 50) - 0.05).abs() < 1e-15);
    }
}
