//! Sixth phase: the flock flies. Once in a control period all members decide; a vehicle that is not ours, not fresh or
//! not following is no member, and an obstacle instead.

use super::judge::{Seen, TrackJudge};
use super::operator::Verb;
use super::told::Weight;
use super::track::velocity_mps;
use super::vehicle::Vehicle;
use super::{Phase, STALE_S, Station, end, number};
use crate::flight::{Row, Tick, Trajectory};
use crate::flying::Solves;
use crate::identify::flight::StepFlight;
use controller::{Decision, Flock, FlockSettings, Insight, Obstacle};
use flight_model::{Setpoint, State, Wind};
use mavlink_bridge::kind::AtEnd;
use std::collections::VecDeque;
use std::time::Duration;

/// A vehicle of which nothing is heard may be anywhere in a disc that grows by this share of its greatest speed.
const GROWTH_SHARE: f64 = 0.25;
/// The disc grows for so long, s.
const GROWTH_S: f64 = 20.0;
/// Vehicles at heights that differ by more than this are no obstacles to each other, m.
const HEIGHT_APART_M: f64 = 25.0;
/// A tick within this of its time is on time, s.
const ON_TIME_S: f64 = 0.05;
/// Commands that take longer to a vehicle do not hold up the flock, s.
const LEAD_MAX_S: f64 = 2.0;
/// A tick that comes this share of the period late is told.
const LATE_SHARE: f64 = 0.25;

/// A tick whose states are not judged yet.
struct Pending {
    at: Duration,
    rows: Vec<Option<(Setpoint, [f64; 3])>>,
    solve_us: f64,
}

/// The flight of the flock.
pub struct Fly {
    /// When it began, on the station's clock.
    pub began: Duration,
    /// When the last tick was over, on the station's clock; none while it flies.
    pub ended: Option<Duration>,
    /// Separation and clearance.
    pub judge: TrackJudge,
    /// Every tick, once all of it is heard.
    pub trajectory: Trajectory,
    /// Times of all solves.
    pub solves: Solves,
    /// Whether every tick was flown.
    pub completed: bool,
    /// Decisions that came late, and the latest of them, s.
    pub late_ticks: u64,
    /// By how much the latest decision was late, s.
    pub worst_late_s: f64,
    flock: Option<Flock>,
    /// What is flown in the place of what the flock would decide.
    steps: Option<StepFlight>,
    members: Vec<usize>,
    tick: u64,
    /// When the last decisions were made.
    decided: Duration,
    next: Duration,
    pending: VecDeque<Pending>,
    paused: bool,
    resuming: bool,
}

impl Fly {
    pub(super) fn new(station: &mut Station, now: Duration) -> Result<Self, String> {
        let scenario = &station.scenario;
        // The settings are tried once, so that a mistake in them is told before the first tick.
        let crew: Vec<usize> = station.crew().collect();
        Flock::new(settings(station, &crew), crew.len()).map_err(|error| error.to_string())?;
        let judge = TrackJudge::new(
            scenario.starts.len(),
            &scenario.obstacles,
            scenario.expected,
            scenario.controller.law.safe_distance_m,
            now.as_secs_f64(),
        );
        let trajectory = Trajectory::new(scenario.starts.len());
        station.told.flight_began_s = Some(now.as_secs_f64());
        station.told.tell(now.as_secs_f64(), None, Weight::Note, "the flock flies");
        Ok(Self {
            began: now,
            ended: None,
            judge,
            trajectory,
            solves: Solves::default(),
            completed: false,
            late_ticks: 0,
            worst_late_s: 0.0,
            flock: None,
            steps: station.settings.steps.clone(),
            members: Vec::new(),
            tick: 0,
            decided: now,
            next: now,
            pending: VecDeque::new(),
            paused: false,
            resuming: false,
        })
    }

    /// Decisions that were made.
    pub fn ticks(&self) -> u64 {
        self.tick
    }

    /// Flight time, s.
    pub fn flight_s(&self, now: Duration) -> f64 {
        now.saturating_sub(self.began).as_secs_f64()
    }

    /// The least separation and clearance since the last tick, m.
    pub fn recent_m(&self) -> [f64; 2] {
        self.judge.recent_m()
    }

