//! Modes, and what begins with each of them.

use super::air::Air;
use super::ground::Contact;
use super::guidance::Direction;
use super::landing::Landing;
use super::manual::Sticks;
use super::ramp::Ramp;
use super::tuning::Tuning;
use super::{Flight, Stage};
use crate::autopilot::home::Home;
use crate::mode::Mode;
use flight_model::State;
use nalgebra::Vector2;

impl Flight {
    /// Changes the mode; asking for the present one changes nothing, as in ArduPlane.
    pub fn set_mode(&mut self, mode: Mode) {
        if mode != self.mode {
            self.glides = false;
            self.mode = mode;
            self.enter(mode);
        }
    }

    /// Starts the engine. From the rail it leaves with the start's speed and course; on the ground it stays until its
    /// mode takes off.
    pub fn arm(&mut self) {
        if self.armed {
            return;
        }
        self.armed = true;
        match self.contact {
            Contact::Rail => {
                self.state = self.start;
                self.contact = Contact::Air;
                self.begin_flight();
            }
            Contact::Ground => self.enter(self.mode),
            Contact::Air => {}
        }
    }

    pub fn set_home(&mut self, home: Home) {
        self.home = home;
        if self.mode == Mode::Rtl {
            self.enter(Mode::Rtl);
        }
    }

    /// Whether TAKEOFF is at its altitude and circles.
    pub fn has_taken_off(&self) -> bool {
        self.mode == Mode::Takeoff && matches!(self.direction, Direction::Circle(_))
    }

    /// Lands at a place, (north, east) in m, on the course from here to there.
    pub fn land_at(&mut self, at: Vector2<f64>) {
        self.fly_to(at);
        self.stage = Stage::Landing(Landing::new(at, self.state.altitude_m));
    }

    /// What the sticks say from now on; none: nobody holds any. Who lets go of one goes on as it is.
    pub fn set_sticks(&mut self, sticks: Option<Sticks>) {
        let before = std::mem::replace(&mut self.sticks, sticks);
        if before == sticks {
            return;
        }
        let held = |sticks: Option<Sticks>, stick: fn(Sticks) -> f64| sticks.is_some_and(|s| stick(s) != 0.0);
        if self.climbs_by_stick() && held(before, |s| s.pitch) && !held(sticks, |s| s.pitch) {
            self.altitude = Ramp::at(self.state.altitude_m);
        }
        if !self.mode.is_manual() {
            return;
        }
        if held(before, |s| s.roll) && !held(sticks, |s| s.roll) {
            self.hold_course();
        }
        self.follow_throttle();
    }

    /// Flies by other parameters from now on: a circle whose radius has changed is flown with the new one where it is.
    /// In AUTO the mission says how wide.
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
            mode if mode.holds_speed() => self.follow_throttle(),
            _ => {}
        }
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

    /// Who started on the ground is there again.
    pub fn stand_at_start(&mut self) {
        if self.starts_on_ground {
            self.armed = false;
            self.air = Air::at(&self.start);
            self.stand_on_ground();
        }
    }

    /// Begins at rest on the ground below the start, disarmed, in MANUAL and at home, as ArduPlane boots.
    pub(super) fn stand_on_ground(&mut self) {
        self.contact = Contact::Ground;
        self.state = State { speed_mps: 0.0, climb_mps: 0.0, altitude_m: 0.0, ..self.start };
        self.home = Home { x_m: self.start.x_m, y_m: self.start.y_m, altitude_m: 0.0 };
        self.mode = Mode::Manual;
        self.enter(Mode::Manual);
    }

    /// Every mode begins by holding what the vehicle does.
    pub(super) fn enter(&mut self, mode: Mode) {
        let now = self.when_released();
        self.speed = Ramp::at(self.airspeed_when_released_mps());
        self.speed_is_over_ground = false;
        self.altitude = Ramp::at(now.altitude_m);
        self.altitude_is_slewed = false;
        self.set_attitude(None);
        self.end_first_climb();
        self.set_course(now.course_rad, f64::INFINITY);
        let here = now.position_m();
        match mode {
            Mode::Manual
            | Mode::Stabilize
            | Mode::Training
            | Mode::Acro
            | Mode::Autotune
            | Mode::Fbwa
            | Mode::Offboard => {}
            Mode::Fbwb | Mode::Cruise => self.follow_throttle(),
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
                self.climb_first();
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
