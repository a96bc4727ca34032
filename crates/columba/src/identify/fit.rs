//! Constants of Eq. 1 with gain and dead times, from responses.

use super::recording::{Commands, Recording};
use super::responses::{Response, Wanted, find};
use super::simplex::minimise;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// The course loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// tau_phi at the reference speed, s.
    pub time_constant_s: f64,
    /// Half of the range over single responses.
    pub time_constant_spread_s: Option<f64>,
    /// Dead time, s.
    pub dead_time_s: f64,
    /// Mean speed of the responses, m/s.
    pub reference_speed_mps: f64,
    /// Whether tau_phi grows in proportion to speed; none: flown at one speed only.
    pub grows_with_speed: Option<bool>,
    /// Of how many responses.
    pub responses: usize,
    /// Root mean square of what is left, as a share of the step.
    pub rms: f64,
    /// Greatest step, rad.
    pub step_max_rad: f64,
}

/// How hard it turns with a bank.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnShare {
    /// Lateral acceleration, as a share of that of a coordinated turn with the same bank.
    pub share: f64,
    /// Half of the range over single turns.
    pub spread: Option<f64>,
    /// Of how many turns.
    pub responses: usize,
}

/// The speed loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Speed {
    /// Speed that it settles on, as a share of the setpoint.
    pub gain: f64,
    /// What the mean of so many samples is uncertain by.
    pub gain_error: f64,
    /// Wind over the flight, (north, east) in m/s; none: not flown in enough directions to tell it from the gain.
    pub wind_mps: Option<[f64; 2]>,
    /// tau_V, s.
    pub time_constant_s: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
    /// Of how many responses.
    pub responses: usize,
    /// Root mean square of what is left, as a share of the step.
    pub rms: f64,
    /// Greatest overshoot, as a share of the step.
    pub overshoot: f64,
}

/// The altitude loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Altitude {
    /// tau_a, s.
    pub a_s: f64,
    /// tau_b, s.
    pub b_s: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
    /// Of how many responses.
    pub responses: usize,
    /// Root mean square of what is left, as a share of the step.
    pub rms: f64,
    /// Fastest climb that was seen, m/s.
    pub climb_max_mps: f64,
    /// Fastest descent, m/s, below zero.
    pub climb_min_mps: f64,
}

/// Standard gravity, m/s2.
const GRAVITY_MPS2: f64 = 9.806_65;
/// A response that ends before this share of the step does not follow.
const FOLLOWS: f64 = 0.5;
/// Steps of altitude beyond this run into the limits of climb, m.
const SMALL_CLIMB_M: f64 = 8.0;

/// Eq. 1 of first order after a dead time, as a share of the step.
fn first_order(t_s: f64, tau_s: f64, dead_s: f64) -> f64 {
    if t_s <= dead_s { 0.0 } else { 1.0 - libm::exp(-(t_s - dead_s) / tau_s) }
}

/// Eq. 1 of second order after a dead time, as a share of the step.
fn second_order(t_s: f64, a_s: f64, b_s: f64, dead_s: f64) -> f64 {
    let t_s = (t_s - dead_s).max(0.0);
    // Where the poles meet, the limit is taken a little beside.
    let b_s = if (a_s - b_s).abs() < 1e-4 { a_s + 1e-4 } else { b_s };
    1.0 - (b_s * libm::exp(-t_s / b_s) - a_s * libm::exp(-t_s / a_s)) / (b_s - a_s)
}

fn mean_square(responses: &[Response], model: impl Fn(&Response, f64) -> f64) -> f64 {
    let sum: f64 = responses.iter().map(|response| square(response.rms(|t_s| model(response, t_s)))).sum();
    sum / responses.len().max(1) as f64
}

/// What lies outside of what a loop can be costs more the further out it is.
fn outside<const N: usize>(values: [f64; N], least: f64) -> f64 {
    values.iter().map(|value| (least - value).max(0.0)).sum()
}

