//! One vehicle's way, from stamped telemetry: what was flown, and nothing that was not.

use flight_model::{State, wrap_pi};
use std::collections::VecDeque;

/// So long a way is kept, s.
const KEPT_S: f64 = 30.0;
/// Two samples further apart than this say nothing of what lies between, s.
pub const GAP_MAX_S: f64 = 1.5;
/// Samples further apart than this are helped by headings, which have to be nearer to each other than this, s.
const HEADINGS_FROM_S: f64 = 0.4;

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
    /// Time and heading, rad: between samples that are far apart they tell the turns.
    headings: VecDeque<(f64, f64)>,
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

    /// Takes a heading, rad; one that is not later than the last is not taken.
    pub fn push_heading(&mut self, at_s: f64, heading_rad: f64) {
        if !heading_rad.is_finite() || self.headings.back().is_some_and(|&(last_s, _)| at_s <= last_s) {
            return;
        }
        self.headings.push_back((at_s, heading_rad));
        while self.headings.front().is_some_and(|&(first_s, _)| at_s - first_s > KEPT_S) {
            self.headings.pop_front();
        }
    }

    /// The last sample.
    pub fn last(&self) -> Option<&Sample> {
        self.samples.back()
    }

    /// Forgets everything: the vehicle's clock began anew.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.headings.clear();
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
        if gap_s > GAP_MAX_S {
            return None;
        }
        let turned = if gap_s > HEADINGS_FROM_S { self.along_headings(before, after, at_s) } else { None };
        Some((turned.unwrap_or_else(|| between(before, after, at_s)), gap_s))
    }

    /// The state between two samples, on a way that turns as the headings between them do; none where these are too
    /// few. What the way misses at the second sample is spread over all of it.
    fn along_headings(&self, before: &Sample, after: &Sample, at_s: f64) -> Option<State> {
        let span_s = after.at_s - before.at_s;
        let share = |when_s: f64| (when_s - before.at_s) / span_s;
        // The way over ground is off from the nose by the wind, and by what a vehicle slips in a turn.
        let first_rad = wrap_pi(before.state.course_rad - self.heading_at(before.at_s)?);
        let last_rad = wrap_pi(after.state.course_rad - self.heading_at(after.at_s)?);
        let course_rad = |when_s: f64| {
            let off_rad = first_rad + share(when_s) * wrap_pi(last_rad - first_rad);
            Some(wrap_pi(self.heading_at(when_s)? + off_rad))
        };
        let speed_mps =
            |when_s: f64| before.state.speed_mps + share(when_s) * (after.state.speed_mps - before.state.speed_mps);
        let from = self.headings.partition_point(|&(heard_s, _)| heard_s <= before.at_s);
        let inside =
            self.headings.range(from..).map(|&(heard_s, _)| heard_s).take_while(|&heard_s| heard_s < after.at_s);
        let (mut last_s, mut way_m, mut way_there_m) = (before.at_s, [0.0; 2], [0.0; 2]);
        for until_s in inside.chain([after.at_s]) {
            for (to_s, is_there) in [(until_s.min(at_s.max(last_s)), true), (until_s, false)] {
                let middle_s = 0.5 * (last_s + to_s);
                let (sin, cos) = libm::sincos(course_rad(middle_s)?);
                let length_m = speed_mps(middle_s) * (to_s - last_s);
                way_m = [way_m[0] + length_m * cos, way_m[1] + length_m * sin];
                last_s = to_s;
                if is_there && to_s <= at_s {
                    way_there_m = way_m;
                }
            }
        }
        let misses_m = [after.state.x_m - before.state.x_m - way_m[0], after.state.y_m - before.state.y_m - way_m[1]];
        Some(State {
            x_m: before.state.x_m + way_there_m[0] + share(at_s) * misses_m[0],
            y_m: before.state.y_m + way_there_m[1] + share(at_s) * misses_m[1],
            course_rad: course_rad(at_s)?,
            ..between(before, after, at_s)
        })
    }

    /// The heading at a time, rad, by the two that are nearest: the next one after a sample may still be under way.
    fn heading_at(&self, at_s: f64) -> Option<f64> {
        let next = self.headings.partition_point(|&(heard_s, _)| heard_s < at_s);
        let later = next.clamp(1, self.headings.len().saturating_sub(1).max(1));
        let (&(before_s, before_rad), &(after_s, after_rad)) =
            (self.headings.get(later - 1)?, self.headings.get(later)?);
        let is_near = at_s - before_s <= HEADINGS_FROM_S && after_s - before_s <= HEADINGS_FROM_S && at_s >= before_s;
        let share = (at_s - before_s) / (after_s - before_s);
        is_near.then(|| wrap_pi(before_rad + share * wrap_pi(after_rad - before_rad)))
    }

    /// The last state moved on to a time at its velocity, and how old it is, s.
    pub fn carried_to(&self, at_s: f64, age_max_s: f64) -> Option<(State, f64)> {
        let last = self.samples.back()?;
        let age_s = (at_s - last.at_s).max(0.0);
        let ahead_s = age_s.min(age_max_s);
        let position_m = last.state.position_m() + last.state.velocity_mps() * ahead_s;
        let state = State {
            x_m: position_m.x,
            y_m: position_m.y,
            altitude_m: last.state.altitude_m + last.state.climb_mps * ahead_s,
            ..last.state
        };
        Some((state, age_s))
    }

    /// Samples of the last `window_s`, in Hz; none with less than half of the window heard.
    pub fn rate_hz(&self, now_s: f64, window_s: f64) -> Option<f64> {
        let intervals_s = self.intervals_s(now_s, window_s)?;
        Some(intervals_s.len() as f64 / intervals_s.iter().sum::<f64>())
    }

    /// The rate at which samples are sent, in Hz: that of those that came, or the usual one between two of them, which
    /// does not change with the few that a link loses.
    pub fn sent_hz(&self, now_s: f64, window_s: f64) -> Option<f64> {
        let mut intervals_s = self.intervals_s(now_s, window_s)?;
        let middle = intervals_s.len() / 2;
        let (_, median_s, _) = intervals_s.select_nth_unstable_by(middle, f64::total_cmp);
        let usual_hz = median_s.recip();
        self.rate_hz(now_s, window_s).map(|rate_hz| rate_hz.max(usual_hz))
    }

    /// Times between the samples of the last `window_s`, s; none with less than half of the window heard.
    fn intervals_s(&self, now_s: f64, window_s: f64) -> Option<Vec<f64>> {
        let from = self.samples.partition_point(|sample| sample.at_s < now_s - window_s);
        let (first, last) = (self.samples.get(from)?, self.samples.back()?);
        let later = self.samples.range(from..).skip(1);
        let between = self.samples.range(from..).zip(later).map(|(before, after)| after.at_s - before.at_s);
        (last.at_s - first.at_s >= 0.5 * window_s).then(|| between.collect())
    }
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
    let (velocity_a, velocity_b) = (a.velocity_mps(), b.velocity_mps());
    let cubic = |from: f64, to: f64, slope_from: f64, slope_to: f64| {
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * from
            + (u3 - 2.0 * u2 + u) * span_s * slope_from
            + (3.0 * u2 - 2.0 * u3) * to
            + (u3 - u2) * span_s * slope_to
    };
    State {
        x_m: cubic(a.x_m, b.x_m, velocity_a.x, velocity_b.x),
        y_m: cubic(a.y_m, b.y_m, velocity_a.y, velocity_b.y),
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
    fn headings_tell_the_turns_between_samples_of_a_second() {
        // 20 m/s, the course swings by 40 degrees each way in 1.6 s; the nose is 5 degrees off in the wind.
        let course_rad = |at_s: f64| 0.7 * libm::sin(at_s * std::f64::consts::TAU / 1.6);
        let (mut bare, mut helped, mut way) = (Track::default(), Track::default(), Vec::new());
        let (mut x_m, mut y_m) = (0.0, 0.0);
        for k in 0..=2000_u32 {
            let at_s = 1e-3 * f64::from(k);
            let state = State { x_m, y_m, speed_mps: 20.0, course_rad: course_rad(at_s), ..State::default() };
            if k % 1000 == 0 && k <= 2000 {
                bare.push(Sample { at_s, state });
                helped.push(Sample { at_s, state });
            }
            if k % 100 == 40 && k < 2000 {
                helped.push_heading(at_s, course_rad(at_s) + 0.09);
            }
            way.push((at_s, state));
            let (sin, cos) = libm::sincos(course_rad(at_s + 0.5e-3));
            (x_m, y_m) = (x_m + 20e-3 * cos, y_m + 20e-3 * sin);
        }
        let worst_m = |track: &Track| {
            let offs = way[1000..=2000].iter().map(|(at_s, truth)| distance_m(&track.at(*at_s).unwrap().0, truth));
            offs.fold(0.0, f64::max)
        };
        assert!(worst_m(&bare) > 1.5, "{}", worst_m(&bare));
        assert!(worst_m(&helped) < 0.2, "{}", worst_m(&helped));
    }

    #[test]
    fn what_a_link_loses_does_not_change_the_rate_at_which_samples_are_sent() {
        let (mut lossy, mut slow) = (Track::default(), Track::default());
        for k in 0..50 {
            // Two of nine are lost.
            if k % 9 != 2 && k % 9 != 5 {
                lossy.push(circle(0.1 * f64::from(k)));
            }
            slow.push(circle(0.2 * f64::from(k)));
        }
        assert!(lossy.rate_hz(4.9, 1.5).unwrap() < 8.5);
        assert!((lossy.sent_hz(4.9, 1.5).unwrap() - 10.0).abs() < 0.1);
        assert!((slow.sent_hz(9.8, 1.5).unwrap() - 5.0).abs() < 0.1);
        assert_eq!(slow.sent_hz(11.0, 1.5), None, "too little was heard");
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
