//! What a run leaves behind: the one value that the record and the report are written from.
//!
//! Lengths are metres in the scenario's local frame (X north, Y east), angles radians, times seconds since the start of
//! the flight unless a name says otherwise.

use flight_model::{Dynamics, Setpoint, State};
use serde::{Deserialize, Deserializer, Serialize};

/// One flight, over: how it ended, where it flew, with which settings, and every tick of it.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// The figures of `summary.json`.
    pub summary: Summary,
    /// What stood in the way, and what was asked of the flock.
    pub field: Field,
    /// Which reading of the paper flew, as name and value, in the order in which the report shows them.
    pub settings: Vec<Setting>,
    /// Every tick.
    pub trajectory: Trajectory,
    /// The model that the controller reckoned with: one entry for each vehicle, a single one for all, or none that is
    /// known.
    pub dynamics: Vec<Dynamics>,
}

/// The field that the flock crosses and the yardsticks it is judged by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// The circles to keep out of.
    pub obstacles: Vec<Obstacle>,
    /// The expected speed, course and altitude of the flock.
    pub expected: Setpoint,
    /// D_s: two vehicles nearer than this have lost separation, m.
    pub safe_distance_m: f64,
    /// Two vehicles nearer than this have collided, m.
    pub collision_distance_m: f64,
}

/// A circle that no vehicle's centre may enter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Obstacle {
    /// Centre, north of the origin, m.
    pub x_m: f64,
    /// Centre, east of the origin, m.
    pub y_m: f64,
    /// Radius, m.
    pub radius_m: f64,
}

/// One setting that flew.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Setting {
    /// Its name as in the scenario file, e.g. `optimizer.generations`.
    pub name: String,
    /// Its value as it would be written there.
    pub value: String,
}

/// Every tick of a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// How many vehicles flew.
    pub vehicles: usize,
    /// One entry for each tick, in order of time.
    pub ticks: Vec<Tick>,
    /// Tick-major: `rows[tick * vehicles + vehicle]`.
    pub rows: Vec<Row>,
}

/// What is true of the whole flock at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Time since the start, s.
    pub t_s: f64,
    /// Least horizontal distance between two vehicles over the interval that ends at `t_s`, at every integration step,
    /// m. Infinite when there is only one vehicle.
    pub min_separation_m: f64,
    /// Least horizontal distance from a vehicle's centre to the edge of a circle over the same interval, m; negative
    /// inside a circle. Infinite when there is no obstacle.
    pub min_clearance_m: f64,
    /// Wall time that one vehicle's solve took at this tick, the mean over the flock, us. Reported, never recorded: it
    /// is not the same from run to run.
    pub solve_us: f64,
}

/// One vehicle at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Where it was.
    pub state: State,
    /// What it was then asked to do.
    pub setpoint: Setpoint,
    /// The alpha that the optimiser chose for the formation, obstacle and neighbour-velocity terms (Eq. 5, 7, 8).
    pub alpha: [f64; 3],
}