fn follows(responses: Vec<Response>, what: &str, notes: &mut Vec<String>) -> Vec<Response> {
    let (kept, left): (Vec<_>, Vec<_>) = responses.into_iter().partition(|response| response.end() > FOLLOWS);
    for response in left {
        notes.push(format!(
            "{what} at {:.0} s was not followed ({:.0} % of the step): left out",
            response.began_s,
            100.0 * response.end()
        ));
    }
    kept
}

/// The course loop, from turns of a range of degrees.
///
/// # Errors
/// What is missing.
pub fn course(recording: &Recording, steps_deg: Range<f64>, notes: &mut Vec<String>) -> Result<Course, String> {
    const WANTED: Wanted = Wanted { step_min: 0.08, rest_s: 4.0, longest_s: 12.0, shortest_s: 5.0, is_angle: true };
    let all = find(&recording.samples, &recording.course, &Commands::new(), &WANTED, |sample| sample.course_rad);
    let in_range = |response: &Response| steps_deg.contains(&response.step.abs().to_degrees());
    let turns: Vec<Response> = all.into_iter().filter(in_range).collect();
    let turns = follows(turns, "a turn", notes);
    if turns.is_empty() {
        return Err(nothing("turns of 5 to 50 degrees", &recording.course));
    }
    let mean_mps = turns.iter().map(|turn| turn.speed_mps).sum::<f64>() / turns.len() as f64;
    let slowest_mps = turns.iter().map(|turn| turn.speed_mps).fold(f64::INFINITY, f64::min);
    let fastest_mps = turns.iter().map(|turn| turn.speed_mps).fold(0.0, f64::max);
    let fit_of = |turns: &[Response], grows: bool| {
        let cost = |&[tau_s, dead_s]: &[f64; 2]| {
            let tau = |turn: &Response| if grows { tau_s * turn.speed_mps / mean_mps } else { tau_s };
            mean_square(turns, |turn, t_s| first_order(t_s, tau(turn).max(0.02), dead_s.max(0.0)))
                + outside([tau_s, dead_s + 0.02], 0.02)
        };
        minimise([1.5, 0.2], [0.5, 0.1], cost)
    };
    let (constant, growing) = (fit_of(&turns, false), fit_of(&turns, true));
    let has_speeds = fastest_mps > 1.25 * slowest_mps;
    let grows_with_speed = has_speeds.then_some(growing.1 < constant.1);
    let ([time_constant_s, dead_time_s], cost) = if grows_with_speed == Some(true) { growing } else { constant };
    let singles = turns.iter().map(|turn| fit_of(std::slice::from_ref(turn), false).0[0]);
    Ok(Course {
        time_constant_s,
        time_constant_spread_s: spread(singles),
        dead_time_s: dead_time_s.max(0.0),
        reference_speed_mps: mean_mps,
        grows_with_speed,
        responses: turns.len(),
        rms: cost.sqrt(),
        step_max_rad: turns.iter().map(|turn| turn.step.abs()).fold(0.0, f64::max),
    })
}

/// How hard it turns with its bank: what it has turned in whole turns, against what coordinated ones with the same bank
/// would have. Over a whole turn what comes late is there in the end, so that only what stays counts. None where banks
/// came too seldom, or no turn is whole.
pub fn turn_share(recording: &Recording) -> Option<TurnShare> {
    const WANTED: Wanted = Wanted { step_min: 0.15, rest_s: 4.0, longest_s: 12.0, shortest_s: 8.0, is_angle: true };
    /// In harder turns lift comes late as well, and some of it is never there.
    const STEP_MAX_RAD: f64 = 0.9;
    const GAP_MAX_S: f64 = 0.35;
    let turns = find(&recording.samples, &recording.course, &Commands::new(), &WANTED, |sample| sample.course_rad);
    let whole = |turn: &&Response| turn.step.abs() < STEP_MAX_RAD && turn.end() > 0.9;
    let angles: Vec<(f64, f64)> = turns
        .iter()
        .filter(whole)
        .filter_map(|turn| {
            let first = recording.banks.partition_point(|(t_s, _)| *t_s < turn.began_s);
            let end = recording.banks.partition_point(|(t_s, _)| *t_s <= turn.ended_s());
            let banks = recording.banks.get(first..end)?;
            let has_gap = banks.windows(2).any(|pair| pair[1].0 - pair[0].0 > GAP_MAX_S);
            let covered_s = banks.last()?.0 - banks.first()?.0;
            if has_gap || covered_s < turn.ended_s() - turn.began_s - 2.0 * GAP_MAX_S {
                return None;
            }
            let tangent_s: f64 = banks
                .windows(2)
                .map(|pair| 0.5 * (libm::tan(pair[0].1) + libm::tan(pair[1].1)) * (pair[1].0 - pair[0].0))
                .sum();
            Some((turn.end() * turn.step, GRAVITY_MPS2 * tangent_s / turn.speed_mps))
        })
        .collect();
    let (turned_rad, coordinated_rad) =
        angles.iter().fold((0.0, 0.0), |sum, turn| (sum.0 + turn.0.abs(), sum.1 + turn.1 * turn.0.signum()));
    (coordinated_rad > 0.1).then(|| TurnShare {
        share: turned_rad / coordinated_rad,
        spread: spread(angles.iter().map(|turn| turn.0 / turn.1)),
        responses: angles.len(),
    })
}

