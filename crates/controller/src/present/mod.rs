//! Where a vehicle is, and where it will be when a command that is sent now acts on it.
//!
//! Telemetry tells where a vehicle *was*; a command acts *later*. Between the two the vehicle flies the commands that
//! are under way. [`Present`] flies them through the vehicle's model from the last state that was heard, to any moment
//! up to the one at which the next command acts (a Smith predictor), and says how far off that may be.
//!
//! Times are seconds on one clock, the ground's; a state has the time of its own stamp, not the one at which it was
//! heard. Sans-I/O: it knows no link and no clock.

mod commands;
mod error;
mod speed;
mod wind;

use commands::Commands;
use error::PredictionError;
use flight_model::{Autopilot, Dynamics, Setpoint, State, Wind, course_vector, wrap_pi};
use nalgebra::{Matrix2, Vector2};
use speed::SpeedObserver;
use std::collections::VecDeque;
use wind::WindEstimate;

/// Step of the model, s.
const STEP_S: f64 = 0.01;
/// Nothing is predicted further than this from the last state, s.
const AHEAD_MAX_S: f64 = 10.0;
/// Headings are used where the last position is older than this, s: up to then its own course is the better one.
const HEADING_AFTER_S: f64 = 0.25;
/// Headings are kept for so long, s.
const HEADINGS_KEPT_S: f64 = 6.0;
/// Residuals of course (rad) and speed (m/s) of a model that fits, at the least: what the wire rounds.
const RESIDUAL_MIN: [f64; 2] = [0.004, 0.03];
/// By so much a missing command has to explain the motion better than the command itself.
const EVIDENCE: f64 = 6.0;

/// Where a vehicle is at some moment, as far as is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The state.
    pub state: State,
    /// The speed that the model and a slow observer say, m/s: a law that adds to this one closes no second loop round
    /// the vehicle's own.
    pub reference_speed_mps: f64,
    /// How long before that moment the last state was flown that was heard, s.
    pub age_s: f64,
    /// Covariance of the position (north, east), m2. It grows with age; how fast is learnt from the flight itself.
    pub covariance_m2: Matrix2<f64>,
    /// Variance that the velocity gains in a second by what no model foresees, as gusts, m2/s3.
    pub velocity_walk_m2ps3: f64,
}

impl Estimate {
    /// The same of the position some seconds later, m: what is not known until something can be done about it.
    pub fn position_std_after_m(&self, later_s: f64) -> f64 {
        let cube = |time_s: f64| time_s * time_s * time_s;
        let gained_m2 = self.velocity_walk_m2ps3 * (cube(self.age_s + later_s) - cube(self.age_s)) / 3.0;
        let now_m = self.position_std_m();
        (now_m * now_m + gained_m2).sqrt()
    }

    /// Standard deviation of the position along its worst direction, m.
    pub fn position_std_m(&self) -> f64 {
        self.covariance_m2.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}

/// One vehicle's present.
///
/// ```
/// use controller::Present;
/// use flight_model::{Dynamics, Setpoint, State};
///
/// // 10 m/s to the north, last seen at 1.0 s; a command takes 0.2 s to the vehicle.
/// let mut present = Present::new(&Dynamics::default());
/// let seen = State { altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
/// present.hear(1.0, &seen);
/// present.set_command_delay_s(0.2);
/// present.command(1.2, &Setpoint { course_rad: 0.5, ..seen.hold() });
///
/// // Up to 1.4 s it flies straight on; then it turns.
/// let before = present.at(1.4).expect("it has been seen");
/// assert!((before.state.x_m - 4.0).abs() < 1e-9 && before.state.course_rad == 0.0);
/// assert!(present.at(1.6).expect("it has been seen").state.course_rad > 0.1);
/// ```
#[derive(Clone, Debug)]
pub struct Present {
    dynamics: Dynamics,
    model: Autopilot,
    commands: Commands,
    command_delay_s: f64,
    fix: Option<Fix>,
    /// Time and heading, rad.
    headings: VecDeque<(f64, f64)>,
    speed: SpeedObserver,
    holds_ground_speed: bool,
    settles_slowly: bool,
    wind: WindEstimate,
    /// Squares of the residuals of course and speed, slowly averaged.
    residuals: [f64; 2],
    /// Time between two states, slowly averaged, s.
    interval_s: f64,
    error: PredictionError,
}

/// A state with its time.
#[derive(Clone, Copy, Debug)]
struct Fix {
    at_s: f64,
    state: State,
}

impl Present {
    /// A vehicle of which nothing is heard yet.
    pub fn new(dynamics: &Dynamics) -> Self {
        Self {
            dynamics: *dynamics,
            model: Autopilot::new(dynamics, STEP_S),
            commands: Commands::default(),
            command_delay_s: 0.0,
            fix: None,
            headings: VecDeque::new(),
            speed: SpeedObserver::default(),
            holds_ground_speed: false,
            settles_slowly: true,
            wind: WindEstimate::default(),
            residuals: RESIDUAL_MIN.map(|least| least * least),
            interval_s: 0.1,
            error: PredictionError::default(),
        }
    }