/// `summary.json`: the figures of a flight by stable names. A name, once published, keeps its meaning and its unit.
///
/// What did not happen or does not exist is `null` (`None`): the least separation of a single vehicle, the time at
/// which a speed converged that never did. Numbers that JSON cannot hold, infinities and NaN, are written as `null`
/// too.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The scenario's name.
    pub scenario: String,
    /// The seed of every random number.
    pub seed: u64,
    /// The optimiser: `mslpio`, `slpio`, `mpio` or `nsga2`.
    pub algorithm: String,
    /// The reading of the paper that the settings started from.
    pub preset: String,
    /// How setpoints reached the vehicles: `memory`, `lockstep` or `real-time`.
    pub transport: String,
    /// How many vehicles flew.
    pub vehicles: usize,
    /// How many circles stood in the field.
    pub obstacles: usize,
    /// Simulated time flown, s.
    pub duration_s: f64,
    /// Control period T, s.
    pub control_period_s: f64,
    /// Whether the flight reached the scenario's end.
    pub completed: bool,
    /// Whether someone stopped it.
    pub interrupted: bool,
    /// Whether it was flown without a collision or another failure.
    pub success: bool,
    /// What failed, and when; `null` if nothing did.
    pub failure: Option<String>,
    /// How many times a vehicle entered a circle.
    pub obstacle_collisions: u32,
    /// How many times two vehicles came within the collision distance.
    pub vehicle_collisions: u32,
    /// How many times two vehicles came within D_s.
    pub separation_losses: u32,
    /// Least distance from a vehicle to the edge of a circle, m; negative inside.
    pub min_clearance_m: Option<f64>,
    /// When that was, s.
    pub min_clearance_at_s: Option<f64>,
    /// Whose it was, as [`vehicle_number`].
    pub min_clearance_vehicle: Option<u32>,
    /// Least distance between two vehicles, m.
    pub min_separation_m: Option<f64>,
    /// When that was, s.
    pub min_separation_at_s: Option<f64>,
    /// Between whom, as [`vehicle_number`]s.
    pub min_separation_vehicles: Option<[u32; 2]>,
    /// How many vehicles were past the far edge of the last circle at the end.
    pub passed_last_obstacle: usize,
    /// From when on every vehicle kept within 0.2 m/s of the expected speed, s.
    pub speed_convergence_s: Option<f64>,
    /// From when on every vehicle kept within 0.02 rad of the expected course, s.
    pub course_convergence_s: Option<f64>,
    /// From when on every vehicle kept its altitude, s.
    pub altitude_settling_s: Option<f64>,
    /// How much a vehicle's speed changed in all, up and down; the mean over the flock, m/s.
    pub speed_variation_mps: f64,
    /// How much a vehicle turned in all, left and right; the mean over the flock, rad.
    pub course_variation_rad: f64,
    /// How far vehicles were from the flock's centre; the mean over the flock and the flight, m.
    pub flock_radius_m: f64,
    /// The same at the end of the flight, m.
    pub flock_radius_end_m: f64,
    /// Median wall time of one vehicle's solve, us.
    #[serde(deserialize_with = "null_is_nan")]
    pub solve_us_p50: f64,
    /// 99th percentile of the same, us.
    #[serde(deserialize_with = "null_is_nan")]
    pub solve_us_p99: f64,
    /// Wall time of the flight, s.
    #[serde(deserialize_with = "null_is_nan")]
    pub wall_s: f64,
    /// Simulated seconds flown in a second of wall time.
    #[serde(deserialize_with = "null_is_nan")]
    pub real_time_factor: f64,
    /// Counters of the link, as an object; `null` for a run in memory.
    #[serde(default)]
    pub link: serde_json::Value,
    /// What a controller in real time knew of the present: delays, ages, errors, and decisions that came late; `null`
    /// where time is simulated in step with the controller.
    #[serde(default)]
    pub present: serde_json::Value,
    /// Root mean square of the distances at ticks from where the controller's model has a vehicle, from its state 3 s
    /// before and the setpoints since then, m; `null` where that is not known.
    #[serde(default)]
    pub prediction_rms_m: Option<f64>,
    /// 99th percentile of the changes of a vehicle's course setpoint from one tick to the next, rad; `null` where that
    /// is not known.
    #[serde(default)]
    pub course_setpoint_change_p99_rad: Option<f64>,
    /// The same of each change as a share of what the vehicle turns in two ticks at most.
    #[serde(default)]
    pub course_setpoint_change_p99_share: Option<f64>,
    /// What a ground station knows of a flight with vehicles that keep their own time: events, vehicles, and what the
    /// least distances rest on; `null` for others.
    #[serde(default)]
    pub station: serde_json::Value,
    /// The version of Columba that flew.
    pub version: String,
}

impl Summary {
    /// A figure of what a controller in real time knew of the present.
    pub fn present_figure(&self, name: &str) -> Option<f64> {
        self.present.get(name)?.as_f64()
    }

