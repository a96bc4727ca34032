//! Messages of ArduPilot's own dialect (<https://mavlink.io/en/messages/ardupilotmega.html>) that its clients wait for
//! and the common dialect does not have. They are written from their fields, in the order of the wire, and are read
//! only as frames.

use crate::{Encoder, telemetry::down};
use flight_model::Wind;

/// The longest of them, bytes.
const PAYLOAD_MAX: usize = 26;

const WIND: u32 = 168;
const EKF_STATUS_REPORT: u32 = 193;

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

impl ArduPilotMessage {
    fn new(id: u32, length: usize, bytes: impl Iterator<Item = u8>) -> Self {
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

    fn hex(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    const WIND_2: &str = "fd080000000101a800000000b4c20000c04047b3";
    const WIND_1: &str = "fe0c000101a80000b4c20000c040000000007b7d";
    const EKF_2: &str = "fd160000000101c1000000000000000000000000000000000000000000003f031e87";
}
