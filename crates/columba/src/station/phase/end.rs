//! Last phase: nobody is left alone. On completion, failure and Ctrl-C alike every vehicle is brought into the mode in
//! which it is to stay, and that it is in it is seen, and told.
//!
//! Planes that circle where they are would meet, so each is given a height of its own. At the end of a flight they
//! change heights first, while the law still steers. An end that somebody wishes comes at once: they circle, and change
//! heights while they do.

use super::Phase;
use super::fly::Fly;
use super::gather::Gather;
use crate::station::told::Weight;
use crate::station::{Station, number};
use mavlink_bridge::dialect::MavCmd;
use mavlink_bridge::kind::{AtEnd, command_long};
use std::time::Duration;

/// So long the change of heights may take.
const SPREAD: Duration = Duration::from_secs(12);
/// A vehicle at its height within this is there, m.
const HEIGHT_M: f64 = 3.0;
/// So long the answer to a change of heights is waited for, where a plane circles already.
const HEIGHT_PATIENCE: Duration = Duration::from_secs(8);
/// So long a mode may take.
const PATIENCE: Duration = Duration::from_secs(12);
/// What was flown at the very end is heard by then.
const LISTEN: Duration = Duration::from_secs(1);

/// Leaves every vehicle as it is to be left.
pub struct End {
    fly: Option<Box<Fly>>,
    began: Duration,
    /// Heights to which planes change before they circle.
    heights: Option<Gather>,
    /// Heights to which planes change while they circle.
    circles: Option<Gather>,
    ordered: Option<Duration>,
}

impl End {
    pub(super) fn new(fly: Option<Box<Fly>>, now: Duration) -> Self {
        Self { fly, began: now, heights: None, circles: None, ordered: None }
    }

    pub(super) fn step(mut self: Box<Self>, station: &mut Station, now: Duration) -> Phase {
        if let Some(fly) = &mut self.fly {
            fly.settle(station, now);
        }
        if self.ordered.is_none() && self.spread(station, now) {
            return Phase::End(self);
        }
        let ordered = *self.ordered.get_or_insert(now);
        let mut waiting = Vec::new();
        for index in station.crew() {
            if self.leave(station, index, now) {
                waiting.push(index);
            }
        }
        let since = now.saturating_sub(ordered);
        let is_late = since > PATIENCE;
        if (!waiting.is_empty() && !is_late) || since < LISTEN {
            return Phase::End(self);
        }
        for index in waiting {
            let vehicle = &station.vehicles[index];
            let answer = vehicle.orders().answer("end").unwrap_or("no answer");
            let text = format!("was not seen to end as it should: it is in {}, {answer}", vehicle.mode_name());
            station.told.tell(now.as_secs_f64(), Some(number(index)), Weight::Fault, text);
        }
        if let Some(fly) = &mut self.fly {
            fly.last(station, now);
        }
        Phase::Over(self.fly)
    }

    /// Changes heights; whether that still takes time.
    fn spread(&mut self, station: &mut Station, now: Duration) -> bool {
        let at_end = station.settings.at_end;
        let Some(fly) = self.fly.as_mut().filter(|_| at_end != AtEnd::Continue) else { return false };
        station.watch_modes(fly.is_paused(), now);
        let planes: Vec<usize> = station
            .crew()
            .filter(|&index| {
                let vehicle = &station.vehicles[index];
                vehicle.is_ours() && vehicle.follows() && vehicle.driver().is_some_and(|driver| !driver.kind().hovers())
            })
            .collect();
        let wished = station.stopped().is_some_and(|stop| stop.wished);
        if wished || planes.len() < 2 || fly.is_paused() || now.saturating_sub(self.began) > SPREAD {
            return false;
        }
        let heights = self.heights.get_or_insert_with(|| heights(station, now));
        let is_there = planes.iter().all(|&index| {
            let state = station.state_now(index, now);
            state.is_none_or(|state| (state.altitude_m - heights.layer_m(index)).abs() < HEIGHT_M)
        });
        if is_there {
            return false;
        }
        let heights = heights.clone();
        fly.steer(station, Some(&|index| heights.layer_m(index)), now);
        true
    }