    /// What the flock last chose for a vehicle of the crew: its setpoint and its weights.
    pub fn chosen(&self, index: usize) -> Option<(Setpoint, [f64; 3])> {
        if let Some(pending) = self.pending.back() {
            return pending.rows.get(index).copied().flatten();
        }
        let last = self.trajectory.rows.len().checked_sub(self.trajectory.vehicles)?;
        let row = self.trajectory.rows.get(last + index)?;
        row.setpoint.is_finite().then_some((row.setpoint, row.alpha))
    }

    /// What the watched vehicles had to choose from at the last decision: its flight time, s, and their indices.
    pub fn insights(&self) -> (f64, impl Iterator<Item = (usize, &Insight)>) {
        let insights = self.flock.iter().flat_map(Flock::insights);
        let of_vehicles = insights.filter_map(|(member, insight)| Some((*self.members.get(member)?, insight)));
        (self.flight_s(self.decided), of_vehicles)
    }

    /// Whether the operator has paused it, and not all vehicles follow again.
    pub fn is_paused(&self) -> bool {
        self.paused || self.resuming
    }

    pub(super) fn step(mut self: Box<Self>, station: &mut Station, now: Duration) -> Phase {
        station.watch_modes(self.is_paused(), now);
        self.obey(station, now);
        let are_steps_over = self.steps.as_ref().is_some_and(StepFlight::is_over);
        let is_over = (self.tick >= station.scenario.ticks() || are_steps_over) && now >= self.next;
        let nobody = station.crew().all(|index| !station.vehicles[index].is_ours());
        if nobody {
            station.stop("no vehicle is left to fly", false);
        }
        if is_over || station.stopped().is_some() {
            self.completed = is_over;
            self.ended = Some(if is_over { self.next } else { now });
            return Phase::End(Box::new(end::End::new(Some(self), now)));
        }
        if self.resuming {
            self.resume(station, now);
        } else if !self.paused {
            self.steer(station, None, now);
        }
        self.settle(station, now, now.as_secs_f64());
        Phase::Fly(self)
    }

    /// A tick if one is due, and what goes out between ticks. `height` stands in for the altitude that the law gives.
    pub(super) fn steer(&mut self, station: &mut Station, height: Option<&dyn Fn(usize) -> f64>, now: Duration) {
        if now >= self.next {
            self.decide(station, height, now);
        } else {
            for index in self.members.clone() {
                if station.vehicles[index].driver().is_some_and(|driver| driver.repeat_every().is_some())
                    && let Some(setpoint) = station.vehicles[index].setpoint
                {
                    station.steer(index, &setpoint, now);
                }
            }
        }
        for index in self.members.clone() {
            station.watch_answers(index, now);
        }
    }

    fn decide(&mut self, station: &mut Station, height: Option<&dyn Fn(usize) -> f64>, now: Duration) {
        let period = station.scenario.control_period;
        let late_s = now.saturating_sub(self.next).as_secs_f64();
        if late_s > LATE_SHARE * period.as_secs_f64() && self.tick > 0 {
            let text = format!("a decision came {late_s:.2} s late: the machine cannot keep up");
            station.told.once(now.as_secs_f64(), None, "late", Weight::Warning, text);
            self.late_ticks += 1;
            self.worst_late_s = self.worst_late_s.max(late_s);
        }
        let members: Vec<usize> = station
            .crew()
            .filter(|&index| {
                let vehicle = &station.vehicles[index];
                vehicle.is_ours() && !vehicle.paused && vehicle.follows() && station.state_now(index, now).is_some()
            })
            .collect();
        if members != self.members || self.flock.is_none() {
            self.flock = Flock::new(settings(station, &members), members.len()).ok();
            self.members = members;
        }
        let Foreseen { states, margins_m, reference_speeds_mps, winds } = foresee(station, &self.members, now);
        let mut obstacles = station.obstacles();
        obstacles.extend(others(station, &self.members, now));
        let Some(flock) = &mut self.flock else { return };
        flock.set_obstacles(obstacles);
        flock.set_margins(&margins_m);
        flock.set_reference_speeds(&reference_speeds_mps);
        flock.set_winds(winds);
        let is_watched = |member: &usize| station.watched().contains(&self.members[*member]);
        flock.watch(&(0..self.members.len()).filter(is_watched).collect::<Vec<_>>());
        self.decided = now;
        let decisions: Vec<Decision> = match (&mut self.steps, states.first()) {
            (Some(steps), Some(first)) => {
                let setpoint = steps.setpoint(now.saturating_sub(self.began).as_secs_f64(), first);
                vec![Decision { setpoint, ..Decision::default() }; states.len()]
            }
            _ => flock.tick(self.tick, &states, station.clock()).to_vec(),
        };
        let mut rows = vec![None; self.trajectory.vehicles];
        let mut solve_us = 0.0;
        for (&index, decision) in self.members.iter().zip(&decisions) {
            let altitude_m = height.map_or(decision.setpoint.altitude_m, |height| height(index));
            let setpoint = Setpoint { altitude_m, ..decision.setpoint };
            station.steer_now(index, &setpoint, now);
            rows[index] = Some((setpoint, decision.weights));
            solve_us += decision.solve.as_secs_f64() * 1e6;
            self.solves.push(decision.solve);
        }
        if self.ended.is_none() {
            let solve_us = solve_us / self.members.len().max(1) as f64;
            // The tick's own time, unless it came late.
            let at = if late_s < ON_TIME_S { self.next } else { now };
            self.pending.push_back(Pending { at, rows, solve_us });
        }
        self.tick += 1;
        // After a stall the next tick is a whole period away: ticks are not made up for.
        self.next = if late_s > period.as_secs_f64() { now + period } else { self.next + period };
    }

