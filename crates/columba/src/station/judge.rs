//! Separation and clearance of what was flown: between tracks that are aligned in time, at a rate finer than
//! telemetry's.
//!
//! A distance is judged only where both tracks are known: between two samples that were heard. Time of which nothing
//! was heard is counted as unseen, and never judged.

use super::vehicle::track::{Track, distance_m};
use crate::judge::{
    ALTITUDE_TOLERANCE_M, COLLISION_DISTANCE_M, COURSE_TOLERANCE_RAD, Least, SPEED_TOLERANCE_MPS, Verdict,
};
use controller::{Expected, Obstacle};
use flight_model::{State, wrap_pi};
use serde::Serialize;

/// Distances are judged so often, s.
const STEP_S: f64 = 0.02;
/// What is not heard after this is unseen, s.
const WAIT_S: f64 = 2.5;
/// How hard a vehicle can change its way between two samples, m/s2: bounds what interpolation can miss.
const ACCELERATION_MPS2: f64 = 10.0;
/// GLOBAL_POSITION_INT tells whole 1e-7 degrees and centimetres a second, m.
const QUANTUM_M: f64 = 0.02;

/// What a least distance rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Ground {
    /// Time between the samples on both sides of it, the longer of two, s.
    pub sample_gap_s: f64,
    /// By how much it may be wrong: interpolation, clocks, and what the message rounds, m. Not what the autopilot
    /// itself does not know of its position.
    pub uncertainty_m: f64,
}

/// What a judge needs to know of one vehicle.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// Its way.
    pub track: &'a Track,
    /// By how much its clock may be wrong, s.
    pub clock_error_s: f64,
    /// Whether it is in the air: one on the ground is not judged.
    pub is_airborne: bool,
    /// Whether it flies with the flock; the others are judged too, but are not asked to converge.
    pub is_member: bool,
}

/// Judges the flight of a flock.
pub struct TrackJudge {
    obstacles: Vec<Obstacle>,
    expected: Expected,
    safe_distance_m: f64,
    start_s: f64,
    /// Steps judged.
    steps: u64,
    last: Vec<Option<State>>,
    inside: Vec<Vec<bool>>,
    close: Vec<Vec<u8>>,
    outside_s: [Option<f64>; 3],
    unseen_s: Vec<f64>,
    verdict: Verdict,
    grounds: [Ground; 2],
    /// Least distances since they were last asked for: separation, clearance.
    recent_m: [f64; 2],
}

impl TrackJudge {
    /// A judge of `vehicles` from a time on the ground's clock.
    pub fn new(
        vehicles: usize,
        obstacles: &[Obstacle],
        expected: Expected,
        safe_distance_m: f64,
        start_s: f64,
    ) -> Self {
        Self {
            obstacles: obstacles.to_vec(),
            expected,
            safe_distance_m,
            start_s,
            steps: 0,
            last: vec![None; vehicles],
            inside: vec![vec![false; obstacles.len()]; vehicles],
            close: vec![vec![0; vehicles]; vehicles],
            outside_s: [None; 3],
            unseen_s: vec![0.0; vehicles],
            verdict: Verdict::default(),
            grounds: [Ground::default(); 2],
            recent_m: [f64::INFINITY; 2],
        }
    }

