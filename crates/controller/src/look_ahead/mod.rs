//! Eq. 11 and Eq. 12: the predicted flight of one vehicle for every choice of weights of a generation (reading 11), and
//! what it costs.
//!
//! From the present state the flocking law is applied again at every control period, the vehicle flying the exact
//! discretisation of Eq. 1, while the neighbours follow their forecast. On the way the flight collects the costs of
//! Eq. 11 and 12, averaged over the horizon, and the metres by which it falls short of the two constraints at the
//! closest approach within every half control period. With a horizon of one control period this is the letter of the
//! paper.

use crate::command::{Commander, Standing};
use crate::forecast::Passage;
use crate::rollout::{BATCH, Each, Extent, Places, Rollout, Step};
use crate::{Expected, LawSettings, LookAheadSettings, Obstacle, ObstacleRule, WeightKind};
use flight_model::{Dynamics, State, Wind};
use multiversion::multiversion;
use optimizer::{Bounds, Candidates, Evaluations, Problem};

/// The law and the vehicle, discretised at the control period.
#[derive(Clone, Debug)]
pub struct LookAhead {
    law: LawSettings,
    commander: Commander,
    separation_m: f64,
    clearance_m: f64,
    steps: usize,
    step: Step,
    /// Where the course loop is slower the faster the vehicle flies.
    growing: Option<Dynamics>,
}

/// A command for each pigeon of a batch.
#[derive(Clone, Debug)]
pub struct Commands {
    pub speed_setpoint_mps: Each,
    pub course_change_rad: Each,
}

/// What one vehicle sees of the world: all of a solve that does not depend on the weights.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The vehicle now.
    pub state: State,
    /// The wind around it.
    pub wind: Wind,
    /// What its last command still asks for; none before the first command.
    pub standing: Option<Standing>,
    /// What the flock is to do.
    pub expected: Expected,
    /// The obstacles that can steer within the horizon.
    pub obstacles: &'a [Obstacle],
    /// The obstacles that can be reached within the horizon.
    pub close_obstacles: &'a [Obstacle],
    /// Whether any obstacle is detected now: which case of Eq. 11 holds.
    pub detected: bool,
    /// The neighbours' forecast, neighbour-major: `1 + 2 * steps` passages each, half a control period apart.
    pub neighbours: &'a [Passage],
    /// What is not known of where the vehicle is, m, and of where each of these neighbours is: added to the distances
    /// that the constraints want. Empty where everything is known.
    pub margin_m: f64,
    pub neighbour_margins_m: &'a [f64],
}

/// The choice of weights as an optimisation problem: the objectives are Eq. 11 and 12, the violation that of the two
/// constraints.
pub struct WeightProblem<'a> {
    pub look_ahead: &'a LookAhead,
    pub scene: Scene<'a>,
    pub kind: WeightKind,
    pub bounds: &'a [Bounds],
    pub rollout: &'a mut Rollout,
}

impl LookAhead {
    pub fn new(law: &LawSettings, look_ahead: &LookAheadSettings, dynamics: &Dynamics, period_s: f64) -> Self {
        let tau = dynamics.time_constants;
        Self {
            law: law.clone(),
            commander: Commander::new(law, dynamics, period_s),
            separation_m: look_ahead.separation_m,
            clearance_m: look_ahead.clearance_m,
            steps: look_ahead.steps(period_s),
            step: Step {
                period_s,
                speed_decay: decays(period_s, tau.speed_s),
                course_gain: decays(period_s, tau.course_s).map(|decay| 1.0 - decay),
                acceleration_max_mps2: dynamics.response.acceleration_max_mps2,
                wind_mps: Wind::CALM.horizontal_mps(),
            },
            growing: dynamics.response.course_reference_speed_mps.map(|_| *dynamics),
        }
    }