    /// Judges what was heard, and records ticks whose states are known by now, or never will be.
    pub(super) fn settle(&mut self, station: &mut Station, now: Duration, until_s: f64) {
        let seen: Vec<Seen<'_>> = station
            .crew()
            .map(|index| {
                let vehicle = &station.vehicles[index];
                Seen {
                    track: &vehicle.track,
                    clock_error_s: vehicle.clock.jitter_s().unwrap_or(0.0).min(0.5),
                    is_airborne: !vehicle.on_ground(),
                    is_member: vehicle.is_ours(),
                }
            })
            .collect();
        self.judge.judge(&seen, now.as_secs_f64(), until_s);
        let mut ticks = Vec::new();
        while self.pending.front().is_some_and(|pending| pending.at.as_secs_f64() <= self.judge.judged_s()) {
            let Some(pending) = self.pending.pop_front() else { break };
            let state = |seen: &Seen<'_>| seen.track.at(pending.at.as_secs_f64()).map(|(state, _)| state);
            let states: Vec<Option<State>> = seen.iter().map(state).collect();
            ticks.push((pending, states));
        }
        for (pending, states) in ticks {
            let line = self.record(pending, &states);
            station.journal.push(line);
        }
    }

    /// The states at the end of the flight, which no setpoint follows.
    pub(super) fn last(&mut self, station: &mut Station, now: Duration) {
        let ended = self.ended.unwrap_or(now);
        let rows = station
            .crew()
            .map(|index| {
                let rows = self.trajectory.rows.len().checked_sub(self.trajectory.vehicles)?;
                let row = self.trajectory.rows.get(rows + index)?;
                row.setpoint.is_finite().then_some((row.setpoint, row.alpha))
            })
            .collect();
        let states: Vec<Option<State>> = station
            .crew()
            .map(|index| station.vehicles[index].track.at(ended.as_secs_f64()).map(|(state, _)| state))
            .collect();
        let line = self.record(Pending { at: ended, rows, solve_us: 0.0 }, &states);
        station.journal.push(line);
    }

    /// What was flown at a tick: a state that was not heard is not a number.
    fn record(&mut self, pending: Pending, states: &[Option<State>]) -> serde_json::Value {
        const UNKNOWN: State = State {
            x_m: f64::NAN,
            y_m: f64::NAN,
            altitude_m: f64::NAN,
            speed_mps: f64::NAN,
            course_rad: f64::NAN,
            climb_mps: f64::NAN,
        };
        const NONE: Setpoint = Setpoint { speed_mps: f64::NAN, course_rad: f64::NAN, altitude_m: f64::NAN };
        let t_s = pending.at.saturating_sub(self.began).as_secs_f64();
        let [min_separation_m, min_clearance_m] = self.judge.take_recent_m();
        let rows: Vec<Row> = (0..self.trajectory.vehicles)
            .map(|index| {
                let (setpoint, alpha) = pending.rows.get(index).copied().flatten().unwrap_or((NONE, [f64::NAN; 3]));
                Row { state: states.get(index).copied().flatten().unwrap_or(UNKNOWN), setpoint, alpha }
            })
            .collect();
        let line = super::record::tick_line(t_s, [min_separation_m, min_clearance_m], &rows);
        let tick = Tick { t_s, min_separation_m, min_clearance_m, solve_us: pending.solve_us };
        self.trajectory.push(tick, rows);
        line
    }

