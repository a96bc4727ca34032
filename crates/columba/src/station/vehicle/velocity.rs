//! By how much the velocities that an autopilot tells are off from its own positions.
//!
//! PX4's estimator brings its position to the measurements without telling so in its velocity: in and after a turn
//! the two differ by up to 0.9 m/s for seconds. Where a vehicle will be follows from how its position moves.

use super::track::velocity_mps;
use flight_model::{State, wrap_pi};
use mavlink_bridge::kind::AutopilotKind;

/// With which differences are smoothed, s: what the message rounds is averaged over it.
const SMOOTHING_S: f64 = 0.25;
/// Positions further apart than this tell no velocity of a moment, s.
const GAP_MAX_S: f64 = 0.3;
/// A larger difference is a jump of the position, m/s.
const JUMP_MPS: f64 = 3.0;
/// A vehicle that is slower than this is left as it is told: the direction of its velocity means nothing, m/s.
const MOVES_MPS: f64 = 1.0;

/// The difference of told velocities from the way of told positions, smoothed.
#[derive(Debug, Default)]
pub struct VelocityOffset {
    /// Vehicle's time and state of the last position, s.
    last: Option<(f64, State)>,
    /// North and east, m/s.
    offset_mps: [f64; 2],
}

impl VelocityOffset {
    /// The state to be taken for a told one. `boot_s` is the vehicle's own time of it, s.
    pub fn take(&mut self, kind: Option<AutopilotKind>, boot_s: f64, told: State) -> State {
        match kind {
            Some(AutopilotKind::Px4Multicopter | AutopilotKind::Px4FixedWing) => self.correct(boot_s, &told),
            // Smoothed differences would make the velocities of others worse (docs/real-autopilots.md).
            _ => told,
        }
    }

    /// The state with the velocity with which its position moves.
    fn correct(&mut self, boot_s: f64, told: &State) -> State {
        if let Some((last_s, last)) = self.last {
            self.learn(boot_s - last_s, &last, told);
        }
        self.last = Some((boot_s, *told));
        if told.speed_mps < MOVES_MPS {
            return *told;
        }
        let (north_mps, east_mps) = velocity_mps(told);
        let (north_mps, east_mps) = (north_mps + self.offset_mps[0], east_mps + self.offset_mps[1]);
        State {
            speed_mps: libm::hypot(north_mps, east_mps),
            course_rad: wrap_pi(libm::atan2(east_mps, north_mps)),
            ..*told
        }
    }

    fn learn(&mut self, span_s: f64, last: &State, told: &State) {
        if span_s <= 0.0 {
            return;
        }
        if span_s > GAP_MAX_S {
            self.offset_mps = [0.0; 2];
            return;
        }
        let ((north_a, east_a), (north_b, east_b)) = (velocity_mps(last), velocity_mps(told));
        let difference_mps = [
            (told.x_m - last.x_m) / span_s - 0.5 * (north_a + north_b),
            (told.y_m - last.y_m) / span_s - 0.5 * (east_a + east_b),
        ];
        if libm::hypot(difference_mps[0], difference_mps[1]) > JUMP_MPS {
            return;
        }
        let share = 1.0 - libm::exp(-span_s / SMOOTHING_S);
        for (offset_mps, difference_mps) in self.offset_mps.iter_mut().zip(difference_mps) {
            *offset_mps += share * (difference_mps - *offset_mps);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let (north_mps, east_mps) = velocity_mps(&offset.correct(at_s, &state));
            libm::hypot(north_mps - 10.0 * libm::cos(course_rad), east_mps - 10.0 * libm::sin(course_rad))
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
        let difference_mps = offset.correct(5.0, &jumped).speed_mps - state.speed_mps;
        assert!(difference_mps.abs() < 0.15, "{difference_mps}");
        let (later, _) = told(6.0, 0.0);
        assert_eq!(offset.correct(6.0, &later).speed_mps, later.speed_mps);
        let stands = State { speed_mps: 0.1, course_rad: 1.0, ..later };
        assert_eq!(offset.correct(6.1, &stands), stands);
    }
}
