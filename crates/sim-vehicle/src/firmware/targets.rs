//! Position targets: SET_POSITION_TARGET_LOCAL_NED and SET_POSITION_TARGET_GLOBAL_INT, and how a fixed wing flies them.

// Clients still send the older numbers of the frames.
#![allow(deprecated)]

use crate::autopilot::Autopilot;
use flight_model::wrap_pi;
use mavlink_bridge::LatLonE7;
use mavlink_bridge::dialect::{
    MavFrame, PositionTargetTypemask as Mask, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use nalgebra::Vector2;

/// What a message asks for; what its mask leaves out is none, and so is what is no finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PositionTarget {
    pub mask: u16,
    /// (North, east) of the origin, m.
    pub place: Option<Vector2<f64>>,
    /// Above the origin, m.
    pub altitude_m: Option<f64>,
    /// (North, east), m/s.
    pub velocity_mps: Option<Vector2<f64>>,
    pub climb_mps: Option<f64>,
    /// Whether it asks for a position, a velocity or an acceleration at all, be it for half of one.
    pub asks_for_anything: bool,
}

/// Why a message is not followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum TargetError {
    #[error("coordinate frame {0} unsupported")]
    Frame(u32),
    #[error("no such place")]
    Place,
}

impl PositionTarget {
    /// In MAV_FRAME_LOCAL_NED, or velocities in MAV_FRAME_BODY_NED of a vehicle that heads `heading_rad`.
    pub fn from_local(data: &SET_POSITION_TARGET_LOCAL_NED_DATA, heading_rad: f64) -> Result<Self, TargetError> {
        let fields = [data.x, data.y, data.z, data.vx, data.vy, data.vz, data.afx, data.afy, data.afz];
        let target = Self::read(data.type_mask, fields.map(f64::from));
        match data.coordinate_frame {
            MavFrame::MAV_FRAME_LOCAL_NED => Ok(target),
            MavFrame::MAV_FRAME_BODY_NED => {
                let (sin, cos) = libm::sincos(heading_rad);
                let turn = |body: Vector2<f64>| Vector2::new(cos * body.x - sin * body.y, sin * body.x + cos * body.y);
                let velocity_mps = target.velocity_mps.map(turn);
                Ok(Self { place: None, altitude_m: None, velocity_mps, ..target })
            }
            other => Err(TargetError::Frame(other as u32)),
        }
    }

    /// Its place and altitude as `to_local` and `altitude_m` have those of the message.
    pub fn from_global(
        data: &SET_POSITION_TARGET_GLOBAL_INT_DATA,
        to_local: impl Fn(LatLonE7) -> Vector2<f64>,
        altitude_m: impl Fn(f32, u8) -> Option<f64>,
    ) -> Result<Self, TargetError> {
        let position = LatLonE7::new(data.lat_int, data.lon_int);
        let place = to_local(position);
        // A velocity needs no frame.
        let up_m = match altitude_m(data.alt, data.coordinate_frame as u8) {
            Some(up_m) => up_m,
            None if data.type_mask.contains(PLACE | Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE) => f64::NAN,
            None => return Err(TargetError::Frame(data.coordinate_frame as u32)),
        };
        let [vx, vy, vz, ax, ay, az] = [data.vx, data.vy, data.vz, data.afx, data.afy, data.afz].map(f64::from);
        let target = Self::read(data.type_mask, [place.x, place.y, -up_m, vx, vy, vz, ax, ay, az]);
        if target.place.is_some() && !position.is_valid() {
            return Err(TargetError::Place);
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
            place: x.zip(y).map(|(x, y)| Vector2::new(x, y)),
            // Zero must not become minus zero.
            altitude_m: z.map(|down_m| 0.0 - down_m),
            velocity_mps: vx.zip(vy).map(|(vx, vy)| Vector2::new(vx, vy)),
            climb_mps: vz.map(|down_mps| 0.0 - down_mps),
            asks_for_anything: others.iter().chain(&accelerations).any(Option::is_some),
        }
    }
}

const PLACE: Mask = Mask::POSITION_TARGET_TYPEMASK_X_IGNORE.union(Mask::POSITION_TARGET_TYPEMASK_Y_IGNORE);