    /// From now on it flies like this.
    pub fn set_dynamics(&mut self, dynamics: &Dynamics) {
        self.dynamics = *dynamics;
        self.model = Autopilot::new(dynamics, STEP_S);
    }

    /// How it flies, as far as is known.
    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// Whether the vehicle finds the airspeed for a speed over ground itself. Else its setpoints are airspeeds.
    pub fn set_holds_ground_speed(&mut self, holds_ground_speed: bool) {
        self.holds_ground_speed = holds_ground_speed;
    }

    /// Whether its speed loop is no Eq. 1, but settles slowly or on something else: a slow observer then tells the
    /// reference speed, and what is to be taken off a setpoint. Else the measured speed is the reference.
    pub fn set_settles_slowly(&mut self, settles_slowly: bool) {
        self.settles_slowly = settles_slowly;
    }

    /// Commands take this long to the vehicle, s, as is known now: those that have been sent took as long.
    pub fn set_command_delay_s(&mut self, delay_s: f64) {
        let delay_s = delay_s.max(0.0);
        self.commands.delay(delay_s - self.command_delay_s);
        self.command_delay_s = delay_s;
    }

    /// How long a command takes to the vehicle, s.
    pub fn command_delay_s(&self) -> f64 {
        self.command_delay_s
    }

    /// A command that is sent now turns the vehicle after this, s: the link's delay and the dead time of its course
    /// loop.
    pub fn acts_after_s(&self) -> f64 {
        self.command_delay_s + self.dynamics.response.course_dead_time_s
    }

    /// What was heard so far was flown later by this than was thought, s; earlier, below zero. So it is when the delay
    /// of a link becomes known.
    pub fn shift_heard(&mut self, by_s: f64) {
        if let Some(fix) = &mut self.fix {
            fix.at_s += by_s;
        }
        self.headings.iter_mut().for_each(|(at_s, _)| *at_s += by_s);
        self.error.shift(by_s);
    }

    /// A command has been sent. The same one may be sent again: whichever comes first acts.
    pub fn command(&mut self, sent_s: f64, setpoint: &Setpoint) {
        self.commands.push(sent_s + self.command_delay_s, setpoint);
    }

    /// Takes a state with the time at which it was flown; one that is not later than the last is not taken.
    pub fn hear(&mut self, at_s: f64, state: &State) {
        if !state.is_finite() || self.fix.is_some_and(|last| at_s <= last.at_s) {
            return;
        }
        self.error.flown(at_s, state);
        match self.fix {
            Some(last) if at_s - last.at_s < AHEAD_MAX_S => {
                self.judge_commands(&last, at_s, state);
                self.interval_s += 0.05 * (at_s - last.at_s - self.interval_s);
                let modelled = self.fly(&Fix { at_s: last.at_s, state: self.with_speed(&last.state) }, at_s);
                self.speed.follow(at_s - last.at_s, modelled.speed_mps, state.speed_mps);
            }
            _ => self.speed.begin(state.speed_mps),
        }
        self.fix = Some(Fix { at_s, state: *state });
        self.commands.forget_before(at_s);
        while self.headings.front().is_some_and(|&(heard_s, _)| heard_s < at_s - HEADINGS_KEPT_S) {
            self.headings.pop_front();
        }
    }

    /// Takes a heading (rad) with the time at which it was flown. Between positions that come slowly it tells the
    /// turn.
    pub fn hear_heading(&mut self, at_s: f64, heading_rad: f64) {
        if heading_rad.is_finite() && self.headings.back().is_none_or(|&(last_s, _)| at_s > last_s) {
            self.headings.push_back((at_s, heading_rad));
            while self.headings.front().is_some_and(|&(heard_s, _)| heard_s < at_s - HEADINGS_KEPT_S) {
                self.headings.pop_front();
            }
        }
    }

