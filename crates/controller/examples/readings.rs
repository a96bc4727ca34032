//! What each reading is worth: flies the same random fields with several settings and prints a table, the one of
//! docs/reading.md. `cargo run --release -p controller --example readings [FIELDS] [VEHICLES]`

#[path = "../tests/flight/mod.rs"]
mod flight;

use controller::{ControllerSettings, FlockSettings, ForecastKind, WeightKind};
use flight::{Flown, field, fly};
use rayon::prelude::*;

/// Ticks of a flight: 46 s, enough for the last circle at 330 m.
const TICKS: u64 = 92;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>().ok());
    let fields = arguments.next().flatten().unwrap_or(200);
    let vehicles = arguments.next().flatten().unwrap_or(12) as usize;
    println!(
        "{fields} random fields, {vehicles} vehicles, starts at least 5 m apart and up to 46 degrees off course\n"
    );
    let columns = "hit an obstacle | collided | lost separation | median least separation, m | clearance, m";
    println!("| settings | {columns} | spread at the end, m | turned, rad |");
    println!("|---|---|---|---|---|---|---|---|");
    for (name, controller) in variants() {
        let flown: Vec<Flown> = (1..=fields)
            .into_par_iter()
            .map(|seed| {
                let (settings, starts) = field(seed, vehicles);
                fly(&FlockSettings { controller: controller.clone(), ..settings }, &starts, TICKS)
            })
            .collect();
        let count = |holds: &dyn Fn(&Flown) -> bool| flown.iter().filter(|flight| holds(flight)).count();
        println!(
            "| {name} | {} | {} | {} | {:.2} | {:.2} | {:.0} | {:.2} |",
            count(&|flight| flight.min_clearance_m < 0.0),
            count(&|flight| flight.min_separation_m < 1.0),
            count(&|flight| flight.min_separation_m < 2.0),
            median(&flown, |flight| flight.min_separation_m),
            median(&flown, |flight| flight.min_clearance_m),
            median(&flown, spread_m),
            median(&flown, turned_rad),
        );
    }
}

fn variants() -> Vec<(&'static str, ControllerSettings)> {
    let mut plain = ControllerSettings::paper();
    plain.weights.kind = WeightKind::PerTerm;
    let mut law = plain.clone();
    law.look_ahead.forecast = ForecastKind::Law;
    let mut evasion = plain.clone();
    evasion.look_ahead.evasion = true;
    let mut both = evasion.clone();
    both.look_ahead.forecast = ForecastKind::Law;
    let mut held = both.clone();
    held.weights.min = 0.2;
    let mut narrow = held.clone();
    narrow.law.obstacle_margin_m = ControllerSettings::default().law.obstacle_margin_m;
    let mut costly = held.clone();
    costly.law.velocity_cost_s = ControllerSettings::default().law.velocity_cost_s;
    vec![
        ("preset `literal`", ControllerSettings::literal()),
        ("preset `paper`", ControllerSettings::paper()),
        ("`kind = \"per-term\"`", plain),
        ("with `forecast = \"law\"`", law),
        ("with `evasion = true`", evasion),
        ("with both", both),
        ("with both and `min = 0.2`", held),
        ("with these and `obstacle_margin_m = 1.5`", narrow),
        ("with these and `velocity_cost_s = 0.25`", costly),
        ("with all five: the default", ControllerSettings::default()),
    ]
}

fn median(flown: &[Flown], value: impl Fn(&Flown) -> f64) -> f64 {
    let mut values: Vec<f64> = flown.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// How far to the side of the flock's middle the outermost vehicle ends.
fn spread_m(flown: &Flown) -> f64 {
    let mean_m = flown.states.iter().map(|state| state.y_m).sum::<f64>() / flown.states.len() as f64;
    flown.states.iter().map(|state| (state.y_m - mean_m).abs()).fold(0.0, f64::max)
}

/// How much a vehicle is told to turn in all, on average.
fn turned_rad(flown: &Flown) -> f64 {
    let vehicles = flown.states.len();
    let turns = flown.decisions.windows(2).flat_map(|pair| {
        pair[0]
            .iter()
            .zip(&pair[1])
            .map(|(a, b)| flight_model::wrap_pi(b.setpoint.course_rad - a.setpoint.course_rad).abs())
    });
    turns.sum::<f64>() / vehicles as f64
}
