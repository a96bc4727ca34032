//! What the scenario asks and the model assumes, against what the vehicles' own parameters allow.

use crate::station::vehicle::narrow;
use controller::Expected;
use flight_model::Limits;
use mavlink_bridge::kind::VehicleLimits;

/// What the comparison came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compared {
    /// What cannot be flown.
    pub faults: Vec<String>,
    /// What was changed, or is not known.
    pub notes: Vec<String>,
}

/// Compares with the limits of vehicles, by their numbers, and narrows the flock's limits to what every vehicle allows,
/// so that the look-ahead plans no turn and no climb that a vehicle cannot fly.
pub fn compare(
    expected: &Expected,
    limits: &mut Limits,
    vehicles: impl IntoIterator<Item = (u32, VehicleLimits)>,
) -> Compared {
    let mut compared = Compared::default();
    let asked = *limits;
    for (number, own) in vehicles {
        let speed_mps = expected.speed_mps;
        match (own.speed_min_mps, own.speed_max_mps) {
            (Some(least), _) if speed_mps < least => compared.faults.push(format!(
                "vehicle {number} cannot fly the expected speed of {speed_mps} m/s: its least is {least} m/s"
            )),
            (_, Some(greatest)) if speed_mps > greatest => compared.faults.push(format!(
                "vehicle {number} cannot fly the expected speed of {speed_mps} m/s: its greatest is {greatest} m/s"
            )),
            (None, None) => compared.notes.push(format!("vehicle {number}: its limits are not known")),
            _ => {}
        }
        narrow(limits, &own, speed_mps);
    }
    for (name, before, after) in [
        ("least speed", asked.speed_min_mps, limits.speed_min_mps),
        ("greatest speed", asked.speed_max_mps, limits.speed_max_mps),
        ("lateral overload", asked.lateral_overload_max, limits.lateral_overload_max),
        ("greatest climb", asked.climb_max_mps, limits.climb_max_mps),
        ("greatest descent", asked.climb_min_mps, limits.climb_min_mps),
    ] {
        if before != after {
            compared
                .notes
                .push(format!("the model's {name} is {after:.2} instead of {before:.2}: the vehicles allow no more"));
        }
    }
    compared
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(bank_deg: f64) -> (u32, VehicleLimits) {
        let own = VehicleLimits {
            speed_min_mps: Some(10.0),
            speed_max_mps: Some(30.0),
            bank_max_rad: Some(f64::to_radians(bank_deg)),
            climb_max_mps: Some(5.0),
            sink_max_mps: Some(5.0),
            ..VehicleLimits::default()
        };
        (1, own)
    }

    #[test]
    fn a_speed_outside_is_a_fault_before_anybody_is_armed() {
        for (speed_mps, word) in [(9.0, "least is 10"), (31.0, "greatest is 30")] {
            let expected = Expected { speed_mps, course_rad: 0.0, altitude_m: 50.0 };
            let compared = compare(&expected, &mut Limits::default(), [plane(65.0)]);
            assert!(compared.faults.len() == 1 && compared.faults[0].contains(word), "{compared:?}");
        }
    }

    #[test]
    fn the_model_turns_no_harder_than_the_vehicle() {
        let expected = Expected { speed_mps: 12.0, course_rad: 0.0, altitude_m: 50.0 };
        let mut limits = Limits::default();
        let compared = compare(&expected, &mut limits, [plane(35.0)]);
        assert!(compared.faults.is_empty());
        assert!((limits.lateral_acceleration_max_mps2() - 9.81 * 0.7002).abs() < 0.01);
        assert_eq!((limits.speed_min_mps, limits.speed_max_mps, limits.climb_max_mps), (10.0, 15.0, 5.0));
        assert!(compared.notes.iter().any(|note| note.contains("lateral overload")));
    }
}
