//! Who came too near to whom: judged at every integration step, in the horizontal plane, as the paper's distances are.

use crate::smoothness::Smoothness;
use controller::{Expected, Obstacle};
use flight_model::{State, wrap_pi};

/// Two vehicles nearer than this have collided, m.
pub const COLLISION_DISTANCE_M: f64 = 1.0;
/// Within this of the expected speed a vehicle has converged, m/s (reading 16).
pub const SPEED_TOLERANCE_MPS: f64 = 0.2;
/// Within this of the expected course a vehicle has converged, rad (reading 16).
pub const COURSE_TOLERANCE_RAD: f64 = 0.02;
/// Within this of the expected altitude a vehicle has settled, m.
pub const ALTITUDE_TOLERANCE_M: f64 = 0.5;

/// The least distances of an interval, m; infinite where there is nothing to be near to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minima {
    /// Between any two vehicles.
    pub separation_m: f64,
    /// From any vehicle to any circle's edge; negative inside.
    pub clearance_m: f64,
}

/// A least value, when it was, and whose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Least<W> {
    /// The value, m.
    pub value_m: f64,
    /// When, s.
    pub at_s: f64,
    /// Index or indices of the vehicles.
    pub whose: W,
}

/// What a flight came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// How often a vehicle entered a circle.
    pub obstacle_collisions: u32,
    /// How often two vehicles came within [`COLLISION_DISTANCE_M`].
    pub vehicle_collisions: u32,
    /// How often two vehicles came within the safe distance D_s.
    pub separation_losses: u32,
    /// The least distance between two vehicles; none with a single one.
    pub separation: Option<Least<[usize; 2]>>,
    /// The least distance to a circle's edge; none without circles.
    pub clearance: Option<Least<usize>>,
    /// Vehicles past the far edge of every circle, along the expected course.
    pub passed_last_obstacle: usize,
    /// From when on every vehicle stayed within the tolerance of speed, s; `None` if one did not at the end.
    pub speed_convergence_s: Option<f64>,
    /// The same of course.
    pub course_convergence_s: Option<f64>,
    /// The same of altitude.
    pub altitude_settling_s: Option<f64>,
    /// How calmly and how closely the flock flew.
    pub smoothness: Smoothness,
    /// The first collision, in words.
    pub failure: Option<String>,
}

/// Judges a flight interval by interval.
pub struct Judge {
    obstacles: Vec<Obstacle>,
    expected: Expected,
    safe_distance_m: f64,
    speed_max_mps: f64,
    last: Vec<State>,
    /// Vehicle-major: whether a vehicle is in a circle.
    inside: Vec<bool>,
    /// Pairs nearer than D_s, with whether they are nearer than the collision distance.
    close: Vec<([usize; 2], bool)>,
    candidates: Vec<[usize; 2]>,
    order: Vec<usize>,
    /// When each was last outside its tolerance: speed, course, altitude.
    outside_s: [Option<f64>; 3],
    verdict: Verdict,
}

impl Judge {
    /// `starts` are judged at time zero.
    pub fn new(
        starts: &[State],
        obstacles: &[Obstacle],
        expected: Expected,
        safe_distance_m: f64,
        speed_max_mps: f64,
    ) -> Self {
        let mut judge = Self {
            obstacles: obstacles.to_vec(),
            expected,
            safe_distance_m,
            speed_max_mps,
            last: starts.to_vec(),
            inside: vec![false; starts.len() * obstacles.len()],
            close: Vec::new(),
            candidates: Vec::new(),
            order: Vec::new(),
            outside_s: [None; 3],
            verdict: Verdict::default(),
        };
        let tracks: Vec<Vec<State>> = starts.iter().map(|start| vec![*start]).collect();
        judge.interval(0.0, 0.0, &tracks);
        // The start is where the flight begins and no step of it.
        judge.verdict.smoothness = Smoothness::default();
        judge
    }

    /// Judges the states after each integration step of an interval that starts at `start_s`; all tracks are equally
    /// long.
    pub fn interval(&mut self, start_s: f64, step_s: f64, tracks: &[Vec<State>]) -> Minima {
        let steps = tracks.iter().map(Vec::len).min().unwrap_or(0);
        self.find_candidates(steps as f64 * step_s);
        let mut minima = Minima { separation_m: f64::INFINITY, clearance_m: f64::INFINITY };
        for step in 0..steps {
            let at_s = start_s + step_s * (step + 1) as f64;
            self.judge_pairs(tracks, step, at_s, &mut minima);
            self.judge_obstacles(tracks, step, at_s, &mut minima);
            self.judge_convergence(tracks, step, at_s);
            let before = |vehicle: usize| if step > 0 { &tracks[vehicle][step - 1] } else { &self.last[vehicle] };
            let states = tracks.iter().enumerate().map(|(vehicle, track)| (before(vehicle), &track[step]));
            self.verdict.smoothness.step(states);
        }
        if steps > 0 {
            self.last = tracks.iter().map(|track| track[steps - 1]).collect();
        }
        minima
    }

