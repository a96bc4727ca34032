//! Air that moves. Speeds that are held are airspeeds, courses are over ground; in still air both are the same, to the
//! last bit.

use flight_model::{Dynamics, Setpoint, State, Wind, wrap_pi};
use nalgebra::Vector2;

/// The air round the vehicle, and what its autopilot knows of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// As it is over ground, whether the vehicle feels it or stands.
    outside: Wind,
    /// As the vehicle feels it.
    wind: Wind,
    /// As the autopilot reckons with it: as it is, while a GPS tells where the air carries the vehicle.
    known: Wind,
    /// How far the place where the vehicle believes to be is from where it is, (north, east) in m.
    astray_m: Vector2<f64>,
    /// The state before the last step, in the wind of that step.
    before: State,
}

impl Air {
    /// Still, round a vehicle that has just begun.
    pub fn at(start: &State) -> Self {
        Self { outside: Wind::CALM, wind: Wind::CALM, known: Wind::CALM, astray_m: Vector2::zeros(), before: *start }
    }

    /// Outside a vehicle that stands on its rail or on the ground.
    pub fn outside(state: &State, wind: Wind) -> Self {
        Self { outside: wind, ..Self::at(state) }
    }

    /// The air of the next step in the air; gives the rate of climb, m/s, that a gust from below adds. `known` is the
    /// wind that the autopilot reckons with; none: it sees its way over ground.
    #[inline]
    pub fn feel(&mut self, wind: Wind, known: Option<Wind>) -> f64 {
        self.outside = wind;
        let lifted_mps = wind.up_mps - self.wind.up_mps;
        self.wind = wind;
        self.known = known.unwrap_or(wind);
        if known.is_none() {
            self.astray_m = Vector2::zeros();
        }
        lifted_mps
    }

    /// As the vehicle feels it.
    #[inline]
    pub fn wind(&self) -> &Wind {
        &self.wind
    }

    /// A state as the air sees it: airspeed and heading in the place of speed and course over ground.
    #[inline]
    pub fn see(&self, state: &State) -> State {
        state.in_air(&self.wind)
    }

    /// Where and how fast a vehicle in a state believes to be: there, unless it has to reckon with a wind that it does
    /// not see.
    #[inline]
    pub fn estimate(&self, state: &State) -> State {
        let astray_m = self.astray_m;
        if self.known == self.wind && astray_m == Vector2::zeros() {
            return *state;
        }
        let moving = state.in_air(&self.wind).over_ground(&self.known);
        State { x_m: state.x_m + astray_m.x, y_m: state.y_m + astray_m.y, ..moving }
    }

    /// The airspeed, m/s, that a run on the ground would take off with: against the wind it is faster.
    pub fn lift_off_speed_mps(&self, state: &State) -> f64 {
        let (sin, cos) = libm::sincos(state.course_rad);
        state.speed_mps - self.outside.north_mps * cos - self.outside.east_mps * sin
    }

    /// Rate of turn that the loops have flown over the last step, rad/s: what a gust does to the heading is no turn.
    pub fn turn_rate_radps(&self, state: &State, step_s: f64) -> f64 {
        wrap_pi(self.see(state).course_rad - self.see(&self.before).course_rad) / step_s
    }

    /// Acceleration over the last step, (north, east, up) in m/s2.
    pub fn acceleration_mps2(&self, state: &State, step_s: f64) -> [f64; 3] {
        let (now, before) = (state.velocity_mps(), self.before.velocity_mps());
        let climb_mps = state.climb_mps - self.before.climb_mps;
        [now.x - before.x, now.y - before.y, climb_mps].map(|change| change / step_s)
    }

    /// A step begins at a state.
    #[inline]
    pub fn remember(&mut self, before: &State) {
        self.before = *before;
    }

    /// The vehicle has been carried for a step by a wind that it may not know.
    #[inline]
    pub fn carry(&mut self, step_s: f64) {
        self.astray_m.x += step_s * (self.known.north_mps - self.wind.north_mps);
        self.astray_m.y += step_s * (self.known.east_mps - self.wind.east_mps);
    }

    /// A setpoint of what is wanted as airspeed and heading, by the wind triangle. The heading lags behind its setpoint
    /// by the time constant of its loop: the airspeed of then counts, or each gust would turn the course while the
    /// airspeed settles. `ratio` is the true airspeed of an equivalent one, which airspeed setpoints and limits are.
    #[inline]
    pub fn through(
        &self,
        setpoint: &Setpoint,
        wanted: Wanted,
        airspeed_mps: f64,
        ratio: f64,
        dynamics: &Dynamics,
    ) -> Setpoint {
        let known = self.known;
        let mut through = *setpoint;
        if known.north_mps == 0.0 && known.east_mps == 0.0 {
            if wanted.is_ground_speed {
                through.speed_mps /= ratio;
            }
            return through;
        }
        let limits = dynamics.limits;
        if wanted.is_ground_speed {
            let (wanted_mps, _) = known.air_velocity(setpoint.speed_mps, setpoint.course_rad);
            through.speed_mps = (wanted_mps / ratio).clamp(limits.speed_min_mps, limits.speed_max_mps);
        }
        if !wanted.is_heading {
            let tau = dynamics.time_constants;
            let settled_mps = through.speed_mps.clamp(limits.speed_min_mps, limits.speed_max_mps) * ratio;
            let settling_mps = settled_mps - airspeed_mps;
            let then_mps = airspeed_mps + settling_mps * (tau.course_s / tau.speed_s).min(1.0);
            through.course_rad = known.heading_rad(setpoint.course_rad, then_mps);
        }
        through
    }
}

/// What a setpoint means in air that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// The speed is over ground, not through the air.
    pub is_ground_speed: bool,
    /// The course is where the nose points.
    pub is_heading: bool,
}
