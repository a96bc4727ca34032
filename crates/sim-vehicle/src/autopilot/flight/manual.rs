//! Flying by the sticks: bank, climb and speed, through the same three loops.

use crate::mode::Mode;
use flight_model::{Dynamics, Setpoint, State};

/// Where the sticks are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sticks {
    /// -1 left to 1 right.
    pub roll: f64,
    /// -1 nose down to 1 nose up.
    pub pitch: f64,
    /// 0 to 1; none: nobody holds it.
    pub throttle: Option<f64>,
}

/// Greatest bank that a stick asks for, rad, where nobody has set ROLL_LIMIT_DEG: ArduPlane's default of 45 degrees.
pub(super) const BANK_MAX_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Rate of climb of a full stick in FBWB and CRUISE, m/s: ArduPlane's default of FBWB_CLIMB_RATE.
const CLIMB_MPS: f64 = 2.0;
/// Climb over speed of a full stick in the other modes: ArduPlane's default pitch limit, 20 degrees.
const SLOPE: f64 = 0.364;
/// Throttle above which a vehicle on the ground rolls.
const IDLE: f64 = 0.1;

impl Sticks {
    /// Whether they make a vehicle roll on the ground.
    pub(super) fn make_roll(&self) -> bool {
        self.throttle.is_some_and(|throttle| throttle > IDLE)
    }

    /// Whether they close the throttle, within ArduPilot's dead zone of 30 microseconds.
    pub(super) fn close_throttle(&self) -> bool {
        const CLOSED: f64 = 0.03;
        self.throttle.is_some_and(|throttle| throttle <= CLOSED)
    }

    /// Whether they lift it off.
    pub(super) fn lift(&self) -> bool {
        self.pitch > 0.0
    }

    /// The bank that they ask for, rad; none in the middle.
    pub(super) fn bank_rad(&self) -> Option<f64> {
        (self.roll != 0.0).then_some(self.roll * BANK_MAX_RAD)
    }

    /// A setpoint with what the sticks ask for in the place of what was held.
    pub(super) fn steer(
        &self,
        mut setpoint: Setpoint,
        mode: Mode,
        state: &State,
        airspeed_mps: f64,
        bank_max_rad: f64,
        dynamics: &Dynamics,
    ) -> Setpoint {
        if self.roll != 0.0 {
            let gravity_mps2 = dynamics.limits.gravity_mps2;
            let turn_rate_radps = gravity_mps2 * libm::tan(self.roll * bank_max_rad) / airspeed_mps.max(1.0);
            // The course loop turns by its error over its time constant.
            setpoint.course_rad = state.course_rad + turn_rate_radps * dynamics.time_constants.course_s;
        }
        self.climb(setpoint, mode, state, airspeed_mps, dynamics)
    }

    /// A setpoint with the climb that the pitch stick asks for in the place of the altitude that was held.
    pub(super) fn climb(
        &self,
        mut setpoint: Setpoint,
        mode: Mode,
        state: &State,
        airspeed_mps: f64,
        dynamics: &Dynamics,
    ) -> Setpoint {
        if self.pitch != 0.0 {
            let tau = dynamics.time_constants;
            let full_mps = if mode.holds_speed() { CLIMB_MPS } else { SLOPE * airspeed_mps };
            let climb_mps = self.pitch * full_mps;
            setpoint.altitude_m = state.altitude_m + climb_mps * (tau.altitude_a_s + tau.altitude_b_s);
        }
        setpoint
    }
}
