//! Messages of ArduPilot's own dialect (<https://mavlink.io/en/messages/ardupilotmega.html>) that its clients wait for
//! and the common dialect does not have. They are written from their fields, in the order of the wire, and are read
//! only as frames.

use crate::{Encoder, telemetry::down};
use flight_model::Wind;
use std::time::Duration;

/// The longest of them, bytes.
const PAYLOAD_MAX: usize = 44;

const WIND: u32 = 168;
const EKF_STATUS_REPORT: u32 = 193;
const MEMINFO: u32 = 152;
const AHRS: u32 = 163;
const SIMSTATE: u32 = 164;
const HWSTATUS: u32 = 165;
const AHRS2: u32 = 178;
const AOA_SSA: u32 = 11_020;
const ESC_TELEMETRY_1_TO_4: u32 = 11_030;

/// A message, ready for [`Encoder::encode_ardupilot`].
#[derive(Clone, Debug, PartialEq)]
pub struct ArduPilotMessage {
    id: u32,
    /// Length in MAVLink 1, which has no extension fields.
    length: usize,
    payload: [u8; PAYLOAD_MAX],
}

/// WIND (<https://mavlink.io/en/messages/ardupilotmega.html#WIND>): where the wind comes from, in degrees from -180 to
/// 180 as ArduPlane gives it, and its speeds in m/s.
pub fn wind(wind: &Wind) -> ArduPilotMessage {
    let fields = [wind.direction_rad().to_degrees() as f32, wind.speed_mps() as f32, down(wind.up_mps)];
    ArduPilotMessage::new(WIND, 12, fields.into_iter().flat_map(f32::to_le_bytes))
}

/// EKF_STATUS_REPORT (<https://mavlink.io/en/messages/ardupilotmega.html#EKF_STATUS_REPORT>): the EKF_STATUS_FLAGS of
/// what the estimator knows, and no variances: it makes no errors.
pub fn ekf_status_report(flags: u16) -> ArduPilotMessage {
    ArduPilotMessage::new(EKF_STATUS_REPORT, 22, [0; 20].into_iter().chain(flags.to_le_bytes()))
}

/// MEMINFO (<https://mavlink.io/en/messages/ardupilotmega.html#MEMINFO>): more memory is free than the message can say.
pub fn meminfo() -> ArduPilotMessage {
    let free = u16::MAX.to_le_bytes();
    ArduPilotMessage::new(MEMINFO, 4, [0, 0].into_iter().chain(free).chain(u32::from(u16::MAX).to_le_bytes()))
}

/// AHRS (<https://mavlink.io/en/messages/ardupilotmega.html#AHRS>): no drifts and no errors.
pub fn ahrs() -> ArduPilotMessage {
    ArduPilotMessage::new(AHRS, 28, std::iter::empty())
}

/// AHRS2 (<https://mavlink.io/en/messages/ardupilotmega.html#AHRS2>): roll, pitch and yaw in rad, m above sea level,
/// latitude and longitude in 1e-7 degrees.
pub fn ahrs2(attitude_rad: [f64; 3], altitude_amsl_m: f64, place_e7: [i32; 2]) -> ArduPilotMessage {
    let [roll, pitch, yaw] = attitude_rad;
    ArduPilotMessage::new(AHRS2, 24, floats([roll, pitch, yaw, altitude_amsl_m]).chain(ints(place_e7)))
}

/// SIMSTATE (<https://mavlink.io/en/messages/ardupilotmega.html#SIMSTATE>): the truth of a simulation: roll, pitch and
/// yaw in rad, specific force in m/s2, rates in rad/s, latitude and longitude in 1e-7 degrees.
pub fn simstate(
    attitude_rad: [f64; 3],
    force_mps2: [f64; 3],
    rates_radps: [f64; 3],
    place_e7: [i32; 2],
) -> ArduPilotMessage {
    let fields = floats(attitude_rad).chain(floats(force_mps2)).chain(floats(rates_radps)).chain(ints(place_e7));
    ArduPilotMessage::new(SIMSTATE, 44, fields)
}

/// HWSTATUS (<https://mavlink.io/en/messages/ardupilotmega.html#HWSTATUS>): the supply of the board, mV, and no errors.
pub fn hwstatus(supply_mv: u16) -> ArduPilotMessage {
    ArduPilotMessage::new(HWSTATUS, 3, supply_mv.to_le_bytes().into_iter())
}

/// AOA_SSA (<https://mavlink.io/en/messages/ardupilotmega.html#AOA_SSA>): the angles of attack and of sideslip,
/// degrees.
pub fn aoa_ssa(time: Duration, angles_deg: [f64; 2]) -> ArduPilotMessage {
    let micros = u64::try_from(time.as_micros()).unwrap_or(u64::MAX).to_le_bytes();
    ArduPilotMessage::new(AOA_SSA, 16, micros.into_iter().chain(floats(angles_deg)))
}

