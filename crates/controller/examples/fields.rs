//! Flies seeded random fields in memory and prints how they ended: `fields KIND FLIGHTS [FIRST_SEED]`, KIND being `paper`,
//! `random5` or `random12`.

use controller::*;
use flight_model::*;
use optimizer::MslpioSettings;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rayon::prelude::*;
use std::time::Duration;

struct Case {
    states: Vec<State>,
    obstacles: Vec<Obstacle>,
    duration_s: f64,
}

fn paper() -> Case {
    let states = [(-12.0, 9.0, 0.09), (-6.0, 10.5, -0.05), (0.0, 9.5, 0.0), (6.0, 11.0, 0.05), (12.0, 9.0, -0.09)]
        .iter()
        .enumerate()
        .map(|(i, &(y_m, speed_mps, course_rad))| State {
            x_m: [0.0, 6.0, 10.0, 6.0, 0.0][i],
            y_m,
            altitude_m: [46.0, 53.0, 50.0, 48.0, 55.0][i],
            speed_mps,
            course_rad,
            climb_mps: 0.0,
        })
        .collect();
    let obstacles = [
        (70.0, 12.0, 8.0),
        (85.0, -18.0, 10.0),
        (130.0, 0.0, 6.0),
        (165.0, 24.0, 9.0),
        (185.0, -14.0, 12.0),
        (235.0, 6.0, 7.0),
        (275.0, -12.0, 8.0),
    ]
    .iter()
    .map(|&(x_m, y_m, radius_m)| Obstacle { x_m, y_m, radius_m })
    .collect();
    Case { states, obstacles, duration_s: 42.0 }
}

fn random(seed: u64, vehicles: usize) -> Case {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = rng.random_range(7..=14);
    let mut obstacles: Vec<Obstacle> = Vec::new();
    let mut tries = 0;
    while obstacles.len() < count && tries < 20000 {
        tries += 1;
        let o = Obstacle {
            x_m: rng.random_range(50.0..330.0),
            y_m: rng.random_range(-50.0..50.0),
            radius_m: rng.random_range(4.0..14.0),
        };
        if o.x_m - o.radius_m < 40.0 {
            continue;
        }
        if obstacles.iter().all(|p| p.clearance_m(o.x_m, o.y_m) - o.radius_m >= 14.0) {
            obstacles.push(o);
        }
    }
    let mut states: Vec<State> = Vec::new();
    let gap: f64 = std::env::var("GAP").ok().and_then(|v| v.parse().ok()).unwrap_or(5.0);
    let half = if vehicles > 6 { 30.0 } else { 20.0 };
    while states.len() < vehicles {
        let s = State {
            x_m: rng.random_range(-20.0..15.0),
            y_m: rng.random_range(-half..half),
            altitude_m: rng.random_range(35.0..65.0),
            speed_mps: rng.random_range(7.0..13.0),
            course_rad: rng.random_range(-0.35..0.35),
            climb_mps: 0.0,
        };
        if states.iter().all(|p| ((p.x_m - s.x_m) * (p.x_m - s.x_m) + (p.y_m - s.y_m) * (p.y_m - s.y_m)).sqrt() > gap) {
            states.push(s);
        }
    }
    Case { states, obstacles, duration_s: 46.0 }
}

#[derive(Default, Clone, Debug)]
struct Result_ {
    min_sep: f64,
    min_clear: f64,
    passed: bool,
    vconv: f64,
    cconv: f64,
    solve: f64,
    sep_at: f64,
    clear_at: f64,
    effort: f64,
    infeasible: f64,
}

