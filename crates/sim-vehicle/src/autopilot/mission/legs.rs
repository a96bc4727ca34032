//! What the item that AUTO flies still wants, and when it has it.

use crate::autopilot::flight::tuning::TAKEOFF_TOLERANCE_M;
use flight_model::{State, wrap_pi};
use nalgebra::Vector2;
use std::time::Duration;

/// What the current item still wants.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Leg {
    /// Its beginning.
    #[default]
    Begin,
    /// To be so near to a place, and not to come nearer: `nearest_m` is how near it has come.
    Place { at: Vector2<f64>, radius_m: f64, nearest_m: f64 },
    /// To be at an altitude, or not below it, or not above it, m above the origin.
    Altitude(f64, AltitudeEnd),
    /// To be on its circle, from then on to turn so far (rad), to stay so long, or to be at an altitude.
    Circle { at: Vector2<f64>, radius_m: f64, until: CircleEnd, flown: Option<Circled> },
    /// To be on the ground.
    Landing,
    /// A landing is given up: to climb to an altitude, m above the origin.
    GoAround(f64),
    /// It stands on the ground and the mission has no take-off: to climb to an altitude, m above the origin, first.
    TakeOffFirst(f64),
    /// Nothing: it has no end.
    Forever,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AltitudeEnd {
    /// Within ArduPlane's 5 m.
    Near,
    NotBelow,
    NotAbove,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum CircleEnd {
    Turned(f64),
    Stayed(Duration),
    Altitude(f64),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Circled {
    since: Duration,
    bearing_rad: f64,
    turned_rad: f64,
}

impl Leg {
    /// Looks after an integration step whether the current item has all that it wants.
    pub fn is_done(&mut self, state: &State, is_on_ground: bool, time: Duration) -> bool {
        if is_on_ground || matches!(self, Leg::Landing) {
            return is_on_ground && matches!(self, Leg::Landing);
        }
        let from = |place: Vector2<f64>| {
            let away = state.position_m() - place;
            (away.norm(), libm::atan2(away.y, away.x))
        };
        match self {
            Leg::Begin | Leg::Forever | Leg::Landing => false,
            Leg::Place { at, radius_m, nearest_m } => {
                // Who sees the vehicle a few times a second must see it within the radius: the item ends where it is
                // nearest.
                let distance_m = from(*at).0;
                let recedes = distance_m >= *nearest_m;
                *nearest_m = nearest_m.min(distance_m);
                distance_m <= *radius_m && recedes
            }
            Leg::Altitude(altitude_m, end) => {
                let above_m = state.altitude_m - *altitude_m;
                match end {
                    AltitudeEnd::Near => above_m.abs() <= 5.0,
                    AltitudeEnd::NotBelow => above_m >= -TAKEOFF_TOLERANCE_M,
                    AltitudeEnd::NotAbove => above_m <= TAKEOFF_TOLERANCE_M,
                }
            }
            Leg::GoAround(altitude_m) | Leg::TakeOffFirst(altitude_m) => {
                state.altitude_m >= *altitude_m - TAKEOFF_TOLERANCE_M
            }
            Leg::Circle { at, radius_m, until, flown } => {
                let (distance_m, bearing_rad) = from(*at);
                match flown {
                    None => {
                        if (distance_m - *radius_m).abs() <= 0.1 * *radius_m {
                            *flown = Some(Circled { since: time, bearing_rad, turned_rad: 0.0 });
                        }
                        false
                    }
                    Some(circled) => {
                        circled.turned_rad += wrap_pi(bearing_rad - circled.bearing_rad);
                        circled.bearing_rad = bearing_rad;
                        match until {
                            CircleEnd::Turned(angle_rad) => circled.turned_rad.abs() >= *angle_rad,
                            CircleEnd::Stayed(stay) => time.saturating_sub(circled.since) >= *stay,
                            CircleEnd::Altitude(altitude_m) => {
                                (state.altitude_m - *altitude_m).abs() <= TAKEOFF_TOLERANCE_M
                            }
                        }
                    }
                }
            }
        }
    }
}
