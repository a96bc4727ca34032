//! A plant: an aircraft behind a real autopilot, as steps of real ones show it. Eq. 1 is the model of it that a
//! controller flies by.
//!
//! Three loops, a file each: speed as a total energy controller holds it, course by banking, altitude by a demand that
//! moves; and pitch, by which changes of speed swing the lift of a turn. All are linear elements behind a dead time and
//! a demand that is limited. The constants of [`plane`] were fitted to an ArduPlane 4.7 in simulation, those of
//! [`px4_plane`] to a PX4 1.18 (docs/dynamics.md).
//!
//! [`plane`]: PlantSettings::plane
//! [`px4_plane`]: PlantSettings::px4_plane

mod altitude;
mod course;
mod delay;
mod pitch;
mod second_order;
mod speed;

pub use altitude::AltitudeLoopSettings;
pub use course::CourseLoopSettings;
pub use delay::{Delay, SetpointDelay};
pub use pitch::PitchSettings;
pub use speed::SpeedLoopSettings;

use crate::{Limits, RangeError, Ranges, Setpoint, State, Wind, course_vector, true_airspeed_ratio, wrap_pi};
use altitude::AltitudeLoop;
use course::CourseLoop;
use pitch::Pitch;
use speed::SpeedLoop;

/// Constants of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantSettings {
    /// How it holds its speed.
    pub speed: SpeedLoopSettings,
    /// How it turns.
    pub course: CourseLoopSettings,
    /// How it climbs.
    pub altitude: AltitudeLoopSettings,
    /// How changes of its speed swing its pitch, and with it the lift that turns it.
    pub pitch: PitchSettings,
    /// How much warmer the air is than the standard atmosphere, K. It counts for the true airspeed of an equivalent
    /// one.
    pub air_temperature_offset_k: f64,
}

/// An aircraft and its autopilot, with all that they remember from step to step.
///
/// Setpoints of speed are equivalent airspeeds, setpoints of course are headings; in still air a heading is a course.
/// The limits bound what the autopilot asks for, as those of a real one do: in a hard turn the bank overshoots its
/// limit by some degrees.
///
/// ```
/// use flight_model::{Airframe, Plant, State, Wind};
///
/// let airframe = Airframe::plane();
/// let start = State { altitude_m: 100.0, speed_mps: 20.0, ..State::default() };
/// let mut plant = Plant::new(&airframe.plant.unwrap(), &airframe.dynamics.limits, 0.01, 584.0, &start);
/// let mut state = start;
/// for _ in 0..3000 {
///     let setpoint = flight_model::Setpoint { speed_mps: 20.0, course_rad: 0.8, altitude_m: 100.0 };
///     state = plant.step(&state, &setpoint, &Wind::CALM);
/// }
/// // Twenty metres per second of equivalent airspeed are more over ground, the higher the more.
/// assert!((state.speed_mps / 20.0 - 1.065).abs() < 0.005 && (state.course_rad - 0.8).abs() < 0.01);
/// ```
#[derive(Clone, Debug)]
pub struct Plant {
    settings: PlantSettings,
    limits: Limits,
    step_s: f64,
    substeps: usize,
    origin_amsl_m: f64,
    held_bank_rad: Option<f64>,
    setpoints: SetpointDelay,
    speed: SpeedLoop,
    course: CourseLoop,
    altitude: AltitudeLoop,
    pitch: Pitch,
}

/// The loops are integrated at no longer steps than this, s.
const SUBSTEP_MAX_S: f64 = 0.01;

impl PlantSettings {
    /// The plane of ArduPilot's simulator with its default parameters.
    pub fn plane() -> Self {
        Self {
            speed: SpeedLoopSettings::plane(),
            course: CourseLoopSettings::plane(),
            altitude: AltitudeLoopSettings::plane(),
            pitch: PitchSettings::plane(),
            air_temperature_offset_k: 18.0,
        }
    }

    /// The plane of PX4's simulator with its default parameters.
    pub fn px4_plane() -> Self {
        Self {
            speed: SpeedLoopSettings::px4_plane(),
            course: CourseLoopSettings::px4_plane(),
            altitude: AltitudeLoopSettings::px4_plane(),
            pitch: PitchSettings::px4_plane(),
            air_temperature_offset_k: 0.0,
        }
    }

    /// Every constant that is out of its range, by the name that an airframe file gives it.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        ranges.within("air_temperature_offset_k", self.air_temperature_offset_k, -60.0, 60.0);
        self.speed.check(&mut ranges);
        self.course.check(&mut ranges);
        self.altitude.check(&mut ranges);
        self.pitch.check(&mut ranges);
        ranges.errors()
    }
}