    /// Takes an airspeed (m/s), heard at a time; with the last state and heading it tells the wind.
    pub fn hear_airspeed(&mut self, heard_s: f64, airspeed_mps: f64) {
        if let (Some(fix), Some(&(_, heading_rad))) = (self.fix, self.headings.back())
            && airspeed_mps.is_finite()
        {
            let true_mps = airspeed_mps * self.dynamics.response.speed_gain;
            self.wind.hear(heard_s, &fix.state, true_mps, heading_rad);
        }
    }

    /// The wind (north, east) as the vehicle's own measurements tell it, m/s; none before an airspeed was heard.
    pub fn wind_mps(&self) -> Option<Vector2<f64>> {
        self.wind.velocity_mps()
    }

    /// The same; calm before an airspeed was heard.
    pub fn wind(&self) -> Wind {
        let [north_mps, east_mps] = self.wind_mps().unwrap_or_default().into();
        Wind { north_mps, east_mps, up_mps: 0.0 }
    }

    /// The speed to be sent for a wanted setpoint, m/s: over ground for vehicles that hold that, else the airspeed in
    /// the wind of now less the slow bias, within what the vehicle takes.
    pub fn speed_to_send_mps(&self, wanted: &Setpoint) -> f64 {
        if self.holds_ground_speed {
            return wanted.speed_mps - self.speed_bias_mps();
        }
        let (limits, gain) = (self.dynamics.limits, self.dynamics.response.speed_gain);
        let settled = Setpoint { speed_mps: wanted.speed_mps * gain, ..*wanted };
        let asked_mps = self.wind.airspeed_mps(&settled) / gain - self.speed_bias_mps();
        asked_mps.clamp(limits.speed_min_mps, limits.speed_max_mps)
    }

    /// Forgets where it was: its clock began anew.
    pub fn clear(&mut self) {
        self.fix = None;
        self.headings.clear();
    }

    /// Where the vehicle is at a moment; none before anything was heard. A moment before the last state is that state.
    pub fn at(&self, at_s: f64) -> Option<Estimate> {
        let fix = self.latest(at_s)?;
        let last = self.fix?;
        let until_s = at_s.min(last.at_s + AHEAD_MAX_S);
        let state = self.fly(&fix, until_s);
        let reference_speed_mps = if self.settles_slowly {
            self.fly(&Fix { state: self.with_speed(&last.state), ..last }, until_s).speed_mps
        } else {
            state.speed_mps
        };
        let age_s = (at_s - last.at_s).max(0.0);
        let walk = self.walk_m2ps3(last.state.speed_mps);
        let covariance_m2 = self.error.covariance_m2(age_s, walk, state.course_rad);
        let velocity_walk_m2ps3 = walk.max();
        Some(Estimate { state, reference_speed_mps, age_s, covariance_m2, velocity_walk_m2ps3 })
    }

    /// Where the vehicle will be when a command sent at a moment acts on it; remembered, to be compared with what is
    /// flown.
    pub fn foresee(&mut self, at_s: f64) -> Option<Estimate> {
        let estimate = self.at(at_s)?;
        self.error.foretold(at_s, &estimate);
        Some(estimate)
    }

    /// When the last state was flown that was heard, s.
    pub fn heard_s(&self) -> Option<f64> {
        self.fix.map(|fix| fix.at_s)
    }

    /// What is to be taken off a wanted speed, m/s, so that the vehicle settles on it: learnt slowly, from wind, air
    /// density and the loop's gain alike.
    pub fn speed_bias_mps(&self) -> f64 {
        if self.settles_slowly { self.speed.bias_mps() } else { 0.0 }
    }

    /// Root of the mean square of the errors of position along and across the course, m, of what was foreseen; none
    /// before anything was compared.
    pub fn foreseen_error_m(&self) -> Option<[f64; 2]> {
        self.error.root_mean_square_m()
    }

    /// What the velocity gains in a second, along and across the course, beyond what the wire rounds, m2/s3.
    fn walk_m2ps3(&self, speed_mps: f64) -> Vector2<f64> {
        let [course, speed] = self.residuals;
        Vector2::new(speed, course * speed_mps * speed_mps) / self.interval_s
    }