/// ESC_TELEMETRY_1_TO_4 (<https://mavlink.io/en/messages/ardupilotmega.html#ESC_TELEMETRY_1_TO_4>): of the throttle's
/// output, the third, V, A and mAh. Nobody counts its turns.
pub fn esc_telemetry(voltage_v: f64, current_a: f64, consumed_mah: f64) -> ArduPilotMessage {
    let third = |value: f64| [0, 0, value.round() as u16, 0];
    let fields = [third(1e2 * voltage_v), third(1e2 * current_a), third(consumed_mah)];
    ArduPilotMessage::new(ESC_TELEMETRY_1_TO_4, 44, fields.into_iter().flatten().flat_map(u16::to_le_bytes))
}

fn floats<const N: usize>(values: [f64; N]) -> impl Iterator<Item = u8> {
    values.into_iter().flat_map(|value| (value as f32).to_le_bytes())
}

fn ints(values: [i32; 2]) -> impl Iterator<Item = u8> {
    values.into_iter().flat_map(i32::to_le_bytes)
}

impl ArduPilotMessage {
    pub(crate) fn new(id: u32, length: usize, bytes: impl Iterator<Item = u8>) -> Self {
        let mut payload = [0; PAYLOAD_MAX];
        payload.iter_mut().zip(bytes).for_each(|(field, byte)| *field = byte);
        Self { id, length, payload }
    }

    /// Its message id.
    pub fn message_id(&self) -> u32 {
        self.id
    }
}

impl Encoder {
    /// Appends a message of ArduPilot's dialect to `out` as one frame.
    pub fn encode_ardupilot(&mut self, message: &ArduPilotMessage, out: &mut Vec<u8>) {
        self.write_fields(message.id, &message.payload, message.length, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Version;

    // Made by pymavlink 2.4.50: MAVLink(None, srcSystem=1, srcComponent=1), wind_encode(-90, 6, 0), and the same in
    // MAVLink 1.
    #[test]
    fn wind_has_the_bytes_that_others_write() {
        let mut out = Vec::new();
        let west = Wind { north_mps: 0.0, east_mps: 6.0, up_mps: 0.0 };
        Encoder::new(1, 1).encode_ardupilot(&wind(&west), &mut out);
        assert_eq!(hex(&out), WIND_2);
        out.clear();
        Encoder::new(1, 1).with_version(Version::V1).encode_ardupilot(&wind(&west), &mut out);
        assert_eq!(hex(&out), WIND_1);
        out.clear();
        Encoder::new(1, 1).encode_ardupilot(&ekf_status_report(831), &mut out);
        assert_eq!(hex(&out), EKF_2);
    }

    #[test]
    fn the_others_have_the_bytes_that_pymavlink_writes() {
        let place = [399_800_000, -5];
        for (message, expected) in [
            (ahrs2([1.0, -2.0, 0.5], 80.0, place), AHRS2_2),
            (simstate([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], place), SIMSTATE_2),
            (hwstatus(5000), HWSTATUS_2),
            (aoa_ssa(Duration::from_millis(1500), [1.0, -1.0]), AOA_2),
            (meminfo(), MEMINFO_2),
            (ahrs(), AHRS_2),
            (esc_telemetry(12.6, 0.3, 5.0), ESC_2),
        ] {
            let mut out = Vec::new();
            Encoder::new(1, 1).encode_ardupilot(&message, &mut out);
            assert_eq!(hex(&out), expected);
        }
    }

    fn hex(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    const ESC_2: &str = "fd150000000101162b0000000000ec040000000000001e0000000000000005546e";
    const WIND_2: &str = "fd080000000101a800000000b4c20000c04047b3";
    const WIND_1: &str = "fe0c000101a80000b4c20000c040000000007b7d";
    const EKF_2: &str = "fd160000000101c1000000000000000000000000000000000000000000003f031e87";
    const AHRS2_2: &str = "fd180000000101b200000000803f000000c00000003f0000a042c076d417fbffffff9fbe";
    const SIMSTATE_2: &str = concat!(
        "fd2c0000000101a400000000803f0000004000004040000080400000a0400000c0400000e0400000",
        "004100001041c076d417fbffffff9e27"
    );
    const HWSTATUS_2: &str = "fd020000000101a5000088134e25";
    const AOA_2: &str = "fd1000000001010c2b0060e31600000000000000803f000080bf0796";
    const MEMINFO_2: &str = "fd0600000001019800000000ffffffff7a7a";
    const AHRS_2: &str = "fd010000000101a30000003c42";
}
