//! AUTO: one item after the other.

use super::{CHANGE_SPEED, JUMP, LOITER_TIME, LOITER_TURNS, LOITER_UNLIM, RETURN_TO_LAUNCH, TAKEOFF, WAYPOINT};
use crate::flight::TAKEOFF_TOLERANCE_M;
use crate::parameters::Parameter;
use crate::{Mode, Vehicle};
use flight_model::{Geodetic, wrap_pi};
use mavlink_bridge::PlanItem;
use mavlink_bridge::dialect::{MISSION_ITEM_REACHED_DATA, MavSeverity, Message};
use std::f64::consts::TAU;
use std::time::Duration;

/// Most items that are done in one step without any flying between them: jumps may go round for ever.
const ITEMS_AT_ONCE_MAX: usize = 100;

/// How far AUTO has come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Progress {
    /// The item that is flown, or will be when AUTO is set.
    pub current: u16,
    pub is_complete: bool,
    /// Times that each jump was made.
    jumps: Vec<(u16, u32)>,
    leg: Leg,
}

/// What the current item still wants.
#[derive(Clone, Copy, Debug, Default)]
enum Leg {
    /// Its beginning.
    #[default]
    Begin,
    /// To be so near to a place.
    Place { at: (f64, f64), radius_m: f64 },
    /// An altitude.
    Altitude(f64),
    /// To be on its circle, from then on to turn so far (rad) or to stay so long.
    Circle { at: (f64, f64), radius_m: f64, until: CircleEnd, flown: Option<Circled> },
    /// Nothing: it has no end.
    Forever,
}

#[derive(Clone, Copy, Debug)]
enum CircleEnd {
    Turned(f64),
    Stayed(Duration),
}

#[derive(Clone, Copy, Debug)]
struct Circled {
    since: Duration,
    bearing_rad: f64,
    turned_rad: f64,
}

impl Vehicle {
    /// AUTO has been set: it goes on with the current item, from its beginning.
    pub(crate) fn begin_mission(&mut self) {
        if self.progress.is_complete || self.progress.current == 0 {
            self.progress = Progress { current: 1, ..Progress::default() };
        }
        self.progress.leg = Leg::Begin;
    }

    /// Another mission begins at its beginning; a changed one goes on where it is.
    pub(crate) fn mission_changed(&mut self, whole: bool) {
        if whole {
            self.progress = Progress { current: self.mission.len().min(1), ..Progress::default() };
        }
        self.progress.leg = Leg::Begin;
        if self.mode() == Mode::Auto && !self.mission.is_flyable() {
            self.end_mission("Mission cleared, RTL");
        }
    }

    /// Goes to an item of the mission, or says why not.
    pub(crate) fn set_current_item(&mut self, seq: u16) -> Result<(), String> {
        if self.mission.get(seq).is_none() {
            return Err(format!("Mission: no item {seq}"));
        }
        self.progress = Progress { current: seq.max(1), ..Progress::default() };
        Ok(())
    }

