//! One integration step: in the air, on the ground, and between them.

use super::air::Wanted;
use super::attitude::Craft;
use super::ground::{BRAKE_MPS2, Contact, RUN_MPS2, SINK_BORNE_MPS, TouchDown};
use super::guidance::Direction;
use super::landing::View;
use super::manual::Sticks;
use super::tuning::TAKEOFF_TOLERANCE_M;
use super::{Flight, Stage};
use crate::mode::Mode;
use flight_model::{Setpoint, Wind};

/// Share of the lift in the drag of a vehicle that glides: it sinks by its speed over this.
const GLIDE_RATIO: f64 = 10.0;

impl Flight {
    /// The air of the next step; on the rail and on the ground it is not felt. `known` is the wind that the autopilot
    /// reckons with; none: it sees its way over ground.
    pub fn feel(&mut self, wind: Wind, known: Option<Wind>) {
        if self.contact == Contact::Air {
            // A gust from below takes the vehicle along; its altitude loop brings it back.
            self.state.climb_mps += self.air.feel(wind, known);
        } else {
            self.air = super::air::Air::outside(&self.state, wind);
        }
    }

    /// Integrates one step; says what has happened in it. On the rail nothing moves, nor while it is held.
    pub fn step(&mut self) -> Option<TouchDown> {
        if self.is_held {
            return None;
        }
        match self.contact {
            Contact::Rail => None,
            Contact::Ground => {
                self.step_on_ground();
                None
            }
            Contact::Air => self.step_in_air(),
        }
    }

    fn step_in_air(&mut self) -> Option<TouchDown> {
        if self.is_taking_off() {
            self.level_off_when_up();
        }
        let course_rad = self.direction.course_rad(&self.air.estimate(&self.state), &self.limited);
        let mut setpoint =
            Setpoint { speed_mps: self.speed.advance(), course_rad, altitude_m: self.altitude.advance() };
        if self.least_ground_speed_mps > 0.0 {
            let shortfall_mps = self.least_ground_speed_mps - self.state.speed_mps;
            setpoint.speed_mps = setpoint.speed_mps.max(self.equivalent_airspeed_mps() + shortfall_mps);
        }
        setpoint = self.with_first_climb(setpoint);
        if let Some(sticks) = self.hands() {
            let bank_max_rad = self.tuning.stick_bank_max_rad;
            setpoint =
                sticks.steer(setpoint, self.mode, &self.state, self.airspeed_mps(), bank_max_rad, &self.dynamics);
        }
        if let Some(sticks) = self.sticks.filter(|_| self.climbs_by_stick() && !self.mode.is_manual()) {
            setpoint = sticks.climb(setpoint, Mode::Fbwb, &self.state, self.airspeed_mps(), &self.dynamics);
        }
        if self.attitude.is_some() {
            setpoint = self.steer_by_attitude(setpoint);
        }
        let ground_m = self.ground_m();
        if let Stage::Landing(landing) = &mut self.stage {
            let tau = self.dynamics.time_constants;
            let view = View {
                state: &self.state,
                ground_m,
                least_mps: self.dynamics.limits.speed_min_mps,
                altitude_lag_s: tau.altitude_a_s + tau.altitude_b_s,
            };
            setpoint = landing.setpoint(&view, &setpoint);
        }
        if self.is_idle() {
            setpoint.speed_mps = self.dynamics.limits.speed_min_mps;
            setpoint.altitude_m = self.altitude_to_climb_at(-self.airspeed_mps() / GLIDE_RATIO);
        }
        self.fly(&setpoint);
        self.touch_down()
    }

    /// Ends a take-off at its altitude. TAKEOFF goes on by circling there; AUTO has its next item.
    fn level_off_when_up(&mut self) {
        if (self.state.altitude_m - self.altitude.target).abs() > TAKEOFF_TOLERANCE_M {
            return;
        }
        self.stage = Stage::Normal;
        if self.mode == Mode::Takeoff {
            self.circle(self.state.position_m(), self.tuning.loiter_radius_m);
        }
    }

    /// The sticks, in the modes that they fly.
    fn hands(&self) -> Option<Sticks> {
        self.sticks.filter(|_| self.mode.is_manual())
    }

    /// Whether the pitch stick changes its altitude.
    pub(super) fn climbs_by_stick(&self) -> bool {
        self.mode.is_manual() || self.mode == Mode::Loiter && self.tuning.options.climbs_in_loiter
    }

    /// Whether its engine gives nothing: it has none, or it is led down without it.
    pub(crate) fn is_idle(&self) -> bool {
        !self.is_engine_running() || self.glides || self.is_throttle_closed()
    }

    /// Whether somebody holds the throttle closed in a mode in which it is the pilot's.
    fn is_throttle_closed(&self) -> bool {
        let is_pilots = self.mode.idles() && self.is_flying();
        is_pilots && self.hands().is_some_and(|sticks| sticks.close_throttle())
    }

