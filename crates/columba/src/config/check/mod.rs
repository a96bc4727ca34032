//! What a scenario must hold: the ranges of the program's own settings, those that other crates give for theirs, and
//! what no single setting shows.

mod many;

pub use many::parameters;

use super::Scenario;
use super::fault::Faults;
use super::file::ScenarioFile;
use super::obstacles::ObstaclesTable;
use crate::counted::counted;
use crate::judge::COLLISION_DISTANCE_M;
use controller::LookAheadSettings;
use optimizer::OptimizerSettings;

/// Greatest length in a scenario, m: what single precision on the wire resolves to a centimetre.
const LENGTH_MAX_M: f64 = 100_000.0;
/// Control periods, s.
const PERIODS_S: std::ops::RangeInclusive<f64> = 0.001..=10.0;
/// Longest look-ahead in control periods.
const HORIZON_PERIODS_MAX: f64 = 3_000.0;

/// Most vehicles of a scenario, and most obstacles.
pub const COUNT_MAX: usize = 10_000;
/// Longest flight, s.
const DURATION_MAX_S: f64 = 86_400.0;
/// Most rows of a trajectory, which a flight keeps in memory: two gigabytes.
const ROWS_MAX: f64 = 2e7;

/// The range of every setting.
pub fn tables(file: &ScenarioFile, faults: &mut Faults) {
    scenario(file, faults);
    vehicles(file, faults);
    controller(file, faults);
    optimizer(file, faults);
    faults.add_ranges("dynamics", file.dynamics.dynamics().check());
    autopilot_and_link(file, faults);
    many::stock_parameters(file, faults);
}

fn scenario(file: &ScenarioFile, faults: &mut Faults) {
    let table = &file.scenario;
    if table.name.trim().is_empty() || table.name.chars().any(char::is_control) {
        faults.add(
            "scenario.name",
            format!("{:?}", table.name),
            "a name of at least one visible character on one line",
        );
    }
    let (period_s, step_s) = (table.control_period_s, file.dynamics.integration_step_s);
    faults.within("dynamics.integration_step_s", step_s, 0.001, 0.1);
    faults.within("scenario.control_period_s", period_s, *PERIODS_S.start(), *PERIODS_S.end());
    if !is_multiple(step_s, 0.001) && (0.001..=0.1).contains(&step_s) {
        faults.add("dynamics.integration_step_s", step_s, "whole milliseconds");
    } else if !is_multiple(period_s, step_s) && (0.001..=0.1).contains(&step_s) && (0.001..=10.0).contains(&period_s) {
        faults.add(
            "scenario.control_period_s",
            period_s,
            format!("a multiple of dynamics.integration_step_s = {step_s}"),
        );
    }
    if period_s <= 10.0
        && !faults.stands_in("scenario.control_period_s")
        && !(period_s..=DURATION_MAX_S).contains(&table.duration_s)
    {
        let wanted = format!("a number from {period_s}, one scenario.control_period_s, to {DURATION_MAX_S}");
        faults.add("scenario.duration_s", table.duration_s, wanted);
    }
    let count = file.count().max(1);
    let longest_s = ROWS_MAX / count as f64 * period_s;
    if period_s >= 0.001 && table.duration_s > longest_s && table.duration_s <= DURATION_MAX_S {
        let wanted = format!(
            "at most {longest_s:.0}: a flight keeps control periods times vehicles ({count}) in memory, at most \
             {ROWS_MAX}"
        );
        faults.add("scenario.duration_s", table.duration_s, wanted);
    }
    faults.within("scenario.origin.latitude_deg", table.origin.latitude_deg, -85.0, 85.0);
    faults.within("scenario.origin.longitude_deg", table.origin.longitude_deg, -180.0, 180.0);
    faults.within("scenario.origin.altitude_amsl_m", table.origin.altitude_amsl_m, -500.0, 9_000.0);
    let (slowest, fastest) = (file.dynamics.speed_min_mps, file.dynamics.speed_max_mps);
    faults.within("flock.expected_speed_mps", file.flock.expected_speed_mps, slowest, fastest);
    faults.within("flock.expected_course_deg", file.flock.expected_course_deg, -360.0, 360.0);
    faults.within("flock.expected_altitude_m", file.flock.expected_altitude_m, -1_000.0, 20_000.0);
}

