//! Pitch, as changes of speed swing it.
//!
//! A total energy controller holds speed against height by pitching: it takes speed that is above its demand, or grows,
//! for energy that height has lost, and raises the nose in proportion (ArduPlane's AP_TECS.cpp: `SEB_error` over
//! TECS_TIME_CONST; `_SKEdot` times TECS_PTCH_DAMP, the acceleration less its mean over TECS_TIME_CONST). The pitch
//! swings on, and what the nose turns up or down is load factor: in a bank it turns the aircraft harder, or not at all.

use super::delay::Delay;
use super::second_order::SecondOrder;
use crate::Ranges;

/// Constants of the pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchSettings {
    /// A change of speed acts after this, s.
    pub dead_time_s: f64,
    /// Pitch asked for by an airspeed above the demand, rad for each m/s; 0: none.
    pub per_speed_error: f64,
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
    /// Fitted to the load factors that ten ArduPlanes measured in 71 s each, speed setpoints of every half second and
    /// every second at once: 0.55 g of 0.63 g (root mean squares), of which it leaves 0.52 g.
    pub fn plane() -> Self {
        Self {
            dead_time_s: 0.17,
            per_speed_error: 0.073,
            per_acceleration: 0.0192,
            washout_s: 5.0,
            load_max_mps2: 4.4,
            frequency_radps: 5.27,
            damping: 0.143,
        }
    }

    /// Not measured: none.
    pub fn px4_plane() -> Self {
        Self { per_speed_error: 0.0, per_acceleration: 0.0, ..Self::plane() }
    }

    pub(super) fn check(&self, ranges: &mut Ranges) {
        ranges.within("pitch_dead_time_s", self.dead_time_s, 0.0, 10.0);
        ranges.within("pitch_per_speed_error", self.per_speed_error, 0.0, 1.0);
        ranges.within("pitch_per_acceleration", self.per_acceleration, 0.0, 1.0);
        ranges.within("pitch_washout_s", self.washout_s, 0.02, 60.0);
        ranges.within("pitch_load_max_mps2", self.load_max_mps2, 0.01, 100.0);
        ranges.within("pitch_frequency_radps", self.frequency_radps, 0.05, 50.0);
        ranges.within("pitch_damping", self.damping, 0.05, 10.0);
    }
}

/// The pitch, and where it is.
#[derive(Clone, Debug)]
pub(super) struct Pitch {
    settings: PitchSettings,
    step_s: f64,
    /// Share of the mean acceleration that a step forgets.
    forgotten: f64,
    mean_mps2: f64,
    /// Pitch that is asked for, until it acts, rad.
    wanted_rad: Delay,
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
            wanted_rad: Delay::new(settings.dead_time_s, step_s, 0.0),
            demand_rad: 0.0,
            pitch: SecondOrder::new(settings.frequency_radps, settings.damping, step_s),
        }
    }

    /// At rest.
    pub fn begin(&mut self) {
        (self.mean_mps2, self.demand_rad) = (0.0, 0.0);
        self.wanted_rad.begin(0.0);
        self.pitch.begin(0.0);
    }

    /// One step with an acceleration along the course, an airspeed above its demand and that true airspeed, m/s.
    pub fn step(&mut self, acceleration_mps2: f64, error_mps: f64, speed_mps: f64) {
        let settings = &self.settings;
        self.mean_mps2 += self.forgotten * (acceleration_mps2 - self.mean_mps2);
        let wanted_rad = self.wanted_rad.pass(
            settings.per_acceleration * (acceleration_mps2 - self.mean_mps2) + settings.per_speed_error * error_mps,
        );
        let step_max_rad = settings.load_max_mps2 / speed_mps.max(SPEED_LEAST_MPS) * self.step_s;
        self.demand_rad += (wanted_rad - self.demand_rad).clamp(-step_max_rad, step_max_rad);
        self.pitch.step(self.demand_rad);
    }

    /// How fast the nose turns, rad/s, up positive.
    pub fn rate_radps(&self) -> f64 {
        self.pitch.rate
    }
}
