//! On the ground: standing, the run before a take-off, touching down and rolling out.

use super::{Flight, Home, Stage};
use crate::mode::Mode;
use flight_model::State;

/// What bears the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contact {
    /// The launch rail, where it starts: in the air, motionless.
    Rail,
    Ground,
    Air,
}

/// What happens between the vehicle and the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Event {
    /// Rate of descent at which it hit the ground; at more than it bears it has stopped there, disarmed.
    TouchedDown { sink_mps: f64 },
}

/// Acceleration of the run before a take-off, m/s2.
const RUN_MPS2: f64 = 3.0;
/// Deceleration of a vehicle that rolls without its engine, m/s2.
const BRAKE_MPS2: f64 = 2.0;
/// Greatest rate of descent that a touch-down bears, m/s.
const SINK_BORNE_MPS: f64 = 3.0;

impl Flight {
    /// Begins at rest on the ground below the start, disarmed, in MANUAL and at home, as ArduPlane boots.
    pub(super) fn stand_on_ground(&mut self) {
        self.contact = Contact::Ground;
        self.state = State { speed_mps: 0.0, climb_mps: 0.0, altitude_m: 0.0, ..self.start };
        self.home = Home { x_m: self.start.x_m, y_m: self.start.y_m, altitude_m: 0.0 };
        self.mode = Mode::Manual;
        self.enter(Mode::Manual);
    }

    /// Altitude of the ground, m above the origin: level with it, or with a start below it.
    pub(super) fn ground_m(&self) -> f64 {
        self.start.altitude_m.min(0.0)
    }

    /// A vehicle that takes off runs until it lifts off at its least airspeed; any other slows down.
    pub(super) fn step_on_ground(&mut self) {
        let step_s = self.autopilot.step_s();
        let (hands_run, hands_lift) = self.hands_take_off();
        let takes_off = matches!(self.stage, Stage::Takeoff);
        let runs = self.is_engine_running() && (takes_off || hands_run);
        let acceleration_mps2 = if runs { RUN_MPS2 } else { -BRAKE_MPS2 };
        let before_mps = self.state.speed_mps;
        // The speed asked for is an airspeed: down the wind the run is as much faster.
        let tail_wind_mps = before_mps - self.lift_off_speed_mps();
        let fastest_mps = (self.speed.target + tail_wind_mps).max(before_mps);
        let after_mps = (before_mps + acceleration_mps2 * step_s).clamp(0.0, fastest_mps);
        let run_m = 0.5 * (before_mps + after_mps) * step_s;
        let (sin, cos) = libm::sincos(self.state.course_rad);
        self.roll_to(State {
            x_m: self.state.x_m + run_m * cos,
            y_m: self.state.y_m + run_m * sin,
            speed_mps: after_mps,
            ..self.state
        });
        if runs && (takes_off || hands_lift) && self.lift_off_speed_mps() >= self.dynamics.limits.speed_min_mps {
            self.contact = Contact::Air;
        }
    }

    /// Who descends onto the ground is on it from then on.
    pub(super) fn touch_down(&mut self) -> Option<Event> {
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
        Some(Event::TouchedDown { sink_mps })
    }
}