    /// A setpoint with the attitude that somebody else sets in the place of what was held.
    fn steer_by_attitude(&mut self, setpoint: Setpoint) -> Setpoint {
        let step_s = self.autopilot.step_s();
        let Some(attitude) = &mut self.attitude else { return setpoint };
        attitude.advance(step_s);
        let tau = self.dynamics.time_constants;
        let craft = Craft {
            state: &self.state,
            in_air: &self.air.see(&self.state),
            limits: &self.limited.limits,
            course_lag_s: step_s / (1.0 - libm::exp(-step_s / tau.course_s)),
            altitude_lag_s: tau.altitude_a_s + tau.altitude_b_s,
        };
        attitude.steer(setpoint, &craft)
    }

    /// The bank that a pilot or somebody else sets, rad.
    fn wanted_bank_rad(&self) -> Option<f64> {
        let set = self.attitude.and_then(|attitude| attitude.roll).map(|roll| roll.rad);
        set.or_else(|| self.hands().and_then(|sticks| sticks.bank_rad()))
    }

    /// One step of the loops.
    fn fly(&mut self, setpoint: &Setpoint) {
        let is_heading = matches!(self.direction, Direction::Heading(_)) || self.is_banked();
        let wanted = Wanted { is_ground_speed: self.speed_is_over_ground, is_heading };
        let bank_rad = self.wanted_bank_rad();
        if let Some(plant) = &mut self.plant {
            plant.hold_bank(bank_rad);
        }
        let ratio = self.true_airspeed_ratio();
        let setpoint = self.air.through(setpoint, wanted, self.airspeed_mps(), ratio, &self.dynamics);
        self.air.remember(&self.state);
        self.state = match (&mut self.plant, &mut self.dead_times) {
            (Some(plant), _) => plant.step(&self.state, &setpoint, self.air.wind()),
            (None, Some(dead_times)) => {
                self.autopilot.step_in_wind(&self.state, &dead_times.pass(&setpoint), self.air.wind())
            }
            (None, None) => self.autopilot.step_in_wind(&self.state, &setpoint, self.air.wind()),
        };
        self.air.carry(self.autopilot.step_s());
    }

    /// A vehicle that takes off runs until it lifts off at its least airspeed; any other slows down.
    fn step_on_ground(&mut self) {
        let step_s = self.autopilot.step_s();
        let hands = self.hands();
        let hands_run = hands.is_some_and(|sticks| sticks.make_roll());
        let hands_lift = hands.is_some_and(|sticks| sticks.lift());
        let attitude = self.attitude.unwrap_or_default();
        let takes_off = matches!(self.stage, Stage::Takeoff);
        let runs = self.is_engine_running() && (takes_off || hands_run || attitude.makes_roll());
        let acceleration_mps2 = if runs { RUN_MPS2 } else { -BRAKE_MPS2 };
        let before_mps = self.state.speed_mps;
        // The speed asked for is an airspeed: down the wind the run is as much faster.
        let tail_wind_mps = before_mps - self.air.lift_off_speed_mps(&self.state);
        let fastest_mps = (self.speed.target + tail_wind_mps).max(before_mps);
        let after_mps = (before_mps + acceleration_mps2 * step_s).clamp(0.0, fastest_mps);
        let run_m = 0.5 * (before_mps + after_mps) * step_s;
        let (sin, cos) = libm::sincos(self.state.course_rad);
        self.air.remember(&self.state);
        self.state.x_m += run_m * cos;
        self.state.y_m += run_m * sin;
        self.state.speed_mps = after_mps;
        if runs
            && (takes_off || hands_lift || attitude.lifts())
            && self.air.lift_off_speed_mps(&self.state) >= self.dynamics.limits.speed_min_mps
        {
            self.contact = Contact::Air;
            self.begin_flight();
        }
    }

    /// It is in the air from now on: what its loops remember is of an earlier flight.
    pub(super) fn begin_flight(&mut self) {
        let air = self.air.see(&self.state);
        if let Some(plant) = &mut self.plant {
            plant.begin(&self.state, self.air.wind());
        }
        if let Some(dead_times) = &mut self.dead_times {
            dead_times.begin(&air.hold());
        }
    }

    /// Who descends onto the ground is on it from then on.
    fn touch_down(&mut self) -> Option<TouchDown> {
        let ground_m = self.ground_m();
        if self.state.altitude_m > ground_m || self.state.climb_mps >= 0.0 {
            return None;
        }
        let sink_mps = -self.state.climb_mps;
        self.contact = Contact::Ground;
        self.state.altitude_m = ground_m;
        self.state.climb_mps = 0.0;
        if sink_mps > SINK_BORNE_MPS {
            self.state.speed_mps = 0.0;
            self.disarm();
        }
        Some(TouchDown { sink_mps })
    }

    /// Altitude of the ground, m above the origin: level with it, or with a start below it.
    fn ground_m(&self) -> f64 {
        self.start.altitude_m.min(0.0)
    }
}
