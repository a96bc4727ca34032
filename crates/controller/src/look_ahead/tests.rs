//! The batch of pigeons against one vehicle at a time: the law as `terms/mod.rs` has it, flown by the
//! vehicle model, with costs summed up as one reads Eq. 11 and 12.

use super::*;
use crate::closest_approach::closest_approach_m;
use crate::law::{Flown, command};
use crate::terms::Neighbour;
use crate::{AltitudeLaw, SideRule, terms};
use flight_model::{Autopilot, course_vector, wrap_pi};
use nalgebra::Vector2;
use proptest::prelude::*;

const PERIOD_S: f64 = 0.5;
const EXPECTED: Expected = Expected { speed_mps: 10.0, course_rad: 0.2, altitude_m: 50.0 };

#[derive(Debug)]
struct Plain {
    cost_1: f64,
    cost_2: f64,
    violation_m: f64,
}

/// (w^2 - d^2) / 2w where positive: the shortfall w - d to first order.
fn shortfall(distance_m: f64, wanted_m: f64) -> f64 {
    ((wanted_m * wanted_m - distance_m * distance_m) / (2.0 * wanted_m)).max(0.0)
}

/// The paper's vehicle, or one that turns as hard as it can at small course errors.
fn vehicle(turns_slowly: bool) -> Dynamics {
    let mut dynamics = Dynamics::default();
    if turns_slowly {
        (dynamics.limits.lateral_overload_max, dynamics.response.turn_share) = (0.8, 0.75);
    }
    dynamics
}

fn plain(
    law: &LawSettings,
    settings: &LookAheadSettings,
    dynamics: &Dynamics,
    scene: &Scene<'_>,
    weights: [f64; 3],
) -> Plain {
    let (commander, autopilot) = (Commander::new(law, dynamics, PERIOD_S), Autopilot::new(dynamics, PERIOD_S));
    let half = Autopilot::new(dynamics, 0.5 * PERIOD_S);
    let steps = settings.steps(PERIOD_S);
    let asked_rad = |heading_rad: f64, state: &State| wrap_pi(heading_rad - state.in_air(&scene.wind).course_rad);
    let passage = |neighbour: usize, instant: usize| scene.neighbours[neighbour * (1 + 2 * steps) + instant];
    let count = scene.neighbours.len() / (1 + 2 * steps);
    let ahead = scene.expected.direction();
    let mut state = scene.state;
    let mut last_heading_rad =
        scene.standing.map(|standing| wrap_pi(state.in_air(&scene.wind).course_rad + standing.turn_rad));
    let mut last_speed_mps = scene.standing.map_or(0.0, |standing| standing.speed_mps);
    let mut sum = Plain { cost_1: 0.0, cost_2: 0.0, violation_m: 0.0 };
    for step in 0..steps {
        let near: Vec<Neighbour> = (0..count)
            .map(|neighbour| {
                let there = passage(neighbour, 2 * step);
                Neighbour { position_m: there.position_m(), velocity_mps: Vector2::new(there.vx_mps, there.vy_mps) }
            })
            .collect();
        let wind = &scene.wind;
        let flown = Flown { commander: &commander, state: &state, wind, last_heading_rad };
        let setpoint = command(law, &scene.expected, &flown, &near, scene.obstacles, weights).in_air(wind);
        if let Some(last_rad) = last_heading_rad {
            let [last_rad, now_rad] = [last_rad, setpoint.course_rad].map(|heading_rad| asked_rad(heading_rad, &state));
            let (speed_mps, air) = (setpoint.speed_mps, state.in_air(wind));
            let turning_mps = air.speed_mps.max(dynamics.limits.speed_min_mps);
            let change_mps = turning_mps * (now_rad - last_rad).abs() + (speed_mps - last_speed_mps).abs();
            sum.cost_1 += law.command_cost_s * change_mps;
        }
        (last_speed_mps, last_heading_rad) = (setpoint.speed_mps, Some(setpoint.course_rad));
        // The batch samples the middle by the trapezium of velocities.
        let [middle, end] = [half, autopilot].map(|autopilot| autopilot.step_in_wind(&state, &setpoint, wind));
        let from_m = state.position_m();
        let middle_m = from_m + (state.velocity_mps() + middle.velocity_mps()) * PERIOD_S / 4.0;
        state = end;

        let velocity_mps = state.velocity_mps();
        let own = [from_m, middle_m, state.position_m()];
        let mut keep_off = |places: [Vector2<f64>; 3], wanted_m: f64| {
            for half in 0..2 {
                let nearest_m = closest_approach_m(places[half] - own[half], places[half + 1] - own[half + 1]);
                sum.violation_m += shortfall(nearest_m, wanted_m);
            }
        };
        for neighbour in 0..count {
            let places = [0, 1, 2].map(|half| passage(neighbour, 2 * step + half).position_m());
            keep_off(places, settings.separation_m);
        }
        for obstacle in scene.close_obstacles {
            keep_off([obstacle.centre_m(); 3], obstacle.radius_m + settings.clearance_m);
        }
        for neighbour in 0..count {
            let there = passage(neighbour, 2 * step + 2);
            let distance_m = (there.position_m() - state.position_m()).norm();
            if distance_m <= law.communication_distance_m {
                let gap = law.desired_distance_m - distance_m;
                let gap = if law.communication_distance_m > law.desired_distance_m { gap.abs() } else { gap };
                sum.cost_2 += law.influence_factor
                    * (gap + (velocity_mps.x - there.vx_mps).abs() + (velocity_mps.y - there.vy_mps).abs());
            }
        }
        let speed_mps = scene.expected.speed_mps;
        let deviation_mps = (ahead * speed_mps - velocity_mps).abs().sum();
        sum.cost_1 += if scene.detected {
            law.velocity_cost_s * deviation_mps - state.position_m().dot(&ahead)
        } else {
            deviation_mps
        };
    }
    sum.cost_1 /= steps as f64;
    sum.cost_2 /= steps as f64;
    sum
}

