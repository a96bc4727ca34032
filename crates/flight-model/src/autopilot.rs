//! One step of the three autopilot loops (Eq. 1) with the limits of Eq. 3 acting inside it.

use crate::{Dynamics, Limits, Setpoint, State, course_vector, wrap_pi};

/// The three loops discretised at a fixed step.
///
/// Each loop is linear between limits and a setpoint is held over the step, so speed, course, climb and altitude are
/// the exact solution of Eq. 1 there; the position integrates the exact velocity with Simpson's rule (its error over a
/// step of h is of order h^5: below 1e-10 m at 10 ms). Where a limit acts the step is first order in the moment at
/// which it begins to act.
///
/// Of [`Response`](crate::Response) it flies the gain of speed, the limit of acceleration, the growth of the course
/// loop's time constant, and the share of a turn. Dead times are the caller's: a step knows only the setpoint that acts
/// in it.
#[derive(Clone, Copy, Debug)]
pub struct Autopilot {
    dynamics: Dynamics,
    limits: Limits,
    step_s: f64,
    course_time_constant_s: f64,
    /// exp(-h/tau) of the speed and course loops over half a step and a whole one.
    speed_decay: [f64; 2],
    course_decay: [f64; 2],
    /// (H - H_c, eta) after a step, from (H - H_c, eta) before it.
    altitude_transition: [[f64; 2]; 2],
}

impl Autopilot {
    /// Discretises `dynamics` at a step of `step_s` seconds.
    pub fn new(dynamics: &Dynamics, step_s: f64) -> Self {
        let tau = dynamics.time_constants;
        let decay = |tau_s: f64| [libm::exp(-0.5 * step_s / tau_s), libm::exp(-step_s / tau_s)];
        Self {
            dynamics: *dynamics,
            limits: dynamics.limits,
            step_s,
            course_time_constant_s: tau.course_s,
            speed_decay: decay(tau.speed_s),
            course_decay: decay(tau.course_s),
            altitude_transition: altitude_transition(tau.altitude_a_s, tau.altitude_b_s, step_s),
        }
    }

    /// The step, s.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// The state one step later, with `setpoint` held over the step.
    pub fn step(&self, state: &State, setpoint: &Setpoint) -> State {
        let [speed_mid, speed_end] = self.speeds(state, setpoint);
        let [course_mid, course_end] = self.courses(state, setpoint, speed_end);
        let (altitude_m, climb_mps) = self.altitude(state, setpoint);

        // Simpson's rule on V cos(phi), V sin(phi).
        let start = state.velocity_mps();
        let middle = course_vector(course_mid) * speed_mid;
        let end = course_vector(course_end) * speed_end;
        let position_m = state.position_m() + (start + middle * 4.0 + end) * (self.step_s / 6.0);
        State {
            x_m: position_m.x,
            y_m: position_m.y,
            altitude_m,
            speed_mps: speed_end,
            course_rad: wrap_pi(course_end),
            climb_mps,
        }
    }

    /// Speed at mid-step and at its end: first order towards the setpoint, clamped to [V_min, V_max]. Only a gust
    /// carries it out of these limits, and then no step makes up for it at once.
    fn speeds(&self, state: &State, setpoint: &Setpoint) -> [f64; 2] {
        let least_mps = self.limits.speed_min_mps.min(state.speed_mps);
        let most_mps = self.limits.speed_max_mps.max(state.speed_mps);
        let asked_mps = setpoint.speed_mps * self.dynamics.response.speed_gain;
        let wanted_mps = if state.speed_mps < self.limits.speed_min_mps || state.speed_mps > self.limits.speed_max_mps {
            asked_mps.clamp(self.limits.speed_min_mps, self.limits.speed_max_mps)
        } else {
            asked_mps
        };
        let change_max_mps = self.dynamics.response.acceleration_max_mps2 * self.step_s;
        [(self.speed_decay[0], 0.5 * change_max_mps), (self.speed_decay[1], change_max_mps)].map(
            |(decay, change_mps)| {
                let free = wanted_mps + (state.speed_mps - wanted_mps) * decay;
                let (low_mps, high_mps) = (state.speed_mps - change_mps, state.speed_mps + change_mps);
                // What is not a number stays so: `clamp` panics of such bounds.
                let limited = if free < low_mps { low_mps } else { free };
                let limited = if limited > high_mps { high_mps } else { limited };
                limited.clamp(least_mps, most_mps)
            },
        )
    }