    /// Carries out what the operator said.
    fn obey(&mut self, station: &mut Station, now: Duration) {
        let now_s = now.as_secs_f64();
        for verb in station.take_verbs() {
            match verb {
                Verb::Pause if !self.paused => {
                    self.paused = true;
                    station.told.tell(now_s, None, Weight::Note, "paused by the operator: all hold where they are");
                }
                Verb::Resume if self.paused => {
                    (self.paused, self.resuming) = (false, true);
                    station.crew().for_each(|index| station.vehicles[index].paused = false);
                    station.told.tell(now_s, None, Weight::Note, "resumed by the operator");
                }
                Verb::PauseOne(vehicle) if station.crew().contains(&(vehicle - 1)) => {
                    station.vehicles[vehicle - 1].paused = true;
                    let text = "paused by the operator: it holds where it is";
                    station.told.tell(now_s, Some(number(vehicle - 1)), Weight::Note, text);
                }
                Verb::ResumeOne(vehicle) if station.crew().contains(&(vehicle - 1)) => {
                    let resumed = &mut station.vehicles[vehicle - 1];
                    if resumed.paused {
                        (resumed.paused, resumed.entered) = (false, false);
                        station.told.tell(now_s, Some(number(vehicle - 1)), Weight::Note, "resumed by the operator");
                    }
                }
                Verb::Drop(vehicle, at_end) if station.crew().contains(&(vehicle - 1)) => {
                    station.vehicles[vehicle - 1].dropped = true;
                    station.vehicles[vehicle - 1].dropped_to = at_end;
                    let text = match at_end {
                        AtEnd::Return => "dropped by the operator: it returns, and is flown no more",
                        AtEnd::Land => "dropped by the operator: it lands, and is flown no more",
                        _ => "dropped by the operator: it holds where it is, and is flown no more",
                    };
                    station.told.tell(now_s, Some(number(vehicle - 1)), Weight::Warning, text);
                }
                Verb::Take(vehicle) if station.crew().contains(&(vehicle - 1)) => {
                    let taken = &mut station.vehicles[vehicle - 1];
                    (taken.dropped, taken.paused, taken.released, taken.entered) = (false, false, None, false);
                    let text = "taken back by the operator";
                    station.told.tell(now_s, Some(number(vehicle - 1)), Weight::Note, text);
                }
                Verb::Drop(vehicle, _) | Verb::Take(vehicle) | Verb::PauseOne(vehicle) | Verb::ResumeOne(vehicle) => {
                    station.told.tell(now_s, None, Weight::Note, format!("there is no vehicle {vehicle}"));
                }
                _ => {}
            }
        }
        for index in station.crew() {
            let vehicle = &station.vehicles[index];
            let Some(driver) = vehicle.driver().cloned() else { continue };
            let is_paused = self.paused || vehicle.paused;
            let holds = vehicle.dropped || (is_paused && vehicle.is_ours());
            let mode = driver.end_mode(if vehicle.dropped { vehicle.dropped_to } else { AtEnd::Loiter });
            let is_told_otherwise = vehicle.dropped && vehicle.holds() && mode != Some(vehicle.custom_mode);
            if holds && (vehicle.follows() || is_told_otherwise) {
                if let Some(mode) = mode {
                    let message = driver.set_mode(vehicle.target, mode);
                    station.order(index, "hold", message, now);
                    station.vehicles[index].was_told_to_hold(now);
                }
            } else if vehicle.is_ours() && !vehicle.entered && !is_paused && !vehicle.on_ground() {
                if vehicle.follows_for_good() {
                    station.vehicles[index].entered = true;
                } else {
                    station.order(index, "take over", driver.take_over(vehicle.target), now);
                }
            }
        }
    }