    /// Looks after each integration step whether the current item is done, and begins the next.
    pub(crate) fn follow_mission(&mut self) {
        if self.mode() != Mode::Auto || !self.flight.is_armed() {
            return;
        }
        for _ in 0..ITEMS_AT_ONCE_MAX {
            if self.mode() != Mode::Auto {
                return;
            }
            let Some(item) = self.mission.get(self.progress.current).copied() else {
                self.progress.is_complete = true;
                self.end_mission("Mission complete, RTL");
                return;
            };
            if matches!(self.progress.leg, Leg::Begin) {
                self.begin_item(&item);
            } else if self.is_leg_done() {
                let seq = self.progress.current;
                if item.command == TAKEOFF {
                    self.takeoff_changes_fence();
                }
                self.links.send_all(&Message::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq }));
                self.go_to(seq + 1);
            } else {
                return;
            }
        }
    }

    fn end_mission(&mut self, text: &str) {
        self.say(MavSeverity::MAV_SEVERITY_INFO, text);
        self.set_mode(Mode::Rtl);
    }

    fn go_to(&mut self, seq: u16) {
        self.progress.current = seq;
        self.progress.leg = Leg::Begin;
    }

    fn begin_item(&mut self, item: &PlanItem) {
        let seq = self.progress.current;
        let [p1, p2, p3, _] = item.params.map(f64::from);
        let at = self.place_of(item);
        let altitude_m = self.altitude_of(item);
        let radius_m = if p3 == 0.0 { self.flight.tuning().loiter_radius_m } else { p3 };
        self.progress.leg = match item.command {
            WAYPOINT => {
                self.flight.fly_to(at);
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                let acceptance_m =
                    if p2 > 0.0 { p2 } else { f64::from(self.parameters.get(Parameter::WaypointRadius)) };
                Leg::Place { at, radius_m: acceptance_m }
            }
            LOITER_UNLIM | LOITER_TURNS | LOITER_TIME => {
                let radius_m = self.flight.circle_at(at, radius_m);
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                match item.command {
                    LOITER_TURNS => Leg::Circle { at, radius_m, until: CircleEnd::Turned(TAU * p1), flown: None },
                    LOITER_TIME => {
                        let stay = Duration::try_from_secs_f64(p1).unwrap_or(Duration::MAX);
                        Leg::Circle { at, radius_m, until: CircleEnd::Stayed(stay), flown: None }
                    }
                    _ => Leg::Forever,
                }
            }
            TAKEOFF => {
                // It starts in the air: straight on, and up.
                self.flight.hold_course();
                self.flight.set_altitude(altitude_m, f64::INFINITY);
                Leg::Altitude(altitude_m)
            }
            RETURN_TO_LAUNCH => {
                self.set_mode(Mode::Rtl);
                return;
            }
            CHANGE_SPEED => {
                let least = f64::from(self.parameters.get(Parameter::AirspeedMin));
                let most = f64::from(self.parameters.get(Parameter::AirspeedMax));
                self.flight.set_speed(p2.clamp(least, most), f64::INFINITY);
                return self.go_to(seq + 1);
            }
            JUMP => {
                let index = self.progress.jumps.iter().position(|(jump, _)| *jump == seq).unwrap_or_else(|| {
                    self.progress.jumps.push((seq, 0));
                    self.progress.jumps.len() - 1
                });
                let made = &mut self.progress.jumps[index].1;
                // A negative number of repeats is for ever.
                let again = p2 < 0.0 || f64::from(*made) < p2;
                *made += u32::from(again);
                return self.go_to(if again { p1 as u16 } else { seq + 1 });
            }
            // The upload lets nothing else in.
            _ => return self.go_to(seq + 1),
        };
    }

    fn is_leg_done(&mut self) -> bool {
        let (state, time) = (*self.flight.state(), self.time);
        let from = |(x_m, y_m): (f64, f64)| {
            let (north, east) = (state.x_m - x_m, state.y_m - y_m);
            ((north * north + east * east).sqrt(), libm::atan2(east, north))
        };
        match &mut self.progress.leg {
            Leg::Begin | Leg::Forever => false,
            Leg::Place { at, radius_m } => from(*at).0 <= *radius_m,
            Leg::Altitude(altitude_m) => (state.altitude_m - *altitude_m).abs() <= TAKEOFF_TOLERANCE_M,
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
                        }
                    }
                }
            }
        }
    }

    /// Where an item is, (north, east) in m; without a place, here.
    pub(crate) fn place_of(&self, item: &PlanItem) -> (f64, f64) {
        if item.latitude_e7 == 0 && item.longitude_e7 == 0 {
            let state = self.flight.state();
            return (state.x_m, state.y_m);
        }
        let place = Geodetic {
            latitude_deg: f64::from(item.latitude_e7) * 1e-7,
            longitude_deg: f64::from(item.longitude_e7) * 1e-7,
            altitude_amsl_m: self.altitude_of(item) + self.settings.frame.origin().altitude_amsl_m,
        };
        let (x_m, y_m, _) = self.settings.frame.to_local(&place);
        (x_m, y_m)
    }

    /// Its altitude above home, m: terrain is as high as home.
    pub(crate) fn altitude_of(&self, item: &PlanItem) -> f64 {
        let above_sea = matches!(item.frame, 0 | 5);
        let origin_m = if above_sea { self.settings.frame.origin().altitude_amsl_m } else { 0.0 };
        f64::from(item.z_m) - origin_m
    }
}