    /// Course at mid-step and at its end: first order towards the setpoint by the short way round, its rate at most
    /// n_max g / V. Where the rate is limited the course first runs along a ramp, then leaves it exponentially.
    fn courses(&self, state: &State, setpoint: &Setpoint, speed_end_mps: f64) -> [f64; 2] {
        let error = wrap_pi(setpoint.course_rad - state.course_rad);
        let rate_max = self.dynamics.turn_rate_max_radps(state.speed_mps.max(speed_end_mps));
        let (course_time_constant_s, course_decay) = self.course_loop(state.speed_mps);
        let error_at_limit = rate_max * course_time_constant_s;
        if error.abs() <= error_at_limit {
            return course_decay.map(|decay| state.course_rad + error * (1.0 - decay));
        }
        let ramp_s = (error.abs() - error_at_limit) / rate_max;
        [0.5 * self.step_s, self.step_s].map(|time_s| {
            let turned = if time_s <= ramp_s {
                rate_max * time_s
            } else {
                let decay = libm::exp(-(time_s - ramp_s) / course_time_constant_s);
                error.abs() - error_at_limit * decay
            };
            state.course_rad + turned.copysign(error)
        })
    }

    /// The course loop's time constant, s, and what is left of an error after half a step and a whole one.
    fn course_loop(&self, speed_mps: f64) -> (f64, [f64; 2]) {
        if self.dynamics.response.course_reference_speed_mps.is_none() {
            return (self.course_time_constant_s, self.course_decay);
        }
        let tau_s = self.dynamics.course_time_constant_s(speed_mps);
        (tau_s, [0.5, 1.0].map(|part| libm::exp(-part * self.step_s / tau_s)))
    }

    /// Altitude and climb at the end of the step: second order, the climb clamped to [eta_min, eta_max].
    fn altitude(&self, state: &State, setpoint: &Setpoint) -> (f64, f64) {
        let (error, climb) = (state.altitude_m - setpoint.altitude_m, state.climb_mps);
        let [[a, b], [c, d]] = self.altitude_transition;
        let free_climb = c * error + d * climb;
        let limited = free_climb.clamp(self.limits.climb_min_mps, self.limits.climb_max_mps);
        if limited == free_climb {
            (setpoint.altitude_m + a * error + b * climb, free_climb)
        } else {
            (state.altitude_m + 0.5 * self.step_s * (climb + limited), limited)
        }
    }
}

