//! How the vehicle flies: its modes and what feeds the three autopilot loops. Knows no MAVLink.

mod air;
mod circle;
mod ground;
mod guidance;
mod landing;
mod manual;
mod ramp;
mod tuning;

pub(crate) use ground::Event;
pub(crate) use guidance::RallyPlace;
pub(crate) use manual::Sticks;
pub(crate) use tuning::{TAKEOFF_ALTITUDE_M, TAKEOFF_TOLERANCE_M, Tuning};

use crate::mode::Mode;
use crate::settings::VehicleSettings;
use air::Air;
use flight_model::{Autopilot, Dynamics, Setpoint, State, wrap_pi};
use ground::Contact;
use guidance::Direction;
use landing::Landing;
use ramp::Ramp;

/// One vehicle: in the air, on the ground, or motionless on its launch rail until it is armed.
#[derive(Clone, Debug)]
pub(crate) struct Flight {
    dynamics: Dynamics,
    /// The three loops, with the lateral limit in force (a guided command may lower it).
    autopilot: Autopilot,
    lateral_limit_mps2: f64,
    tuning: Tuning,
    start: State,
    state: State,
    air: Air,
    mode: Mode,
    armed: bool,
    /// Whether the engine would run if it were armed.
    engine_works: bool,
    contact: Contact,
    stage: Stage,
    sticks: Option<Sticks>,
    home: Home,
    /// Where GUIDED was entered: released from a course, the vehicle circles here.
    guided_point: (f64, f64),
    rally: Option<RallyPlace>,
    /// An airspeed, unless it was asked for over ground.
    speed: Ramp,
    speed_is_over_ground: bool,
    /// The least speed over ground, m/s, for which the airspeed rises; 0 for none.
    least_ground_speed_mps: f64,
    /// Whether it glides with its engine idle, until another mode is set.
    glides: bool,
    altitude: Ramp,
    /// Whether a guided command asked for that altitude.
    altitude_is_slewed: bool,
    direction: Direction,
}

/// A place to return to, in the local frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Home {
    /// North of the origin, m.
    pub x_m: f64,
    /// East of the origin, m.
    pub y_m: f64,
    /// Above the origin, m.
    pub altitude_m: f64,
}

impl Home {
    /// (north, east) in m.
    pub fn at(&self) -> (f64, f64) {
        (self.x_m, self.y_m)
    }
}

/// What a flight is in the middle of, beside its mode.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Normal,
    /// On the way up, from the run on the ground on.
    Takeoff,
    Landing(Landing),
}

/// Share of the lift in the drag of a vehicle that glides: it sinks by its speed over this.
const GLIDE_RATIO: f64 = 10.0;

