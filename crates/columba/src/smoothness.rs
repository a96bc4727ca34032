//! How calmly and how closely a flock flew: total variation of speed and course, and the flock's radius.

use flight_model::{State, wrap_pi};
use nalgebra::Vector2;

/// Gathers a flight's smoothness, integration step by integration step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Smoothness {
    speed_mps: f64,
    course_rad: f64,
    radius_m: f64,
    radius_end_m: f64,
    steps: u64,
    vehicles: usize,
}

impl Smoothness {
    /// One integration step: each vehicle before and after it.
    pub fn step<'a>(&mut self, states: impl ExactSizeIterator<Item = (&'a State, &'a State)> + Clone) {
        self.vehicles = states.len();
        for (before, after) in states.clone() {
            self.speed_mps += (after.speed_mps - before.speed_mps).abs();
            self.course_rad += wrap_pi(after.course_rad - before.course_rad).abs();
        }
        self.radius_end_m = radius_m(states.map(|(_, after)| after));
        self.radius_m += self.radius_end_m;
        self.steps += 1;
    }

    /// How much a vehicle's speed changed in all, up and down: the mean over the flock, m/s.
    pub fn speed_variation_mps(&self) -> f64 {
        self.speed_mps / self.vehicles.max(1) as f64
    }

    /// How much a vehicle turned in all, left and right: the mean over the flock, rad.
    pub fn course_variation_rad(&self) -> f64 {
        self.course_rad / self.vehicles.max(1) as f64
    }

    /// How far vehicles were from the flock's centre, horizontally: the mean over the flock and the flight, m.
    pub fn radius_m(&self) -> f64 {
        self.radius_m / self.steps.max(1) as f64
    }

    /// The same at the end of the flight, m.
    pub fn radius_end_m(&self) -> f64 {
        self.radius_end_m
    }
}

/// The mean distance to the centre.
fn radius_m<'a>(states: impl ExactSizeIterator<Item = &'a State> + Clone) -> f64 {
    let share = 1.0 / states.len().max(1) as f64;
    let centre_m = states.clone().fold(Vector2::zeros(), |sum, state| sum + state.position_m()) * share;
    share * states.map(|state| (state.position_m() - centre_m).norm()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64, y_m: f64, speed_mps: f64, course_rad: f64) -> State {
        State { x_m, y_m, speed_mps, course_rad, ..State::default() }
    }

    #[test]
    fn ups_and_downs_add_up_and_courses_go_the_short_way() {
        let flights = [
            [at(0.0, 0.0, 10.0, 3.1), at(0.0, 0.0, 12.0, -3.1), at(0.0, 0.0, 10.0, 3.1)],
            [at(0.0, 8.0, 10.0, 0.0), at(0.0, 8.0, 10.0, 0.0), at(6.0, 8.0, 10.0, 0.5)],
        ];
        let mut smoothness = Smoothness::default();
        for step in 1..3 {
            smoothness.step(flights.iter().map(|flight| (&flight[step - 1], &flight[step])));
        }
        assert_eq!(smoothness.speed_variation_mps(), 2.0);
        let turned_rad = 2.0 * (std::f64::consts::TAU - 6.2) + 0.5;
        assert!((smoothness.course_variation_rad() - 0.5 * turned_rad).abs() < 1e-12);
        // Two at 8 m and then at 10 m from each other, each half of it from the centre.
        assert!((smoothness.radius_m() - 4.5).abs() < 1e-12 && (smoothness.radius_end_m() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_flown_is_nothing_and_not_nan() {
        let smoothness = Smoothness::default();
        assert_eq!(
            (smoothness.speed_variation_mps(), smoothness.radius_m(), smoothness.radius_end_m()),
            (0.0, 0.0, 0.0)
        );
    }
}
