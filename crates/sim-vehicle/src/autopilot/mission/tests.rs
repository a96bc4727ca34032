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

/// A vehicle that flies north at 10 m/s over a place, and behind it to another, with commands on the way.
fn with_commands(commands: &[(u16, [f32; 4])]) -> Vehicle {
    let mut vehicle = Vehicle::new(settings(false, 10.0)).unwrap();
    let place = |x_m| item(&vehicle, WAYPOINT, (x_m, 0.0), 50.0, 5.0);
    let between =
        commands.iter().map(|(command, params)| PlanItem { command: *command, params: *params, ..place(0.0) });
    let items = [PlanItem::default(), place(50.0)].into_iter().chain(between).chain([place(1000.0), place(1500.0)]);
    let items = items.collect();
    vehicle.autopilot_mut().replace_plan(PlanKind::Mission, items, true).unwrap();
    vehicle.autopilot_mut().set_mode(Mode::Auto);
    vehicle
}

/// Where it was when it was first asked for another speed, m to the north; none on the way to the last place.
fn speeds_up_at_m(vehicle: &mut Vehicle, last: u16) -> Option<f64> {
    for tick in 1.. {
        vehicle.advance(Duration::from_millis(100 * tick), &mut Vec::new());
        if vehicle.autopilot().flight.speed_target_mps() == 12.0 {
            return Some(vehicle.state().x_m);
        }
        if vehicle.autopilot().session.progress.current() == last {
            return None;
        }
    }
    None
}

#[test]
fn commands_wait_for_a_condition_while_the_next_place_is_flown_to() {
    const SPEED: (u16, [f32; 4]) = (178, [0.0, 12.0, 0.0, 0.0]);
    let at_m = |condition: (u16, [f32; 4])| {
        speeds_up_at_m(&mut with_commands(&[condition, (183, [1.0, 1500.0, 0.0, 0.0]), SPEED]), 6)
    };
    let delayed_m = at_m((112, [10.0, 0.0, 0.0, 0.0])).unwrap();
    assert!((delayed_m - 150.0).abs() < 8.0, "{delayed_m}");
    let near_m = at_m((114, [300.0, 0.0, 0.0, 0.0])).unwrap();
    assert!((near_m - 700.0).abs() < 2.0, "{near_m}");
    // What waits still when the place is reached is passed over.
    assert_eq!(at_m((112, [500.0, 0.0, 0.0, 0.0])), None);
}

#[test]
fn an_item_with_nothing_to_fly_behind_it_cannot_be_chosen() {
    // The tag behind the last place, and a jump to one that there is not.
    for commands in [[(600, [7.0, 0.0, 0.0, 0.0])], [(601, [9.0, 0.0, 0.0, 0.0])]] {
        let mut vehicle = with_commands(&[]);
        let mut items = vehicle.autopilot().mission().items().to_vec();
        items.extend(commands.map(|(command, params)| PlanItem { command, params, ..PlanItem::default() }));
        vehicle.autopilot_mut().replace_plan(PlanKind::Mission, items, true).unwrap();
        vehicle.autopilot_mut().set_mode(Mode::Auto);
        assert!(vehicle.autopilot_mut().set_current_item(3, false).is_ok());
        assert_eq!(vehicle.mode(), Mode::Auto);
        assert!(vehicle.autopilot_mut().set_current_item(4, false).is_err());
        assert_eq!(vehicle.mode(), Mode::Rtl);
    }
}

/// As a real one was measured, disarmed on the ground.
#[test]
fn auto_returns_where_its_mission_is_cleared() {
    let mut vehicle = Vehicle::new(settings(true, 10.0)).unwrap();
    let place = item(&vehicle, WAYPOINT, (100.0, 0.0), 50.0, 0.0);
    vehicle.autopilot_mut().replace_plan(PlanKind::Mission, vec![PlanItem::default(), place], true).unwrap();
    vehicle.autopilot_mut().enter(Mode::Auto).unwrap();
    assert_eq!(vehicle.mode(), Mode::Auto);
    vehicle.autopilot_mut().replace_plan(PlanKind::Mission, Vec::new(), true).unwrap();
    assert_eq!((vehicle.mode(), vehicle.is_armed()), (Mode::Rtl, false));
}

#[test]
fn a_jump_that_is_over_counts_anew_and_home_resets_all() {
    let mut progress = super::progress::Progress::default();
    let made: Vec<_> = (0..4).map(|_| progress.jump(3, 1, 2.0)).collect();
    assert_eq!(made, [Some(1), Some(2), None, Some(1)]);
    let mission = super::Mission::new(1);
    progress.choose(2, &mission, false);
    assert_eq!(progress.jumps_made(3), 1);
    progress.choose(0, &mission, false);
    assert_eq!(progress.jumps_made(3), 0);
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
