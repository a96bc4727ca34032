//! Equivalent airspeed, as a total energy controller holds it.
//!
//! The demand moves to the setpoint at a limited acceleration. That acceleration is fed forward to the throttle, which
//! gives the speed a push at once and takes it back when the demand has arrived; the energy balance brings the speed
//! to the demand slowly, and overshoots.

use super::second_order::SecondOrder;
use crate::{Limits, Ranges};

/// Constants of the speed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLoopSettings {
    /// A new setpoint acts after this, s.
    pub dead_time_s: f64,
    /// Fastest rise of the demand, m/s2.
    pub acceleration_max_mps2: f64,
    /// Fastest fall of the demand, m/s2, above zero.
    pub deceleration_max_mps2: f64,
    /// Speed of the push for each m/s2 of the demand's acceleration, s.
    pub push_s: f64,
    /// Natural frequency of the push, rad/s.
    pub push_frequency_radps: f64,
    /// Damping of the push.
    pub push_damping: f64,
    /// Natural frequency of the energy balance, rad/s.
    pub frequency_radps: f64,
    /// Damping of the energy balance.
    pub damping: f64,
    /// Airspeed that it settles on, less its setpoint, m/s.
    pub standing_error_mps: f64,
}

impl SpeedLoopSettings {
    /// Fitted to steps of 2 and 5 m/s of an ArduPlane at 13 to 25 m/s: 4 to 14 % of the step, where Eq. 1 leaves 20 to
    /// 30 %.
    pub fn plane() -> Self {
        Self {
            dead_time_s: 0.3,
            acceleration_max_mps2: 1.3,
            deceleration_max_mps2: 0.87,
            push_s: 1.65,
            push_frequency_radps: 4.8,
            push_damping: 1.0,
            frequency_radps: 0.41,
            damping: 0.45,
            standing_error_mps: 0.0,
        }
    }

    /// From 11 to 14 m/s half the step after 1.6 s and 90 % after 2.9 s, and 1 to 1.5 m/s too slow for good.
    pub fn px4_plane() -> Self {
        Self {
            dead_time_s: 0.2,
            acceleration_max_mps2: 2.5,
            deceleration_max_mps2: 2.5,
            push_s: 0.0,
            push_frequency_radps: 5.0,
            push_damping: 1.0,
            frequency_radps: 2.2,
            damping: 1.0,
            standing_error_mps: -1.2,
        }
    }

    pub(super) fn check(&self, ranges: &mut Ranges) {
        ranges.within("speed_loop_dead_time_s", self.dead_time_s, 0.0, 10.0);
        ranges.within("acceleration_max_mps2", self.acceleration_max_mps2, 0.01, 100.0);
        ranges.within("deceleration_max_mps2", self.deceleration_max_mps2, 0.01, 100.0);
        ranges.within("push_s", self.push_s, 0.0, 10.0);
        ranges.within("push_frequency_radps", self.push_frequency_radps, 0.05, 50.0);
        ranges.within("push_damping", self.push_damping, 0.05, 10.0);
        ranges.within("speed_frequency_radps", self.frequency_radps, 0.05, 50.0);
        ranges.within("speed_damping", self.damping, 0.05, 10.0);
        ranges.within("speed_standing_error_mps", self.standing_error_mps, -10.0, 10.0);
    }
}

/// The loop, and where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedLoop {
    settings: SpeedLoopSettings,
    step_s: f64,
    demand_mps: f64,
    balance: SecondOrder,
    push: SecondOrder,
}

impl SpeedLoop {
    pub fn new(settings: &SpeedLoopSettings, step_s: f64) -> Self {
        Self {
            settings: *settings,
            step_s,
            demand_mps: 0.0,
            balance: SecondOrder::new(settings.frequency_radps, settings.damping, step_s),
            push: SecondOrder::new(settings.push_frequency_radps, settings.push_damping, step_s),
        }
    }

    /// Settled at an airspeed.
    pub fn begin(&mut self, airspeed_mps: f64) {
        self.demand_mps = airspeed_mps;
        self.balance.begin(airspeed_mps);
        self.push.begin(0.0);
    }

    /// Something else than this loop has changed the airspeed to this.
    pub fn meet(&mut self, airspeed_mps: f64) {
        self.balance.value += airspeed_mps - self.airspeed_mps();
    }

    fn airspeed_mps(&self) -> f64 {
        self.balance.value + self.push.value
    }

    /// How far the airspeed is above the demand, m/s.
    pub fn error_mps(&self) -> f64 {
        self.airspeed_mps() - self.demand_mps
    }

    /// One step towards a setpoint; gives the airspeed after it, within the limits. Only a gust carries it out of
    /// these, and then no step makes up for it at once.
    pub fn step(&mut self, setpoint_mps: f64, limits: &Limits) -> f64 {
        let settings = &self.settings;
        let least_mps = limits.speed_min_mps.min(self.airspeed_mps());
        let most_mps = limits.speed_max_mps.max(self.airspeed_mps());
        let wanted_mps = (setpoint_mps + settings.standing_error_mps).clamp(limits.speed_min_mps, limits.speed_max_mps);
        let change_mps = (wanted_mps - self.demand_mps)
            .clamp(-settings.deceleration_max_mps2 * self.step_s, settings.acceleration_max_mps2 * self.step_s);
        self.demand_mps += change_mps;
        self.balance.step(self.demand_mps);
        self.push.step(settings.push_s * change_mps / self.step_s);
        let airspeed_mps = self.airspeed_mps().clamp(least_mps, most_mps);
        self.meet(airspeed_mps);
        airspeed_mps
    }
}