/// Whether a value is a whole number of units, at least one.
fn is_multiple(value: f64, unit: f64) -> bool {
    let ratio = value / unit;
    ratio.round() >= 1.0 && (ratio - ratio.round()).abs() < 1e-6
}

fn vehicles(file: &ScenarioFile, faults: &mut Faults) {
    let (slowest, fastest) = (file.dynamics.speed_min_mps, file.dynamics.speed_max_mps);
    for (index, vehicle) in file.vehicle.iter().enumerate() {
        let key = |name: &str| format!("vehicle[{}].{name}", index + 1);
        faults.within(key("x_m"), vehicle.x_m, -LENGTH_MAX_M, LENGTH_MAX_M);
        faults.within(key("y_m"), vehicle.y_m, -LENGTH_MAX_M, LENGTH_MAX_M);
        faults.within(key("altitude_m"), vehicle.altitude_m, -1_000.0, 20_000.0);
        faults.within(key("speed_mps"), vehicle.speed_mps, slowest, fastest);
        faults.within(key("course_deg"), vehicle.course_deg, -360.0, 360.0);
    }
    if let Some(pattern) = &file.vehicles {
        many::pattern_count(pattern, faults);
        faults.within("vehicles.spacing_m", pattern.spacing_m, 2.0 * COLLISION_DISTANCE_M, 1_000.0);
        faults.within("vehicles.x_m", pattern.x_m, -LENGTH_MAX_M, LENGTH_MAX_M);
        faults.within("vehicles.y_m", pattern.y_m, -LENGTH_MAX_M, LENGTH_MAX_M);
        if let Some(altitude_m) = pattern.altitude_m {
            faults.within("vehicles.altitude_m", altitude_m, -1_000.0, 20_000.0);
        }
        if let Some(speed_mps) = pattern.speed_mps {
            faults.within("vehicles.speed_mps", speed_mps, slowest, fastest);
        }
        if let Some(course_deg) = pattern.course_deg {
            faults.within("vehicles.course_deg", course_deg, -360.0, 360.0);
        }
        let speed_mps = pattern.speed_mps.unwrap_or(file.flock.expected_speed_mps);
        let room_mps = (speed_mps - slowest).min(fastest - speed_mps);
        faults.within("vehicles.altitude_spread_m", pattern.altitude_spread_m, 0.0, 1_000.0);
        faults.within("vehicles.speed_spread_mps", pattern.speed_spread_mps, 0.0, room_mps);
        faults.within("vehicles.course_spread_deg", pattern.course_spread_deg, 0.0, 180.0);
    }
    match (file.vehicle.len(), &file.vehicles) {
        (0, None) => {
            let wanted = "must have at least one [[vehicle]], or a [vehicles] table with a count";
            faults.add_subject("vehicle", "the flock is empty", wanted);
        }
        (count, Some(_)) if count > 0 => {
            let wanted = "must be either [[vehicle]] tables or one [vehicles]";
            faults.add_subject("vehicles", "[vehicles] stands beside [[vehicle]]", wanted);
        }
        (count, _) if count > COUNT_MAX => faults.add_subject("vehicle", counted(count, "vehicle"), too_many()),
        _ => {}
    }
    obstacles(file, faults);
}

