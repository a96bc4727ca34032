//! The commands that a vehicle has been sent, with the times at which they act.

use flight_model::{Response, Setpoint};
use std::collections::VecDeque;
use std::ops::Range;

/// Commands that acted longer ago than this are forgotten, but for the last one, s.
const KEPT_S: f64 = 3.0;

/// The commands of one vehicle, in the order in which they were sent.
#[derive(Clone, Debug, Default)]
pub struct Commands {
    sent: VecDeque<Command>,
}

#[derive(Clone, Copy, Debug)]
struct Command {
    /// When it comes to the vehicle, s.
    comes_s: f64,
    setpoint: Setpoint,
    is_lost: bool,
}

impl Commands {
    /// A command that comes to the vehicle at a time.
    pub fn push(&mut self, comes_s: f64, setpoint: &Setpoint) {
        self.sent.push_back(Command { comes_s, setpoint: *setpoint, is_lost: false });
    }

    /// All commands come later by this than was thought when they were sent, s.
    pub fn delay(&mut self, by_s: f64) {
        self.sent.iter_mut().for_each(|command| command.comes_s += by_s);
    }

    /// The setpoint that acts at a time, each part after its dead time; none before the first command acts.
    pub fn acting(&self, at_s: f64, response: &Response) -> Option<Setpoint> {
        let [speed, course, altitude] =
            [response.speed_dead_time_s, response.course_dead_time_s, response.altitude_dead_time_s]
                .map(|dead_time_s| self.last_at(at_s - dead_time_s));
        let course = course.or(speed).or(altitude)?;
        Some(Setpoint {
            speed_mps: speed.unwrap_or(course).speed_mps,
            course_rad: course.course_rad,
            altitude_m: altitude.unwrap_or(course).altitude_m,
        })
    }

    fn last_at(&self, at_s: f64) -> Option<Setpoint> {
        // A nanosecond for the rounding of sums of times.
        let has_come = |command: &&Command| !command.is_lost && command.comes_s <= at_s + 1e-9;
        self.sent.iter().rev().find(has_come).map(|command| command.setpoint)
    }

    /// The places of the last commands that act by a time and whose coming can be judged, at most two.
    pub fn acted(&self, at_s: f64, response: &Response) -> Range<usize> {
        let by_s = at_s - response.course_dead_time_s.min(response.speed_dead_time_s);
        let end = self.sent.partition_point(|command| command.comes_s <= by_s);
        // Of the first there is nothing before that would act in its place.
        end.saturating_sub(2).max(1).min(end)..end
    }

    /// Takes the last `lost` commands of some places for lost, and the others for come.
    pub fn assume_lost(&mut self, places: Range<usize>, lost: usize) {
        let first_lost = places.end.saturating_sub(lost);
        for place in places {
            if let Some(command) = self.sent.get_mut(place) {
                command.is_lost = place >= first_lost;
            }
        }
    }

    /// Forgets what no longer acts at a time.
    pub fn forget_before(&mut self, at_s: f64) {
        while self.sent.len() > 4 && self.sent.get(3).is_some_and(|command| command.comes_s < at_s - KEPT_S) {
            self.sent.pop_front();
        }
    }
}
