//! What the ground knows of vehicles that keep their own time, or answer late: the delay of each link, where each
//! vehicle is, and where it will be when a command that is sent now acts.
//!
//! Sans-I/O: messages and times go in, states come out. Times are flight time, which runs as fast as the vehicles do.

use crate::config::{Scenario, SetpointDialect};
use controller::{Decision, Present};
use flight_model::{Setpoint, State, Wind};
use mavlink_bridge::dialect::{Message, TIMESYNC_DATA};
use mavlink_bridge::link::VehicleClock;
use mavlink_bridge::{Position, state_from_local_position};
use serde_json::json;
use std::collections::VecDeque;
use std::time::Duration;

/// A tick whose commands go out later than this share of the control period is late.
const LATE_SHARE: f64 = 0.25;
/// Commands that are slower than this in comparison with the slowest usual link do not hold up the flock, s.
const LEAD_MAX_S: f64 = 2.0;
/// Predictions that are kept until the flight comes to them.
const FORESEEN_MAX: usize = 16;
/// From this share of lost frames on commands are sent again within their period: once, and from the second on twice.
const LOSS_SHARES: [f64; 2] = [0.02, 0.1];
/// Again after this share of the period, and after twice as much.
const AGAIN_SHARE: f64 = 0.1;

/// The flock as the ground knows it.
pub struct Watch {
    crafts: Vec<Craft>,
    has_link: bool,
    period_s: f64,
    silence_s: f64,
    margin_sigmas: f64,
    /// At the last tick, and when the commands of that tick act.
    states: Vec<State>,
    foreseen: Vec<State>,
    margins_m: Vec<f64>,
    reference_speeds_mps: Vec<f64>,
    /// Predictions for moments that are not flown yet.
    pending: VecDeque<(f64, Vec<State>)>,
    timing: Timing,
    error: StateError,
    /// Where all were at the end of the last stretch of their flight.
    last_flown: Vec<State>,
    frames: [u64; 2],
}

/// One vehicle.
struct Craft {
    clock: VehicleClock,
    present: Present,
    ages_s: [f64; 2],
    std_m: f64,
}

/// When decisions were made.
#[derive(Default)]
struct Timing {
    ticks: u64,
    late: u64,
    /// Decisions that were made only after the next one was due.
    missed: u64,
    /// Looks at the vehicles before the delays of all links were known.
    without_delay: u64,
    worst_late_s: f64,
    /// From the look at the vehicles to the commands, s: what it takes at most, forgotten slowly.
    deciding_s: f64,
    seen_s: f64,
}

/// States that were foreseen against those that were flown.
#[derive(Default)]
struct StateError {
    sum_squared_m2: f64,
    count: u64,
    worst_m: f64,
}

impl Watch {
    /// The vehicles of a scenario behind a link, of which nothing is heard yet.
    pub fn new(scenario: &Scenario) -> Self {
        let hold_ground_speed = scenario.link.setpoints == SetpointDialect::LocalNed;
        Self::of(scenario, true, hold_ground_speed)
    }

    /// The vehicles of a scenario that are seen as they are and commanded at once, but answer after a dead time; none
    /// where they answer at once.
    pub fn without_a_link(scenario: &Scenario) -> Option<Self> {
        let answers_late = |index| {
            let response = scenario.dynamics_of(index).response;
            response.course_dead_time_s.max(response.speed_dead_time_s).max(response.altitude_dead_time_s) > 0.0
        };
        (0..scenario.starts.len()).any(answers_late).then(|| Self::of(scenario, false, true))
    }