    /// Judges what was heard until `now_s`, but nothing after `until_s`.
    pub fn judge(&mut self, vehicles: &[Seen<'_>], now_s: f64, until_s: f64) {
        loop {
            let at_s = self.start_s + STEP_S * self.steps as f64;
            let is_heard =
                |seen: &Seen<'_>| !seen.is_airborne || seen.track.last().is_some_and(|last| last.at_s >= at_s);
            let is_due = vehicles.iter().all(is_heard) || now_s - at_s > WAIT_S;
            if at_s > until_s || !is_due {
                return;
            }
            self.step(vehicles, at_s);
            self.steps += 1;
        }
    }

    /// The last time on the ground's clock that is judged, s; before the start when nothing is.
    pub fn judged_s(&self) -> f64 {
        self.start_s + STEP_S * (self.steps as f64 - 1.0)
    }

    /// The least separation and clearance since they were last taken, m.
    pub fn recent_m(&self) -> [f64; 2] {
        self.recent_m
    }

    /// The least separation and clearance since this was last asked, m.
    pub fn take_recent_m(&mut self) -> [f64; 2] {
        std::mem::replace(&mut self.recent_m, [f64::INFINITY; 2])
    }

    /// For how long each vehicle was not seen, s.
    pub fn unseen_s(&self) -> &[f64] {
        &self.unseen_s
    }

    /// What the least separation and the least clearance rest on.
    pub fn grounds(&self) -> [Ground; 2] {
        self.grounds
    }

    /// The verdict on all that was judged.
    pub fn verdict(&self) -> Verdict {
        let ahead = self.expected.direction();
        let along = |x_m: f64, y_m: f64| x_m * ahead.x + y_m * ahead.y;
        let edges = self.obstacles.iter().map(|circle| along(circle.x_m, circle.y_m) + circle.radius_m);
        let last_edge_m = edges.fold(f64::NEG_INFINITY, f64::max);
        let end_s = STEP_S * self.steps as f64;
        // Outside at the very end is not converged.
        let converged = |last: Option<f64>| match last {
            Some(outside_s) if outside_s + 1.5 * STEP_S >= end_s => None,
            last => Some(last.unwrap_or(0.0)),
        };
        let [speed, course, altitude] = self.outside_s;
        let seen = self.last.iter().flatten();
        Verdict {
            passed_last_obstacle: seen.filter(|state| along(state.x_m, state.y_m) > last_edge_m).count(),
            speed_convergence_s: converged(speed),
            course_convergence_s: converged(course),
            altitude_settling_s: converged(altitude),
            ..self.verdict.clone()
        }
    }

    fn step(&mut self, vehicles: &[Seen<'_>], at_s: f64) {
        let flight_s = at_s - self.start_s;
        let now: Vec<Option<(State, f64)>> =
            vehicles.iter().map(|seen| seen.track.at(at_s).filter(|_| seen.is_airborne)).collect();
        for (index, known) in now.iter().enumerate() {
            let Some((state, gap_s)) = *known else {
                if let Some(unseen_s) = self.unseen_s.get_mut(index).filter(|_| vehicles[index].is_airborne) {
                    *unseen_s += STEP_S;
                }
                continue;
            };
            self.judge_obstacles(
                index,
                &state,
                Ground::of(gap_s, vehicles[index].clock_error_s * state.speed_mps),
                flight_s,
            );
            for (other, known) in now.iter().enumerate().take(index) {
                let Some((theirs, their_gap_s)) = *known else { continue };
                // Each clock is wrong on its own: what both have in common is not known.
                let clocks_m =
                    vehicles[index].clock_error_s * state.speed_mps + vehicles[other].clock_error_s * theirs.speed_mps;
                let ground = Ground::of(gap_s.max(their_gap_s), clocks_m);
                self.judge_pair([other, index], &theirs, &state, ground, flight_s);
            }
            if vehicles[index].is_member {
                self.judge_convergence(&state, flight_s);
            }
        }
        let flown: Vec<(State, State)> =
            self.last.iter().zip(&now).filter_map(|(before, now)| Some(((*before)?, now.as_ref()?.0))).collect();
        if !flown.is_empty() {
            self.verdict.smoothness.step(flown.iter().map(|(before, after)| (before, after)));
        }
        for (last, now) in self.last.iter_mut().zip(now) {
            *last = now.map(|(state, _)| state).or(*last);
        }
    }

    fn judge_pair(&mut self, [a, b]: [usize; 2], first: &State, second: &State, ground: Ground, at_s: f64) {
        let value_m = distance_m(first, second);
        self.recent_m[0] = self.recent_m[0].min(value_m);
        if self.verdict.separation.is_none_or(|least| value_m < least.value_m) {
            self.verdict.separation = Some(Least { value_m, at_s, whose: [a, b] });
            self.grounds[0] = ground;
        }
        let level = u8::from(value_m < self.safe_distance_m) + u8::from(value_m < COLLISION_DISTANCE_M);
        let before = std::mem::replace(&mut self.close[a][b], level);
        if level >= 1 && before == 0 && value_m < self.safe_distance_m {
            self.verdict.separation_losses += 1;
        }
        if value_m < COLLISION_DISTANCE_M && before < level {
            self.verdict.vehicle_collisions += 1;
            self.fail(format!("vehicles {} and {} collided at {at_s:.2} s", a + 1, b + 1));
        }
    }

    fn judge_obstacles(&mut self, index: usize, state: &State, ground: Ground, at_s: f64) {
        for circle in 0..self.obstacles.len() {
            let value_m = self.obstacles[circle].clearance_m(state.position_m());
            self.recent_m[1] = self.recent_m[1].min(value_m);
            if self.verdict.clearance.is_none_or(|least| value_m < least.value_m) {
                self.verdict.clearance = Some(Least { value_m, at_s, whose: index });
                self.grounds[1] = ground;
            }
            let was_inside = std::mem::replace(&mut self.inside[index][circle], value_m < 0.0);
            if value_m < 0.0 && !was_inside {
                self.verdict.obstacle_collisions += 1;
                self.fail(format!("vehicle {} entered obstacle {} at {at_s:.2} s", index + 1, circle + 1));
            }
        }
    }

    fn judge_convergence(&mut self, state: &State, at_s: f64) {
        let deviates = [
            (state.speed_mps - self.expected.speed_mps).abs() > SPEED_TOLERANCE_MPS,
            wrap_pi(state.course_rad - self.expected.course_rad).abs() > COURSE_TOLERANCE_RAD,
            (state.altitude_m - self.expected.altitude_m).abs() > ALTITUDE_TOLERANCE_M,
        ];
        for (last, deviates) in self.outside_s.iter_mut().zip(deviates) {
            if deviates {
                *last = Some(at_s);
            }
        }
    }

    fn fail(&mut self, how: String) {
        self.verdict.failure.get_or_insert(how);
    }
}

impl Ground {
    fn of(sample_gap_s: f64, clock_m: f64) -> Self {
        let interpolation_m = ACCELERATION_MPS2 * sample_gap_s * sample_gap_s / 8.0;
        Self { sample_gap_s, uncertainty_m: QUANTUM_M + interpolation_m + clock_m }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vehicle::track::Sample;
    use super::*;

    const EXPECTED: Expected = Expected { speed_mps: 20.0, course_rad: 0.0, altitude_m: 50.0 };

    fn straight(y_m: f64, times: impl Iterator<Item = f64>) -> Track {
        let mut track = Track::default();
        for at_s in times {
            let state = State { x_m: 20.0 * at_s, y_m, altitude_m: 50.0, speed_mps: 20.0, ..State::default() };
            track.push(Sample { at_s, state });
        }
        track
    }

    fn judged(tracks: &[Track], obstacles: &[Obstacle], now_s: f64) -> TrackJudge {
        let mut judge = TrackJudge::new(tracks.len(), obstacles, EXPECTED, 8.0, 0.0);
        let seen: Vec<Seen<'_>> = tracks
            .iter()
            .map(|track| Seen { track, clock_error_s: 0.001, is_airborne: true, is_member: true })
            .collect();
        judge.judge(&seen, now_s, 10.0);
        judge
    }

    #[test]
    fn distances_are_those_between_samples_of_different_times() {
        let even = (0..=100).map(|k| 0.1 * f64::from(k));
        let odd = (0..=100).map(|k| 0.037 + 0.1 * f64::from(k) - 0.1);
        let tracks = [straight(0.0, even), straight(5.0, odd)];
        let circle = Obstacle { x_m: 101.0, y_m: -9.0, radius_m: 5.0 };
        let judge = judged(&tracks, &[circle], 10.0);
        let verdict = judge.verdict();
        assert!((verdict.separation.unwrap().value_m - 5.0).abs() < 1e-6);
        assert!((verdict.clearance.unwrap().value_m - 4.0).abs() < 1e-2);
        assert_eq!((verdict.separation_losses, verdict.vehicle_collisions, verdict.obstacle_collisions), (1, 0, 0));
        assert!(judge.grounds()[0].uncertainty_m < 0.1);
        assert_eq!((verdict.passed_last_obstacle, verdict.speed_convergence_s), (2, Some(0.0)));
    }

    #[test]
    fn a_clock_that_may_be_wrong_makes_distances_uncertain_though_both_fly_alike() {
        let tracks = [0.0, 30.0].map(|y_m| straight(y_m, (0..=100).map(|k| 0.1 * f64::from(k))));
        let mut judge = TrackJudge::new(2, &[], EXPECTED, 8.0, 0.0);
        let seen = |track, clock_error_s| Seen { track, clock_error_s, is_airborne: true, is_member: true };
        judge.judge(&[seen(&tracks[0], 0.0), seen(&tracks[1], 2.0)], 20.0, 10.0);
        assert!(judge.grounds()[0].uncertainty_m >= 40.0, "{:?}", judge.grounds());
    }

    #[test]
    fn what_was_not_heard_is_unseen_and_not_judged() {
        let all = (0..=100).map(|k| 0.1 * f64::from(k));
        let with_hole = (0..=100).map(|k| 0.1 * f64::from(k)).filter(|at_s| !(3.0..6.0).contains(at_s));
        // The way through the hole would lead into the circle: nobody saw it.
        let tracks = [straight(0.0, with_hole), straight(30.0, all)];
        let circle = Obstacle { x_m: 90.0, y_m: 0.0, radius_m: 10.0 };
        let judge = judged(&tracks, &[circle], 20.0);
        assert_eq!(judge.verdict().obstacle_collisions, 0);
        assert!((judge.unseen_s()[0] - 3.1).abs() < 0.15, "{:?}", judge.unseen_s());
        assert_eq!(judge.unseen_s()[1], 0.0);
    }

    #[test]
    fn an_entered_circle_is_told_once() {
        let track = straight(0.0, (0..=100).map(|k| 0.1 * f64::from(k)));
        let circle = Obstacle { x_m: 90.0, y_m: 0.0, radius_m: 10.0 };
        let verdict = judged(&[track], &[circle], 20.0).verdict();
        assert_eq!(verdict.obstacle_collisions, 1);
        assert!(verdict.failure.unwrap().starts_with("vehicle 1 entered obstacle 1 at 4.0"));
    }
}
