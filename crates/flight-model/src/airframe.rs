//! Airframes: what a vehicle of a kind can do, as constants of the flight model.

use crate::{Dynamics, Limits, PlantSettings, Response, TimeConstants};

/// A kind of vehicle: how it flies, and how fast and how tightly it flies by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airframe {
    /// Constants of Eq. 1 and 3: what a controller reckons with, and how the vehicle flies where it has no plant.
    pub dynamics: Dynamics,
    /// How it flies otherwise than by Eq. 1.
    pub plant: Option<PlantSettings>,
    /// Its airspeed where nobody asks for another, m/s.
    pub cruise_speed_mps: f64,
    /// Radius of the circles that it flies by itself, m.
    pub loiter_radius_m: f64,
}

/// Standard gravity, m/s2.
const GRAVITY_MPS2: f64 = 9.806_65;

impl Airframe {
    /// The paper's UAV (section 4): 5 to 15 m/s.
    pub fn paper() -> Self {
        Self { dynamics: Dynamics::default(), plant: None, cruise_speed_mps: 10.0, loiter_radius_m: 60.0 }
    }

    /// The plane of ArduPilot's SITL with its default parameters: 10 to 30 m/s, cruise 22 m/s, banks of 65 degrees.
    ///
    /// The constants are those that `columba identify` finds of an ArduPlane 4.7 in GUIDED at 684 m above sea level
    /// (course steps up to 45 degrees, speed 2 and 5 m/s); those of altitude were fitted to steps of 10 m. What Eq. 1
    /// does not show, its plant does: its speed loop overshoots, beyond 50 degrees it turns twice as fast, and its
    /// climb rate builds up over seconds.
    pub fn plane() -> Self {
        Self {
            dynamics: Dynamics {
                time_constants: TimeConstants { speed_s: 1.1, course_s: 3.1, altitude_a_s: 1.2, altitude_b_s: 2.8 },
                limits: Limits {
                    speed_min_mps: 10.0,
                    speed_max_mps: 30.0,
                    climb_min_mps: -5.0,
                    climb_max_mps: 5.0,
                    lateral_overload_max: overload_at_bank_deg(65.0),
                    gravity_mps2: GRAVITY_MPS2,
                },
                response: Response {
                    speed_gain: 1.066,
                    speed_dead_time_s: 0.3,
                    course_dead_time_s: 0.18,
                    altitude_dead_time_s: 0.3,
                    course_reference_speed_mps: Some(22.0),
                    // Its autopilot could do 0.9 to 1.3; faster changes make it pitch, and take the lift from turns.
                    acceleration_max_mps2: 0.4,
                    course_step_max_rad: 50_f64.to_radians(),
                    turn_share: 0.73,
                },
            },
            plant: Some(PlantSettings::plane()),
            cruise_speed_mps: 22.0,
            loiter_radius_m: 80.0,
        }
    }

    /// The plane of PX4's simulator with its default parameters: 10 to 20 m/s, cruise 15 m/s, banks of 50 degrees.
    ///
    /// The time constants were fitted to the steps of a PX4 1.18 in Guided Course (course 30 to 90 degrees, speed 3
    /// m/s, altitude 20 m); it climbs and sinks at the rates of FW_T_CLMB_R_SP and FW_T_SINK_R_SP.
    pub fn px4_plane() -> Self {
        Self {
            dynamics: Dynamics {
                time_constants: TimeConstants { speed_s: 1.6, course_s: 1.1, altitude_a_s: 1.9, altitude_b_s: 2.9 },
                limits: Limits {
                    speed_min_mps: 10.0,
                    speed_max_mps: 20.0,
                    climb_min_mps: -2.0,
                    climb_max_mps: 3.0,
                    lateral_overload_max: overload_at_bank_deg(50.0),
                    gravity_mps2: GRAVITY_MPS2,
                },
                response: Response {
                    speed_gain: 1.0,
                    speed_dead_time_s: 0.2,
                    course_dead_time_s: 0.25,
                    altitude_dead_time_s: 0.2,
                    course_reference_speed_mps: Some(15.0),
                    acceleration_max_mps2: 2.5,
                    course_step_max_rad: 50_f64.to_radians(),
                    turn_share: 1.0,
                },
            },
            plant: Some(PlantSettings::px4_plane()),
            cruise_speed_mps: 15.0,
            loiter_radius_m: 80.0,
        }
    }
}

