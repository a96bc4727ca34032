//! What vehicles say in words (STATUSTEXT) that an operator must hear of.

use super::told::Weight;

/// How much a text about a failsafe weighs; none: the text is about something else. ArduPilot ends its texts with
/// `on`, `off` and `cleared`, PX4 says `activated`; both send the end of a failsafe at the same severity as the
/// beginning.
pub fn of_failsafe(text: &str) -> Option<Weight> {
    let text = text.to_lowercase();
    if !text.contains("failsafe") {
        return None;
    }
    let is_over = text.ends_with(" off") || text.ends_with(" cleared");
    Some(if is_over { Weight::Note } else { Weight::Warning })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_failsafe_is_no_warning() {
        for (text, weight) in [
            ("Throttle failsafe on", Some(Weight::Warning)),
            ("Throttle failsafe off", Some(Weight::Note)),
            ("GCS Failsafe On: switched to RTL", Some(Weight::Warning)),
            ("GCS Failsafe Cleared", Some(Weight::Note)),
            ("Radio Failsafe - Disarming", Some(Weight::Warning)),
            ("Failsafe activated", Some(Weight::Warning)),
            ("EKF Failsafe", Some(Weight::Warning)),
            ("Ground speed off", None),
        ] {
            assert_eq!(of_failsafe(text), weight, "{text}");
        }
    }
}