    /// Orders a vehicle to its last mode; whether it is still to be waited for.
    fn leave(&mut self, station: &mut Station, index: usize, now: Duration) -> bool {
        let vehicle = &station.vehicles[index];
        let Some(driver) = vehicle.driver().cloned() else { return false };
        // What the operator wished for this one alone counts more.
        let sent_to = vehicle.custody().dropped().filter(|to| *to != AtEnd::Loiter);
        let at_end = sent_to.unwrap_or(station.settings.at_end);
        // A pilot has it, or the operator keeps it out: it is not ours to command.
        if vehicle.custody().released().is_some() || !vehicle.heard().armed {
            return false;
        }
        if vehicle.on_ground() {
            let disarm = command_long(vehicle.target(), MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [0.0; 7]);
            station.order(index, "end", disarm, now);
            station.tell_once(index, "ended", Weight::Note, "is on the ground: it is told to disarm", now);
            return true;
        }
        let is_brought_there = |to| driver.end_mode(to) == Some(vehicle.heard().custom_mode);
        let is_ours = vehicle.follows() || vehicle.holds() || is_brought_there(at_end);
        if vehicle.custody().has_entered() && !is_ours {
            station.release_for_its_mode(index, now);
            return false;
        }
        let Some(mode) = driver.end_mode(at_end) else {
            let text = format!("flies on in {}, as asked", vehicle.mode_name());
            station.tell_once(index, "ended", Weight::Note, text, now);
            return false;
        };
        if vehicle.heard().custom_mode == mode {
            let note = driver.end_note(at_end).map(|note| format!(": {note}")).unwrap_or_default();
            let text = format!("is left in {}{note}", vehicle.mode_name());
            let height = if at_end == AtEnd::Loiter { self.height(station, index, now) } else { Height::AsItIs };
            let height = match height {
                Height::AsItIs => String::new(),
                Height::IsAsked => return true,
                Height::Answered(text) => text,
            };
            station.tell_once(index, "ended", Weight::Note, text + &height, now);
            return false;
        }
        station.order(index, "end", driver.set_mode(vehicle.target(), mode), now);
        true
    }

    /// Asks a plane that circles beside others for a height of its own.
    fn height(&mut self, station: &mut Station, index: usize, now: Duration) -> Height {
        if self.heights.is_some() || station.crew().len() < 2 {
            return Height::AsItIs;
        }
        let circles = self.circles.get_or_insert_with(|| heights(station, now));
        let layer_m = circles.layer_m(index);
        let vehicle = &station.vehicles[index];
        let amsl_m = station.frame.origin().altitude_amsl_m + layer_m;
        let Some(message) = vehicle.driver().and_then(|driver| driver.circle_at(vehicle.target(), amsl_m)) else {
            return Height::AsItIs;
        };
        match vehicle.orders().answer("height") {
            Some("ACCEPTED") => Height::Answered(format!(", and changes to {layer_m:.0} m")),
            Some(answer) => Height::Answered(format!(", at the height where it was: {answer} to {layer_m:.0} m")),
            None if self.ordered.is_some_and(|ordered| now.saturating_sub(ordered) > HEIGHT_PATIENCE) => {
                Height::Answered(format!(", and has not answered to {layer_m:.0} m"))
            }
            None => {
                station.order(index, "height", message, now);
                Height::IsAsked
            }
        }
    }
}

/// What becomes of the height of a vehicle that is in its last mode.
enum Height {
    /// It keeps its own.
    AsItIs,
    /// It was asked for another, and has not answered.
    IsAsked,
    /// It has answered, or will not, in words.
    Answered(String),
}

/// Heights from left to right as they fly now, so that neighbours differ.
fn heights(station: &Station, now: Duration) -> Gather {
    let states: Vec<_> =
        station.crew().map(|index| station.state_now(index, now).unwrap_or(station.scenario.starts[index])).collect();
    Gather::new(&states, station.scenario.expected, &[], &station.limits)
}
