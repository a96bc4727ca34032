//! Variation of children: simulated binary crossover and polynomial mutation, coordinate by coordinate.

use crate::problem::Bounds;

/// Simulated binary crossover within bounds (Deb and Agrawal 1995; bounded as in Deb's own NSGA-II): with the parents
/// y1 < y2 and u uniform in [0, 1), the children are
///
/// c1 = ((y1 + y2) - b1 (y2 - y1)) / 2 and c2 = ((y1 + y2) + b2 (y2 - y1)) / 2,
///
/// where b = (u a)^(1 / (eta + 1)) if u <= 1 / a, else (1 / (2 - u a))^(1 / (eta + 1)); a = 2 - B^-(eta + 1); and
/// B = 1 + 2 (y1 - lower) / (y2 - y1) for the first child, 1 + 2 (upper - y2) / (y2 - y1) for the second.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossover {
    /// eta + 1, and one over it.
    degree: f64,
    inverse_degree: f64,
}

impl Crossover {
    /// With the distribution index eta, from 0 to 1000.
    pub fn new(index: f64) -> Self {
        Self { degree: index + 1.0, inverse_degree: 1.0 / (index + 1.0) }
    }

    /// The two children's values, in either order. Parents as good as equal have children equal to them.
    ///
    /// There is no branch on a draw: half of the branches would be predicted wrongly.
    pub fn cross(&self, parents: [f64; 2], bounds: Bounds, u: f64, swapped: bool) -> [f64; 2] {
        let (low, high) = (parents[0].min(parents[1]), parents[0].max(parents[1]));
        let gap = high - low;
        if gap <= 1e-14 * bounds.range() {
            return parents;
        }
        let alphas =
            [low - bounds.lower, bounds.upper - high].map(|room| 2.0 - power(gap / (gap + 2.0 * room), self.degree));
        let [below, above] = alphas.map(|alpha| 0.5 * gap * self.spread(u * alpha));
        // Half sums: their whole might overflow.
        let middle = 0.5 * low + 0.5 * high;
        let mut children = [0.0; 2];
        children[usize::from(swapped)] = bounds.clamp(middle - below);
        children[usize::from(!swapped)] = bounds.clamp(middle + above);
        children
    }

    /// b, where `base` is u a: base^(1 / (eta + 1)) up to 1, (2 - base)^(-1 / (eta + 1)) above.
    fn spread(&self, base: f64) -> f64 {
        let above = 1.0 - base;
        root(1.0 - above.abs(), self.inverse_degree.copysign(above))
    }
}

/// Polynomial mutation within bounds (Deb and Goyal 1996; bounded as in Deb's own NSGA-II): y moves by d (upper -
/// lower),
///
/// d = (2 u + (1 - 2 u) (1 - d1)^(eta + 1))^(1 / (eta + 1)) - 1 if u <= 0.5,
/// else 1 - (2 (1 - u) + (2 u - 1) (1 - d2)^(eta + 1))^(1 / (eta + 1)),
///
/// where d1 and d2 are how far y is from the lower and from the upper bound, as fractions of the range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mutation {
    /// eta + 1, and one over it.
    degree: f64,
    inverse_degree: f64,
}

impl Mutation {
    /// With the distribution index eta, from 0 to 1000.
    pub fn new(index: f64) -> Self {
        Self { degree: index + 1.0, inverse_degree: 1.0 / (index + 1.0) }
    }

    /// Where a value moves by the draw `u`.
    pub fn mutate(&self, value: f64, bounds: Bounds, u: f64) -> f64 {
        let range = bounds.range();
        if range <= 0.0 {
            return value;
        }
        // A step upwards is a mirrored step downwards; again without a branch.
        let room = [bounds.upper - value, value - bounds.lower][usize::from(u > 0.5)];
        let tail = 1.0 - (2.0 * u - 1.0).abs();
        let step = 1.0 - root(tail + (1.0 - tail) * power(room / range, self.degree), self.inverse_degree);
        bounds.clamp(value + step.copysign(u - 0.5) * range)
    }
}