    fn of(scenario: &Scenario, has_link: bool, hold_ground_speed: bool) -> Self {
        let craft = |index: usize| {
            let mut present = Present::new(&if hold_ground_speed {
                scenario.dynamics_over_ground_of(index)
            } else {
                scenario.dynamics_of(index)
            });
            present.set_holds_ground_speed(hold_ground_speed);
            present.set_settles_slowly(!hold_ground_speed || scenario.plant_of(index).is_some());
            Craft { clock: VehicleClock::default(), present, ages_s: [0.0; 2], std_m: 0.0 }
        };
        Self {
            crafts: (0..scenario.starts.len()).map(craft).collect(),
            has_link,
            period_s: scenario.control_period.as_secs_f64(),
            silence_s: scenario.ground.silence_s,
            margin_sigmas: scenario.controller.look_ahead.margin_sigmas,
            states: scenario.starts.clone(),
            foreseen: scenario.starts.clone(),
            margins_m: vec![0.0; scenario.starts.len()],
            reference_speeds_mps: scenario.starts.iter().map(|start| start.speed_mps).collect(),
            pending: VecDeque::new(),
            timing: Timing::default(),
            error: StateError::default(),
            last_flown: scenario.starts.clone(),
            frames: [0; 2],
        }
    }

    /// Takes the states of all vehicles, which are behind no link, at flight time `now`.
    pub fn hear_states(&mut self, states: &[State], now: Duration) {
        for (craft, state) in self.crafts.iter_mut().zip(states) {
            craft.present.hear(now.as_secs_f64(), state);
        }
    }

    /// Takes a message of a vehicle that was heard at flight time `now`.
    pub fn hear(&mut self, vehicle: usize, message: &Message, now: Duration) {
        let Some(craft) = self.crafts.get_mut(vehicle) else { return };
        match message {
            Message::LOCAL_POSITION_NED(data) => {
                if let Some(at_s) = craft.flown_at_s(data.time_boot_ms, now) {
                    craft.present.hear(at_s, &state_from_local_position(data));
                }
            }
            Message::ATTITUDE(data) => {
                if let Some(at_s) = craft.flown_at_s(data.time_boot_ms, now) {
                    craft.present.hear_heading(at_s, f64::from(data.yaw));
                }
            }
            Message::VFR_HUD(data) => craft.present.hear_airspeed(now.as_secs_f64(), f64::from(data.airspeed)),
            Message::TIMESYNC(data) => {
                if let Some(round_trip) = round_trip(data, now) {
                    craft.round_trip(round_trip, now);
                }
            }
            _ => {}
        }
    }

    /// Takes a position that was heard at flight time `now`.
    pub fn hear_position(&mut self, vehicle: usize, position: &Position, now: Duration) {
        if let Some(craft) = self.crafts.get_mut(vehicle)
            && let Some(at_s) = craft.flown_at_s(position.time_boot_ms, now)
        {
            craft.present.hear(at_s, &position.state);
        }
    }

    /// A vehicle begins to fly at flight time `now`, from where it stood until then.
    pub fn begin(&mut self, vehicle: usize, state: &State, now: Duration) {
        if let Some(craft) = self.crafts.get_mut(vehicle) {
            craft.present.hear(now.as_secs_f64(), state);
        }
    }

    /// Whether the delay of a vehicle's link is known.
    pub fn knows_delay(&self, vehicle: usize) -> bool {
        self.crafts.get(vehicle).is_some_and(|craft| craft.clock.delay_s().is_some())
    }

    /// The question for the time, to be sent to every vehicle at flight time `now`: the answer tells the delay.
    pub fn time_request(now: Duration) -> Message {
        let ts1 = i64::try_from(now.as_nanos()).unwrap_or(i64::MAX);
        Message::TIMESYNC(TIMESYNC_DATA { tc1: 0, ts1, target_system: 0, target_component: 0 })
    }

    /// Frames that came and that were lost on the way, so far.
    pub fn note_frames(&mut self, came: u64, lost: u64) {
        self.frames = [came, lost];
    }

    /// After which times commands go out again in a control period: none where the link loses hardly any. Soon: what
    /// comes late is flown late.
    pub fn sends_again(&self, period: Duration) -> impl Iterator<Item = Duration> + use<> {
        let [came, lost] = self.frames.map(|frames| frames as f64);
        let share = lost / (came + lost).max(1.0);
        let times = LOSS_SHARES.iter().filter(|least| share > **least).count() as u32;
        (1..=times).map(move |time| period.mul_f64(AGAIN_SHARE) * time)
    }