/// The transition matrix over `h` of e' = eta, eta' = -(1/a + 1/b) eta - e/(a b), whose poles are -1/a and -1/b.
fn altitude_transition(a_s: f64, b_s: f64, h: f64) -> [[f64; 2]; 2] {
    let (p, q) = (1.0 / a_s, 1.0 / b_s);
    let exp_p = libm::exp(-p * h);
    let exp_q = libm::exp(-q * h);
    // (exp(-q h) - exp(-p h)) / (p - q), which has the limit h exp(-p h) when the poles meet.
    let spread = if (p - q).abs() * h < 1e-9 { h * exp_p } else { (exp_q - exp_p) / (p - q) };
    [[exp_q + q * spread, spread], [-p * q * spread, exp_p - q * spread]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TimeConstants;
    use proptest::prelude::*;

    fn fly(state: State, setpoint: Setpoint, step_s: f64, time_s: f64) -> State {
        let autopilot = Autopilot::new(&Dynamics::default(), step_s);
        (0..(time_s / step_s).round() as usize).fold(state, |state, _| autopilot.step(&state, &setpoint))
    }

    fn cruise() -> State {
        State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() }
    }

    #[test]
    fn a_speed_step_is_the_closed_form() {
        let after = fly(cruise(), Setpoint { speed_mps: 12.0, ..cruise().hold() }, 0.01, 1.5);
        assert!((after.speed_mps - (12.0 - 2.0 * libm::exp(-1.5))).abs() < 1e-12);
        let distance = 12.0 * 1.5 - 2.0 * (1.0 - libm::exp(-1.5));
        assert!((after.x_m - distance).abs() < 1e-9);
    }

    #[test]
    fn a_course_step_is_the_closed_form() {
        let after = fly(cruise(), Setpoint { course_rad: 0.8, ..cruise().hold() }, 0.01, 1.0);
        assert!((after.course_rad - 0.8 * (1.0 - libm::exp(-1.0 / 0.75))).abs() < 1e-12);
    }

    #[test]
    fn an_altitude_step_is_the_closed_form() {
        let after = fly(cruise(), Setpoint { altitude_m: 52.0, ..cruise().hold() }, 0.01, 2.0);
        let (a, b): (f64, f64) = (1.0 / 3.0, 3.0);
        let remaining = (b * libm::exp(-2.0 / b) - a * libm::exp(-2.0 / a)) / (b - a);
        assert!((after.altitude_m - (52.0 - 2.0 * remaining)).abs() < 1e-9);
    }

    #[test]
    fn a_course_step_across_south_takes_the_short_way() {
        let start = State { course_rad: 3.0, ..cruise() };
        let after = fly(start, Setpoint { course_rad: -3.0, ..start.hold() }, 0.01, 0.1);
        assert!(after.course_rad > 3.0 || after.course_rad < -3.0);
    }

    #[test]
    fn a_limited_turn_runs_at_the_limit_then_leaves_it() {
        let mut dynamics = Dynamics::default();
        dynamics.limits.lateral_overload_max = 0.5; // 0.5 rad/s at 10 m/s, reached from errors of 0.375 rad up
        let autopilot = Autopilot::new(&dynamics, 0.01);
        let setpoint = Setpoint { course_rad: 1.0, ..cruise().hold() };
        let states: Vec<State> =
            std::iter::successors(Some(cruise()), |s| Some(autopilot.step(s, &setpoint))).take(301).collect();
        assert!((states[100].course_rad - 0.5).abs() < 1e-9);
        let closed_form = 1.0 - 0.375 * libm::exp(-(3.0 - 1.25) / 0.75);
        assert!((states[300].course_rad - closed_form).abs() < 1e-9);
    }

    #[test]
    fn a_vehicle_that_slips_turns_by_its_share_of_the_limit() {
        let mut dynamics = Dynamics::default();
        (dynamics.limits.lateral_overload_max, dynamics.response.turn_share) = (0.5, 0.6);
        let setpoint = Setpoint { course_rad: 1.0, ..cruise().hold() };
        let turned_rad = Autopilot::new(&dynamics, 1.0).step(&cruise(), &setpoint).course_rad;
        assert!((turned_rad - 0.3).abs() < 1e-12, "{turned_rad}");
    }

    #[test]
    fn speed_changes_no_faster_than_the_limit_of_acceleration() {
        let mut dynamics = Dynamics::default();
        dynamics.response.acceleration_max_mps2 = 0.8;
        let autopilot = Autopilot::new(&dynamics, 0.01);
        let setpoint = Setpoint { speed_mps: 14.0, ..cruise().hold() };
        let states: Vec<State> =
            std::iter::successors(Some(cruise()), |s| Some(autopilot.step(s, &setpoint))).take(801).collect();
        // A ramp until 0.8 m/s are left of the step, then first order.
        assert!((states[300].speed_mps - 12.4).abs() < 1e-9);
        assert!((states[800].speed_mps - (14.0 - 0.8 * libm::exp(-4.0))).abs() < 1e-2);
        let slower = autopilot.step(&cruise(), &Setpoint { speed_mps: 6.0, ..cruise().hold() });
        assert!((slower.speed_mps - 9.992).abs() < 1e-9);
    }

    #[test]
    fn a_speed_gain_scales_what_is_asked() {
        let mut dynamics = Dynamics::default();
        dynamics.response.speed_gain = 1.1;
        let autopilot = Autopilot::new(&dynamics, 0.5);
        let after = autopilot.step(&cruise(), &Setpoint { speed_mps: 10.0, ..cruise().hold() });
        assert!((after.speed_mps - (11.0 - libm::exp(-0.5))).abs() < 1e-12);
    }

    #[test]
    fn a_course_loop_that_grows_with_speed_has_its_time_constant_at_its_reference() {
        let turned_rad = |reference_mps: Option<f64>, speed_mps: f64| {
            let mut dynamics = Dynamics::default();
            dynamics.response.course_reference_speed_mps = reference_mps;
            let start = State { speed_mps, ..cruise() };
            let setpoint = Setpoint { course_rad: 0.2, ..start.hold() };
            Autopilot::new(&dynamics, 0.5).step(&start, &setpoint).course_rad
        };
        assert!((turned_rad(Some(10.0), 10.0) - turned_rad(None, 10.0)).abs() < 1e-15);
        assert!((turned_rad(Some(10.0), 15.0) - 0.2 * (1.0 - libm::exp(-0.5 / (1.5 * 0.75)))).abs() < 1e-12);
    }

    #[test]
    fn equal_poles_have_their_own_closed_form() {
        let tau = TimeConstants { altitude_a_s: 1.0, altitude_b_s: 1.0, ..TimeConstants::default() };
        let dynamics = Dynamics { time_constants: tau, ..Dynamics::default() };
        let autopilot = Autopilot::new(&dynamics, 0.5);
        let after = autopilot.step(&cruise(), &Setpoint { altitude_m: 51.0, ..cruise().hold() });
        assert!((after.altitude_m - (51.0 - 1.5 * libm::exp(-0.5))).abs() < 1e-12);
    }

    #[test]
    fn a_long_climb_runs_at_the_limit() {
        let after = fly(cruise(), Setpoint { altitude_m: 150.0, ..cruise().hold() }, 0.01, 5.0);
        assert_eq!(after.climb_mps, 6.0);
        assert!((after.altitude_m - 80.0).abs() < 1.2);
    }

    proptest! {
        #[test]
        fn one_step_is_two_half_steps(
            speed in 5.0..15.0f64, error in -1.0..1.0f64, dv in -3.0..3.0f64, dh in -1.0..1.0f64,
        ) {
            let start = State { speed_mps: speed, ..cruise() };
            let speed_mps = (speed + dv).clamp(5.0, 15.0);
            let setpoint = Setpoint { speed_mps, course_rad: error, altitude_m: 50.0 + dh };
            let whole = fly(start, setpoint, 0.2, 0.2);
            let halves = fly(start, setpoint, 0.1, 0.2);
            prop_assert!((whole.speed_mps - halves.speed_mps).abs() < 1e-12);
            prop_assert!((whole.course_rad - halves.course_rad).abs() < 1e-12);
            prop_assert!((whole.altitude_m - halves.altitude_m).abs() < 1e-12);
            prop_assert!((whole.x_m - halves.x_m).abs() < 1e-4);
        }

        #[test]
        fn limits_hold_whatever_is_asked(
            speed in -50.0..50.0f64, course in -10.0..10.0f64, altitude in -500.0..500.0f64,
        ) {
            let autopilot = Autopilot::new(&Dynamics::default(), 0.01);
            let setpoint = Setpoint { speed_mps: speed, course_rad: course, altitude_m: altitude };
            let mut state = cruise();
            for _ in 0..300 {
                let next = autopilot.step(&state, &setpoint);
                prop_assert!((5.0..=15.0).contains(&next.speed_mps));
                prop_assert!((-6.0..=6.0).contains(&next.climb_mps));
                let rate = wrap_pi(next.course_rad - state.course_rad).abs() / 0.01;
                prop_assert!(rate <= 50.0 / state.speed_mps.max(next.speed_mps) + 1e-9);
                state = next;
            }
        }
    }
}
