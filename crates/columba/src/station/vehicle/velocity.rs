//! By how much the velocities that an autopilot tells are off from its own positions.
//!
//! PX4's estimator brings its position to the measurements without telling so in its velocity: in and after a turn
//! the two differ by up to 0.9 m/s for seconds. A multicopter holds the velocity that it tells, and so its position
//! drifts off the course that was asked for. Where a vehicle will be follows from how its position moves.

use flight_model::{State, wrap_pi};
use mavlink_bridge::kind::AutopilotKind;
use nalgebra::Vector2;

/// With which differences are smoothed, s: what the message rounds is averaged over it.
const SMOOTHING_S: f64 = 0.25;
/// Positions further apart than this tell no velocity of a moment, s.
const GAP_MAX_S: f64 = 0.3;
/// A larger difference is a jump of the position, m/s.
const JUMP_MPS: f64 = 3.0;
/// A vehicle that is slower than this is left as it is told: the direction of its velocity means nothing, m/s.
const MOVES_MPS: f64 = 1.0;
/// A simulator's clock falls behind by no more than this where the machine keeps up: what is estimated beyond is a
/// burst of late messages.
const DRIFT_MAX: f64 = 0.03;

/// The difference of told velocities from the way of told positions, smoothed.
#[derive(Debug, Default)]
pub struct VelocityOffset {
    /// Vehicle's time and state of the last position, s.
    last: Option<(f64, State)>,
    /// North and east, m/s.
    offset_mps: Vector2<f64>,
    /// Whether it counts.
    applies: bool,
}

impl VelocityOffset {
    /// The state to be taken for a told one. `boot_s` is the vehicle's own time of it, s; `clock_drift` is by how much
    /// that clock falls behind in a second of the ground's.
    pub fn take(&mut self, kind: Option<AutopilotKind>, boot_s: f64, clock_drift: f64, told: State) -> State {
        match kind {
            Some(AutopilotKind::Px4Multicopter | AutopilotKind::Px4FixedWing) => {
                self.correct(boot_s, clock_drift, &told)
            }
            // Smoothed differences would make the velocities of others worse (docs/real-autopilots.md).
            _ => told,
        }
    }

    /// With which velocity its position moves, less the velocity that it tells (north, east), m/s.
    pub fn drift_mps(&self) -> Vector2<f64> {
        if self.applies { self.offset_mps } else { Vector2::zeros() }
    }

    /// The state with the velocity with which its position moves.
    fn correct(&mut self, boot_s: f64, clock_drift: f64, told: &State) -> State {
        if let Some((last_s, last)) = self.last {
            let ground_s = (boot_s - last_s) / (1.0 - clock_drift.clamp(-DRIFT_MAX, DRIFT_MAX));
            self.learn(ground_s, &last, told);
        }
        self.last = Some((boot_s, *told));
        self.applies = told.speed_mps >= MOVES_MPS;
        if !self.applies {
            return *told;
        }
        let moves_mps = told.velocity_mps() + self.offset_mps;
        let course_rad = wrap_pi(libm::atan2(moves_mps.y, moves_mps.x));
        State { speed_mps: moves_mps.norm(), course_rad, ..*told }
    }

    fn learn(&mut self, span_s: f64, last: &State, told: &State) {
        if span_s <= 0.0 {
            return;
        }
        if span_s > GAP_MAX_S {
            self.offset_mps = Vector2::zeros();
            return;
        }
        let way_m = told.position_m() - last.position_m();
        let difference_mps = way_m / span_s - 0.5 * (last.velocity_mps() + told.velocity_mps());
        if difference_mps.norm() > JUMP_MPS {
            return;
        }
        let share = 1.0 - libm::exp(-span_s / SMOOTHING_S);
        self.offset_mps += share * (difference_mps - self.offset_mps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::course_vector;

    /// 10 m/s round a circle of 20 m; the told velocity is off by `off_mps` to the east, places are whole centimetres.
    fn told(at_s: f64, off_mps: f64) -> (State, f64) {
        let (sin, cos) = libm::sincos(0.5 * at_s);
        let (north_mps, east_mps) = (10.0 * cos, 10.0 * sin + off_mps);
        let whole = |place_m: f64| 0.011 * libm::round(place_m / 0.011);
        let state = State {
            x_m: whole(20.0 * sin),
            y_m: whole(-20.0 * cos),
            speed_mps: libm::hypot(north_mps, east_mps),
            course_rad: libm::atan2(east_mps, north_mps),
            ..State::default()
        };
        (state, wrap_pi(0.5 * at_s))
    }

    fn worst_mps(offset: &mut VelocityOffset, off_mps: f64, steps: impl Iterator<Item = u32>) -> f64 {
        let errors = steps.map(|step| {
            let at_s = 0.1 * f64::from(step);
            let (state, course_rad) = told(at_s, off_mps);
            (offset.correct(at_s, 0.0, &state).velocity_mps() - 10.0 * course_vector(course_rad)).norm()
        });
        errors.skip(20).fold(0.0, f64::max)
    }

    #[test]
    fn a_velocity_that_is_off_from_its_own_positions_is_put_right() {
        assert!(worst_mps(&mut VelocityOffset::default(), 0.9, 0..200) < 0.15);
        assert!(worst_mps(&mut VelocityOffset::default(), 0.0, 0..200) < 0.15, "and a right one stays");
    }

    #[test]
    fn a_position_that_jumps_or_was_not_heard_tells_no_velocity() {
        let mut offset = VelocityOffset::default();
        worst_mps(&mut offset, 0.0, 0..50);
        let (state, _) = told(5.0, 0.0);
        let jumped = State { x_m: state.x_m + 2.0, ..state };
        let difference_mps = offset.correct(5.0, 0.0, &jumped).speed_mps - state.speed_mps;
        assert!(difference_mps.abs() < 0.15, "{difference_mps}");
        let (later, _) = told(6.0, 0.0);
        assert_eq!(offset.correct(6.0, 0.0, &later).speed_mps, later.speed_mps);
        let stands = State { speed_mps: 0.1, course_rad: 1.0, ..later };
        assert_eq!(offset.correct(6.1, 0.0, &stands), stands);
        assert_eq!(offset.drift_mps(), Vector2::zeros());
    }

    #[test]
    fn the_speed_of_a_slow_clock_is_that_on_the_clock_of_the_ground() {
        let mut offset = VelocityOffset::default();
        let state = |at_s: f64| State { x_m: 10.0 * at_s, speed_mps: 10.0, ..State::default() };
        let steps = (0..50).map(|step| 0.1 * f64::from(step));
        let last = steps.map(|boot_s| offset.correct(boot_s, 0.01, &state(boot_s))).last().unwrap();
        assert!((last.speed_mps - 9.9).abs() < 1e-3, "{last:?}");
        assert!((offset.drift_mps() - Vector2::new(-0.1, 0.0)).norm() < 1e-3);
    }
}
