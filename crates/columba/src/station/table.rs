//! The live table: one line for each vehicle, and one for the flock.

use super::Station;
use super::phase::Phase;
use std::fmt::Write;
use std::time::Duration;

/// The table as it is now, line by line.
pub fn lines(station: &Station, recent_m: [f64; 2], now: Duration) -> Vec<String> {
    let now_s = now.as_secs_f64();
    let mut lines = vec![format!(
        "{:>3} {:>4} {:<16} {:<14} {:>6} {:>6} {:>6} {:>6} {:>7} {:>5}",
        "", "sys", "autopilot", "mode", "age s", "m/s", "alt m", "delay", "lost", "batt"
    )];
    for (index, vehicle) in station.vehicles().iter().enumerate() {
        let number = vehicle.slot().map_or_else(|| "-".to_owned(), |_| (index + 1).to_string());
        let name = vehicle.driver().map_or("unknown", |driver| driver.kind().name());
        let mut mode = vehicle.mode_name();
        if !vehicle.heard().armed {
            mode.push_str(" (disarmed)");
        } else if vehicle.custody().released().is_some() {
            mode.push_str(" (released)");
        } else if vehicle.custody().dropped().is_some() {
            mode.push_str(" (dropped)");
        } else if vehicle.custody().is_paused() {
            mode.push_str(" (paused)");
        }
        let number_or = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
        };
        let state = vehicle.track().last().map(|sample| sample.state);
        let battery = vehicle.heard().battery_percent.map_or_else(|| "-".to_owned(), |percent| format!("{percent} %"));
        lines.push(format!(
            "{number:>3} {:>4} {name:<16} {mode:<14} {:>6} {:>6} {:>6} {:>6} {:>7} {battery:>5}",
            vehicle.id(),
            number_or(vehicle.age_s(now_s), 1),
            number_or(state.map(|state| state.speed_mps), 1),
            number_or(state.map(|state| state.altitude_m), 1),
            number_or(vehicle.clock().delay_s().map(|delay_s| delay_s * 1e3), 0),
            vehicle.frames().1,
        ));
    }
    let mut last = station.phase().name().to_owned();
    if let Phase::Fly(fly) = station.phase() {
        let _ = write!(last, " {:.0} s of {:.0}", fly.flight_s(now), station.scenario.duration.as_secs_f64());
        if fly.is_paused() {
            last.push_str(", paused");
        }
        let metres = |value: f64| if value.is_finite() { format!("{value:.1} m") } else { "-".to_owned() };
        let _ = write!(last, "; separation {}, clearance {}", metres(recent_m[0]), metres(recent_m[1]));
    }
    lines.push(last);
    lines
}