    /// One control period of the vehicle model from an airspeed: over a look-ahead that changes little.
    fn step_from(&self, airspeed_mps: f64, wind: &Wind) -> Step {
        let mut step = Step { wind_mps: wind.horizontal_mps(), ..self.step };
        if let Some(dynamics) = &self.growing {
            let tau_s = dynamics.course_time_constant_s(airspeed_mps);
            step.course_gain = decays(step.period_s, tau_s).map(|decay| 1.0 - decay);
        }
        step
    }

    /// Flies `pigeons` commands through the scene, the law with the same weights for all after the first period, and
    /// returns by how many metres each falls short of the constraints.
    pub fn try_commands<'f>(
        &self,
        scene: &Scene<'_>,
        commands: &Commands,
        weights: [f64; 3],
        pigeons: usize,
        rollout: &'f mut Rollout,
    ) -> &'f [f64] {
        fly(self, scene, Some(commands), &weights.map(|weight| [weight; BATCH]), pigeons, rollout, None);
        &rollout.violation_m[..pigeons.min(BATCH)]
    }

    /// Where each of these choices of weights leads: north and east in m at the present and after every control period.
    pub fn paths_m(&self, scene: &Scene<'_>, weights: &[[f64; 3]], rollout: &mut Rollout) -> Vec<Vec<[f64; 2]>> {
        let mut paths_m = Vec::with_capacity(weights.len());
        for batch in weights.chunks(BATCH) {
            let mut columns = [[0.0; BATCH]; 3];
            for (pigeon, weights) in batch.iter().enumerate() {
                for (column, weight) in columns.iter_mut().zip(weights) {
                    column[pigeon] = *weight;
                }
            }
            let mut places = Vec::with_capacity(1 + self.steps);
            fly(self, scene, None, &columns, batch.len(), rollout, Some(&mut places));
            let path = |pigeon: usize| places.iter().map(|(x_m, y_m)| [x_m[pigeon], y_m[pigeon]]).collect();
            paths_m.extend((0..batch.len()).map(path));
        }
        paths_m
    }

    /// Flies `pigeons` choices of weights (alpha_f, alpha_o, alpha_nv) through the scene; `places` takes where they are
    /// at every control period.
    #[inline(always)]
    fn fly(
        &self,
        scene: &Scene<'_>,
        first: Option<&Commands>,
        weights: &[Each; 3],
        pigeons: usize,
        rollout: &mut Rollout,
        mut places: Option<&mut Vec<Places>>,
    ) {
        let law = &self.law;
        let expected = &scene.expected;
        let ahead = expected.direction();
        rollout.start(&scene.state, &scene.wind, scene.standing, pigeons);
        let vehicle = self.step_from(scene.state.in_air(&scene.wind).speed_mps, &scene.wind);
        let mut here = rollout.extent();
        for k in 0..=self.steps {
            rollout.clear_terms();
            let before = here;
            here = rollout.extent();
            if let Some(places) = places.as_deref_mut() {
                places.push(rollout.places());
            }
            self.meet_neighbours(scene, k, &here, rollout);
            if k > 0 {
                self.keep_clear(scene, k, &before, &here, rollout);
            }
            if k == self.steps {
                break;
            }
            for obstacle in scene.obstacles {
                let inflated_m = obstacle.radius_m + law.obstacle_margin_m;
                if law.obstacle_rule == ObstacleRule::Nearest
                    || here.may_be_blocked(obstacle.x_m, obstacle.y_m, inflated_m, ahead)
                {
                    rollout.offer_obstacle(law, expected, obstacle);
                }
            }
            match first {
                Some(first) if k == 0 => rollout.follow(&first.speed_setpoint_mps, &first.course_change_rad),
                _ => {
                    let is_first = k == 0 && scene.standing.is_none();
                    rollout.follow_law(&self.commander, law, expected, weights, is_first);
                }
            }
            rollout.advance(&vehicle);
            rollout.add_progress(law, expected, scene.detected);
        }
    }

    /// The neighbours' terms at the `k`-th control period.
    #[inline(always)]
    fn meet_neighbours(&self, scene: &Scene<'_>, k: usize, here: &Extent, rollout: &mut Rollout) {
        let range_m = self.law.communication_distance_m.max(self.law.safe_distance_m);
        for passages in scene.neighbours.chunks_exact(1 + 2 * self.steps) {
            let there = &passages[2 * k];
            if here.is_within(there.x_m, there.y_m, range_m) {
                rollout.add_neighbour(&self.law, there, k > 0);
            }
        }
    }

    /// Both constraints over the `k`-th control period, which began in `before` and ended in `here`.
    #[inline(always)]
    fn keep_clear(&self, scene: &Scene<'_>, k: usize, before: &Extent, here: &Extent, rollout: &mut Rollout) {
        let half_way = rollout.extent_half_way();
        let (first, second) = (before.and(&half_way), half_way.and(here));
        for (index, passages) in scene.neighbours.chunks_exact(1 + 2 * self.steps).enumerate() {
            let theirs_m = scene.neighbour_margins_m.get(index).copied().unwrap_or(0.0);
            let wanted_m = self.separation_m + (scene.margin_m + theirs_m);
            let [start, middle, end] = [2 * k - 2, 2 * k - 1, 2 * k].map(|i| passages[i].position_m());
            if first.may_be_met(start, middle, wanted_m) {
                rollout.keep_off_first_half(start, middle, wanted_m);
            }
            if second.may_be_met(middle, end, wanted_m) {
                rollout.keep_off_second_half(middle, end, wanted_m);
            }
        }
        for obstacle in scene.close_obstacles {
            let (place, wanted_m) = (obstacle.centre_m(), obstacle.radius_m + (self.clearance_m + scene.margin_m));
            if first.may_be_met(place, place, wanted_m) {
                rollout.keep_off_first_half(place, place, wanted_m);
            }
            if second.may_be_met(place, place, wanted_m) {
                rollout.keep_off_second_half(place, place, wanted_m);
            }
        }
    }
}