impl Plant {
    /// A plant that flies as a state does in still air. The origin of altitudes is so high above mean sea level, m.
    pub fn new(settings: &PlantSettings, limits: &Limits, step_s: f64, origin_amsl_m: f64, start: &State) -> Self {
        let substeps = (step_s / SUBSTEP_MAX_S).ceil().max(1.0) as usize;
        let substep_s = step_s / substeps as f64;
        let mut plant = Self {
            settings: *settings,
            limits: *limits,
            step_s,
            substeps,
            origin_amsl_m,
            held_bank_rad: None,
            setpoints: SetpointDelay::new(
                [settings.speed.dead_time_s, settings.course.dead_time_s, settings.altitude.dead_time_s],
                step_s,
                &start.hold(),
            ),
            speed: SpeedLoop::new(&settings.speed, substep_s),
            course: CourseLoop::new(&settings.course, substep_s),
            altitude: AltitudeLoop::new(&settings.altitude, substep_s),
            pitch: Pitch::new(&settings.pitch, substep_s),
        };
        plant.begin(start, &Wind::CALM);
        plant
    }

    /// Flies level as a state does in a wind: what was before is forgotten.
    pub fn begin(&mut self, state: &State, wind: &Wind) {
        let air = state.in_air(wind);
        let equivalent_mps = air.speed_mps / self.true_airspeed_ratio(state.altitude_m);
        self.setpoints.begin(&Setpoint {
            speed_mps: equivalent_mps,
            course_rad: air.course_rad,
            altitude_m: state.altitude_m,
        });
        self.speed.begin(equivalent_mps);
        self.course.begin();
        self.altitude.begin(state.altitude_m, state.climb_mps);
        self.pitch.begin();
    }

    /// Other limits from now on.
    pub fn set_limits(&mut self, limits: &Limits) {
        self.limits = *limits;
    }

    /// From now on it banks as it is told, rad, whatever its course; none: it turns to its course again.
    pub fn hold_bank(&mut self, bank_rad: Option<f64>) {
        self.held_bank_rad = bank_rad;
    }

    /// Bank, rad, right wing down positive.
    pub fn bank_rad(&self) -> f64 {
        self.course.bank_rad()
    }

    /// True airspeed of an equivalent airspeed of one, at an altitude above the origin in m.
    pub fn true_airspeed_ratio(&self, altitude_m: f64) -> f64 {
        true_airspeed_ratio(self.origin_amsl_m + altitude_m, self.settings.air_temperature_offset_k)
    }

    /// The state one step later in air that moves with a wind over the step. What has changed the state since the last
    /// step, such as a gust, is taken up by the loops.
    pub fn step(&mut self, state: &State, setpoint: &Setpoint, wind: &Wind) -> State {
        let setpoint = self.setpoints.pass(setpoint);
        let ratio = self.true_airspeed_ratio(state.altitude_m);
        let air = state.in_air(wind);
        let (mut speed_mps, mut heading_rad) = (air.speed_mps, air.course_rad);
        let substep_s = self.step_s / self.substeps as f64;
        let mut position_m = state.position_m() + wind.horizontal_mps() * self.step_s;
        let mut velocity = course_vector(heading_rad) * speed_mps;
        self.speed.meet(speed_mps / ratio);
        self.altitude.meet(state.altitude_m, state.climb_mps);
        for _ in 0..self.substeps {
            let before_mps = speed_mps;
            speed_mps = self.speed.step(setpoint.speed_mps, &self.limits) * ratio;
            let error_mps = self.speed.error_mps() * ratio;
            self.pitch.step((speed_mps - before_mps) / substep_s, error_mps, speed_mps);
            let error_rad = wrap_pi(setpoint.course_rad - heading_rad);
            let bank_rad = self.held_bank_rad.unwrap_or_else(|| self.course.wanted_bank_rad(error_rad));
            heading_rad += self.course.step(bank_rad, self.pitch.rate_radps(), speed_mps, &self.limits);
            self.altitude.step(setpoint.altitude_m, &self.limits);
            let after = course_vector(heading_rad) * speed_mps;
            position_m += (velocity + after) * (0.5 * substep_s);
            velocity = after;
        }
        let (altitude_m, climb_mps) = self.altitude.now();
        let course_rad = wrap_pi(heading_rad);
        let next = State { altitude_m, climb_mps, speed_mps, course_rad, ..*state }.over_ground(wind);
        State { x_m: position_m.x, y_m: position_m.y, ..next }
    }
}

#[cfg(test)]
mod tests;
