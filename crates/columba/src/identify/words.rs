//! What is known of vehicles, in words and as an airframe file.

use super::Identified;
use super::fit::{Altitude, Course, Speed, TurnShare};
use std::fmt::Write;

/// What Eq. 1 leaves of a step beyond this does not count as a fit.
const FITS: f64 = 0.05;

/// For a terminal.
pub fn told(identified: &Identified) -> String {
    let mut text = format!("vehicle {}\n", identified.system_id);
    let mut line = |name: &str, words: String| {
        let _ = writeln!(text, "  {name:<9} {words}");
    };
    match &identified.course {
        Ok(course) => {
            line("course", turn(course));
            line("", growth(course));
        }
        Err(missing) => line("course", format!("not known: {missing}")),
    }
    if let Some(hard) = &identified.hard_course {
        let words = turn(hard);
        line("", format!("beyond 50 degrees: {words}"));
    }
    if let Some(share) = &identified.turn_share {
        line("", slip(share));
    }
    match &identified.speed {
        Ok(speed) => {
            line("speed", pace(speed));
            if let Some([north_mps, east_mps]) = speed.wind_mps {
                line("", format!("wind {:.1} m/s", libm::hypot(north_mps, east_mps)));
            }
        }
        Err(missing) => line("speed", format!("not known: {missing}")),
    }
    match &identified.altitude {
        Ok(altitude) => line("altitude", climb(altitude)),
        Err(missing) => line("altitude", format!("not known: {missing}")),
    }
    for note in &identified.notes {
        line("note", note.clone());
    }
    text
}

fn turn(course: &Course) -> String {
    let spread = course.time_constant_spread_s.map_or(String::new(), |spread_s| format!(" +- {spread_s:.2}"));
    format!(
        "tau {:.2}{spread} s, dead time {:.2} s; {}, up to {:.0} degrees; {}",
        course.time_constant_s,
        course.dead_time_s,
        counted(course.responses),
        course.step_max_rad.to_degrees(),
        left(course.rms)
    )
}

fn slip(turn: &TurnShare) -> String {
    let spread = turn.spread.map_or(String::new(), |spread| format!(" +- {spread:.2}"));
    format!("turns by {:.2}{spread} of a coordinated turn; {}", turn.share, counted(turn.responses))
}

fn growth(course: &Course) -> String {
    let speed_mps = course.reference_speed_mps;
    match course.grows_with_speed {
        Some(true) => format!("tau is that at {speed_mps:.1} m/s over ground, and grows with speed"),
        Some(false) => "tau does not grow with speed".to_owned(),
        None => format!("flown at {speed_mps:.1} m/s over ground alone: whether tau grows with speed is not known"),
    }
}

fn pace(speed: &Speed) -> String {
    format!(
        "gain {:.3} +- {:.3}, tau {:.2} s, dead time {:.2} s, overshoot {:.0} %; {}; {}",
        speed.gain,
        speed.gain_error,
        speed.time_constant_s,
        speed.dead_time_s,
        100.0 * speed.overshoot,
        counted(speed.responses),
        left(speed.rms)
    )
}

fn climb(altitude: &Altitude) -> String {
    format!(
        "tau {:.2} and {:.2} s, dead time {:.2} s; {}; {}; climb seen {:.1} to {:.1} m/s",
        altitude.a_s,
        altitude.b_s,
        altitude.dead_time_s,
        counted(altitude.responses),
        left(altitude.rms),
        altitude.climb_min_mps,
        altitude.climb_max_mps
    )
}

fn counted(responses: usize) -> String {
    if responses == 1 { "1 response".to_owned() } else { format!("{responses} responses") }
}

fn left(rms: f64) -> String {
    let verdict = if rms > FITS { ": Eq. 1 does not fit" } else { "" };
    format!("rms {:.1} % of the step{verdict}", 100.0 * rms)
}

/// An airframe file with what is known: what is not stays as the base has it.
pub fn airframe_toml(identified: &Identified, whence: &str) -> String {
    let mut text = format!("# Identified by `columba identify` from {whence}.\n");
    for line in told(identified).lines() {
        let _ = writeln!(text, "# {line}");
    }
    let base = if identified.has_wings { "plane" } else { "paper" };
    let _ = write!(
        text,
        "\n[airframe]\nbase = \"{base}\"\n# A simulated vehicle flies Eq. 1 with these constants; \"plant\": the \
         plant of the base instead,\n# and the controller reckons with these constants.\nflies = \"equation-1\"\n"
    );
    let mut key = |name: &str, value: f64| {
        let _ = writeln!(text, "{name} = {value:.4}");
    };
    if let Ok(course) = &identified.course {
        key("course_time_constant_s", course.time_constant_s.max(0.02));
        key("course_dead_time_s", course.dead_time_s);
        if course.grows_with_speed == Some(true) {
            key("course_reference_speed_mps", course.reference_speed_mps);
        }
    }
    if let Some(turn) = &identified.turn_share {
        key("turn_share", turn.share.clamp(0.1, 3.0));
    }
    if let Ok(speed) = &identified.speed {
        key("speed_gain", speed.gain);
        key("speed_time_constant_s", speed.time_constant_s.max(0.02));
        key("speed_dead_time_s", speed.dead_time_s);
    }
    if let Ok(altitude) = &identified.altitude {
        key("altitude_time_constant_a_s", altitude.a_s.max(0.02));
        key("altitude_time_constant_b_s", altitude.b_s.max(0.02));
        key("altitude_dead_time_s", altitude.dead_time_s);
    }
    text
}
