//! What a PX4 tells the devices and programs beside it when they ask: a gimbal's state of the autopilot, and the state
//! that a simulator keeps.

use super::Instruments;
use mavlink_bridge::dialect::{
    AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, EstimatorStatusFlags, HIL_STATE_QUATERNION_DATA, Message,
};

/// Greatest numbers of the fields of 16 bits.
const I16: std::ops::RangeInclusive<f64> = -32_768.0..=32_767.0;

impl Instruments<'_> {
    /// [`AUTOPILOT_STATE_FOR_GIMBAL_DEVICE`][page], to all gimbals: where it thinks it is, m/s and rad.
    ///
    /// [page]: https://mavlink.io/en/messages/common.html#AUTOPILOT_STATE_FOR_GIMBAL_DEVICE
    pub(super) fn state_for_gimbal(&self) -> Message {
        let state = self.flight.estimate();
        let velocity_mps = state.velocity_mps();
        Message::AUTOPILOT_STATE_FOR_GIMBAL_DEVICE(AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
            time_boot_us: self.micros(),
            q: self.quaternion(),
            vx: velocity_mps.x as f32,
            vy: velocity_mps.y as f32,
            vz: (0.0 - state.climb_mps) as f32,
            estimator_status: EstimatorStatusFlags::from_bits_truncate(self.estimator_flags()),
            landed_state: self.landed_state(),
            angular_velocity_z: self.flight.turn_rate_radps() as f32,
            ..AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::DEFAULT
        })
    }

    /// HIL_STATE_QUATERNION (<https://mavlink.io/en/messages/common.html#HIL_STATE_QUATERNION>): where the simulation
    /// has it, in cm/s, mm and mg.
    pub(super) fn hil_state_quaternion(&self) -> Message {
        let (state, readings) = (self.flight.state(), self.readings());
        let velocity_mps = state.velocity_mps();
        let place = self.frame.to_geodetic(state.x_m, state.y_m, state.altitude_m);
        let [rollspeed, pitchspeed, yawspeed] = readings.rates_radps.map(|rate_radps| rate_radps as f32);
        let hundredths = |value: f64| (100.0 * value).round().clamp(*I16.start(), *I16.end()) as i16;
        let milli_g = |force_mps2: f64| (1000.0 * force_mps2 / self.gravity_mps2()).round();
        let [xacc, yacc, zacc] =
            readings.force_mps2.map(|force_mps2| milli_g(force_mps2).clamp(*I16.start(), *I16.end()) as i16);
        let in_cmps = |speed_mps: f64| (100.0 * speed_mps).round() as u16;
        Message::HIL_STATE_QUATERNION(HIL_STATE_QUATERNION_DATA {
            time_usec: self.micros(),
            attitude_quaternion: self.quaternion(),
            rollspeed,
            pitchspeed,
            yawspeed,
            lat: (1e7 * place.latitude_deg).round() as i32,
            lon: (1e7 * place.longitude_deg).round() as i32,
            alt: (1e3 * place.altitude_amsl_m).round() as i32,
            vx: hundredths(velocity_mps.x),
            vy: hundredths(velocity_mps.y),
            vz: hundredths(0.0 - state.climb_mps),
            ind_airspeed: in_cmps(self.flight.equivalent_airspeed_mps()),
            true_airspeed: in_cmps(self.flight.airspeed_mps()),
            xacc,
            yacc,
            zacc,
        })
    }
}