fn fly(case: &Case, seed: u64, settings: &ControllerSettings) -> Result_ {
    let dynamics = Dynamics::default();
    let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
    let mut flock = Flock::new(
        FlockSettings {
            controller: settings.clone(),
            optimizer: MslpioSettings::default(),
            seed,
            control_period_s: 0.5,
            expected,
            obstacles: case.obstacles.clone(),
            dynamics,
        },
        case.states.len(),
    )
    .unwrap();
    let autopilot = Autopilot::new(&dynamics, 0.01);
    let mut states = case.states.clone();
    let mut r = Result_ { min_sep: 1e9, min_clear: 1e9, ..Default::default() };
    let start = std::time::Instant::now();
    let clock = move || -> Duration { start.elapsed() };
    let ticks = (case.duration_s / 0.5) as u64;
    let verbose = std::env::var("VERBOSE").is_ok();
    for tick in 0..ticks {
        let d: Vec<Decision> = flock.tick(tick, &states, &clock).to_vec();
        r.solve += d.iter().map(|d| d.solve.as_secs_f64()).sum::<f64>() / (d.len() as f64 * ticks as f64);
        r.infeasible += d.iter().filter(|d| !d.feasible).count() as f64 / (d.len() as f64 * ticks as f64);
        if verbose {
            println!("t={:.1}", tick as f64 * 0.5);
            for (s, d) in states.iter().zip(&d) {
                println!(
                    "   x {:6.1} y {:6.1} v {:5.2} c {:6.3} | w {:.2?} {} | sp {:5.2} {:6.3}",
                    s.x_m,
                    s.y_m,
                    s.speed_mps,
                    s.course_rad,
                    d.weights,
                    d.feasible,
                    d.setpoint.speed_mps,
                    d.setpoint.course_rad
                );
            }
        }
        for step in 0..50 {
            for (s, d) in states.iter_mut().zip(&d) {
                *s = autopilot.step(s, &d.setpoint);
            }
            let t = tick as f64 * 0.5 + 0.01 * (step + 1) as f64;
            for (i, s) in states.iter().enumerate() {
                for p in &states[..i] {
                    let dd = ((p.x_m - s.x_m) * (p.x_m - s.x_m) + (p.y_m - s.y_m) * (p.y_m - s.y_m)).sqrt();
                    if dd < r.min_sep {
                        r.min_sep = dd;
                        r.sep_at = t;
                    }
                }
                for o in &case.obstacles {
                    let c = o.clearance_m(s.x_m, s.y_m);
                    if c < r.min_clear {
                        r.min_clear = c;
                        r.clear_at = t;
                    }
                }
            }
        }
        let t = (tick + 1) as f64 * 0.5;
        if states.iter().any(|s| (s.speed_mps - 10.0).abs() > 0.2) {
            r.vconv = t + 0.5;
        }
        if states.iter().any(|s| s.course_rad.abs() > 0.02) {
            r.cconv = t + 0.5;
        }
    }
    if r.vconv > case.duration_s {
        r.vconv = 99.0;
    }
    if r.cconv > case.duration_s {
        r.cconv = 99.0;
    }
    let last = case.obstacles.iter().map(|o| o.x_m + o.radius_m).fold(0.0, f64::max);
    r.passed = states.iter().all(|s| s.x_m > last);
    r
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (kind, flights) = (args[1].as_str(), args[2].parse::<u64>().unwrap());
    let first: u64 = args.get(3).map_or(1, |s| s.parse().unwrap());
    let settings: ControllerSettings = match std::env::var("SETTINGS") {
        Ok(text) => serde_json::from_str(&text).unwrap(),
        Err(_) => ControllerSettings::default(),
    };
    let results: Vec<(u64, Result_)> = (first..first + flights)
        .into_par_iter()
        .map(|seed| {
            let case = match kind {
                "paper" => paper(),
                "random5" => random(seed, 5),
                "random12" => random(seed, 12),
                _ => panic!(),
            };
            (seed, fly(&case, seed, &settings))
        })
        .collect();
    let n = results.len() as f64;
    for (seed, r) in &results {
        if r.min_sep < 2.0 || r.min_clear < 0.0 || !r.passed || flights <= 5 {
            println!(
                "seed {seed}: sep {:.2} at {:.1}, clear {:.2} at {:.1}, passed {}, v {} c {} inf {:.3}",
                r.min_sep, r.sep_at, r.min_clear, r.clear_at, r.passed, r.vconv, r.cconv, r.infeasible
            );
        }
    }
    let count = |f: &dyn Fn(&Result_) -> bool| results.iter().filter(|(_, r)| f(r)).count();
    let median = |f: &dyn Fn(&Result_) -> f64| {
        let mut v: Vec<f64> = results.iter().map(|(_, r)| f(r)).collect();
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    println!(
        "{kind}: {n} flights: obstacle hits {}, vehicle hits {}, sep<2 {}, not passed {}, median v {} c {}, min sep med {:.2} worst {:.2}, clear med {:.2}, solve {:.0} us, infeasible {:.4}",
        count(&|r| r.min_clear < 0.0),
        count(&|r| r.min_sep < 1.0),
        count(&|r| r.min_sep < 2.0),
        count(&|r| !r.passed),
        median(&|r| r.vconv),
        median(&|r| r.cconv),
        median(&|r| r.min_sep),
        results.iter().map(|(_, r)| r.min_sep).fold(1e9, f64::min),
        median(&|r| r.min_clear),
        median(&|r| r.solve) * 1e6,
        median(&|r| r.infeasible)
    );
}
