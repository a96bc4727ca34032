//! The wind at a vehicle: what is left of its velocity over ground without its velocity through the air.

use flight_model::{Setpoint, State, course_vector};
use nalgebra::Vector2;

/// A gust is taken up with this time constant, s.
const FOLLOW_S: f64 = 1.0;

/// The wind as the vehicle's own measurements tell it. An airspeed that reads a little wrong is a little wind along the
/// heading, and corrected for as such.
///
/// Airspeeds here are true ones: those that the vehicle reads and takes, times the gain of its speed loop.
#[derive(Clone, Copy, Debug, Default)]
pub struct WindEstimate {
    /// (North, east), m/s, and when.
    last: Option<(f64, Vector2<f64>)>,
}

impl WindEstimate {
    /// Takes an airspeed (m/s) and a heading (rad) that were measured with a state over ground.
    pub fn hear(&mut self, at_s: f64, state: &State, airspeed_mps: f64, heading_rad: f64) {
        let measured = state.velocity_mps() - course_vector(heading_rad) * airspeed_mps;
        let wind = match self.last {
            Some((last_s, wind)) => wind + (measured - wind) * ((at_s - last_s) / FOLLOW_S).clamp(0.0, 1.0),
            None => measured,
        };
        if wind.iter().all(|part| part.is_finite()) {
            self.last = Some((at_s, wind));
        }
    }

    /// (North, east), m/s; none before an airspeed was heard.
    pub fn velocity_mps(&self) -> Option<Vector2<f64>> {
        self.last.map(|(_, wind)| wind)
    }

    /// The airspeed that gives the speed over ground of a setpoint on its course, m/s.
    pub fn airspeed_mps(&self, setpoint: &Setpoint) -> f64 {
        let ground = course_vector(setpoint.course_rad) * setpoint.speed_mps;
        self.velocity_mps().map_or(setpoint.speed_mps, |wind| (ground - wind).norm())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tail_wind_takes_off_the_airspeed_and_a_head_wind_adds_to_it() {
        let mut estimate = WindEstimate::default();
        let setpoint = Setpoint { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
        assert_eq!(estimate.airspeed_mps(&setpoint), 10.0);
        // 14 m/s over ground to the north at an airspeed of 10 m/s: 4 m/s from behind.
        estimate.hear(0.0, &State { speed_mps: 14.0, ..State::default() }, 10.0, 0.0);
        assert!((estimate.airspeed_mps(&setpoint) - 6.0).abs() < 1e-12);
        let back = Setpoint { course_rad: std::f64::consts::PI, ..setpoint };
        assert!((estimate.airspeed_mps(&back) - 14.0).abs() < 1e-12);
    }
}
