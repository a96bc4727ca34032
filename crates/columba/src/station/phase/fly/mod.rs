//! Sixth phase: the flock flies. Once in a control period all members decide; a vehicle that is not ours, not fresh or
//! not following is no member, and an obstacle instead.

pub mod log;
mod operated;
mod surroundings;

use super::Phase;
use crate::flying::Solves;
use crate::identify::flight::StepFlight;
use crate::judge::Verdict;
use crate::station::Station;
use crate::station::told::Weight;
use controller::{Decision, Flock, Insight};
use flight_model::Setpoint;
use log::{Choice, Decided, FlightLog, Logged};
use operated::Pause;
use std::time::Duration;
use surroundings::Foreseen;

/// A tick within this of its time is on time, s.
const ON_TIME_S: f64 = 0.05;
/// A tick that comes this share of the period late is told.
const LATE_SHARE: f64 = 0.25;

/// The flight of the flock.
pub struct Fly {
    /// When it began, on the station's clock.
    began: Duration,
    /// When the last tick was over, on the station's clock; none while it flies.
    ended: Option<Duration>,
    /// Whether every tick was flown.
    completed: bool,
    log: FlightLog,
    pause: Pause,
    timing: Timing,
    flock: Option<Flock>,
    /// What is flown in the place of what the flock would decide.
    steps: Option<StepFlight>,
    members: Vec<usize>,
    /// When the last decisions were made.
    decided: Duration,
    next: Duration,
}

/// How the decisions came.
#[derive(Default)]
pub struct Timing {
    /// Decisions that were made.
    pub ticks: u64,
    /// Decisions that came late.
    pub late_ticks: u64,
    /// By how much the latest of them was late, s.
    pub worst_late_s: f64,
    /// Times of all solves.
    pub solves: Solves,
}

/// A flight of which all is said.
pub struct Flown {
    /// Whether every tick was flown.
    pub completed: bool,
    /// How the decisions came.
    pub timing: Timing,
    /// What was seen of it.
    pub logged: Logged,
}

impl Fly {
    pub(super) fn new(station: &mut Station, now: Duration) -> Result<Self, String> {
        // The settings are tried once, so that a mistake in them is told before the first tick.
        let crew: Vec<usize> = station.crew().collect();
        Flock::new(surroundings::settings(station, &crew), crew.len()).map_err(|error| error.to_string())?;
        station.told.flight_began_s = Some(now.as_secs_f64());
        station.told.tell(now.as_secs_f64(), None, Weight::Note, "the flock flies");
        Ok(Self {
            began: now,
            ended: None,
            completed: false,
            log: FlightLog::new(station, now),
            pause: Pause::default(),
            timing: Timing::default(),
            flock: None,
            steps: station.settings.steps.clone(),
            members: Vec::new(),
            decided: now,
            next: now,
        })
    }

    /// When it began, on the station's clock.
    pub fn began(&self) -> Duration {
        self.began
    }

    /// Decisions that were made.
    pub fn ticks(&self) -> u64 {
        self.timing.ticks
    }

    /// Flight time, s.
    pub fn flight_s(&self, now: Duration) -> f64 {
        now.saturating_sub(self.began).as_secs_f64()
    }

    /// The least separation and clearance since the last tick, m.
    pub fn recent_m(&self) -> [f64; 2] {
        self.log.recent_m()
    }

    /// Separation and clearance until now.
    pub fn verdict(&self) -> Verdict {
        self.log.verdict()
    }

    /// What the flock last chose for a vehicle of the crew.
    pub fn chosen(&self, index: usize) -> Option<Choice> {
        self.log.chosen(index)
    }

    /// What the watched vehicles had to choose from at the last decision: its flight time, s, and their indices.
    pub fn insights(&self) -> (f64, impl Iterator<Item = (usize, &Insight)>) {
        let insights = self.flock.iter().flat_map(Flock::insights);
        let of_vehicles = insights.filter_map(|(member, insight)| Some((*self.members.get(member)?, insight)));
        (self.flight_s(self.decided), of_vehicles)
    }

    /// Whether the operator has paused it, and not all vehicles follow again.
    pub fn is_paused(&self) -> bool {
        self.pause.holds()
    }

    /// All of it, when all is said.
    pub fn into_flown(self) -> Flown {
        Flown { completed: self.completed, timing: self.timing, logged: self.log.into_logged() }
    }

    pub(super) fn step(mut self: Box<Self>, station: &mut Station, now: Duration) -> Phase {
        station.watch_modes(self.is_paused(), now);
        self.pause.obey(station, now);
        let are_steps_over = self.steps.as_ref().is_some_and(StepFlight::is_over);
        let is_over = (self.timing.ticks >= station.scenario.ticks() || are_steps_over) && now >= self.next;
        if station.crew().all(|index| !station.vehicles[index].is_ours()) {
            station.stop("no vehicle is left to fly", false);
        }
        if is_over || station.stopped().is_some() {
            self.completed = is_over;
            self.ended = Some(if is_over { self.next } else { now });
            return Phase::end(Some(self), now);
        }
        if self.pause.is_resuming() {
            if self.pause.resume(station, now) {
                self.next = now;
            }
        } else if !self.pause.holds() {
            self.steer(station, None, now);
        }
        self.settle(station, now);
        Phase::Fly(self)
    }