    /// The mean over the vehicles of such a figure.
    pub fn present_mean(&self, name: &str) -> Option<f64> {
        let vehicles = self.present.get("vehicles")?.as_array()?;
        let values: Vec<f64> = vehicles.iter().filter_map(|vehicle| vehicle.get(name)?.as_f64()).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    /// Which decisions came late, in words; none where all were in time.
    pub fn lateness(&self) -> Option<String> {
        let [ticks, late, missed] =
            ["ticks", "late_ticks", "missed_ticks"].map(|name| self.present_figure(name).unwrap_or(0.0));
        let worst_s = self.present_figure("worst_late_s").unwrap_or(0.0);
        (late > 0.0).then(|| {
            format!(
                "{late:.0} of {ticks:.0} decisions came late, by up to {worst_s:.2} s, and {missed:.0} of these only \
                 after the next one was due: the machine cannot keep up"
            )
        })
    }
}

/// The number under which a vehicle goes in everything that is written for people and their scripts: one for the first.
pub fn vehicle_number(index: usize) -> u32 {
    u32::try_from(index).map_or(u32::MAX, |index| index.saturating_add(1))
}

impl Trajectory {
    /// An empty record of a flock, to which ticks are added with [`Trajectory::push`].
    pub fn new(vehicles: usize) -> Self {
        Self { vehicles, ..Self::default() }
    }

    /// Adds a tick with one row for each vehicle, in order. Rows too many are dropped and rows too few filled up with
    /// zeros, so that the layout always holds.
    pub fn push(&mut self, tick: Tick, rows: impl IntoIterator<Item = Row>) {
        self.ticks.push(tick);
        self.rows.extend(rows.into_iter().take(self.vehicles));
        self.rows.resize(self.ticks.len().saturating_mul(self.vehicles), Row::default());
    }

    /// Every tick with its rows, one for each vehicle.
    pub fn iter(&self) -> impl Iterator<Item = (&Tick, &[Row])> {
        let rows = move |tick: usize| {
            let start = tick.saturating_mul(self.vehicles);
            self.rows.get(start..start.saturating_add(self.vehicles)).unwrap_or_default()
        };
        self.ticks.iter().enumerate().map(move |(index, tick)| (tick, rows(index)))
    }

    /// One vehicle's flight, as time and row.
    pub fn vehicle(&self, index: usize) -> impl Iterator<Item = (f64, &Row)> {
        self.iter().filter_map(move |(tick, rows)| rows.get(index).map(|row| (tick.t_s, row)))
    }
}

fn null_is_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(t_s: f64) -> Tick {
        Tick { t_s, min_separation_m: f64::INFINITY, min_clearance_m: f64::INFINITY, solve_us: 0.0 }
    }

    #[test]
    fn rows_are_found_by_tick_and_vehicle() {
        let mut trajectory = Trajectory::new(2);
        for step in 0..3 {
            let row = |y_m| Row { state: State { x_m: f64::from(step), y_m, ..State::default() }, ..Row::default() };
            trajectory.push(tick(f64::from(step)), [row(0.0), row(7.0)]);
        }
        assert_eq!(trajectory.rows.len(), 6);
        let second: Vec<(f64, f64, f64)> =
            trajectory.vehicle(1).map(|(t_s, row)| (t_s, row.state.x_m, row.state.y_m)).collect();
        assert_eq!(second, [(0.0, 0.0, 7.0), (1.0, 1.0, 7.0), (2.0, 2.0, 7.0)]);
    }

    #[test]
    fn a_tick_with_too_few_or_too_many_rows_keeps_the_layout() {
        let mut trajectory = Trajectory::new(2);
        trajectory.push(tick(0.0), [Row::default()]);
        trajectory.push(tick(1.0), [Row::default(); 5]);
        assert_eq!(trajectory.rows.len(), 4);
        assert!(trajectory.iter().all(|(_, rows)| rows.len() == 2));
    }

    #[test]
    fn no_vehicles_and_missing_rows_are_not_a_panic() {
        assert_eq!(Trajectory::new(0).vehicle(0).count(), 0);
        let torn = Trajectory { vehicles: 2, ticks: vec![tick(0.0)], rows: vec![Row::default()] };
        assert_eq!(torn.vehicle(0).count(), 0);
    }
}
