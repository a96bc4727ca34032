//! Which messages an ArduPlane sends at a rate and when it is asked (`mavlink_id_to_ap_message_id` of GCS_Common.cpp).

use super::super::rules::Offer;
use crate::telemetry::streams::Stream;

/// What has nothing to say where there is no such device, or nothing that has happened: its rate can be set, it is
/// accepted when asked for, and nothing comes.
const WITHOUT_CONTENT: [(u16, &str); 30] = [
    (22, "list of parameters under way"),
    (100, "optical flow sensor"),
    (124, "second GPS"),
    (127, "RTK GPS"),
    (128, "second GPS"),
    (132, "distance sensor"),
    (133, "terrain to ask for"),
    (143, "third barometer"),
    (173, "rangefinder"),
    (180, "camera"),
    (191, "compass calibration under way"),
    (194, "controller to tune"),
    (195, "deepstall landing"),
    (225, "fuel injection"),
    (226, "speed sensor of an engine"),
    (246, "aircraft received"),
    (259, "camera"),
    (260, "camera"),
    (262, "camera"),
    (269, "video stream"),
    (271, "camera"),
    (277, "thermal camera"),
    (280, "gimbal"),
    (281, "gimbal"),
    (285, "gimbal"),
    (301, "vessel received"),
    (373, "generator"),
    // Asked for once they are sent, one after the other.
    (435, "list of modes under way"),
    (9005, "winch"),
    (10_008, "transponder"),
];

/// Messages of other autopilots.
const UNKNOWN: [u16; 12] = [4, 69, 93, 111, 115, 230, 261, 375, 436, 12_900, 12_901, 12_904];

/// A message as an ArduPlane offers it.
pub(in crate::firmware) fn offer(message_id: u32) -> Offer {
    if let Some((_, what)) = WITHOUT_CONTENT.iter().find(|(id, _)| u32::from(*id) == message_id) {
        return Offer::Silent(what);
    }
    let is_known = !UNKNOWN.iter().any(|id| u32::from(*id) == message_id);
    Stream::from_message_id(message_id).filter(|_| is_known).map_or(Offer::None, Offer::Sent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_fit_a_statustext() {
        assert!(WITHOUT_CONTENT.windows(2).all(|pair| pair[0].0 < pair[1].0));
        for (id, what) in WITHOUT_CONTENT {
            assert_eq!(offer(u32::from(id)), Offer::Silent(what));
            assert!(format!("There is no {what}").len() <= 50);
        }
    }
}
