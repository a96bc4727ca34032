use super::items::{LAND, TAKEOFF, WAYPOINT};
use crate::autopilot::plan::PlanKind;
use crate::firmware::Personality;
use crate::mode::Mode;
use crate::settings::VehicleSettings;
use crate::vehicle::Vehicle;
use flight_model::State;
use mavlink_bridge::PlanItem;
use proptest::prelude::*;
use std::time::Duration;

type Place = (f64, f64);

fn settings(on_ground: bool, speed_mps: f64) -> VehicleSettings {
    let start = State { altitude_m: 50.0, speed_mps, ..State::default() };
    VehicleSettings { start, on_ground, ground: None, ..VehicleSettings::default() }
}

fn item(vehicle: &Vehicle, command: u16, (x_m, y_m): Place, z_m: f32, radius_m: f32) -> PlanItem {
    let place = vehicle.settings().frame.to_geodetic(x_m, y_m, 0.0);
    PlanItem {
        params: [0.0, radius_m, 0.0, 0.0],
        latitude_e7: (place.latitude_deg * 1e7).round() as i32,
        longitude_e7: (place.longitude_deg * 1e7).round() as i32,
        z_m,
        command,
        frame: 6,
        autocontinue: 1,
    }
}

/// Flies a mission until it is complete; where the vehicle was while each item was the current one, five times a second
/// as a ground station sees it.
fn fly(vehicle: &mut Vehicle, items: Vec<PlanItem>, patience_s: u64) -> Vec<Vec<Place>> {
    let count = items.len();
    vehicle.autopilot_mut().replace_plan(PlanKind::Mission, items, true).unwrap();
    vehicle.autopilot_mut().set_mode(Mode::Auto);
    let mut seen = vec![Vec::new(); count];
    for tick in 1..=5 * patience_s {
        if let Some(places) = seen.get_mut(usize::from(vehicle.autopilot().session.progress.current())) {
            places.push((vehicle.state().x_m, vehicle.state().y_m));
        }
        if vehicle.autopilot().session.progress.is_complete() {
            return seen;
        }
        vehicle.advance(Duration::from_millis(200 * tick), &mut Vec::new());
    }
    panic!("item {} is not reached", vehicle.autopilot().session.progress.current());
}

fn nearest_m(places: &[Place], at: Place) -> f64 {
    places.iter().map(|place| libm::hypot(place.0 - at.0, place.1 - at.1)).fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]
    #[test]
    fn every_waypoint_is_passed_within_its_radius(
        waypoints in prop::collection::vec(((-1.0..1.0f64, -1.0..1.0f64), 3.0..30.0f32), 10),
        half_width_m in 5.0..400.0f64, speed_mps in 5.0..15.0f64, wind_mps in prop::sample::select(vec![0.0f32, 3.0]),
    ) {
        let mut vehicle = Vehicle::new(VehicleSettings {
            default_parameters: vec![("SIM_WIND_SPD".into(), wind_mps)],
            ..settings(false, speed_mps)
        }).unwrap();
        let places: Vec<Place> =
            waypoints.iter().map(|((x, y), _)| (x * half_width_m, y * half_width_m)).collect();
        let mut items = vec![PlanItem::default()];
        let waypoint = |(at, (_, radius_m)): (&Place, &(_, f32))| item(&vehicle, WAYPOINT, *at, 50.0, *radius_m);
        items.extend(places.iter().zip(&waypoints).map(waypoint));
        let seen = fly(&mut vehicle, items, 2_000);
        // Where two are near each other, an item may begin and end between two looks.
        let track = seen.concat();
        for (at, (_, radius_m)) in places.iter().zip(&waypoints) {
            let leg = &track;
            prop_assert!(nearest_m(leg, *at) <= f64::from(*radius_m), "{} > {radius_m}", nearest_m(leg, *at));
        }
    }

    #[test]
    fn a_mission_from_the_ground_ends_where_it_lands(
        x in -300.0..300.0f64, y in -300.0..300.0f64, altitude_m in 20.0..100.0f32, speed_mps in 8.0..15.0f64,
    ) {
        let mut vehicle = Vehicle::new(settings(true, speed_mps)).unwrap();
        let items = vec![
            PlanItem::default(),
            item(&vehicle, TAKEOFF, (0.0, 0.0), altitude_m, 0.0),
            item(&vehicle, WAYPOINT, (x, y), altitude_m, 10.0),
            item(&vehicle, LAND, (0.0, 0.0), 0.0, 0.0),
        ];
        prop_assert!(vehicle.autopilot_mut().arm_or_disarm([1.0, 0.0]).is_ok());
        fly(&mut vehicle, items, 1_000);
        prop_assert!(libm::hypot(vehicle.state().x_m, vehicle.state().y_m) < 20.0);
        let landed = vehicle.time();
        vehicle.advance(landed + Duration::from_secs(40), &mut Vec::new());
        prop_assert_eq!((vehicle.is_armed(), vehicle.state().altitude_m, vehicle.state().speed_mps), (false, 0.0, 0.0));
    }
}

#[test]
fn a_waypoint_that_is_missed_is_passed_by_an_arduplane_and_flown_to_again_by_others() {
    let legs = |personality: Personality| {
        // No radius of their own: that of the parameter counts.
        let default_parameters = vec![("WP_RADIUS".into(), 1.0)];
        let settings = VehicleSettings { personality, default_parameters, ..settings(false, 15.0) };
        let mut vehicle = Vehicle::new(settings).unwrap();
        // The second is nearer beside the first than the vehicle can turn.
        let places = [(100.0, 0.0), (100.0, 3.0), (300.0, 100.0)];
        let first = if personality == Personality::ArduPlane { vec![PlanItem::default()] } else { Vec::new() };
        let waypoints = places.map(|at| item(&vehicle, WAYPOINT, at, 50.0, 0.0));
        let seen = fly(&mut vehicle, first.into_iter().chain(waypoints).collect(), 300);
        let second = seen.iter().rev().nth(1).map_or(0, Vec::len);
        (second as f64 / 5.0, nearest_m(&seen.concat(), places[1]))
    };
    let (passed_s, missed_m) = legs(Personality::ArduPlane);
    let (reached_s, nearest_m) = legs(Personality::Generic);
    assert!(missed_m > 1.0 && passed_s < 3.0, "{missed_m} m, {passed_s} s");
    assert!(nearest_m <= 1.5 && reached_s > passed_s, "{nearest_m} m, {reached_s} s");
}