    /// The verdict on all that was judged so far.
    pub fn verdict(&self) -> Verdict {
        let ahead = self.expected.direction();
        let last_edge_m = self
            .obstacles
            .iter()
            .map(|circle| circle.centre_m().dot(&ahead) + circle.radius_m)
            .fold(f64::NEG_INFINITY, f64::max);
        let [speed, course, altitude] = self.outside_s;
        // Outside at the very end is not converged; never outside is converged from the start.
        let converged = |kind: usize, last: Option<f64>| {
            if self.last.iter().any(|state| self.deviates(state)[kind]) { None } else { Some(last.unwrap_or(0.0)) }
        };
        Verdict {
            passed_last_obstacle: self.last.iter().filter(|state| state.position_m().dot(&ahead) > last_edge_m).count(),
            speed_convergence_s: converged(0, speed),
            course_convergence_s: converged(1, course),
            altitude_settling_s: converged(2, altitude),
            ..self.verdict.clone()
        }
    }

    /// Pairs that can come nearest, or within D_s, before the interval is over.
    fn find_candidates(&mut self, interval_s: f64) {
        self.candidates.clear();
        self.order.clear();
        self.order.extend(0..self.last.len());
        self.order.sort_by(|&a, &b| self.last[a].x_m.total_cmp(&self.last[b].x_m));
        let approach_m = 2.0 * self.speed_max_mps * interval_s;
        // The nearest pair in order of northing is an upper bound of the nearest pair, and good enough.
        let nearest_m = self
            .order
            .windows(2)
            .map(|pair| distance_m(&self.last[pair[0]], &self.last[pair[1]]))
            .fold(f64::INFINITY, f64::min);
        let range_m = nearest_m.max(self.safe_distance_m).max(COLLISION_DISTANCE_M) + 2.0 * approach_m + 1.0;
        for (rank, &a) in self.order.iter().enumerate() {
            for &b in &self.order[rank + 1..] {
                if self.last[b].x_m - self.last[a].x_m > range_m {
                    break;
                }
                if distance_m(&self.last[a], &self.last[b]) <= range_m {
                    self.candidates.push([a.min(b), a.max(b)]);
                }
            }
        }
        self.candidates.sort_unstable();
    }

    fn judge_pairs(&mut self, tracks: &[Vec<State>], step: usize, at_s: f64, minima: &mut Minima) {
        for &[a, b] in &self.candidates {
            let separation_m = distance_m(&tracks[a][step], &tracks[b][step]);
            minima.separation_m = minima.separation_m.min(separation_m);
            if self.verdict.separation.is_none_or(|least| separation_m < least.value_m) {
                self.verdict.separation = Some(Least { value_m: separation_m, at_s, whose: [a, b] });
            }
            let known = self.close.iter().position(|(pair, _)| *pair == [a, b]);
            if separation_m >= self.safe_distance_m.max(COLLISION_DISTANCE_M) {
                if let Some(index) = known {
                    self.close.swap_remove(index);
                }
                continue;
            }
            let index = known.unwrap_or_else(|| {
                self.close.push(([a, b], false));
                self.close.len() - 1
            });
            if known.is_none() && separation_m < self.safe_distance_m {
                self.verdict.separation_losses += 1;
            }
            let collides = separation_m < COLLISION_DISTANCE_M;
            if collides && !self.close[index].1 {
                self.verdict.vehicle_collisions += 1;
                let text =
                    format!("vehicles {} and {} collided at {at_s:.2} s ({separation_m:.2} m apart)", a + 1, b + 1);
                self.verdict.failure.get_or_insert(text);
            }
            self.close[index].1 = collides;
        }
    }

    fn judge_obstacles(&mut self, tracks: &[Vec<State>], step: usize, at_s: f64, minima: &mut Minima) {
        for (vehicle, track) in tracks.iter().enumerate() {
            for (number, obstacle) in self.obstacles.iter().enumerate() {
                let clearance_m = obstacle.clearance_m(track[step].position_m());
                minima.clearance_m = minima.clearance_m.min(clearance_m);
                if self.verdict.clearance.is_none_or(|least| clearance_m < least.value_m) {
                    self.verdict.clearance = Some(Least { value_m: clearance_m, at_s, whose: vehicle });
                }
                let inside = &mut self.inside[vehicle * self.obstacles.len() + number];
                if clearance_m < 0.0 && !*inside {
                    self.verdict.obstacle_collisions += 1;
                    let text = format!("vehicle {} entered obstacle {} at {at_s:.2} s", vehicle + 1, number + 1);
                    self.verdict.failure.get_or_insert(text);
                }
                *inside = clearance_m < 0.0;
            }
        }
    }

