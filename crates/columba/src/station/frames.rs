//! One frame for all: the scenario's, in which every vehicle's position is told, with altitudes above mean sea level.

use super::number;
use super::vehicle::Vehicle;
use flight_model::{Geodetic, LocalFrame};

/// Vehicles further than this from the origin are not where the scenario is: the local frame would not fit them, m.
const FAR_M: f64 = 20_000.0;
/// A vehicle's own positions may differ by this, m.
const CONTRADICTION_M: f64 = 5.0;
/// The flock flies at least so high above every home, m.
const HEIGHT_MIN_M: f64 = 5.0;

/// Where the scenario's frame is put.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Origin {
    /// Where the scenario has it; at the first vehicle's home if the scenario names none and the vehicles are far away.
    #[default]
    Scenario,
    /// At the first vehicle's home.
    Home,
    /// Here.
    Given(Geodetic),
}

impl std::str::FromStr for Origin {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "must be home, or LATITUDE,LONGITUDE,ALTITUDE in degrees and m above mean sea level";
        match text {
            "home" => return Ok(Self::Home),
            "scenario" => return Ok(Self::Scenario),
            _ => {}
        }
        let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
        match numbers[..] {
            [latitude_deg, longitude_deg, altitude_amsl_m]
                if text.split(',').count() == 3
                    && latitude_deg.abs() <= 85.0
                    && longitude_deg.abs() <= 180.0
                    && altitude_amsl_m.abs() <= 9_000.0 =>
            {
                Ok(Self::Given(Geodetic { latitude_deg, longitude_deg, altitude_amsl_m }))
            }
            _ => Err(wanted.to_owned()),
        }
    }
}

/// The frame of a flight, and what there is to say about it.
///
/// # Errors
/// When the vehicles are not where the frame is.
pub fn choose(
    scenario: &LocalFrame,
    is_named: bool,
    origin: Origin,
    vehicles: &[Vehicle],
) -> Result<(LocalFrame, Option<String>), String> {
    let home = |vehicle: &Vehicle| vehicle.heard().home.or_else(|| vehicle.heard().place());
    let first = vehicles.iter().find(|vehicle| vehicle.slot() == Some(0)).and_then(home);
    let at_home = || first.map(LocalFrame::new).ok_or("the first vehicle has no home yet".to_owned());
    let frame = match origin {
        Origin::Given(place) => LocalFrame::new(place),
        Origin::Home => at_home()?,
        Origin::Scenario => *scenario,
    };
    let far = |frame: &LocalFrame| {
        vehicles.iter().find_map(|vehicle| {
            let (x_m, y_m, _) = frame.to_local(&vehicle.heard().place()?);
            let distance_m = (x_m * x_m + y_m * y_m).sqrt();
            (distance_m > FAR_M).then_some((number(vehicle.slot()?), distance_m))
        })
    };
    let Some((number, distance_m)) = far(&frame) else {
        let note = (origin == Origin::Home)
            .then(|| format!("the origin is the home of vehicle 1: {}", words(&frame.origin())));
        return Ok((frame, note));
    };
    if origin == Origin::Scenario && !is_named {
        let frame = at_home()?;
        if far(&frame).is_none() {
            let note = format!("the scenario names no origin: it is the home of vehicle 1: {}", words(&frame.origin()));
            return Ok((frame, Some(note)));
        }
    }
    let there = first.map_or_else(String::new, |home| format!(", or --origin {}", words(&home)));
    Err(format!(
        "vehicle {number} is {:.0} km from the origin {}: the scenario must be where the vehicles are (--origin \
         home{there})",
        distance_m * 1e-3,
        words(&frame.origin())
    ))
}

/// What contradicts itself, in words; nothing if all agree.
pub fn contradictions(frame: &LocalFrame, expected_altitude_m: f64, vehicles: &[Vehicle]) -> Vec<String> {
    let mut faults = Vec::new();
    let expected_amsl_m = frame.origin().altitude_amsl_m + expected_altitude_m;
    for vehicle in vehicles {
        let Some(number) = vehicle.slot().map(number) else { continue };
        if vehicle.routes().is_doubled() {
            faults.push(format!(
                "two autopilots speak with system id {}: each must have its own (MAV_SYSID, SYSID_THISMAV, MAV_SYS_ID)",
                vehicle.id()
            ));
        }
        if let Some(off_m) = vehicle.heard().contradiction_m().filter(|off_m| *off_m > CONTRADICTION_M) {
            faults.push(format!(
                "vehicle {number} contradicts itself: its global and its local position, from its own origin, are \
                 {off_m:.0} m apart"
            ));
        }
        if let Some(home) = vehicle.heard().home
            && expected_amsl_m - home.altitude_amsl_m < HEIGHT_MIN_M
        {
            faults.push(format!(
                "vehicle {number}: the expected altitude of {expected_altitude_m:.0} m above the origin is \
                 {expected_amsl_m:.0} m above mean sea level, and its home is at {:.0} m: the origin's altitude must \
                 fit",
                home.altitude_amsl_m
            ));
        }
    }
    faults
}