fn obstacles(file: &ScenarioFile, faults: &mut Faults) {
    if file.obstacle.len() > COUNT_MAX {
        faults.add_subject("obstacle", counted(file.obstacle.len(), "obstacle"), too_many());
    }
    for (index, obstacle) in file.obstacle.iter().enumerate() {
        let key = |name: &str| format!("obstacle[{}].{name}", index + 1);
        faults.within(key("x_m"), obstacle.x_m, -LENGTH_MAX_M, LENGTH_MAX_M);
        faults.within(key("y_m"), obstacle.y_m, -LENGTH_MAX_M, LENGTH_MAX_M);
        faults.above(key("radius_m"), obstacle.radius_m, 0.0, 10_000.0);
    }
    let Some(table) = &file.obstacles else { return };
    if !file.obstacle.is_empty() {
        let wanted = "must be either [[obstacle]] tables or one [obstacles]";
        faults.add_subject("obstacles", "[obstacles] stands beside [[obstacle]]", wanted);
    }
    faults.whole("obstacles.count", table.count, 1, 1_000);
    faults.above("obstacles.radius_min_m", table.radius_min_m, 0.0, 10_000.0);
    faults.within("obstacles.radius_max_m", table.radius_max_m, table.radius_min_m, 10_000.0);
    faults.within("obstacles.gap_m", table.gap_m, 0.0, 10_000.0);
    faults.within("obstacles.x_min_m", table.x_min_m, -LENGTH_MAX_M, LENGTH_MAX_M);
    faults.within("obstacles.x_max_m", table.x_max_m, table.x_min_m, LENGTH_MAX_M);
    faults.within("obstacles.y_min_m", table.y_min_m, -LENGTH_MAX_M, LENGTH_MAX_M);
    faults.within("obstacles.y_max_m", table.y_max_m, table.y_min_m, LENGTH_MAX_M);
}

/// Whether all circles of a random field found room.
pub fn scattered(table: &ObstaclesTable, placed: usize, faults: &mut Faults) {
    if placed < table.count {
        let wanted =
            format!("at most about {placed}: there is no room for more with obstacles.gap_m = {}", table.gap_m);
        faults.add("obstacles.count", table.count, wanted);
    }
}

fn too_many() -> String {
    format!("must be at most {COUNT_MAX}")
}

fn controller(file: &ScenarioFile, faults: &mut Faults) {
    faults.add_ranges("law", file.law.check());
    faults.add_ranges("weights", file.weights.check());
    faults.add_ranges("look_ahead", file.look_ahead.check());
    let periods_s = HORIZON_PERIODS_MAX * file.scenario.control_period_s;
    let horizon_s = file.look_ahead.horizon_s;
    // A period or a horizon that is at fault itself has been told already.
    let both_in_range =
        PERIODS_S.contains(&file.scenario.control_period_s) && horizon_s <= LookAheadSettings::HORIZON_MAX_S;
    if both_in_range && horizon_s > periods_s && !faults.stands_in("scenario.control_period_s") {
        let wanted = format!("at most {HORIZON_PERIODS_MAX} control periods, {periods_s} s: every pigeon flies it");
        faults.add("look_ahead.horizon_s", horizon_s, wanted);
    }
}

/// An optimiser tells the first of its settings that is out of range: with the default in its place, the next.
fn optimizer(file: &ScenarioFile, faults: &mut Faults) {
    let mut settings = file.optimizer;
    while let Err((algorithm, error)) = settings.validate() {
        let wanted =
            if error.range.starts_with("from") { format!("a number {}", error.range) } else { error.range.to_owned() };
        let key = format!("optimizer.{}.{}", algorithm.key(), error.setting);
        let seen = faults.tells(&key);
        faults.add(&key, error.value, wanted);
        match with_default(settings, algorithm.key(), error.setting) {
            Some(repaired) if !seen => settings = repaired,
            _ => break,
        }
    }
}

fn with_default(settings: OptimizerSettings, algorithm: &str, setting: &str) -> Option<OptimizerSettings> {
    let mut json = serde_json::to_value(settings).ok()?;
    let default = serde_json::to_value(OptimizerSettings::default()).ok()?;
    *json.get_mut(algorithm)?.get_mut(setting)? = default.get(algorithm)?.get(setting)?.clone();
    serde_json::from_value(json).ok()
}

