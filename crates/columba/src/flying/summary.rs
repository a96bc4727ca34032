//! What is told of every flight, flown by simulated or by real vehicles: from its scenario, from its judge, from its
//! solves.

use crate::config::Scenario;
use crate::flight::{Field, Obstacle, Setting, Summary, vehicle_number};
use crate::judge::{COLLISION_DISTANCE_M, Verdict};
use flight_model::Setpoint;
use std::time::Duration;

/// What is known of a flight before it; `transport` is how setpoints reach the vehicles.
pub fn planned(scenario: &Scenario, transport: &str) -> Summary {
    Summary {
        scenario: scenario.name.clone(),
        seed: scenario.seed,
        algorithm: scenario.optimizer.algorithm.key().to_owned(),
        preset: name_of(&scenario.preset),
        transport: transport.to_owned(),
        vehicles: scenario.starts.len(),
        obstacles: scenario.obstacles.len(),
        control_period_s: scenario.control_period.as_secs_f64(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        ..Summary::default()
    }
}

/// The same with what the judge found.
pub fn judged(verdict: &Verdict, summary: Summary) -> Summary {
    Summary {
        obstacle_collisions: verdict.obstacle_collisions,
        vehicle_collisions: verdict.vehicle_collisions,
        separation_losses: verdict.separation_losses,
        min_clearance_m: verdict.clearance.map(|least| least.value_m),
        min_clearance_at_s: verdict.clearance.map(|least| least.at_s),
        min_clearance_vehicle: verdict.clearance.map(|least| vehicle_number(least.whose)),
        min_separation_m: verdict.separation.map(|least| least.value_m),
        min_separation_at_s: verdict.separation.map(|least| least.at_s),
        min_separation_vehicles: verdict.separation.map(|least| least.whose.map(vehicle_number)),
        passed_last_obstacle: verdict.passed_last_obstacle,
        speed_convergence_s: verdict.speed_convergence_s,
        course_convergence_s: verdict.course_convergence_s,
        altitude_settling_s: verdict.altitude_settling_s,
        speed_variation_mps: verdict.smoothness.speed_variation_mps(),
        course_variation_rad: verdict.smoothness.course_variation_rad(),
        flock_radius_m: verdict.smoothness.radius_m(),
        flock_radius_end_m: verdict.smoothness.radius_end_m(),
        ..summary
    }
}

/// How long the optimiser took, solve by solve.
#[derive(Default)]
pub struct Solves(Vec<Duration>);

impl Solves {
    /// One solve more.
    pub fn push(&mut self, solve: Duration) {
        self.0.push(solve);
    }

    /// The time within which a share of the solves were done, by nearest rank, us; NaN where there was none.
    pub fn percentile_us(&mut self, share: f64) -> f64 {
        self.0.sort_unstable();
        let rank = (share * self.0.len() as f64).ceil() as usize;
        self.0.get(rank.saturating_sub(1)).map_or(f64::NAN, |solve| solve.as_secs_f64() * 1e6)
    }
}

/// The field of a scenario.
pub fn field(scenario: &Scenario) -> Field {
    Field {
        obstacles: scenario
            .obstacles
            .iter()
            .map(|circle| Obstacle { x_m: circle.x_m, y_m: circle.y_m, radius_m: circle.radius_m })
            .collect(),
        expected: Setpoint {
            speed_mps: scenario.expected.speed_mps,
            course_rad: scenario.expected.course_rad,
            altitude_m: scenario.expected.altitude_m,
        },
        safe_distance_m: scenario.controller.law.safe_distance_m,
        collision_distance_m: COLLISION_DISTANCE_M,
    }
}

/// The reading of the paper that flew, by the names of the scenario file.
pub fn settings(scenario: &Scenario) -> Vec<Setting> {
    let mut settings = vec![Setting { name: "preset".to_owned(), value: name_of(&scenario.preset) }];
    let algorithm = scenario.optimizer.algorithm.key();
    settings.push(Setting { name: "optimizer.algorithm".to_owned(), value: algorithm.to_owned() });
    if let Some(values) = serde_json::to_value(scenario.optimizer)
        .ok()
        .and_then(|mut table| table.get_mut(algorithm).map(serde_json::Value::take))
    {
        add(&mut settings, &format!("optimizer.{algorithm}"), &values);
    }
    if let Ok(serde_json::Value::Object(tables)) = serde_json::to_value(&scenario.controller) {
        for (table, values) in tables {
            add(&mut settings, &table, &values);
        }
    }
    settings
}

/// Every key of a table of settings.
fn add(settings: &mut Vec<Setting>, table: &str, values: &serde_json::Value) {
    for (key, value) in values.as_object().into_iter().flatten() {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        settings.push(Setting { name: format!("{table}.{key}"), value });
    }
}

/// The name under which a scenario file speaks of an enum's value.
pub fn name_of(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}