/// A power of a base that is not negative. For a whole exponent, which is the common case, it only multiplies: that is
/// several times faster than `libm::pow`, and has the same bits on every platform.
fn power(base: f64, exponent: f64) -> f64 {
    if exponent != exponent.trunc() {
        return libm::pow(base, exponent);
    }
    // At most 1001, by validation.
    let (mut left, mut square, mut power) = (exponent as u32, base, 1.0);
    while left > 0 {
        if left % 2 == 1 {
            power *= square;
        }
        square *= square;
        left /= 2;
    }
    power
}

/// A power between -1 and 1 of a number that is not negative, by logarithm. In single precision, which is enough for a
/// draw of 32 bits and takes a third of the time.
fn root(radicand: f64, exponent: f64) -> f64 {
    libm::exp(libm::log(radicand) * exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Bounds = Bounds::new(0.0, 1.0);

    #[test]
    fn crossing_keeps_the_mean_far_from_the_bounds_and_never_leaves_them() {
        let crossover = Crossover::new(20.0);
        for u in [0.0, 0.1, 0.49, 0.51, 0.9, 0.999] {
            let wide = Bounds::new(-1e9, 1e9);
            let [a, b] = crossover.cross([4.0, 1.0], wide, u, false);
            assert!((a + b - 5.0).abs() < 1e-9, "{u}: {a} {b}");
            // Unbounded, the spread is the textbook's: (2u)^(1/21), or (1 / (2 (1 - u)))^(1/21).
            let spread = if u <= 0.5 { 2.0 * u } else { 1.0 / (2.0 * (1.0 - u)) };
            assert!((b - a - 3.0 * libm::pow(spread, 1.0 / 21.0)).abs() < 1e-6, "{u}: {a} {b}");
            let swapped = crossover.cross([4.0, 1.0], wide, u, true);
            assert_eq!(swapped, [b, a]);
            let [a, b] = Crossover::new(0.0).cross([0.01, 0.9], UNIT, u, false);
            assert!((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b), "{u}: {a} {b}");
        }
        assert_eq!(crossover.cross([0.3, 0.3], UNIT, 0.7, false), [0.3, 0.3]);
    }

    #[test]
    fn mutation_moves_down_below_one_half_and_reaches_the_bounds() {
        let mutation = Mutation::new(20.0);
        assert!(mutation.mutate(0.5, UNIT, 0.0).abs() < 1e-6);
        assert!((mutation.mutate(0.5, UNIT, 0.5) - 0.5).abs() < 1e-12);
        assert!(mutation.mutate(0.5, UNIT, 0.2) < 0.5);
        assert!(mutation.mutate(0.5, UNIT, 0.8) > 0.5);
        assert!((mutation.mutate(0.5, UNIT, 1.0 - 1e-16) - 1.0).abs() < 1e-6);
        // By hand: u = 0.25, d1 = 1, so d = 0.5^(1/21) - 1.
        assert!((mutation.mutate(1.0, UNIT, 0.25) - 0.967_532_4).abs() < 1e-6);
        assert_eq!(mutation.mutate(2.0, Bounds::new(2.0, 2.0), 0.1), 2.0);
    }

    #[test]
    fn a_root_is_what_libm_says() {
        for radicand in [0.0, 1e-9, 0.2, 1.0, 7.0, 4e9] {
            for degree in [1.0, 16.0, 21.0, 1001.0] {
                let (ours, reference) = (root(radicand, 1.0 / degree), libm::pow(radicand, 1.0 / degree));
                assert!((ours - reference).abs() <= 2e-6 * reference, "{radicand}^(1/{degree})");
            }
        }
    }

    #[test]
    fn a_power_is_what_libm_says() {
        for base in [0.0, 1e-300, 0.2, 0.999, 1.0] {
            for exponent in [1.0, 2.0, 16.0, 21.0, 20.5, 1001.0] {
                let (ours, reference) = (power(base, exponent), libm::pow(base, exponent));
                assert!((ours - reference).abs() <= 1e-12 * reference, "{base}^{exponent}");
            }
        }
    }
}
