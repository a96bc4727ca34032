//! Angles on the circle.

use std::f64::consts::{PI, TAU};

/// The same direction in (-pi, pi]. Course errors are always taken so (reading 4 of the paper).
///
/// NaN and the infinities give NaN.
pub fn wrap_pi(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    // floor is exact, so this holds for any number of turns up to the precision of the argument itself.
    let wrapped = angle_rad - TAU * ((angle_rad + PI) / TAU).floor();
    if wrapped <= -PI {
        wrapped + TAU
    } else if wrapped > PI {
        wrapped - TAU
    } else if wrapped == -PI {
        PI
    } else {
        wrapped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_seam_belongs_to_plus_pi() {
        assert_eq!(wrap_pi(PI), PI);
        assert_eq!(wrap_pi(-PI), PI);
        assert_eq!(wrap_pi(0.5), 0.5);
        assert!((wrap_pi(3.0 * PI) - PI).abs() < 1e-12);
        assert!(wrap_pi(f64::NAN).is_nan());
    }

    proptest! {
        #[test]
        fn stays_in_range_and_keeps_the_direction(angle in -1e4..1e4f64) {
            let wrapped = wrap_pi(angle);
            prop_assert!(wrapped > -PI - 1e-15 && wrapped <= PI);
            prop_assert!((libm::cos(wrapped) - libm::cos(angle)).abs() < 1e-9);
            prop_assert!((libm::sin(wrapped) - libm::sin(angle)).abs() < 1e-9);
        }
    }
}