/// What is left of an error after half a period and a whole one.
fn decays(period_s: f64, tau_s: f64) -> [f64; 2] {
    [0.5, 1.0].map(|part| libm::exp(-part * period_s / tau_s))
}

impl Problem for WeightProblem<'_> {
    fn bounds(&self) -> &[Bounds] {
        self.bounds
    }

    fn objectives(&self) -> usize {
        2
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        let mean = 1.0 / self.look_ahead.steps as f64;
        let mut start = 0;
        while start < candidates.len() {
            let end = (start + BATCH).min(candidates.len());
            let count = end - start;
            let mut weights = [[0.0; BATCH]; 3];
            for (term, weight) in weights.iter_mut().enumerate() {
                let dimension = if self.kind == WeightKind::Shared { 0 } else { term };
                weight[..count].copy_from_slice(&candidates.coordinate(dimension)[start..end]);
            }
            fly(self.look_ahead, &self.scene, None, &weights, count, self.rollout, None);
            let ([cost_1, cost_2], violation) = evaluations.objectives_and_violation();
            for i in 0..count {
                cost_1[start + i] = self.rollout.cost_1[i] * mean;
                cost_2[start + i] = self.rollout.cost_2[i] * mean;
                violation[start + i] = self.rollout.violation_m[i];
            }
            start = end;
        }
    }
}

/// The look-ahead compiled for what vector instructions the machine has: the same operations, so the same bits.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn fly(
    look_ahead: &LookAhead,
    scene: &Scene<'_>,
    first: Option<&Commands>,
    weights: &[Each; 3],
    pigeons: usize,
    rollout: &mut Rollout,
    places: Option<&mut Vec<Places>>,
) {
    look_ahead.fly(scene, first, weights, pigeons, rollout, places);
}

#[cfg(test)]
mod tests;