/// The speed loop: its gain from all that is settled, the rest from steps.
///
/// # Errors
/// What is missing.
pub fn speed(recording: &Recording, notes: &mut Vec<String>) -> Result<Speed, String> {
    const WANTED: Wanted = Wanted { step_min: 0.8, rest_s: 6.0, longest_s: 15.0, shortest_s: 6.0, is_angle: false };
    let (gain, gain_error, wind_mps) = gain(recording)?;
    if wind_mps.is_none() {
        notes.push("not flown in enough directions: a wind would be part of the speed's gain".to_owned());
    }
    let all = find(&recording.samples, &recording.speed, &recording.course, &WANTED, |sample| sample.speed_mps);
    let steps = follows(all, "a speed", notes);
    if steps.is_empty() {
        return Err(nothing("steps of speed of 0.8 m/s or more", &recording.speed));
    }
    let cost = |&[tau_s, dead_s]: &[f64; 2]| {
        mean_square(&steps, |_, t_s| gain * first_order(t_s, tau_s.max(0.02), dead_s.max(0.0)))
            + outside([tau_s, dead_s + 0.02], 0.02)
    };
    let ([time_constant_s, dead_time_s], cost) = minimise([1.0, 0.3], [0.4, 0.1], cost);
    let greatest = |step: &Response| step.points.iter().map(|(_, share)| share / gain - 1.0).fold(0.0, f64::max);
    Ok(Speed {
        gain,
        gain_error,
        wind_mps,
        time_constant_s,
        dead_time_s: dead_time_s.max(0.0),
        responses: steps.len(),
        rms: cost.sqrt(),
        overshoot: steps.iter().map(greatest).fold(0.0, f64::max),
    })
}