    /// The last state, brought forward by headings that were heard after it, but not beyond a moment.
    fn latest(&self, until_s: f64) -> Option<Fix> {
        let mut fix = self.fix?;
        let newest_s = self.headings.back().map_or(f64::NEG_INFINITY, |&(heard_s, _)| heard_s).min(until_s);
        if newest_s - fix.at_s < HEADING_AFTER_S {
            return Some(fix);
        }
        let Some(mut heading_rad) = self.heading_at(fix.at_s) else { return Some(fix) };
        for &(heard_s, next_rad) in self.headings.iter().filter(|&&(heard_s, _)| heard_s <= until_s) {
            if heard_s <= fix.at_s {
                continue;
            }
            let from = fix.state;
            let modelled = self.fly(&fix, heard_s);
            let turn_rad = wrap_pi(next_rad - heading_rad);
            let mean_mps = 0.5 * (from.speed_mps + modelled.speed_mps);
            let way_m = course_vector(from.course_rad + 0.5 * turn_rad) * (mean_mps * (heard_s - fix.at_s));
            let course_rad = wrap_pi(from.course_rad + turn_rad);
            let (x_m, y_m) = (from.x_m + way_m.x, from.y_m + way_m.y);
            fix = Fix { at_s: heard_s, state: State { x_m, y_m, course_rad, ..modelled } };
            heading_rad = next_rad;
        }
        Some(fix)
    }

    /// The heading at a moment, between those that were heard round it.
    fn heading_at(&self, at_s: f64) -> Option<f64> {
        let next = self.headings.partition_point(|&(heard_s, _)| heard_s < at_s);
        let &(after_s, after_rad) = self.headings.get(next)?;
        let Some(&(before_s, before_rad)) = next.checked_sub(1).and_then(|before| self.headings.get(before)) else {
            return (after_s - at_s < 0.05).then_some(after_rad);
        };
        let share = (at_s - before_s) / (after_s - before_s);
        Some(before_rad + share * wrap_pi(after_rad - before_rad))
    }

    fn with_speed(&self, state: &State) -> State {
        State { speed_mps: self.speed.speed_mps(), ..*state }
    }

    /// The model's flight on the commands as they act.
    fn fly(&self, from: &Fix, to_s: f64) -> State {
        let Fix { mut at_s, mut state } = *from;
        let (hold, wind) = (from.state.hold(), self.wind());
        while to_s - at_s > 1e-6 {
            let setpoint = self.commands.acting(at_s, &self.dynamics.response).unwrap_or(hold);
            if to_s - at_s >= STEP_S {
                state = self.model.step_in_wind(&state, &self.in_air(&setpoint, &wind), &wind);
                at_s += STEP_S;
            } else {
                let rest = Autopilot::new(&self.dynamics, to_s - at_s);
                state = rest.step_in_wind(&state, &self.in_air(&setpoint, &wind), &wind);
                at_s = to_s;
            }
        }
        state
    }

    /// A setpoint over ground as one of airspeed and heading, both before the gain of the speed loop.
    fn in_air(&self, setpoint: &Setpoint, wind: &Wind) -> Setpoint {
        if wind.is_calm() {
            return *setpoint;
        }
        let gain = self.dynamics.response.speed_gain;
        let settled = Setpoint { speed_mps: setpoint.speed_mps * gain, ..*setpoint }.in_air(wind);
        Setpoint { speed_mps: settled.speed_mps / gain, ..settled }
    }

    /// Looks whether the last commands have come: each that has acted by now is taken for lost where the vehicle flew
    /// as if it had never been sent.
    fn judge_commands(&mut self, last: &Fix, at_s: f64, state: &State) {
        let acted = self.commands.acted(at_s, &self.dynamics.response);
        let mut best: Option<(f64, usize, [f64; 2])> = None;
        for lost in 0..=acted.len().min(2) {
            self.commands.assume_lost(acted.clone(), lost);
            let modelled = self.fly(last, at_s);
            let residual = [wrap_pi(state.course_rad - modelled.course_rad), state.speed_mps - modelled.speed_mps]
                .map(|residual| residual * residual);
            let misfit = residual[0] / self.residuals[0] + residual[1] / self.residuals[1] + EVIDENCE * lost as f64;
            if best.is_none_or(|(least, ..)| misfit < least) {
                best = Some((misfit, lost, residual));
            }
        }
        let Some((_, lost, residual)) = best else { return };
        self.commands.assume_lost(acted, lost);
        for ((mean, residual), least) in self.residuals.iter_mut().zip(residual).zip(RESIDUAL_MIN) {
            *mean = (*mean + 0.05 * (residual - *mean)).max(least * least);
        }
    }
}

#[cfg(test)]
mod tests;
