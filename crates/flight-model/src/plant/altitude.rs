//! Altitude, by a demand that moves.
//!
//! The demand moves to the setpoint at the limits of climb and descent and is smoothed; the aircraft follows the
//! smoothed demand closely. So its rate of climb builds up and dies away over seconds.

use super::second_order::SecondOrder;
use crate::{Limits, Ranges};

/// Constants of the altitude loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AltitudeLoopSettings {
    /// A new setpoint acts after this, s.
    pub dead_time_s: f64,
    /// Time constant with which the demand is smoothed, s.
    pub smoothing_s: f64,
    /// Natural frequency with which the aircraft follows it, rad/s.
    pub frequency_radps: f64,
    /// Damping of that.
    pub damping: f64,
}

impl AltitudeLoopSettings {
    /// Fitted to steps of 5, 20 and 50 m of an ArduPlane, whose TECS smooths its demand over 3 s.
    pub fn plane() -> Self {
        Self { dead_time_s: 0.3, smoothing_s: 3.0, frequency_radps: 6.0, damping: 0.8 }
    }

    /// Fitted to the times that steps of 20 m took a PX4.
    pub fn px4_plane() -> Self {
        Self { dead_time_s: 0.2, smoothing_s: 1.3, frequency_radps: 6.0, damping: 0.9 }
    }

    pub(super) fn check(&self, ranges: &mut Ranges) {
        ranges.within("altitude_loop_dead_time_s", self.dead_time_s, 0.0, 10.0);
        ranges.within("altitude_smoothing_s", self.smoothing_s, 0.02, 60.0);
        ranges.within("altitude_frequency_radps", self.frequency_radps, 0.05, 50.0);
        ranges.within("altitude_damping", self.damping, 0.05, 10.0);
    }
}

/// The loop, and where it is. Altitudes are above the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct AltitudeLoop {
    step_s: f64,
    /// exp(-h/tau) of the smoothing.
    decay: f64,
    demand_m: f64,
    smoothed_m: f64,
    altitude: SecondOrder,
}

impl AltitudeLoop {
    pub fn new(settings: &AltitudeLoopSettings, step_s: f64) -> Self {
        Self {
            step_s,
            decay: libm::exp(-step_s / settings.smoothing_s),
            demand_m: 0.0,
            smoothed_m: 0.0,
            altitude: SecondOrder::new(settings.frequency_radps, settings.damping, step_s),
        }
    }

    /// Settled at an altitude, but for a rate of climb.
    pub fn begin(&mut self, altitude_m: f64, climb_mps: f64) {
        (self.demand_m, self.smoothed_m) = (altitude_m, altitude_m);
        (self.altitude.value, self.altitude.rate) = (altitude_m, climb_mps);
    }

    /// Something else than this loop has brought the aircraft here, or has changed its rate of climb.
    pub fn meet(&mut self, altitude_m: f64, climb_mps: f64) {
        (self.altitude.value, self.altitude.rate) = (altitude_m, climb_mps);
    }

    /// One step towards a setpoint. A gust may carry the climb out of its limits.
    pub fn step(&mut self, setpoint_m: f64, limits: &Limits) {
        let least_mps = limits.climb_min_mps.min(self.altitude.rate);
        let most_mps = limits.climb_max_mps.max(self.altitude.rate);
        let change_m = setpoint_m - self.demand_m;
        self.demand_m += change_m.clamp(limits.climb_min_mps * self.step_s, limits.climb_max_mps * self.step_s);
        self.smoothed_m = self.demand_m + (self.smoothed_m - self.demand_m) * self.decay;
        let (before_m, before_mps) = (self.altitude.value, self.altitude.rate);
        self.altitude.step(self.smoothed_m);
        let climb_mps = self.altitude.rate.clamp(least_mps, most_mps);
        if climb_mps != self.altitude.rate {
            self.altitude.value = before_m + 0.5 * (before_mps + climb_mps) * self.step_s;
            self.altitude.rate = climb_mps;
        }
    }

    /// Altitude, m, and rate of climb, m/s.
    pub fn now(&self) -> (f64, f64) {
        (self.altitude.value, self.altitude.rate)
    }
}