fn state() -> impl Strategy<Value = State> {
    (-5.0..5.0f64, -5.0..5.0f64, 5.0..15.0f64, -3.1..3.1f64).prop_map(|(x_m, y_m, speed_mps, course_rad)| State {
        x_m,
        y_m,
        altitude_m: 50.0,
        speed_mps,
        course_rad,
        climb_mps: 0.0,
    })
}

fn law() -> impl Strategy<Value = LawSettings> {
    let numbers = (0.0..4.0f64, 8.0..20.0f64, 0.0..2.0f64);
    let side_rule = prop::sample::select(vec![SideRule::Auto, SideRule::Course, SideRule::Command]);
    (any::<bool>(), side_rule, 0.0..0.2f64, numbers).prop_map(|(nearest, side_rule, command_cost_s, numbers)| {
        let (obstacle_margin_m, communication_distance_m, velocity_cost_s) = numbers;
        LawSettings {
            side_rule,
            command_cost_s,
            obstacle_rule: if nearest { ObstacleRule::Nearest } else { ObstacleRule::Blocking },
            obstacle_margin_m,
            communication_distance_m,
            velocity_cost_s,
            altitude_law: AltitudeLaw::Hold,
            ..LawSettings::default()
        }
    })
}

fn obstacles() -> impl Strategy<Value = Vec<Obstacle>> {
    let circle = (-40.0..60.0f64, -40.0..40.0f64, 2.0..12.0f64);
    prop::collection::vec(circle.prop_map(|(x_m, y_m, radius_m)| Obstacle { x_m, y_m, radius_m }), 0..6)
}

fn weights() -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(prop::array::uniform3(0.0..3.0f64), 1..70)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_batch_flies_as_each_of_its_vehicles_would(
        air in state(),
        (north_mps, east_mps) in prop_oneof![Just((0.0, 0.0)), (-6.0..6.0f64, -6.0..6.0f64)],
        others in prop::collection::vec(state(), 0..7),
        law in law(),
        obstacles in obstacles(),
        weights in weights(),
        horizon_s in prop::sample::select(vec![0.5, 1.5, 3.0]),
        turns_slowly in any::<bool>(),
        standing in prop::option::of((5.0..15.0f64, -0.5..0.5f64)),
    ) {
        let dynamics = vehicle(turns_slowly);
        let settings = LookAheadSettings { horizon_s, ..LookAheadSettings::default() };
        let look_ahead = LookAhead::new(&law, &settings, &dynamics, PERIOD_S);
        let mut forecast = crate::forecast::Forecast::default();
        forecast.extrapolate(&others, settings.steps(PERIOD_S), PERIOD_S);
        let neighbours: Vec<Passage> = (0..others.len()).flat_map(|i| forecast.vehicle(i).to_vec()).collect();
        let wind = Wind { north_mps, east_mps, up_mps: 0.0 };
        let state = air.over_ground(&wind);
        let heading = course_vector(state.in_air(&wind).course_rad);
        let detected = obstacles.iter().any(|o| terms::detects(&law, state.position_m(), heading, o));
        let scene = Scene {
            state,
            wind,
            standing: standing.map(|(speed_mps, turn_rad)| Standing { speed_mps, turn_rad }),
            expected: EXPECTED,
            obstacles: &obstacles,
            close_obstacles: &obstacles,
            detected,
            neighbours: &neighbours,
            margin_m: 0.0,
            neighbour_margins_m: &[],
        };
        let columns: Vec<f64> = (0..3).flat_map(|term| weights.iter().map(move |row| row[term])).collect();
        let (mut costs, mut violations) = (vec![0.0; 2 * weights.len()], vec![0.0; weights.len()]);
        let bounds = [Bounds::new(0.0, 3.0), Bounds::new(0.0, 3.0), Bounds::new(0.0, 3.0)];
        let mut rollout = Box::new(Rollout::new());
        let mut problem = WeightProblem {
            look_ahead: &look_ahead,
            scene: scene.clone(),
            kind: WeightKind::PerTerm,
            bounds: &bounds,
            rollout: &mut rollout,
        };
        problem.evaluate(
            &Candidates::new(&columns, weights.len()),
            &mut Evaluations::new(&mut costs, &mut violations),
        );
        for (pigeon, weights) in weights.iter().enumerate() {
            let wanted = plain(&law, &settings, &dynamics, &scene, *weights);
            let got = Plain {
                cost_1: costs[pigeon], cost_2: costs[pigeon + violations.len()], violation_m: violations[pigeon],
            };
            // Inside D_s the collision term multiplies rounding by 1e5.
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * (1.0 + b.abs());
            let costs_agree = near(got.cost_1, wanted.cost_1) && near(got.cost_2, wanted.cost_2);
            prop_assert!(
                costs_agree && near(got.violation_m, wanted.violation_m),
                "pigeon {pigeon} {weights:?}: {got:?} instead of {wanted:?}"
            );
        }
    }
}