impl Flight {
    pub fn new(settings: &VehicleSettings) -> Self {
        let start = State { course_rad: wrap_pi(settings.start.course_rad), ..settings.start };
        let mut flight = Self {
            dynamics: settings.dynamics,
            autopilot: Autopilot::new(&settings.dynamics, settings.step.as_secs_f64()),
            tuning: Tuning {
                loiter_radius_m: settings.loiter_radius_m,
                rtl_radius_m: settings.loiter_radius_m,
                rtl_altitude_m: None,
                cruise_speed_mps: None,
                takeoff_altitude_m: TAKEOFF_ALTITUDE_M,
                lateral_overload_max: f64::INFINITY,
            },
            lateral_limit_mps2: f64::INFINITY,
            start,
            state: State { speed_mps: 0.0, climb_mps: 0.0, ..start },
            air: Air::at(&start),
            mode: settings.mode,
            armed: false,
            engine_works: true,
            contact: Contact::Rail,
            stage: Stage::Normal,
            sticks: None,
            home: Home::default(),
            guided_point: (start.x_m, start.y_m),
            rally: None,
            speed: Ramp::at(start.speed_mps),
            speed_is_over_ground: false,
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

    pub fn state(&self) -> &State {
        &self.state
    }

    pub fn mode(&self) -> Mode {
        self.mode
    }

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

    pub fn is_landing(&self) -> bool {
        matches!(self.stage, Stage::Landing(_))
    }

    /// Whether it has touched down, and not left the ground since.
    pub fn is_on_ground(&self) -> bool {
        self.contact == Contact::Ground
    }

    /// Where RTL leads, and what altitudes above home are above.
    pub fn home(&self) -> Home {
        self.home
    }

    pub fn set_home(&mut self, home: Home) {
        self.home = home;
        if self.mode == Mode::Rtl {
            self.enter(Mode::Rtl);
        }
    }

    /// How far it is from the altitude that it is to have, m.
    pub fn altitude_error_m(&self) -> f64 {
        (self.state.altitude_m - self.altitude.target).abs()
    }

    /// Stops or restarts the engine. Without it the speed falls to the least one and the vehicle glides down.
    pub fn set_engine(&mut self, works: bool) {
        self.engine_works = works;
    }

    pub fn is_engine_running(&self) -> bool {
        self.armed && self.engine_works
    }

    /// Integrates one step; says what has happened in it. On the rail nothing moves.
    pub fn step(&mut self) -> Option<Event> {
        match self.contact {
            Contact::Rail => None,
            Contact::Ground => {
                self.step_on_ground();
                None
            }
            Contact::Air => self.step_in_air(),
        }
    }

    fn step_in_air(&mut self) -> Option<Event> {
        if self.is_taking_off() {
            self.level_off_when_up();
        }
        let course_rad = self.guide_rad();
        let mut setpoint =
            Setpoint { speed_mps: self.speed.advance(), course_rad, altitude_m: self.altitude.advance() };
        if self.least_ground_speed_mps > 0.0 {
            let shortfall_mps = self.least_ground_speed_mps - self.state.speed_mps;
            setpoint.speed_mps = setpoint.speed_mps.max(self.airspeed_mps() + shortfall_mps);
        }
        setpoint = self.by_hand(setpoint);
        if let Stage::Landing(landing) = self.stage {
            setpoint = self.land(landing, &setpoint);
        }
        if !self.is_engine_running() || self.glides {
            setpoint.speed_mps = self.dynamics.limits.speed_min_mps;
            setpoint.altitude_m = self.altitude_to_climb_at(-self.airspeed_mps() / GLIDE_RATIO);
        }
        self.fly(&setpoint);
        self.touch_down()
    }

    /// The altitude setpoint that makes the altitude loop climb at a rate, m/s: it lags by its time constants behind a
    /// setpoint that moves.
    fn altitude_to_climb_at(&self, climb_mps: f64) -> f64 {
        let tau = self.dynamics.time_constants;
        self.state.altitude_m + climb_mps * (tau.altitude_a_s + tau.altitude_b_s)
    }

    /// Starts the engine. From the rail it leaves with the start's speed and course; on the ground it stays until its mode
    /// takes off.
    pub fn arm(&mut self) {
        if self.armed {
            return;
        }
        self.armed = true;
        match self.contact {
            Contact::Rail => {
                self.state = self.start;
                self.contact = Contact::Air;
            }
            Contact::Ground => self.enter(self.mode),
            Contact::Air => {}
        }
    }

    /// Stops the engine. In the air it glides down, led by its mode still.
    pub fn disarm(&mut self) {
        self.armed = false;
    }

    /// Changes the mode; asking for the present one changes nothing, as in ArduPlane.
    pub fn set_mode(&mut self, mode: Mode) {
        if mode != self.mode {
            self.glides = false;
            self.mode = mode;
            self.enter(mode);
        }
    }

    /// Airspeed setpoint, m/s, reached at no more than an acceleration in m/s2 (infinite: at once).
    pub fn set_speed(&mut self, speed_mps: f64, acceleration_mps2: f64) {
        let value = if acceleration_mps2.is_finite() { self.airspeed_when_released_mps() } else { speed_mps };
        self.speed_is_over_ground = false;
        self.speed = Ramp { value, target: speed_mps, per_step: acceleration_mps2 * self.autopilot.step_s() };
    }

    /// Glides with its engine idle, until another mode is set.
    pub fn glide(&mut self) {
        self.glides = true;
    }

    /// From now on its airspeed rises where its speed over ground, m/s, would be lower.
    pub fn set_least_ground_speed(&mut self, speed_mps: f64) {
        self.least_ground_speed_mps = speed_mps;
    }

    /// Altitude setpoint, m above the origin, reached at no more than a rate in m/s (infinite: at once).
    pub fn set_altitude(&mut self, altitude_m: f64, rate_mps: f64) {
        self.altitude_is_slewed = false;
        let value = if rate_mps.is_finite() { self.state.altitude_m } else { altitude_m };
        self.altitude = Ramp { value, target: altitude_m, per_step: rate_mps * self.autopilot.step_s() };
    }

    /// Course setpoint, rad, turned to with no more than a lateral acceleration in m/s2 (or the vehicle's own limit).
    pub fn set_course(&mut self, course_rad: f64, lateral_acceleration_mps2: f64) {
        self.stage = Stage::Normal;
        self.direction = Direction::Course(course_rad);
        self.limit_lateral_acceleration(lateral_acceleration_mps2);
    }

    /// Flies by other parameters from now on: a circle whose radius has changed is flown with the new one where it is. In
    /// AUTO the mission says how wide.
    pub fn retune(&mut self, tuning: Tuning) {
        let old_radius_m = self.radius_m();
        self.tuning = tuning;
        match self.direction {
            Direction::Circle(circle) if self.mode != Mode::Auto && self.radius_m() != old_radius_m => {
                self.circle(circle.centre(), self.radius_m());
            }
            _ => self.limit_lateral_acceleration(self.lateral_limit_mps2),
        }
        match self.mode {
            Mode::Loiter | Mode::Circle | Mode::Rtl => self.fly_by_itself(),
            _ => {}
        }
    }

    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    fn radius_m(&self) -> f64 {
        if self.mode == Mode::Rtl { self.tuning.rtl_radius_m } else { self.tuning.loiter_radius_m }
    }

    /// Speed and altitude of the modes that need nobody.
    fn fly_by_itself(&mut self) {
        if let Some(speed_mps) = self.tuning.cruise_speed_mps {
            self.set_speed(speed_mps, f64::INFINITY);
        }
        let above_home_m = self.tuning.rtl_altitude_m.map(|altitude_m| self.home.altitude_m + altitude_m);
        let return_altitude_m = self.rally.map(|rally| rally.altitude_m).or(above_home_m);
        if let Some(altitude_m) = return_altitude_m.filter(|_| self.mode == Mode::Rtl) {
            self.set_altitude(altitude_m, f64::INFINITY);
        }
    }

    fn limit_lateral_acceleration(&mut self, limit_mps2: f64) {
        self.lateral_limit_mps2 = limit_mps2;
        self.autopilot = Autopilot::new(&self.limited_dynamics(), self.autopilot.step_s());
    }

    /// The flight model with the least of the lateral limits.
    fn limited_dynamics(&self) -> Dynamics {
        let mut dynamics = self.dynamics;
        let overload = (self.lateral_limit_mps2 / dynamics.limits.gravity_mps2).min(self.tuning.lateral_overload_max);
        dynamics.limits.lateral_overload_max = overload.min(dynamics.limits.lateral_overload_max);
        dynamics
    }

    /// What it flies now, or will fly when it is released from the rail or has left the ground.
    fn when_released(&self) -> State {
        match self.contact {
            Contact::Rail => self.start,
            Contact::Ground => State { speed_mps: self.start.speed_mps, ..self.state },
            Contact::Air => self.state,
        }
    }

    fn airspeed_when_released_mps(&self) -> f64 {
        if self.contact == Contact::Air { self.airspeed_mps() } else { self.start.speed_mps }
    }

    /// Every mode begins by holding what the vehicle does.
    fn enter(&mut self, mode: Mode) {
        let now = self.when_released();
        self.speed = Ramp::at(self.airspeed_when_released_mps());
        self.speed_is_over_ground = false;
        self.altitude = Ramp::at(now.altitude_m);
        self.altitude_is_slewed = false;
        self.set_course(now.course_rad, f64::INFINITY);
        let here = (now.x_m, now.y_m);
        match mode {
            Mode::Manual | Mode::Stabilize | Mode::Fbwa | Mode::Fbwb | Mode::Cruise | Mode::Offboard => {}
            Mode::Takeoff => {
                // From the ground, above the ground. Who is higher already stays there, as in ArduPlane.
                let base_m = if self.is_on_ground() { now.altitude_m } else { self.home.altitude_m };
                self.take_off((base_m + self.tuning.takeoff_altitude_m).max(now.altitude_m));
            }
            // The mission says where to; until then, as before.
            Mode::Auto | Mode::Course => self.fly_by_itself(),
            Mode::Rtl => {
                self.circle(self.rally.map_or(self.home.at(), |rally| rally.at), self.tuning.rtl_radius_m);
                self.fly_by_itself();
            }
            Mode::Loiter | Mode::Circle => {
                self.circle(here, self.tuning.loiter_radius_m);
                self.fly_by_itself();
            }
            Mode::Land => self.land_at(here),
            Mode::Guided => {
                self.guided_point = here;
                // Entered in flight, ArduPlane circles until it is told where to go. A start on the rail or in the air
                // goes straight on: the flock's start is already a course.
                if self.armed {
                    self.circle(here, self.tuning.loiter_radius_m);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
