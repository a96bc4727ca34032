//! Dead times.

use crate::{Response, Setpoint};
use std::collections::VecDeque;

/// A value that acts later: by a dead time, rounded to whole steps.
#[derive(Clone, Debug)]
pub struct Delay {
    steps: usize,
    /// What has not acted yet, the oldest first.
    line: VecDeque<f64>,
}

/// The three setpoints of a vehicle, each after its dead time.
#[derive(Clone, Debug)]
pub struct SetpointDelay {
    speed: Delay,
    course: Delay,
    altitude: Delay,
}

impl Delay {
    /// A dead time in s at steps of `step_s`; before its end the value is `first`.
    pub fn new(dead_time_s: f64, step_s: f64, first: f64) -> Self {
        let steps = (dead_time_s / step_s).round().clamp(0.0, 1e5) as usize;
        let mut delay = Self { steps, line: VecDeque::with_capacity(steps + 1) };
        delay.begin(first);
        delay
    }

    /// Forgets what was asked for before: until a dead time from now it is `first`.
    pub fn begin(&mut self, first: f64) {
        self.line.clear();
        self.line.resize(self.steps, first);
    }

    /// One step: takes what is asked for in it and gives what acts in it.
    #[inline]
    pub fn pass(&mut self, value: f64) -> f64 {
        match self.line.pop_front() {
            Some(acts) => {
                self.line.push_back(value);
                acts
            }
            None => value,
        }
    }
}

impl SetpointDelay {
    /// Dead times of speed, course and altitude in s, at steps of `step_s`.
    pub fn new([speed_s, course_s, altitude_s]: [f64; 3], step_s: f64, first: &Setpoint) -> Self {
        Self {
            speed: Delay::new(speed_s, step_s, first.speed_mps),
            course: Delay::new(course_s, step_s, first.course_rad),
            altitude: Delay::new(altitude_s, step_s, first.altitude_m),
        }
    }

    /// The dead times of a response; none where it has none.
    pub fn of(response: &Response, step_s: f64, first: &Setpoint) -> Option<Self> {
        let dead_times_s = [response.speed_dead_time_s, response.course_dead_time_s, response.altitude_dead_time_s];
        dead_times_s.iter().any(|time_s| *time_s > 0.0).then(|| Self::new(dead_times_s, step_s, first))
    }

    /// Forgets what was asked for before.
    pub fn begin(&mut self, first: &Setpoint) {
        self.speed.begin(first.speed_mps);
        self.course.begin(first.course_rad);
        self.altitude.begin(first.altitude_m);
    }

    /// One step: takes the setpoint that is asked for in it and gives the one that acts in it.
    #[inline]
    pub fn pass(&mut self, setpoint: &Setpoint) -> Setpoint {
        Setpoint {
            speed_mps: self.speed.pass(setpoint.speed_mps),
            course_rad: self.course.pass(setpoint.course_rad),
            altitude_m: self.altitude.pass(setpoint.altitude_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_acts_a_dead_time_later() {
        let mut delay = Delay::new(0.03, 0.01, 7.0);
        let passed: Vec<f64> = (0..5).map(|step| delay.pass(f64::from(step))).collect();
        assert_eq!(passed, [7.0, 7.0, 7.0, 0.0, 1.0]);
        assert_eq!(Delay::new(0.0, 0.01, 7.0).pass(3.0), 3.0);
    }
}
