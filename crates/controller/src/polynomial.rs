//! Logarithm, sine and cosine as short polynomials.
//!
//! A look-ahead flies every pigeon of a generation through the same steps, in plain loops over arrays that the compiler
//! turns into vector instructions. A call to a library would break such a loop up; these are straight lines of the four
//! operations, so they vectorise, and give the same bits whatever the vector width and platform.

/// Angles that [`sincos`] takes, rad: commands are bounded so that no turn within one control period is greater.
pub const SINCOS_RANGE_RAD: f64 = 1.5;

/// Sine and cosine of an angle within +-[`SINCOS_RANGE_RAD`], to 2e-11: their Taylor series, summed pairwise so that
/// the terms do not wait for each other.
#[inline(always)]
pub fn sincos(angle_rad: f64) -> (f64, f64) {
    let z = angle_rad * angle_rad;
    let (z_2, z_4) = (z * z, (z * z) * (z * z));
    let sin = (1.0 - z * (1.0 / 6.0) + z_2 * (1.0 / 120.0 - z * (1.0 / 5_040.0)))
        + z_4
            * ((1.0 / 362_880.0 - z * (1.0 / 39_916_800.0))
                + z_2 * (1.0 / 6_227_020_800.0 - z * (1.0 / 1_307_674_368_000.0)));
    let cos = (1.0 - z * 0.5 + z_2 * (1.0 / 24.0 - z * (1.0 / 720.0)))
        + z_4
            * ((1.0 / 40_320.0 - z * (1.0 / 3_628_800.0))
                + z_2 * (1.0 / 479_001_600.0 - z * (1.0 / 87_178_291_200.0))
                + z_4 * (1.0 / 20_922_789_888_000.0));
    (sin * angle_rad, cos)
}

/// Natural logarithm of a positive, normal number, to 4e-11: ln(m 2^e) = e ln 2 + 2 artanh((m - 1)/(m + 1)) with m in
/// [sqrt(1/2), sqrt(2)).
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
    const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;
    const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;
    // 2^52: an integer put into the mantissa of this double reads as 2^52 + integer.
    const TWO_52_BITS: u64 = 0x4330_0000_0000_0000;
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    // Counting from sqrt(1/2) instead of 1 moves the carry into the exponent to sqrt(2).
    let shifted = x.to_bits().wrapping_add(ONE_BITS - SQRT_HALF_BITS);
    let exponent = f64::from_bits((shifted >> 52) | TWO_52_BITS) - (TWO_52 + 1023.0);
    let m = f64::from_bits((shifted & MANTISSA).wrapping_add(SQRT_HALF_BITS));
    let t = (m - 1.0) / (m + 1.0);
    let z = t * t;
    let z_2 = z * z;
    let series = (1.0 + z * (1.0 / 3.0)) + z_2 * ((1.0 / 5.0 + z * (1.0 / 7.0)) + z_2 * (1.0 / 9.0 + z * (1.0 / 11.0)));
    exponent * std::f64::consts::LN_2 + 2.0 * t * series
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ln_is_ln(exponent in -40.0..40.0f64) {
            let x = libm::exp(exponent);
            prop_assert!((ln(x) - libm::log(x)).abs() <= 4e-11);
        }

        #[test]
        fn sincos_is_sincos(angle in -SINCOS_RANGE_RAD..SINCOS_RANGE_RAD) {
            let (sin, cos) = sincos(angle);
            prop_assert!((sin - libm::sin(angle)).abs() < 2e-11);
            prop_assert!((cos - libm::cos(angle)).abs() < 2e-11);
        }
    }
}