/// Settled speed as a share of its setpoint, what that is uncertain by, and the wind: least squares of
/// V = gain V_c + w_n cos(phi) + w_e sin(phi).
fn gain(recording: &Recording) -> Result<(f64, f64, Option<[f64; 2]>), String> {
    const SETTLED_S: f64 = 12.0;
    const TURNED_S: f64 = 9.0;
    let since = |commands: &Commands, t_s: f64| {
        let next = commands.partition_point(|(at_s, _)| *at_s <= t_s);
        next.checked_sub(1).map(|last| (t_s - commands[last].0, commands[last].1))
    };
    let settled: Vec<(f64, [f64; 3])> = recording
        .samples
        .iter()
        .filter_map(|sample| {
            let (speed_s, setpoint_mps) = since(&recording.speed, sample.t_s)?;
            let turned_s = since(&recording.course, sample.t_s).map_or(f64::INFINITY, |(turned_s, _)| turned_s);
            let climbed_s = since(&recording.altitude, sample.t_s).map_or(f64::INFINITY, |(climbed_s, _)| climbed_s);
            let is_settled = speed_s > SETTLED_S && turned_s > TURNED_S && climbed_s > TURNED_S;
            let (east, north) = libm::sincos(sample.course_rad);
            is_settled.then_some((sample.speed_mps, [setpoint_mps, north, east]))
        })
        .collect();
    if settled.len() < 10 {
        return Err(format!(
            "speed: no setpoint was held for {SETTLED_S} s in straight level flight: what it settles on is not known"
        ));
    }
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (speed_mps, row) in &settled {
        let row = Vector3::from(*row);
        normal += row * row.transpose();
        right += row * *speed_mps;
    }
    let alone = right[0] / normal[(0, 0)];
    let count = settled.len() as f64;
    // Directions that span too little leave wind and gain alike.
    let scale = Matrix3::from_diagonal(&Vector3::new((count / normal[(0, 0)]).sqrt(), 1.0, 1.0));
    let least = (scale * normal * scale / count).symmetric_eigenvalues().min();
    let solved = (least > 0.03).then(|| normal.try_inverse()).flatten().map(|inverse| inverse * right);
    let (gain, wind) = solved.map_or((alone, [0.0, 0.0]), |found| (found[0], [found[1], found[2]]));
    let left = |(speed_mps, row): &(f64, [f64; 3])| speed_mps - gain * row[0] - wind[0] * row[1] - wind[1] * row[2];
    let mean_square = settled.iter().map(|sample| square(left(sample))).sum::<f64>() / count;
    let setpoint_mps = (normal[(0, 0)] / count).sqrt();
    // Samples of one stretch hang together: a stretch counts for one.
    let stretches = (count / recording.rate_hz().unwrap_or(1.0) / 3.0).max(1.0);
    Ok((gain, (mean_square / stretches).sqrt() / setpoint_mps, solved.map(|_| wind)))
}

/// The altitude loop, from steps that no limit of climb bends.
///
/// # Errors
/// What is missing.
pub fn altitude(recording: &Recording, notes: &mut Vec<String>) -> Result<Altitude, String> {
    const WANTED: Wanted = Wanted { step_min: 2.0, rest_s: 6.0, longest_s: 15.0, shortest_s: 6.0, is_angle: false };
    let all = find(&recording.samples, &recording.altitude, &recording.course, &WANTED, |sample| sample.altitude_m);
    let all = follows(all, "an altitude", notes);
    let (small, large): (Vec<_>, Vec<_>) = all.into_iter().partition(|step| step.step.abs() <= SMALL_CLIMB_M);
    let steps = if small.is_empty() {
        if !large.is_empty() {
            notes.push(format!("altitude: only steps beyond {SMALL_CLIMB_M} m, in which limits of climb may act"));
        }
        &large
    } else {
        &small
    };
    if steps.is_empty() {
        return Err(nothing("steps of altitude of 2 m or more", &recording.altitude));
    }
    let cost = |&[a_s, b_s, dead_s]: &[f64; 3]| {
        let model = |t_s: f64| second_order(t_s, a_s.max(0.02), b_s.max(0.02), dead_s.max(0.0));
        mean_square(steps, |_, t_s| model(t_s)) + outside([a_s, b_s, dead_s + 0.02], 0.02)
    };
    let ([one_s, other_s, dead_time_s], cost) = minimise([0.5, 2.5, 0.3], [0.3, 1.0, 0.2], cost);
    let climbs = || recording.samples.iter().map(|sample| sample.climb_mps);
    Ok(Altitude {
        a_s: one_s.min(other_s),
        b_s: one_s.max(other_s),
        dead_time_s: dead_time_s.max(0.0),
        responses: steps.len(),
        rms: cost.sqrt(),
        climb_max_mps: climbs().fold(0.0, f64::max),
        climb_min_mps: climbs().fold(0.0, f64::min),
    })
}

fn square(value: f64) -> f64 {
    value * value
}

fn spread(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (least, most, count) = values
        .fold((f64::INFINITY, f64::NEG_INFINITY, 0), |(least, most, count), value: f64| {
            (least.min(value), most.max(value), count + 1)
        });
    (count > 1).then_some(0.5 * (most - least))
}

fn nothing(what: &str, commands: &Commands) -> String {
    match commands.len() {
        0 => format!("no {what}: nothing was commanded"),
        count => {
            format!("no {what} that were held for 5 s or longer after a rest of 4 s ({count} setpoints were commanded)")
        }
    }
}