    fn judge_convergence(&mut self, tracks: &[Vec<State>], step: usize, at_s: f64) {
        for track in tracks {
            for (kind, deviates) in self.deviates(&track[step]).into_iter().enumerate() {
                if deviates {
                    self.outside_s[kind] = Some(at_s);
                }
            }
        }
    }

    /// Whether speed, course and altitude are outside their tolerances.
    fn deviates(&self, state: &State) -> [bool; 3] {
        [
            (state.speed_mps - self.expected.speed_mps).abs() > SPEED_TOLERANCE_MPS,
            wrap_pi(state.course_rad - self.expected.course_rad).abs() > COURSE_TOLERANCE_RAD,
            (state.altitude_m - self.expected.altitude_m).abs() > ALTITUDE_TOLERANCE_M,
        ]
    }
}

fn distance_m(a: &State, b: &State) -> f64 {
    (a.position_m() - b.position_m()).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPECTED: Expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };

    fn at(x_m: f64, y_m: f64) -> State {
        State { x_m, y_m, altitude_m: 50.0, speed_mps: 10.0, ..State::default() }
    }

    fn judge(starts: &[State], obstacles: &[Obstacle]) -> Judge {
        Judge::new(starts, obstacles, EXPECTED, 2.0, 15.0)
    }

    #[test]
    fn a_pair_that_meets_between_ticks_is_seen_once_each_time() {
        let mut judge = judge(&[at(0.0, 0.0), at(0.0, 10.0)], &[]);
        let there = |y: f64| vec![at(0.0, 0.0), at(0.0, 0.0), at(0.0, 0.0), at(0.0, 0.0), at(0.0, y)];
        let tracks = [there(0.0), vec![at(0.0, 3.0), at(0.0, 1.5), at(0.0, 0.5), at(0.0, 1.5), at(0.0, 5.0)]];
        let minima = judge.interval(0.0, 0.1, &tracks);
        assert_eq!(minima.separation_m, 0.5);
        let verdict = judge.verdict();
        assert_eq!((verdict.separation_losses, verdict.vehicle_collisions), (1, 1));
        let least = verdict.separation.expect("two vehicles");
        assert!((least.at_s - 0.3).abs() < 1e-9 && least.whose == [0, 1]);
        assert!(verdict.failure.is_some_and(|text| text.contains("vehicles 1 and 2")));
        judge.interval(0.5, 0.1, &[vec![at(0.0, 0.0)], vec![at(0.0, 1.9)]]);
        assert_eq!(judge.verdict().separation_losses, 2);
        assert_eq!(judge.verdict().vehicle_collisions, 1);
    }

    #[test]
    fn a_circle_is_entered_once_until_it_is_left() {
        let circle = Obstacle { x_m: 10.0, y_m: 0.0, radius_m: 2.0 };
        let mut judge = judge(&[at(0.0, 0.0)], &[circle]);
        let minima = judge.interval(0.0, 0.5, &[vec![at(7.0, 0.0), at(9.0, 0.0), at(10.0, 0.0), at(13.0, 0.0)]]);
        assert_eq!(minima.clearance_m, -2.0);
        let verdict = judge.verdict();
        assert_eq!((verdict.obstacle_collisions, verdict.passed_last_obstacle), (1, 1));
    }

    #[test]
    fn convergence_is_the_last_time_outside_the_tolerance() {
        let mut judge = judge(&[at(0.0, 0.0)], &[]);
        let fast = State { speed_mps: 10.3, ..at(0.0, 0.0) };
        judge.interval(0.0, 1.0, &[vec![at(0.0, 0.0), fast, at(0.0, 0.0)]]);
        assert_eq!(judge.verdict().speed_convergence_s, Some(2.0));
        assert_eq!(judge.verdict().course_convergence_s, Some(0.0));
        judge.interval(3.0, 1.0, &[vec![fast]]);
        assert_eq!(judge.verdict().speed_convergence_s, None);
    }

    #[test]
    fn one_vehicle_without_obstacles_is_near_to_nothing() {
        let mut judge = judge(&[at(0.0, 0.0)], &[]);
        let minima = judge.interval(0.0, 1.0, &[vec![at(10.0, 0.0)]]);
        assert_eq!((minima.separation_m, minima.clearance_m), (f64::INFINITY, f64::INFINITY));
        assert_eq!(judge.verdict().separation, None);
    }
}
