//! A flight in plain words: how it ended, and its key figures.

use crate::flight::{Flight, Summary};

/// How a flight ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Completed without collision.
    Success,
    /// Stopped before its end, until then without collision.
    Interrupted,
    /// With a collision or another failure.
    Failure,
}

impl Ending {
    /// How this flight ended.
    pub fn of(summary: &Summary) -> Self {
        let collided = summary.obstacle_collisions > 0 || summary.vehicle_collisions > 0;
        if summary.failure.is_some() || collided || (!summary.success && !summary.interrupted) {
            Self::Failure
        } else if summary.interrupted {
            Self::Interrupted
        } else {
            Self::Success
        }
    }

    /// In a word, and the class that gives it its colour.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            Self::Success => ("Flown", "good"),
            Self::Interrupted => ("Interrupted", "mid"),
            Self::Failure => ("Failed", "bad"),
        }
    }
}

/// The flight in one sentence.
pub fn headline(summary: &Summary) -> String {
    let flock = count(summary.vehicles, "UAV", "UAVs");
    let nearest = nearest(summary);
    let among = if summary.obstacles == 0 {
        String::new()
    } else {
        format!(" among {}", count(summary.obstacles, "obstacle", "obstacles"))
    };
    match Ending::of(summary) {
        Ending::Success if summary.obstacles > 0 && summary.passed_last_obstacle >= summary.vehicles => format!(
            "{flock} passed {} in {} s without collision{nearest}",
            count(summary.obstacles, "obstacle", "obstacles"),
            short(summary.duration_s)
        ),
        Ending::Success if summary.obstacles > 0 => format!(
            "{flock} flew {} s{among} without collision, {} of them past the last obstacle{nearest}",
            short(summary.duration_s),
            summary.passed_last_obstacle
        ),
        Ending::Success => format!("{flock} flew {} s without collision{nearest}", short(summary.duration_s)),
        Ending::Interrupted if summary.duration_s > 0.0 => {
            format!("{flock} had flown {} s{among} when the flight was interrupted{nearest}", short(summary.duration_s))
        }
        Ending::Interrupted => format!("The flight of {flock}{among} was interrupted before it began"),
        Ending::Failure => match &summary.failure {
            Some(failure) => format!("The flight of {flock}{among} failed: {failure}"),
            None => format!(
                "The flight of {flock}{among} failed after {} s: {}",
                short(summary.duration_s),
                faults(summary)
            ),
        },
    }
}

fn faults(summary: &Summary) -> String {
    let faults: Vec<String> = [
        (summary.obstacle_collisions, "collision with an obstacle", "collisions with obstacles"),
        (summary.vehicle_collisions, "collision between UAVs", "collisions between UAVs"),
    ]
    .into_iter()
    .filter(|(number, ..)| *number > 0)
    .map(|(number, one, many)| count(number as usize, one, many))
    .collect();
    if faults.is_empty() { "it did not reach its end".to_owned() } else { faults.join(" and ") }
}

fn nearest(summary: &Summary) -> String {
    let parts = [("separation", summary.min_separation_m), ("clearance", summary.min_clearance_m)];
    let parts: Vec<String> = parts
        .into_iter()
        .filter_map(|(name, least)| {
            least.filter(|least| least.is_finite()).map(|least| format!("smallest {name} {} m", fixed(least, 1)))
        })
        .collect();
    if parts.is_empty() { String::new() } else { format!("; {}", parts.join(", ")) }
}

