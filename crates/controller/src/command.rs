//! Eq. 2: from the control demand to the setpoints of the three autopilots, bounded by what they can fly.

use crate::polynomial::SINCOS_RANGE_RAD;
use crate::{AltitudeLaw, CourseLaw, LawSettings, terms};
use flight_model::{Dynamics, Setpoint, State, Wind, course_vector};
use nalgebra::Vector2;

/// Longest control period at which Eq. 9 and 10 settle as printed (reading 5).
const PRINTED_ALTITUDE_PERIOD_MAX_S: f64 = 0.2;

/// Greatest course change that one command may ask, rad. Below half a turn, so that the short way round is the way
/// meant.
const COURSE_CHANGE_MAX_RAD: f64 = 2.8;

/// A course setpoint changes from one command to the next by at most what the vehicle turns in so many control periods:
/// in two, less a reserve for a speed that is not known exactly.
const COURSE_STEP_TICKS: f64 = 1.85;

/// The airspeed of an evasion is at least this times the wind against it.
const HEAD_WIND_FACTOR: f64 = 1.5;

/// What a command still asks for, while it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Airspeed on which the vehicle settles, m/s.
    pub speed_mps: f64,
    /// Turn from the present heading, rad.
    pub turn_rad: f64,
}

/// Turns demands into commands for one kind of vehicle at one control period.
#[derive(Clone, Copy, Debug)]
pub struct Commander {
    pub speed_time_constant_s: f64,
    /// The time constant of the course line.
    pub turn_time_constant_s: f64,
    pub speed_min_mps: f64,
    pub speed_max_mps: f64,
    /// Greatest course change asked at any speed, rad.
    pub course_change_max_rad: f64,
    /// Greatest course change asked, times speed, rad m/s: beyond it the autopilot's turn rate would be at its limit.
    /// Infinite where that is the same change at every speed.
    pub course_change_speed_max: f64,
    altitude_time_constants_s: (f64, f64),
    printed_altitude: bool,
    speed_gain: f64,
    /// Greatest change of the course setpoint from one command to the next, times speed, rad m/s; infinite: any.
    pub course_step_speed_max: f64,
}

impl Commander {
    pub fn new(law: &LawSettings, dynamics: &Dynamics, control_period_s: f64) -> Self {
        let (tau, limits) = (dynamics.time_constants, dynamics.limits);
        let quickest_course_s = dynamics.course_time_constant_s(limits.speed_min_mps);
        let turn_mps2 = dynamics.turn_acceleration_max_mps2();
        // A turn rate of error / tau_phi is at its limit of a / V where the error is tau_phi a / V. Where tau_phi grows
        // with V, that is the same error at every speed.
        let (error_max_rad, error_speed_max) = match dynamics.response.course_reference_speed_mps {
            Some(reference_mps) => (tau.course_s * turn_mps2 / reference_mps, f64::INFINITY),
            None => (f64::INFINITY, tau.course_s * turn_mps2),
        };
        let turned = 1.0 - libm::exp(-control_period_s / quickest_course_s);
        Self {
            speed_time_constant_s: tau.speed_s,
            turn_time_constant_s: match law.course_law {
                CourseLaw::Printed => tau.speed_s,
                CourseLaw::Own => tau.course_s,
                CourseLaw::Auto => tau.speed_s.max(tau.course_s),
            },
            speed_min_mps: limits.speed_min_mps,
            speed_max_mps: limits.speed_max_mps,
            course_change_max_rad: COURSE_CHANGE_MAX_RAD
                .min(dynamics.response.course_step_max_rad)
                .min(error_max_rad)
                .min(SINCOS_RANGE_RAD / turned),
            course_change_speed_max: error_speed_max,
            altitude_time_constants_s: (tau.altitude_a_s, tau.altitude_b_s),
            printed_altitude: match law.altitude_law {
                AltitudeLaw::Auto => control_period_s <= PRINTED_ALTITUDE_PERIOD_MAX_S,
                AltitudeLaw::Printed => true,
                AltitudeLaw::Hold => false,
            },
            speed_gain: dynamics.response.speed_gain,
            course_step_speed_max: match law.course_law {
                CourseLaw::Printed => f64::INFINITY,
                CourseLaw::Own | CourseLaw::Auto => COURSE_STEP_TICKS * control_period_s * turn_mps2,
            },
        }
    }

