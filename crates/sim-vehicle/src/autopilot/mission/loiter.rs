//! When a loiter of a mission is over: on the circle, then what the item asks for, then on the way to what comes next
//! (`verify_loiter_turns` and its kin, `isHeadingLinedUp` of ArduPlane; `is_mission_item_reached_or_completed` of PX4).

use flight_model::wrap_pi;
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Duration;

type Place = Vector2<f64>;

/// An ArduPlane counts as on its circle from here on, in radii: where it goes over from coming nearer to turning.
const ON_CIRCLE: f64 = 1.05;
/// How near to its altitude a loiter must be: 5 m for an ArduPlane, NAV_FW_ALT_RAD for a PX4.
const ARDUPLANE_ALTITUDE_M: f64 = 5.0;
pub(super) const PX4_ALTITUDE_M: f64 = 10.0;
/// How well the course must be lined up with the next place, at first.
const ARDUPLANE_LINED_UP_RAD: f64 = 10.0 * TAU / 360.0;
const PX4_LINED_UP_RAD: f64 = 5.0 * TAU / 360.0;

/// Which autopilot's rules count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rules {
    ArduPlane,
    Px4,
}

/// What a loiter asks for once it is on its circle.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// To turn so far, rad.
    Turned(f64),
    Stayed(Duration),
    /// To be at an altitude, m above the origin.
    Altitude(f64),
    /// To be at an altitude, and to stay so long.
    AltitudeAndStayed(f64, Duration),
}

/// Where it leads to in the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Exit {
    /// Nowhere: it is over when it has what it asks for.
    AtOnce,
    /// When it flies towards this place.
    Toward(Place),
}

/// What is known of the vehicle at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now {
    pub time: Duration,
    pub place: Place,
    pub course_rad: f64,
    pub altitude_m: f64,
}

/// A loiter under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loiter {
    pub centre: Place,
    pub radius_m: f64,
    /// 1 clockwise, -1 anticlockwise.
    pub turn: f64,
    /// m, within which a PX4 counts as on its circle, and its altitude m above the origin.
    pub margin_m: f64,
    pub altitude_m: f64,
    pub goal: Goal,
    pub exit: Exit,
    pub rules: Rules,
    flown: Option<Flown>,
}

#[derive(Clone, Copy, Debug)]
struct Flown {
    since: Duration,
    bearing_rad: f64,
    turned_rad: f64,
    /// How far it had turned when it had what it asks for.
    met_at_rad: Option<f64>,
}

impl Loiter {
    pub fn new(centre: Place, radius_m: f64, turn: f64, goal: Goal, exit: Exit, rules: Rules) -> Self {
        Self { centre, radius_m, turn, margin_m: 0.0, altitude_m: 0.0, goal, exit, rules, flown: None }
    }

    /// Looks after an integration step whether it is over.
    pub fn is_over(&mut self, now: &Now) -> bool {
        let away = now.place - self.centre;
        let (distance_m, bearing_rad) = (away.norm(), libm::atan2(away.y, away.x));
        let Some(mut flown) = self.flown else {
            if self.is_on_circle(distance_m, now.altitude_m) {
                self.flown = Some(Flown { since: now.time, bearing_rad, turned_rad: 0.0, met_at_rad: None });
            }
            return false;
        };
        flown.turned_rad += wrap_pi(bearing_rad - flown.bearing_rad);
        flown.bearing_rad = bearing_rad;
        let is_met = flown.met_at_rad.is_some() || self.is_met(&flown, now, distance_m);
        if is_met && flown.met_at_rad.is_none() {
            flown.met_at_rad = Some(flown.turned_rad);
        }
        self.flown = Some(flown);
        is_met && self.leads_to_the_next(&flown, now, away)
    }

    fn is_on_circle(&self, distance_m: f64, altitude_m: f64) -> bool {
        match self.rules {
            Rules::ArduPlane => distance_m <= ON_CIRCLE * self.radius_m,
            Rules::Px4 => {
                let is_high = matches!(self.goal, Goal::Altitude(_) | Goal::AltitudeAndStayed(..))
                    || (altitude_m - self.altitude_m).abs() <= PX4_ALTITUDE_M;
                distance_m <= self.radius_m + self.margin_m && is_high
            }
        }
    }

    fn is_met(&self, flown: &Flown, now: &Now, distance_m: f64) -> bool {
        let has_stayed = |stay: Duration| now.time.saturating_sub(flown.since) >= stay;
        let near_m = if self.rules == Rules::Px4 { PX4_ALTITUDE_M } else { ARDUPLANE_ALTITUDE_M };
        let is_at = |altitude_m: f64| (now.altitude_m - altitude_m).abs() < near_m;
        match self.goal {
            // An ArduPlane that is off its circle again has not met its turns.
            Goal::Turned(angle_rad) => {
                self.is_on_circle(distance_m, now.altitude_m) && flown.turned_rad.abs() >= angle_rad
            }
            Goal::Stayed(stay) => has_stayed(stay),
            Goal::Altitude(altitude_m) => is_at(altitude_m),
            Goal::AltitudeAndStayed(altitude_m, stay) => is_at(altitude_m) && has_stayed(stay),
        }
    }

