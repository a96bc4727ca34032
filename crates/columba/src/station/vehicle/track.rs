//! One vehicle's way, from stamped telemetry: what was flown, and nothing that was not.

use flight_model::{State, wrap_pi};
use std::collections::VecDeque;

/// So long a way is kept, s.
const KEPT_S: f64 = 30.0;
/// Two samples further apart than this say nothing of what lies between, s.
pub const GAP_MAX_S: f64 = 1.5;

/// Where a vehicle was, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time on the ground's clock at which it was there, s.
    pub at_s: f64,
    /// The state.
    pub state: State,
}

/// The way of one vehicle.
#[derive(Clone, Debug, Default)]
pub struct Track {
    samples: VecDeque<Sample>,
}

impl Track {
    /// Takes the next sample; one that is not later than the last is not taken.
    pub fn push(&mut self, sample: Sample) -> bool {
        let is_later = self.samples.back().is_none_or(|last| sample.at_s > last.at_s);
        if !is_later || !sample.state.is_finite() {
            return false;
        }
        self.samples.push_back(sample);
        while self.samples.front().is_some_and(|first| sample.at_s - first.at_s > KEPT_S) {
            self.samples.pop_front();
        }
        true
    }

    /// The last sample.
    pub fn last(&self) -> Option<&Sample> {
        self.samples.back()
    }

    /// Forgets everything: the vehicle's clock began anew.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// The state at a time between two samples, and how far apart these are, s; none where nothing was heard.
    pub fn at(&self, at_s: f64) -> Option<(State, f64)> {
        let next = self.samples.partition_point(|sample| sample.at_s < at_s);
        let after = self.samples.get(next)?;
        if after.at_s == at_s {
            return Some((after.state, 0.0));
        }
        let before = self.samples.get(next.checked_sub(1)?)?;
        let gap_s = after.at_s - before.at_s;
        (gap_s <= GAP_MAX_S).then(|| (between(before, after, at_s), gap_s))
    }

    /// The last state moved on to a time at its velocity, and how old it is, s.
    pub fn carried_to(&self, at_s: f64, age_max_s: f64) -> Option<(State, f64)> {
        let last = self.samples.back()?;
        let age_s = (at_s - last.at_s).max(0.0);
        let ahead_s = age_s.min(age_max_s);
        let (north_mps, east_mps) = velocity_mps(&last.state);
        let state = State {
            x_m: last.state.x_m + north_mps * ahead_s,
            y_m: last.state.y_m + east_mps * ahead_s,
            altitude_m: last.state.altitude_m + last.state.climb_mps * ahead_s,
            ..last.state
        };
        Some((state, age_s))
    }

    /// Samples of the last `window_s`, in Hz; none with less than half of the window heard.
    pub fn rate_hz(&self, now_s: f64, window_s: f64) -> Option<f64> {
        let from = self.samples.partition_point(|sample| sample.at_s < now_s - window_s);
        let first = self.samples.get(from)?;
        let last = self.samples.back()?;
        let span_s = last.at_s - first.at_s;
        (span_s >= 0.5 * window_s).then(|| (self.samples.len() - from - 1) as f64 / span_s)
    }
}

/// North and east, m/s.
pub fn velocity_mps(state: &State) -> (f64, f64) {
    let (sin, cos) = libm::sincos(state.course_rad);
    (state.speed_mps * cos, state.speed_mps * sin)
}

/// Horizontal distance, m.
pub fn distance_m(a: &State, b: &State) -> f64 {
    libm::hypot(a.x_m - b.x_m, a.y_m - b.y_m)
}

/// Distance with heights, m.
pub fn slant_m(a: &State, b: &State) -> f64 {
    libm::hypot(distance_m(a, b), a.altitude_m - b.altitude_m)
}

/// Cubic in position, by both velocities; linear in the rest.
fn between(before: &Sample, after: &Sample, at_s: f64) -> State {
    let span_s = after.at_s - before.at_s;
    let u = (at_s - before.at_s) / span_s;
    let (a, b) = (&before.state, &after.state);
    let ((north_a, east_a), (north_b, east_b)) = (velocity_mps(a), velocity_mps(b));
    let cubic = |from: f64, to: f64, slope_from: f64, slope_to: f64| {
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * from
            + (u3 - 2.0 * u2 + u) * span_s * slope_from
            + (3.0 * u2 - 2.0 * u3) * to
            + (u3 - u2) * span_s * slope_to
    };
    State {
        x_m: cubic(a.x_m, b.x_m, north_a, north_b),
        y_m: cubic(a.y_m, b.y_m, east_a, east_b),
        altitude_m: cubic(a.altitude_m, b.altitude_m, a.climb_mps, b.climb_mps),
        speed_mps: a.speed_mps + u * (b.speed_mps - a.speed_mps),
        course_rad: wrap_pi(a.course_rad + u * wrap_pi(b.course_rad - a.course_rad)),
        climb_mps: a.climb_mps + u * (b.climb_mps - a.climb_mps),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(at_s: f64) -> Sample {
        // 20 m/s round 80 m.
        let (sin, cos) = libm::sincos(0.25 * at_s);
        let state = State {
            x_m: 80.0 * sin,
            y_m: -80.0 * cos,
            speed_mps: 20.0,
            course_rad: wrap_pi(0.25 * at_s),
            ..State::default()
        };
        Sample { at_s, state }
    }

    #[test]
    fn a_turn_is_followed_to_centimetres_between_samples() {
        let mut track = Track::default();
        (0..50).for_each(|k| assert!(track.push(circle(0.1 * f64::from(k)))));
        for k in 0..400 {
            let at_s = 0.5 + 0.01 * f64::from(k);
            let (state, gap_s) = track.at(at_s).unwrap();
            let truth = circle(at_s).state;
            let off_m = distance_m(&state, &truth);
            assert!(off_m < 0.01 && gap_s < 0.11, "{off_m} {gap_s}");
        }
        assert!((track.rate_hz(4.9, 2.0).unwrap() - 10.0).abs() < 0.1);
    }

    #[test]
    fn nothing_is_said_of_what_was_not_heard() {
        let mut track = Track::default();
        track.push(circle(0.0));
        track.push(circle(3.0));
        assert_eq!(track.at(1.0), None, "a gap of three seconds");
        assert_eq!(track.at(3.1), None, "the future");
        assert_eq!(track.at(-0.1), None, "the past");
        assert!(!track.push(circle(2.0)), "an older one");
        let (ahead, age_s) = track.carried_to(3.5, 1.0).unwrap();
        assert_eq!(age_s, 0.5);
        assert!((ahead.x_m - circle(3.5).state.x_m).abs() < 1.0);
    }
}