    /// Speed setpoint (m/s) and course change (rad) for a horizontal demand (m/s2), first two lines of Eq. 2.
    ///
    /// The course line uses tau_V as printed, or tau_phi (reading 4). The demand is bounded to the speeds of the
    /// vehicle and to the course change whose turn rate it can fly (reading 7), so prediction and vehicle never meet
    /// their limits; `asked_rad` is the turn that the last command still asks for.
    pub fn horizontal(
        &self,
        demand_mps2: Vector2<f64>,
        speed_mps: f64,
        heading: Vector2<f64>,
        asked_rad: Option<f64>,
    ) -> (f64, f64) {
        let along_mps2 = demand_mps2.dot(&heading);
        let across_mps2 = heading.perp(&demand_mps2);
        let setpoint_mps =
            (speed_mps + self.speed_time_constant_s * along_mps2).clamp(self.speed_min_mps, self.speed_max_mps);
        let turning_speed_mps = speed_mps.max(self.speed_min_mps);
        let change_rad = self.turn_time_constant_s * across_mps2 / turning_speed_mps;
        (setpoint_mps, self.bounded_rad(change_rad, speed_mps, setpoint_mps, asked_rad))
    }

    /// The course change nearest to a wanted one that a command may ask, rad: its setpoint changes from the last
    /// command by at most what the vehicle turns in two control periods, and asks for no more than it can follow.
    pub fn bounded_rad(&self, change_rad: f64, speed_mps: f64, setpoint_mps: f64, asked_rad: Option<f64>) -> f64 {
        let bound_rad = self.course_bound_rad(speed_mps, setpoint_mps);
        let step_rad = self.course_step_rad(speed_mps);
        let stepped_rad = match asked_rad {
            Some(asked_rad) => change_rad.max(asked_rad - step_rad).min(asked_rad + step_rad),
            None => change_rad,
        };
        stepped_rad.clamp(-bound_rad, bound_rad)
    }

    /// Greatest change of the course setpoint from one command to the next, rad; infinite: any.
    fn course_step_rad(&self, speed_mps: f64) -> f64 {
        let step_rad = self.course_step_speed_max / speed_mps.max(self.speed_min_mps);
        // Two turns that differ by more than half a circle cannot be told apart.
        if step_rad < std::f64::consts::PI { step_rad } else { f64::INFINITY }
    }

    /// The speed setpoint that makes the vehicle settle on a speed, m/s.
    pub fn asked_mps(&self, speed_mps: f64) -> f64 {
        speed_mps / self.speed_gain
    }

    /// The speed on which the vehicle settles with a setpoint, m/s.
    pub fn speed_mps(&self, setpoint: &Setpoint) -> f64 {
        setpoint.speed_mps * self.speed_gain
    }

    /// A setpoint of speed and course over ground as one of airspeed and heading.
    pub fn in_air(&self, setpoint: &Setpoint, wind: &Wind) -> Setpoint {
        if wind.is_calm() {
            return *setpoint;
        }
        let settled = Setpoint { speed_mps: self.speed_mps(setpoint), ..*setpoint }.in_air(wind);
        Setpoint { speed_mps: self.asked_mps(settled.speed_mps), ..settled }
    }

    /// A setpoint of airspeed and heading as one of speed and course over ground.
    pub fn over_ground(&self, setpoint: &Setpoint, wind: &Wind) -> Setpoint {
        if wind.is_calm() {
            return *setpoint;
        }
        let settled = Setpoint { speed_mps: self.speed_mps(setpoint), ..*setpoint }.over_ground(wind);
        Setpoint { speed_mps: self.asked_mps(settled.speed_mps), ..settled }
    }

