//! How the vehicle flies: its modes and what feeds the three autopilot loops. Knows no MAVLink.

mod air;
pub(crate) mod attitude;
mod circle;
pub(crate) mod ground;
pub(crate) mod guidance;
mod landing;
pub(crate) mod manual;
mod modes;
mod options;
mod ramp;
mod steering;
mod step;
pub(crate) mod tuning;

use crate::autopilot::home::Home;
use crate::mode::Mode;
use crate::parameters::table::TAKEOFF_ALTITUDE_M;
use crate::settings::VehicleSettings;
use crate::world::Motion;
use air::Air;
use attitude::AttitudeTarget;
use flight_model::{Autopilot, Dynamics, Plant, SetpointDelay, State, wrap_pi};
use ground::Contact;
use guidance::{Direction, RallyPlace};
use landing::Landing;
use manual::Sticks;
use nalgebra::Vector2;
use options::{FirstClimb, Options};
use ramp::Ramp;
use tuning::Tuning;

/// One vehicle: in the air, on the ground, or motionless on its launch rail until it is armed.
#[derive(Clone, Debug)]
pub(crate) struct Flight {
    dynamics: Dynamics,
    /// The three loops, with the lateral limit in force (a guided command may lower it).
    autopilot: Autopilot,
    /// What flies in the place of these loops, if it has one.
    plant: Option<Plant>,
    /// Dead times of these loops.
    dead_times: Option<SetpointDelay>,
    lateral_limit_mps2: f64,
    /// The flight model within that limit.
    limited: Dynamics,
    tuning: Tuning,
    start: State,
    starts_on_ground: bool,
    state: State,
    /// Whether its time goes on without it.
    is_held: bool,
    air: Air,
    mode: Mode,
    armed: bool,
    /// Whether the engine would run if it were armed.
    engine_works: bool,
    contact: Contact,
    stage: Stage,
    sticks: Option<Sticks>,
    /// The attitude that somebody else sets, until the mode changes.
    attitude: Option<AttitudeTarget>,
    home: Home,
    /// Where GUIDED was entered: released from a course, the vehicle circles here.
    guided_point: Vector2<f64>,
    rally: Option<RallyPlace>,
    /// The climb that a return has begun with.
    first_climb: Option<FirstClimb>,
    /// An airspeed, unless it was asked for over ground.
    speed: Ramp,
    speed_is_over_ground: bool,
    /// Fastest change of a speed that comes without an acceleration, m/s2.
    led_acceleration_mps2: f64,
    /// The least speed over ground, m/s, for which the airspeed rises; 0 for none.
    least_ground_speed_mps: f64,
    /// Whether it glides with its engine idle, until another mode is set.
    glides: bool,
    altitude: Ramp,
    /// Whether a guided command asked for that altitude.
    altitude_is_slewed: bool,
    direction: Direction,
}

/// What a flight is in the middle of, beside its mode.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Normal,
    /// On the way up, from the run on the ground on.
    Takeoff,
    Landing(Landing),
}

impl Flight {
    pub fn new(settings: &VehicleSettings) -> Self {
        let start = State { course_rad: wrap_pi(settings.start.course_rad), ..settings.start };
        let (step_s, origin_amsl_m) = (settings.step.as_secs_f64(), settings.frame.origin().altitude_amsl_m);
        let new_plant = |plant| Plant::new(plant, &settings.dynamics.limits, step_s, origin_amsl_m, &start);
        let mut flight = Self {
            dynamics: settings.dynamics,
            limited: settings.dynamics,
            autopilot: Autopilot::new(&settings.dynamics, step_s),
            plant: settings.plant.as_ref().map(new_plant),
            dead_times: SetpointDelay::of(&settings.dynamics.response, step_s, &start.hold()),
            tuning: Tuning {
                loiter_radius_m: settings.loiter_radius_m,
                rtl_radius_m: settings.loiter_radius_m,
                rtl_altitude_m: None,
                cruise_speed_mps: settings.cruise_speed_mps,
                climb_max_mps: f64::INFINITY,
                sink_max_mps: f64::INFINITY,
                takeoff_altitude_m: TAKEOFF_ALTITUDE_M,
                lateral_overload_max: f64::INFINITY,
                stick_bank_max_rad: manual::BANK_MAX_RAD,
                options: Options::default(),
            },
            lateral_limit_mps2: f64::INFINITY,
            start,
            starts_on_ground: settings.on_ground,
            state: State { speed_mps: 0.0, climb_mps: 0.0, ..start },
            is_held: false,
            air: Air::at(&start),
            mode: settings.mode,
            armed: false,
            engine_works: true,
            contact: Contact::Rail,
            stage: Stage::Normal,
            sticks: None,
            attitude: None,
            home: Home::default(),
            guided_point: start.position_m(),
            rally: None,
            first_climb: None,
            speed: Ramp::at(start.speed_mps),
            speed_is_over_ground: false,
            led_acceleration_mps2: settings.led_acceleration_mps2,
            least_ground_speed_mps: 0.0,
            glides: false,
            altitude: Ramp::at(start.altitude_m),
            altitude_is_slewed: false,
            direction: Direction::Course(start.course_rad),
        };
        if settings.on_ground {
            flight.stand_on_ground();
        } else {
            flight.enter(settings.mode);
            if settings.armed {
                flight.arm();
            }
        }
        flight
    }

    #[inline]
    pub fn state(&self) -> &State {
        &self.state
    }

    #[inline]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    #[inline]
    pub fn is_armed(&self) -> bool {
        self.armed
    }

