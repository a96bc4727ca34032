//! A flight of single steps: turns, changes of speed and of altitude, each from rest, back and forth over one area.
//!
//! All vehicles fly the same steps at the same time, so that their distances stay what they were.

use flight_model::{Setpoint, State, wrap_pi};
use nalgebra::Vector2;
use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;

/// Where and around what the steps are flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// Speed from which steps start, m/s.
    pub speed_mps: f64,
    /// First course, rad.
    pub course_rad: f64,
    /// Lowest altitude, m above the origin.
    pub altitude_m: f64,
    /// Vehicles turn back before they are further than this from where the steps began, m; where they are is told by
    /// the first of them.
    pub area_m: f64,
}

/// One step: what changes, and how long it is held.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    course_rad: f64,
    speed_mps: f64,
    altitude_m: f64,
    hold_s: f64,
}

/// The flight, and where in it the vehicles are.
#[derive(Clone, Debug)]
pub struct StepFlight {
    settings: StepSettings,
    steps: VecDeque<Step>,
    /// When the present step is over, s.
    until_s: f64,
    course_rad: f64,
    speed_mps: f64,
    altitude_m: f64,
    centre: Option<Vector2<f64>>,
    /// Turns back that are left before it is given up.
    turns_back: usize,
    over: bool,
}

/// A turn is held so long, s; a hard one; a change of speed; of altitude.
const TURN_S: f64 = 11.0;
const HARD_TURN_S: f64 = 13.0;
const SPEED_S: f64 = 16.0;
const ALTITUDE_S: f64 = 16.0;
/// The flock is to be at rest before the first step, s.
const REST_S: f64 = 16.0;
/// The first step waits until the flock is so near to its altitude, m, but not for longer than this, s.
const LEVEL_M: f64 = 2.0;
const CLIMB_MAX_S: f64 = 90.0;
/// An area that is too small for the vehicles is not turned back in for ever.
const TURNS_BACK_MAX: usize = 12;

impl StepFlight {
    /// The steps.
    pub fn new(settings: StepSettings) -> Self {
        let turn = |deg: f64, hold_s| Step { course_rad: deg.to_radians(), speed_mps: 0.0, altitude_m: 0.0, hold_s };
        let speed = |speed_mps| Step { speed_mps, ..turn(0.0, SPEED_S) };
        let climb = |altitude_m| Step { altitude_m, ..turn(0.0, ALTITUDE_S) };
        let steps = [
            turn(0.0, REST_S),
            turn(10.0, TURN_S),
            turn(-10.0, TURN_S),
            turn(45.0, TURN_S),
            turn(-45.0, TURN_S),
            turn(90.0, HARD_TURN_S),
            turn(90.0, HARD_TURN_S),
            speed(2.0),
            speed(-2.0),
            speed(-2.0),
            speed(2.0),
            turn(-90.0, HARD_TURN_S),
            turn(-90.0, HARD_TURN_S),
            climb(5.0),
            climb(-5.0),
            climb(20.0),
            climb(-20.0),
        ];
        Self {
            course_rad: settings.course_rad,
            speed_mps: settings.speed_mps,
            altitude_m: settings.altitude_m,
            settings,
            steps: steps.into(),
            until_s: 0.0,
            centre: None,
            turns_back: TURNS_BACK_MAX,
            over: false,
        }
    }

    /// How long it takes at most, s.
    pub fn longest_s(&self) -> f64 {
        self.steps.iter().map(|step| step.hold_s).sum::<f64>() + TURNS_BACK_MAX as f64 * HARD_TURN_S + CLIMB_MAX_S
    }

    /// Whether the last step has been held.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// The setpoint at a time in s since the beginning, with the first vehicle in a state.
    pub fn setpoint(&mut self, t_s: f64, first: &State) -> Setpoint {
        let climbs = self.centre.is_none() && (first.altitude_m - self.altitude_m).abs() > LEVEL_M;
        if t_s >= self.until_s && (!climbs || t_s > CLIMB_MAX_S) {
            let position_m = first.position_m();
            let centre = *self.centre.get_or_insert(position_m);
            self.next(t_s, position_m - centre);
        }
        Setpoint { speed_mps: self.speed_mps, course_rad: self.course_rad, altitude_m: self.altitude_m }
    }

    fn next(&mut self, t_s: f64, away_m: Vector2<f64>) {
        let Some(step) = self.steps.front().copied() else {
            self.over = true;
            return;
        };
        let course_rad = self.course_rad + step.course_rad;
        let way_m = flight_model::course_vector(course_rad) * (self.speed_mps * step.hold_s);
        let is_outward = (away_m + way_m).norm() > self.settings.area_m.max(away_m.norm());
        if is_outward && self.turns_back > 0 && away_m.norm() > 0.0 {
            self.turns_back -= 1;
            // The short way round to the middle, by a quarter of a circle at a time.
            let home_rad = libm::atan2(-away_m.y, -away_m.x);
            let off_rad = wrap_pi(home_rad - self.course_rad).clamp(-FRAC_PI_2, FRAC_PI_2);
            if off_rad.abs() > 0.2 {
                self.course_rad = wrap_pi(self.course_rad + off_rad);
                self.until_s = t_s + HARD_TURN_S;
                return;
            }
        }
        self.steps.pop_front();
        self.course_rad = wrap_pi(course_rad);
        self.speed_mps += step.speed_mps;
        self.altitude_m += step.altitude_m;
        self.until_s = t_s + step.hold_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::{Autopilot, Dynamics};

    #[test]
    fn it_is_over_in_time_and_stays_in_its_area() {
        for area_m in [400.0, 800.0, 5_000.0] {
            let settings = StepSettings { speed_mps: 10.0, course_rad: 1.0, altitude_m: 50.0, area_m };
            let mut flight = StepFlight::new(settings);
            let longest_s = flight.longest_s();
            let autopilot = Autopilot::new(&Dynamics::default(), 0.1);
            let mut state = State { altitude_m: 50.0, speed_mps: 10.0, course_rad: 1.0, ..State::default() };
            let mut t_s = 0.0;
            while !flight.is_over() && t_s <= longest_s {
                let setpoint = flight.setpoint(t_s, &state);
                assert!((8.0..=12.0).contains(&setpoint.speed_mps) && (50.0..=70.0).contains(&setpoint.altitude_m));
                state = autopilot.step(&state, &setpoint);
                assert!(state.position_m().norm() < area_m + 150.0, "{area_m} {t_s} {state:?}");
                t_s += 0.1;
            }
            assert!(flight.is_over(), "{area_m}");
        }
    }
}