fn words(place: &Geodetic) -> String {
    format!("{:.7},{:.7},{:.1}", place.latitude_deg, place.longitude_deg, place.altitude_amsl_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::{GLOBAL_POSITION_INT_DATA, HOME_POSITION_DATA, Message};
    use std::time::Duration;

    const CANBERRA: Geodetic = Geodetic { latitude_deg: -35.363262, longitude_deg: 149.165237, altitude_amsl_m: 584.0 };
    const BEIJING: Geodetic = Geodetic { latitude_deg: 39.98, longitude_deg: 116.34, altitude_amsl_m: 50.0 };

    fn vehicle(slot: usize, place: Geodetic, frame: &LocalFrame) -> Vehicle {
        let mut vehicle = Vehicle::new(slot as u8 + 1, 1);
        vehicle.take_slot(Some(slot));
        let home = HOME_POSITION_DATA {
            latitude: (place.latitude_deg * 1e7).round() as i32,
            longitude: (place.longitude_deg * 1e7).round() as i32,
            altitude: (place.altitude_amsl_m * 1e3) as i32,
            ..HOME_POSITION_DATA::DEFAULT
        };
        vehicle.hear(&Message::HOME_POSITION(home), Duration::from_secs(1), frame);
        let data = GLOBAL_POSITION_INT_DATA {
            time_boot_ms: 1000,
            lat: (place.latitude_deg * 1e7).round() as i32,
            lon: (place.longitude_deg * 1e7).round() as i32,
            alt: (place.altitude_amsl_m * 1e3) as i32,
            ..GLOBAL_POSITION_INT_DATA::DEFAULT
        };
        vehicle.hear(&Message::GLOBAL_POSITION_INT(data), Duration::from_secs(1), frame);
        vehicle
    }

    #[test]
    fn homes_300_m_apart_are_told_300_m_apart() {
        let frame = LocalFrame::new(CANBERRA);
        let there = frame.to_geodetic(0.0, 300.0, 0.0);
        let vehicles = [vehicle(0, CANBERRA, &frame), vehicle(1, there, &frame)];
        let state = |vehicle: &Vehicle| vehicle.track().last().unwrap().state;
        let (a, b) = (state(&vehicles[0]), state(&vehicles[1]));
        assert!(((b.y_m - a.y_m) - 300.0).abs() < 0.02 && (b.x_m - a.x_m).abs() < 0.02);
        assert_eq!(choose(&frame, true, Origin::Scenario, &vehicles), Ok((frame, None)));
    }

    #[test]
    fn an_origin_elsewhere_is_an_error_and_one_that_is_not_named_is_the_home() {
        let scenario = LocalFrame::new(BEIJING);
        let vehicles = [vehicle(0, CANBERRA, &scenario)];
        let error = choose(&scenario, true, Origin::Scenario, &vehicles).unwrap_err();
        assert!(error.contains("vehicle 1") && error.contains("--origin home"), "{error}");
        let (frame, note) = choose(&scenario, false, Origin::Scenario, &vehicles).unwrap();
        assert_eq!(frame.origin(), CANBERRA);
        assert!(note.unwrap().contains("names no origin"));
        assert!(choose(&scenario, true, Origin::Home, &vehicles).is_ok());
    }

    #[test]
    fn an_altitude_below_a_home_is_a_contradiction() {
        let frame = LocalFrame::new(Geodetic { altitude_amsl_m: 50.0, ..CANBERRA });
        let faults = contradictions(&frame, 50.0, &[vehicle(0, CANBERRA, &frame)]);
        assert!(faults.len() == 1 && faults[0].contains("584"), "{faults:?}");
        assert!(contradictions(&LocalFrame::new(CANBERRA), 50.0, &[vehicle(0, CANBERRA, &frame)]).is_empty());
    }

    #[test]
    fn origins_are_read() {
        assert_eq!("home".parse(), Ok(Origin::Home));
        assert_eq!("-35.363262,149.165237,584".parse(), Ok(Origin::Given(CANBERRA)));
        for wrong in ["here", "1,2", "1,2,3,4", "91,0,0", "a,b,c"] {
            assert!(wrong.parse::<Origin>().is_err(), "{wrong}");
        }
    }
}
