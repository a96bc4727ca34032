//! Bank angle over time.

use super::{NONE, VehicleLine, over_time};
use crate::flight::{Flight, Row};
use flight_model::wrap_pi;

/// Standard gravity, m/s2.
const GRAVITY_MPS2: f64 = 9.806_65;

/// How the figure is computed.
pub const CAPTION: &str = "Bank angle of a coordinated turn, positive to the right: arctan(V \u{b7} course rate / g), \
                           with the mean speed and the change of course between two ticks, and g = 9.81 m/s\u{b2}. \
                           45\u{b0} is a lateral acceleration of 1 g. Exact in still air; peaks between ticks are not \
                           in it.";

/// Bank angle over time in degrees, from the ground track.
pub fn bank(flight: &Flight) -> String {
    let lines: Vec<VehicleLine> = (0..flight.trajectory.vehicles).map(|vehicle| banks_deg(flight, vehicle)).collect();
    over_time(flight, "bank", "bank, right (\u{b0})", (0.0, NONE), 10.0, &lines)
}

/// A vehicle's mean bank angle between each two ticks, deg, at the time between them.
fn banks_deg(flight: &Flight, vehicle: usize) -> VehicleLine {
    let rows: Vec<(f64, &Row)> = flight.trajectory.vehicle(vehicle).collect();
    let between = |pair: &[(f64, &Row)]| {
        let [(from_s, from), (to_s, to)] = pair else { return None };
        let course_rate_radps = wrap_pi(to.state.course_rad - from.state.course_rad) / (to_s - from_s);
        let speed_mps = 0.5 * (from.state.speed_mps + to.state.speed_mps);
        let bank_rad = libm::atan(speed_mps * course_rate_radps / GRAVITY_MPS2);
        Some((0.5 * (from_s + to_s), bank_rad.to_degrees()))
    };
    rows.windows(2).filter_map(between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn a_turn_to_the_right_at_one_g_is_45_degrees() {
        let mut flight = sample::flight(1, 0, 4);
        // Over the seam of the circle, too.
        for (tick, row) in flight.trajectory.rows.iter_mut().enumerate() {
            row.state.speed_mps = 20.0;
            row.state.course_rad = wrap_pi(3.0 + GRAVITY_MPS2 / 20.0 * 0.5 * tick as f64);
        }
        let banks = banks_deg(&flight, 0);
        assert_eq!(banks.iter().map(|(t_s, _)| *t_s).collect::<Vec<_>>(), [0.25, 0.75, 1.25]);
        assert!(banks.iter().all(|(_, bank_deg)| (bank_deg - 45.0).abs() < 1e-9), "{banks:?}");
        flight.trajectory.rows[1].state.course_rad -= 0.5;
        assert!(banks_deg(&flight, 0)[0].1 < 0.0, "to the left");
    }
}
