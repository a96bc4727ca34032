//! Position targets: SET_POSITION_TARGET_LOCAL_NED and SET_POSITION_TARGET_GLOBAL_INT, and how a fixed wing flies them.

// Clients still send the older numbers of the frames.
#![allow(deprecated)]

use crate::vehicle::Vehicle;
use flight_model::wrap_pi;
use mavlink_bridge::LatLonE7;
use mavlink_bridge::dialect::{
    MavFrame, PositionTargetTypemask as Mask, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};

/// What a message asks for; what its mask leaves out is none, and so is what is no finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PositionTarget {
    pub mask: u16,
    /// (North, east) of the origin, m.
    pub place: Option<(f64, f64)>,
    /// Above the origin, m.
    pub altitude_m: Option<f64>,
    /// (North, east), m/s.
    pub velocity_mps: Option<(f64, f64)>,
    pub climb_mps: Option<f64>,
    /// Whether it asks for a position, a velocity or an acceleration at all, be it for half of one.
    pub asks_for_anything: bool,
}

/// Why a message is not followed, for a STATUSTEXT.
pub(super) type TargetRefused = String;

impl PositionTarget {
    /// In MAV_FRAME_LOCAL_NED, or velocities in MAV_FRAME_BODY_NED of a vehicle that heads `heading_rad`.
    pub fn from_local(data: &SET_POSITION_TARGET_LOCAL_NED_DATA, heading_rad: f64) -> Result<Self, TargetRefused> {
        let fields = [data.x, data.y, data.z, data.vx, data.vy, data.vz, data.afx, data.afy, data.afz];
        let target = Self::read(data.type_mask, fields.map(f64::from));
        match data.coordinate_frame {
            MavFrame::MAV_FRAME_LOCAL_NED => Ok(target),
            MavFrame::MAV_FRAME_BODY_NED => {
                let (sin, cos) = libm::sincos(heading_rad);
                let turn = |(ahead, right): (f64, f64)| (cos * ahead - sin * right, sin * ahead + cos * right);
                let velocity_mps = target.velocity_mps.map(turn);
                Ok(Self { place: None, altitude_m: None, velocity_mps, ..target })
            }
            other => Err(format!("coordinate frame {} unsupported", other as u32)),
        }
    }

    /// Its place and altitude as `to_local` and `altitude_m` have those of the message.
    pub fn from_global(
        data: &SET_POSITION_TARGET_GLOBAL_INT_DATA,
        to_local: impl Fn(LatLonE7) -> (f64, f64),
        altitude_m: impl Fn(f32, u8) -> Option<f64>,
    ) -> Result<Self, TargetRefused> {
        let position = LatLonE7::new(data.lat_int, data.lon_int);
        let (north_m, east_m) = to_local(position);
        // A velocity needs no frame.
        let up_m = match altitude_m(data.alt, data.coordinate_frame as u8) {
            Some(up_m) => up_m,
            None if data.type_mask.contains(PLACE | Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE) => f64::NAN,
            None => return Err(format!("coordinate frame {} unsupported", data.coordinate_frame as u32)),
        };
        let [vx, vy, vz, ax, ay, az] = [data.vx, data.vy, data.vz, data.afx, data.afy, data.afz].map(f64::from);
        let target = Self::read(data.type_mask, [north_m, east_m, -up_m, vx, vy, vz, ax, ay, az]);
        if target.place.is_some() && !position.is_valid() {
            return Err("no such place".into());
        }
        Ok(target)
    }

    /// Whether it says where to and how high: all that a PX4 needs to follow it.
    pub fn is_complete(&self) -> bool {
        (self.place.is_some() || self.velocity_mps.is_some()) && (self.altitude_m.is_some() || self.climb_mps.is_some())
    }

    /// Whether there is anything in it that can be flown.
    pub fn is_flyable(&self) -> bool {
        let horizontal = self.place.is_some() || self.velocity_mps.is_some();
        horizontal || self.altitude_m.is_some() || self.climb_mps.is_some()
    }

    fn read(mask: Mask, [x, y, z, vx, vy, vz, ax, ay, az]: [f64; 9]) -> Self {
        let asked = |ignored: Mask, value: f64| (!mask.contains(ignored) && value.is_finite()).then_some(value);
        let x = asked(Mask::POSITION_TARGET_TYPEMASK_X_IGNORE, x);
        let y = asked(Mask::POSITION_TARGET_TYPEMASK_Y_IGNORE, y);
        let z = asked(Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE, z);
        let vx = asked(Mask::POSITION_TARGET_TYPEMASK_VX_IGNORE, vx);
        let vy = asked(Mask::POSITION_TARGET_TYPEMASK_VY_IGNORE, vy);
        let vz = asked(Mask::POSITION_TARGET_TYPEMASK_VZ_IGNORE, vz);
        let accelerations = [
            asked(Mask::POSITION_TARGET_TYPEMASK_AX_IGNORE, ax),
            asked(Mask::POSITION_TARGET_TYPEMASK_AY_IGNORE, ay),
            asked(Mask::POSITION_TARGET_TYPEMASK_AZ_IGNORE, az),
        ];
        let others = [x, y, z, vx, vy, vz];
        Self {
            mask: mask.bits(),
            place: x.zip(y),
            // Zero must not become minus zero.
            altitude_m: z.map(|down_m| 0.0 - down_m),
            velocity_mps: vx.zip(vy),
            climb_mps: vz.map(|down_mps| 0.0 - down_mps),
            asks_for_anything: others.iter().chain(&accelerations).any(Option::is_some),
        }
    }
}

