//! What was foreseen against what was flown: how far off a prediction may be is learnt from those that were made.

use super::Estimate;
use flight_model::{State, course_vector};
use nalgebra::{Matrix2, Vector2};
use std::collections::VecDeque;

/// Predictions that no state was heard for are forgotten when there are so many.
const PREDICTIONS_MAX: usize = 64;
/// A prediction is compared with states that are no further apart than this, s.
const GAP_MAX_S: f64 = 1.2;
/// Standard deviation of a position when it was flown, m.
const POSITION_STD_M: f64 = 0.05;
/// A prediction is off by this for each second ahead, m/s, before anything is known.
const RATE_AT_FIRST_MPS: f64 = 0.5;
/// The least that is believed, m/s.
const RATE_MIN_MPS: f64 = 0.05;
/// Share of a new comparison in what is known.
const SHARE: f64 = 0.1;

/// The errors of one vehicle's predictions, along and across its course.
#[derive(Clone, Debug)]
pub struct PredictionError {
    foretold: VecDeque<(f64, Estimate)>,
    last: Option<(f64, State)>,
    /// Squares of the error for each second ahead, m2/s2.
    rate_squared: Vector2<f64>,
    sum_squared_m2: Vector2<f64>,
    count: u64,
}

impl Default for PredictionError {
    fn default() -> Self {
        Self {
            foretold: VecDeque::new(),
            last: None,
            rate_squared: Vector2::repeat(RATE_AT_FIRST_MPS * RATE_AT_FIRST_MPS),
            sum_squared_m2: Vector2::zeros(),
            count: 0,
        }
    }
}

impl PredictionError {
    /// A prediction for a moment.
    pub fn foretold(&mut self, at_s: f64, estimate: &Estimate) {
        self.foretold.push_back((at_s, *estimate));
        if self.foretold.len() > PREDICTIONS_MAX {
            self.foretold.pop_front();
        }
    }

    /// The last state was flown later by this than was thought, s.
    pub fn shift(&mut self, by_s: f64) {
        if let Some((at_s, _)) = &mut self.last {
            *at_s += by_s;
        }
    }

    /// A state was flown: predictions for moments up to then are compared.
    pub fn flown(&mut self, at_s: f64, state: &State) {
        while let Some(&(foretold_s, estimate)) = self.foretold.front().filter(|(foretold_s, _)| *foretold_s <= at_s) {
            self.foretold.pop_front();
            let Some((last_s, last)) = self.last else { continue };
            if foretold_s < last_s || at_s - last_s > GAP_MAX_S {
                continue;
            }
            let off_m = estimate.state.position_m() - between((last_s, &last), (at_s, state), foretold_s);
            let ahead = course_vector(estimate.state.course_rad);
            let squared_m2 = Vector2::new(off_m.dot(&ahead), ahead.perp(&off_m)).map(|off_m| off_m * off_m);
            self.sum_squared_m2 += squared_m2;
            self.count += 1;
            // A state that was not foreseen but seen tells nothing of what lies ahead.
            if estimate.age_s > 0.05 {
                let per_second = squared_m2 / (estimate.age_s * estimate.age_s);
                self.rate_squared += (per_second - self.rate_squared) * SHARE;
            }
        }
        self.last = Some((at_s, *state));
    }

    /// Covariance (north, east) of a position that is foreseen so far ahead of the last state, m2, with what the
    /// velocity gains in a second along and across the course, m2/s3.
    pub fn covariance_m2(&self, ahead_s: f64, walk_m2ps3: Vector2<f64>, course_rad: f64) -> Matrix2<f64> {
        let squared_m2 = self.rate_squared.zip_map(&walk_m2ps3, |rate, walk| {
            let rate = rate.max(RATE_MIN_MPS * RATE_MIN_MPS);
            POSITION_STD_M * POSITION_STD_M + (rate + walk * ahead_s / 3.0) * ahead_s * ahead_s
        });
        let ahead = course_vector(course_rad);
        let turn = Matrix2::new(ahead.x, -ahead.y, ahead.y, ahead.x);
        turn * Matrix2::from_diagonal(&squared_m2) * turn.transpose()
    }

    /// Along and across, m.
    pub fn root_mean_square_m(&self) -> Option<[f64; 2]> {
        let mean = self.sum_squared_m2 / self.count as f64;
        (self.count > 0).then(|| [mean.x.sqrt(), mean.y.sqrt()])
    }
}

/// The position between two states: the cubic that both velocities give.
fn between((from_s, from): (f64, &State), (to_s, to): (f64, &State), at_s: f64) -> Vector2<f64> {
    let span_s = to_s - from_s;
    let u = ((at_s - from_s) / span_s).clamp(0.0, 1.0);
    let (u2, u3) = (u * u, u * u * u);
    from.position_m() * (2.0 * u3 - 3.0 * u2 + 1.0)
        + from.velocity_mps() * ((u3 - 2.0 * u2 + u) * span_s)
        + to.position_m() * (3.0 * u2 - 2.0 * u3)
        + to.velocity_mps() * ((u3 - u2) * span_s)
}
