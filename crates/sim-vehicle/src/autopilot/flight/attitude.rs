//! Flying by an attitude and a throttle that somebody else sets, through the same three loops.
//!
//! The flight model has neither surfaces nor drag, so a coordinated, quasi-steady flight stands in for them: a bank
//! turns at g tan(roll) / V, a pitch climbs at V tan(pitch) without an angle of attack, and the throttle is a share of
//! the greatest power, which keeps up the speed against a drag that grows with its cube, and lifts.

use flight_model::{Limits, Setpoint, State};
use std::f64::consts::FRAC_PI_2;

/// Throttle above which a vehicle on the ground rolls.
const IDLE: f64 = 0.1;
/// Share of the greatest power that the steepest climb costs, as in [`power_share`](super::Flight::power_share).
const CLIMB_POWER: f64 = 0.5;
/// Greatest bank and pitch, rad, that are taken at their word: beyond them there is no rate of turn or climb.
const ANGLE_MAX_RAD: f64 = FRAC_PI_2 - 0.05;

/// An angle that is held, or that moves at a rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Angle {
    pub rad: f64,
    pub rate_radps: f64,
}

impl Angle {
    pub fn held(rad: f64) -> Self {
        Self { rad, rate_radps: 0.0 }
    }

    fn advance(&mut self, step_s: f64) {
        self.rad = (self.rad + self.rate_radps * step_s).clamp(-ANGLE_MAX_RAD, ANGLE_MAX_RAD);
    }
}

/// What is asked for; what is none goes on as it is steered otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AttitudeTarget {
    /// Bank, right wing down above zero.
    pub roll: Option<Angle>,
    /// Nose up above zero.
    pub pitch: Option<Angle>,
    /// 0 to 1: a share of the greatest power.
    pub throttle: Option<f64>,
    /// Whether it takes off from the ground.
    pub takes_off: bool,
}

/// What an attitude is flown with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Craft<'a> {
    pub state: &'a State,
    /// Airspeed and heading in the place of speed and course.
    pub in_air: &'a State,
    pub limits: &'a Limits,
    /// By how much the course loop lags behind a setpoint that turns, s.
    pub course_lag_s: f64,
    /// By how much the altitude loop lags behind a setpoint that climbs, s.
    pub altitude_lag_s: f64,
}

impl AttitudeTarget {
    pub fn is_empty(&self) -> bool {
        self.roll.is_none() && self.pitch.is_none() && self.throttle.is_none()
    }

    /// Whether it makes a vehicle roll on the ground.
    pub(super) fn makes_roll(&self) -> bool {
        self.takes_off && self.throttle.is_some_and(|throttle| throttle > IDLE)
    }

    /// Whether it lifts a vehicle off.
    pub(super) fn lifts(&self) -> bool {
        self.takes_off && self.pitch.is_some_and(|pitch| pitch.rad > 0.0)
    }

    /// Angles move on by a step.
    pub(super) fn advance(&mut self, step_s: f64) {
        for angle in [&mut self.roll, &mut self.pitch].into_iter().flatten() {
            angle.advance(step_s);
        }
    }

    /// A setpoint with what is asked for in the place of what was held. With a bank its course is a heading.
    pub(super) fn steer(&self, mut setpoint: Setpoint, craft: &Craft<'_>) -> Setpoint {
        let Craft { state, in_air, limits, .. } = *craft;
        let airspeed_mps = in_air.speed_mps.max(1.0);
        if let Some(roll) = self.roll {
            let turn_rate_radps = limits.gravity_mps2 * libm::tan(roll.rad) / airspeed_mps;
            setpoint.course_rad = in_air.course_rad + turn_rate_radps * craft.course_lag_s;
        }
        let mut climb_mps = state.climb_mps;
        if let Some(pitch) = self.pitch {
            climb_mps = (airspeed_mps * libm::tan(pitch.rad)).clamp(limits.climb_min_mps, limits.climb_max_mps);
            setpoint.altitude_m = state.altitude_m + climb_mps * craft.altitude_lag_s;
        }
        if let Some(throttle) = self.throttle {
            let speed_mps = speed_by_power_mps(throttle, climb_mps, limits);
            setpoint.speed_mps = speed_mps.max(limits.speed_min_mps);
            if speed_mps < limits.speed_min_mps {
                // It does not get slower, and cannot hold its height.
                let climb_mps = climb_by_power_mps(throttle, limits.speed_min_mps, limits);
                let highest_m = state.altitude_m + climb_mps * craft.altitude_lag_s;
                setpoint.altitude_m = setpoint.altitude_m.min(highest_m);
            }
        }
        setpoint
    }
}