    /// A setpoint of airspeed and heading that leads forwards over ground.
    ///
    /// Slower than the wind against it the vehicle would be carried backwards, on a course that says nothing of its
    /// heading: it would turn the other way to fly it. So the airspeed is at least half as much again as the head wind.
    pub fn forwards(&self, setpoint: &Setpoint, wind: &Wind) -> Setpoint {
        let head_wind_mps = -wind.horizontal_mps().dot(&course_vector(setpoint.course_rad));
        let least_mps = (HEAD_WIND_FACTOR * head_wind_mps).min(self.speed_max_mps);
        Setpoint { speed_mps: setpoint.speed_mps.max(self.asked_mps(least_mps)), ..*setpoint }
    }

    /// Greatest course change that the vehicle can follow below its limit of turn rate, rad; the faster it is or gets
    /// on the way, the lower.
    pub fn course_bound_rad(&self, speed_mps: f64, setpoint_mps: f64) -> f64 {
        let fastest_mps = speed_mps.max(self.speed_min_mps).max(setpoint_mps);
        self.course_change_max_rad.min(self.course_change_speed_max / fastest_mps)
    }

    /// Altitude setpoint, m: the third line of Eq. 2 with Eq. 9-10 where that settles, else h_e itself (reading 5).
    pub fn altitude_m(&self, law: &LawSettings, expected_altitude_m: f64, state: &State) -> f64 {
        if !self.printed_altitude {
            return expected_altitude_m;
        }
        let (a_s, b_s) = self.altitude_time_constants_s;
        let demand_mps2 = terms::vertical(law, expected_altitude_m, state.altitude_m, state.climb_mps);
        state.altitude_m + (a_s + b_s) * state.climb_mps + a_s * b_s * demand_mps2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::{Autopilot, Setpoint};

    /// (overshoot as a share of the step, error at the end) of an altitude step flown at a control period.
    fn altitude_step(law: AltitudeLaw, control_period_s: f64, start_m: f64) -> (f64, f64) {
        let law = LawSettings { altitude_law: law, ..LawSettings::default() };
        let dynamics = Dynamics::default();
        let commander = Commander::new(&law, &dynamics, control_period_s);
        let autopilot = Autopilot::new(&dynamics, 0.01);
        let mut state = State { altitude_m: start_m, speed_mps: 10.0, ..State::default() };
        let (mut overshoot, mut worst_late) = (0.0_f64, 0.0_f64);
        for tick in 0..(60.0 / control_period_s) as usize {
            let setpoint = Setpoint { altitude_m: commander.altitude_m(&law, 50.0, &state), ..state.hold() };
            for _ in 0..(control_period_s / 0.01).round() as usize {
                state = autopilot.step(&state, &setpoint);
                overshoot = overshoot.max((state.altitude_m - 50.0) / (50.0 - start_m));
                if tick as f64 * control_period_s > 40.0 {
                    worst_late = worst_late.max((state.altitude_m - 50.0).abs());
                }
            }
        }
        (overshoot, worst_late)
    }

    #[test]
    fn a_command_against_a_wind_leads_against_it() {
        let commander = Commander::new(&LawSettings::default(), &Dynamics::default(), 0.5);
        // As slow as it flies, hard to the left, into a gust of 6.6 m/s: carried backwards, it would turn to the right.
        let command = Setpoint { speed_mps: 5.0, course_rad: 1.64, altitude_m: 50.0 };
        let wind = Wind { east_mps: -6.65, ..Wind::CALM };
        let over_ground = commander.over_ground(&commander.forwards(&command, &wind), &wind);
        assert!((over_ground.course_rad - 1.64).abs() < 0.3 && over_ground.speed_mps > 3.0, "{over_ground:?}");
        // Any other stays what it is.
        let fast = Setpoint { speed_mps: 12.0, ..command };
        assert_eq!(commander.forwards(&fast, &wind), fast);
        assert_eq!(commander.forwards(&command, &Wind::CALM), command);
    }

    #[test]
    fn altitude_settles_at_any_control_period() {
        for period_s in [0.02, 0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0] {
            for start_m in [30.0, 45.0, 49.0, 50.5, 60.0, 70.0] {
                let (overshoot, late_m) = altitude_step(AltitudeLaw::Auto, period_s, start_m);
                assert!(overshoot <= 0.05, "{period_s} s from {start_m} m: overshoot {overshoot}");
                assert!(late_m < 0.01, "{period_s} s from {start_m} m: still {late_m} m off");
            }
        }
    }

    #[test]
    fn the_printed_altitude_law_never_settles_at_the_papers_period() {
        let (_, late_m) = altitude_step(AltitudeLaw::Printed, 0.5, 45.0);
        assert!(late_m > 0.3, "reading 5 says a limit cycle, got {late_m} m");
    }

    #[test]
    fn demands_are_bounded_by_what_the_vehicle_flies() {
        let commander = Commander::new(&LawSettings::default(), &Dynamics::default(), 0.5);
        let (speed_mps, change_rad) = commander.horizontal(Vector2::new(1e5, 1e5), 10.0, Vector2::new(1.0, 0.0), None);
        assert_eq!(speed_mps, 15.0);
        assert!(change_rad > 2.0 && change_rad < std::f64::consts::PI);
    }

    #[test]
    fn a_vehicle_that_turns_more_slowly_than_it_speeds_up_is_turned_with_its_own_constant() {
        let mut dynamics = Dynamics::default();
        dynamics.time_constants.course_s = 3.0;
        let change_rad = |course_law: CourseLaw, dynamics: &Dynamics| {
            let law = LawSettings { course_law, ..LawSettings::default() };
            let commander = Commander::new(&law, dynamics, 0.5);
            commander.horizontal(Vector2::new(0.5, 2.0), 8.0, Vector2::new(1.0, 0.0), None).1
        };
        assert_eq!(change_rad(CourseLaw::Auto, &dynamics), 3.0 * 2.0 / 8.0);
        assert_eq!(change_rad(CourseLaw::Printed, &dynamics), 1.0 * 2.0 / 8.0);
        assert_eq!(change_rad(CourseLaw::Own, &Dynamics::default()), 0.75 * 2.0 / 8.0);
    }

    #[test]
    fn no_course_change_asks_for_more_than_the_greatest_turn_rate() {
        for (share, reference_mps) in [(1.0, None), (0.73, None), (1.0, Some(22.0)), (0.73, Some(22.0))] {
            let mut dynamics = Dynamics::default();
            dynamics.time_constants.course_s = 3.1;
            dynamics.limits.lateral_overload_max = 0.35;
            dynamics.response.course_reference_speed_mps = reference_mps;
            dynamics.response.turn_share = share;
            let commander = Commander::new(&LawSettings::default(), &dynamics, 0.5);
            for speed_mps in [7.0, 10.0, 15.0] {
                let rate_radps =
                    commander.course_bound_rad(speed_mps, speed_mps) / dynamics.course_time_constant_s(speed_mps);
                let share_of_limit = rate_radps / dynamics.turn_rate_max_radps(speed_mps);
                assert!((share_of_limit - 1.0).abs() < 1e-12, "{share} {reference_mps:?} {speed_mps} m/s");
            }
        }
    }

    #[test]
    fn the_course_line_uses_tau_v_as_printed() {
        let commander = Commander::new(&LawSettings::default(), &Dynamics::default(), 0.5);
        let (speed_mps, change_rad) = commander.horizontal(Vector2::new(0.5, 2.0), 8.0, Vector2::new(1.0, 0.0), None);
        assert_eq!(speed_mps, 8.5);
        assert_eq!(change_rad, 1.0 * 2.0 / 8.0);
    }
}
