//! What an autopilot makes of a message that somebody asks for, by its number.

use super::rules::{CommandSet, Offer};
use super::{arduplane, px4};
use crate::autopilot::Autopilot;
use crate::telemetry::streams::Stream;

impl CommandSet {
    /// What an autopilot makes of a message.
    pub fn offer(self, message_id: u32) -> Offer {
        match self {
            CommandSet::ArduPlane => arduplane::messages::offer(message_id),
            CommandSet::Px4 => px4::messages::offer(message_id),
            CommandSet::Generic => Stream::from_message_id(message_id).map_or(Offer::None, Offer::Sent),
        }
    }
}

/// Whether a PX4 sends a message that is due.
pub(crate) fn px4_streams(autopilot: &Autopilot, stream: Stream) -> bool {
    px4::messages::streams(autopilot, stream)
}

/// Whether a PX4 has something to say in a message that is asked for.
pub(crate) fn px4_has(autopilot: &Autopilot, stream: Stream) -> bool {
    px4::messages::has(autopilot, stream)
}
