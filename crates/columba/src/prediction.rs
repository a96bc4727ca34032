//! Predicted against flown: where the model takes a vehicle in a few seconds, and where it was then.
//!
//! This is what the controller's look-ahead rests on, measured after the flight: from a recorded state on, with the
//! setpoints that were recorded after it, each acting a dead time later.

use crate::flight::{Flight, Row};
use flight_model::{Autopilot, Dynamics, Setpoint, State};

/// How far ahead, s.
pub const HORIZON_S: f64 = 3.0;
/// Step of the model, s.
const STEP_S: f64 = 0.05;

/// The state a time after another one, with the setpoints that `asked` gives for times since then in s; those before
/// it, below zero, count where a dead time reaches back.
pub fn predict(dynamics: &Dynamics, start: &State, time_s: f64, asked: impl Fn(f64) -> Setpoint) -> State {
    let steps = (time_s / STEP_S).round().max(1.0);
    let step_s = time_s / steps;
    let autopilot = Autopilot::new(dynamics, step_s);
    let response = dynamics.response;
    let mut state = *start;
    for step in 0..steps as usize {
        // Setpoints are held over a step: the middle of it is on one side of every change.
        let t_s = (step as f64 + 0.5) * step_s;
        let setpoint = Setpoint {
            speed_mps: asked(t_s - response.speed_dead_time_s).speed_mps,
            course_rad: asked(t_s - response.course_dead_time_s).course_rad,
            altitude_m: asked(t_s - response.altitude_dead_time_s).altitude_m,
        };
        state = autopilot.step(&state, &setpoint);
    }
    state
}

/// How far a vehicle was from where the model has it, m, at each tick that was predicted [`HORIZON_S`] before; what was
/// not heard is left out. Nothing where the model is not in the record.
pub fn errors_m(flight: &Flight, vehicle: usize) -> Vec<(f64, f64)> {
    let Some(dynamics) = flight.dynamics.get(vehicle).or(flight.dynamics.first()) else { return Vec::new() };
    let rows: Vec<(f64, &Row)> = flight.trajectory.vehicle(vehicle).collect();
    let mut errors = Vec::new();
    for (index, (start_s, row)) in rows.iter().enumerate() {
        let later = rows[index..].partition_point(|(t_s, _)| *t_s < start_s + HORIZON_S - 1e-6);
        let Some((end_s, end)) = rows.get(index + later) else { break };
        if !row.state.is_finite() || !end.state.is_finite() {
            continue;
        }
        let asked = |since_s: f64| {
            let next = rows.partition_point(|(t_s, _)| *t_s <= start_s + since_s);
            rows[next.saturating_sub(1)].1.setpoint
        };
        let predicted = predict(dynamics, &row.state, end_s - start_s, asked);
        if predicted.is_finite() {
            errors.push((*end_s, (predicted.position_m() - end.state.position_m()).norm()));
        }
    }
    errors
}

/// The flight with the root mean square of all vehicles' errors in its summary.
pub fn with_prediction(mut flight: Flight) -> Flight {
    let errors: Vec<(f64, f64)> =
        (0..flight.trajectory.vehicles).flat_map(|vehicle| errors_m(&flight, vehicle)).collect();
    flight.summary.prediction_rms_m = rms(&errors);
    flight
}

/// Root mean square of some errors; none of no error.
pub fn rms(errors: &[(f64, f64)]) -> Option<f64> {
    let square = errors.iter().map(|(_, error)| error * error).sum::<f64>() / errors.len() as f64;
    (!errors.is_empty()).then(|| square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::{Tick, Trajectory};

    /// Flies a row of setpoints by Eq. 1 with dead times, and records it every half second.
    fn flown(dynamics: Dynamics) -> Flight {
        let autopilot = Autopilot::new(&dynamics, 0.01);
        let first = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
        let mut dead_times = flight_model::SetpointDelay::of(&dynamics.response, 0.01, &first.hold());
        let mut flight = Flight { trajectory: Trajectory::new(1), dynamics: vec![dynamics], ..Flight::default() };
        let mut state = first;
        for tick in 0..40 {
            let course_rad = if tick % 10 < 5 { 0.6 } else { -0.4 };
            let setpoint = Setpoint { speed_mps: 9.0 + f64::from(tick % 7) * 0.4, course_rad, altitude_m: 50.0 };
            let t_s = 0.5 * f64::from(tick);
            let tick = Tick { t_s, min_separation_m: f64::INFINITY, min_clearance_m: f64::INFINITY, solve_us: 0.0 };
            flight.trajectory.push(tick, [Row { state, setpoint, alpha: [1.0; 3] }]);
            for _ in 0..50 {
                let acts = dead_times.as_mut().map_or(setpoint, |dead_times| dead_times.pass(&setpoint));
                state = autopilot.step(&state, &acts);
            }
        }
        flight
    }

    #[test]
    fn what_flies_by_the_model_is_where_it_was_predicted() {
        let mut late = Dynamics::default();
        late.response.course_dead_time_s = 0.2;
        late.response.speed_dead_time_s = 0.3;
        late.response.speed_gain = 1.05;
        for dynamics in [Dynamics::default(), late] {
            let mut flight = flown(dynamics);
            let errors = errors_m(&flight, 0);
            assert_eq!((errors.len(), errors[0].0), (34, 3.0));
            // The dead times before the first row are not known.
            assert!(rms(&errors[1..]).unwrap() < 0.02, "{errors:?}");
            assert_eq!(with_prediction(flight.clone()).summary.prediction_rms_m, rms(&errors));
            flight.dynamics[0].time_constants.course_s *= 3.0;
            assert!(rms(&errors_m(&flight, 0)).unwrap() > 0.5);
        }
    }

    #[test]
    fn what_was_not_heard_is_left_out() {
        let mut flight = flown(Dynamics::default());
        flight.trajectory.rows[3].state.x_m = f64::NAN;
        assert_eq!(errors_m(&flight, 0).len(), 33);
        // A vehicle that was released has no setpoint any more.
        for tick in 10..40 {
            flight.trajectory.rows[tick].setpoint.speed_mps = f64::NAN;
        }
        assert_eq!(errors_m(&flight, 0).len(), 4);
        flight.dynamics.clear();
        assert!(errors_m(&flight, 0).is_empty() && rms(&[]).is_none());
    }
}
