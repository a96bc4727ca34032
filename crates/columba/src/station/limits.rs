//! What the scenario asks and the model assumes, against what the vehicles' own parameters allow.

use super::vehicle::Vehicle;
use controller::Expected;
use flight_model::Limits;
use mavlink_bridge::kind::VehicleLimits;

/// Gravity, m/s2: how a bank is an acceleration.
const GRAVITY_MPS2: f64 = 9.81;

/// What the comparison came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compared {
    /// What cannot be flown.
    pub faults: Vec<String>,
    /// What was changed, or is not known.
    pub notes: Vec<String>,
}

/// Compares, and narrows the flock's limits to what every vehicle allows, so that the look-ahead plans no turn and no
/// climb that a vehicle cannot fly.
pub fn compare(expected: &Expected, limits: &mut Limits, vehicles: &[Vehicle]) -> Compared {
    let mut compared = Compared::default();
    let asked = *limits;
    for vehicle in vehicles.iter().filter(|vehicle| vehicle.slot.is_some()) {
        let number = vehicle.slot.unwrap_or(0) + 1;
        let Some(own) = vehicle.limits else { continue };
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

/// Narrows limits to those that a vehicle's own parameters set; the expected speed stays within them.
pub fn narrow(limits: &mut Limits, own: &VehicleLimits, speed_mps: f64) {
    if let Some(least) = own.speed_min_mps {
        limits.speed_min_mps = limits.speed_min_mps.max(least.min(speed_mps));
    }
    if let Some(greatest) = own.speed_max_mps {
        limits.speed_max_mps = limits.speed_max_mps.min(greatest.max(speed_mps));
    }
    if let Some(bank_rad) = own.bank_max_rad.filter(|bank_rad| (0.01..1.55).contains(bank_rad)) {
        let overload = GRAVITY_MPS2 * libm::tan(bank_rad) / limits.gravity_mps2;
        limits.lateral_overload_max = limits.lateral_overload_max.min(overload);
    }
    if let Some(climb_mps) = own.climb_max_mps.filter(|climb_mps| *climb_mps > 0.1) {
        limits.climb_max_mps = limits.climb_max_mps.min(climb_mps);
    }
    if let Some(sink_mps) = own.sink_max_mps.filter(|sink_mps| *sink_mps > 0.1) {
        limits.climb_min_mps = limits.climb_min_mps.max(-sink_mps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(bank_deg: f64) -> Vehicle {
        let mut vehicle = Vehicle::new(1, 1);
        vehicle.slot = Some(0);
        vehicle.limits = Some(VehicleLimits {
            speed_min_mps: Some(10.0),
            speed_max_mps: Some(30.0),
            bank_max_rad: Some(f64::to_radians(bank_deg)),
            climb_max_mps: Some(5.0),
            sink_max_mps: Some(5.0),
            ..VehicleLimits::default()
        });
        vehicle
    }

    #[test]
    fn a_speed_outside_is_a_fault_before_anybody_is_armed() {
        for (speed_mps, word) in [(9.0, "least is 10"), (31.0, "greatest is 30")] {
            let expected = Expected { speed_mps, course_rad: 0.0, altitude_m: 50.0 };
            let compared = compare(&expected, &mut Limits::default(), &[plane(65.0)]);
            assert!(compared.faults.len() == 1 && compared.faults[0].contains(word), "{compared:?}");
        }
    }

    #[test]
    fn the_model_turns_no_harder_than_the_vehicle() {
        let expected = Expected { speed_mps: 12.0, course_rad: 0.0, altitude_m: 50.0 };
        let mut limits = Limits::default();
        let compared = compare(&expected, &mut limits, &[plane(35.0)]);
        assert!(compared.faults.is_empty());
        assert!((limits.lateral_acceleration_max_mps2() - 9.81 * 0.7002).abs() < 0.01);
        assert_eq!((limits.speed_min_mps, limits.speed_max_mps, limits.climb_max_mps), (10.0, 15.0, 5.0));
        assert!(compared.notes.iter().any(|note| note.contains("lateral overload")));
    }
}
