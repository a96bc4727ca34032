//! Flights to test the report with: simulated by the flight model, steered by nothing better than a weave.

use crate::flight::{Field, Flight, Obstacle, Row, Setting, Summary, Tick, Trajectory};
use flight_model::{Autopilot, Dynamics, Setpoint, State};

const STEP_S: f64 = 0.05;
const STEPS_PER_TICK: usize = 10;

/// `vehicles` UAVs that weave northwards for `ticks` control periods of 0.5 s past the first `obstacles` of seven
/// circles.
pub fn flight(vehicles: usize, obstacles: usize, ticks: usize) -> Flight {
    let circles =
        [(60., 36., 9.), (95., -40., 8.), (130., 24., 6.), (175., 38., 9.), (210., -35., 11.), (260., 26., 7.)];
    let circles = circles.into_iter().chain([(320., -44., 10.)]).take(obstacles);
    let obstacles: Vec<Obstacle> = circles.map(|(x_m, y_m, radius_m)| Obstacle { x_m, y_m, radius_m }).collect();
    let expected = Setpoint { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };

    let mut states: Vec<State> = (0..vehicles).map(|vehicle| start(vehicle, vehicles)).collect();
    let mut trajectory = Trajectory::new(vehicles);
    let autopilot = Autopilot::new(&Dynamics::default(), STEP_S);
    for tick in 0..ticks {
        let t_s = tick as f64 * STEP_S * STEPS_PER_TICK as f64;
        let setpoints: Vec<Setpoint> = (0..vehicles).map(|vehicle| weave(vehicle, t_s, &expected)).collect();
        let rows = states.iter().zip(&setpoints).enumerate().map(|(vehicle, (state, setpoint))| {
            let wobble = |speed: f64| 1.5 + 1.4 * libm::sin(speed * t_s + vehicle as f64);
            Row { state: *state, setpoint: *setpoint, alpha: [wobble(0.9), wobble(2.3), wobble(0.4)] }
        });
        let min_separation_m = separation(&states);
        let min_clearance_m = clearance(&states, &obstacles);
        trajectory.push(Tick { t_s, min_separation_m, min_clearance_m, solve_us: 80.0 }, rows);
        for (state, setpoint) in states.iter_mut().zip(&setpoints) {
            for _ in 0..STEPS_PER_TICK {
                *state = autopilot.step(state, setpoint);
            }
        }
    }
    let field = Field { obstacles, expected, safe_distance_m: 5.0, collision_distance_m: 1.0 };
    let settings = [("optimizer.algorithm", "mslpio"), ("law.alpha", "per-term"), ("law.look_ahead_s", "3")];
    let settings = settings.map(|(name, value)| Setting { name: name.into(), value: value.into() }).into();
    Flight { summary: summary(&field, &trajectory), field, settings, trajectory, dynamics: Vec::new() }
}

fn start(vehicle: usize, vehicles: usize) -> State {
    let place = vehicle as f64 - 0.5 * (vehicles as f64 - 1.0);
    let spacing_m = if vehicles > 10 { 3.0 } else { 9.0 };
    let course_rad = 0.1 * libm::sin(place);
    State {
        x_m: 4.0 * libm::sin(2.0 * place),
        y_m: spacing_m * place,
        altitude_m: 50.0 + 2.0 * libm::cos(3.0 * place),
        speed_mps: 9.0 + libm::sin(5.0 * place),
        course_rad,
        climb_mps: 0.0,
    }
}

fn weave(vehicle: usize, t_s: f64, expected: &Setpoint) -> Setpoint {
    let fading = if t_s < 30.0 { 1.0 } else { libm::exp(-(t_s - 30.0) / 2.0) };
    let phase = 0.35 * t_s + 0.4 * vehicle as f64;
    Setpoint {
        speed_mps: expected.speed_mps + 0.8 * fading * libm::sin(1.7 * phase),
        course_rad: expected.course_rad + 0.35 * fading * libm::cos(phase),
        altitude_m: expected.altitude_m,
    }
}

fn separation(states: &[State]) -> f64 {
    let mut least = f64::INFINITY;
    for (index, one) in states.iter().enumerate() {
        for other in states.iter().skip(index + 1) {
            least = least.min(libm::hypot(one.x_m - other.x_m, one.y_m - other.y_m));
        }
    }
    least
}

fn clearance(states: &[State], obstacles: &[Obstacle]) -> f64 {
    let to_edge =
        |state: &State, disc: &Obstacle| libm::hypot(state.x_m - disc.x_m, state.y_m - disc.y_m) - disc.radius_m;
    let all = states.iter().flat_map(|state| obstacles.iter().map(move |disc| to_edge(state, disc)));
    all.fold(f64::INFINITY, f64::min)
}

fn summary(field: &Field, trajectory: &Trajectory) -> Summary {
    let least = |value: fn(&Tick) -> f64| {
        let ticks = trajectory.ticks.iter().filter(|tick| value(tick).is_finite());
        ticks.min_by(|one, other| value(one).total_cmp(&value(other))).copied()
    };
    let nearest = least(|tick| tick.min_separation_m);
    let closest = least(|tick| tick.min_clearance_m);
    let hit = closest.filter(|tick| tick.min_clearance_m < 0.0);
    Summary {
        scenario: "sample".into(),
        seed: 1,
        algorithm: "mslpio".into(),
        preset: "paper".into(),
        transport: "memory".into(),
        vehicles: trajectory.vehicles,
        obstacles: field.obstacles.len(),
        duration_s: trajectory.ticks.last().map_or(0.0, |tick| tick.t_s),
        control_period_s: 0.5,
        completed: !trajectory.ticks.is_empty(),
        interrupted: trajectory.ticks.is_empty(),
        success: !trajectory.ticks.is_empty() && hit.is_none(),
        failure: hit.map(|tick| format!("UAV 1 entered an obstacle at {:.1} s", tick.t_s)),
        obstacle_collisions: u32::from(hit.is_some()),
        separation_losses: u32::from(nearest.is_some_and(|tick| tick.min_separation_m < field.safe_distance_m)),
        min_clearance_m: closest.map(|tick| tick.min_clearance_m),
        min_clearance_at_s: closest.map(|tick| tick.t_s),
        min_clearance_vehicle: closest.map(|_| 1),
        min_separation_m: nearest.map(|tick| tick.min_separation_m),
        min_separation_at_s: nearest.map(|tick| tick.t_s),
        min_separation_vehicles: nearest.map(|_| [1, 2]),
        passed_last_obstacle: trajectory.vehicles,
        course_convergence_s: Some(36.5),
        solve_us_p50: 81.0,
        solve_us_p99: 140.0,
        wall_s: 0.061,
        real_time_factor: 690.0,
        version: env!("CARGO_PKG_VERSION").into(),
        ..Summary::default()
    }
}
