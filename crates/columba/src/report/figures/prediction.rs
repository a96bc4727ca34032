//! Predicted against flown.

use super::{LINES_MAX, NONE, VehicleLine, over_time};
use crate::flight::{Flight, vehicle_number};
use crate::prediction::{HORIZON_S, errors_m, rms};
use std::fmt::Write;

/// How far vehicles were from where the model had them three seconds before.
pub fn prediction(flight: &Flight) -> String {
    let lines: Vec<VehicleLine> = lines(flight);
    over_time(flight, "prediction", "error 3 s ahead (m)", (0.0, NONE), 1.0, &lines)
}

/// What the figure shows, with the root mean squares of the vehicles.
pub fn caption(flight: &Flight) -> String {
    let mut caption = format!(
        "Distance at each tick from where the model that the controller reckons with (Eq. 1, with gain and dead times) \
         has a vehicle, from its state {HORIZON_S:.0} s before and the setpoints since then."
    );
    if flight.dynamics.is_empty() {
        caption += " This record does not say which model was flown by.";
        return caption;
    }
    let lines = lines(flight);
    if let Some(all) = rms(&lines.concat()) {
        let _ = write!(caption, " Root mean square {all:.2} m");
        let of = |(vehicle, line): (usize, &VehicleLine)| {
            rms(line).map(|rms| format!("UAV {}: {rms:.2} m", vehicle_number(vehicle)))
        };
        let each: Vec<String> = lines.iter().enumerate().filter_map(of).collect();
        if each.len() > 1 && each.len() <= LINES_MAX {
            let _ = write!(caption, " ({})", each.join(", "));
        }
        caption.push('.');
    }
    caption
}

fn lines(flight: &Flight) -> Vec<VehicleLine> {
    (0..flight.trajectory.vehicles).map(|vehicle| errors_m(flight, vehicle)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn the_caption_says_how_good_the_model_was() {
        let mut flight = sample::flight(2, 0, 20);
        assert!(caption(&flight).contains("does not say"));
        flight.dynamics = vec![flight_model::Dynamics::default()];
        let words = caption(&flight);
        assert!(words.contains("Root mean square") && words.contains("UAV 2: "), "{words}");
        let svg = prediction(&flight);
        assert!(
            svg.contains(">none</text>") && !svg.contains(">expected</text>"),
            "no error is expected: none is meant"
        );
    }
}