/// The airspeed that a share of the power keeps up at a rate of climb, m/s.
fn speed_by_power_mps(share: f64, climb_mps: f64, limits: &Limits) -> f64 {
    let left = share - CLIMB_POWER * climb_mps / limits.climb_max_mps;
    limits.speed_max_mps * libm::cbrt(left.max(0.0)).min(1.0)
}

/// The rate of climb that a share of the power keeps up at an airspeed, m/s.
fn climb_by_power_mps(share: f64, airspeed_mps: f64, limits: &Limits) -> f64 {
    let speed = airspeed_mps / limits.speed_max_mps;
    ((share - speed * speed * speed) * limits.climb_max_mps / CLIMB_POWER).max(limits.climb_min_mps)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        speed_min_mps: 10.0,
        speed_max_mps: 30.0,
        climb_min_mps: -5.0,
        climb_max_mps: 5.0,
        lateral_overload_max: 1.0,
        gravity_mps2: 10.0,
    };

    fn steered(target: AttitudeTarget) -> Setpoint {
        let state = State { altitude_m: 100.0, speed_mps: 20.0, ..State::default() };
        let craft = Craft { state: &state, in_air: &state, limits: &LIMITS, course_lag_s: 2.0, altitude_lag_s: 3.0 };
        target.steer(state.hold(), &craft)
    }

    #[test]
    fn a_bank_turns_and_a_pitch_climbs() {
        let roll = AttitudeTarget { roll: Some(Angle::held(0.3)), ..AttitudeTarget::default() };
        let turn = steered(roll);
        assert!((turn.course_rad - 2.0 * 10.0 * libm::tan(0.3) / 20.0).abs() < 1e-12);
        assert_eq!((turn.speed_mps, turn.altitude_m), (20.0, 100.0));
        let pitch = AttitudeTarget { pitch: Some(Angle::held(-0.1)), ..AttitudeTarget::default() };
        assert!((steered(pitch).altitude_m - (100.0 - 3.0 * 20.0 * libm::tan(0.1))).abs() < 1e-12);
        let steep = AttitudeTarget { pitch: Some(Angle::held(1.0)), ..AttitudeTarget::default() };
        assert_eq!(steered(steep).altitude_m, 100.0 + 3.0 * 5.0);
    }

    #[test]
    fn a_throttle_keeps_up_a_speed_and_what_it_cannot_costs_height() {
        let throttle = |share| AttitudeTarget { throttle: Some(share), ..AttitudeTarget::default() };
        assert_eq!(steered(throttle(1.0)).speed_mps, 30.0);
        assert!((steered(throttle(0.125)).speed_mps - 15.0).abs() < 1e-9);
        let idle = steered(throttle(0.0));
        assert!(idle.speed_mps == 10.0 && idle.altitude_m < 100.0, "{idle:?}");
        let climb = AttitudeTarget { pitch: Some(Angle::held(0.4)), ..throttle(0.625) };
        assert!((steered(climb).speed_mps - 15.0).abs() < 1e-9);
    }

    #[test]
    fn a_rate_moves_its_angle_and_ends_before_the_vertical() {
        let roll = Angle { rad: 0.0, rate_radps: 0.5 };
        let mut target = AttitudeTarget { roll: Some(roll), ..AttitudeTarget::default() };
        target.advance(0.1);
        assert_eq!(target.roll, Some(Angle { rad: 0.05, ..roll }));
        target.advance(100.0);
        assert_eq!(target.roll.map(|roll| roll.rad), Some(ANGLE_MAX_RAD));
    }
}
