//! What holds of any flock's tick.

mod flight;

use controller::{ControllerSettings, Expected, Flock, FlockError, FlockSettings, Obstacle};
use flight::fly;
use flight_model::{Autopilot, State};
use std::time::Duration;

const EXPECTED: Expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };

fn settings() -> FlockSettings {
    let circle = |x_m: f64, y_m: f64, radius_m: f64| Obstacle { x_m, y_m, radius_m };
    FlockSettings { obstacles: vec![circle(60.0, 5.0, 8.0), circle(80.0, -20.0, 6.0)], ..FlockSettings::new(EXPECTED) }
}

fn row(vehicles: usize, spacing_m: f64) -> Vec<State> {
    let state = |i: usize| State { y_m: i as f64 * spacing_m, altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
    (0..vehicles).map(state).collect()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let flown = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| fly(&settings(), &row(6, 6.0), 12))
    };
    let (one, three) = (flown(1), flown(3));
    assert_eq!(one.decisions, three.decisions);
    assert_eq!(one.states, three.states);
}

#[test]
fn the_seed_decides() {
    let flown = |seed| fly(&FlockSettings { seed, ..settings() }, &row(6, 6.0), 12);
    assert_eq!(flown(1).decisions, flown(1).decisions);
    assert_ne!(flown(1).decisions, flown(2).decisions);
}

#[test]
fn a_vehicle_alone_holds_what_is_expected() {
    let settings = FlockSettings::new(EXPECTED);
    let start = State { altitude_m: 35.0, speed_mps: 6.0, course_rad: 0.8, ..State::default() };
    let end = fly(&settings, &[start], 60).states[0];
    assert!((end.speed_mps - 10.0).abs() < 0.05 && end.course_rad.abs() < 0.005, "{end:?}");
    assert!((end.altitude_m - 50.0).abs() < 0.05, "{end:?}");
}

#[test]
fn neighbours_too_near_part_and_do_not_come_near_again() {
    let flown = fly(&FlockSettings::new(EXPECTED), &row(4, 3.2), 40);
    assert!(flown.min_separation_m > 2.5, "{}", flown.min_separation_m);
}

#[test]
fn the_presets_fly_and_differ() {
    let flown = |controller| fly(&FlockSettings { controller, ..settings() }, &row(5, 8.0), 24);
    let (default, paper, literal) = (
        flown(ControllerSettings::default()),
        flown(ControllerSettings::paper()),
        flown(ControllerSettings::literal()),
    );
    assert_ne!(default.decisions, paper.decisions);
    assert_ne!(paper.decisions, literal.decisions);
    assert!(literal.decisions.iter().flatten().all(|decision| decision.setpoint.is_finite()));
    let shared = paper.decisions.iter().flatten().all(|d| d.weights[0] == d.weights[1] && d.weights[1] == d.weights[2]);
    assert!(shared, "the paper has one alpha");
}

#[test]
fn settings_out_of_range_are_refused_with_their_name() {
    let refused = |change: fn(&mut FlockSettings)| {
        let mut settings = settings();
        change(&mut settings);
        Flock::new(settings, 2).err()
    };
    let name = |change: fn(&mut FlockSettings)| match refused(change) {
        Some(FlockError::Setting(error)) => error.name,
        other => panic!("{:?}", other.map(|error| error.to_string())),
    };
    assert_eq!(name(|settings| settings.control_period_s = 0.0), "control_period_s");
    assert_eq!(name(|settings| settings.expected.speed_mps = f64::NAN), "expected.speed_mps");
    assert_eq!(name(|settings| settings.controller.look_ahead.horizon_s = f64::INFINITY), "horizon_s");
    assert_eq!(name(|settings| settings.controller.weights.max = -1.0), "max");
    assert_eq!(name(|settings| settings.dynamics[0].time_constants.speed_s = 0.0), "speed_time_constant_s");
    assert_eq!(name(|settings| settings.dynamics[0].limits.climb_max_mps = f64::NAN), "climb_max_mps");
    // Vehicles that fly at one speed alone, and hardly bank.
    let narrow = refused(|settings| {
        let limits = &mut settings.dynamics[0].limits;
        (limits.speed_min_mps, limits.speed_max_mps, limits.lateral_overload_max) = (10.0, 10.0, 0.01);
    });
    assert_eq!(narrow, None);
    let optimizer = refused(|settings| settings.optimizer.mslpio.iterations = usize::MAX);
    assert!(matches!(optimizer, Some(FlockError::Optimizer(error)) if error.setting == "iterations"));
    for controller in [ControllerSettings::default(), ControllerSettings::paper(), ControllerSettings::literal()] {
        assert!(FlockSettings { controller, ..settings() }.check().is_empty());
    }
}