/// The lateral overload of a coordinated level turn.
fn overload_at_bank_deg(bank_deg: f64) -> f64 {
    libm::tan(bank_deg.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Autopilot, Setpoint, State, wrap_pi};

    /// Time until a step is done to a share, s.
    fn time_to(
        airframe: &Airframe,
        share: f64,
        setpoint: impl Fn(&State) -> Setpoint,
        done: impl Fn(&State) -> f64,
    ) -> f64 {
        let autopilot = Autopilot::new(&airframe.dynamics, 0.01);
        let start = State { altitude_m: 100.0, speed_mps: airframe.cruise_speed_mps, ..State::default() };
        let setpoint = setpoint(&start);
        let mut state = start;
        (1..6_000)
            .find(|_| {
                state = autopilot.step(&state, &setpoint);
                done(&state) >= share
            })
            .map_or(f64::INFINITY, |steps| f64::from(steps) * 0.01)
    }

    fn course(airframe: &Airframe, step_deg: f64, share: f64) -> f64 {
        let step_rad = step_deg.to_radians();
        let to = |start: &State| Setpoint { course_rad: step_rad, ..start.hold() };
        let dead_time_s = airframe.dynamics.response.course_dead_time_s;
        dead_time_s + time_to(airframe, share, to, |state| wrap_pi(state.course_rad) / step_rad)
    }

    fn altitude(airframe: &Airframe, step_m: f64, share: f64) -> f64 {
        let to = |start: &State| Setpoint { altitude_m: start.altitude_m + step_m, ..start.hold() };
        time_to(airframe, share, to, |state| (state.altitude_m - 100.0) / step_m)
    }

    #[test]
    fn a_plane_answers_steps_as_an_arduplane() {
        let plane = Airframe::plane();
        // Measured: t63 of 3.6-3.8 s and 3.45 s, t50 and t90 of 10 m up in 3.5 s and 8.0 s.
        assert!((course(&plane, 10.0, 0.63) - 3.7).abs() < 0.6, "{}", course(&plane, 10.0, 0.63));
        assert!((course(&plane, 45.0, 0.63) - 3.45).abs() < 0.6, "{}", course(&plane, 45.0, 0.63));
        assert!((altitude(&plane, 10.0, 0.5) - 3.5).abs() < 0.5, "{}", altitude(&plane, 10.0, 0.5));
        assert!((altitude(&plane, 10.0, 0.9) - 8.0).abs() < 0.5, "{}", altitude(&plane, 10.0, 0.9));
        // Measured: 50 m up in 8.2 s and 13.3 s. Eq. 1 is at its limit of climb at once, and so ahead by as long as the
        // real climb rate takes to build up.
        for (share, measured_s) in [(0.5, 8.2), (0.9, 13.3)] {
            let ahead_s = measured_s - altitude(&plane, 50.0, share);
            assert!((2.5..3.5).contains(&ahead_s), "{ahead_s}");
        }
    }

    #[test]
    fn a_px4_plane_answers_steps_as_a_px4() {
        let plane = Airframe::px4_plane();
        // Measured: t50 1.35 s and t90 2.6 s of 30 degrees; t50 5.0 s and t90 10.4 s of 20 m up, 5.8 s and 9.7 s down.
        assert!((course(&plane, 30.0, 0.9) - 2.6).abs() < 0.5, "{}", course(&plane, 30.0, 0.9));
        assert!((altitude(&plane, 20.0, 0.5) - 5.0).abs() < 1.0, "{}", altitude(&plane, 20.0, 0.5));
        assert!((altitude(&plane, 20.0, 0.9) - 10.4).abs() < 1.5, "{}", altitude(&plane, 20.0, 0.9));
        assert!((altitude(&plane, -20.0, 0.5) - 5.8).abs() < 1.0, "{}", altitude(&plane, -20.0, 0.5));
        assert!((altitude(&plane, -20.0, 0.9) - 9.7).abs() < 1.6, "{}", altitude(&plane, -20.0, 0.9));
    }

    #[test]
    fn what_an_airframe_flies_by_itself_is_within_its_limits() {
        for airframe in [Airframe::paper(), Airframe::plane(), Airframe::px4_plane()] {
            let limits = airframe.dynamics.limits;
            assert!((limits.speed_min_mps..=limits.speed_max_mps).contains(&airframe.cruise_speed_mps));
            let tightest_m =
                airframe.cruise_speed_mps * airframe.cruise_speed_mps / limits.lateral_acceleration_max_mps2();
            assert!(airframe.loiter_radius_m > tightest_m);
        }
    }
}
