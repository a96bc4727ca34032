//! What the item that AUTO flies still wants, and when it has it.

use super::loiter::{Loiter, Now};
use crate::autopilot::flight::tuning::TAKEOFF_TOLERANCE_M;
use flight_model::State;
use nalgebra::Vector2;
use std::time::Duration;

/// What the current item still wants.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Leg {
    /// Its beginning.
    #[default]
    Begin,
    /// To be so near to a place, and not to come nearer: `nearest_m` is how near it has come. Or to be abeam of it, as
    /// seen on the way from a place where that counts.
    Place {
        at: Vector2<f64>,
        radius_m: f64,
        nearest_m: f64,
        abeam_from: Option<Vector2<f64>>,
        /// Whether it is over within the radius, and not where it is nearest.
        ends_at_once: bool,
    },
    /// To be at an altitude, or not below it, or not above it, m above the origin.
    Altitude(f64, AltitudeEnd),
    /// To circle.
    Circle(Loiter),
    /// To be on the ground.
    Landing,
    /// A landing is given up: to climb to an altitude, m above the origin.
    GoAround(f64),
    /// It stands on the ground and the mission has no take-off: to climb to an altitude, m above the origin, first.
    TakeOffFirst(f64),
    /// Nothing: it has no end.
    Forever,
}

/// Whether somebody has passed a place on the way from another one: is past the line through it, across the way
/// (`Location::past_interval_finish_line`).
pub(super) fn is_beyond(here: Vector2<f64>, from: Vector2<f64>, at: Vector2<f64>) -> bool {
    (here - at).dot(&(at - from)) >= 0.0
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AltitudeEnd {
    /// Within ArduPlane's 5 m.
    Near,
    NotBelow,
    NotAbove,
    Exceeded,
}

impl Leg {
    /// Looks after an integration step whether the current item has all that it wants.
    pub fn is_done(&mut self, state: &State, is_on_ground: bool, time: Duration) -> bool {
        if is_on_ground || matches!(self, Leg::Landing) {
            return is_on_ground && matches!(self, Leg::Landing);
        }
        match self {
            Leg::Begin | Leg::Forever | Leg::Landing => false,
            Leg::Place { at, radius_m, nearest_m, abeam_from, ends_at_once } => {
                // Who sees the vehicle a few times a second must see it within the radius: the item ends where it is
                // nearest.
                let distance_m = (state.position_m() - *at).norm();
                let recedes = *ends_at_once || distance_m >= *nearest_m;
                *nearest_m = nearest_m.min(distance_m);
                (distance_m <= *radius_m && recedes)
                    || abeam_from.is_some_and(|from| is_beyond(state.position_m(), from, *at))
            }
            Leg::Altitude(altitude_m, end) => {
                let above_m = state.altitude_m - *altitude_m;
                match end {
                    AltitudeEnd::Near => above_m.abs() <= 5.0,
                    AltitudeEnd::NotBelow => above_m >= -TAKEOFF_TOLERANCE_M,
                    AltitudeEnd::NotAbove => above_m <= TAKEOFF_TOLERANCE_M,
                    AltitudeEnd::Exceeded => above_m > 0.0,
                }
            }
            Leg::GoAround(altitude_m) | Leg::TakeOffFirst(altitude_m) => {
                state.altitude_m >= *altitude_m - TAKEOFF_TOLERANCE_M
            }
            Leg::Circle(loiter) => {
                let (place, course_rad) = (state.position_m(), state.course_rad);
                loiter.is_over(&Now { time, place, course_rad, altitude_m: state.altitude_m })
            }
        }
    }
}
