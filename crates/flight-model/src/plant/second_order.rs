//! A linear element of second order.

/// x'' = w^2 (u - x) - 2 z w x', with an input u that is held over a step: the exact solution.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondOrder {
    /// (x - u, x') after a step, from the same before it.
    transition: [[f64; 2]; 2],
    pub value: f64,
    /// Its derivative, 1/s.
    pub rate: f64,
}

impl SecondOrder {
    /// At rest at zero. `frequency_radps` is w, `damping` z, `step_s` the step in s.
    pub fn new(frequency_radps: f64, damping: f64, step_s: f64) -> Self {
        let (w, sigma, h) = (frequency_radps, damping * frequency_radps, step_s);
        let square = w * w * (damping * damping - 1.0);
        let decay = libm::exp(-sigma * h);
        let root = square.abs().sqrt();
        let (cosine, sine) = if root * h < 1e-6 {
            (1.0, h)
        } else if square < 0.0 {
            (libm::cos(root * h), libm::sin(root * h) / root)
        } else {
            (libm::cosh(root * h), libm::sinh(root * h) / root)
        };
        let (cosine, sine) = (decay * cosine, decay * sine);
        let transition = [[cosine + sigma * sine, sine], [-w * w * sine, cosine - sigma * sine]];
        Self { transition, value: 0.0, rate: 0.0 }
    }

    /// At rest at a value.
    pub fn begin(&mut self, value: f64) {
        (self.value, self.rate) = (value, 0.0);
    }

    /// One step under an input; gives the value after it.
    pub fn step(&mut self, input: f64) -> f64 {
        let [[a, b], [c, d]] = self.transition;
        let (error, rate) = (self.value - input, self.rate);
        self.value = input + a * error + b * rate;
        self.rate = c * error + d * rate;
        self.value
    }

    /// The same, with a derivative of at most so much, 1/s.
    pub fn step_limited(&mut self, input: f64, rate_max: f64, step_s: f64) {
        let before = self.value;
        self.step(input);
        if self.rate.abs() > rate_max {
            self.rate = rate_max.copysign(self.rate);
            self.value = before + self.rate * step_s;
        }
    }

    /// At plus or minus a bound it stops.
    pub fn stop_at(&mut self, bound: f64) {
        if self.value.abs() > bound {
            (self.value, self.rate) = (bound.copysign(self.value), 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn one_step_is_two_half_steps(w in 0.1..20.0f64, z in 0.05..3.0f64, x in -5.0..5.0f64, v in -5.0..5.0f64) {
            let run = |step_s: f64, steps: usize| {
                let mut element = SecondOrder::new(w, z, step_s);
                (element.value, element.rate) = (x, v);
                (0..steps).for_each(|_| _ = element.step(1.0));
                (element.value, element.rate)
            };
            let (whole, halves) = (run(0.02, 1), run(0.01, 2));
            prop_assert!((whole.0 - halves.0).abs() < 1e-9 && (whole.1 - halves.1).abs() < 1e-8);
        }

        #[test]
        fn it_settles_on_its_input(w in 0.5..10.0f64, z in 0.2..2.0f64, u in -50.0..50.0f64) {
            let mut element = SecondOrder::new(w, z, 0.01);
            (0..20_000).for_each(|_| _ = element.step(u));
            prop_assert!((element.value - u).abs() < 1e-6);
        }
    }

    #[test]
    fn critical_damping_has_its_closed_form() {
        let mut element = SecondOrder::new(2.0, 1.0, 0.01);
        (0..100).for_each(|_| _ = element.step(1.0));
        // 1 - (1 + w t) exp(-w t) at t = 1 s.
        assert!((element.value - (1.0 - 3.0 * libm::exp(-2.0))).abs() < 1e-9);
    }
}