const PLACE: Mask = Mask::POSITION_TARGET_TYPEMASK_X_IGNORE.union(Mask::POSITION_TARGET_TYPEMASK_Y_IGNORE);

impl Vehicle {
    /// Flies a target: a place, along a line through a place in the direction of the velocity, or with a velocity; at an
    /// altitude or with a rate of climb. What it does not ask for stays as it is. From the ground, armed, it takes off where
    /// the target is higher.
    pub(super) fn fly_target(&mut self, target: &PositionTarget) {
        // A velocity of zero has no direction.
        let velocity_mps = target.velocity_mps.filter(|velocity| *velocity != (0.0, 0.0));
        match (target.place, velocity_mps) {
            (Some(place), Some(velocity)) => {
                self.flight.set_course(self.course_onto_line(place, velocity), f64::INFINITY)
            }
            (Some(place), None) => self.flight.fly_to(place),
            (None, Some((north, east))) => self.flight.set_course(wrap_pi(libm::atan2(east, north)), f64::INFINITY),
            (None, None) => {}
        }
        if let Some((north, east)) = velocity_mps {
            self.flight.set_speed((north * north + east * east).sqrt(), f64::INFINITY);
        }
        match (target.altitude_m, target.climb_mps) {
            (Some(altitude_m), _) => self.flight.set_altitude(altitude_m, f64::INFINITY),
            (None, Some(climb_mps)) => self.flight.climb_at(climb_mps),
            (None, None) => {}
        }
        if self.flight.is_on_ground() && self.flight.is_armed() && self.leads_up(target) {
            self.take_off_for_target();
        }
    }

    fn leads_up(&self, target: &PositionTarget) -> bool {
        /// How much higher than the ground a place must be.
        const HIGHER_M: f64 = 1.0;
        match (target.altitude_m, target.climb_mps) {
            (Some(altitude_m), _) => altitude_m > self.flight.state().altitude_m + HIGHER_M,
            (None, climb_mps) => climb_mps.is_some_and(|climb_mps| climb_mps > 0.0),
        }
    }

    /// Runs and lifts off, straight on, as fast as it must; the next target leads it in the air.
    fn take_off_for_target(&mut self) {
        let least_mps = self.flight.limits().speed_min_mps;
        if self.flight.speed_target_mps() < least_mps {
            self.flight.set_speed(least_mps, f64::INFINITY);
        }
        self.flight.take_off(self.flight.state().altitude_m + self.flight.altitude_error_m());
    }

    /// The course that leads onto the line through a place in the direction of a velocity.
    fn course_onto_line(&self, (x_m, y_m): (f64, f64), (north, east): (f64, f64)) -> f64 {
        /// Time over which the distance from the line is made up: slow against the course loop.
        const APPROACH_S: f64 = 4.0;
        let state = self.flight.state();
        let course_rad = libm::atan2(east, north);
        let (sin, cos) = libm::sincos(course_rad);
        let right_m = (state.y_m - y_m) * cos - (state.x_m - x_m) * sin;
        course_rad - libm::atan(right_m / (APPROACH_S * state.speed_mps.max(1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn local(mask: u16) -> PositionTarget {
        let data = SET_POSITION_TARGET_LOCAL_NED_DATA {
            x: 1.0,
            y: 2.0,
            z: -3.0,
            vx: 4.0,
            vy: 5.0,
            vz: -6.0,
            type_mask: Mask::from_bits_retain(mask),
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        };
        PositionTarget::from_local(&data, 0.0).unwrap()
    }

    #[test]
    fn masks_are_complete_or_not_as_px4_has_them() {
        for (mask, is_complete) in [
            (0xDC7, true),
            (0xDE3, true),
            (0x9C7, true),
            (0x5C7, true),
            (0xDC0, true),
            (0xDE0, true),
            (0xDF8, true),
            (0xC07, true),
            (0x000, true),
            (0xDE7, false),
            (0xDDF, false),
            (0xDCF, false),
            (0xDFC, false),
            (0xC3F, false),
            (0xFFF, false),
        ] {
            assert_eq!(local(mask).is_complete(), is_complete, "{mask:#x}");
            assert_eq!(local(mask).asks_for_anything, mask != 0xFFF);
        }
        let whole = local(0);
        assert_eq!((whole.place, whole.altitude_m), (Some((1.0, 2.0)), Some(3.0)));
        assert_eq!((whole.velocity_mps, whole.climb_mps), (Some((4.0, 5.0)), Some(6.0)));
    }

    #[test]
    fn a_body_velocity_is_turned_and_what_is_no_number_is_not_asked_for() {
        let data = SET_POSITION_TARGET_LOCAL_NED_DATA {
            vx: 3.0,
            type_mask: Mask::from_bits_retain(0xDC7),
            coordinate_frame: MavFrame::MAV_FRAME_BODY_NED,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        };
        let target = PositionTarget::from_local(&data, std::f64::consts::FRAC_PI_2).unwrap();
        let (north, east) = target.velocity_mps.unwrap();
        assert!(north.abs() < 1e-9 && (east - 3.0).abs() < 1e-9);
        let nan = SET_POSITION_TARGET_LOCAL_NED_DATA { vx: f32::NAN, ..data };
        assert!(!PositionTarget::from_local(&nan, 0.0).unwrap().is_complete());
        let odd = SET_POSITION_TARGET_LOCAL_NED_DATA { coordinate_frame: MavFrame::MAV_FRAME_LOCAL_FRD, ..nan };
        assert_eq!(PositionTarget::from_local(&odd, 0.0), Err("coordinate frame 20 unsupported".into()));
    }
}
