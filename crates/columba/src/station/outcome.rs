//! What a flight came to: the same value that a simulated flight leaves, from telemetry alone.

use super::phase::fly::log::{Logged, UNKNOWN};
use super::phase::fly::{Flown, Timing};
use super::told::Weight;
use super::{Station, number};
use crate::chatter::with_chatter;
use crate::flight::{Flight, Row, Summary, Tick, Trajectory};
use crate::flying::{self, field, judged, settings};
use crate::judge::Verdict;
use crate::prediction::with_prediction;
use flight_model::Setpoint;
use serde_json::json;
use std::time::Duration;

/// A least distance that may be wrong by more than this is told to be so, m.
const UNCERTAINTY_TOLD_M: f64 = 2.0;
/// A vehicle that was not seen for longer is told as lost, s.
const UNSEEN_TOLD_S: f64 = 3.0;

/// The flight as it is to be written. `links` are the counters of the links.
pub fn flight(mut station: Station, wall: Duration, links: serde_json::Value) -> Flight {
    let now_s = wall.as_secs_f64();
    let flown = station.take_flown();
    let (completed, timing, logged) = match flown {
        Some(Flown { completed, timing, logged }) => (completed, Some(timing), Some(logged)),
        None => (false, None, None),
    };
    let unseen_s = logged.as_ref().map_or(&[][..], |logged| &logged.unseen_s);
    for (index, unseen_s) in unseen_s.iter().enumerate().filter(|(_, unseen_s)| **unseen_s > UNSEEN_TOLD_S) {
        let text = format!("was not seen for {unseen_s:.1} s of the flight");
        station.told.once(now_s, Some(number(index)), "lost", Weight::Fault, text);
    }
    if let Some(logged) = &logged {
        tell_uncertainty(&mut station, logged, now_s);
    }
    let vehicles = vehicles(&station, unseen_s);
    let grounds = logged.as_ref().map(|logged| logged.grounds);
    let present = timing.as_ref().map_or(serde_json::Value::Null, |timing| present(&station, timing));
    let mut solves = timing.map(|timing| timing.solves).unwrap_or_default();
    let (verdict, trajectory) = match logged {
        Some(Logged { verdict, trajectory, .. }) => (verdict, trajectory),
        None => (Verdict::default(), on_the_spot(&station)),
    };
    let duration_s = trajectory.ticks.last().map_or(0.0, |tick| tick.t_s);
    let stop = station.stopped().cloned();
    let interrupted = stop.as_ref().is_some_and(|stop| stop.wished) && !completed;
    let failure = failure(&station, &verdict, completed, duration_s);
    let collisions = verdict.obstacle_collisions + verdict.vehicle_collisions;
    let dry = station.settings.dry_run;
    let success = (completed || dry) && collisions == 0 && failure.is_none();
    let scenario = &station.scenario;
    let summary = Summary {
        duration_s,
        completed,
        interrupted,
        success,
        failure,
        solve_us_p50: solves.percentile_us(0.50),
        solve_us_p99: solves.percentile_us(0.99),
        wall_s: now_s,
        real_time_factor: if now_s > 0.0 { duration_s / now_s } else { 0.0 },
        link: links,
        present,
        station: json!({
            "events": station.told.events(),
            "vehicles": vehicles,
            "at_end": station.settings.at_end,
            "separation_rests_on": grounds.map(|grounds| grounds[0]),
            "clearance_rests_on": grounds.map(|grounds| grounds[1]),
            "origin": {
                "latitude_deg": station.frame.origin().latitude_deg,
                "longitude_deg": station.frame.origin().longitude_deg,
                "altitude_amsl_m": station.frame.origin().altitude_amsl_m,
            },
        }),
        ..judged(&verdict, planned(&station))
    };
    let dynamics = scenario.flock_settings().dynamics;
    let flight = Flight { field: field(scenario), settings: settings(scenario), summary, trajectory, dynamics };
    with_chatter(with_prediction(flight))
}

/// What is known of a flight before it: the header of its journal.
pub fn planned(station: &Station) -> Summary {
    flying::planned(&station.scenario, "real-time")
}

/// What went wrong first, in words.
fn failure(station: &Station, verdict: &Verdict, completed: bool, duration_s: f64) -> Option<String> {
    let event = station.told.first_fault().map(|event| match event.vehicle {
        Some(vehicle) => format!("vehicle {vehicle} {}", event.text),
        None => event.text.clone(),
    });
    let stopped = station.stopped().filter(|_| !completed).map(|stop| format!("{} at {duration_s:.1} s", stop.why));
    let faults = station.told.events().iter().filter(|event| event.weight == Weight::Fault).count();
    let failure = verdict.failure.clone().or(event).or(stopped);
    match failure {
        Some(failure) if faults > 1 => Some(format!("{failure} (and {} faults more)", faults - 1)),
        other => other,
    }
}