/// What a controller in real time knew of the present.
fn present_figures(summary: &Summary) -> Vec<KeyFigure> {
    let mut figures = Vec::new();
    if let Some(error_m) = summary.present_figure("state_error_rms_m") {
        let note = "where vehicles were foreseen, against where they flew; root of the mean square".to_owned();
        figures.push(("State error", unit(error_m, 2, "m"), note));
    }
    let delays_s = ["telemetry_delay_s", "command_delay_s"].map(|name| summary.present_mean(name));
    if let [Some(telemetry_s), Some(command_s)] = delays_s {
        let spread_s = summary.present_mean("delay_spread_s").unwrap_or(0.0);
        let note = format!("of telemetry and of commands; spread {}", unit(1e3 * spread_s, 0, "ms"));
        let value = format!("{} and {}", fixed(1e3 * telemetry_s, 0), unit(1e3 * command_s, 0, "ms"));
        figures.push(("Delay of the link", value, note));
    }
    if let Some(lateness) = summary.lateness() {
        let late = summary.present_figure("late_ticks").unwrap_or(0.0);
        figures.push(("Late decisions", format!("{late:.0}"), lateness));
    }
    figures
}

/// A key figure: what it is, its value, and what more there is to say.
pub type KeyFigure = (&'static str, String, String);

/// The figures of the table at the top.
pub fn key_figures(flight: &Flight) -> Vec<KeyFigure> {
    let summary = &flight.summary;
    let at = |at_s: Option<f64>| at_s.map_or_else(String::new, |at_s| format!("at {} s", fixed(at_s, 1)));
    let pair = summary.min_separation_vehicles.map(|[one, other]| format!(", UAVs {one} and {other}"));
    let vehicle = summary.min_clearance_vehicle.map(|vehicle| format!(", UAV {vehicle}"));
    let or_never = |time_s: Option<f64>| time_s.map_or_else(|| "never".to_owned(), |time_s| unit(time_s, 1, "s"));
    let or_none = |metres: Option<f64>| metres.map_or_else(|| "none to measure".to_owned(), |m| unit(m, 2, "m"));
    let no_note = String::new;
    let mut figures = vec![
        (
            "Smallest separation",
            or_none(summary.min_separation_m),
            at(summary.min_separation_at_s) + &pair.unwrap_or_default(),
        ),
        (
            "Smallest clearance",
            or_none(summary.min_clearance_m),
            at(summary.min_clearance_at_s) + &vehicle.unwrap_or_default(),
        ),
        ("Collisions with obstacles", summary.obstacle_collisions.to_string(), no_note()),
        ("Collisions between UAVs", summary.vehicle_collisions.to_string(), no_note()),
        (
            "Losses of separation",
            summary.separation_losses.to_string(),
            format!("below D\u{209b} = {} m", flight.field.safe_distance_m),
        ),
        ("Speed converged", or_never(summary.speed_convergence_s), no_note()),
        ("Course converged", or_never(summary.course_convergence_s), no_note()),
        ("Altitude settled", or_never(summary.altitude_settling_s), no_note()),
        (
            "Speed variation",
            unit(summary.speed_variation_mps, 1, "m/s"),
            "sum of all changes, mean over the flock".to_owned(),
        ),
        (
            "Course variation",
            unit(summary.course_variation_rad, 2, "rad"),
            "sum of all turns, mean over the flock".to_owned(),
        ),
        ("Flock radius", unit(summary.flock_radius_m, 1, "m"), "mean distance from the flock's centre".to_owned()),
        (
            "Flight time",
            unit(summary.duration_s, 1, "s"),
            format!("{} ticks of {} s", flight.trajectory.ticks.len(), short(summary.control_period_s)),
        ),
        (
            "Solve, median",
            unit(summary.solve_us_p50, 0, "\u{b5}s"),
            format!("99th percentile {}", unit(summary.solve_us_p99, 0, "\u{b5}s")),
        ),
        (
            "Real-time factor",
            fixed(summary.real_time_factor, 1),
            format!("{} of wall time", unit(summary.wall_s, 2, "s")),
        ),
    ];
    let chatter = [summary.course_setpoint_change_p99_rad, summary.course_setpoint_change_p99_share];
    if let [Some(change_rad), Some(share)] = chatter {
        let note = format!("a tick, 99th percentile; {} % of a turn of two ticks at most", fixed(100.0 * share, 0));
        figures.push(("Course setpoint changes", unit(change_rad.to_degrees(), 0, "degrees"), note));
    }
    figures.extend(present_figures(summary));
    if summary.obstacles > 0 {
        let passed = format!("{} of {}", summary.passed_last_obstacle, summary.vehicles);
        figures.insert(5, ("Past the last obstacle", passed, no_note()));
    }
    figures
}

/// The counters of the link, one line each; none for a flight in memory.
pub fn link_figures(summary: &Summary) -> Vec<(String, String)> {
    let Some(counters) = summary.link.as_object() else { return Vec::new() };
    let text = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    counters.iter().map(|(name, value)| (name.clone(), text(value))).collect()
}

fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// A number with a real minus sign; a dash for what is no number.
fn fixed(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}").replace('-', "\u{2212}") } else { "\u{2013}".to_owned() }
}