    /// Looks at all vehicles at flight time `now`: where they are, and where they will be when commands act.
    pub fn look(&mut self, now: Duration) {
        let now_s = now.as_secs_f64();
        self.timing.seen_s = now_s;
        let slowest_s = self.crafts.iter().map(|craft| craft.present.acts_after_s()).fold(0.0, f64::max);
        let acts_s = now_s + slowest_s.min(LEAD_MAX_S) + self.timing.deciding_s;
        for (index, craft) in self.crafts.iter_mut().enumerate() {
            // A vehicle that is silent is carried no further than this.
            let no_later_s = craft.present.heard_s().map_or(now_s, |heard_s| heard_s + self.silence_s);
            if let Some(here) = craft.present.at(now_s.min(no_later_s)) {
                self.states[index] = here.state;
                craft.ages_s = [craft.ages_s[0] + here.age_s, craft.ages_s[1].max(here.age_s)];
            }
            if let Some(there) = craft.present.foresee(acts_s.min(no_later_s)) {
                self.foreseen[index] = there.state;
                self.reference_speeds_mps[index] = there.reference_speed_mps;
                craft.std_m = there.position_std_m();
                // The next command can make up for it a control period later.
                self.margins_m[index] = self.margin_sigmas * there.position_std_after_m(self.period_s);
            }
        }
        // Before the first round trip nobody knows how old anything is: that is told, and no state of the flight's.
        if !self.has_link || self.crafts.iter().all(|craft| craft.clock.delay_s().is_some()) {
            self.pending.push_back((acts_s, self.foreseen.clone()));
        } else {
            self.timing.without_delay += 1;
        }
        if self.pending.len() > FORESEEN_MAX {
            self.pending.pop_front();
        }
    }

    /// Where all vehicles are, at the last look.
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// Where they will be when the commands of that look act.
    pub fn foreseen(&self) -> &[State] {
        &self.foreseen
    }

    /// How far off that may be, m.
    pub fn margins_m(&self) -> &[f64] {
        &self.margins_m
    }

    /// The speeds to which Eq. 2 adds, m/s.
    pub fn reference_speeds_mps(&self) -> &[f64] {
        &self.reference_speeds_mps
    }

    /// The winds around the vehicles, as far as they are known.
    pub fn winds(&self) -> impl Iterator<Item = Wind> {
        self.crafts.iter().map(|craft| craft.present.wind())
    }

    /// The commands of a tick go out at flight time `now`; they were due at `due`. Says by how much they are late, s,
    /// if that is worth telling.
    pub fn decided(&mut self, due: Duration, now: Duration) -> Option<f64> {
        let (now_s, late_s) = (now.as_secs_f64(), now.saturating_sub(due).as_secs_f64());
        let timing = &mut self.timing;
        timing.ticks += 1;
        timing.deciding_s = (0.9 * timing.deciding_s).max((now_s - timing.seen_s).clamp(0.0, self.period_s));
        timing.worst_late_s = timing.worst_late_s.max(late_s);
        let is_late = late_s > LATE_SHARE * self.period_s;
        timing.late += u64::from(is_late);
        timing.missed += u64::from(late_s > self.period_s);
        is_late.then_some(late_s)
    }

    /// A command is sent at flight time `now`; gives the setpoint that is to go out for what is wanted.
    pub fn command(&mut self, vehicle: usize, decision: &Decision, now: Duration) -> Setpoint {
        let Some(craft) = self.crafts.get_mut(vehicle) else { return decision.setpoint };
        craft.present.command(now.as_secs_f64(), &decision.setpoint);
        Setpoint { speed_mps: craft.present.speed_to_send_mps(&decision.setpoint), ..decision.setpoint }
    }

