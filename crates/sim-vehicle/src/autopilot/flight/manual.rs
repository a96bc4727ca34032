//! Flying by the sticks: bank, climb and speed, through the same three loops.

use super::{Flight, Ramp};
use crate::mode::Mode;
use flight_model::Setpoint;

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

/// Greatest bank that a stick asks for, rad: ArduPlane's default of ROLL_LIMIT_DEG, 45 degrees.
const BANK_MAX_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Rate of climb of a full stick in FBWB and CRUISE, m/s: ArduPlane's default of FBWB_CLIMB_RATE.
const CLIMB_MPS: f64 = 2.0;
/// Climb over speed of a full stick in the other modes: ArduPlane's default pitch limit, 20 degrees.
const SLOPE: f64 = 0.364;
/// Throttle above which a vehicle on the ground rolls.
const IDLE: f64 = 0.1;

impl Flight {
    /// What the sticks say from now on; none: nobody holds any. Who lets go of one goes on as it is.
    pub fn set_sticks(&mut self, sticks: Option<Sticks>) {
        let before = std::mem::replace(&mut self.sticks, sticks);
        if before == sticks || !self.is_flown_by_hand() {
            return;
        }
        let held = |sticks: Option<Sticks>, stick: fn(Sticks) -> f64| sticks.is_some_and(|s| stick(s) != 0.0);
        if held(before, |s| s.roll) && !held(sticks, |s| s.roll) {
            self.hold_course();
        }
        if held(before, |s| s.pitch) && !held(sticks, |s| s.pitch) {
            self.altitude = Ramp::at(self.state.altitude_m);
        }
        if let Some(throttle) = sticks.and_then(|sticks| sticks.throttle) {
            let limits = self.dynamics.limits;
            self.set_speed(
                limits.speed_min_mps + throttle * (limits.speed_max_mps - limits.speed_min_mps),
                f64::INFINITY,
            );
        }
    }

    fn is_flown_by_hand(&self) -> bool {
        matches!(self.mode, Mode::Manual | Mode::Stabilize | Mode::Fbwa | Mode::Fbwb | Mode::Cruise)
    }

    /// The sticks, in the modes that they fly.
    fn hands(&self) -> Option<Sticks> {
        self.sticks.filter(|_| self.is_flown_by_hand())
    }

    /// Whether the sticks make it roll on the ground, and whether they lift it off.
    pub(super) fn hands_take_off(&self) -> (bool, bool) {
        let hands = self.hands();
        (
            hands.is_some_and(|sticks| sticks.throttle.is_some_and(|throttle| throttle > IDLE)),
            hands.is_some_and(|sticks| sticks.pitch > 0.0),
        )
    }

    /// A setpoint with what the sticks ask for in the place of what was held.
    pub(super) fn by_hand(&self, mut setpoint: Setpoint) -> Setpoint {
        let Some(sticks) = self.hands() else { return setpoint };
        let airspeed_mps = self.airspeed_mps();
        if sticks.roll != 0.0 {
            let gravity_mps2 = self.dynamics.limits.gravity_mps2;
            let turn_rate_radps = gravity_mps2 * libm::tan(sticks.roll * BANK_MAX_RAD) / airspeed_mps.max(1.0);
            // The course loop turns by its error over its time constant.
            setpoint.course_rad = self.state.course_rad + turn_rate_radps * self.dynamics.time_constants.course_s;
        }
        if sticks.pitch != 0.0 {
            let full_mps =
                if matches!(self.mode, Mode::Fbwb | Mode::Cruise) { CLIMB_MPS } else { SLOPE * airspeed_mps };
            setpoint.altitude_m = self.altitude_to_climb_at(sticks.pitch * full_mps);
        }
        setpoint
    }
}
