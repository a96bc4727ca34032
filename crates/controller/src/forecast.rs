//! Where the neighbours will be while a vehicle looks ahead.

use flight_model::State;

/// A vehicle at one instant of a forecast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passage {
    /// North, m.
    pub x_m: f64,
    /// East, m.
    pub y_m: f64,
    /// Northward, m/s.
    pub vx_mps: f64,
    /// Eastward, m/s.
    pub vy_mps: f64,
}

/// Forecasts of a whole flock, vehicle-major: `instants` passages each, half a control period apart.
#[derive(Clone, Debug, Default)]
pub struct Forecast {
    passages: Vec<Passage>,
    instants: usize,
}

impl Forecast {
    /// Every vehicle keeps its velocity (reading 11: neighbours are extrapolated).
    pub fn extrapolate(&mut self, states: &[State], steps: usize, control_period_s: f64) {
        self.instants = 1 + 2 * steps;
        self.passages.clear();
        for state in states {
            let (vx_mps, vy_mps) = state.velocity_mps();
            self.passages.extend((0..self.instants).map(|instant| {
                let time_s = 0.5 * control_period_s * instant as f64;
                Passage { x_m: state.x_m + vx_mps * time_s, y_m: state.y_m + vy_mps * time_s, vx_mps, vy_mps }
            }));
        }
    }

    /// The forecast of one vehicle.
    pub fn vehicle(&self, index: usize) -> &[Passage] {
        &self.passages[index * self.instants..(index + 1) * self.instants]
    }
}