    pub fn limits(&self) -> &flight_model::Limits {
        &self.dynamics.limits
    }

    /// The setpoint that the next step starts from, as far as it is known before it.
    pub fn speed_target_mps(&self) -> f64 {
        self.speed.target
    }

    /// Whether it flies: on the ground, a run faster than ArduPlane's bound of 1.5 m/s counts.
    #[inline]
    pub fn is_flying(&self) -> bool {
        const RUN_MPS: f64 = 1.5;
        match self.contact {
            Contact::Rail => false,
            Contact::Ground => self.armed && self.state.speed_mps > RUN_MPS,
            Contact::Air => true,
        }
    }

    pub fn is_taking_off(&self) -> bool {
        matches!(self.stage, Stage::Takeoff)
    }

    #[inline]
    pub fn is_landing(&self) -> bool {
        matches!(self.stage, Stage::Landing(_))
    }

    /// Whether it has touched down, and not left the ground since.
    #[inline]
    pub fn is_on_ground(&self) -> bool {
        self.contact == Contact::Ground
    }

    /// Where RTL leads, and what altitudes above home are above.
    pub fn home(&self) -> Home {
        self.home
    }

    /// The altitude that it is to have, m above the origin.
    pub fn target_altitude_m(&self) -> f64 {
        self.altitude.target
    }

    /// How far it is from the altitude that it is to have, m.
    pub fn altitude_error_m(&self) -> f64 {
        (self.state.altitude_m - self.altitude.target).abs()
    }

    /// Stops or restarts the engine. Without it the speed falls to the least one and the vehicle glides down.
    pub fn set_engine(&mut self, works: bool) {
        self.engine_works = works;
    }

    /// Keeps it where it is, with the velocity that it has, or lets it fly on.
    pub fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
    }

    #[inline]
    pub fn is_engine_running(&self) -> bool {
        self.armed && self.engine_works
    }

    /// Stops the engine. In the air it glides down, led by its mode still.
    pub fn disarm(&mut self) {
        self.armed = false;
    }

    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// Where and how fast the vehicle believes to be: its true state, unless it has to reckon with a wind that it does
    /// not see.
    #[inline]
    pub fn estimate(&self) -> State {
        self.air.estimate(&self.state)
    }

    /// Where it believes to be, (north, east) in m.
    pub fn here(&self) -> Vector2<f64> {
        self.estimate().position_m()
    }

    /// How far a place is from there, m.
    pub fn distance_m(&self, place: Vector2<f64>) -> f64 {
        (place - self.here()).norm()
    }

    /// The state as the air sees it: airspeed and heading in the place of speed and course over ground.
    #[inline]
    pub fn in_air(&self) -> State {
        self.air.see(&self.state)
    }

    /// Speed through the air, m/s, true.
    #[inline]
    pub fn airspeed_mps(&self) -> f64 {
        self.in_air().speed_mps
    }

    /// Airspeed that its sensor shows and its setpoints mean, m/s: the true one, unless it flies a plant.
    #[inline]
    pub fn equivalent_airspeed_mps(&self) -> f64 {
        self.airspeed_mps() / self.true_airspeed_ratio()
    }

    /// True airspeed of an equivalent airspeed of one, here.
    #[inline]
    pub fn true_airspeed_ratio(&self) -> f64 {
        self.plant.as_ref().map_or(1.0, |plant| plant.true_airspeed_ratio(self.state.altitude_m))
    }

    /// Where its nose points, rad.
    pub fn heading_rad(&self) -> f64 {
        self.in_air().course_rad
    }

    /// Rate of turn that the loops have flown over the last step, rad/s.
    pub fn turn_rate_radps(&self) -> f64 {
        self.air.turn_rate_radps(&self.state, self.autopilot.step_s())
    }

    /// How it moves, as its sensors feel it.
    pub fn motion(&self) -> Motion {
        Motion {
            altitude_m: self.state.altitude_m,
            climb_mps: self.state.climb_mps,
            airspeed_mps: self.airspeed_mps(),
            true_airspeed_ratio: self.true_airspeed_ratio(),
            heading_rad: self.heading_rad(),
            roll_rad: self.roll_rad(),
            turn_rate_radps: self.turn_rate_radps(),
            acceleration_mps2: self.air.acceleration_mps2(&self.state, self.autopilot.step_s()),
            gravity_mps2: self.dynamics.limits.gravity_mps2,
        }
    }

    /// Power that the speed asked for needs in level flight, as a share of the motor's greatest.
    #[inline]
    pub fn power_needed(&self) -> f64 {
        let share = self.speed.target / self.dynamics.limits.speed_max_mps;
        (share * share * share).clamp(0.0, 1.0)
    }

    /// Power that the motor gives, as a share of its greatest: drag grows with the cube of the airspeed, and a climb
    /// costs.
    #[inline]
    pub fn power_share(&self) -> f64 {
        let limits = self.dynamics.limits;
        let speed = self.airspeed_mps() / limits.speed_max_mps;
        let climb = self.state.climb_mps / limits.climb_max_mps;
        (speed * speed * speed + 0.5 * climb).clamp(0.0, 1.0)
    }

    /// Bank, rad, of a coordinated turn: the lift's horizontal part is the centripetal force.
    pub fn roll_rad(&self) -> f64 {
        if let Some(plant) = self.plant.as_ref().filter(|_| self.contact == Contact::Air) {
            return plant.bank_rad();
        }
        libm::atan(self.airspeed_mps() * self.turn_rate_radps() / self.dynamics.limits.gravity_mps2)
    }
}

#[cfg(test)]
mod tests;
