//! Single responses: from a command that changes a setpoint to the next one, or for so long as it takes to settle.

use super::recording::{Commands, Sample};
use flight_model::wrap_pi;

/// One response of one loop.
#[derive(Clone, Debug)]
pub struct Response {
    /// When the command was given, s.
    pub began_s: f64,
    /// By how much it changed the setpoint.
    pub step: f64,
    /// Time since the command in s and how far the response is, as a share of the step.
    pub points: Vec<(f64, f64)>,
    /// Rate at the beginning, in shares of the step each second.
    pub rate: f64,
    /// Speed over ground at the beginning, m/s.
    pub speed_mps: f64,
}

/// Which responses are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Least change of the setpoint.
    pub step_min: f64,
    /// The loop has to be at rest for so long before, s.
    pub rest_s: f64,
    /// A response is shorter than this, s: what comes later says little.
    pub longest_s: f64,
    /// And longer than this.
    pub shortest_s: f64,
    /// Whether it is an angle.
    pub is_angle: bool,
}

impl Response {
    /// Root mean square of what a model leaves of it, as a share of the step.
    pub fn rms(&self, model: impl Fn(f64) -> f64) -> f64 {
        let left = |&(t_s, share): &(f64, f64)| share - model(t_s);
        let squares: f64 = self.points.iter().map(|point| left(point) * left(point)).sum();
        (squares / self.points.len().max(1) as f64).sqrt()
    }

    /// When it was over, s.
    pub fn ended_s(&self) -> f64 {
        self.began_s + self.points.last().map_or(0.0, |(t_s, _)| *t_s)
    }

    /// How far it is at its end, as a share of the step.
    pub fn end(&self) -> f64 {
        let last = &self.points[self.points.len().saturating_sub(5)..];
        last.iter().map(|(_, share)| share).sum::<f64>() / last.len().max(1) as f64
    }
}

/// The responses to the commands of one loop, while the setpoint `quiet` of another one does not change.
pub fn find(
    samples: &[Sample],
    commands: &Commands,
    quiet: &Commands,
    wanted: &Wanted,
    value: impl Fn(&Sample) -> f64,
) -> Vec<Response> {
    let change = |to: f64, from: f64| if wanted.is_angle { wrap_pi(to - from) } else { to - from };
    let mut responses = Vec::new();
    for (index, &(began_s, target)) in commands.iter().enumerate().skip(1) {
        let (before_s, before) = commands[index - 1];
        let step = change(target, before);
        let next_s = commands.get(index + 1).map_or(f64::INFINITY, |next| next.0);
        let disturbed_s = quiet.iter().map(|(at_s, _)| *at_s).find(|at_s| *at_s > began_s - 3.0);
        let end_s = next_s.min(began_s + wanted.longest_s).min(disturbed_s.unwrap_or(f64::INFINITY));
        if step.abs() < wanted.step_min || began_s - before_s < wanted.rest_s || end_s - began_s < wanted.shortest_s {
            continue;
        }
        let first = samples.partition_point(|sample| sample.t_s <= began_s);
        let last = samples.partition_point(|sample| sample.t_s < end_s);
        // Where it was when the command was given: what was heard over the moment before.
        let rest = &samples[first.saturating_sub(5)..first];
        if rest.is_empty() || last < first + 4 || rest[0].t_s < began_s - 6.0 {
            continue;
        }
        let reference = value(&rest[rest.len() - 1]);
        let mean = |of: &dyn Fn(&Sample) -> f64| rest.iter().map(of).sum::<f64>() / rest.len() as f64;
        let start = reference + mean(&|sample| change(value(sample), reference));
        // A response from another place than the last setpoint is still one: to the setpoint from there.
        let step = if wanted.is_angle { change(target, start) } else { step };
        if step.abs() < wanted.step_min {
            continue;
        }
        // Angles are followed round: a turn of more than half a circle is one way.
        let mut gone = 0.0;
        let mut at = start;
        let points = samples[first..last]
            .iter()
            .map(|sample| {
                gone += change(value(sample), at);
                at = value(sample);
                (sample.t_s - began_s, gone / step)
            })
            .collect();
        responses.push(Response {
            began_s,
            step,
            points,
            rate: mean(&|sample| sample.climb_mps) / step,
            speed_mps: mean(&|sample| sample.speed_mps),
        });
    }
    responses
}
