//! References that do not jump.

/// A reference that moves to its target by at most so much a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramp {
    pub value: f64,
    pub target: f64,
    pub per_step: f64,
}

impl Ramp {
    pub fn at(value: f64) -> Self {
        Self { value, target: value, per_step: f64::INFINITY }
    }

    pub fn advance(&mut self) -> f64 {
        let error = self.target - self.value;
        self.value =
            if error.abs() <= self.per_step { self.target } else { self.value + self.per_step.copysign(error) };
        self.value
    }
}
