//! What a scenario must hold: the range of every setting, and what no single setting shows.

mod many;

pub use many::parameters;

use super::Scenario;
use super::file::ScenarioFile;
use super::obstacles::ObstaclesTable;
use crate::judge::COLLISION_DISTANCE_M;
use std::fmt::Display;

/// Everything that is wrong.
#[derive(Default)]
pub struct Faults {
    pub list: Vec<Fault>,
}

/// One thing that is wrong.
pub struct Fault {
    /// As `table.key` or `table[2].key`, counted from one.
    pub key: String,
    /// The setting's value.
    pub value: String,
    /// What is at fault, where that is more than the key and its value.
    pub subject: Option<String>,
    /// What would be right, as `must be ...`.
    pub wanted: String,
    /// The line of another file that is at fault.
    pub place: Option<String>,
}

/// Greatest length in a scenario, m: what single precision on the wire resolves to a centimetre.
const LENGTH_MAX_M: f64 = 100_000.0;
/// Control periods, s.
const PERIODS_S: std::ops::RangeInclusive<f64> = 0.001..=10.0;
/// Longest look-ahead, s, and in control periods.
const HORIZON_MAX_S: f64 = 60.0;
const HORIZON_PERIODS_MAX: f64 = 3_000.0;

/// Most vehicles of a scenario, and most obstacles.
pub const COUNT_MAX: usize = 10_000;
/// Longest flight, s.
pub const DURATION_MAX_S: f64 = 86_400.0;
/// Most rows of a trajectory, which a flight keeps in memory: two gigabytes.
const ROWS_MAX: f64 = 2e7;
/// Greatest share of datagrams lost, duplicated or reordered: a link that loses everything would wait for ever.
pub const SHARE_MAX: f64 = 0.95;

impl Faults {
    /// A setting with a wrong value.
    fn add(&mut self, key: impl Into<String>, value: impl Display, wanted: impl Display) {
        let wanted = format!("must be {wanted}");
        self.list.push(Fault { key: key.into(), value: value.to_string(), subject: None, wanted, place: None });
    }

    /// A fault that is not of one setting alone.
    fn add_subject(&mut self, key: impl Into<String>, subject: impl Into<String>, wanted: impl Into<String>) {
        let subject = Some(subject.into());
        self.list.push(Fault { key: key.into(), value: String::new(), subject, wanted: wanted.into(), place: None });
    }

    /// A fault in a line of another file than the scenario's.
    fn add_elsewhere(&mut self, place: String, subject: String, wanted: impl Display) {
        let wanted = format!("must be {wanted}");
        let fault =
            Fault { key: String::new(), value: String::new(), subject: Some(subject), wanted, place: Some(place) };
        self.list.push(fault);
    }

    /// `low..=high`; where these are settings at fault themselves, their own messages are enough.
    fn within(&mut self, key: impl Into<String>, value: f64, low: f64, high: f64) {
        if low <= high && !(low..=high).contains(&value) {
            self.add(key, value, format!("a number from {low} to {high}"));
        }
    }

    /// Above `low`, up to `high`; as [`within`](Self::within).
    fn above(&mut self, key: impl Into<String>, value: f64, low: f64, high: f64) {
        if low <= high && !(value > low && value <= high) {
            self.add(key, value, format!("a number greater than {low} and at most {high}"));
        }
    }

    fn whole(&mut self, key: impl Into<String>, value: usize, low: usize, high: usize) {
        if !(low..=high).contains(&value) {
            self.add(key, value, format!("a whole number from {low} to {high}"));
        }
    }
}

