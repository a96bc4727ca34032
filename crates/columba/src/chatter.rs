//! Chatter: how far course setpoints jump from one tick to the next, against what a vehicle can turn meanwhile.

use crate::flight::{Flight, Row};
use flight_model::{Autopilot, Dynamics, wrap_pi};

/// A change is compared with what the vehicle turns in so many control periods.
const TICKS: f64 = 2.0;
/// Which of all changes counts: so many of a hundred are no greater.
const PERCENTILE: f64 = 0.99;

/// The changes of one vehicle's course setpoint, rad, each with the time of the setpoint in s and what the vehicle
/// turns at most in two control periods, rad. Nothing where the model is not in the record.
pub fn changes_rad(flight: &Flight, vehicle: usize) -> Vec<(f64, f64, f64)> {
    let Some(dynamics) = flight.dynamics.get(vehicle).or(flight.dynamics.first()) else { return Vec::new() };
    let rows: Vec<(f64, &Row)> = flight.trajectory.vehicle(vehicle).collect();
    // The last row is the end of the flight, and has the setpoint of the tick before.
    let decided = &rows[..rows.len().saturating_sub(1)];
    let change = |pair: &[(f64, &Row)]| {
        let [(before_s, before), (at_s, at)] = pair else { return None };
        let change_rad = wrap_pi(at.setpoint.course_rad - before.setpoint.course_rad).abs();
        let turn_rad = greatest_turn_rad(dynamics, at, TICKS * (at_s - before_s));
        (change_rad.is_finite() && turn_rad > 0.0).then_some((*at_s, change_rad, turn_rad))
    };
    decided.windows(2).filter_map(change).collect()
}

/// What a vehicle turns in a time at most: towards the opposite course, rad.
fn greatest_turn_rad(dynamics: &Dynamics, row: &Row, time_s: f64) -> f64 {
    let mut opposite = row.state.hold();
    opposite.course_rad += std::f64::consts::PI - 1e-6;
    let after = Autopilot::new(dynamics, time_s).step(&row.state, &opposite);
    wrap_pi(after.course_rad - row.state.course_rad).abs()
}

/// The flight with the chatter of all vehicles in its summary.
pub fn with_chatter(mut flight: Flight) -> Flight {
    let changes = (0..flight.trajectory.vehicles).flat_map(|vehicle| changes_rad(&flight, vehicle));
    let (changes_rad, shares): (Vec<f64>, Vec<f64>) =
        changes.map(|(_, change_rad, turn_rad)| (change_rad, change_rad / turn_rad)).unzip();
    flight.summary.course_setpoint_change_p99_rad = percentile(changes_rad);
    flight.summary.course_setpoint_change_p99_share = percentile(shares);
    flight
}

/// By nearest rank; none of nothing.
fn percentile(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let rank = (PERCENTILE * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::{Tick, Trajectory};
    use flight_model::State;

    /// A flight at 10 m/s to the north in which the course setpoint changes by this from tick to tick, left and right.
    fn flown(change_rad: f64, ticks: usize, dynamics: Dynamics) -> Flight {
        let state = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
        let mut flight = Flight { trajectory: Trajectory::new(1), dynamics: vec![dynamics], ..Flight::default() };
        for tick in 0..ticks {
            let course_rad = wrap_pi(3.0 + if tick % 2 == 0 { 0.0 } else { change_rad });
            let setpoint = flight_model::Setpoint { course_rad, ..state.hold() };
            let t_s = 0.5 * tick as f64;
            let tick = Tick { t_s, min_separation_m: f64::INFINITY, min_clearance_m: f64::INFINITY, solve_us: 0.0 };
            flight.trajectory.push(tick, [Row { state, setpoint, alpha: [1.0; 3] }]);
        }
        flight
    }

    #[test]
    fn a_setpoint_that_jumps_is_compared_with_what_the_vehicle_turns() {
        let mut slow = Dynamics::default();
        slow.limits.lateral_overload_max = 0.3;
        let summary = with_chatter(flown(0.6, 10, slow)).summary;
        let near = |value: Option<f64>, wanted: f64| assert!((value.unwrap() - wanted).abs() < 1e-9, "{value:?}");
        near(summary.course_setpoint_change_p99_rad, 0.6);
        // 0.3 rad/s at 10 m/s, over a second.
        near(summary.course_setpoint_change_p99_share, 2.0);
        // The paper's vehicle turns by 1 - exp(-1 / 0.75) of half a circle.
        let summary = with_chatter(flown(0.6, 10, Dynamics::default())).summary;
        let turn_rad = (std::f64::consts::PI - 1e-6) * (1.0 - libm::exp(-1.0 / 0.75));
        near(summary.course_setpoint_change_p99_share, 0.6 / turn_rad);
    }

    #[test]
    fn what_was_not_decided_or_not_heard_is_left_out() {
        let mut flight = flown(0.6, 10, Dynamics::default());
        assert_eq!(changes_rad(&flight, 0).len(), 8);
        flight.trajectory.rows[4].setpoint.course_rad = f64::NAN;
        assert_eq!(changes_rad(&flight, 0).len(), 6);
        flight.dynamics.clear();
        assert_eq!(with_chatter(flight).summary.course_setpoint_change_p99_rad, None);
        assert_eq!(with_chatter(Flight::default()).summary.course_setpoint_change_p99_share, None);
    }
}