fn autopilot_and_link(file: &ScenarioFile, faults: &mut Faults) {
    let link = &file.link;
    if let Some(speed_mps) = file.autopilot.cruise_speed_mps {
        let (slowest, fastest) = (file.dynamics.speed_min_mps, file.dynamics.speed_max_mps);
        faults.within("autopilot.cruise_speed_mps", speed_mps, slowest, fastest);
    }
    for error in file.autopilot.check(file.dynamics.integration_step_s) {
        let why = if error.name.ends_with("_hz") { ", 0.8 for each dynamics.integration_step_s" } else { "" };
        faults.add(format!("autopilot.{}", error.name), error.value, format!("{}{why}", error.range));
    }
    if link.host.parse::<std::net::IpAddr>().is_err() {
        faults.add("link.host", format!("{:?}", link.host), "an IP address, such as 127.0.0.1");
    }
    many::ports(file, faults);
    faults.add_ranges("link", link.impairment().check());
    faults.add_ranges("ground", file.ground.check());
    if file.output.folder.as_deref().is_some_and(|folder| folder.trim().is_empty()) {
        faults.add("output.folder", "\"\"", "a folder's name");
    }
}

/// No two vehicles in one place, none inside a circle, none out of reach. Rows that are at fault themselves are left
/// out.
pub fn starts(scenario: &Scenario, by_pattern: bool, faults: &mut Faults) {
    let at_fault = |table: &str, count: usize, faults: &Faults| -> Vec<bool> {
        (1..=count).map(|number| !faults.is_empty() && faults.is_within(&format!("{table}[{number}]"))).collect()
    };
    let vehicles_at_fault = at_fault("vehicle", scenario.starts.len(), faults);
    let obstacles_at_fault = at_fault("obstacle", scenario.obstacles.len(), faults);
    let mut add = |index: usize, wanted: String| {
        if vehicles_at_fault[index] {
            return;
        }
        let start = &scenario.starts[index];
        let key = if by_pattern { "vehicles".to_owned() } else { format!("vehicle[{}]", index + 1) };
        // Hundredths are enough to find a vehicle of a pattern.
        let [x_m, y_m] = [start.x_m, start.y_m].map(|value| (value * 100.0).round() / 100.0);
        faults.add_subject(key, format!("vehicle {} at x_m = {x_m}, y_m = {y_m}", index + 1), wanted);
    };
    // Sorted by northing, only vehicles within the collision distance in x need to be compared.
    let mut order: Vec<usize> = (0..scenario.starts.len()).collect();
    order.sort_by(|&a, &b| scenario.starts[a].x_m.total_cmp(&scenario.starts[b].x_m));
    for (rank, &a) in order.iter().enumerate() {
        let first = &scenario.starts[a];
        for &b in &order[rank + 1..] {
            let second = &scenario.starts[b];
            let (dx, dy) = (second.x_m - first.x_m, second.y_m - first.y_m);
            if dx >= COLLISION_DISTANCE_M {
                break;
            }
            let distance_m = (dx * dx + dy * dy).sqrt();
            if distance_m < COLLISION_DISTANCE_M && !vehicles_at_fault[a.min(b)] {
                let wanted = format!(
                    "must be at least {COLLISION_DISTANCE_M} m from vehicle {}, which starts {distance_m:.2} m away",
                    a.min(b) + 1
                );
                add(a.max(b), wanted);
            }
        }
    }
    for (index, start) in scenario.starts.iter().enumerate() {
        if !(start.x_m.abs() <= LENGTH_MAX_M && start.y_m.abs() <= LENGTH_MAX_M) {
            add(index, format!("must be within {LENGTH_MAX_M} m of the origin in x and y"));
        }
        for (number, obstacle) in scenario.obstacles.iter().enumerate() {
            let clearance_m = obstacle.clearance_m(start.position_m());
            if clearance_m <= 0.0 && !obstacles_at_fault[number] {
                let inside_m = -clearance_m;
                add(
                    index,
                    format!("must be outside obstacle {}, {inside_m:.2} m inside whose edge it starts", number + 1),
                );
            }
        }
    }
}
