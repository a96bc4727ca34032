//! Arithmetic on several pigeons at once.
//!
//! A look-ahead flies every pigeon of a generation through the same steps, so the pigeons are the lanes of a vector. The
//! operations are plain loops over a fixed array, which the compiler turns into vector instructions, and they use only
//! the four operations, comparisons and square roots: the bits are the same whatever the vector width, and on every
//! platform. `ln` and `sincos` are short polynomials, accurate to 1e-12, instead of calls that would break the vector up.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Pigeons flown together.
pub const LANES: usize = 8;

/// One number for each of [`LANES`] pigeons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    pub const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// The first lanes from `values`, the others repeating its last one (they are computed and thrown away).
    #[inline(always)]
    pub fn load(values: &[f64]) -> Self {
        let last = values.last().copied().unwrap_or(0.0);
        Self(std::array::from_fn(|lane| values.get(lane).copied().unwrap_or(last)))
    }

    /// Stores the first lanes into `values`.
    #[inline(always)]
    pub fn store(self, values: &mut [f64]) {
        for (value, lane) in values.iter_mut().zip(self.0) {
            *value = lane;
        }
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for lane in &mut out.0 {
            *lane = f(*lane);
        }
        out
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for lane in 0..LANES {
            out.0[lane] = f(self.0[lane], other.0[lane]);
        }
        out
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    pub fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }

    /// `yes` where self < other, else `no`.
    #[inline(always)]
    pub fn select_less(self, other: Self, yes: Self, no: Self) -> Self {
        let mut out = no;
        for lane in 0..LANES {
            out.0[lane] = if self.0[lane] < other.0[lane] { yes.0[lane] } else { no.0[lane] };
        }
        out
    }

    /// Natural logarithm of positive, normal numbers.
    #[inline(always)]
    pub fn ln(self) -> Self {
        self.map(ln)
    }

    /// Sine and cosine of angles within +-[`SINCOS_RANGE_RAD`].
    #[inline(always)]
    pub fn sincos(self) -> (Self, Self) {
        let z = self * self;
        let mut sin = Self::splat(SIN[SIN.len() - 1]);
        for coefficient in SIN.iter().rev().skip(1) {
            sin = sin * z + Self::splat(*coefficient);
        }
        let mut cos = Self::splat(COS[COS.len() - 1]);
        for coefficient in COS.iter().rev().skip(1) {
            cos = cos * z + Self::splat(*coefficient);
        }
        (sin * self, cos)
    }
}

/// Angles that [`Lanes::sincos`] takes: the greatest turn of one prediction step is bounded below this.
pub const SINCOS_RANGE_RAD: f64 = 1.6;

/// Taylor coefficients of sin(x)/x and cos(x) in x^2: the first term left out is below 1e-11 within the range.
const SIN: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COS: [f64; 9] = [
    1.0,
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// ln(m 2^e) = e ln 2 + 2 artanh((m - 1)/(m + 1)) with m in [sqrt(1/2), sqrt(2)).
#[inline(always)]
fn ln(x: f64) -> f64 {
    // Adding the distance of sqrt(1/2) from 1 in bits moves the exponent's carry to sqrt(2).
    const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
    const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;
    const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;
    // 2^52: an integer put into the mantissa of this double reads as 2^52 + integer.
    const TWO_52_BITS: u64 = 0x4330_0000_0000_0000;
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    let shifted = x.to_bits().wrapping_add(ONE_BITS - SQRT_HALF_BITS);
    let exponent = f64::from_bits((shifted >> 52) | TWO_52_BITS) - (TWO_52 + 1023.0);
    let m = f64::from_bits((shifted & MANTISSA).wrapping_add(SQRT_HALF_BITS));
    let t = (m - 1.0) / (m + 1.0);
    let z = t * t;
    let series = 1.0 / 13.0 + z * (1.0 / 15.0);
    let series = 1.0 / 9.0 + z * (1.0 / 11.0 + z * series);
    let series = 1.0 / 5.0 + z * (1.0 / 7.0 + z * series);
    exponent * std::f64::consts::LN_2 + 2.0 * t * (1.0 + z * (1.0 / 3.0 + z * series))
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
        impl $trait<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.map(|a| a $op other)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ln_is_ln(exponent in -40.0..40.0f64) {
            let x = libm::exp(exponent);
            let got = Lanes::splat(x).ln().0[0];
            prop_assert!((got - libm::log(x)).abs() <= 1e-12 * (1.0 + exponent.abs()), "{x}: {got}");
        }

        #[test]
        fn sincos_is_sincos(angle in -SINCOS_RANGE_RAD..SINCOS_RANGE_RAD) {
            let (sin, cos) = Lanes::splat(angle).sincos();
            prop_assert!((sin.0[0] - libm::sin(angle)).abs() < 2e-11);
            prop_assert!((cos.0[0] - libm::cos(angle)).abs() < 2e-11);
        }
    }

    #[test]
    fn a_short_load_repeats_its_last_value_and_a_short_store_drops_it() {
        let lanes = Lanes::load(&[1.0, 2.0, 3.0]);
        assert_eq!(lanes.0[..4], [1.0, 2.0, 3.0, 3.0]);
        let mut out = [0.0; 3];
        (lanes * 2.0).store(&mut out);
        assert_eq!(out, [2.0, 4.0, 6.0]);
    }
}
