//! Course, by banking.
//!
//! The bank asked for is proportional to the course error, up to the bank limit; so the turn is faster than in
//! proportion at large errors, by the tangent of the bank. The lift that a bank needs is pulled with a lag, and
//! overshoots in hard turns. Sideslip takes a share of the turn after a moment. In small turns this is Eq. 1 with the
//! time constant V / (g * bank per error * settled share), and a dead time.

use super::second_order::SecondOrder;
use crate::{Limits, Ranges};

/// Constants of the course loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseLoopSettings {
    /// A new setpoint acts after this, s.
    pub dead_time_s: f64,
    /// Bank asked for by a course error, rad for each rad.
    pub bank_per_error: f64,
    /// Natural frequency of the bank, rad/s.
    pub bank_frequency_radps: f64,
    /// Damping of the bank.
    pub bank_damping: f64,
    /// Fastest roll, rad/s.
    pub bank_rate_max_radps: f64,
    /// Natural frequency of the lift, rad/s.
    pub lift_frequency_radps: f64,
    /// Damping of the lift.
    pub lift_damping: f64,
    /// Lateral acceleration at once, as a share of that of a coordinated turn.
    pub turn_share_first: f64,
    /// The same in a steady turn.
    pub turn_share_settled: f64,
    /// Natural frequency of the sideslip that makes the difference, rad/s.
    pub slip_frequency_radps: f64,
    /// Damping of the sideslip.
    pub slip_damping: f64,
}

impl CourseLoopSettings {
    /// Fitted to course steps of 10 to 178 degrees of an ArduPlane at 15, 21 and 28 m/s: 1 % of the step up to 45
    /// degrees, at most 3 % beyond. `bank_per_error` is its GUIDED_P of 5000 centidegrees for each rad.
    pub fn plane() -> Self {
        Self {
            dead_time_s: 0.1,
            bank_per_error: 50_f64.to_radians(),
            bank_frequency_radps: 4.43,
            bank_damping: 0.354,
            bank_rate_max_radps: 1.76,
            lift_frequency_radps: 3.08,
            lift_damping: 0.106,
            turn_share_first: 1.19,
            turn_share_settled: 0.733,
            slip_frequency_radps: 4.59,
            slip_damping: 0.25,
        }
    }

    /// Fitted to the times that course steps of 30 to 170 degrees took a PX4 at 14 m/s: within 0.25 s.
    pub fn px4_plane() -> Self {
        Self {
            dead_time_s: 0.1,
            bank_per_error: 0.9,
            bank_frequency_radps: 5.1,
            bank_damping: 1.5,
            bank_rate_max_radps: 3.0,
            lift_frequency_radps: 50.0,
            lift_damping: 1.0,
            turn_share_first: 1.0,
            turn_share_settled: 1.0,
            slip_frequency_radps: 5.0,
            slip_damping: 1.0,
        }
    }

    pub(super) fn check(&self, ranges: &mut Ranges) {
        ranges.within("course_loop_dead_time_s", self.dead_time_s, 0.0, 10.0);
        ranges.within("bank_per_error", self.bank_per_error, 0.01, 20.0);
        ranges.within("bank_frequency_radps", self.bank_frequency_radps, 0.05, 50.0);
        ranges.within("bank_damping", self.bank_damping, 0.05, 10.0);
        ranges.within("bank_rate_max_radps", self.bank_rate_max_radps, 0.05, 20.0);
        ranges.within("lift_frequency_radps", self.lift_frequency_radps, 0.05, 50.0);
        ranges.within("lift_damping", self.lift_damping, 0.05, 10.0);
        ranges.within("turn_share_first", self.turn_share_first, 0.1, 3.0);
        ranges.within("turn_share_settled", self.turn_share_settled, 0.1, 3.0);
        ranges.within("slip_frequency_radps", self.slip_frequency_radps, 0.05, 50.0);
        ranges.within("slip_damping", self.slip_damping, 0.05, 10.0);
    }
}

/// The loop, and where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct CourseLoop {
    settings: CourseLoopSettings,
    step_s: f64,
    /// Bank, rad.
    bank: SecondOrder,
    /// Lift in g, less that of level flight.
    lift: SecondOrder,
    /// Lateral acceleration that the sideslip has caught up with, m/s2.
    slip: SecondOrder,
}

/// A bank overshoots its limit by no more, rad: 11 degrees. Its tangent stays finite.
const OVERSHOOT_MAX_RAD: f64 = 0.19;
const BANK_MAX_RAD: f64 = 1.5;
/// Nor does it turn faster where it hardly flies, m/s.
const SPEED_LEAST_MPS: f64 = 1.0;

impl CourseLoop {
    pub fn new(settings: &CourseLoopSettings, step_s: f64) -> Self {
        Self {
            settings: *settings,
            step_s,
            bank: SecondOrder::new(settings.bank_frequency_radps, settings.bank_damping, step_s),
            lift: SecondOrder::new(settings.lift_frequency_radps, settings.lift_damping, step_s),
            slip: SecondOrder::new(settings.slip_frequency_radps, settings.slip_damping, step_s),
        }
    }

    /// Wings level.
    pub fn begin(&mut self) {
        self.bank.begin(0.0);
        self.lift.begin(0.0);
        self.slip.begin(0.0);
    }

    pub fn bank_rad(&self) -> f64 {
        self.bank.value
    }

    /// The bank that is asked for by a course error, both in rad.
    pub fn wanted_bank_rad(&self, error_rad: f64) -> f64 {
        self.settings.bank_per_error * error_rad
    }

    /// One step with a bank that is asked for, rad, at a true airspeed in m/s; gives the turn, rad. A nose that goes up
    /// or down by itself, rad/s, pulls more lift than the bank needs, or takes it.
    pub fn step(&mut self, bank_rad: f64, pitch_rate_radps: f64, speed_mps: f64, limits: &Limits) -> f64 {
        let settings = &self.settings;
        let limit_rad = libm::atan(limits.lateral_overload_max);
        let wanted_rad = bank_rad.clamp(-limit_rad, limit_rad);
        self.bank.step_limited(wanted_rad, settings.bank_rate_max_radps, self.step_s);
        self.bank.stop_at((limit_rad + OVERSHOOT_MAX_RAD).min(BANK_MAX_RAD));
        let bank_rad = self.bank.value;
        let (sin, cos) = libm::sincos(bank_rad);
        let swing_g = speed_mps * pitch_rate_radps / limits.gravity_mps2;
        let lift_g = (1.0 + self.lift.step(1.0 / cos - 1.0)).max(0.0) + swing_g;
        let coordinated_mps2 = limits.gravity_mps2 * lift_g * sin;
        let slipped_mps2 = self.slip.step(coordinated_mps2);
        let lateral_mps2 = settings.turn_share_first * coordinated_mps2
            + (settings.turn_share_settled - settings.turn_share_first) * slipped_mps2;
        lateral_mps2 / speed_mps.max(SPEED_LEAST_MPS) * self.step_s
    }
}
