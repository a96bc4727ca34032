//! Attitudes as messages have them.

/// Bank and pitch of a rotation from north-east-down to the body, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Euler {
    pub roll_rad: f64,
    pub pitch_rad: f64,
}

impl Euler {
    /// Of a quaternion, w first, of any length, as ArduPilot and PX4 read it: one of zeros is level. None where a part
    /// is no finite number.
    pub fn of(q: [f32; 4]) -> Option<Self> {
        if !q.iter().all(|part| part.is_finite()) {
            return None;
        }
        let [w, x, y, z] = q.map(f64::from);
        let roll_rad = libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y));
        let pitch_rad = libm::asin((2.0 * (w * y - z * x)).clamp(-1.0, 1.0));
        Some(Self { roll_rad, pitch_rad })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bank_and_pitch_are_those_of_the_rotation_whatever_its_yaw() {
        let half = |angle_rad: f64| libm::sincos(0.5 * angle_rad);
        let ((sr, cr), (sp, cp), (sy, cy)) = (half(0.4), half(-0.2), half(2.5));
        let q = [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ];
        let euler = Euler::of(q.map(|part| part as f32)).unwrap();
        assert!((euler.roll_rad - 0.4).abs() < 1e-6 && (euler.pitch_rad + 0.2).abs() < 1e-6, "{euler:?}");
        assert_eq!(Euler::of([0.0; 4]), Some(Euler { roll_rad: 0.0, pitch_rad: 0.0 }));
        assert_eq!(Euler::of([1.0, f32::NAN, 0.0, 0.0]), None);
    }
}