    /// Brings all back into the mode in which they follow.
    fn resume(&mut self, station: &mut Station, now: Duration) {
        let mut all = true;
        for index in station.crew() {
            let vehicle = &station.vehicles[index];
            let Some(driver) = vehicle.driver().cloned().filter(|_| vehicle.is_ours()) else { continue };
            if !vehicle.follows_for_good() {
                all = false;
                if let Some(state) = station.state_now(index, now).filter(|_| driver.repeat_every().is_some()) {
                    station.steer(index, &state.hold(), now);
                }
                station.order(index, "take over", driver.take_over(station.vehicles[index].target), now);
            }
        }
        if all {
            self.resuming = false;
            self.next = now;
        }
    }
}

/// What a flock of these members is to know: each flies by its own model, within its own limits.
fn settings(station: &Station, members: &[usize]) -> FlockSettings {
    let dynamics = members.iter().map(|&index| *station.vehicles[index].present.dynamics()).collect();
    FlockSettings { dynamics, ..station.scenario.flock_settings() }.behind_a_link()
}

/// Where the members will be when commands that are sent now act.
#[derive(Default)]
struct Foreseen {
    states: Vec<State>,
    /// How far off these may be until the next command acts, m.
    margins_m: Vec<f64>,
    /// The speeds to which Eq. 2 adds, m/s.
    reference_speeds_mps: Vec<f64>,
    winds: Vec<Wind>,
}

fn foresee(station: &mut Station, members: &[usize], now: Duration) -> Foreseen {
    let sigmas = station.scenario.controller.look_ahead.margin_sigmas;
    let period_s = station.scenario.control_period.as_secs_f64();
    let lead = |&index: &usize| station.vehicles[index].present.acts_after_s();
    let lead_s = members.iter().map(lead).fold(0.0, f64::max).min(LEAD_MAX_S);
    let mut foreseen = Foreseen::default();
    for &index in members {
        // A member was heard a moment ago: there is always an estimate.
        if let Some(estimate) = station.vehicles[index].present.foresee(now.as_secs_f64() + lead_s) {
            foreseen.states.push(estimate.state);
            foreseen.margins_m.push(sigmas * estimate.position_std_after_m(period_s));
            foreseen.reference_speeds_mps.push(estimate.reference_speed_mps);
            foreseen.winds.push(station.vehicles[index].present.wind());
        }
    }
    foreseen
}

/// Vehicles in the air that are no members, as circles that the flock keeps out of: along their way over the look-ahead
/// while they are heard, a disc that grows when they are not.
fn others(station: &Station, members: &[usize], now: Duration) -> Vec<Obstacle> {
    let look_ahead = &station.scenario.controller.look_ahead;
    let period_s = station.scenario.control_period.as_secs_f64();
    let radius_m = (look_ahead.separation_m - look_ahead.clearance_m).max(1.0);
    let flock_m = station.scenario.expected.altitude_m;
    let now_s = now.as_secs_f64();
    let mut circles = Vec::new();
    let is_other = |(index, vehicle): &(usize, &Vehicle)| !members.contains(index) && !vehicle.on_ground();
    for (_, vehicle) in station.vehicles.iter().enumerate().filter(is_other) {
        let Some((state, age_s)) = vehicle.track.carried_to(now_s, GROWTH_S) else { continue };
        if (state.altitude_m - flock_m).abs() > HEIGHT_APART_M && age_s <= STALE_S {
            continue;
        }
        if age_s > STALE_S {
            let grown_m = GROWTH_SHARE * station.limits.speed_max_mps * age_s.min(GROWTH_S);
            circles.push(Obstacle { x_m: state.x_m, y_m: state.y_m, radius_m: radius_m + grown_m });
            continue;
        }
        let (north_mps, east_mps) = velocity_mps(&state);
        for step in 0..=look_ahead.steps(period_s) {
            let ahead_s = period_s * step as f64;
            let (x_m, y_m) = (state.x_m + north_mps * ahead_s, state.y_m + east_mps * ahead_s);
            circles.push(Obstacle { x_m, y_m, radius_m });
        }
    }
    circles
}