    fn leads_to_the_next(&self, flown: &Flown, now: &Now, away: Place) -> bool {
        let Exit::Toward(next) = self.exit else { return true };
        let to_next = next - self.centre;
        let next_m = to_next.norm();
        match self.rules {
            Rules::Px4 => {
                let to_next_rad = libm::atan2(next.y - now.place.y, next.x - now.place.x);
                next_m <= 1.05 * self.radius_m || wrap_pi(to_next_rad - now.course_rad).abs() < PX4_LINED_UP_RAD
            }
            Rules::ArduPlane => {
                if next_m <= 0.0 || self.radius_m <= 0.0 {
                    return true;
                }
                // Where it is on the circle, and how it would leave it there: errors of its radius and course do not count.
                let at_rad = libm::atan2(away.y, away.x);
                let (sin, cos) = libm::sincos(at_rad);
                let leaving_rad = at_rad + self.turn * FRAC_PI_2;
                let wanted_rad = if next_m >= self.radius_m {
                    libm::atan2(to_next.y - self.radius_m * sin, to_next.x - self.radius_m * cos)
                } else {
                    // A place inside is never ahead: it turns off before, the earlier the nearer to the centre it is.
                    let chord_rad = 2.0 * libm::asin((self.radius_m - next_m) / (2.0 * self.radius_m));
                    libm::atan2(to_next.y, to_next.x) + self.turn * (FRAC_PI_2 - chord_rad)
                };
                let turned_since_rad = (flown.turned_rad - flown.met_at_rad.unwrap_or(flown.turned_rad)).abs();
                let allowed_rad = ARDUPLANE_LINED_UP_RAD * (1.0 + (turned_since_rad / TAU).floor());
                wrap_pi(wanted_rad - leaving_rad).abs() <= allowed_rad
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round a circle of 100 m at the origin, clockwise from the south at one degree a second; after how many seconds it is
    /// over.
    fn over_after(mut loiter: Loiter, radius_m: f64) -> Option<u64> {
        (0..3600).find(|second| {
            let angle_rad = TAU * (0.5 + *second as f64 / 360.0);
            let now = Now {
                time: Duration::from_secs(*second),
                place: Place::new(radius_m * libm::cos(angle_rad), radius_m * libm::sin(angle_rad)),
                course_rad: angle_rad + FRAC_PI_2,
                altitude_m: *second as f64,
            };
            loiter.is_over(&now)
        })
    }

    fn loiter(goal: Goal, exit: Exit, rules: Rules) -> Loiter {
        Loiter::new(Place::zeros(), 100.0, 1.0, goal, exit, rules)
    }

    #[test]
    fn no_turns_are_over_on_the_circle_and_not_before() {
        let none = loiter(Goal::Turned(0.0), Exit::AtOnce, Rules::ArduPlane);
        assert_eq!(over_after(none, 104.0), Some(1));
        assert_eq!(over_after(none, 106.0), None);
    }

    #[test]
    fn what_is_asked_for_is_followed_by_the_way_to_the_next() {
        // From the south it leads north, along the western tangent, after a quarter of a turn.
        let north = Exit::Toward(Place::new(10_000.0, -100.0));
        let turns = |exit| over_after(loiter(Goal::Turned(TAU), exit, Rules::ArduPlane), 100.0);
        assert!(matches!(turns(Exit::AtOnce), Some(360 | 361)));
        let lined_up = turns(north).unwrap();
        assert!((360 + 79..=360 + 90).contains(&lined_up), "{lined_up}");
        let stayed = Goal::Stayed(Duration::from_secs(100));
        // A PX4 waits for the altitude too, and margins are its own.
        let mut held = loiter(stayed, Exit::AtOnce, Rules::Px4);
        (held.margin_m, held.altitude_m) = (1.0, -50.0);
        assert_eq!(over_after(held, 100.0), None);
        (held.exit, held.altitude_m) = (north, 50.0);
        let lined_up = over_after(held, 100.0).unwrap();
        assert!((360 + 84..=360 + 90).contains(&lined_up), "{lined_up}");
    }

    #[test]
    fn an_altitude_is_met_within_5_m_and_to_a_px4_within_10_m() {
        for (rules, second) in [(Rules::ArduPlane, 196), (Rules::Px4, 191)] {
            assert_eq!(
                over_after(loiter(Goal::Altitude(200.0), Exit::AtOnce, rules), 100.0),
                Some(second),
                "{rules:?}"
            );
        }
    }

    #[test]
    fn a_place_inside_the_circle_is_left_for_once_a_turn() {
        let inside = Exit::Toward(Place::new(-50.0, 0.0));
        let over = over_after(loiter(Goal::Turned(0.0), inside, Rules::ArduPlane), 100.0).unwrap();
        assert!(over > 300 && over < 360, "{over}");
    }
}