#[test]
fn an_impossible_state_is_no_panic_and_leaves_the_others_alone() {
    let mut states = row(4, 8.0);
    states[2].x_m = f64::NAN;
    states[3].speed_mps = f64::INFINITY;
    let mut flock = Flock::new(settings(), 4).expect("valid settings");
    let decisions = flock.tick(0, &states, &|| Duration::ZERO);
    assert!(decisions[0].setpoint.is_finite() && decisions[1].setpoint.is_finite(), "{decisions:?}");
}

#[test]
fn too_many_or_too_few_states_are_no_panic() {
    let mut flock = Flock::new(settings(), 3).expect("valid settings");
    assert_eq!(flock.tick(0, &row(5, 8.0), &|| Duration::ZERO).len(), 3);
    assert_eq!(flock.tick(1, &row(1, 8.0), &|| Duration::ZERO).len(), 3);
    assert!(flock.decide(2, 1, &row(1, 8.0), &|| Duration::ZERO).is_none());
}

#[test]
fn a_vehicle_by_itself_decides_what_the_flock_would() {
    let (mut flock, mut alone) = (Flock::new(settings(), 4), Flock::new(settings(), 4));
    let states = row(4, 6.0);
    let together = flock.as_mut().expect("valid settings").tick(0, &states, &|| Duration::ZERO)[2];
    let by_itself = alone.as_mut().expect("valid settings").decide(0, 2, &states, &|| Duration::ZERO);
    assert_eq!(by_itself, Some(together));
}

#[test]
fn a_warm_solve_allocates_nothing() {
    let mut flock = Flock::new(settings(), 9).expect("valid settings");
    let states = row(9, 5.0);
    for tick in 0..3 {
        flock.decide(tick, 4, &states, &|| Duration::ZERO);
    }
    let allocated = allocation_counter::measure(|| {
        flock.decide(3, 4, &states, &|| Duration::ZERO);
    });
    assert_eq!(allocated.count_total, 0);
}

#[test]
fn a_watched_vehicle_tells_its_front_and_where_it_leads_and_decides_the_same() {
    let settings = settings();
    let states = row(5, 6.0);
    let autopilot = Autopilot::new(&settings.dynamics[0], settings.control_period_s);
    let mut plain = Flock::new(settings.clone(), states.len()).expect("settings in range");
    let mut watched = Flock::new(settings, states.len()).expect("settings in range");
    watched.watch(&[2, 9]);
    let (mut states, mut told) = (states, 0);
    for tick in 0..20 {
        let wanted = plain.tick(tick, &states, &|| Duration::ZERO).to_vec();
        let decisions = watched.tick(tick, &states, &|| Duration::ZERO).to_vec();
        assert_eq!(decisions, wanted);
        let insights: Vec<_> = watched.insights().collect();
        let [(2, insight)] = insights[..] else { panic!("only the third is watched") };
        let chosen = &insight.members[insight.chosen];
        assert_eq!((insight.tick, chosen.weights), (tick, decisions[2].weights));
        assert!(insight.members.len() <= insight.front_len.min(61));
        let costs = |k: usize| insight.members.iter().map(move |member| member.costs[k]);
        assert!(costs(0).is_sorted() && costs(1).rev().is_sorted(), "a front of two costs");
        let from = states[2];
        for (state, decision) in states.iter_mut().zip(&decisions) {
            *state = autopilot.step(state, &decision.setpoint);
        }
        let path_m = insight.evasion_path_m.as_ref().unwrap_or(&chosen.path_m);
        let off_m = |[x_m, y_m]: [f64; 2], state: &State| {
            let (north_m, east_m) = (state.x_m - x_m, state.y_m - y_m);
            (north_m * north_m + east_m * east_m).sqrt()
        };
        assert_eq!(path_m.len(), 7, "the present, and six control periods");
        assert!(off_m(path_m[0], &from) < 1e-9);
        // The first command need not be the law's where the course would jump.
        told += u32::from(off_m(path_m[1], &states[2]) < 0.02);
    }
    assert!(told > 15, "{told} of 20 predictions came true");
    watched.watch(&[]);
    assert_eq!(watched.insights().count(), 0);
}