/// Tells which least distance may be far off.
fn tell_uncertainty(station: &mut Station, logged: &Logged, now_s: f64) {
    let Logged { verdict, grounds: [separation, clearance], .. } = logged;
    let least = [
        ("separation", verdict.separation.map(|least| least.value_m), separation),
        ("clearance", verdict.clearance.map(|least| least.value_m), clearance),
    ];
    for (what, value_m, ground) in least {
        let Some(value_m) = value_m.filter(|_| ground.uncertainty_m > UNCERTAINTY_TOLD_M) else { continue };
        let text = format!(
            "the least {what} of {value_m:.1} m may be wrong by {:.1} m: clocks or telemetry stood still",
            ground.uncertainty_m
        );
        station.told.once(now_s, None, what, Weight::Warning, text);
    }
}

/// What is known of each vehicle at the end.
fn vehicles(station: &Station, unseen: &[f64]) -> Vec<serde_json::Value> {
    let describe = |index: usize| {
        let vehicle = &station.vehicles[index];
        let (clock, wind_mps) = (vehicle.clock(), vehicle.present().wind_mps());
        let (came, lost) = vehicle.frames();
        json!({
            "vehicle": number(index),
            "system_id": vehicle.id(),
            "autopilot": vehicle.driver().map(|driver| driver.kind().name()),
            "version": vehicle.version().map(|version| version.to_string()),
            "uid": vehicle.uid(),
            "mode": vehicle.mode_name(),
            "armed": vehicle.heard().armed,
            "released": vehicle.custody().released(),
            "unseen_s": unseen.get(index),
            "delay_ms": clock.delay_s().map(|delay_s| delay_s * 1e3),
            "jitter_ms": clock.jitter_s().map(|jitter_s| jitter_s * 1e3),
            "clock_drift": clock.drift(),
            "wind_north_mps": wind_mps.map(|wind| wind.x),
            "wind_east_mps": wind_mps.map(|wind| wind.y),
            "battery_percent": vehicle.heard().battery_percent,
            "frames": came,
            "frames_lost": lost,
            "limits": vehicle.limits(),
        })
    };
    station.crew().map(describe).collect()
}

/// What was known of the present: the same names as of a flight by `columba run`.
fn present(station: &Station, timing: &Timing) -> serde_json::Value {
    let describe = |index: usize| {
        let (clock, present) = (station.vehicles[index].clock(), station.vehicles[index].present());
        let foreseen = present.foreseen_error_m();
        let jitter_s = clock.jitter_s().unwrap_or(0.0);
        json!({
            "vehicle": number(index),
            "telemetry_delay_s": clock.delay_s().map(|least_s| least_s + jitter_s),
            "command_delay_s": clock.command_delay_s(),
            "delay_spread_s": clock.delay_spread_s(),
            "clock_drift": clock.drift(),
            "foreseen_error_along_m": foreseen.map(|[along_m, _]| along_m),
            "foreseen_error_across_m": foreseen.map(|[_, across_m]| across_m),
            "speed_bias_mps": present.speed_bias_mps(),
        })
    };
    let vehicles: Vec<serde_json::Value> = station.crew().map(describe).collect();
    json!({
        "ticks": timing.ticks,
        "late_ticks": timing.late_ticks,
        "worst_late_s": timing.worst_late_s,
        "vehicles": vehicles,
    })
}

/// A flight that did not begin: one tick, with where the vehicles stand.
fn on_the_spot(station: &Station) -> Trajectory {
    let mut trajectory = Trajectory::new(station.scenario.starts.len());
    let none = Setpoint { speed_mps: f64::NAN, course_rad: f64::NAN, altitude_m: f64::NAN };
    let rows = (0..trajectory.vehicles).map(|index| {
        let vehicle = station.vehicles.get(index).filter(|vehicle| vehicle.slot() == Some(index));
        let state = vehicle.and_then(|vehicle| vehicle.track().last()).map(|sample| sample.state);
        Row { state: state.unwrap_or(UNKNOWN), setpoint: none, alpha: [f64::NAN; 3] }
    });
    let rows: Vec<Row> = rows.collect();
    let tick = Tick { t_s: 0.0, min_separation_m: f64::NAN, min_clearance_m: f64::NAN, solve_us: 0.0 };
    trajectory.push(tick, rows);
    trajectory
}
