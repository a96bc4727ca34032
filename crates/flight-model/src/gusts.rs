//! Dryden gusts at low altitude (MIL-F-8785C, 3.7.2 and 3.7.3.4), as filters that turn white noise into wind.
//!
//! The forming filters are discretised exactly for a step over which airspeed and height stay, so that the variance is
//! that of the specification at any step. The components along and across the mean wind are equal in strength and
//! length, as the specification has them below 1000 ft; above it the filters stay as they are there.

use crate::Wind;

/// A foot, m.
const FOOT_M: f64 = 0.3048;
/// Heights between which the model of low altitude holds, ft.
const HEIGHTS_FT: (f64, f64) = (10.0, 1000.0);

/// The state of the three filters, each of unit variance: strength comes in where the gust is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gusts {
    along: f64,
    across: SecondOrder,
    up: SecondOrder,
}

/// A filter of the form (1 + sqrt(3) T s) / (1 + T s)^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct SecondOrder {
    fast: f64,
    slow: f64,
}

impl Gusts {
    /// How many normal numbers a step needs.
    pub const NORMALS: usize = 5;

    /// Goes on by `step_s` at an airspeed in m/s and a height above ground in m, with independent numbers of the
    /// standard normal distribution.
    pub fn step(&mut self, airspeed_mps: f64, height_m: f64, step_s: f64, normals: [f64; Self::NORMALS]) {
        let [n0, n1, n2, n3, n4] = normals;
        let scale = Scale::at(height_m);
        let travelled_m = airspeed_mps.max(0.0) * step_s;
        let passed = travelled_m / scale.horizontal_m;
        let decay = libm::exp(-passed);
        self.along = decay * self.along + (-libm::expm1(-2.0 * passed)).sqrt() * n0;
        self.across.step(passed, [n1, n2]);
        self.up.step(travelled_m / scale.vertical_m, [n3, n4]);
    }

    /// The gust of this moment. `intensity_mps` is the standard deviation of each horizontal component; the vertical
    /// one is weaker near the ground. The mean wind comes from `wind_from_rad`.
    pub fn velocity(&self, intensity_mps: f64, height_m: f64, wind_from_rad: f64) -> Wind {
        let (sin, cos) = libm::sincos(wind_from_rad);
        let (along, across) = (intensity_mps * self.along, intensity_mps * self.across.output());
        Wind {
            north_mps: along * cos - across * sin,
            east_mps: along * sin + across * cos,
            up_mps: intensity_mps * Scale::at(height_m).vertical_share * self.up.output(),
        }
    }
}

impl SecondOrder {
    /// Goes on by `passed` time constants. Both states have unit variance and are correlated; the noise of a step is
    /// the integral of the filter's answer to white noise, whose covariance is known in closed form.
    fn step(&mut self, passed: f64, [n0, n1]: [f64; 2]) {
        let x = 2.0 * passed;
        let decay = libm::exp(-x);
        let variance_fast = -libm::expm1(-x);
        let covariance = (variance_fast - x * decay) * std::f64::consts::FRAC_1_SQRT_2;
        let variance_slow = variance_fast - (x + 0.5 * x * x) * decay;
        let deviation = variance_fast.sqrt();
        let shared = if deviation > 0.0 { covariance / deviation } else { 0.0 };
        // Rounding can make the rest of a small variance negative.
        let rest = (variance_slow - shared * shared).max(0.0).sqrt();
        let (fast, slow) = (self.fast, self.slow);
        let decay = libm::exp(-passed);
        self.fast = decay * fast + deviation * n0;
        self.slow = decay * (slow + std::f64::consts::SQRT_2 * passed * fast) + shared * n0 + rest * n1;
    }

    fn output(&self) -> f64 {
        let root_3 = 3.0_f64.sqrt();
        1.5_f64.sqrt() * self.fast - 0.5 * (root_3 - 1.0) * self.slow
    }
}

/// Lengths and strengths at a height.
struct Scale {
    horizontal_m: f64,
    vertical_m: f64,
    /// Standard deviation of the vertical component in that of a horizontal one.
    vertical_share: f64,
}

impl Scale {
    fn at(height_m: f64) -> Self {
        let height_ft = (height_m / FOOT_M).clamp(HEIGHTS_FT.0, HEIGHTS_FT.1);
        let roughness = 0.177 + 0.000_823 * height_ft;
        Self {
            horizontal_m: FOOT_M * height_ft / libm::pow(roughness, 1.2),
            vertical_m: FOOT_M * height_ft,
            vertical_share: libm::pow(roughness, 0.4),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that are normal enough: sums of twelve uniform ones.
    struct Normals(u64);

    impl Normals {
        fn next(&mut self) -> f64 {
            let mut sum = -6.0;
            for _ in 0..12 {
                self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (self.0 >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        }
    }

    /// Mean squares of the three components, and the correlation of the first with itself after `lag` steps.
    fn statistics(step_s: f64, steps: usize, lag: usize) -> ([f64; 3], f64) {
        let mut normals = Normals(1);
        let mut gusts = Gusts::default();
        let mut track = Vec::new();
        for _ in 0..steps {
            gusts.step(20.0, 50.0, step_s, std::array::from_fn(|_| normals.next()));
            let wind = gusts.velocity(1.0, 50.0, 0.0);
            track.push([wind.north_mps, wind.east_mps, wind.up_mps]);
        }
        let mean = |value: &dyn Fn(usize) -> f64| (0..steps - lag).map(value).sum::<f64>() / (steps - lag) as f64;
        let squares = std::array::from_fn(|axis| mean(&|i| track[i][axis] * track[i][axis]));
        (squares, mean(&|i| track[i][0] * track[i + lag][0]))
    }

    #[test]
    fn the_strength_is_that_of_the_specification_at_any_step() {
        let vertical = libm::pow(0.177 + 0.000_823 * 50.0 / FOOT_M, 0.8);
        for step_s in [0.05, 0.5] {
            let ([along, across, up], _) = statistics(step_s, 400_000, 0);
            assert!((along - 1.0).abs() < 0.1, "{along}");
            assert!((across - 1.0).abs() < 0.1, "{across}");
            assert!((up / vertical - 1.0).abs() < 0.1, "{up}");
        }
    }

    #[test]
    fn the_length_is_that_of_the_specification() {
        // L_u at 164 ft is 164 / (0.177 + 0.000823 * 164)^1.2 ft: 672 ft, and the correlation exp(-V t / L).
        let length_m = 0.3048 * 164.04 / libm::pow(0.177 + 0.000_823 * 164.04, 1.2);
        assert!((length_m - 205.0).abs() < 3.0, "{length_m}");
        let (_, correlation) = statistics(0.5, 400_000, 10);
        assert!((correlation - libm::exp(-100.0 / length_m)).abs() < 0.1, "{correlation}");
    }

    #[test]
    fn standing_still_the_gust_stays() {
        let mut gusts = Gusts::default();
        gusts.step(20.0, 50.0, 0.1, [1.0; 5]);
        let before = gusts;
        gusts.step(0.0, 50.0, 0.1, [1.0; 5]);
        assert_eq!(gusts, before);
    }
}