    /// Compares what was foreseen with what was flown: states `step` apart after `start`, in flight time.
    pub fn compare(&mut self, start: Duration, step: Duration, tracks: &[Vec<State>]) {
        let (start_s, step_s) = (start.as_secs_f64(), step.as_secs_f64());
        let flown_s = start_s + step_s * tracks.iter().map(Vec::len).min().unwrap_or(0) as f64;
        while self.pending.front().is_some_and(|(at_s, _)| *at_s < flown_s) {
            let Some((at_s, foreseen)) = self.pending.pop_front() else { return };
            let place = ((at_s - start_s) / step_s).round() as usize;
            for ((track, foreseen), last) in tracks.iter().zip(&foreseen).zip(&self.last_flown) {
                // The state after the first step is that at `start + step`.
                let Some(flown) = place.checked_sub(1).map_or(Some(last), |place| track.get(place)) else { continue };
                let off_m = (flown.position_m() - foreseen.position_m()).norm();
                self.error.sum_squared_m2 += off_m * off_m;
                self.error.worst_m = self.error.worst_m.max(off_m);
                self.error.count += 1;
            }
        }
        for (last, track) in self.last_flown.iter_mut().zip(tracks) {
            *last = track.last().copied().unwrap_or(*last);
        }
    }

    /// The figures of `summary.json`, `present`.
    pub fn figures(&self) -> serde_json::Value {
        let ticks = self.timing.ticks.max(1) as f64;
        let vehicles: Vec<serde_json::Value> = self
            .crafts
            .iter()
            .enumerate()
            .map(|(index, craft)| {
                let foreseen = craft.present.foreseen_error_m();
                json!({
                    "vehicle": index + 1,
                    "telemetry_delay_s": craft.clock.delay_s().map(|least_s| least_s + craft.jitter_s()),
                    "command_delay_s": craft.clock.command_delay_s(),
                    "delay_spread_s": craft.clock.delay_spread_s(),
                    "clock_drift": craft.clock.drift(),
                    "position_age_mean_s": craft.ages_s[0] / ticks,
                    "position_age_max_s": craft.ages_s[1],
                    "position_std_m": craft.std_m,
                    "foreseen_error_along_m": foreseen.map(|[along_m, _]| along_m),
                    "foreseen_error_across_m": foreseen.map(|[_, across_m]| across_m),
                    "speed_bias_mps": craft.present.speed_bias_mps(),
                    "wind_north_mps": craft.present.wind_mps().map(|wind| wind.x),
                    "wind_east_mps": craft.present.wind_mps().map(|wind| wind.y),
                })
            })
            .collect();
        let error = &self.error;
        let is_compared = error.count > 0;
        json!({
            "ticks": self.timing.ticks,
            "late_ticks": self.timing.late,
            "missed_ticks": self.timing.missed,
            "worst_late_s": self.timing.worst_late_s,
            "ticks_without_delay": self.timing.without_delay,
            "state_error_rms_m": is_compared.then(|| (error.sum_squared_m2 / error.count as f64).sqrt()),
            "state_error_max_m": is_compared.then_some(error.worst_m),
            "vehicles": vehicles,
        })
    }
}

impl Craft {
    /// The flight time at which a stamp of the vehicle was put on.
    fn flown_at_s(&mut self, boot_ms: u32, heard: Duration) -> Option<f64> {
        let reboots = self.clock.reboots();
        self.clock.hear(boot_ms, heard);
        if self.clock.reboots() != reboots {
            self.present.clear();
        }
        self.clock.ground_time_s(boot_ms)
    }

    /// Takes a round trip: the delay that it tells holds for what was heard and sent before it as well.
    fn round_trip(&mut self, round_trip: Duration, now: Duration) {
        let before_s = self.clock.delay_s().unwrap_or(0.0);
        self.clock.round_trip(round_trip, now);
        self.present.shift_heard(before_s - self.clock.delay_s().unwrap_or(0.0));
        self.present.set_command_delay_s(self.clock.command_delay_s().unwrap_or(0.0));
    }

    fn jitter_s(&self) -> f64 {
        self.clock.jitter_s().unwrap_or(0.0)
    }
}

/// The round trip that an answer tells; none if it answers no question of ours.
fn round_trip(data: &TIMESYNC_DATA, now: Duration) -> Option<Duration> {
    if data.tc1 == 0 {
        return None;
    }
    now.checked_sub(Duration::from_nanos(u64::try_from(data.ts1).ok()?))
}