fn unit(value: f64, decimals: usize, unit: &str) -> String {
    format!("{} {unit}", fixed(value, decimals))
}

/// At most three decimals, none of them superfluous.
fn short(value: f64) -> String {
    let text = fixed(value, 3);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flown() -> Summary {
        Summary {
            vehicles: 5,
            obstacles: 7,
            passed_last_obstacle: 5,
            duration_s: 42.0,
            completed: true,
            success: true,
            min_separation_m: Some(4.123),
            ..Summary::default()
        }
    }

    #[test]
    fn a_flight_without_fault() {
        assert_eq!(
            headline(&flown()),
            "5 UAVs passed 7 obstacles in 42 s without collision; smallest separation 4.1 m"
        );
        let short_of = Summary { passed_last_obstacle: 3, ..flown() };
        assert!(
            headline(&short_of)
                .starts_with("5 UAVs flew 42 s among 7 obstacles without collision, 3 of them past the last obstacle")
        );
        let alone = Summary { vehicles: 1, obstacles: 0, min_separation_m: None, duration_s: 12.5, ..flown() };
        assert_eq!(headline(&alone), "1 UAV flew 12.5 s without collision");
    }

    #[test]
    fn where_there_is_no_obstacle_nobody_is_past_one() {
        let named = |obstacles| {
            let flight = Flight { summary: Summary { obstacles, ..flown() }, ..Flight::default() };
            key_figures(&flight).into_iter().any(|(name, ..)| name == "Past the last obstacle")
        };
        assert!(named(7) && !named(0));
    }

    #[test]
    fn a_failure_says_what_and_when() {
        let failed = Summary { success: false, failure: Some("UAV 3 entered obstacle 2 at 17.4 s".into()), ..flown() };
        assert_eq!(Ending::of(&failed), Ending::Failure);
        assert!(headline(&failed).ends_with("failed: UAV 3 entered obstacle 2 at 17.4 s"));
        let unnamed = Summary { success: false, obstacle_collisions: 1, vehicle_collisions: 2, ..flown() };
        assert!(headline(&unnamed).ends_with("1 collision with an obstacle and 2 collisions between UAVs"));
    }

    #[test]
    fn a_collision_outweighs_an_interruption() {
        let stopped = Summary { success: false, interrupted: true, ..flown() };
        assert_eq!(Ending::of(&stopped), Ending::Interrupted);
        assert_eq!(Ending::of(&Summary { obstacle_collisions: 1, ..stopped.clone() }), Ending::Failure);
        let at_once = Summary { duration_s: 0.0, min_separation_m: None, ..stopped };
        assert_eq!(headline(&at_once), "The flight of 5 UAVs among 7 obstacles was interrupted before it began");
    }

    #[test]
    fn counters_are_listed_and_no_number_is_a_dash() {
        let summary = Summary { link: serde_json::json!({ "lost": 3, "name": "udp" }), ..flown() };
        assert_eq!(link_figures(&summary), [("lost".into(), "3".into()), ("name".into(), "udp".into())]);
        assert!(link_figures(&flown()).is_empty());
        assert_eq!(fixed(f64::INFINITY, 1), "\u{2013}");
        assert_eq!(fixed(-1.25, 1), "\u{2212}1.2");
    }
}