/// The range of every setting.
pub fn tables(file: &ScenarioFile, faults: &mut Faults) {
    scenario(file, faults);
    vehicles(file, faults);
    controller(file, faults);
    optimizer(file, faults);
    dynamics(file, faults);
    autopilot_and_link(file, faults);
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
    if period_s <= 10.0 && !(period_s..=DURATION_MAX_S).contains(&table.duration_s) {
        let wanted = format!("a number from {period_s}, one scenario.control_period_s, to {DURATION_MAX_S}");
        faults.add("scenario.duration_s", table.duration_s, wanted);
    }
    let count = file.count().max(1);
    let longest_s = ROWS_MAX / count as f64 * period_s;
    if period_s >= 0.001 && table.duration_s > longest_s && table.duration_s <= DURATION_MAX_S {
        let wanted = format!(
            "at most {longest_s:.0}: a flight keeps control periods times vehicles ({count}) in memory, at most {ROWS_MAX}"
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
        (count, _) if count > COUNT_MAX => faults.add_subject("vehicle", format!("{count} vehicles"), too_many()),
        _ => {}
    }
    obstacles(file, faults);
}

fn obstacles(file: &ScenarioFile, faults: &mut Faults) {
    if file.obstacle.len() > COUNT_MAX {
        faults.add_subject("obstacle", format!("{} obstacles", file.obstacle.len()), too_many());
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
    let law = &file.law;
    for (key, value, high) in [
        ("law.formation_gain", law.formation_gain, 1e3),
        ("law.collision_gain", law.collision_gain, 1e9),
        ("law.obstacle_gain", law.obstacle_gain, 1e3),
        ("law.neighbour_velocity_gain", law.neighbour_velocity_gain, 1e3),
        ("law.vertical_velocity_gain", law.vertical_velocity_gain, 1e3),
        ("law.altitude_gain", law.altitude_gain, 1e3),
        ("law.obstacle_margin_m", law.obstacle_margin_m, 100.0),
        ("law.influence_factor", law.influence_factor, 1e3),
        ("law.velocity_cost_s", law.velocity_cost_s, 1e3),
        ("weights.min", file.weights.min, 100.0),
    ] {
        faults.within(key, value, 0.0, high);
    }
    for (key, value, high) in [
        ("law.communication_distance_m", law.communication_distance_m, 1_000.0),
        ("law.desired_distance_m", law.desired_distance_m, 1_000.0),
        ("law.safe_distance_m", law.safe_distance_m, 1_000.0),
        ("law.perception_distance_m", law.perception_distance_m, 10_000.0),
        ("look_ahead.horizon_s", file.look_ahead.horizon_s, HORIZON_MAX_S),
        ("look_ahead.separation_m", file.look_ahead.separation_m, 1_000.0),
    ] {
        faults.above(key, value, 0.0, high);
    }
    let periods_s = HORIZON_PERIODS_MAX * file.scenario.control_period_s;
    let horizon_s = file.look_ahead.horizon_s;
    // A period or a horizon that is at fault itself has been told already.
    let both_in_range = PERIODS_S.contains(&file.scenario.control_period_s) && horizon_s <= HORIZON_MAX_S;
    if both_in_range && horizon_s > periods_s {
        let wanted = format!("at most {HORIZON_PERIODS_MAX} control periods, {periods_s} s: every pigeon flies it");
        faults.add("look_ahead.horizon_s", horizon_s, wanted);
    }
    faults.above("weights.max", file.weights.max, file.weights.min, 100.0);
    faults.within("look_ahead.clearance_m", file.look_ahead.clearance_m, 0.0, 100.0);
    faults.whole("look_ahead.neighbours_max", file.look_ahead.neighbours_max, 1, 64);
}

fn optimizer(file: &ScenarioFile, faults: &mut Faults) {
    let Err((algorithm, error)) = file.optimizer.validate() else { return };
    let wanted =
        if error.range.starts_with("from") { format!("a number {}", error.range) } else { error.range.to_owned() };
    faults.add(format!("optimizer.{}.{}", algorithm.key(), error.setting), error.value, wanted);
}

fn dynamics(file: &ScenarioFile, faults: &mut Faults) {
    let table = &file.dynamics;
    for (key, value) in [
        ("dynamics.speed_time_constant_s", table.speed_time_constant_s),
        ("dynamics.course_time_constant_s", table.course_time_constant_s),
        ("dynamics.altitude_time_constant_a_s", table.altitude_time_constant_a_s),
        ("dynamics.altitude_time_constant_b_s", table.altitude_time_constant_b_s),
    ] {
        faults.within(key, value, 0.02, 60.0);
    }
    faults.within("dynamics.speed_min_mps", table.speed_min_mps, 0.1, 300.0);
    faults.above("dynamics.speed_max_mps", table.speed_max_mps, table.speed_min_mps, 300.0);
    faults.within("dynamics.climb_min_mps", table.climb_min_mps, -100.0, -0.1);
    faults.within("dynamics.climb_max_mps", table.climb_max_mps, 0.1, 100.0);
    faults.within("dynamics.lateral_overload_max", table.lateral_overload_max, 0.1, 20.0);
    faults.within("dynamics.gravity_mps2", table.gravity_mps2, 1.0, 20.0);
}

fn autopilot_and_link(file: &ScenarioFile, faults: &mut Faults) {
    let (autopilot, link) = (&file.autopilot, &file.link);
    faults.within("autopilot.setpoint_timeout_s", autopilot.setpoint_timeout_s, 0.0, 86_400.0);
    faults.within("autopilot.loiter_radius_m", autopilot.loiter_radius_m, 1.0, 10_000.0);
    let rate_max_hz = 0.8 / file.dynamics.integration_step_s;
    for (key, value) in [
        ("autopilot.heartbeat_hz", autopilot.heartbeat_hz),
        ("autopilot.sys_status_hz", autopilot.sys_status_hz),
        ("autopilot.system_time_hz", autopilot.system_time_hz),
        ("autopilot.attitude_hz", autopilot.attitude_hz),
        ("autopilot.global_position_int_hz", autopilot.global_position_int_hz),
        ("autopilot.vfr_hud_hz", autopilot.vfr_hud_hz),
        ("autopilot.local_position_ned_hz", autopilot.local_position_ned_hz),
    ] {
        if rate_max_hz > 0.0 && !(0.0..=rate_max_hz).contains(&value) {
            let wanted = format!("a number from 0 to {rate_max_hz}, 0.8 for each dynamics.integration_step_s");
            faults.add(key, value, wanted);
        }
    }
    if link.host.parse::<std::net::IpAddr>().is_err() {
        faults.add("link.host", format!("{:?}", link.host), "an IP address, such as 127.0.0.1");
    }
    many::ports(file, faults);
    for (key, value) in
        [("link.loss", link.loss), ("link.duplication", link.duplication), ("link.reordering", link.reordering)]
    {
        faults.within(key, value, 0.0, SHARE_MAX);
    }
    faults.within("link.delay_ms", link.delay_ms, 0.0, 60_000.0);
    faults.within("link.jitter_ms", link.jitter_ms, 0.0, 60_000.0);
    if file.output.folder.as_deref().is_some_and(|folder| folder.trim().is_empty()) {
        faults.add("output.folder", "\"\"", "a folder's name");
    }
}

/// No two vehicles in one place, none inside a circle, none out of reach.
pub fn starts(scenario: &Scenario, by_pattern: bool, faults: &mut Faults) {
    let mut add = |index: usize, wanted: String| {
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
            if distance_m < COLLISION_DISTANCE_M {
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
            if clearance_m <= 0.0 {
                let inside_m = -clearance_m;
                add(
                    index,
                    format!("must be outside obstacle {}, {inside_m:.2} m inside whose edge it starts", number + 1),
                );
            }
        }
    }
}