/// Flies a target: a place, along a line through a place in the direction of the velocity, or with a velocity; at an
/// altitude or with a rate of climb. What it does not ask for stays as it is. From the ground, armed, it takes off
/// where the target is higher.
pub(super) fn fly_target(autopilot: &mut Autopilot, target: &PositionTarget) {
    // A velocity of zero has no direction.
    let velocity_mps = target.velocity_mps.filter(|velocity| *velocity != Vector2::zeros());
    match (target.place, velocity_mps) {
        (Some(place), Some(velocity)) => {
            autopilot.flight.set_course(course_onto_line(autopilot, place, velocity), f64::INFINITY)
        }
        (Some(place), None) => autopilot.flight.fly_to(place),
        (None, Some(to)) => autopilot.flight.set_course(wrap_pi(libm::atan2(to.y, to.x)), f64::INFINITY),
        (None, None) => {}
    }
    if let Some(velocity_mps) = velocity_mps {
        autopilot.flight.set_speed_as_led(velocity_mps.norm());
    }
    match (target.altitude_m, target.climb_mps) {
        (Some(altitude_m), _) => autopilot.flight.set_altitude(altitude_m, f64::INFINITY),
        (None, Some(climb_mps)) => autopilot.flight.climb_at(climb_mps),
        (None, None) => {}
    }
    if autopilot.flight.is_on_ground() && autopilot.flight.is_armed() && leads_up(autopilot, target) {
        take_off_for_target(autopilot);
    }
}

fn leads_up(autopilot: &Autopilot, target: &PositionTarget) -> bool {
    /// How much higher than the ground a place must be.
    const HIGHER_M: f64 = 1.0;
    match (target.altitude_m, target.climb_mps) {
        (Some(altitude_m), _) => altitude_m > autopilot.flight.state().altitude_m + HIGHER_M,
        (None, climb_mps) => climb_mps.is_some_and(|climb_mps| climb_mps > 0.0),
    }
}

/// Runs and lifts off, straight on, as fast as it must; the next target leads it in the air.
fn take_off_for_target(autopilot: &mut Autopilot) {
    let least_mps = autopilot.flight.limits().speed_min_mps;
    if autopilot.flight.speed_target_mps() < least_mps {
        autopilot.flight.set_speed(least_mps, f64::INFINITY);
    }
    autopilot.flight.take_off(autopilot.flight.state().altitude_m + autopilot.flight.altitude_error_m());
}

/// The course that leads onto the line through a place in the direction of a velocity.
fn course_onto_line(autopilot: &Autopilot, place: Vector2<f64>, velocity: Vector2<f64>) -> f64 {
    /// Time over which the distance from the line is made up: slow against the course loop.
    const APPROACH_S: f64 = 4.0;
    let state = autopilot.flight.state();
    let course_rad = libm::atan2(velocity.y, velocity.x);
    let (sin, cos) = libm::sincos(course_rad);
    let off = state.position_m() - place;
    let right_m = off.y * cos - off.x * sin;
    course_rad - libm::atan(right_m / (APPROACH_S * state.speed_mps.max(1.0)))
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
        assert_eq!((whole.place, whole.altitude_m), (Some(Vector2::new(1.0, 2.0)), Some(3.0)));
        assert_eq!((whole.velocity_mps, whole.climb_mps), (Some(Vector2::new(4.0, 5.0)), Some(6.0)));
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
        let velocity = target.velocity_mps.unwrap();
        assert!((velocity - Vector2::new(0.0, 3.0)).amax() < 1e-9);
        let nan = SET_POSITION_TARGET_LOCAL_NED_DATA { vx: f32::NAN, ..data };
        assert!(!PositionTarget::from_local(&nan, 0.0).unwrap().is_complete());
        let odd = SET_POSITION_TARGET_LOCAL_NED_DATA { coordinate_frame: MavFrame::MAV_FRAME_LOCAL_FRD, ..nan };
        assert_eq!(PositionTarget::from_local(&odd, 0.0), Err(TargetError::Frame(20)));
    }
}
