//! Pitch, as changes of speed swing it.
//!
//! A total energy controller holds speed against height by pitching: it takes an airspeed that grows for energy that
//! height has lost, and raises the nose in proportion (ArduPlane's AP_TECS.cpp: `_SKEdot` in the rate of the energy
//! balance, times TECS_PTCH_DAMP, over g; the acceleration less its mean over TECS_TIME_CONST), no faster than
//! TECS_VERT_ACC allows. The pitch swings on, and what the nose turns up or down is load factor: in a bank it turns the
//! aircraft harder, or not at all.

use super::second_order::SecondOrder;
use crate::Ranges;

/// Constants of the pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchSettings {
    /// Pitch asked for by an acceleration, rad for each m/s2; 0: none.
    pub per_acceleration: f64,
    /// Time constant with which an acceleration that stays is forgotten, s.
    pub washout_s: f64,
    /// Greatest vertical acceleration for which the pitch asked for turns the nose, m/s2.
    pub load_max_mps2: f64,
    /// Natural frequency of the pitch, rad/s.
    pub frequency_radps: f64,
    /// Damping of the pitch.
    pub damping: f64,
}

impl PitchSettings {
    /// TECS_PTCH_DAMP 0.3 over g, TECS_TIME_CONST 5 s and TECS_VERT_ACC 7 m/s2, the parameters' defaults; frequency and
    /// damping so that load factors are those of real flights with the same setpoints.
    pub fn plane() -> Self {
        Self { per_acceleration: 0.0306, washout_s: 5.0, load_max_mps2: 7.0, frequency_radps: 5.4, damping: 0.15 }
    }

    /// Not measured: none.
    pub fn px4_plane() -> Self {
        Self { per_acceleration: 0.0, ..Self::plane() }
    }

    pub(super) fn check(&self, ranges: &mut Ranges) {
        ranges.within("pitch_per_acceleration", self.per_acceleration, 0.0, 1.0);
        ranges.within("pitch_washout_s", self.washout_s, 0.02, 60.0);
        ranges.within("pitch_load_max_mps2", self.load_max_mps2, 0.01, 100.0);
        ranges.within("pitch_frequency_radps", self.frequency_radps, 0.05, 50.0);
        ranges.within("pitch_damping", self.damping, 0.05, 10.0);
    }
}

/// The pitch, and where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pitch {
    settings: PitchSettings,
    step_s: f64,
    /// Share of the mean acceleration that a step forgets.
    forgotten: f64,
    mean_mps2: f64,
    demand_rad: f64,
    pitch: SecondOrder,
}

/// Where it hardly flies the pitch asked for moves no faster than at this speed, m/s.
const SPEED_LEAST_MPS: f64 = 1.0;

impl Pitch {
    pub fn new(settings: &PitchSettings, step_s: f64) -> Self {
        Self {
            settings: *settings,
            step_s,
            forgotten: -libm::expm1(-step_s / settings.washout_s),
            mean_mps2: 0.0,
            demand_rad: 0.0,
            pitch: SecondOrder::new(settings.frequency_radps, settings.damping, step_s),
        }
    }

    /// At rest.
    pub fn begin(&mut self) {
        (self.mean_mps2, self.demand_rad) = (0.0, 0.0);
        self.pitch.begin(0.0);
    }

    /// One step with an acceleration along the course, at a true airspeed in m/s; gives the turn of the nose, rad/s, up
    /// positive.
    pub fn step(&mut self, acceleration_mps2: f64, speed_mps: f64) -> f64 {
        self.mean_mps2 += self.forgotten * (acceleration_mps2 - self.mean_mps2);
        let wanted_rad = self.settings.per_acceleration * (acceleration_mps2 - self.mean_mps2);
        let step_max_rad = self.settings.load_max_mps2 / speed_mps.max(SPEED_LEAST_MPS) * self.step_s;
        self.demand_rad += (wanted_rad - self.demand_rad).clamp(-step_max_rad, step_max_rad);
        self.pitch.step(self.demand_rad);
        self.pitch.rate
    }
}