    /// A tick if one is due, and what goes out between ticks. `height` stands in for the altitude that the law gives.
    pub(super) fn steer(&mut self, station: &mut Station, height: Option<&dyn Fn(usize) -> f64>, now: Duration) {
        if now >= self.next {
            self.decide(station, height, now);
        } else {
            for &index in &self.members {
                let vehicle = &station.vehicles[index];
                if vehicle.driver().is_some_and(|driver| driver.repeat_every().is_some())
                    && let Some(setpoint) = vehicle.orders().setpoint()
                {
                    station.steer(index, &setpoint, now);
                }
            }
        }
        for &index in &self.members {
            station.watch_answers(index, now);
        }
    }

    fn decide(&mut self, station: &mut Station, height: Option<&dyn Fn(usize) -> f64>, now: Duration) {
        let period = station.scenario.control_period;
        let late_s = now.saturating_sub(self.next).as_secs_f64();
        if late_s > LATE_SHARE * period.as_secs_f64() && self.timing.ticks > 0 {
            let text = format!("a decision came {late_s:.2} s late: the machine cannot keep up");
            station.told.once(now.as_secs_f64(), None, "late", Weight::Warning, text);
            self.timing.late_ticks += 1;
            self.timing.worst_late_s = self.timing.worst_late_s.max(late_s);
        }
        self.gather_members(station, now);
        let mut choices = vec![None; station.scenario.starts.len()];
        let mut solve_us = 0.0;
        let Some(decisions) = self.decisions(station, now) else { return };
        for (&index, decision) in self.members.iter().zip(&decisions) {
            let altitude_m = height.map_or(decision.setpoint.altitude_m, |height| height(index));
            let setpoint = Setpoint { altitude_m, ..decision.setpoint };
            station.steer_now(index, &setpoint, now);
            choices[index] = Some((setpoint, decision.weights));
            solve_us += decision.solve.as_secs_f64() * 1e6;
            self.timing.solves.push(decision.solve);
        }
        if self.ended.is_none() {
            let solve_us = solve_us / self.members.len().max(1) as f64;
            // The tick's own time, unless it came late.
            let at = if late_s < ON_TIME_S { self.next } else { now };
            self.log.push(Decided { at, choices, solve_us });
        }
        self.timing.ticks += 1;
        // After a stall the next tick is a whole period away: ticks are not made up for.
        self.next = if late_s > period.as_secs_f64() { now + period } else { self.next + period };
    }

    /// Makes a flock of those that are ours, fresh and following.
    fn gather_members(&mut self, station: &Station, now: Duration) {
        let is_member = |index: &usize| {
            let vehicle = &station.vehicles[*index];
            let may_steer = vehicle.is_ours() && !vehicle.custody().is_paused() && vehicle.follows();
            may_steer && station.state_now(*index, now).is_some()
        };
        let members: Vec<usize> = station.crew().filter(is_member).collect();
        if members != self.members || self.flock.is_none() {
            self.flock = Flock::new(surroundings::settings(station, &members), members.len()).ok();
            self.members = members;
        }
    }

    /// What the members are to do, or the next step of a step flight.
    fn decisions(&mut self, station: &mut Station, now: Duration) -> Option<Vec<Decision>> {
        let Foreseen { states, margins_m, reference_speeds_mps, winds } =
            surroundings::foresee(station, &self.members, now);
        let mut obstacles = station.obstacles();
        obstacles.extend(surroundings::others(station, &self.members, now));
        let flock = self.flock.as_mut()?;
        flock.set_obstacles(obstacles);
        flock.set_margins(&margins_m);
        flock.set_reference_speeds(&reference_speeds_mps);
        flock.set_winds(winds);
        let is_watched = |member: &usize| station.watched().contains(&self.members[*member]);
        flock.watch(&(0..self.members.len()).filter(is_watched).collect::<Vec<_>>());
        self.decided = now;
        Some(match (&mut self.steps, states.first()) {
            (Some(steps), Some(first)) => {
                let setpoint = steps.setpoint(now.saturating_sub(self.began).as_secs_f64(), first);
                vec![Decision { setpoint, ..Decision::default() }; states.len()]
            }
            _ => flock.tick(self.timing.ticks, &states, station.clock()).to_vec(),
        })
    }

    /// Judges and records what was heard of the flight.
    pub(super) fn settle(&mut self, station: &mut Station, now: Duration) {
        self.log.settle(station, now, self.ended.unwrap_or(now).as_secs_f64());
    }

    /// The states at the end of the flight.
    pub(super) fn last(&mut self, station: &mut Station, now: Duration) {
        self.log.last(station, self.ended.unwrap_or(now));
    }
}
